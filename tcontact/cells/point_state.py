"""State of the quadrature points of a domain as numbers of the cells, for output and for the heat of other terms."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..device import arrays
from ..kernels.lanes import WIDTH
from ..planning.domain import CellBlock, Domain
from ..scene.body import Body
from ..scene.scene import Scene
from .internal_force import InternalForce


class PointState:
    """Reads the state of the points of every body, see kernels/language/point_memory.py; domain: all its cells."""

    def __init__(self, domain: Domain, force: InternalForce) -> None:
        self.domain, self.force = domain, force
        self._shapes = [shape_of(block) for block in domain.blocks]

    def of_block(self, number: int) -> np.ndarray:
        """Return a copy of the state [cells, points, numbers] of a block, its contact cells last."""
        block, (points, size) = self.domain.blocks[number], self._shapes[number]
        count, contact = block.count, len(block.contact)
        places = self.force.packs.memory_places
        memory = np.zeros(0) if self.force.memory is None else arrays.get(self.force.memory)
        parts = []
        for place, cells in ((places[number], count - contact), (places[len(self._shapes) + number], contact)):
            packs = -(-cells // WIDTH)
            stored = memory[place : place + packs * points * size * WIDTH].reshape(packs, points, size, WIDTH)
            parts.append(stored.transpose(0, 3, 1, 2).reshape(packs * WIDTH, points, size)[:cells])
        return np.concatenate(parts)

    def warming(self, number: int) -> np.ndarray:
        """Return where the temperature rises [cells, points] of a block of metal stand, its contact cells last."""
        from ..kernels.materials import LAWS

        block, (points, size) = self.domain.blocks[number], self._shapes[number]
        count, contact = block.count, len(block.contact)
        places, law = self.force.packs.memory_places, LAWS[block.material.law].plastic
        assert law is not None
        found = []
        for place, cells in ((places[number], count - contact), (places[len(self._shapes) + number], contact)):
            pack, lane = np.divmod(np.arange(cells)[:, None], WIDTH)
            found.append(place + ((pack * points + np.arange(points)) * size + law.warming) * WIDTH + lane)
        return np.concatenate(found)

    def cells_of(self, block: CellBlock) -> np.ndarray:
        """Return the cells [m] of the body, in the user's numbering, that a block has, its contact cells last."""
        return block.body.cell_order[block.own.first + block.order]

    def blocks_of_body(self, number: int) -> tuple[np.ndarray, ...]:
        """Return the state [cells, points, numbers] of every block of a body (`Body.blocks`), cells as in the mesh."""
        body = self.domain.bodies[number]
        return tuple(
            self.of_block(index)[np.argsort(self.cells_of(block))]
            for index, block in enumerate(self.domain.blocks)
            if block.body is body
        )

    def put_blocks_of_body(self, number: int, states: Sequence[np.ndarray]) -> None:
        """Set the state of every block of a body, as `blocks_of_body` returns it."""
        body, memory = self.domain.bodies[number], self.force.memory
        if memory is None:
            return
        values, places, left = np.array(arrays.get(memory)), self.force.packs.memory_places, iter(states)
        for index, block in enumerate(self.domain.blocks):
            if block.body is not body:
                continue
            state = next(left)[np.argsort(np.argsort(self.cells_of(block)))]
            _count, points, size = state.shape
            contact = len(state) - len(block.contact)
            for place, part in ((places[index], state[:contact]), (places[len(self._shapes) + index], state[contact:])):
                packs = -(-len(part) // WIDTH)
                # the lanes that fill up the last pack repeat its last cell
                rows = part[np.minimum(np.arange(packs * WIDTH), len(part) - 1)].reshape(packs, WIDTH, points, size)
                values[place : place + rows.size] = rows.transpose(0, 2, 3, 1).reshape(-1)
        arrays.set_values(memory, values)

    def strains_of_body(self, number: int) -> np.ndarray:
        """Return the largest plastic strain [cells] of the points of every cell of a body; NaN without plastic flow."""
        from ..kernels.materials import LAWS

        body = self.domain.bodies[number]
        result = np.full(body.body.mesh.cell_count, np.nan)
        for index, block in enumerate(self.domain.blocks):
            law = LAWS[block.material.law].plastic
            if block.body is body and law is not None:
                result[self.cells_of(block)] = self.of_block(index)[:, :, law.strain].max(axis=1)
        return result


def shape_of(block: CellBlock) -> tuple[int, int]:
    """Return the number of points of a cell of a block, and that of the numbers that each of them keeps."""
    from ..kernels.elements import FUNCTIONS
    from ..kernels.materials import LAWS

    return FUNCTIONS[block.variant].points, len(LAWS[block.material.law].state)


def has_state(scene: Scene) -> bool:
    """Return whether the points of some body keep a state."""
    from ..kernels.materials import LAWS

    return any(LAWS[material.law].state for body in scene.bodies for material in body.materials)


def metal_field(body: Body, name: str, states: Sequence[np.ndarray] | None) -> np.ndarray:
    """Return "plastic_strain" or "temperature" [K] of every cell [m] of a body; NaN where it has none.

    They are means of the points of a cell; states: see `PointState.blocks_of_body`, None: none is known.
    """
    from ..kernels.materials import LAWS

    result = np.full(body.mesh.cell_count, np.nan)
    for number, block in enumerate(body.blocks):
        plastic = LAWS[block.material.law].plastic
        if plastic is not None and states is not None:
            place, start = plastic.strain, 0.0
            if name == "temperature":
                place, start = plastic.warming, block.material.parameters[plastic.initial_temperature]
            result[block.numbers] = start + states[number][:, :, place].mean(axis=1)
    return result


def metal_fields(bodies: Sequence[Body], states: Sequence[Sequence[np.ndarray]]) -> dict[str, np.ndarray]:
    """Return `metal_field` of all bodies by name, stacked in order."""
    kept = list(zip(bodies, states, strict=True))
    names = ("plastic_strain", "temperature")
    return {name: np.concatenate([metal_field(body, name, own) for body, own in kept]) for name in names}
