"""Results in the terms of other packages: the history as a table of pandas, a frame as a grid of PyVista."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import validate
from ..base.errors import InputError
from ..mesh.elements import ELEMENTS

if TYPE_CHECKING:
    from pandas import DataFrame
    from pyvista import UnstructuredGrid


AXES = {3: "xyz", 6: ("xx", "yy", "zz", "xy", "yz", "xz")}  # ends of the names of the columns of a vector, a stress


def frame_of(history: Mapping[str, np.ndarray]) -> DataFrame:
    """Return the history as a table with the time [s] as index. Raises `InputError` without pandas."""
    columns = flat_columns(history)
    table: DataFrame = needed("pandas", "to_pandas").DataFrame(columns)
    return table.set_index("time") if "time" in columns else table


def flat_columns(history: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return columns [rows] by name: vectors take several, name_x, name_y and name_z, or name_0 and so on."""
    columns: dict[str, np.ndarray] = {}
    for name, array in history.items():
        array = np.asarray(array)
        if array.ndim == 1:
            columns[name] = array
        else:
            parts = array.reshape(len(array), -1)
            ends = AXES.get(parts.shape[1], range(parts.shape[1]))
            columns |= {f"{name}_{end}": part for end, part in zip(ends, parts.T, strict=True)}
    return columns


def grid_of(data: Any, time: float | None, fields: Sequence[str] | None) -> UnstructuredGrid:
    """Return the frame of a series nearest to a time [s], None = the last, as a grid with displaced points.

    fields: names of those that the grid gets, None = all. Raises `InputError` without PyVista, for unknown fields, a
    series without frames and a time outside of them.
    """
    pyvista = needed("pyvista", "to_pyvista")
    frame = data.frame(nearest(data, time))
    known = frame.point_data | frame.cell_data
    chosen = tuple(known) if fields is None else validate.words("fields", fields, tuple(known))
    moved = frame.point_data.get("displacement")
    points = np.array(data.points, dtype=np.float64) if moved is None else data.points + moved
    numbers = [np.full(len(corners), ELEMENTS[kind].vtk, np.uint8) for kind, corners in data.blocks]
    rows = [np.insert(corners, 0, corners.shape[1], axis=1).ravel() for _, corners in data.blocks]
    grid: UnstructuredGrid = pyvista.UnstructuredGrid(np.concatenate(rows), np.concatenate(numbers), points)
    for part, target in ((frame.point_data, grid.point_data), (frame.cell_data, grid.cell_data)):
        for name in part.keys() & set(chosen):
            target[name] = part[name]
    grid.field_data["time"] = [frame.time]
    return grid


def nearest(data: Any, time: float | None) -> int:
    """Return the number of the frame of a series nearest to a time [s], None = the last.

    Raises `InputError` where there is none, and for a time that lies outside of the frames by more than half of the
    longest time between them (of a single frame: of its time).
    """
    if len(data) == 0:
        raise InputError("data", str(data.path), "the file holds no frames; run again with frames > 0")
    times = np.asarray(data.times)
    if time is None:
        return len(times) - 1
    wanted = validate.number("time", time)
    apart = np.diff(times).max() if len(times) > 1 else abs(times[0])
    if max(times[0] - wanted, wanted - times[-1]) > 0.5 * apart:
        several = f"the frames are from {times[0]:.6g} to {times[-1]:.6g} s"
        have = several if len(times) > 1 else f"there is one frame alone, at {times[0]:.6g} s"
        raise InputError("time", time, f"{have}; give a time [s] among them, or none for the last")
    return int(np.argmin(np.abs(times - wanted)))


def needed(package: str, what: str) -> Any:
    """Return an optional package. Raises `InputError` with the command that installs it."""
    try:
        return import_module(package)
    except ImportError as error:
        raise InputError(what, package, f"needs the package {package}: pip install {package}") from error
