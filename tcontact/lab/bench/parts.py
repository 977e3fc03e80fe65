"""Time of the parts of a step: the methods that a step calls, timed one by one, without the parts they call in turn.

The looks at the stable step are one part with all force passes they make.
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np

from ...planning.planning import plan
from ...run.loop import Run
from ...run.precision import set_precision
from ...run.progress import ProgressBar
from ...scene.scene import Scene
from ...schemes.explicit.central_difference import CentralDifference
from .driver_calls import calls_of_a_block

# part -> path of the method from the body's state or from the run; what does not exist in a scene has no part
OF_A_BODY = {
    "force and update": "internal_force.advance",
    "contact cells": "internal_force.measure_surface",  # where they are few the static solve has them
    "boundary nodes and static solve": "serial.run",
    "history row": "rows",
    "search of pairs": "contact.pairs.search",
    "coupling of pairs": "contact.pairs.rebuild",
}
WHOLE_STEP = "whole step, small body"  # one launch with force, contact and row, which cannot be timed apart
PAIR_PARTS = ("search of pairs", "coupling of pairs")
WHOLE = "stable step"
OF_THE_RUN = {"history": "history.add", "guards": "guards.check", WHOLE: "_watch"}


class Parts:
    """Stopwatch of the parts: seconds by part since the last reset."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._inner = [0.0]
        self._inside = False  # inside the part that stays whole

    def time(self, owner: Any, path: str, part: str) -> None:
        """Time the method at the dotted path below owner; nothing happens where the scene has no such thing."""
        *names, method = path.split(".")
        for name in names:
            owner = getattr(owner, name, None)
        found = getattr(owner, method, None)
        if callable(found):
            setattr(owner, method, self._timed(found, part))

    def _timed(self, method: Callable[..., Any], part: str) -> Callable[..., Any]:
        def call(*arguments: Any, **options: Any) -> Any:
            if self._inside:
                return method(*arguments, **options)
            self._inside = part == WHOLE
            self._inner.append(0.0)
            begin = perf_counter()
            try:
                return method(*arguments, **options)
            finally:
                taken = perf_counter() - begin
                self._inside = False
                own = taken - self._inner.pop()
                self._inner[-1] += taken
                self.seconds[part] = self.seconds.get(part, 0.0) + own

        return call

    def reset(self) -> None:
        """Forget what was timed: the first step compiles."""
        self.seconds.clear()


class FirstStep(ProgressBar):
    """Calls back after the first step of a run."""

    def __init__(self, after: Callable[[], None]) -> None:
        super().__init__(1.0, enabled=False)
        self._after: Callable[[], None] | None = after

    def update(self, time: float, note: str = "") -> None:
        """Call back after the first step, once."""
        if self._after is not None:
            self._after()
            self._after = None


def parts_of_a_step(scene: Scene, precision: str = "f64", calls: dict[str, float] | None = None) -> dict[str, float]:
    """Return seconds a step by part, timers included, over a run of the scene; "loop" is what no other part has.

    calls: takes the calls of a GPU's driver in a step after the run, where they are logged.
    """
    planned = plan(scene)
    set_precision(planned, precision)
    run = Run(
        scene,
        planned,
        CentralDifference(),
        [np.zeros((body.mesh.node_count, 3)) for body in scene.bodies],
        [np.array(body.initial_velocity) for body in scene.bodies],
        1,
    )
    parts = Parts()
    state = run.domains[0]
    at_once = state.domain.small and state.serial is not None
    for part, path in OF_A_BODY.items():
        parts.time(state, path, WHOLE_STEP if at_once and path == "serial.run" else part)
    for part, path in OF_THE_RUN.items():
        parts.time(run, path, part)
    result = run.go(0, None, FirstStep(parts.reset), perf_counter())
    if calls is not None:
        calls |= calls_of_a_block(state, run.dt) or {}
    found = {part: seconds / result.steps for part, seconds in parts.seconds.items()}
    return found | {"loop": result.wall_s / result.steps - sum(found.values())}
