"""The internal force of a body by what a user could take instead: FElupe, a product with SciPy's CSR matrix.

Each function prepares a method and returns the call that computes the force at the given displacements [3n], every time
anew, as an array [3n] [N] or as what the package makes of it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...cells.internal_force import InternalForce
from ...device import arrays
from ...planning.body_plan import BodyPlan
from ...planning.domain import Domain
from . import reference
from .plain_step import PlainStep

AT_ONCE = 2**14  # cells whose stiffness is computed at a time
Force = Callable[[], Any]


def ours(body: BodyPlan, u: np.ndarray, threads: int) -> Force:
    """Prepare the force pass of the explicit step, with the energy of its ledger and the product with 1/mass."""
    term = InternalForce(Domain((body,)))
    at, rate, weight = arrays.put(u), arrays.zeros(u.size), np.repeat(body.lumped, 3)

    def force() -> np.ndarray:
        arrays.set_values(rate, np.zeros(u.size))
        term.minus_force(at, rate)
        return -np.array(arrays.get(rate)) * weight

    return force


def plain(body: BodyPlan, u: np.ndarray, threads: int) -> Force:
    """Prepare the obvious Taichi kernel: a loop over the cells, which adds to the nodes by atomic operations."""
    step = PlainStep(body, u, np.zeros(u.size), 0.0)

    def force() -> np.ndarray:
        arrays.set_values(step.force, np.zeros(u.size))
        step.add_force()
        return np.array(arrays.get(step.force))

    return force


def felupe(body: BodyPlan, u: np.ndarray, threads: int) -> Force:
    """Prepare FElupe's `SolidBody.assemble.vector` with the neo-Hookean law of this package, written with one inverse.

    Its composition of the same law out of two of its own computes the inverse twice and takes a third longer.
    """
    import felupe as fem

    lame, mu = body.body.material.lame_lambda, body.body.material.lame_mu

    def stress(x: Any, **options: Any) -> list[Any]:
        f = x[0]
        j = fem.math.det(f)
        return [mu * f + (lame * (j - 1) * j - mu) * fem.math.transpose(fem.math.inv(f, j)), x[-1]]

    name, region = {
        "hex8": ("hexahedron", fem.RegionHexahedron),
        "tet4": ("tetra", fem.RegionTetra),
    }[body.body.mesh.kind]
    mesh = fem.Mesh(np.array(body.reference), np.array(body.cells), name)
    field = fem.FieldContainer([fem.Field(region(mesh), dim=3)])
    field[0].values[:] = u.reshape(-1, 3)
    solid = fem.SolidBody(fem.Material(stress, lambda x, **options: [None]), field)
    return lambda: solid.assemble.vector(field, parallel=threads > 1)


def scipy(body: BodyPlan, u: np.ndarray, threads: int) -> Force:
    """Prepare the product of SciPy with the assembled matrix: small strains only, one thread whatever their number."""
    matrix = stiffness(body)
    return lambda: matrix @ u


def stiffness(body: BodyPlan) -> Any:
    """Return K [3n, 3n] [N/m] of the linear law in CSR; internal numbering."""
    from scipy import sparse

    material, size = body.body.material, 3 * len(body.reference)
    total = sparse.csr_matrix((size, size))
    for start in range(0, len(body.cells), AT_ONCE):
        cells = body.cells[start : start + AT_ONCE]
        values = reference.stiffness(
            body.body.mesh.kind, (material.lame_lambda, material.lame_mu), body.reference, cells
        )
        places = (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), -1).astype(np.int32)
        rows = np.repeat(places, places.shape[1], axis=1).ravel()
        columns = np.tile(places, (1, places.shape[1])).ravel()
        total = total + sparse.coo_matrix((values.ravel(), (rows, columns)), shape=(size, size)).tocsr()
    return total
