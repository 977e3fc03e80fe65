"""The interface of a run for watches and checkpoints."""

from __future__ import annotations

from typing import Any, Protocol

from ..scene.scene import Scene


class Run(Protocol):
    """A run between two steps: its scene, the state of every body and of every domain, the step [s]."""

    scene: Scene
    states: list[Any]
    domains: list[Any]
    dt: float

    def warn(self, text: str, kind: type[Warning] = RuntimeWarning) -> None:
        """Issue a warning now and store it in the result."""
        ...
