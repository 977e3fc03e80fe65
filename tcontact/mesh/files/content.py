"""The content of a mesh file of any format, and its conversion to a `Mesh`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...base.warning_kinds import MeshWarning, warn
from ..elements import ELEMENTS, MIXED, face_corners
from ..geometry import FloatArray, IntArray, cell_face_keys, face_keys, in_face_table
from ..mesh import Mesh

KINDS = {element.meshio: element.kind for element in ELEMENTS.values()}
ORDINARY = {"vertex", "line", "triangle", "quad", *KINDS}


class MeshFileError(Exception):
    """A mesh file cannot be used; the text says what to do."""


@dataclass
class FileMesh:
    """Contents of a mesh file, rows counted from 0.

    points: [n, 3]; blocks: (cell type in meshio's words, [m, corners]); node_sets: name -> ids;
    face_sets: name -> arrays of faces, triangles and quads apart; cell_sets: name -> by number of a block, the cells
    [k] in it.
    """

    points: FloatArray
    blocks: list[tuple[str, IntArray]]
    node_sets: dict[str, IntArray] = field(default_factory=dict)
    face_sets: dict[str, list[IntArray]] = field(default_factory=dict)
    cell_sets: dict[str, dict[int, IntArray]] = field(default_factory=dict)


def mesh_from_file(content: FileMesh, scale: float, kind: str | None) -> Mesh:
    """Make a mesh of the volume cells; nodes without cells are dropped.

    kind: of the cells to take, None = all. Raises `MeshFileError` for cells of other kinds and where several kinds do
    not make a mesh, `InputError` as `Mesh` does.
    """
    kinds = cell_kinds({name for name, rows in content.blocks if len(rows)}, kind)
    parts = {one: [rows for name, rows in content.blocks if KINDS.get(name) == one] for one in kinds}
    cells = {one: np.concatenate(rows).astype(np.int64) for one, rows in parts.items()}
    if any(rows.min() < 0 or rows.max() >= len(content.points) for rows in cells.values()):
        raise MeshFileError("cells refer to nodes that the file does not hold; save it again, complete")
    points = np.asarray(content.points, dtype=np.float64) * scale

    number = np.full(len(points), -1, dtype=np.int64)
    used = np.unique(np.concatenate([rows.reshape(-1) for rows in cells.values()]))
    number[used] = np.arange(len(used))
    found = kinds[0] if len(kinds) == 1 else MIXED
    given = content.face_sets
    if any(len(rows) and KINDS.get(name, kinds[0]) not in kinds for name, rows in content.blocks):
        given = _of_these(given, found, number, cells[found])
    face_sets = {name: _faces(name, faces, found, number) for name, faces in given.items() if faces}
    node_sets = {}
    for name, ids in content.node_sets.items():
        kept = number[np.unique(ids)]
        if (kept >= 0).any():
            node_sets[name] = kept[kept >= 0]
        else:
            warn(f"set {name!r} is left out: none of its nodes belongs to a {found} cell", MeshWarning)
    mine = {one: number[rows] for one, rows in cells.items()}
    sets: dict[str, Any] = {"node_sets": node_sets, "face_sets": face_sets, "cell_sets": _cell_sets(content, kinds)}
    if len(kinds) == 1:
        return Mesh(points[used], mine[found], found, **sets)
    try:
        return Mesh(points[used], mine, **sets)  # type: ignore[arg-type]
    except InputError as error:
        mixed = " mixed with ".join(ELEMENTS[one].plural for one in kinds)
        raise MeshFileError(f"{mixed}: {error}; or take one of them with kind=, a body of each") from error


def _cell_sets(content: FileMesh, kinds: list[str]) -> dict[str, IntArray]:
    """Return the cell sets in the numbering of the mesh: kind after kind, within a kind block after block."""
    first, start = {}, 0
    for kind in kinds:
        for number, (name, rows) in enumerate(content.blocks):
            if KINDS.get(name) == kind:
                first[number] = start
                start += len(rows)
    found = {}
    for name, parts in content.cell_sets.items():
        numbers = [
            first[number] + np.unique(cells) for number, cells in parts.items() if number in first and len(cells)
        ]
        if numbers:
            found[name] = np.concatenate(numbers)
    return found


def cell_kinds(types: set[str], wanted: str | None) -> list[str]:
    """Return the kinds of volume cells to take. Raises `MeshFileError` without any, `InputError` without `wanted`."""
    strange = sorted(types - ORDINARY)
    if strange:
        known = ", ".join(element.plural for element in ELEMENTS.values())
        raise MeshFileError(f"cells of type {', '.join(strange)}; mesh with {known} of first order")
    kinds = [kind for name, kind in KINDS.items() if name in types]
    if not kinds:
        held = ", ".join(sorted(types)) or "nothing"
        raise MeshFileError(
            f"no volume cells, only {held}; mesh the volume and, where groups are used, put it into a physical volume"
        )
    if wanted is not None and wanted not in kinds:
        raise InputError("kind", wanted, f"the file holds {' and '.join(kinds)} cells; leave kind out or mesh anew")
    return kinds if wanted is None else [wanted]


def _of_these(
    given: dict[str, list[IntArray]], kind: str, number: IntArray, cells: IntArray
) -> dict[str, list[IntArray]]:
    """Select the faces of a file with several kinds of cells that the chosen cells have; warn of sets without any."""
    lengths = face_corners(kind)
    known = cell_face_keys(cells, kind, len(number))
    result = {}
    for name, arrays in given.items():
        fitting = [faces for faces in arrays if faces.shape[1] in lengths]
        kept = [faces[np.isin(face_keys(in_face_table(faces, kind), len(number)), known)] for faces in fitting]
        result[name] = [faces for faces in kept if len(faces)]
        if arrays and not result[name]:
            warn(f"set {name!r} is left out: none of its faces belongs to a {kind} cell", MeshWarning)
    return result


def _faces(name: str, arrays: list[IntArray], kind: str, number: IntArray) -> IntArray:
    """Return the faces of a set in the new numbering, each once."""
    lengths = face_corners(kind)
    if any(faces.shape[1] not in lengths for faces in arrays):
        raise MeshFileError(f"surface {name!r} has faces that are no faces of {kind} cells; mesh it with the volume")
    faces = np.concatenate([in_face_table(faces, kind) for faces in arrays])
    _, first = np.unique(face_keys(faces, len(number)), return_index=True)
    faces = number[faces[np.sort(first)]]
    if (faces < 0).any():
        raise MeshFileError(f"surface {name!r} has faces that belong to no cell; leave this group out of the file")
    return faces
