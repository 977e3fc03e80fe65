"""The pictures of a series one after another: each is drawn once, and stored while the next one is drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...device.atomic_file import unlinked
from .camera import Eye
from .png import write_png
from .studio import Studio

if TYPE_CHECKING:
    from PIL import Image

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
        self._early: dict[int, Image.Image] = {}
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
        return [np.asarray(picture) for picture in self._early.values()]

    def all(self, shoot: Callable[[Image.Image], None] | None = None) -> Iterator[Image.Image]:
        """Yield the picture of every frame, in order, as it goes to its file; shoot: called with each as well."""
        for index, path in enumerate(self._paths):
            picture = self._early.pop(index, None) or self._drawn(index)
            self._waiting.append(self._pool.submit(write_png, unlinked(path), np.asarray(picture)))
            self._settle(AHEAD)
            if shoot is not None:
                shoot(picture)
            yield picture

    def _drawn(self, index: int) -> Image.Image:
        return self._studio.picture(self._studio.frame(index), *self._wishes)

    def _settle(self, left: int) -> None:
        """Wait until at most so many pictures are left to write. Raises `OSError`."""
        while len(self._waiting) > left:
            self._waiting.pop(0).result()
