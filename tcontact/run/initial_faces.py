"""Choose the contact faces, pairs and removal of a run that starts from the end of another one (later_start.py)."""

from __future__ import annotations

import numpy as np

from ..planning.removal import removals
from ..results.result import Result
from ..scene.later_start import holds, started_from
from ..scene.scene import Scene
from .checkpoint.keeper import Start

REMOVALS = (None, "normal", "full")  # what a body may have, by its number in a checkpoint


def scene_of_start(scene: Scene, start: Start, initial: Result, implicit: bool) -> tuple[Scene, list[str]]:
    """Return the scene with the contact faces that may meet from the end of another run, and warnings.

    The faces of the other run stay, where the body had contact="auto" there too. It warns of bodies with more of them:
    a run of both durations would have had these from its beginning. The scene knows the removal of the other run, which
    `choose_removal` keeps.
    """
    bodies = zip(scene.bodies, initial.scene.bodies, strict=True)
    known = [before.contact_faces if body.finds_contact and before.finds_contact else None for body, before in bodies]
    result = started_from(scene, start[0], start[1], known, removals(initial.scene)).for_scheme(implicit)
    found = []
    for index, (body, before) in enumerate(zip(result.bodies, known, strict=True)):
        more = 0 if before is None else int((~holds(before, body.contact_faces)).sum())
        if more:
            found.append(
                f"contact='auto' of body {result.label(index)} has {more} faces more than in the run that it starts"
                f" from ({len(body.contact_faces)} of {len(body.outer_faces)}), as they may meet something in this"
                " duration: it goes on a little differently than one run of both durations, which contact='all' or"
                " names of sets keep alike"
            )
    return result, found


def with_kept_faces(scene: Scene, start: Start | None, implicit: bool) -> Scene:
    """Return the scene of a run as it was when its checkpoints were written; start: out of them, None: its own."""
    if start is None or len(start) < 3:
        return scene
    displacement, velocity, faces, *others = start
    removal = [REMOVALS[int(number[0])] for number in others[0]] if others else None
    return started_from(scene, displacement, velocity, faces, removal).for_scheme(implicit)


def kept_start(scene: Scene, displacement: list[np.ndarray], velocity: list[np.ndarray]) -> Start:
    """Return what checkpoints keep of the start of a run from another one's end.

    That is all contact faces too, and the removal of the other run.
    """
    assert scene.end_before is not None
    removal = [np.array([REMOVALS.index(name)]) for name in scene.end_before.removal]
    return displacement, velocity, [body.contact_faces for body in scene.bodies], removal
