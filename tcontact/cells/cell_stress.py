"""Cauchy stress of the cells of a body with the pressure that they have, for probes, maxima and frames."""

from __future__ import annotations

import numpy as np

from ..device import arrays
from ..device.launch import Prepared
from ..planning.node_volumes import NodeVolumes, held_nodes, node_volumes
from ..planning.packing import WIDTH, pack_cells
from ..scene.body import Body
from ..scene.cell_blocks import AVERAGED, BodyBlock
from .shared_volumes import BodyVolumes
from .stress import States, packed, shown_parameters

AVERAGES = 6  # numbers of a cell averaged at nodes, see kernels/cells/cell_stress.py
VON_MISES = 6  # place of the von Mises norm, behind the six components
NUMBERS = 7


def pressure_of(stress: np.ndarray) -> np.ndarray:
    """Return the pressure [...] [Pa], positive in compression, of stresses [..., 6 or more]."""
    return (stress[..., 0] + stress[..., 1] + stress[..., 2]) * (-1.0 / 3.0)


class CellStress:
    """Computes the stress of all cells of a body at up to `rows` displacements in one launch.

    It is made only where it is shown, and keeps 56 bytes a cell and 24 a node for each row. Taichi must be running.
    """

    def __init__(self, body: Body, rows: int = 1, shared: BodyVolumes | None = None) -> None:
        """Prepare for the cells of a body; shared: what the part of a rank shares with others, which call it alike."""
        self._count = body.mesh.cell_count
        self._position = arrays.put(body.mesh.nodes)
        self._u = arrays.zeros(rows * 3 * body.mesh.node_count)
        self._parts = [_Part(body, block, rows, shared) for block in body.blocks]

    def __call__(self, displacement: np.ndarray, states: States = None) -> np.ndarray:
        """Return six components of the stress and its von Mises norm [rows, m, 7] [Pa] of all cells.

        displacement [rows, n, 3] [m] of the user; states: see `VonMises`. Components in the order xx, yy, zz, xy, yz,
        xz.
        """
        arrays.set_values(self._u, displacement)
        result = np.empty((len(displacement), self._count, NUMBERS))
        for number, part in enumerate(self._parts):
            if states is not None and states[number].size:
                part.recall(states[number])
            result[:, part.block.numbers] = part.stress(len(displacement), self._position, self._u)
        return result

    def owned(self) -> list[arrays.Array]:
        """Return its arrays."""
        return [self._position, self._u, *(array for part in self._parts for array in part.owned())]


class _Part:
    """The cells of one block, packed."""

    def __init__(self, body: Body, block: BodyBlock, rows: int, shared: BodyVolumes | None) -> None:
        from ..kernels.cells.cell_stress import make_cell_stress
        from ..kernels.elements import FUNCTIONS
        from ..kernels.materials import LAWS

        packs = pack_cells(block.cells, body.mesh.node_count, WIDTH)
        self.block, self._packs = block, packs.lanes // WIDTH
        numbers = FUNCTIONS[block.element].points * len(LAWS[block.material.law].state)
        self._averages = _Averages(body, block, shared) if block.formulation == AVERAGED else None
        self._cells = arrays.share(packs.connectivity)
        self._parameters = arrays.put(np.array(shown_parameters(block)))
        self._memory = arrays.zeros(packs.lanes * numbers)
        self._averaged = arrays.zeros(0 if self._averages is None else rows * packs.lanes * AVERAGES)
        self._out = arrays.zeros(rows * packs.lanes * NUMBERS)
        self._kernel = Prepared(make_cell_stress(block.element, block.material.law))

    def recall(self, state: np.ndarray) -> None:
        """Take the state [cells, points, numbers] of its cells for all that follows."""
        arrays.set_values(self._memory, packed(state))

    def stress(self, rows: int, position: arrays.Array, u: arrays.Array) -> np.ndarray:
        """Return the numbers [rows, cells, NUMBERS] of its cells; u [rows, 3n]: see `CellStress`."""
        if self._averages is not None:
            arrays.set_values(self._averaged, self._averages(rows, self._cells, position, u))
        self._kernel(rows, self._cells, position, self._parameters, u, self._memory, self._averaged, self._out)
        found = arrays.get(self._out)[: rows * self._packs * NUMBERS * WIDTH]
        lanes = found.reshape(rows, self._packs, NUMBERS, WIDTH).transpose(0, 1, 3, 2)
        return lanes.reshape(rows, -1, NUMBERS)[:, : self.block.count]

    def owned(self) -> list[arrays.Array]:
        """Return its arrays."""
        return [self._cells, self._parameters, self._memory, self._averaged, self._out]


class _Averages:
    """Volume changes of the cells of a block, averaged at the nodes (elements/tet4_node_averaged.py)."""

    def __init__(self, body: Body, block: BodyBlock, shared: BodyVolumes | None) -> None:
        from ..kernels.cells.cell_stress import make_volume_change

        master = None if body.images is None else body.images.master
        held = held_nodes(body) if shared is None else shared.held
        self._own: NodeVolumes = node_volumes(body.mesh.nodes, block.cells, held, master)
        self._block, self._shared = block, shared
        self._count = body.mesh.node_count
        total = self._of_all_ranks(self._own.totals(self._count))
        self._inverse = np.where(total > 0.0, 1.0 / np.where(total > 0.0, total, 1.0), 0.0)
        self._change: arrays.Array = None
        self._kernel = Prepared(make_volume_change(block.element, block.material.law))

    def __call__(self, rows: int, cells: arrays.Array, position: arrays.Array, u: arrays.Array) -> np.ndarray:
        """Return w_e, J_a - 1 of the corners and J - 1 of every cell, packed [rows, packs, AVERAGES, WIDTH]."""
        own, count = self._own, len(self._own.shares)
        lanes = -(-count // WIDTH) * WIDTH
        if self._change is None or arrays.get(self._change).size < rows * lanes:
            self._change = arrays.zeros(rows * lanes)
        self._kernel(rows, cells, position, u, self._change)
        result = np.zeros((rows, AVERAGES, lanes))
        there = own.nodes >= 0
        for row, change in enumerate(arrays.get(self._change)[: rows * lanes].reshape(rows, lanes)[:, :count]):
            part = np.broadcast_to((own.shares * change)[:, None], own.nodes.shape)
            mean = self._of_all_ranks(np.bincount(own.nodes[there], part[there], self._count)) * self._inverse
            result[row, 0, :count] = own.shares
            result[row, 1:5, :count] = np.where(there, mean[own.nodes], 0.0).T
            result[row, 5, :count] = change / own.volumes
        return result.reshape(rows, AVERAGES, -1, WIDTH).transpose(0, 2, 1, 3)

    def _of_all_ranks(self, values: np.ndarray) -> np.ndarray:
        """Add the parts of other ranks to values [n] at the nodes, and return them."""
        if self._shared is not None:
            self._shared.add(self._block.kind, self._block.region, values)
        return values
