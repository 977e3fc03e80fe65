"""Reading a result file back (tcontact/vtkhdf.py writes it)."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from . import validate
from .atomic_file import AtomicFile, read_undo
from .errors import InputError

VTK_TYPE = {"tet4": 10, "hex8": 12}
NODES_PER_CELL = {"tet4": 4, "hex8": 8}
_KIND = {number: kind for kind, number in VTK_TYPE.items()}

DAMAGED = (
    KeyError,
    ValueError,
    AttributeError,
    OSError,
    RuntimeError,
    TypeError,
    IndexError,
    ArithmeticError,
    MemoryError,
)


@dataclass(frozen=True)
class Frame:
    """One stored instant: time [s], point fields [n] or [n,k] and cell fields [cells] or [cells,k] by name."""

    time: float
    point_data: dict[str, np.ndarray]
    cell_data: dict[str, np.ndarray]


@dataclass(frozen=True)
class ResultData:
    """A result file, read back: mesh, times and attributes in memory, frames and history on demand.

    points [n,3] reference positions [m]; blocks: (kind, connectivity [m,k]); times [frames] [s].
    """

    path: Path
    points: np.ndarray
    blocks: tuple[tuple[str, np.ndarray], ...]
    times: np.ndarray
    attributes: dict[str, Any]
    point_fields: tuple[str, ...]
    cell_fields: tuple[str, ...]

    @classmethod
    def open(cls, path: Path | str) -> ResultData:
        """Open a file that `ResultFile` wrote; raises `InputError` if it is missing, foreign or cut short."""
        path = validate.path("path", path, "give the name of a result.vtkhdf")
        with _opened(path) as file:
            try:
                root = file["VTKHDF"]
                attributes = json.loads(file["tcontact/attributes"].asstr()[()])
                steps = root["Steps"]
                times = steps["Values"][: int(steps.attrs["NSteps"])]  # the time is the last thing a frame writes
                points, offsets, connectivity = root["Points"][()], root["Offsets"][()], root["Connectivity"][()]
                blocks = tuple(_blocks(root["Types"][()], offsets, connectivity))
                fields = [tuple(n for n in steps[f"{g}Offsets"] if n in root[g]) for g in ("PointData", "CellData")]
            except DAMAGED as error:
                remedy = f"not a result file of tcontact, or damaged ({error}); give a result.vtkhdf that a run wrote"
                raise InputError("path", str(path), remedy) from error
        return cls(path, points, blocks, times, attributes, *fields)

    def __len__(self) -> int:
        return len(self.times)

    def frame(self, index: int) -> Frame:
        """Frame `index` (negative: from the end); raises `InputError` outside the series or for damaged data."""
        if not -len(self) <= index < len(self):
            raise InputError("frame", index, f"the file holds {len(self)} frames, numbered from 0")
        index %= len(self)
        with _opened(self.path) as file:
            try:
                data = [
                    {name: _rows(file["VTKHDF"], group, name, index, rows) for name in names}
                    for group, names, rows in (
                        ("PointData", self.point_fields, len(self.points)),
                        ("CellData", self.cell_fields, self.cells),
                    )
                ]
            except DAMAGED as error:
                raise InputError(
                    "path", str(self.path), f"frame {index} cannot be read ({error}); run again"
                ) from error
        return Frame(float(self.times[index]), *data)

    @property
    def cells(self) -> int:
        """Number of cells."""
        return sum(len(cells) for _, cells in self.blocks)

    @property
    def history(self) -> dict[str, np.ndarray]:
        """Per-step arrays [steps] or [steps,k] by name, read from the file at each call; `InputError` if damaged."""
        with _opened(self.path) as file:
            try:
                return {name: array[()] for name, array in file["tcontact/history"].items()}
            except DAMAGED as error:
                raise InputError("path", str(self.path), f"the history cannot be read ({error}); run again") from error


def _blocks(types: np.ndarray, offsets: np.ndarray, connectivity: np.ndarray) -> list[tuple[str, np.ndarray]]:
    cuts = np.concatenate([[0], np.flatnonzero(np.diff(types)) + 1, [len(types)]])
    blocks = []
    for first, last in pairwise(cuts):
        kind = _KIND[int(types[first])]
        blocks.append((kind, connectivity[offsets[first] : offsets[last]].reshape(-1, NODES_PER_CELL[kind])))
    return blocks


def _rows(root: h5py.Group, group: str, name: str, index: int, rows: int) -> np.ndarray:
    first = int(root[f"Steps/{group}Offsets/{name}"][index])
    array = root[group][name][first : first + rows]
    if len(array) != rows:
        raise ValueError(f"field {name} ends early")
    return array


@contextmanager
def _opened(path: Path) -> Iterator[h5py.File]:
    """The file to read from, as it was before a write that was cut short."""
    validate.file_exists("path", path, "no such file; give a result.vtkhdf that a run wrote")
    disk = AtomicFile(path, "r") if read_undo(path) is not None else None
    try:
        file = h5py.File(path, "r", locking=False) if disk is None else h5py.File(disk, "r")
    except DAMAGED as error:
        if disk is not None:
            disk.close()
        remedy = "not an HDF5 file, empty or cut short; give a result.vtkhdf that a run wrote"
        raise InputError("path", str(path), remedy) from error
    try:
        with file:
            yield file
    finally:
        if disk is not None:
            disk.close()
