"""Accuracy of the timed step: its errors against NumPy on a randomly deformed mesh."""

from __future__ import annotations

import numpy as np

from ...cells.internal_force import InternalForce
from ...device import arrays
from ...planning.domain import Domain
from ...planning.planning import plan
from . import blocks, reference

LARGEST = 32  # cells along an edge; the check uses the same kernels on at most this many


def step_errors(kind: str, law: str, size: int, mixed: bool = False) -> dict[str, float | int]:
    """Return the errors of one pass of force and update at random displacements, largest difference over largest value.

    force_error: nodal forces; elastic_error: the elastic energy; update_error: the change of u; check_cells: cells.
    mixed: in mixed precision.
    """
    scene, displacement = blocks.shaken(kind, law, min(size, LARGEST))
    body = plan(scene).bodies[0]
    domain = Domain((body,))
    domain.mixed = mixed
    term = InternalForce(domain)
    start = displacement[body.node_order]
    u, v = arrays.put(start), arrays.zeros(start.size)
    kick, drift = 1e-6, 2e-6
    term.advance(u, v, kick, kick, drift)
    velocity = np.array(arrays.get(v)).reshape(-1, 3)
    forces = -velocity * body.lumped[:, None] / (2 * kick)
    exact, energy = reference.force(kind, law, body.body.material.parameters, body.reference, body.cells, start)
    moved = -drift * 2 * kick * exact / body.lumped[:, None]
    return {
        "force_error": float(np.abs(forces - exact).max() / np.abs(exact).max()),
        "elastic_error": abs(term.sum_of("elastic") - energy) / energy,
        "update_error": float(
            np.abs(np.array(arrays.get(u)).reshape(-1, 3) - (start + moved)).max() / np.abs(start).max()
        ),
        "check_cells": len(body.cells),
    }


def difference(one: np.ndarray, other: np.ndarray) -> float:
    """Return the largest difference over the largest value."""
    return float(np.abs(one - other).max() / np.abs(other).max())
