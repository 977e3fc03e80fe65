"""What the results of a run and of its files have in common: views of the history, curves, pictures, tables."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from . import tables

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from pandas import DataFrame
    from pyvista import UnstructuredGrid


class Outcome:
    """A run that has ended, from memory or from its files.

    history: dict of arrays, one row per step (row 0 = start), columns as in docs/COLUMNS.md.
    """

    views: ClassVar[Any]  # curves, pictures and the end as a frame; they stand above results, so the package sets it
    history: dict[str, np.ndarray]

    @property
    def frames(self) -> Any:
        """The stored frames, read when asked for: times [s], frame(index), points, point_fields, cell_fields
        (`ResultData`).

        A run without a file has one frame, its end.
        """
        raise NotImplementedError

    @property
    def probes(self) -> dict[str, np.ndarray]:
        """What the probes recorded [rows] or [rows, numbers], by "<body>_<set>_<quantity>"."""
        return self._columns("probe_")

    @property
    def obstacle_force(self) -> dict[str, np.ndarray]:
        """Force [rows, 3] [N] on every obstacle by name, where there are several or one moves."""
        return self._columns("obstacle_force:")

    @property
    def obstacle_moment(self) -> dict[str, np.ndarray]:
        """Moment [rows, 3] [N m] on every obstacle about its reference point, by name."""
        return self._columns("obstacle_moment:")

    @property
    def pair_force(self) -> dict[str, np.ndarray]:
        """Force on the first body of each pair [rows, 3] [N], by the name of the pair."""
        return self._columns("pair_force:")

    @property
    def pair_moment(self) -> dict[str, np.ndarray]:
        """Moment of that force about the origin [rows, 3] [N m], by the name of the pair."""
        return self._columns("pair_moment:")

    def _columns(self, start: str) -> dict[str, np.ndarray]:
        return {name[len(start) :]: column for name, column in self.history.items() if name.startswith(start)}

    def plot(self, quantity: str = "contact_force", axes: Axes | None = None) -> Axes:
        """Plot a quantity of the history over time with matplotlib; return the axes, to change, show or save them.

        quantity: "contact_force" (a curve for each of several obstacles and pairs), "energy" (all energies and their
        sum), "gap" or any column of the history, a vector as three curves; axes: those to draw on, None = new ones.
        Raises `InputError` for an unknown quantity and for axes that are none of matplotlib.
        """
        drawn: Axes = self.views.plot(self, quantity, axes)
        return drawn

    def render(
        self,
        path: Path | str | None = None,
        time: float | None = None,
        field: str | None = None,
        size: tuple[int, int] = (960, 720),
        **options: Any,
    ) -> np.ndarray:
        """Draw the frame nearest to a time [s] (None: the end) without a display; return it [height, width, 3], 0..255.

        path: file to write the picture to as well, None = none; field: None = the von Mises stress, another one where
        the frames do not have it; size and the other options (camera, deformation_scale, range, view, title, colours,
        clip): as in `tcontact.render.render_picture`.
        Raises `InputError` for an unknown field, a time outside of the frames and what cannot be drawn or written.
        """
        return np.asarray(self.views.render(self, path, time, field, size, options))

    def to_pandas(self) -> DataFrame:
        """Return the history as a table of pandas: a row per step with its time [s] as index, vectors as _x, _y, _z.

        Raises `InputError` where pandas is not installed.
        """
        return tables.frame_of(self.history)

    def to_pyvista(self, time: float | None = None, fields: Sequence[str] | None = None) -> UnstructuredGrid:
        """Return the frame nearest to a time [s] (None: the end) as a grid of PyVista with the points where they were.

        fields: names of those that the grid gets as point or cell data, None = all. The grid has the time as field
        data "time".
        Raises `InputError` where PyVista is not installed, for unknown fields and a time outside of the frames.
        """
        return tables.grid_of(self.frames, time, fields)
