"""Check a `Mesh`; each `InputError` says which cell or node is wrong and how many are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..base.errors import InputError
from ..base.validate import choice
from ..base.warning_kinds import MeshWarning, warn
from .elements import ELEMENTS, MIXED, face_corners
from .geometry import (
    Blocks,
    FloatArray,
    IntArray,
    Surface,
    cell_face_keys,
    cracks,
    face_keys,
    in_face_table,
    jacobians,
    surface,
)

FLAT = 1e-12  # det / edges at an integration point at or below which the cell has no volume there
CORNER = 1e-6  # det / edges at a corner: flatter than this is rounding of float32 or printed coordinates, not inversion


def checked_nodes(nodes: Any) -> FloatArray:
    """Return the coordinates [n, 3] as a read-only float64 copy."""
    array = _numbers("nodes", nodes, "give an array [n, 3] of coordinates in metres")
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError("nodes", f"array of shape {array.shape}", "give coordinates x y z of each node: shape [n, 3]")
    if len(array) == 0:
        raise InputError("nodes", "empty array", "a mesh needs at least one cell and its nodes")
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if len(bad):
        raise InputError("nodes", _first("node", bad, len(array)), "has a NaN or infinite coordinate; give finite ones")
    return read_only(array)


def checked_blocks(cells: Any, kind: Any, node_count: int) -> tuple[tuple[str, IntArray], ...]:
    """Return the kinds of cells with their corner ids [m, a], read-only int64 copies; no unused node.

    cells: an array with its kind, or a dict from kinds to arrays, for which `kind` is "mixed" or the only one.
    """
    known = ", ".join(map(repr, ELEMENTS))
    if kind is not None and not isinstance(kind, str):
        raise InputError("kind", kind, f"give one of {known}")
    if not isinstance(cells, Mapping):
        if kind == MIXED:
            raise InputError("kind", kind, f"give one of {known}, or cells as a dict from kinds to arrays")
        blocks = [(choice("kind", kind, ELEMENTS), cells, "cells")]
    else:
        for name in cells:
            if not isinstance(name, str) or name not in ELEMENTS:
                raise InputError("cells", name, f"a dict of cells has the kinds {known} as keys")
        if kind != MIXED and [*cells] != [kind]:
            raise InputError("kind", kind, f"the cells are {' and '.join(cells) or 'none'}; leave kind out")
        if not cells:
            raise InputError("cells", "empty dict", "a mesh needs at least one cell")
        blocks = [(name, part, f"cells[{name!r}]") for name, part in cells.items()]
    found = tuple((name, _checked_cells(field, part, name, node_count)) for name, part, field in blocks)
    used = np.zeros(node_count, dtype=bool)
    for _, array in found:
        used[array] = True
    bad = np.flatnonzero(~used)
    if len(bad):
        raise InputError(
            "nodes",
            _first("node", bad, node_count),
            "belongs to no cell; remove it and renumber (read_mesh does so for files)",
        )
    return found


def _checked_cells(field: str, cells: Any, kind: str, node_count: int) -> IntArray:
    """Return corner ids [m, a] as a read-only int64 copy; in range, no cell or corner twice."""
    corners = ELEMENTS[kind].corners
    array = _ids(field, cells, f"give an integer array [m, {corners}] of node ids, corners in VTK order")
    if array.size == 0:
        raise InputError(field, "empty array", "a mesh needs at least one cell")
    if array.ndim != 2 or array.shape[1] != corners:
        raise InputError(
            field, f"array of shape {array.shape}", f"{kind} cells have {corners} corners: shape [m, {corners}]"
        )
    bad = np.flatnonzero(((array < 0) | (array >= node_count)).any(axis=1))
    if len(bad):
        raise InputError(field, _first("cell", bad, len(array), array), f"node ids count from 0 to {node_count - 1}")
    ranked = np.sort(array, axis=1)
    bad = np.flatnonzero((ranked[:, 1:] == ranked[:, :-1]).any(axis=1))
    if len(bad):
        raise InputError(
            field, _first("cell", bad, len(array), array), f"names a node twice; give {corners} different corners"
        )
    keys = face_keys(array, node_count)
    order = np.argsort(keys, kind="stable")
    bad = np.sort(order[1:][keys[order[1:]] == keys[order[:-1]]])
    if len(bad):
        raise InputError(
            field, _first("cell", bad, len(array), array), "has the same nodes as an earlier cell; remove the double"
        )
    return np.asarray(read_only(array))


def turned_blocks(nodes: FloatArray, blocks: Blocks) -> tuple[tuple[str, IntArray], ...]:
    """Return the cells, mirrored ones turned with a `MeshWarning`; refuse cells without volume and tangled ones."""
    try:
        check_shapes(nodes, blocks)
        return tuple(blocks)
    except InputError:
        found = [(kind, *_turned(nodes, cells, kind)) for kind, cells in blocks]
    turned = tuple((kind, cells) for kind, cells, _ in found)
    check_shapes(nodes, turned)
    counts = " and ".join(f"{count} inverted {kind} cells" for kind, _, count in found if count)
    warn(f"corners of {counts} were reordered", MeshWarning)
    return turned


def _turned(nodes: FloatArray, cells: IntArray, kind: str) -> tuple[IntArray, int]:
    """Return the cells, those turned that are inverted at every point of integration, and how many these are."""
    element = ELEMENTS[kind]
    mirrored = np.ones(len(cells), dtype=bool)
    for part, det, edges in jacobians(nodes, cells, element.rule[1]):
        mirrored[part] = (det < -FLAT * edges).all(axis=0)
    turned = np.where(mirrored[:, None], cells[:, element.mirror], cells)
    return read_only(turned), int(mirrored.sum())


def check_shapes(nodes: FloatArray, blocks: Blocks) -> None:
    """Refuse cells without volume and inverted cells.

    A cell must have a positive Jacobian at every point of integration. A corner may be flat (wedge-like hexes), so
    corners are refused only when clearly negative; see `FLAT` and `CORNER`.
    """
    for kind, cells in blocks:
        _check_shapes("cells" if len(blocks) == 1 else f"cells[{kind!r}]", nodes, cells, kind)


def _check_shapes(field: str, nodes: FloatArray, cells: IntArray, kind: str) -> None:
    element = ELEMENTS[kind]
    gradients = element.rule[1]
    flat = np.zeros(len(cells), dtype=bool)
    inverted = np.zeros(len(cells), dtype=bool)
    for part, det, edges in jacobians(nodes, cells, gradients):
        if not np.isfinite(edges).all():
            raise InputError(
                "nodes", float(np.abs(nodes).max()), "coordinates this large overflow; use metres near the origin"
            )
        flat[part] = (np.abs(det) <= FLAT * edges).any(axis=0)
        inverted[part] = (det < -FLAT * edges).any(axis=0)
    if len(gradients) > 1:  # else the Jacobian is the same everywhere
        for part, det, edges in jacobians(nodes, cells, element.shape(element.reference)[1]):
            inverted[part] |= (det < -CORNER * edges).any(axis=0)
    bad = np.flatnonzero(inverted)
    if len(bad):
        raise InputError(
            field,
            _first("cell", bad, len(cells), cells),
            f"is inverted (negative Jacobian); {element.order}, or untangle the mesh",
        )
    bad = np.flatnonzero(flat)
    if len(bad):
        raise InputError(
            field, _first("cell", bad, len(cells), cells), "has no volume; remove it or move its nodes apart"
        )


def checked_surface(blocks: Blocks, node_count: int) -> Surface:
    """Return the boundary of the mesh; a face with more than two cells and a quadrilateral on triangles are refused."""
    skin = surface(blocks, node_count)
    if len(skin.crowded):
        value = f"face {skin.crowded[0].tolist()} ({len(skin.crowded)} such)"
        raise InputError("cells", value, "is shared by more than two cells; remove the overlapping cells")
    if len(blocks) > 1 and len(open_ := cracks(skin, node_count)):
        value = f"face {skin.faces[open_[0]].tolist()} ({len(open_)} such)"
        remedy = "is a quadrilateral of one cell on triangles of others, which would part there; mesh it so that"
        remedy += " quadrilaterals meet quadrilaterals (wedge6 between hex8 and the triangles; there are no pyramids)"
        raise InputError("cells", value, remedy)
    return skin


def warn_of_gaps(nodes: FloatArray, skin: Surface) -> None:
    """Warn of nodes of the boundary that have the place of another one: their cells are not joined there."""
    numbers = np.unique(skin.faces)
    x = nodes[numbers]
    order = np.lexsort(x.T)
    doubles = (x[order[1:]] == x[order[:-1]]).all(axis=1)
    if doubles.any():
        first, other = numbers[order[:-1][doubles][0]], numbers[order[1:][doubles][0]]
        count = int(doubles.sum())
        text = (
            f"{count} {'nodes have' if count > 1 else 'node has'} the place of another one ({other} that of {first}):"
        )
        text += (
            " cells that share no node are not joined there. To join them: nodes, number = numpy.unique(nodes, axis=0,"
        )
        warn(f"{text} return_inverse=True); cells = number.ravel()[cells]", MeshWarning)


def checked_cell_sets(sets: Any, cell_count: int) -> dict[str, IntArray]:
    """Return named cell numbers [k], each a read-only int64 copy, ascending."""
    checked = {}
    for name, ids in _named("cell_sets", sets).items():
        field = f"cell_sets[{name!r}]"
        array = _ids(field, ids, "give cell numbers [k]; for a mask use numpy.flatnonzero(mask)", "cell numbers")
        if array.ndim != 1 or array.size == 0:
            remedy = "give at least one cell number, shape [k], or leave the set out"
            raise InputError(field, f"array of shape {array.shape}", remedy)
        bad = array[(array < 0) | (array >= cell_count)]
        if len(bad):
            remedy = f"{len(bad)} numbers are no cells; cells count from 0 to {cell_count - 1}"
            raise InputError(field, int(bad[0]), remedy)
        ranked = np.sort(array)
        if (ranked[1:] == ranked[:-1]).any():
            double = int(ranked[1:][ranked[1:] == ranked[:-1]][0])
            raise InputError(field, double, "the set names this cell twice; name each once (numpy.unique)")
        checked[name] = read_only(ranked)
    return checked


def checked_node_sets(sets: Any, node_count: int) -> dict[str, IntArray]:
    """Return named node ids [k], each a read-only int64 copy."""
    checked = {}
    for name, ids in _named("node_sets", sets).items():
        field = f"node_sets[{name!r}]"
        array = _ids(field, ids, "give node ids [k]; for a mask use numpy.flatnonzero(mask)")
        if array.ndim != 1 or array.size == 0:
            raise InputError(
                field, f"array of shape {array.shape}", "give at least one node id, shape [k], or leave the set out"
            )
        bad = array[(array < 0) | (array >= node_count)]
        if len(bad):
            raise InputError(field, int(bad[0]), f"{len(bad)} ids are no nodes; ids count from 0 to {node_count - 1}")
        checked[name] = read_only(array)
    return checked


def checked_members(field: str, ids: Any, count: int, what: str) -> IntArray:
    """Return the numbers [k] of some of so many nodes or cells (`what`), an int64 copy; none for none."""
    remedy = f"give numbers of {what}, shape [k], counted from 0; for a mask use numpy.flatnonzero(mask)"
    array = _ids(field, ids, remedy, f"numbers of {what}")
    if array.ndim != 1:
        raise InputError(field, f"array of shape {array.shape}", remedy)
    bad = array[(array < 0) | (array >= count)]
    if len(bad):
        remedy = f"{len(bad)} numbers are no {what}; {what} count from 0 to {count - 1}"
        raise InputError(field, int(bad[0]), remedy)
    return array


def checked_face_sets(sets: Any, blocks: Blocks, node_count: int, skin: Surface) -> dict[str, IntArray]:
    """Return named faces [k, 4|3], each a read-only int64 copy; every face must belong to a cell."""
    kind = blocks[0][0] if len(blocks) == 1 else MIXED
    lengths = face_corners(kind)
    corners = " or ".join(map(str, lengths))
    checked = {}
    for name, faces in _named("face_sets", sets).items():
        field = f"face_sets[{name!r}]"
        array = _ids(field, faces, f"give an integer array [k, {corners}] of node ids")
        if array.ndim != 2 or array.shape[1] not in lengths or array.size == 0:
            raise InputError(
                field,
                f"array of shape {array.shape}",
                f"faces of {kind} cells have {corners} corners: shape [k, {corners}], k >= 1",
            )
        array = in_face_table(array, kind)
        bad = np.flatnonzero(((array < 0) | (array >= node_count)).any(axis=1))
        if len(bad):
            raise InputError(
                field, _first("face", bad, len(array), array), f"node ids count from 0 to {node_count - 1}"
            )
        loose = np.flatnonzero(skin.find(array, node_count) < 0)
        if len(loose):  # inner faces are rare: only now search all faces
            keys = face_keys(array[loose], node_count)
            inner = np.any([np.isin(keys, cell_face_keys(cells, one, node_count)) for one, cells in blocks], axis=0)
            bad = loose[~inner]
            if len(bad):
                raise InputError(
                    field, _first("face", bad, len(array), array), "is a face of no cell; give faces that cells have"
                )
        checked[name] = read_only(array)
    return checked


def checked_numbers(numbers: Any, node_count: int) -> IntArray:
    """Return numbers of nodes [..]. Raises `InputError` for what is no number of a node."""
    found = np.asarray(numbers)
    if found.size and (found.dtype.kind not in "iu" or found.min() < 0 or found.max() >= node_count):
        raise InputError("numbers", numbers, f"give whole numbers of nodes, from 0 to {node_count - 1}")
    return found.astype(np.int64, copy=False)


def read_only(array: Any) -> Any:
    """Return the array, made read-only."""
    array.flags.writeable = False
    return array


def _named(field: str, sets: Any) -> Mapping[str, Any]:
    if not isinstance(sets, Mapping):
        raise InputError(field, sets, "give a dict from set name to array")
    for name in sets:
        if not isinstance(name, str) or not name:
            raise InputError(field, name, "set names are non-empty strings")
    return sets


def _numbers(field: str, value: Any, remedy: str) -> FloatArray:
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "iuf":
            raise TypeError
        return np.array(array, dtype=np.float64, order="C")
    except Exception as error:  # the object may raise anything
        raise InputError(field, value, remedy) from error


def _ids(field: str, value: Any, remedy: str, what: str = "node ids") -> IntArray:
    try:
        if np.ma.is_masked(value):
            raise TypeError("masked values")
        array = np.asarray(value)
    except Exception as error:  # the object may raise anything
        raise InputError(field, value, remedy) from error
    if array.size == 0:
        return np.zeros(array.shape, dtype=np.int64)
    if array.dtype.kind == "f" and not np.array_equal(array, np.clip(np.rint(array), -(2.0**53), 2.0**53)):
        raise InputError(field, value, f"{what} are whole numbers; {remedy}")
    if array.dtype.kind not in "iuf":
        raise InputError(field, value, remedy)
    return np.array(array, dtype=np.int64, order="C")


def _first(what: str, bad: IntArray, count: int, rows: IntArray | None = None) -> str:
    """Describe the wrong cells or nodes, the first one by number."""
    text = f"{what} {bad[0]}"
    if rows is not None:
        text += f" {rows[bad[0]].tolist()}"
    return text if len(bad) == 1 else f"{text} ({len(bad)} of {count} such)"
