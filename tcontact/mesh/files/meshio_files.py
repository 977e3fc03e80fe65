"""Read Gmsh and VTU files with meshio."""

from __future__ import annotations

import contextlib
import io
import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from ..geometry import IntArray, face_keys
from .content import KINDS, FileMesh, MeshFileError
from .meshio_guard import guarded
from .second_order import SECOND_ORDER

DIMENSION = {"vertex": 0, "line": 1, "triangle": 2, "quad": 2} | dict.fromkeys(KINDS, 3)
DIMENSION |= {name: DIMENSION[first] for name, first in SECOND_ORDER.items()}
MAXIMUM_REGIONS = 100  # values of a cell array of a VTU file that makes cell sets
# VTK types without a volume that meshio leaves out: poly-vertices, poly-lines, strips of triangles
_FLAT = {"2", "4", "6"}
_UNNAMED = ("PhysicalPoint", "PhysicalLine", "PhysicalSurface", "PhysicalVolume")  # names in gmsh's exports


def read_vtu(path: Path) -> FileMesh:
    """Read the cells of a VTU file, and cell sets from its cell data.

    A cell array of whole numbers with at most `MAXIMUM_REGIONS` values, named "region", makes the sets "region-1" and
    so on; identities of cells and arrays of VTK's own are left out. Point data are not sets.
    """
    mesh = read_file(path, "vtu")
    return FileMesh(mesh.points, typed_blocks(mesh), cell_sets=region_sets(mesh))


def region_sets(mesh: Any) -> dict[str, dict[int, IntArray]]:
    """Return cell sets by whole numbers of the cells, as `FileMesh` has them."""
    found = {}
    for name, arrays in mesh.cell_data.items():
        parts = [np.asarray(part) for part in arrays]
        known = name.lower().startswith("vtk") or name.lower().endswith("ids")
        if known or any(part.dtype.kind not in "iu" or part.ndim != 1 for part in parts):
            continue
        values = np.unique(np.concatenate(parts))
        for value in values.tolist() if len(values) <= MAXIMUM_REGIONS else []:
            found[f"{name}-{value}"] = {number: np.flatnonzero(part == value) for number, part in enumerate(parts)}
    return found


def read_gmsh(path: Path) -> FileMesh:
    """Read cells and physical groups of a gmsh file, 2.2 or 4.1, ASCII or binary.

    Groups of dimension 2 become face sets, all others sets of their nodes, those of dimension 3 also cell sets. A group
    without a name is called PhysicalSurface9 and the like. Of an entity in several groups meshio keeps every named one
    but only the first unnamed one (4.1; none if some entities have no group at all). Version 2.2 writes such a cell
    once for each group; the doubles are dropped. Groups of one dimension and one name are one set.
    """
    mesh = read_file(path, "gmsh")
    blocks = typed_blocks(mesh)
    names = _physical_names(path)
    content = FileMesh(mesh.points, blocks)
    node_ids: dict[str, list[IntArray]] = {}
    regions: dict[str, dict[int, IntArray]] = {}
    for k, (cell_type, rows) in enumerate(blocks):
        dimension = DIMENSION.get(cell_type, -1)
        tags = np.asarray(mesh.cell_data["gmsh:physical"][k]) if "gmsh:physical" in mesh.cell_data else np.zeros(0, int)
        members: dict[str, list[IntArray]] = {}
        for tag in np.unique(tags[tags != 0]).tolist():
            name = names.get((dimension, abs(tag))) or f"{_UNNAMED[dimension]}{abs(tag)}"
            members.setdefault(name, []).append(np.flatnonzero(tags == tag))
        for group, sets in mesh.cell_sets.items():
            if group in mesh.field_data and group[0] == dimension and len(sets[k]):
                name = names.get((dimension, abs(group[1]))) or f"{_UNNAMED[dimension]}{abs(group[1])}"
                members.setdefault(name, []).append(np.asarray(sets[k], dtype=np.int64))
        for name, parts in members.items():
            cells = np.unique(np.concatenate(parts))  # several groups may have one name
            if dimension == 2:
                content.face_sets.setdefault(name, []).append(rows[cells])
            else:
                node_ids.setdefault(name, []).append(rows[cells].reshape(-1))
            if dimension == 3:
                regions.setdefault(name, {})[k] = cells
    content.node_sets = {name: np.concatenate(ids) for name, ids in node_ids.items()}
    content.blocks = []
    for number, cell_type in enumerate(dict.fromkeys(name for name, _ in blocks)):
        rows, place = _without_doubles(blocks, cell_type)
        content.blocks.append((cell_type, rows))
        first = 0
        for k, (other, own) in enumerate(blocks):
            if other == cell_type:
                for name in (name for name, places in regions.items() if k in places):
                    known = content.cell_sets.setdefault(name, {}).get(number, np.zeros(0, dtype=np.int64))
                    content.cell_sets[name][number] = np.union1d(known, place[first + regions[name][k]])
                first += len(own)
    return content


def read_file(path: Path, file_format: str) -> Any:
    """Read a mesh by meshio without its printing; its `SystemExit` and warnings of open sections become errors."""
    from unittest import mock

    import meshio

    said = io.StringIO()
    with contextlib.ExitStack() as stack:
        for context in (contextlib.redirect_stdout(said), contextlib.redirect_stderr(said), warnings.catch_warnings()):
            stack.enter_context(context)
        stack.enter_context(guarded(path))
        stack.enter_context(mock.patch.dict("meshio._mesh.topological_dimension", DIMENSION))  # its own lacks wedge15
        stack.enter_context(mock.patch("meshio.gmsh._gmsh41._read_physical_names", _read_groups))
        warnings.simplefilter("ignore")
        try:
            mesh = meshio.read(path, file_format)
        except MemoryError as error:
            raise MeshFileError("it needs more memory than there is; the file is damaged or too large") from error
        except SystemExit as error:
            reason = " ".join(said.getvalue().split())
            why = f" ({reason})" if reason else ""
            raise MeshFileError(f"no {file_format} file, or a broken one{why}; save it again") from error
        except ValueError as error:
            if "gmsh:physical" not in str(error):
                raise
            mesh = _read_partly_grouped(path)
    text = " ".join(said.getvalue().split())
    if "not closed by" in text:
        raise MeshFileError("the file ends too early; save it again, complete")
    left_out = set(re.findall(r"cells that meshio cannot handle \(type (\d+)\)", text)) - _FLAT
    if left_out:
        remedy = "save hexahedra, tetrahedra or prisms alone (tcontact.Mesh.from_pyvista takes voxels too)"
        raise MeshFileError(f"cells of the VTK type {', '.join(sorted(left_out))}, which are not read; {remedy}")
    return mesh


def _read_partly_grouped(path: Path) -> Any:
    """Read a 4.1 file in which only some entities have groups (Mesh.SaveAll=1), which meshio's table refuses."""
    from unittest import mock

    import meshio
    from meshio.gmsh import _gmsh41

    def mesh_of_named_groups(*arguments: Any, cell_data: dict[str, Any], **others: Any) -> Any:
        cell_data.pop("gmsh:physical", None)
        return meshio.Mesh(*arguments, cell_data=cell_data, **others)

    with mock.patch.object(_gmsh41, "Mesh", mesh_of_named_groups):
        return meshio.read(path, "gmsh")


def typed_blocks(mesh: Any) -> list[tuple[str, IntArray]]:
    """Return the types of cells in meshio's words with their nodes; polyhedra come last, without nodes."""
    return [(block.type, np.asarray(block.data)) for block in mesh.cells if not block.type.startswith("poly")] + [
        (block.type, np.zeros((len(block.data), 1), dtype=np.int64))
        for block in mesh.cells
        if block.type.startswith("poly")
    ]


def _read_groups(stream: Any, groups: dict[tuple[int, int], IntArray]) -> None:
    """Read the named groups by dimension and tag in place of meshio's function, which keeps one group of a name.

    A group that an entity belongs to turned round has its tag with a minus sign there.
    """
    from meshio.gmsh.common import _fast_forward_to_end_block

    for _ in range(int(stream.readline().decode())):
        dimension, tag = (int(word) for word in stream.readline().split(maxsplit=2)[:2])
        for turned in (tag, -tag):
            groups[dimension, turned] = np.array([turned, dimension])
    _fast_forward_to_end_block(stream, "PhysicalNames")


def _physical_names(path: Path) -> dict[tuple[int, int], str]:
    """Return (dimension, tag) -> name, which stands in quotes in most files."""
    section = re.search(rb"\$PhysicalNames\s(.*?)\$EndPhysicalNames", path.read_bytes(), re.DOTALL)
    text = section.group(1).decode(errors="replace") if section else ""
    rows = re.findall(r'(?m)^[ \t]*(\d)[ \t]+(\d+)[ \t]+"?(.*?)"?\s*$', text)
    return {(int(dimension), int(tag)): name for dimension, tag, name in rows}


def _without_doubles(blocks: list[tuple[str, IntArray]], cell_type: str) -> tuple[IntArray, IntArray]:
    """Return all cells of one type, each once, and for every cell of the blocks its place among them."""
    rows = np.concatenate([block for name, block in blocks if name == cell_type]).astype(np.int64)
    if len(rows) == 0 or DIMENSION.get(cell_type) != 3 or rows.min() < 0:
        return rows, np.arange(len(rows))
    _, first, same = np.unique(face_keys(rows, int(rows.max()) + 1), return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return rows[first[order]], rank[same.reshape(-1)]
