"""Take a part of a mesh: some of its cells, with the nodes, faces and sets that belong to them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .elements import face_corners
from .geometry import Blocks, FloatArray, IntArray, cell_face_keys, face_keys

Sets = Mapping[str, IntArray]


def part_of(
    nodes: FloatArray, blocks: Blocks, node_sets: Sets, face_sets: Sets, cell_sets: Sets, chosen: IntArray
) -> dict[str, Any]:
    """Return the arguments of `Mesh` for the cells of these numbers, ascending; numbers close up, empty sets go."""
    cells, first = {}, 0
    for kind, rows in blocks:
        mine = chosen[(chosen >= first) & (chosen < first + len(rows))] - first
        first += len(rows)
        if len(mine):
            cells[kind] = rows[mine]
    used = np.unique(np.concatenate([rows.reshape(-1) for rows in cells.values()]))
    number = np.full(len(nodes), -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    keys = np.concatenate([cell_face_keys(rows, kind, len(nodes)) for kind, rows in cells.items()])
    place = np.full(first, -1, dtype=np.int64)
    place[chosen] = np.arange(len(chosen))
    sets = {
        "node_sets": {name: number[ids][number[ids] >= 0] for name, ids in node_sets.items()},
        "face_sets": {
            name: number[faces[np.isin(face_keys(faces, len(nodes)), keys)]] for name, faces in face_sets.items()
        },
        "cell_sets": {name: place[ids][place[ids] >= 0] for name, ids in cell_sets.items()},
    }
    kept = {group: {name: ids for name, ids in given.items() if len(ids)} for group, given in sets.items()}
    if len(cells) > 1:
        return {"nodes": nodes[used], "cells": {kind: number[rows] for kind, rows in cells.items()}, **kept}
    kind, rows = next(iter(cells.items()))
    if len(blocks) > 1:  # triangles of a mesh of several kinds have a corner twice
        corners = face_corners(kind)[-1]
        kept["face_sets"] = {name: faces[:, :corners] for name, faces in kept["face_sets"].items()}
    return {"nodes": nodes[used], "cells": number[rows], "kind": kind, **kept}
