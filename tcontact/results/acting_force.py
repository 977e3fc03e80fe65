"""The contact force by which a run is judged and drawn: that of the obstacles, or of pairs of bodies."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

ROUNDING = 1e-9  # force of all obstacles over the largest force of a pair below which there is none


def pair_forces(history: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the force [rows, 3] [N] on the first body of each pair, by the name of the pair."""
    start = "pair_force:"
    return {name[len(start) :]: force for name, force in history.items() if name.startswith(start)}


def acting_force(history: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the contact force [rows, 3] [N]: of the obstacles, or without it that of the pair with the largest one.

    The forces of a pair on its two bodies cancel in the contact force of all bodies.
    """
    total, pairs = history["contact_force"], pair_forces(history)
    if not pairs:
        return total
    largest = max(pairs.values(), key=lambda force: float(np.nanmax(np.abs(force), initial=0.0)))
    size = float(np.nanmax(np.abs(largest), initial=0.0))
    return largest if float(np.nanmax(np.abs(total), initial=0.0)) <= ROUNDING * size else total
