"""Nodes with tensor mass, supports or contact: their masses and loads, and what is prescribed."""

from __future__ import annotations

import numpy as np

from ..device import arrays
from ..planning.domain import Domain

SYMMETRIC = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def flat_tensors(tensors: np.ndarray) -> np.ndarray:
    """Symmetric tensors [s, 3, 3] as (xx, yy, zz, xy, yz, xz) [s, 6]."""
    return np.stack([tensors[:, i, j] for i, j in SYMMETRIC], axis=1)


class BoundaryNodes:
    """The list of boundary nodes; `force` is their internal force of the last pass, less the contact force."""

    name = "boundary-nodes"

    def __init__(self, domain: Domain, force: arrays.Array) -> None:
        self.force = force
        self.nodes = arrays.put(domain.boundary.astype(np.int32))
        mass, load = flat_tensors(domain.tensors), domain.loads
        if len(domain.tied):
            mass, load = mass.copy(), load.copy()
            mass[domain.tied], load[domain.tied] = 0.0, 0.0
        self.mass = arrays.put(mass)
        self.inverse_mass = arrays.put(flat_tensors(domain.inverses))
        self.load = arrays.put(load)

    def arguments(self) -> dict[str, arrays.Array]:
        """Arrays by the names of kernels/language/bundles.Boundary."""
        return {"nodes": self.nodes, "mass": self.mass, "inverse_mass": self.inverse_mass, "load": self.load}

    def owned(self) -> list[arrays.Array]:
        """Arrays of this term."""
        return [self.nodes, self.mass, self.inverse_mass, self.load, self.force]


class Supports:
    """Held and driven components; their reaction is M a + f - f_ext - contact force (METHOD 1)."""

    name = "supports"

    def __init__(self, domain: Domain) -> None:
        self.components = arrays.put((3 * domain.support_rows + domain.support_axes).astype(np.int32))
        self.speeds = arrays.put(domain.speeds)

    def arguments(self) -> dict[str, arrays.Array]:
        """Arrays by the names of kernels/language/bundles.Supports."""
        return {"components": self.components, "speeds": self.speeds}

    def owned(self) -> list[arrays.Array]:
        """Arrays of this term."""
        return [self.components, self.speeds]
