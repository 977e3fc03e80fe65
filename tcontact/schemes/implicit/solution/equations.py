"""The equations of a step, R(x1) = inertia + f* - fc* - f_ext = 0, and of a static solve of the contact nodes alone.

    inertia = M (c d - b),  d = x1 - x0:  c = 2/dt^2, b = 2 v0/dt for the trapezoidal rule        (METHOD 4)

Rows of held components keep the displacement of the start value.
"""

from __future__ import annotations

import numpy as np

from .cells import Cells
from .contact import StepContact
from .mass import ConsistentMass, NodalMass
from .rule import ImplicitRule
from .several_cells import SeveralCells
from .sparsity import Sparsity
from .surfaces import Passage

ROUNDED = 1e-3  # share of modulus times area below which forces of a static solve are rounding


class Rows:
    """Rows of held components and of exact contact in a tangent.

    held [n, 3, 3]: projectors on held components; place [k]: rows of the contact nodes; stiff [k] [N/m]: factors from
    their gaps to forces.
    """

    def __init__(
        self, sparsity: Sparsity, held: np.ndarray, contact: StepContact | None, place: np.ndarray, stiff: np.ndarray
    ) -> None:
        self.sparsity, self.contact, self.place = sparsity, contact, place
        self.held = held
        self.bound = np.flatnonzero(np.abs(held).max(axis=(1, 2)) > 0.0)
        self.stiff = stiff
        rows = sparsity.rows
        self._bound_blocks = np.flatnonzero(np.isin(rows, self.bound))
        number = np.full(len(held), -1)
        number[place] = np.arange(len(place))
        self._contact_blocks = np.flatnonzero(number[rows] >= 0)
        self._owner = number[rows[self._contact_blocks]]
        self._rows = rows

    @property
    def exact(self) -> bool:
        """Return whether contact is exact."""
        return self.contact is not None and self.contact.exact is not None

    def residual(self, residual: np.ndarray) -> np.ndarray:
        """Return the residual of the rewritten rows; the active set of exact contact must be up to date."""
        result = residual.copy()
        if self.exact and self.contact is not None and self.contact.exact is not None:
            result[self.place] = self.contact.exact.rows(residual[self.place], self.stiff)
        here = self.bound
        result[here] -= np.einsum("nij,nj->ni", self.held[here], result[here])
        return result

    def tangent(self, blocks: np.ndarray) -> np.ndarray:
        """Rewrite the blocks of these rows in place."""
        diagonal = self.sparsity.diagonal
        size = np.trace(blocks[diagonal], axis1=1, axis2=2) / 3.0
        if self.exact and self.contact is not None and self.contact.exact is not None:
            exact = self.contact.exact
            blocks[diagonal[self.place]] += exact.curvature()
            blocks[self._contact_blocks] = exact.keep()[self._owner] @ blocks[self._contact_blocks]
            blocks[diagonal[self.place]] += exact.replaced(self.stiff)
        here, among = self.bound, self._bound_blocks
        blocks[among] -= self.held[self._rows[among]] @ blocks[among]
        blocks[diagonal[here]] += np.abs(size[here])[:, None, None] * self.held[here]
        return blocks


class StepEquations:
    """Balance of a time step under the external load [n, 3]."""

    def __init__(
        self,
        scheme: ImplicitRule,
        cells: Cells | SeveralCells,
        mass: NodalMass | ConsistentMass,
        contact: StepContact | None,
        rows: Rows,
        load: np.ndarray,
    ) -> None:
        self.scheme, self.cells, self.mass = scheme, cells, mass
        self.contact, self.rows, self.load = contact, rows, load
        self.contact_force = np.zeros((0, 0, 3) if contact is None else contact.shape)
        self.unbalanced = np.zeros_like(load)

    def prepare(
        self, u0: np.ndarray, factor: float, known: np.ndarray, past: np.ndarray, past_contact: np.ndarray
    ) -> None:
        """Set a step from u0 with inertia M (factor d - known); past, past_contact: weighted forces before it."""
        self.u0, self.factor, self.known, self.past, self.past_contact = u0, factor, known, past, past_contact

    def evaluate(self, d: np.ndarray) -> tuple[np.ndarray, float]:
        """Return residual and size of forces, see `Equations`."""
        scheme, cells = self.scheme, self.cells
        cells.evaluate(scheme.stress, self.u0, scheme.level * d, False, scheme.chi)
        force = scheme.present * cells.force(scheme.hourglass_level) + self.past
        inertia = self.mass.times(self.factor * d - self.known)
        residual = inertia + force - self.load
        scale = max(float(np.abs(self.mass.times(self.known)).max()), cells.magnitude(), float(np.abs(self.load).max()))
        contact = self.contact
        if contact is not None and len(contact.nodes):
            if contact.exact is not None:
                passages = self._passages(d)
                contact.exact.balance(residual[contact.nodes], passages, contact.tolerance)
                self.contact_force = contact.exact.force(passages)
                free = residual.copy()
                free[contact.nodes] -= self.contact_force.sum(axis=0)
                self.unbalanced = free
                return self.rows.residual(residual), scale
            self.contact_force = self._penalty(d)[0]
            residual[contact.nodes] -= self.contact_force.sum(axis=0)
            scale = max(scale, float(np.abs(self.contact_force).max()))
        self.unbalanced = residual
        return self.rows.residual(residual), scale

    def tangent(self, d: np.ndarray) -> np.ndarray:
        """Return the tangent, see `Equations`."""
        scheme, cells = self.scheme, self.cells
        cells.evaluate(scheme.stress, self.u0, scheme.level * d, True, scheme.chi)
        blocks = cells.tangent_blocks(scheme.present * scheme.level, scheme.hourglass_level)
        self.mass.add_to(blocks, self.factor, cells.sparsity)
        contact = self.contact
        if contact is not None and contact.penalty is not None and len(contact.nodes):
            blocks[cells.sparsity.diagonal[contact.nodes]] -= self._penalty(d)[1]
        return self.rows.tangent(blocks)

    def _passages(self, d: np.ndarray) -> list[Passage]:
        """Return gaps at the end of the step and normals of the level at which its exact contact force stands."""
        assert self.contact is not None
        level = self.scheme.contact_level
        return self.contact.passages(self.u0, d) if level == 0.5 else self.contact.along(self.u0, d, level)

    def _penalty(self, d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return contact forces [p, k, 3] and their derivative, at the level of the scheme."""
        assert self.contact is not None
        scheme = self.scheme
        if scheme.conserving:
            return self.contact.conserving(self.u0, d)
        force, tangent = self.contact.at(self.u0 + scheme.level * d)
        return scheme.present * force + self.past_contact, scheme.present * scheme.level * tangent


class StaticEquations:
    """Balance of massless nodes with everything else fixed: f_K(x) - f_ext,K = lambda nu (paper eqs 15-17).

    cells: cells with such nodes, whose unknowns are the contact nodes in order; load [k, 3] [N]; modulus [Pa], area
    [m^2] of a node: their product is the scale of rounding errors of forces.
    """

    def __init__(
        self,
        cells: Cells | SeveralCells,
        contact: StepContact,
        rows: Rows,
        load: np.ndarray,
        modulus: float,
        area: float,
    ) -> None:
        self.cells, self.contact, self.rows, self.load = cells, contact, rows, load
        self.modulus, self.area = modulus, area

    def prepare(self, u: np.ndarray) -> None:
        """Set the displacement u [n, 3] to start from."""
        self.u = u
        # strains have a rounding error of 1e-16, times u over the size of a cell where u is larger
        far = float(np.abs(u).max()) / self.area**0.5
        self.minimum_force = ROUNDED * self.modulus * self.area * max(1.0, far)

    def moved(self, d: np.ndarray) -> np.ndarray:
        """Return the displacement [n, 3] with the contact nodes moved by d [k, 3]."""
        result = self.u.copy()
        result[self.contact.nodes] += d
        return result

    def evaluate(self, d: np.ndarray) -> tuple[np.ndarray, float]:
        """Return residual and size of forces, see `Equations`."""
        u = self.moved(d)
        self.cells.evaluate("end", u, np.zeros_like(u))
        residual = self.cells.force(1.0)[self.contact.nodes] - self.load
        scale = max(self.cells.magnitude(), float(np.abs(self.load).max()), self.minimum_force)
        if self.contact.exact is not None:
            self.contact.exact.balance(residual, self.contact.ends(u), self.contact.tolerance)
        else:
            residual -= self.contact.at(u)[0].sum(axis=0)
        return self.rows.residual(residual), scale

    def tangent(self, d: np.ndarray) -> np.ndarray:
        """Return the tangent, see `Equations`."""
        u = self.moved(d)
        self.cells.evaluate("end", u, np.zeros_like(u), True)
        blocks = self.cells.tangent_blocks(1.0, 1.0)
        if self.contact.exact is None:
            blocks[self.cells.sparsity.diagonal] -= self.contact.at(u)[1]
        return self.rows.tangent(blocks)
