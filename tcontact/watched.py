"""The part of a run that watches and checkpoints see."""

from __future__ import annotations

from typing import Any, Protocol

from .scene import Scene


class Run(Protocol):
    """A run between two steps: its scene, the state of every body, the step [s]."""

    scene: Scene
    states: list[Any]
    dt: float

    def warn(self, text: str, kind: type[Warning] = RuntimeWarning) -> None:
        """Warn now and in the result."""
        ...
