"""The pictures of a series one after another: each is drawn once, and stored while the next one is drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from ...base import stages
from .camera import Eye
from .png import write_png
from .studio import Studio

AHEAD = 2  # pictures that may wait for the disk


class Shots:
    """The pictures of all frames of a studio, written to one file each. Use as a context manager.

    A second thread compresses and writes them; what it cannot write raises its `OSError` at one of the next pictures,
    or at the end.
    """

    def __init__(
        self, studio: Studio, field: str, limits: tuple[float, float], eye: Eye, paths: Sequence[Path]
    ) -> None:
        self._studio, self._wishes, self._paths = studio, (field, limits, eye), paths
        self._early: dict[int, np.ndarray] = {}
        self._pool = ThreadPoolExecutor(1)
        self._waiting: list[Future[None]] = []

    def __enter__(self) -> Shots:
        return self

    def __exit__(self, kind: Any, *_: object) -> None:
        self._pool.shutdown()
        if kind is None:
            self._settle(0)

    def sample(self, count: int) -> list[np.ndarray]:
        """Draw pictures [height, width, 3] spread over the series, and keep them for `all`."""
        chosen = sorted({round(k) for k in np.linspace(0, len(self._paths) - 1, count)})
        self._early = {index: self._drawn(index) for index in chosen}
        return list(self._early.values())

    def all(self, shoot: Callable[[np.ndarray], None] | None = None) -> Iterator[np.ndarray]:
        """Yield the picture [height, width, 3] of every frame, in order, as it goes to its file.

        shoot: called with each as well.
        """
        for index, path in enumerate(self._paths):
            stages.say(f"drawing picture {index + 1} of {len(self._paths)}")
            early = self._early.pop(index, None)
            picture = self._drawn(index) if early is None else early
            self._waiting.append(self._pool.submit(write_png, path, picture))
            self._settle(AHEAD)
            if shoot is not None:
                shoot(picture)
            yield picture

    def _drawn(self, index: int) -> np.ndarray:
        return self._studio.pixels(self._studio.frame(index), *self._wishes)

    def _settle(self, left: int) -> None:
        """Wait until at most so many pictures are left to write. Raises `OSError`."""
        while len(self._waiting) > left:
            self._waiting.pop(0).result()
