"""Bytes that the cells and nodes of a domain take on a GPU, counted before anything is allocated.

A device that runs thread per cell (tcontact/cells/device_force.py) keeps a place for the force of every corner of every
cell and for every node the places of its corners, and no force rows; the state stands there twice, since a block of
steps may have to be taken again (tcontact/schemes/explicit/device_step.py).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from ..kernels import lanes
from ..kernels.columns import NODE_SUMS, cell_groups, group_size
from .cell_shapes import STORED
from .domain import Domain
from .packing import WIDTH

REAL, WHOLE = 8, 4  # bytes of a number
SEARCHED, KEPT = 5, 20  # vectors of the search for the stable step, and vectors that it keeps in 16 bits
DAMPED = 4  # further vectors of the search with viscous contact cells, which keeps as many in 32 bits
PLACES = 2**31 - 1  # numbers of an array: the kernels count them in 32 bits


@dataclass(frozen=True)
class Cells:
    """Cells that are packed together: their number, corners, stored numbers of shape, and of state of the points."""

    count: int
    corners: int
    shape: int
    state: int

    @property
    def lanes(self) -> int:
        """Their number with the lanes that fill up the last pack."""
        return -(-self.count // WIDTH) * WIDTH


@dataclass(frozen=True)
class DeviceSize:
    """Bytes on a device, by what they are for.

    force: cells, their forces and what belongs to nodes; state: displacement and velocity; kept: the state at the start
    of a block; search: for the stable step; transfer: the largest copy; places: numbers of the largest array.
    """

    force: int
    state: int
    kept: int
    search: int
    transfer: int
    places: int

    @property
    def total(self) -> int:
        """All of them: what a run takes at most."""
        return self.force + self.state + self.kept + self.search + self.transfer


def device_size(cells: Sequence[Cells], nodes: int, plastic: bool = False, viscous: bool = False) -> DeviceSize:
    """Return what cells and nodes take; plastic: some of the cells flow; viscous: there are viscous contact cells."""
    corners = sum(part.lanes * part.corners for part in cells)
    own = sum(part.count * part.corners for part in cells)
    shapes = sum(part.lanes * part.shape for part in cells)
    memory = sum(part.lanes * part.state for part in cells)
    position = 3 * nodes if shapes == 0 else -(-3 * nodes // WIDTH) * WIDTH + shapes
    numbers, threads = NODE_SUMS + group_size(*cell_groups(False, plastic)), threads_of(cells, nodes)
    ledger = lanes.DEVICE_ROWS * numbers * (threads // lanes.FOLD + lanes.FOLD + 1)
    wholes = corners + nodes + (nodes + 1 + own)  # connectivity, numbers of the nodes, corners of the nodes
    reals = position + nodes + memory + 3 * corners + numbers * threads + ledger
    search = SEARCHED * 3 * REAL * nodes + KEPT * WHOLE * -(-3 * nodes // 2) + 3 * REAL * threads
    if viscous:
        search += (DAMPED * REAL + KEPT * WHOLE) * 3 * nodes + 4 * REAL * threads
    largest = max(REAL * max(position, 3 * nodes), WHOLE * (nodes + 1 + own), WHOLE * corners, REAL * ledger)
    return DeviceSize(
        force=REAL * reals + WHOLE * wholes,
        state=2 * 3 * REAL * nodes,
        kept=(2 * 3 * nodes + memory) * REAL,
        search=search,
        transfer=max(largest, REAL * memory),
        places=max(3 * corners, position, memory),
    )


def threads_of(cells: Iterable[Cells], nodes: int) -> int:
    """Return the threads of each loop, see `device_threads`."""
    wanted = max(sum(part.lanes for part in cells), nodes, lanes.FEWEST_THREADS)
    return min(1 << (wanted - 1).bit_length(), lanes.MOST_THREADS)


def cells_of(domain: Domain, state: Mapping[tuple[str, str], int] | None = None) -> list[Cells]:
    """Return the cells of a domain, for every block the ordinary and the contact cells.

    state: numbers that the points of a cell keep, by element and law; None: none.
    """
    found = []
    for block in domain.blocks:
        corners, shape = block.own.cells.shape[1], STORED.get(block.variant, 0)
        kept = 0 if state is None else state.get(block.kind, 0)
        counts = (block.count - len(block.contact), len(block.contact))
        found += [Cells(count, corners, shape, kept) for count in counts if count]
    return found
