"""The stiffness of pressures that follow their faces: how much they can add to the largest omega^2 of a body.

With F_a = -p int N_a n dA on the corners of a face (kernels/nodes/loads.py) and z x = [z]_x, the stiffness -dF/dx of a
face has the symmetric part

    L_ab = p [z_ab]_x,    z_ab = 1/2 (w_ab - w_ba),    w_ab = int N_a (dN_b/deta dx/dxi - dN_b/dxi dx/deta) dxi deta

so |L_ab| <= p |z_ab|, and lambda(K + L) <= lambda(K) + lambda(M^-1 L) <= lambda(K) + max_a (B y)_a/y_a with
B_ab = sum over the faces of p |z_ab|/sqrt(m_a m_b) and any y > 0 (Collatz and Wielandt); y is made better by products
with B. What remains is a bound from the safe side: of a cube under p = .1 E it takes 4 % of the step. Here p is the
largest |p| of each face in the whole run, so that no step is too long, whatever a function of time does next.
"""

from __future__ import annotations

import numpy as np

from ..base.errors import FunctionError
from ..scene.loads import Load
from .body_plan import BodyPlan

SAMPLES = 257  # times at which a function of time is asked for its pressure
PRODUCTS = 12  # with B, which come within 1 % of its largest eigenvalue
PAIRS = [(a, b) for a in range(4) for b in range(a)]


def _shares() -> np.ndarray:
    """Return c [6, 4] with z_ab = sum over e of c_e x_e for the pairs of corners of a face; 2 x 2 points are exact."""
    xi, eta = np.array([-1.0, 1.0, 1.0, -1.0]), np.array([-1.0, -1.0, 1.0, 1.0])
    w = np.zeros((4, 4, 4))
    for s, t in np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) / np.sqrt(3.0):
        value = 0.25 * (1.0 + xi * s) * (1.0 + eta * t)
        over_xi, over_eta = 0.25 * xi * (1.0 + eta * t), 0.25 * eta * (1.0 + xi * s)
        w += np.einsum("a,b,e->abe", value, over_eta, over_xi) - np.einsum("a,b,e->abe", value, over_xi, over_eta)
    return np.array([0.5 * (w[a, b] - w[b, a]) for a, b in PAIRS])


SHARES = _shares()


def largest_pressures(load: Load, plan: BodyPlan, duration: float) -> np.ndarray:
    """Return the largest |p| [Pa] of a load in a run, one or one for each face, up to where its function fails."""
    function, found = load.function(plan.body.mesh), np.zeros(1)
    try:
        for time in np.linspace(0.0, duration, SAMPLES) if load.varies else np.zeros(1):
            found = np.maximum(found, np.abs(function.at(np.array([time]))[0]))
    except FunctionError:  # the run stops there
        pass
    return found


class PressureRate:
    """The bound of omega^2 that the pressures on a body add at its present positions.

    rows: numbers of its loaded nodes [k], ascending, in the numbering of its plan.
    """

    def __init__(self, plan: BodyPlan, duration: float) -> None:
        faces, largest = [], []
        for load in plan.body.loads:
            if load.kind == "pressure":
                faces.append(plan.place[load.faces(plan.body.mesh)])
                largest.append(np.broadcast_to(largest_pressures(load, plan, duration), len(faces[-1])))
        self.rows, corners = np.unique(np.concatenate(faces), return_inverse=True)
        corners = corners.reshape(-1, 4)
        self._reference = plan.reference[self.rows]
        pairs = corners[:, PAIRS]  # [f, 6, 2]
        apart = pairs[..., 0] != pairs[..., 1]  # the last corner of a triangle stands twice
        self._corners, self._pressure = corners, np.concatenate(largest)[:, None] * apart
        self._ends = pairs.reshape(-1, 2).T
        self._size = 1.0 / np.sqrt(plan.lumped[self.rows])

    @staticmethod
    def of(plan: BodyPlan, duration: float) -> PressureRate | None:
        """Return that of a body; None without pressures."""
        pressed = any(load.kind == "pressure" for load in plan.body.loads)
        return PressureRate(plan, duration) if pressed else None

    def bound(self, moved: np.ndarray) -> float:
        """Return the bound [1/s^2] at displacements [k, 3] [m] of its nodes."""
        x = (self._reference + moved)[self._corners]
        lengths = np.linalg.norm(np.einsum("pe,fec->fpc", SHARES, x), axis=2)
        first, second = self._ends
        entry = (self._pressure * lengths).reshape(-1) * self._size[first] * self._size[second]
        if not np.isfinite(entry).all() or not entry.any():
            return 0.0
        y, found = np.ones(len(self.rows)), np.inf
        for _ in range(PRODUCTS):
            product = np.bincount(first, entry * y[second], len(y)) + np.bincount(second, entry * y[first], len(y))
            found = min(found, float((product / y).max()))
            y = np.maximum(product / product.max(), 1e-6)
        return found
