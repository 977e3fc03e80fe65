"""Reader of result files, which tcontact/results/files/vtkhdf.py writes."""

from __future__ import annotations

import json
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ...base import validate
from ...base.errors import InputError
from ...device.atomic_file import AtomicFile, read_undo
from ...mesh.elements import ELEMENTS

FORMAT = 2  # format of the group /tcontact; 1 had no checksums
CHECK = "crc32"  # attribute of an array that is stored as a whole
_KIND = {element.vtk: element for element in ELEMENTS.values()}

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

    points [n,3] reference positions [m]; blocks: (kind, connectivity [m,k]); times [frames] [s]; format: of the file, 1
    = without checksums. What is damaged is refused by name: the mesh, a frame, the history.
    """

    path: Path
    points: np.ndarray
    blocks: tuple[tuple[str, np.ndarray], ...]
    times: np.ndarray
    attributes: dict[str, Any]
    point_fields: tuple[str, ...]
    cell_fields: tuple[str, ...]
    format: int = FORMAT

    @classmethod
    def open(cls, path: Path | str) -> ResultData:
        """Open a file that `ResultFile` wrote; raises `InputError` if it is missing, foreign or cut short."""
        path = validate.path("path", path, "give the name of a result.vtkhdf")
        with _opened(path) as file:
            try:
                root = file["VTKHDF"]
                own = file["tcontact"]
                format = int(own.attrs.get("format", 1))
                text = own["attributes"]
                attributes = json.loads(text.asstr()[()] if format == 1 else stored(text).tobytes())
                steps = root["Steps"]
                times = _times(steps, len(own["frames"]) if format > 1 else None, "reason" in attributes)
                points, offsets, connectivity, types = (
                    stored(root[name], format) for name in ("Points", "Offsets", "Connectivity", "Types")
                )
                blocks = tuple(_blocks(types, offsets, connectivity))
                fields = [tuple(n for n in steps[f"{g}Offsets"] if n in root[g]) for g in ("PointData", "CellData")]
            except DAMAGED as error:
                remedy = f"not a result file of tcontact, or damaged ({error}); give a result.vtkhdf that a run wrote"
                raise InputError("path", str(path), remedy) from error
        return cls(path, points, blocks, times, attributes, fields[0], fields[1], format)

    def __len__(self) -> int:
        return len(self.times)

    def frame(self, index: int) -> Frame:
        """Return frame `index` (negative: from the end); raises `InputError` outside the series or for damaged data."""
        if not -len(self) <= index < len(self):
            raise InputError("frame", index, f"the file holds {len(self)} frames, numbered from 0")
        index %= len(self)
        with _opened(self.path) as file:
            try:
                return self._frame(file, index)
            except DAMAGED as error:
                raise InputError("path", str(self.path), self._damaged(file, index, error)) from error

    def _frame(self, file: h5py.File, index: int) -> Frame:
        """Return a frame as it stands in the file. Raises one of `DAMAGED`."""
        parts = [
            {name: self._field(file["VTKHDF"], group, name, index, rows) for name in names}
            for group, names, rows in (
                ("PointData", self.point_fields, len(self.points)),
                ("CellData", self.cell_fields, self.cells),
            )
        ]
        if self.format > 1:
            self._check(file, index, parts)
        return Frame(float(self.times[index]), *parts)

    def _field(self, root: h5py.Group, group: str, name: str, index: int, rows: int) -> np.ndarray:
        dataset = root[group][name]
        if dataset.maxshape[0] is not None:
            return stored(dataset, self.format)  # all frames have the same
        return _rows(root, dataset, group, name, index, rows)

    def _check(self, file: h5py.File, index: int, parts: list[dict[str, np.ndarray]]) -> None:
        """Raise `ValueError` if the fields of a frame are not those that were written."""
        moving = {
            f"{group}/{name}": array
            for group, part in zip(("PointData", "CellData"), parts, strict=True)
            for name, array in part.items()
            if file["VTKHDF"][group][name].maxshape[0] is None
        }
        if checksum(f"{index} {float(self.times[index])!r}", moving) != int(file["tcontact/frames"][index]):
            raise ValueError("it is not what was written: its checksum is another one")

    def _damaged(self, file: h5py.File, index: int, error: Exception) -> str:
        """Return what is said of a frame that cannot be read: also which of the others can."""
        spans: list[list[int]] = []
        for other in range(len(self)):
            try:
                self._frame(file, other)
            except DAMAGED:
                continue
            if spans and spans[-1][1] == other - 1:
                spans[-1][1] = other
            else:
                spans.append([other, other])
        whole = ", ".join(str(low) if low == high else f"{low} to {high}" for low, high in spans)
        kept = (
            f"frames {whole} are whole: `ResultData.frame` reads them, or run again" if whole else "no frame is whole"
        )
        return f"frame {index} (t = {self.times[index]:.6g} s) is damaged ({error}); {kept}"

    @property
    def cells(self) -> int:
        """Number of cells."""
        return sum(len(cells) for _, cells in self.blocks)

    @property
    def history(self) -> dict[str, np.ndarray]:
        """Per-step arrays [steps] or [steps,k] by name, read from the file at each call; `InputError` if damaged."""
        with _opened(self.path) as file:
            try:
                return {name: stored(array, self.format) for name, array in file["tcontact/history"].items()}
            except DAMAGED as error:
                remedy = f"the history is damaged ({error}); the frames may be whole: read them, or run again"
                raise InputError("path", str(self.path), remedy) from error


def checksum(label: str, arrays: Mapping[str, np.ndarray]) -> int:
    """Return the CRC-32 of a label and of arrays with their names, kinds and shapes, in alphabetical order."""
    check = zlib.crc32(label.encode())
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        check = zlib.crc32(f"{name} {array.dtype.str} {array.shape}".encode(), check)
        check = zlib.crc32(array.reshape(-1).view(np.uint8).data, check)
    return check


def stored(dataset: h5py.Dataset, format: int = FORMAT) -> np.ndarray:
    """Return an array that was stored as a whole. Raises `ValueError` if it is not what was written."""
    array = dataset[()]
    if format > 1 and checksum(dataset.name, {"": array}) != int(dataset.attrs[CHECK]):
        raise ValueError(f"{dataset.name} is not what was written: its checksum is another one")
    return np.asarray(array)


def _times(steps: h5py.Group, frames: int | None, ended: bool) -> np.ndarray:
    """Return the times [s] of the whole frames: the time is the last thing that a frame writes.

    frames: how many have a checksum, None in files without; ended: no run goes on with the file.
    """
    values, count = steps["Values"], int(steps.attrs["NSteps"])
    if frames is not None:
        in_order = len(values) == count == frames if ended else len(values) <= count <= frames <= len(values) + 1
        if not in_order:
            raise ValueError(f"{len(values)} times, {count} steps and {frames} checksums do not go together")
    return np.asarray(values[:count])


def _blocks(types: np.ndarray, offsets: np.ndarray, connectivity: np.ndarray) -> list[tuple[str, np.ndarray]]:
    cuts = np.concatenate([[0], np.flatnonzero(np.diff(types)) + 1, [len(types)]])
    blocks = []
    for first, last in pairwise(cuts):
        element = _KIND[int(types[first])]
        blocks.append((element.kind, connectivity[offsets[first] : offsets[last]].reshape(-1, element.corners)))
    return blocks


def _rows(root: h5py.Group, dataset: h5py.Dataset, group: str, name: str, index: int, rows: int) -> np.ndarray:
    first = int(root[f"Steps/{group}Offsets/{name}"][index])
    array = dataset[first : first + rows]
    if len(array) != rows:
        raise ValueError(f"field {name} ends early")
    return array


@contextmanager
def _opened(path: Path) -> Iterator[h5py.File]:
    """Return the file to read from, as it was before a write that was cut short."""
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
