"""The result file of a run on several ranks, which shows what is in the parts of all ranks as one mesh.

Its large arrays are virtual: HDF5 takes their rows from the parts (part_file.py), which stay where they are relative to
it. Mesh and fields have the nodes that each rank owns, one rank after the other:

    frame 0                        frame 1
    | rank 0 | rank 1 | rank 2 |   | rank 0 | rank 1 | rank 2 |   ...

so that ParaView sees one grid without seams. Ranks write their parts first; then the file counts the frame. Where a
part is missing its values are not numbers; `ResultData` refuses the file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from .part_places import part_name
from .vtkhdf import ResultFile, column, store

Fields = Mapping[tuple[str, str], tuple[Any, tuple[int, ...]]]


@dataclass(frozen=True)
class PartSize:
    """Sizes of a part: its nodes, how many of them its rank owns, its cells, and corners of cells."""

    nodes: int
    owned: int
    cells: int
    corners: int


class MasterFile(ResultFile):
    """Writer of the result file that shows the parts of all ranks."""

    _library = ("v108", "v110")  # the first with virtual arrays; without the "still open" mark
    _shown: Sequence[PartSize] = ()
    _kinds: Fields

    @classmethod
    def start(
        cls,
        path: Path,
        parts: Sequence[PartSize],
        attributes: Mapping[str, Any],
        static: Sequence[str],
        frames: Sequence[tuple[float, np.ndarray]] = (),
        fields: Fields | None = None,
    ) -> MasterFile:
        """Start the file of these parts, which are there, one of each rank.

        static: names of fields of cells that never change; frames, fields: those that the parts have already, see
        `add`. Raises `OSError`.
        """
        nodes, cells, corners = (sum(getattr(one, name) for one in parts) for name in ("owned", "cells", "corners"))

        def fill(root: h5py.Group) -> None:
            counts = {"NumberOfPoints": nodes, "NumberOfCells": cells, "NumberOfConnectivityIds": corners}
            for name, count in counts.items():
                store(root, name, np.array([count], dtype=np.int64))
            owned, all_cells = [one.owned for one in parts], [one.cells for one in parts]
            ends = [one.cells + (rank == 0) for rank, one in enumerate(parts)]
            _show(root, "Points", (nodes, 3), np.float64, _whole(owned, [one.nodes for one in parts]))
            _show(root, "Types", (cells,), np.uint8, _whole(all_cells))
            _show(root, "Offsets", (cells + 1,), np.int64, _whole(ends), "tcontact/part/offsets")
            every = _whole([one.corners for one in parts])
            _show(root, "Connectivity", (corners,), np.int64, every, "tcontact/part/connectivity")
            for name in static:
                _show(root["CellData"], name, (cells,), np.int64, _whole(all_cells))

        found = cls._started(path, nodes, cells, static, attributes, fill)
        found._file["tcontact"].attrs["parts"] = np.int64(len(parts))
        found._shown = tuple(parts)
        for time, checks in frames:
            found.add(time, checks, fields or {}, commit=False)
        found.commit()
        return found

    def add(self, time: float, checks: np.ndarray, fields: Fields, commit: bool = True) -> None:
        """Count a frame at `time` [s] that all parts have on disk.

        checks [ranks]: its checksum in every part; fields: kind and shape of a row of each, by group and name. Raises
        `OSError`.
        """
        for group, name in fields.keys() - self._field_offsets.keys():
            self._field_offsets[group, name] = column(self._file["VTKHDF/Steps"][f"{group}Offsets"], name)
        self._kinds = fields
        self._take(time, {"parts": checks.astype(np.uint32)})
        if commit:
            self.commit()

    def _count_new(self) -> None:
        if self._new:
            for (group, name), (kind, shape) in self._kinds.items():
                self._show_field(group, name, kind, shape)
        super()._count_new()

    def _show_field(self, group: str, name: str, kind: Any, shape: tuple[int, ...]) -> None:
        """Show a field of all frames, in the place of one of fewer frames."""
        root, total, frames = self._file["VTKHDF"][group], self._rows[group], self._frames
        if name in root:
            del root[name]
        shown, there = ("owned", "nodes") if group == "PointData" else ("cells", "cells")
        counts = [[getattr(one, name) for one in self._shown] for name in (shown, there)]
        rows = _Rows(counts[0], counts[1], total, frames)
        _show(root, name, (frames * total, *shape), kind, rows)


@dataclass(frozen=True)
class _Rows:
    """Rows of the parts that an array shows: of `there` rows a frame of each part the first `shown`."""

    shown: Sequence[int]
    there: Sequence[int]
    total: int
    frames: int = 1

    def __iter__(self) -> Iterator[tuple[int, int, int, int]]:
        """Iterate over the parts that have any: rank, first row here, rows a frame that are shown, and that it has."""
        first = 0
        for rank, (shown, there) in enumerate(zip(self.shown, self.there, strict=True)):
            if shown:
                yield rank, first, shown, there
            first += shown


def _whole(shown: Sequence[int], there: Sequence[int] | None = None) -> _Rows:
    """Return the rows of an array that is there once."""
    return _Rows(shown, shown if there is None else there, sum(shown))


def _show(group: h5py.Group, name: str, shape: tuple[int, ...], kind: Any, rows: _Rows, source: str = "") -> None:
    """Make an array that shows rows of the parts; source: name of the array there, "" = the same as here."""
    target, kept = h5py.h5s.create_simple(shape), h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    if np.dtype(kind).kind == "f":
        kept.set_fill_value(np.array(np.nan))
    rest = shape[1:]
    once, zeros = (1,) * len(rest), (0,) * len(rest)
    for rank, first, shown, there in rows:
        target.select_hyperslab((first, *zeros), (rows.frames, *once), (rows.total, *once), (shown, *rest))
        of_part = h5py.h5s.create_simple((rows.frames * there, *rest))
        of_part.select_hyperslab((0, *zeros), (rows.frames, *once), (there, *once), (shown, *rest))
        path = source or f"{group.name}/{name}"
        kept.set_virtual(target, part_name(rank).encode(), path.encode(), of_part)
    target.select_all()
    h5py.h5d.create(group.id, name.encode(), h5py.h5t.py_create(np.dtype(kind)), target, kept)
