"""Von Mises stress of a body, one value per cell: at its centre, of metals the mean of the points of the cell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..base.errors import InputError
from ..device import arrays
from ..device.launch import Prepared
from ..planning.packing import WIDTH, pack_cells
from ..scene.body import Body
from ..scene.cell_blocks import AVERAGED, BodyBlock

States = Sequence[np.ndarray] | None  # of every block of a body: numbers [cells, points, numbers of a point]


class VonMises:
    """Computes the von Mises norm of the Cauchy stress of a body for any displacement.

    It is made only where it is shown: it compiles its own kernel and keeps connectivity, positions, displacement and
    result, 24 (tet4), 32 (wedge6) or 40 (hex8) bytes a cell and 48 a node, and the state of the points. Taichi must be
    running (`runtime.start`). Raises `InputError` for a law that the kernels do not have.
    """

    def __init__(self, body: Body, order: np.ndarray | None = None) -> None:
        """Prepare for displacements in an order of the nodes [n] of the body; None: their own."""
        from ..kernels.cells.von_mises import make_von_mises
        from ..kernels.elements import FUNCTIONS
        from ..kernels.materials import LAWS

        mesh = body.mesh
        for material in body.materials:
            law = material.law
            if law not in LAWS:
                raise InputError("material.law", law, f"the kernels know {', '.join(LAWS)}")
        self._blocks = body.blocks
        self._position = arrays.put(mesh.nodes if order is None else mesh.nodes[order])
        place = None if order is None else np.argsort(order)
        self._u = arrays.zeros(3 * mesh.node_count)
        self._whole = np.zeros(mesh.cell_count if len(body.blocks) > 1 else 0)
        kernels = {(block.element, block.material.law): None for block in body.blocks}
        self._kernels = {kind: Prepared(make_von_mises(*kind)) for kind in kernels}
        self._data = []
        for block in body.blocks:
            cells = block.cells if place is None else place[block.cells]
            packs = pack_cells(cells, mesh.node_count, WIDTH)
            numbers, law = shown_parameters(block), LAWS[block.material.law]
            if block.formulation == AVERAGED:  # the pressure of a single cell is no result, and large near poisson 1/2
                numbers[0] = 0.0
            state = arrays.zeros(packs.lanes * FUNCTIONS[block.element].points * len(law.state))
            self._data.append(
                (arrays.share(packs.connectivity), arrays.put(np.array(numbers)), state, arrays.zeros(packs.lanes))
            )

    def __call__(self, displacement: np.ndarray, states: States = None) -> np.ndarray:
        """Return the stress [m] [Pa] at a displacement [n, 3] [m]; the next call overwrites it.

        states: of the points of the cells of every block (`PointState.blocks_of_body`), for laws that have one; None:
        that of the call before, first that of the start.
        """
        arrays.set_values(self._u, displacement)
        for number, (block, data) in enumerate(zip(self._blocks, self._data, strict=True)):
            connectivity, parameters, memory, stress = data
            if states is not None and states[number].size:
                arrays.set_values(memory, packed(states[number]))
            kernel = self._kernels[block.element, block.material.law]
            kernel(connectivity, self._position, parameters, self._u, memory, stress)
            found = arrays.get(stress)[: block.count]
            if len(self._blocks) == 1:
                return found
            self._whole[block.numbers] = found
        return self._whole


def shown_parameters(block: BodyBlock) -> list[float]:
    """Return the parameters of the law of a block with which the stress of the state as it stands is computed."""
    from ..kernels.materials import LAWS
    from ..kernels.materials.law import HIGH

    numbers, law = [*block.material.parameters], LAWS[block.material.law]
    if law.plastic is not None:
        numbers[law.plastic.strength] = HIGH
        numbers += [0.0] * law.rates
    return numbers


def packed(state: np.ndarray) -> np.ndarray:
    """Return the state [cells, points, numbers] as [packs, points, numbers, WIDTH], filled up with zeros."""
    packs = -(-len(state) // WIDTH)
    padded = np.zeros((packs * WIDTH, *state.shape[1:]))
    padded[: len(state)] = state
    return padded.reshape(packs, WIDTH, *state.shape[1:]).transpose(0, 2, 3, 1)
