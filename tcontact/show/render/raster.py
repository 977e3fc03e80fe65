"""The raster, which draws triangles into buffers of samples and makes a picture of them."""

from __future__ import annotations

import numpy as np

from ...device.launch import Prepared
from .triangles import FAR, Place, Triangles, drawable

GRID = 256  # places of a corner along a sample, as the kernel demands
SIZES = {"rows": 2, "x": 3, "y": 3, "depth": 3, "value": 3, "light": 1, "table": 1, "edges": 1, "ink": 1}
COUNTS = ("rows", "table", "edges")  # int32, the others float64


class Raster:
    """The raster with the arrays of its input, which are kept from one picture to the next.

    Buffers that it is given stay alive as long as it does: hand in the same ones again and again.
    """

    def __init__(self) -> None:
        self._room = -1  # triangles for which there are arrays
        self._input: dict[str, np.ndarray] = {}
        self._colours = np.empty(0, np.float32)
        self._kernels: dict[int, Prepared] = {}  # by samples per pixel, 0 for the one that draws

    def draw(
        self,
        scene: Triangles,
        width: int,
        place: Place,
        factor: int,
        line: float,
        colours: np.ndarray,
        behind: np.ndarray,
        depth: np.ndarray,
        pixel: np.ndarray,
    ) -> None:
        """Draw triangles into a place of the buffers, which then hold nothing else.

        width: of the buffers, place in them [sample]; factor: samples per pixel along one axis, line: half width of a
        line [pixel]; behind: inverse depth of what hides triangles.
        """
        count = self._fill(scene, factor)
        if len(self._colours) != len(colours):
            self._colours = np.empty_like(colours)
        self._colours[:] = colours
        self._kernels[0](
            count,
            int(width),
            *(int(end) for part in place for end in (part.start, part.stop)),
            float(line * factor),
            *self._input.values(),
            self._colours,
            behind,
            depth,
            pixel,
        )

    def resolve(
        self,
        width: int,
        factor: int,
        ground: int,
        place: Place,
        front: np.ndarray,
        behind: np.ndarray,
        background: np.ndarray,
        dark: float,
        shadow: np.ndarray,
        image: np.ndarray,
    ) -> None:
        """Fill a place of a picture [pixel] from samples and those behind them, where there are any or a shadow falls.

        The arguments are those of the kernel.
        """
        from ...kernels.pictures.raster import make_resolve

        (top, bottom), (left, right) = ((int(part.start), int(part.stop)) for part in place)
        if bottom <= top or right <= left:
            return
        if factor not in self._kernels:
            self._kernels[factor] = Prepared(make_resolve(factor))
        ends = top, left, bottom - top, right - left
        self._kernels[factor](int(width), int(ground), *ends, front, behind, background, float(dark), shadow, image)

    def _fill(self, scene: Triangles, factor: int) -> int:
        """Put those triangles that can be drawn into the arrays; return how many they are."""
        screen, good = scene.screen, slice(None)
        if not np.abs(screen).max(initial=0.0) * factor < FAR:  # not so for nan
            good = drawable(screen * (factor, factor, 1.0))  # type: ignore[assignment]
            screen = screen[good]
        count = len(screen)
        if count > self._room:
            self._make_room(count + count // 8)
        part = {name: self._input[name][: size * count] for name, size in SIZES.items()}
        for axis, name in enumerate(("x", "y", "depth")):
            part[name].reshape(count, 3)[:] = screen[:, :, axis]
        for name in ("x", "y"):
            part[name] *= factor * GRID
            np.rint(part[name], out=part[name])
            part[name] /= GRID
        first, second, third = part["y"].reshape(count, 3).T
        rows = part["rows"].reshape(count, 2)
        rows[:, 0] = np.ceil(np.minimum(np.minimum(first, second), third) - 0.5)
        rows[:, 1] = np.floor(np.maximum(np.maximum(first, second), third) - 0.5) + 1.0
        part["value"].reshape(count, 3)[:] = scene.value[good]
        for name in ("light", "table", "edges", "ink"):
            part[name][:] = getattr(scene, name)[good]
        return count

    def _make_room(self, count: int) -> None:
        """Make arrays for so many triangles, and the kernel that has seen none before them."""
        from ...kernels.pictures.raster import draw_triangles

        self._room = count
        self._input = {
            name: np.empty(size * count, np.int32 if name in COUNTS else np.float64) for name, size in SIZES.items()
        }
        self._kernels[0] = Prepared(draw_triangles)
