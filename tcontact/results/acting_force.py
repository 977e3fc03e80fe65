"""The contact force by which a run is judged and drawn: that of the obstacle or pair that has the largest.

The forces of several partners cancel in the contact force of all bodies: those of two planes that squeeze a block, and
those of a pair on its two bodies.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

ROUNDING = 1e-9  # force of all obstacles over the largest force of a pair below which there is none
OBSTACLE, PAIR = "obstacle_force:", "pair_force:"


class ActingForce(NamedTuple):
    """The contact force of one partner: on the bodies by an obstacle, or on the first body of a pair.

    force: [rows, 3] [N]; column: its column of the history ("contact_force" of a run with one obstacle);
    largest: its largest length [N], of all steps where that is known; several: the run has other partners too.
    """

    force: np.ndarray
    column: str
    largest: float
    several: bool

    @property
    def size(self) -> np.ndarray:
        """The length of the force [rows] [N]."""
        return np.asarray(np.linalg.norm(self.force, axis=1))

    @property
    def partner(self) -> str:
        """The partner in words behind a force, such as " on floor" or " of pair lower-upper"; "" of the only one."""
        return f" {partner_in_words(self.column)}" if self.several else ""

    @property
    def of_pair(self) -> bool:
        """Whether the partner is a pair of bodies."""
        return self.column.startswith(PAIR)


def partner_in_words(column: str) -> str:
    """Return the partner whose force a column of the history holds, in words."""
    if column.startswith(PAIR):
        return f"of pair {column[len(PAIR) :]}"
    return f"on {column[len(OBSTACLE) :]}" if column.startswith(OBSTACLE) else "on the obstacle"


def pair_forces(history: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the force [rows, 3] [N] on the first body of each pair, by its column."""
    return {name: force for name, force in history.items() if name.startswith(PAIR)}


def partner_forces(history: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the contact force [rows, 3] [N] of each partner by its column: on the bodies, or the first body of a pair.

    A run with one obstacle has the contact force of all bodies, unless that is the rounding left by its pairs.
    """
    pairs, total = pair_forces(history), history["contact_force"]
    obstacles = {name: -force for name, force in history.items() if name.startswith(OBSTACLE)}
    if not obstacles or (len(obstacles) == 1 and not pairs):
        noise = ROUNDING * max(map(_largest, pairs.values()), default=0.0)
        obstacles = {} if pairs and _largest(total) <= noise else {"contact_force": total}
    return obstacles | pairs


def acting_force(history: Mapping[str, np.ndarray], peaks: Mapping[str, float] | None = None) -> ActingForce:
    """Return the force of the partner that has the largest one; peaks: `Result.peaks`, of steps without a row too."""
    forces, known = partner_forces(history), peaks or {}
    sizes = {name: float(np.fmax(_largest(force), known.get(name, 0.0))) for name, force in forces.items()}
    column = max(sizes, key=lambda name: sizes[name])
    return ActingForce(forces[column], column, sizes[column], len(forces) > 1)


def largest_energy_error(history: Mapping[str, np.ndarray], peaks: Mapping[str, float]) -> float:
    """Return the largest energy error of all steps, or of the rows of the history where only these are known."""
    found = peaks.get("energy_error")
    return float(np.abs(history["energy_error"]).max()) if found is None else found


def _largest(force: np.ndarray) -> float:
    """Return the largest length [N] of a force [rows, 3], leaving out rows that are not numbers."""
    with np.errstate(invalid="ignore", over="ignore"):  # a run that blew up
        return float(np.nanmax(np.linalg.norm(force, axis=1), initial=0.0))
