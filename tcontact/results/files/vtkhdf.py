"""The result file: a VTKHDF 2 unstructured grid with time steps, appended frame by frame.

The mesh is stored once (all its offsets are 0); every field grows by one block of rows a frame. ParaView (5.12 or
newer) opens the file directly. What VTK does not know about lives in the top-level group `/tcontact`: `attributes`
(JSON as bytes), `history` and `frames`, a checksum of every frame.

Damage is found thrice: all metadata are of HDF5 1.8, with checksums of their own; all numbers pass through the filter
Fletcher-32, which every HDF5 program checks; and what `ResultData` gives back has the CRC-32 of what was put in, since
HDF5 1.8 does not guard the index that leads to the numbers.
Format: https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/vtkhdf_specifications.html
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from ...base.errors import InputError
from ...device.atomic_file import AtomicFile
from ...mesh.elements import ELEMENTS
from ...mesh.geometry import joined
from .vtkhdf_reader import CHECK, DAMAGED, FORMAT, Frame, ResultData, checksum

__all__ = ["Frame", "ResultData", "ResultFile"]

VERSION = (2, 0)  # the first VTKHDF version with time steps: every later reader accepts it
_STEP_ROWS = 512  # rows in a chunk of the per-step arrays
_STEPS_AHEAD = 63  # frames whose places are written before they are there: one write for all
_STORED_ROWS = 2**16  # rows at most in a chunk of what is stored as a whole
_LIBRARY = ("v108", "v108")  # metadata with checksums, yet without the "still open" mark that blocks readers
_STATIC_OFFSETS = {"PartOffsets": (), "PointOffsets": (), "CellOffsets": (1,), "ConnectivityIdOffsets": (1,)}

if TYPE_CHECKING:
    from typing_extensions import Self

Blocks = Sequence[tuple[str, np.ndarray]]


class ResultFile:
    """Writer of a result file. Each commit leaves a complete file on disk, so a killed run keeps its frames.

    Use as a context manager or call `close`. What cannot be written raises `OSError`; the file on disk then stays as
    it was before the call, and nothing more is written.
    """

    _library = _LIBRARY

    def __init__(self, disk: AtomicFile, file: h5py.File, points: int, cells: int, static: Sequence[str]) -> None:
        """Take an open file; use `create` or `reopen` instead."""
        self._disk, self._file = disk, file
        self._rows = {"PointData": points, "CellData": cells}
        self._static = {("CellData", name) for name in static}
        self._fields: dict[tuple[str, str], _Column] = {}
        steps = file["VTKHDF/Steps"]
        self._values = _Column(steps, "Values", np.float64, (), _STEP_ROWS)
        self._parts = _Column(steps, "NumberOfParts", np.int64, (), _STEP_ROWS)
        self._offsets = {
            key: _Column(steps, key, np.int64, shape, _STEP_ROWS) for key, shape in _STATIC_OFFSETS.items()
        }
        self._field_offsets = {
            key: _Column(steps[f"{key[0]}Offsets"], key[1], np.int64, (), _STEP_ROWS) for key in self._static
        }
        self._checks = _Column(file["tcontact"], "frames", np.uint32, (), _STEP_ROWS)
        self._frames = 0
        self.kept = 0  # frames that are on disk
        self._ahead = 0  # frames whose places are known, as the same number follows for each
        self._new: list[tuple[float, int]] = []  # time [s] and checksum of frames that nothing counts yet

    @classmethod
    def create(
        cls,
        path: Path | str,
        points: np.ndarray,
        blocks: Blocks,
        attributes: Mapping[str, Any] | None = None,
        static_cell_data: Mapping[str, np.ndarray] | None = None,
    ) -> Self:
        """Start a new file at `path` (an older one is replaced) and write the mesh.

        points: reference positions [n,3] [m]; blocks: (kind, connectivity [m,k]) with a kind of `ELEMENTS`, cells in
        VTK node order; attributes: anything JSON can say; static_cell_data: fields that never change, e.g. {"body":
        [cells]}.
        Raises `InputError` for wrong shapes, unknown kinds and node numbers outside the mesh, before the file is
        touched.
        """
        points = np.ascontiguousarray(points, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 3 or len(points) == 0:
            raise InputError("points", points.shape, "give an array [n,3] with at least one point")
        checked = [_checked_block(index, kind, cells, len(points)) for index, (kind, cells) in enumerate(blocks)]
        count = sum(len(cells) for _, cells in checked)
        if count == 0:
            raise InputError("blocks", count, "give at least one cell")
        static = {
            name: _checked_field("static_cell_data", name, array, count)
            for name, array in (static_cell_data or {}).items()
        }
        sizes = np.concatenate([np.full(len(cells), cells.shape[1], dtype=np.int64) for _, cells in checked])
        types = [np.full(len(cells), ELEMENTS[kind].vtk, dtype=np.uint8) for kind, cells in checked]
        mesh = {
            "NumberOfPoints": np.array([len(points)], dtype=np.int64),
            "NumberOfCells": np.array([count], dtype=np.int64),
            "NumberOfConnectivityIds": np.array([sizes.sum()], dtype=np.int64),
            "Points": points,
            "Connectivity": joined([cells.ravel() for _, cells in checked]),
            "Offsets": np.concatenate([[0], np.cumsum(sizes)]),
            "Types": np.concatenate(types),
        }

        def fill(root: h5py.Group) -> None:
            for name, array in mesh.items():
                store(root, name, array)
            for name, array in static.items():
                store(root["CellData"], name, array)

        return cls._started(path, len(points), count, list(static), attributes or {}, fill)

    @classmethod
    def _started(
        cls,
        path: Path | str,
        points: int,
        cells: int,
        static: Sequence[str],
        attributes: Mapping[str, Any],
        fill: Callable[[h5py.Group], None],
    ) -> Self:
        """Start a new file with so many points and cells; fill: puts the mesh into its group VTKHDF."""
        disk = AtomicFile(path, "w")
        try:
            file = h5py.File(disk, "w", libver=cls._library)
            root = file.create_group("VTKHDF")
            root.attrs["Version"] = np.array(VERSION, dtype=np.int64)
            root.attrs.create("Type", np.bytes_("UnstructuredGrid"), dtype=h5py.string_dtype("ascii", 16))
            steps = root.create_group("Steps")
            steps.attrs["NSteps"] = np.int64(0)
            for group in ("PointData", "CellData"):
                root.create_group(group)
                steps.create_group(f"{group}Offsets")
            fill(root)
            own = file.create_group("tcontact")
            own.attrs["format"] = np.int64(FORMAT)
            own.create_group("history")
            result = cls(disk, file, points, cells, static)
            result._write_first(attributes)
        except BaseException:
            disk.close()
            raise
        return result

    @classmethod
    def reopen(cls, path: Path | str, frames: int, attributes: Mapping[str, Any] | None = None) -> Self:
        """Continue a file behind its first `frames` frames; the others, and its history, are dropped.

        Raises `InputError` if it is missing, foreign, of an older version, damaged in one of these frames, or holds
        fewer of them; nothing is changed then.
        """
        path = Path(path)
        data = ResultData.open(path)
        if data.format != FORMAT:
            raise InputError("path", str(path), "an older version of the program wrote it; run again")
        if len(data) < frames:
            raise InputError("path", str(path), f"holds {len(data)} of the {frames} frames to go on from; run again")
        for index in range(frames):
            data.frame(index)
        disk = AtomicFile(path, "r+")
        try:
            return cls._cut(disk, data, frames, attributes or {})
        except DAMAGED as error:
            disk.close()
            if disk.failed is not None or isinstance(error, InputError):
                raise
            raise InputError("path", str(path), f"is damaged ({error}); run again") from error

    @classmethod
    def _cut(cls, disk: AtomicFile, data: ResultData, frames: int, attributes: Mapping[str, Any]) -> Self:
        """Return the writer of a file that keeps its first frames."""
        file = h5py.File(disk, "r+", libver=_LIBRARY)
        root = file["VTKHDF"]
        moving = {("PointData", name) for name in data.point_fields}
        moving |= {("CellData", name) for name in data.cell_fields if root["CellData"][name].maxshape[0] is None}
        static = [name for name in data.cell_fields if ("CellData", name) not in moving]
        result = cls(disk, file, len(data.points), data.cells, static)
        for group, name in sorted(moving):
            grown = root[group][name]
            chunk = result._rows[group]
            result._fields[group, name] = _Column(root[group], name, grown.dtype, grown.shape[1:], chunk)
            offsets = root["Steps"][f"{group}Offsets"]
            result._field_offsets[group, name] = _Column(offsets, name, np.int64, (), _STEP_ROWS)
        own = (result._values, result._parts, result._checks)
        for column in (*own, *result._offsets.values(), *result._field_offsets.values()):
            column.cut(frames)
        for (group, _), column in result._fields.items():
            column.cut(frames * result._rows[group])
        root["Steps"].attrs.modify("NSteps", np.int64(frames))
        result._frames = result.kept = result._ahead = frames
        for name in list(file["tcontact/history"]):
            del file["tcontact/history"][name]
        result._write_first(attributes)
        return result

    def append(
        self,
        time: float,
        point_data: Mapping[str, np.ndarray] | None = None,
        cell_data: Mapping[str, np.ndarray] | None = None,
        commit: bool = True,
    ) -> None:
        """Add a frame at `time` [s]; point_data: fields [n] or [n,k]; cell_data: fields [cells] or [cells,k].

        The first frame fixes names and shapes. Raises `InputError` if a later frame differs or a field has the wrong
        length; nothing is written then. Non-finite values are kept: they show where a run broke. commit: False
        leaves it to `commit`, which then brings several frames to disk.
        """
        fields = {("PointData", name): array for name, array in (point_data or {}).items()}
        fields |= {("CellData", name): array for name, array in (cell_data or {}).items()}
        arrays = {
            key: _checked_field(f"{key[0]} field", key[1], array, self._rows[key[0]]) for key, array in fields.items()
        }
        self._check_same(arrays)
        for key, array in arrays.items():
            group, name = key
            if key not in self._fields:
                root = self._file["VTKHDF"]
                self._fields[key] = _Column(root[group], name, array.dtype, array.shape[1:], self._rows[group])
                self._field_offsets[key] = column(root["Steps"][f"{group}Offsets"], name)
            self._fields[key].append(array)
        named = {f"{group}/{name}": array for (group, name), array in arrays.items()}
        self._take(time, named)
        if commit:
            self.commit()

    def _take(self, time: float, arrays: Mapping[str, np.ndarray]) -> None:
        """Count a frame at `time` [s] whose arrays are there."""
        self._new.append((float(time), checksum(f"{self._frames} {float(time)!r}", arrays)))
        self._frames += 1

    def _number(self, count: int) -> None:
        """Write where the fields of the first `count` frames start, also of those that are not there yet."""
        numbers = np.arange(self._ahead, count)
        for key, column in self._field_offsets.items():
            column.append(numbers * (0 if key in self._static else self._rows[key[0]]))
        for name, column in self._offsets.items():
            column.append(np.zeros((len(numbers), *_STATIC_OFFSETS[name])))
        self._parts.append(np.ones(len(numbers)))
        self._ahead = count

    def _cut_ahead(self) -> None:
        """Leave of what `_number` wrote what belongs to frames."""
        if self._ahead > self._frames:
            for column in (self._parts, *self._offsets.values(), *self._field_offsets.values()):
                column.cut(self._frames)
            self._ahead = self._frames

    def _count_new(self) -> None:
        """Let the file count the frames since the last commit: their numbers follow them, the times come last."""
        if not self._new:
            return
        if self._frames > self._ahead:
            self._number(self._frames + _STEPS_AHEAD)
        times, checks = zip(*self._new, strict=True)
        self._checks.append(np.array(checks))
        self._stage()  # the frames are on disk before anything counts them
        self._file["VTKHDF/Steps"].attrs.modify("NSteps", np.int64(self._frames))
        self._stage()  # VTK's reader crashes on more times than steps, so that no kill may leave them
        self._values.append(np.array(times))
        self._new = []

    def write_history(self, history: Mapping[str, np.ndarray]) -> None:
        """Store per-step arrays [steps] or [steps,k] in `/tcontact/history`, in place of what was there."""
        group = self._file["tcontact/history"]
        for name in set(group) - set(history):
            del group[name]
        for name, array in history.items():
            array = np.asarray(array)
            if array.ndim == 0:
                raise InputError(f"history['{name}']", array, "give an array with one row per step")
            store(group, name, array)
        self.commit()

    def write_attributes(self, attributes: Mapping[str, Any]) -> None:
        """Store `attributes` as JSON in `/tcontact/attributes` (numpy values allowed); replaces the earlier ones."""
        text = json.dumps(dict(attributes), default=_plain).encode()
        store(self._file["tcontact"], "attributes", np.frombuffer(text, dtype=np.uint8))
        self.commit()

    def _write_first(self, attributes: Mapping[str, Any]) -> None:
        """Store the attributes of a new file; where that fails close it: HDF5 crashes on an open file at exit."""
        try:
            self.write_attributes(attributes)
        except OSError:
            self.close()
            raise

    def sync(self) -> None:
        """Wait until the device holds all that was written so far."""
        if self._new:
            self.commit()
        self._disk.sync()

    def close(self) -> None:
        """Close the file; calling it again is harmless."""
        if not self._file:
            return
        failed = self._disk.failed is not None
        try:
            with suppress(Exception) if failed else nullcontext():  # nothing that it does reaches the disk any more
                self._count_new()
                self._cut_ahead()
                self._file.close()
            if not failed:
                self._disk.commit()
        finally:
            self._disk.close()

    def _stage(self) -> None:
        """Let what was written so far reach the disk before the rest."""
        self._file.flush()
        self._disk.stage()

    def commit(self) -> None:
        """Bring everything to disk, or nothing. Raises `OSError`."""
        self._count_new()
        self._file.flush()
        self._disk.commit()
        self.kept = self._frames

    def __len__(self) -> int:
        return self._frames

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _check_same(self, arrays: Mapping[tuple[str, str], np.ndarray]) -> None:
        for key in arrays.keys() & self._static:
            raise InputError("cell field", key[1], "this name already belongs to a static cell field")
        if not self._frames:
            return
        if arrays.keys() != self._fields.keys():
            known = ", ".join(sorted(name for _, name in self._fields))
            raise InputError(
                "fields", sorted(name for _, name in arrays), f"every frame needs the fields of the first: {known}"
            )
        for key, array in arrays.items():
            if array.shape[1:] != self._fields[key].shape:
                raise InputError(
                    f"field '{key[1]}'", array.shape, f"the first frame had components {self._fields[key].shape}"
                )


def store(group: h5py.Group, name: str, array: np.ndarray) -> None:
    """Store an array as a whole with its checksum, in the place of an older one of that name."""
    if name in group and (group[name].shape[1:] != array.shape[1:] or group[name].dtype != array.dtype):
        del group[name]
    if name in group:
        group[name].resize(len(array), axis=0)
    else:
        rest, growing = array.shape[1:], group.name.startswith("/tcontact")
        chunk = 4096 if growing else max(1, min(len(array), _STORED_ROWS))
        limit = (None, *rest) if growing else None
        group.create_dataset(name, array.shape, array.dtype, maxshape=limit, chunks=(chunk, *rest), fletcher32=True)
    group[name][...] = array
    group[name].attrs[CHECK] = np.uint32(checksum(group[name].name, {"": array}))


def column(group: h5py.Group, name: str) -> _Column:
    """Return an array of whole numbers, one a frame, that grows."""
    return _Column(group, name, np.int64, (), _STEP_ROWS)


class _Column:
    """Dataset that grows along its first axis, through the low-level calls: cheaper than `resize` and slicing."""

    def __init__(self, group: h5py.Group, name: str, dtype: Any, shape: tuple[int, ...], chunk: int) -> None:
        self.shape = shape
        if name in group:
            dataset = group[name]
        else:
            options = {"maxshape": (None, *shape), "chunks": (chunk, *shape), "fletcher32": True}
            dataset = group.create_dataset(name, (0, *shape), dtype, **options)
        self._id = dataset.id
        self.dtype = dataset.dtype
        self._rows = len(dataset)

    def cut(self, rows: int) -> None:
        """Keep the first rows only."""
        self._id.set_extent((rows, *self.shape))
        self._rows = rows

    def append(self, value: Any) -> None:
        rows = np.ascontiguousarray(value, dtype=self.dtype).reshape(-1, *self.shape)
        end = self._rows + len(rows)
        self._id.set_extent((end, *self.shape))
        space = self._id.get_space()
        space.select_hyperslab((self._rows, *(0 for _ in self.shape)), rows.shape)
        self._id.write(h5py.h5s.create_simple(rows.shape), space, rows)
        self._rows = end


def _checked_block(index: int, kind: str, cells: np.ndarray, points: int) -> tuple[str, np.ndarray]:
    if kind not in ELEMENTS:
        raise InputError(f"blocks[{index}] kind", kind, f"use one of {', '.join(ELEMENTS)}")
    cells = np.ascontiguousarray(cells, dtype=np.int64)
    if cells.ndim != 2 or cells.shape[1] != ELEMENTS[kind].corners:
        raise InputError(f"blocks[{index}]", cells.shape, f"{kind} needs connectivity [m,{ELEMENTS[kind].corners}]")
    if cells.size and (cells.min() < 0 or cells.max() >= points):
        raise InputError(
            f"blocks[{index}]", (int(cells.min()), int(cells.max())), f"node numbers must lie in 0..{points - 1}"
        )
    return kind, cells


def _checked_field(what: str, name: str, array: np.ndarray, rows: int) -> np.ndarray:
    array = np.ascontiguousarray(array)
    if not name or "/" in name or name == ".":
        raise InputError(what, name, "give the field a name without '/'")
    if array.ndim not in (1, 2) or len(array) != rows or array.dtype.kind not in "iufb":
        shown = (array.shape, array.dtype.name)
        raise InputError(f"{what} '{name}'", shown, f"give numbers of shape [{rows}] or [{rows},k]")
    if array.dtype.kind == "f":
        return array.astype(np.float64, copy=False)
    return array.astype(np.int64, copy=False)  # VTK has no booleans and no half-wide integers worth keeping


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    return str(value)
