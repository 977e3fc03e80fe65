"""Cut second-order cells and faces of mesh files down to their corners, which stand first in every format."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np

from ...base.warning_kinds import MeshWarning, warn
from ..geometry import IntArray
from .content import KINDS, FileMesh

CORNERS = {"line": 2, "triangle": 3, "quad": 4, "tetra": 4, "hexahedron": 8, "wedge": 6}
SECOND_ORDER = {  # meshio's words
    "line3": "line",
    "triangle6": "triangle",
    "triangle7": "triangle",
    "quad8": "quad",
    "quad9": "quad",
    "tetra10": "tetra",
    "hexahedron20": "hexahedron",
    "hexahedron24": "hexahedron",
    "hexahedron27": "hexahedron",
    "wedge12": "wedge",
    "wedge15": "wedge",
    "wedge18": "wedge",
}
FACE_CORNERS = {6: 3, 7: 3, 8: 4, 9: 4}  # nodes of a face of second order -> its corners


def first_order(content: FileMesh, kind: str | None) -> FileMesh:
    """Return the content with cells and faces cut down to their corners; warn of the nodes of volume cells dropped.

    kind: of the volume cells that are used, None for all.
    """
    if not any(name in SECOND_ORDER for name, _ in content.blocks):
        return content
    blocks: list[tuple[str, IntArray]] = []
    used: list[IntArray] = []
    middle: list[IntArray] = []
    counts: Counter[str] = Counter()
    for name, rows in content.blocks:
        first = SECOND_ORDER.get(name, name)
        corners = rows[:, : CORNERS.get(first)]
        blocks.append((first, corners))
        if first in KINDS and kind in (None, KINDS[first]):
            used.append(corners.reshape(-1))
            middle.append(rows[:, CORNERS[first] :].reshape(-1))
            counts[name] += len(rows) if name in SECOND_ORDER else 0
    if counts.total():
        dropped = len(np.setdiff1d(np.concatenate(middle), np.concatenate(used)))
        cells = " and ".join(f"{count} {name}" for name, count in counts.items() if count)
        text = f"second-order cells ({cells}) are read as those of first order: {dropped} mid-side nodes were dropped"
        warn(f"{text}, and curved edges are straight now; a finer mesh of first order is more accurate", MeshWarning)
    faces = {
        name: [rows[:, : FACE_CORNERS.get(rows.shape[1])] for rows in parts]
        for name, parts in content.face_sets.items()
    }
    return replace(content, blocks=blocks, face_sets=faces)
