"""Volume changes averaged at nodes of which several ranks have copies (kernels/cells/node_volumes.py).

    th_a = sum over the ranks, in their order, of the sum over their cells round the node of w_e V_e (J_e - 1) / V_a

Every rank averages over its own cells, with the volume V_a of those of all ranks, and the ranks add these parts up
before the force pass. A volume node belongs to one block of a body: ranks share it where both have cells of that block
there. The nodes of contact cells are on one rank alone, so that a static solve needs no message.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..device import arrays
from ..device.exchange import Exchange
from ..device.launch import Prepared
from ..device.team import Team
from ..kernels import volume_places as places
from ..planning.domain import Domain
from ..planning.node_volumes import node_shifts, node_volumes
from ..planning.partition.domain_part import DomainPart
from ..scene.cell_blocks import AVERAGED

if TYPE_CHECKING:
    from .internal_force import InternalForce

Key = tuple[int, str, str]  # of a block in all ranks: number of the body, kind, region


class SharedVolumes:
    """The volume nodes that the part of a rank shares with others, block by block; all ranks make it together."""

    def __init__(self, team: Team, part: DomainPart) -> None:
        self.team, self.part, self.domain = team, part, part.domain
        self.blocks = _averaged(part)
        shared: dict[int, np.ndarray] = dict(part.nodes_shared())
        mine: dict[Key, dict[int, np.ndarray]] = {}
        for key, number in self.blocks.items():
            inside = _inside(self.domain, number)
            mine[key] = {other: inside[nodes] for other, nodes in shared.items()}
        # other ranks may have no cells of a block at a node that both have
        told = [{key: own[other] for key, own in mine.items() if other in own} for other in range(team.size)]
        theirs = team.comm.alltoall(told)
        # by block, for every other rank, ascending, the nodes [k] in the order of both
        self.shared: dict[Key, list[tuple[int, np.ndarray]]] = {key: [] for key in self.blocks}
        for other, nodes in shared.items():
            for key in sorted(mine.keys() & theirs[other].keys()):
                both = mine[key][other] & theirs[other][key]
                if both.any():
                    self.shared[key].append((other, nodes[both]))

    def of_body(self, number: int) -> BodyVolumes:
        """Return what a body of the domain shares, in the user's numbering of its part."""
        first, plan = int(self.domain.node_start[number]), self.domain.bodies[number]
        assert self.domain.held is not None
        held = self.domain.held[first : first + plan.node_count][plan.place]
        adds: dict[tuple[str, str], Callable[[np.ndarray], None]] = {}
        for key, own in self.shared.items():
            if key[0] == self.part.there[number]:
                found = [(other, plan.node_order[nodes - first]) for other, nodes in own]
                adds[key[1], key[2]] = self.team.exchange(found, 1).add
        return BodyVolumes(held, adds)


class BodyVolumes:
    """What a rank shares of a body.

    held [n]: nodes that are no volume nodes; adds: of every block, by kind and region, what adds the parts of all ranks
    to values [n, 1] at the nodes, in place.
    """

    def __init__(self, held: np.ndarray, adds: dict[tuple[str, str], Callable[[np.ndarray], None]]) -> None:
        self.held, self._adds = held, adds

    def add(self, kind: str, region: str | None, values: np.ndarray) -> None:
        """Add the parts of all ranks to values [n] at the volume nodes of a block."""
        self._adds[kind, region or ""](values.reshape(-1, 1))


class ForceVolumes:
    """Averages the volume changes of a force pass over the cells of all ranks."""

    def __init__(self, force: InternalForce, shared: SharedVolumes) -> None:
        from ..kernels.language.signatures import signature_of
        from ..kernels.step.internal_force import make_volumes

        kernel = make_volumes(shared.domain.kinds, signature_of({"body": force.bundle()}))
        self._kernel, self._values = Prepared(kernel), force.volumes
        self._exchange = _of_force(force, shared)
        self._share_volumes(arrays.get(force.volume_lists))

    def _share_volumes(self, lists: np.ndarray) -> None:
        """Put the inverse volumes of the nodes on all ranks into the place of those of the cells of this one."""
        values = arrays.get(self._values)
        count, first, changes = lists[places.COUNT], lists[places.INVERSES], lists[places.CHANGES]
        number = changes + lists[lists[places.NUMBERS] :][:count]
        values[number] = 1.0 / values[first : first + count]
        self._exchange.add(values.reshape(-1, 1))
        values[first : first + count] = 1.0 / values[number]
        values[number] = 0.0

    def average(self, end: int, given: tuple[Any, ...]) -> None:
        """Average over the cells of chunks 0..end, and those of other chunks as they stand, of all ranks."""
        self._kernel(0, end, *given)
        self._exchange.add(arrays.get(self._values).reshape(-1, 1))


def _averaged(part: DomainPart) -> dict[Key, int]:
    """Return the numbers of the blocks of a part that are averaged, by the key that they have on all ranks."""
    found = {}
    for number, block in enumerate(part.domain.blocks):
        own = block.own.own
        if own.formulation == AVERAGED:
            body = next(n for n, body in zip(part.there, part.domain.bodies, strict=True) if body is block.body)
            found[body, own.kind, own.region or ""] = number
    return dict(sorted(found.items()))


def _inside(domain: Domain, number: int) -> np.ndarray:
    """Return which nodes [n] of a domain are volume nodes of a block."""
    cells, count = domain.blocks[number].cells, len(domain.reference)
    assert domain.held is not None
    nodes = node_volumes(domain.reference, cells, domain.held, None).nodes
    return np.bincount(nodes[nodes >= 0], minlength=count) > 0


def _of_force(force: InternalForce, shared: SharedVolumes) -> Exchange:
    """Return the exchange of the averages, by their places in the volumes of a force pass."""
    lists, found = arrays.get(force.volume_lists), dict[int, list[np.ndarray]]()
    shift, _ = node_shifts(shared.domain)
    for key, number in shared.blocks.items():
        for other, nodes in shared.shared[key]:
            found.setdefault(other, []).append(lists[places.CHANGES] + shift[number] + nodes)
    return shared.team.exchange([(other, np.concatenate(found[other])) for other in sorted(found)], 1)
