"""Reader of result files, which tcontact/results/files/vtkhdf.py writes, and of those that show the parts of ranks."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ...base import validate
from ...base.errors import InputError
from ...device.atomic_file import AtomicFile, read_undo
from ...mesh.elements import ELEMENTS
from .part_places import FOLDER, PartPlace, assembled, joined_mesh, part_path
from .still_written import settled

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
    = without checksums; parts: those of the ranks of a run on several, in their order; place: of a part in the whole.
    What is damaged is refused by name: the mesh, a frame, the history, a part that is missing.
    """

    path: Path
    points: np.ndarray
    blocks: tuple[tuple[str, np.ndarray], ...]
    times: np.ndarray
    attributes: dict[str, Any]
    point_fields: tuple[str, ...]
    cell_fields: tuple[str, ...]
    format: int = FORMAT
    parts: tuple[ResultData, ...] = ()
    place: PartPlace | None = None

    @classmethod
    def open(cls, path: Path | str) -> ResultData:
        """Open a file that `ResultFile` writes or wrote; raises `InputError` if it is missing, foreign or cut short."""
        place = validate.path("path", path, "give the name of a result.vtkhdf")
        return settled(place, lambda: cls._read(place), (InputError,))

    @classmethod
    def _read(cls, path: Path) -> ResultData:
        with _opened(path) as file:
            try:
                root = file["VTKHDF"]
                own = file["tcontact"]
                format = int(own.attrs.get("format", 1))
                text = own["attributes"]
                attributes = json.loads(text.asstr()[()] if format == 1 else stored(text).tobytes())
                steps = root["Steps"]
                times = _times(steps, len(own["frames"]) if format > 1 else None, "reason" in attributes)
                fields = [tuple(n for n in steps[f"{g}Offsets"] if n in root[g]) for g in ("PointData", "CellData")]
                count = int(own.attrs.get("parts", 0))
                points, blocks = (np.zeros((0, 3)), ()) if count else _mesh(root, format)
                place = _place(own["part"]) if "part" in own else None
            except DAMAGED as error:
                remedy = f"not a result file of tcontact, or damaged ({error}); give a result.vtkhdf that a run wrote"
                raise InputError("path", str(path), remedy) from error
        found = cls(path, points, blocks, times, attributes, fields[0], fields[1], format, (), place)
        return found._with_parts(count) if count else found

    def _with_parts(self, count: int) -> ResultData:
        """Return the same with the parts of so many ranks, and the mesh that they have together."""
        parts = []
        for rank in range(count):
            path = part_path(self.path, rank)
            if not path.is_file():
                found = f"{path} is missing; {self.path.name} shows what is in the {count} files of {FOLDER} beside it"
                raise InputError("path", str(self.path), f"{found}: move or copy both together, or run again")
            parts.append(ResultData.open(path))
        try:
            points, blocks = joined_mesh([(one._placed, one.points, one.blocks) for one in parts])
        except DAMAGED as error:
            remedy = f"{FOLDER} beside it holds parts of another run, or damaged ones ({error}); run again"
            raise InputError("path", str(self.path), remedy) from error
        return replace(self, points=points, blocks=blocks, parts=tuple(parts))

    @property
    def _placed(self) -> PartPlace:
        """The place of a part in the whole. Raises `ValueError` where the file is no part."""
        if self.place is None:
            raise ValueError(f"{self.path.name} is no part")
        return self.place

    def __len__(self) -> int:
        return len(self.times)

    def frame(self, index: int) -> Frame:
        """Return frame `index` (negative: from the end); raises `InputError` outside the series or for damaged data."""
        if not isinstance(index, (int, np.integer)) or not -len(self) <= index < len(self):
            raise InputError("frame", index, f"the file holds {len(self)} frames, numbered from 0")
        try:
            return settled(self.path, lambda: self._frame(index % len(self)), DAMAGED)
        except InputError:
            raise
        except DAMAGED:
            with self.opened() as read:  # says which frames are whole
                return read(index % len(self))

    def _frame(self, index: int) -> Frame:
        with ExitStack() as files:
            return self._reader(files).read(index)

    def _reader(self, files: ExitStack) -> FrameReader | JoinedReader:
        """Open the file, and those of its parts, to read frames."""
        file = files.enter_context(_opened(self.path))
        parts = [FrameReader(part, files.enter_context(_opened(part.path))) for part in self.parts]
        return JoinedReader(self, file, parts) if parts else FrameReader(self, file)

    @contextmanager
    def opened(self) -> Iterator[Callable[[int], Frame]]:
        """Yield what reads a frame by its number from 0, as `frame` does: the file is opened once for many."""
        with ExitStack() as files:
            try:
                reader = self._reader(files)
            except InputError:
                raise
            except DAMAGED as error:
                raise InputError("path", str(self.path), f"no frame is whole ({error}); run again") from error

            def read(index: int) -> Frame:
                try:
                    return reader.read(index)
                except DAMAGED as error:
                    raise InputError("path", str(self.path), self._damaged(reader, index, error)) from error

            yield read

    def _damaged(self, reader: FrameReader | JoinedReader, index: int, error: Exception) -> str:
        """Return what is said of a frame that cannot be read: also which of the others can."""
        spans: list[list[int]] = []
        for other in range(len(self)):
            try:
                reader.read(other)
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

    def static_fields(self) -> dict[str, np.ndarray]:
        """Return the fields [cells] of cells that never change, by name. Raises `InputError` for damaged data."""
        with _opened(self.path) as file:
            try:
                if self.parts:
                    cells = [part._placed.cells for part in self.parts]
                    return _assembled(cells, [part.static_fields() for part in self.parts])
                arrays = {name: file["VTKHDF/CellData"][name] for name in self.cell_fields}
                return {name: stored(one, self.format) for name, one in arrays.items() if one.maxshape[0] is not None}
            except DAMAGED as error:
                remedy = f"fields of its cells are damaged ({error}); run again"
                raise InputError("path", str(self.path), remedy) from error

    @property
    def cells(self) -> int:
        """Number of cells."""
        return sum(len(cells) for _, cells in self.blocks)

    @property
    def history(self) -> dict[str, np.ndarray]:
        """Per-step arrays [steps] or [steps,k] by name, read from the file at each call; `InputError` if damaged."""
        return settled(self.path, self._history, (InputError,))

    def _history(self) -> dict[str, np.ndarray]:
        with _opened(self.path) as file:
            try:
                return {name: stored(array, self.format) for name, array in file["tcontact/history"].items()}
            except DAMAGED as error:
                remedy = f"the history is damaged ({error}); the frames may be whole: read them, or run again"
                raise InputError("path", str(self.path), remedy) from error


class FrameReader:
    """Reads the frames of an open file. What is damaged raises one of `DAMAGED`."""

    def __init__(self, data: ResultData, file: h5py.File) -> None:
        self._data, root = data, file["VTKHDF"]
        self._checks = file["tcontact/frames"] if data.format > 1 else None
        self._fields: dict[str, dict[str, tuple[h5py.Dataset, h5py.Dataset | None]]] = {}
        for group, names in (("PointData", data.point_fields), ("CellData", data.cell_fields)):
            arrays = {name: root[group][name] for name in names}
            moving = {name: array.maxshape[0] is None for name, array in arrays.items()}
            places = {name: root[f"Steps/{group}Offsets/{name}"] if moving[name] else None for name in names}
            self._fields[group] = {name: (arrays[name], places[name]) for name in names}

    def check(self, index: int) -> int:
        """Return the checksum of a frame."""
        return int(self._checks[index]) if self._checks is not None else 0

    def read(self, index: int) -> Frame:
        """Return a frame as it was written."""
        rows = {"PointData": len(self._data.points), "CellData": self._data.cells}
        parts: dict[str, dict[str, np.ndarray]] = {group: {} for group in rows}
        moving: dict[str, np.ndarray] = {}
        for group, fields in self._fields.items():
            for name, (array, place) in fields.items():
                if place is None:  # all frames have the same
                    parts[group][name] = stored(array, self._data.format)
                else:
                    parts[group][name] = moving[f"{group}/{name}"] = _rows(array, int(place[index]), name, rows[group])
        time = float(self._data.times[index])
        if self._checks is not None and checksum(f"{index} {time!r}", moving) != self.check(index):
            raise ValueError("it is not what was written: its checksum is another one")
        return Frame(time, parts["PointData"], parts["CellData"])


class JoinedReader:
    """Reads the frames of the parts of all ranks as those of one mesh. What is damaged raises one of `DAMAGED`."""

    def __init__(self, data: ResultData, file: h5py.File, parts: list[FrameReader]) -> None:
        self._data, self._parts, self._checks = data, parts, file["tcontact/frames"]

    def read(self, index: int) -> Frame:
        """Return a frame as the ranks wrote it, in the user's numbering."""
        time = float(self._data.times[index])
        frames = [part.read(index) for part in self._parts]
        checks = np.array([part.check(index) for part in self._parts], dtype=np.uint32)
        if checksum(f"{index} {time!r}", {"parts": checks}) != int(self._checks[index]):
            raise ValueError("its parts are not those of one frame")
        places = [part._placed for part in self._data.parts]
        nodes, cells = [place.nodes[: place.owned] for place in places], [place.cells for place in places]
        pairs = zip(frames, nodes, strict=True)
        owned = [{name: own[: len(at)] for name, own in frame.point_data.items()} for frame, at in pairs]
        return Frame(time, _assembled(nodes, owned), _assembled(cells, [frame.cell_data for frame in frames]))


def _assembled(numbers: list[np.ndarray], parts: list[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Return fields of which every part has the rows of these numbers."""
    return {name: assembled(numbers, [fields[name] for fields in parts]) for name in parts[0]}


def glance(path: Path) -> tuple[np.ndarray, int]:
    """Return the times [s] of the frames of a result file and the number of its parts, without reading its mesh.

    Raises `InputError` as `ResultData.open`.
    """
    with _opened(path) as file:
        try:
            own = file["tcontact"]
            return _times(file["VTKHDF/Steps"], len(own["frames"]), False), int(own.attrs.get("parts", 0))
        except DAMAGED as error:
            raise InputError("path", str(path), f"is damaged ({error}); run again") from error


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


def _mesh(root: h5py.Group, format: int) -> tuple[np.ndarray, tuple[tuple[str, np.ndarray], ...]]:
    """Return points [n, 3] and blocks of a file that holds them."""
    names = ("Points", "Offsets", "Connectivity", "Types")
    points, offsets, connectivity, types = (stored(root[name], format) for name in names)
    return points, tuple(_blocks(types, offsets, connectivity))


def _place(group: h5py.Group) -> PartPlace:
    """Return the place of a part in the whole."""
    return PartPlace(stored(group["nodes"]), int(group.attrs["owned"]), stored(group["cells"]))


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


def _rows(array: h5py.Dataset, first: int, name: str, rows: int) -> np.ndarray:
    """Return the rows of a frame, of which the first one is given."""
    found = array[first : first + rows]
    if len(found) != rows:
        raise ValueError(f"field {name} ends early")
    return np.asarray(found)


def _unlocked(path: Path) -> h5py.File:
    """Return the file to read from: without a lock, or as the program has it open, if HDF5 takes only that."""
    try:
        return h5py.File(path, "r", locking=False)
    except OSError as error:
        if "locking" not in str(error):
            raise
        for locking in ("best-effort", True):
            with suppress(OSError):
                return h5py.File(path, "r", locking=locking)
        raise


@contextmanager
def _opened(path: Path) -> Iterator[h5py.File]:
    """Return the file to read from, as it was before a write that was cut short."""
    validate.file_exists("path", path, "no such file; give a result.vtkhdf that a run wrote")
    disk = AtomicFile(path, "r") if read_undo(path) is not None else None
    try:
        file = _unlocked(path) if disk is None else h5py.File(disk, "r")
    except DAMAGED as error:
        if disk is not None:
            disk.close()
        remedy = "not an HDF5 file, empty or cut short; give a result.vtkhdf that a run wrote"
        if path.stat().st_size == 0:
            remedy = "is empty: the run has stored nothing yet: read it again, or give a result.vtkhdf that a run wrote"
        if isinstance(error, PermissionError):
            remedy = "cannot be read: permission denied"
        raise InputError("path", str(path), remedy) from error
    try:
        with file:
            yield file
    finally:
        if disk is not None:
            disk.close()
