"""Tell of bodies whose contact nodes lose other mass than in the run from whose end theirs starts.

Velocities are carried over onto other masses there, and nodes without mass move to where they are in equilibrium:
momentum, kinetic and elastic energy jump between the last row of that run and the first one of this.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..planning.removal import massless_nodes, removals
from ..results.result import Result
from ..scene.scene import Scene

ALIKE = 1e-6  # difference of the projections onto massless directions up to which they are the same
QUANTITIES = {"kinetic": "kinetic energy, {} J", "elastic": "elastic energy, {} J", "momentum": "momentum, {} kg m/s"}


class Handover(NamedTuple):
    """What changes for the contact nodes, and the last row of the run before: its sizes by `QUANTITIES`."""

    changes: list[str]
    last: dict[str, float]

    def text(self, history: Mapping[str, np.ndarray]) -> str:
        """Return a warning; history: of this run, with its first row at least."""
        first = _sizes(history, 0)
        jumps = [
            words.format(f"{self.last[name]:.4g} -> {first[name]:.4g}")
            for name, words in QUANTITIES.items()
            if name in self.last and name in first
        ]
        return (
            f"{'; '.join(self.changes)}: contact nodes lose other mass than in the run that this one starts from, and"
            f" momentum and energy jump there ({'; '.join(jumps)}); name the same MasslessContact(removal=) in the"
            " scenes of both runs, 'full' where only directions change"
        )


def handover(scene: Scene, initial: Result) -> Handover | None:
    """Return what to tell of a run of a scene that starts from the end of another one; None if no body changes."""
    changes = []
    for index, (before, now) in enumerate(zip(removals(initial.scene), removals(scene), strict=True)):
        if before is None or now is None:
            continue
        if before != now:
            changes.append(f"{scene.label(index)} has removal={now!r} instead of {before!r}")
        elif now == "normal" and _turned(scene, initial.scene, index):
            changes.append(f"{scene.label(index)} has removal='normal' along other directions")
    return Handover(changes, _sizes(initial.history, -1)) if changes else None


def _turned(scene: Scene, before: Scene, index: int) -> bool:
    """Return whether nodes that lose mass in both scenes lose it along other directions."""
    one, other = massless_nodes(scene, index), massless_nodes(before, index)
    _, here, there = np.intersect1d(one.nodes, other.nodes, assume_unique=True, return_indices=True)
    spans = [
        np.einsum("kic,kjc->kij", found.basis[rows], found.basis[rows]) for found, rows in ((one, here), (other, there))
    ]
    return bool((np.abs(spans[0] - spans[1]) > ALIKE).any())


def _sizes(history: Mapping[str, np.ndarray], row: int) -> dict[str, float]:
    """Return the sizes of the quantities in a row of a history."""
    return {name: float(np.linalg.norm(history[name][row])) for name in QUANTITIES if len(history.get(name, ()))}
