"""Where the parts of the ranks lie that a result file shows as one mesh, and how their meshes and fields join.

A run on several ranks leaves a file of each rank in the folder `result-parts`, beside the result file. A part is a
result file of its own: of the cells of its rank and of all their nodes, first those that the rank owns. It says in
`/tcontact/part` which numbers these have in the mesh of the user.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ...mesh.elements import ELEMENTS

FOLDER = "result-parts"


def part_name(rank: int) -> str:
    """Return the name of the part of a rank relative to the result file."""
    return f"{FOLDER}/{rank}.vtkhdf"


def part_path(result: Path, rank: int) -> Path:
    """Return the file of the part of a rank; result: the result file."""
    return result.parent / part_name(rank)


@dataclass(frozen=True, eq=False)
class PartPlace:
    """Numbers of the nodes and cells of a part in the mesh of the user.

    nodes [n]: of every node of the part; owned: number of the first ones, which the rank owns; cells [m].
    """

    nodes: np.ndarray
    owned: int
    cells: np.ndarray


Blocks = Sequence[tuple[str, np.ndarray]]


def joined_mesh(
    parts: Sequence[tuple[PartPlace, np.ndarray, Blocks]],
) -> tuple[np.ndarray, tuple[tuple[str, np.ndarray], ...]]:
    """Return points [n, 3] and blocks of the whole mesh in the user's numbering; parts: place, points and blocks.

    Raises `ValueError` if the parts are not those of one mesh.
    """
    count = sum(len(place.cells) for place, _, _ in parts)
    points = assembled([place.nodes[: place.owned] for place, _, _ in parts], [p[: at.owned] for at, p, _ in parts])
    kinds, corners = np.empty(count, dtype=np.int64), np.zeros(count, dtype=np.int64)
    names = list(ELEMENTS)
    width = max(cells.shape[1] for _, _, blocks in parts for _, cells in blocks)
    rows = np.zeros((count, width), dtype=np.int64)
    everyone = np.concatenate([place.cells for place, _, _ in parts])
    if not np.array_equal(np.sort(everyone), np.arange(count)):
        raise ValueError("the cells of the parts are not those of one mesh")
    for place, _, blocks in parts:
        first = 0
        for kind, cells in blocks:
            at = place.cells[first : first + len(cells)]
            kinds[at], corners[at] = names.index(kind), cells.shape[1]
            rows[at, : cells.shape[1]] = place.nodes[cells]
            first += len(cells)
    cuts = np.concatenate([[0], np.flatnonzero(np.diff(kinds)) + 1, [count]])
    spans = pairwise(cuts)
    return points, tuple((names[kinds[a]], np.ascontiguousarray(rows[a:b, : corners[a]])) for a, b in spans)


def assembled(numbers: Sequence[np.ndarray], values: Sequence[np.ndarray]) -> Any:
    """Return values [n, ..] of which every part has those of these numbers. Raises `ValueError` if some are missing."""
    count = sum(map(len, numbers))
    result = np.empty((count, *values[0].shape[1:]), dtype=values[0].dtype)
    there = np.zeros(count, dtype=bool)
    for at, own in zip(numbers, values, strict=True):
        if len(at) and (at.min() < 0 or at.max() >= count):
            raise ValueError("the nodes of the parts are not those of one mesh")
        result[at], there[at] = own, True
    if not there.all():
        raise ValueError("the nodes of the parts are not those of one mesh")
    return result
