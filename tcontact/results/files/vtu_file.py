"""One frame as a .vtu file: VTK's XML unstructured grid with its numbers appended raw.

Format: https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html (offsets of `AppendedData` count bytes
from the underscore; each block is its length as UInt64, then the numbers).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from ...device.atomic_file import replaced
from ...mesh.elements import ELEMENTS

TYPES = {"f": "Float64", "i": "Int64", "u": "UInt8"}


class VtuWriter:
    """Writer of frames of one mesh: points [n, 3] [m], blocks (kind, connectivity [m, k]) as in `ResultData`."""

    def __init__(self, points: np.ndarray, blocks: Sequence[tuple[str, np.ndarray]]) -> None:
        self.points = points
        sizes = np.concatenate([np.full(len(cells), cells.shape[1], dtype=np.int64) for _, cells in blocks])
        self.cells = {
            "connectivity": np.concatenate([cells.ravel() for _, cells in blocks]).astype(np.int64),
            "offsets": np.cumsum(sizes),
            "types": np.concatenate(
                [np.full(len(cells), ELEMENTS[kind].vtk, dtype=np.uint8) for kind, cells in blocks]
            ),
        }

    def write(self, path: Path, point_data: Mapping[str, np.ndarray], cell_data: Mapping[str, np.ndarray]) -> None:
        """Write one frame; fields [n] or [n, k] and [cells] or [cells, k] by name."""
        sections = {
            "PointData": point_data,
            "CellData": cell_data,
            "Points": {"Points": self.points},
            "Cells": self.cells,
        }
        raw: list[bytes] = []
        size = 0
        text = ['<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">']
        text.append("<UnstructuredGrid>")
        text.append(f'<Piece NumberOfPoints="{len(self.points)}" NumberOfCells="{len(self.cells["types"])}">')
        for section, arrays in sections.items():
            text.append(f"<{section}>")
            for name, array in arrays.items():
                kind = TYPES[array.dtype.kind]
                width = "" if array.ndim == 1 else f' NumberOfComponents="{array.shape[1]}"'
                text.append(
                    f'<DataArray type="{kind}" Name={quoteattr(name)}{width} format="appended" offset="{size}"/>'
                )
                block = np.ascontiguousarray(array, dtype=f"<{array.dtype.kind}{array.dtype.itemsize}").tobytes()
                raw += [np.array(len(block), dtype="<u8").tobytes(), block]
                size += 8 + len(block)
            text.append(f"</{section}>")
        text += ["</Piece>", "</UnstructuredGrid>", '<AppendedData encoding="raw">', "_"]
        with replaced(path, synced=False) as part, part.open("wb") as file:
            file.write("\n".join(text).encode())
            for piece in raw:
                file.write(piece)
            file.write(b"\n</AppendedData>\n</VTKFile>\n")


def write_collection(path: Path, times: Sequence[float], files: Sequence[Path]) -> None:
    """Write the .pvd file that tells ParaView which .vtu file belongs to which time [s]."""
    rows = [
        f'<DataSet timestep="{float(time)!r}" part="0" file={quoteattr(file.name)}/>'
        for time, file in zip(times, files, strict=True)
    ]
    head = '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">'
    text = "\n".join([head, "<Collection>", *rows, "</Collection>", "</VTKFile>", ""])
    with replaced(path, synced=False) as part:
        part.write_text(text, encoding="utf-8")
