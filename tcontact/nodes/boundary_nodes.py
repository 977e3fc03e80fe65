"""Nodes with tensor mass, supports or contact: their masses and loads, and what is prescribed."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..device import arrays
from ..kernels.lanes import DRIVEN_AXIS
from ..planning.domain import Domain

SYMMETRIC = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def flat_tensors(tensors: np.ndarray) -> np.ndarray:
    """Return symmetric tensors [s, 3, 3] as (xx, yy, zz, xy, yz, xz) [s, 6]."""
    return np.stack([tensors[:, i, j] for i, j in SYMMETRIC], axis=1)


def tensors_of(flat: np.ndarray) -> np.ndarray:
    """Return symmetric tensors [s, 3, 3] out of their numbers (xx, yy, zz, xy, yz, xz) in any shape."""
    numbers = flat.reshape(-1, 6)
    found = np.empty((len(numbers), 3, 3))
    for place, (i, j) in enumerate(SYMMETRIC):
        found[:, i, j] = found[:, j, i] = numbers[:, place]
    return found


class BoundaryNodes:
    """The list of boundary nodes; `force` is their internal force of the last pass, less the contact force.

    springs: numbers of springs, which stand behind the mass tensors (springs.py), None without any.
    """

    name = "boundary-nodes"

    def __init__(
        self,
        domain: Domain,
        force: arrays.Array,
        loads: np.ndarray | None = None,
        springs: np.ndarray | None = None,
    ) -> None:
        """Make the arrays; loads: data of loads behind those of gravity (kernels/load_places.py); springs: theirs."""
        self.force = force
        self.nodes = arrays.put(domain.boundary.astype(np.int32))
        mass, load = flat_tensors(domain.tensors), domain.loads
        if len(domain.tied):
            mass, load = mass.copy(), load.copy()
            mass[domain.tied], load[domain.tied] = 0.0, 0.0
        self.mass = arrays.put(mass if springs is None else np.concatenate([mass.ravel(), springs]))
        self.inverse_mass = arrays.put(flat_tensors(domain.inverses))
        behind = np.zeros(0) if loads is None else loads
        self.load = arrays.put(np.concatenate([load.reshape(-1), behind]))

    def arguments(self) -> dict[str, arrays.Array]:
        """Return the arrays by the names of kernels/language/bundles.Boundary."""
        return {"nodes": self.nodes, "mass": self.mass, "inverse_mass": self.inverse_mass, "load": self.load}

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of this term."""
        return [self.nodes, self.mass, self.inverse_mass, self.load, self.force]


class Supports:
    """Held and driven components; their reaction is M a + f - f_ext - contact force (METHOD 1).

    start [n, 3] [m]: displacement of the nodes at the start; rows: steps in a launch, for the table of driven supports
    (kernels/nodes/driven_supports.py).
    """

    name = "supports"

    def __init__(self, domain: Domain, start: np.ndarray, rows: int = 1) -> None:
        components, values = 3 * domain.support_rows + domain.support_axes, domain.speeds
        self.driven, self.rows = bool(domain.driven), rows
        if self.driven:
            axes = [support.kind == "velocity" for support in domain.driven for _ in support.axes]
            place = start[domain.boundary[domain.support_rows], domain.support_axes]
            added = np.where(np.array([*axes, False])[domain.driven_axes], place, 0.0)
            components = np.concatenate([components, domain.driven_axes, [len(axes)]])
            values = np.concatenate([values, added, np.zeros(DRIVEN_AXIS * len(axes) * rows)])
        self.components = arrays.put(components.astype(np.int32))
        self.speeds = arrays.put(values)

    def arguments(self) -> dict[str, Any]:
        """Return the arrays by the names of kernels/language/bundles.Supports."""
        found: dict[str, Any] = {"components": self.components, "speeds": self.speeds}
        return {**found, "driven": True} if self.driven else found

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of this term."""
        return [self.components, self.speeds]
