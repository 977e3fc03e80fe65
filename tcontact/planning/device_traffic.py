"""Bytes that a step moves between the memory of a GPU and its processors, counted from the arrays of its kernels.

Every array that a launch touches is read or written once in it (kernels/step/device_step.py): values that several
threads need are taken to stay in the caches within a launch, and nothing stays there from launch to launch.

    cells   read   connectivity, displacement, positions or stored shapes, state of the points
            write  corner forces, state of the points, sums of the threads
    nodes   read   places of corners, corner forces, mass, displacement, velocity, sums of the threads
            write  displacement, velocity, sums of the threads
    once in a block of rows: state read and written, as it is kept
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ..kernels import lanes
from ..kernels.columns import NODE_SUMS, cell_groups, group_size
from .device_memory import REAL, WHOLE, Cells, threads_of


class Traffic(NamedTuple):
    """Bytes of a step, by launch: read and written by the cells, by the nodes, and the share of keeping the state."""

    cells_read: float
    cells_written: float
    nodes_read: float
    nodes_written: float
    kept: float

    @property
    def read(self) -> float:
        """All bytes read."""
        return self.cells_read + self.nodes_read + 0.5 * self.kept

    @property
    def written(self) -> float:
        """All bytes written."""
        return self.cells_written + self.nodes_written + 0.5 * self.kept


def traffic(cells: Sequence[Cells], nodes: int, plastic: bool = False) -> Traffic:
    """Return the bytes of a step of a domain of ordinary nodes; plastic: some of its cells flow."""
    corners = sum(part.lanes * part.corners for part in cells)
    own = sum(part.count * part.corners for part in cells)
    memory = REAL * sum(part.lanes * part.state for part in cells)
    shapes = REAL * sum(part.lanes * part.shape for part in cells)
    placed = 3 * REAL * nodes if any(part.shape == 0 for part in cells) else 0
    state, forces = 6 * REAL * nodes, 3 * REAL * corners
    threads, of_cells = threads_of(cells, nodes), group_size(*cell_groups(False, plastic))
    node_sums, cell_sums = REAL * NODE_SUMS * threads, REAL * of_cells * threads
    return Traffic(
        cells_read=WHOLE * corners + 3 * REAL * nodes + placed + shapes + memory + node_sums,
        cells_written=forces + memory + cell_sums,
        nodes_read=WHOLE * (nodes + 1 + own) + 3 * REAL * own + REAL * nodes + state + cell_sums,
        nodes_written=state + node_sums,
        kept=2.0 * (state + memory) / lanes.DEVICE_ROWS,
    )
