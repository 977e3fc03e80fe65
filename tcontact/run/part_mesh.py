"""The mesh of what one rank has of all bodies, as its part of the result file has it (results/files/part_file.py)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..device.team import Team
from ..mesh.geometry import chunks_of
from ..planning.node_order import inverse
from ..planning.partition.body_part import BodyPart
from ..planning.partition.domain_part import DomainPart
from ..results.files.part_file import PartMesh
from ..results.files.part_places import PartPlace
from ..scene.scene import Scene


class RankMesh:
    """What a rank has of all bodies, one after the other; all ranks make theirs together.

    numbers: those of the bodies of which it has nodes; order [n]: nodes of its meshes as the part has them, first those
    that it owns; mesh: that of the part.
    """

    def __init__(self, team: Team, scene: Scene, parts: Sequence[DomainPart]) -> None:
        bodies = {
            part.whole.numbers[number]: part.bodies[number] for part in parts for number in range(len(part.bodies))
        }
        self.numbers = [number for number in sorted(bodies) if len(bodies[number].nodes)]
        mine = [bodies[number] for number in self.numbers]
        meshes = [scene.bodies[number].mesh for number in range(len(scene.bodies))]
        node_starts = np.cumsum([0, *(mesh.node_count for mesh in meshes)])
        cell_starts = np.cumsum([0, *(mesh.cell_count for mesh in meshes)])
        nodes = np.concatenate([node_starts[n] + bodies[n].part.nodes for n in self.numbers])
        cells = np.concatenate([cell_starts[n] + bodies[n].part.cells for n in self.numbers])
        owned = np.concatenate([one.part.owner == team.rank for one in mine])
        self.order = np.concatenate([np.flatnonzero(owned), np.flatnonzero(~owned)])
        blocks, points = [], np.empty((len(nodes), 3))
        place, first = inverse(self.order), 0
        for one in mine:
            mesh, last = one.plan.body.mesh, first + len(one.nodes)
            points[place[first:last]] = mesh.nodes
            blocks += [(kind, _renumbered(place[first:last], rows)) for kind, rows in mesh.blocks if len(rows)]
            mesh.release()
            first = last
        corners = sum(rows.size for _, rows in blocks)
        sizes = team.gathered(np.array([owned.sum(), corners])).astype(np.int64)
        shown = np.full(len(nodes), -1, dtype=np.int64)
        shown[owned] = sizes[: team.rank, 0].sum() + np.arange(owned.sum())
        _complete(team, shown, [bodies[number] for number in sorted(bodies)])
        self.mesh = PartMesh(
            place=PartPlace(nodes[self.order], int(owned.sum()), cells),
            points=points,
            blocks=blocks,
            shown=shown[self.order],
            corner=int(sizes[: team.rank, 1].sum()),
        )


def _renumbered(place: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Return the cells [m, corners] with nodes by their places [n]."""
    result = np.empty(cells.shape, dtype=np.int64)
    for part in chunks_of(len(cells)):
        result[part] = place[cells[part]]
    return result


def _complete(team: Team, shown: np.ndarray, bodies: Sequence[BodyPart]) -> None:
    """Put the numbers of nodes that other ranks own into `shown` [n], -1 so far; bodies: parts of all of them."""
    common: dict[int, list[np.ndarray]] = {}
    first = 0
    for one in bodies:
        for other, places in one.part.shared:
            common.setdefault(other, []).append(first + places)
        first += len(one.part.nodes)
    joint = {other: np.concatenate(found) for other, found in common.items()}
    sent = [shown[joint[other]] if other in joint else None for other in range(team.size)]
    for other, received in enumerate(team.comm.alltoall(sent)):
        if received is not None:
            there = received >= 0
            shown[joint[other][there]] = received[there]
