"""Heat between friction layers and the cells behind them: what leaves a layer through its far end warms the cells.

    T_far,s = sum w_sc T_c,   Q_c = sum w_sc Q_s,   T_c += Q_c / C_c,   C = rho c V,   w_sc = C_c / sum of C around s

T_c is the mean temperature of the points of cell c, all of which become warmer by the same. The second side of a layer
of a slave k has the masters of its row behind it, with the weights |P_km| / sum |P_km|; a slave that has left the other
body keeps the last ones. Cells keep a temperature if their material is an `ElastoPlastic` with a specific heat.
"""

from __future__ import annotations

import numpy as np

from ..cells.internal_force import InternalForce
from ..cells.point_state import PointState
from ..device import arrays
from ..kernels import pair_places as at
from ..kernels.lanes import WIDTH
from ..planning.domain import Domain
from ..scene.metals import ElastoPlastic, MieGrueneisen
from .node_layers import NodeLayers
from .pairs.pair_contact import PairContact


class HeatExchange:
    """The cells around the boundary nodes [s] of a domain, of which the first are the contact nodes [k].

    given [k] [J]: heat that the layers of the contact nodes gave to the cells so far; last [k] [J]: of the last step.
    """

    def __init__(self, domain: Domain, force: InternalForce, layers: NodeLayers, pairs: PairContact | None) -> None:
        assert domain.contact is not None
        self._force, self._layers, self._pairs = force, layers, pairs
        self.given, self.last = (np.zeros(len(domain.contact.nodes)) for _ in range(2))
        self._find_cells(domain, force)
        self._rebuilds = -1
        # the slave, the master and the weight of every entry of the rows
        self._slaves, self._masters = (np.zeros(0, dtype=np.int64) for _ in range(2))
        self._weights = np.zeros(0)

    def _find_cells(self, domain: Domain, force: InternalForce) -> None:
        """Find the cells around every boundary node, their volumes, and where their temperatures stand."""
        slot = np.full(len(domain.reference), -1)
        slot[domain.boundary] = np.arange(len(domain.boundary))
        points = PointState(domain, force)
        nodes, cells, places, capacities, starts, pressed, count = [], [], [], [], [], [], 0
        for number, block in enumerate(domain.blocks):
            metal = block.material
            if not isinstance(metal, ElastoPlastic) or metal.specific_heat is None:
                continue
            corners = slot[block.cells if domain.images is None else domain.images.master[block.cells]]
            near = np.flatnonzero((corners >= 0).any(axis=1))
            cell, corner = np.nonzero(corners[near] >= 0)
            nodes.append(corners[near][cell, corner])
            cells.append(count + cell)
            volume = block.body.body.mesh.cell_volumes()[points.cells_of(block)[near]]
            capacities.append(metal.density * metal.specific_heat * volume)
            found = points.warming(number)[near]
            places.append((np.repeat(count + np.arange(len(near)), found.shape[1]), found.reshape(-1)))
            starts.append(np.full(len(near), metal.initial_temperature))
            pressed.append(np.full(found.size, isinstance(metal.pressure, MieGrueneisen)))
            count += len(near)
        self._nodes, self._cells = np.concatenate(nodes), np.concatenate(cells)
        self._cell_of_place, self._places = (np.concatenate(part) for part in zip(*places, strict=True))
        self._capacity, self._start = np.concatenate(capacities), np.concatenate(starts)
        self._pressed = np.concatenate(pressed)  # places of points whose heat has a pressure
        self._points = np.bincount(self._cell_of_place, minlength=count)
        size = self._capacity[self._cells]
        self._shares = size / np.bincount(self._nodes, size, len(domain.boundary))[self._nodes]

    def temperature(self) -> np.ndarray:
        """Return the mean temperature [s] [K] of the cells around every boundary node, 0 where none keeps one."""
        rise = arrays.get(self._force.memory)[self._places]
        cells = self._start + np.bincount(self._cell_of_place, rise, len(self._start)) / self._points
        return np.bincount(self._nodes, self._shares * cells[self._cells], self._node_count)

    @property
    def _node_count(self) -> int:
        return len(arrays.get(self._force.special_force)) // 3

    def set_far_ends(self, pressed: np.ndarray) -> None:
        """Set the temperatures beyond the far ends of all layers to those of the cells there.

        pressed [k]: the nodes in contact; layers that meet it for the first time take these temperatures as a whole.
        """
        self._read_rows()
        around = self.temperature()
        beyond = np.bincount(self._slaves, self._weights * around[self._masters], len(self.given))
        layers = self._layers
        for number, (kind, batch, nodes) in enumerate(zip(layers.kinds, layers.batches, layers.nodes, strict=True)):
            found = np.tile(batch.start_temperatures, (len(nodes), 1))
            for side, is_open in enumerate(kind.open_ends):
                if is_open:
                    far = (around, beyond)[side][nodes]
                    found[:, side] = np.where(far > 0.0, far, found[:, side])
                    batch.set_far_temperature(found[:, side], side)
            new = np.flatnonzero(pressed[nodes] & (layers.used[nodes] == number) & (batch.cell("WARM") == 0.0))
            if any(kind.open_ends) and len(new):
                batch.start_at(new, found[new])

    def give(self, areas: np.ndarray, before: list[np.ndarray]) -> None:
        """Give the heat that left the layers since `before` (`heat_out`) to the cells; areas [k] [m^2]."""
        around, self.last = np.zeros(self._node_count), np.zeros(len(self.given))
        for side, (now, then) in enumerate(zip(self.heat_out(), before, strict=True)):
            heat = areas * (now - then)
            self.last += heat
            if side == 0:
                around[: len(heat)] += heat
            else:
                around += np.bincount(self._masters, self._weights * heat[self._slaves], len(around))
        self.given += self.last
        cells = np.bincount(self._cells, self._shares * around[self._nodes], len(self._start))
        memory = arrays.get(self._force.memory)
        rise = (cells / self._capacity)[self._cell_of_place]
        if self._pressed.any():  # two more numbers of their state (kernels/materials/mie_grueneisen.py)
            place, added = self._places[self._pressed], rise[self._pressed]
            start = self._start[self._cell_of_place[self._pressed]]
            reduced, heat = place + WIDTH, place + 2 * WIDTH
            memory[reduced] += added * (start + memory[reduced]) / (start + memory[place])
            memory[heat] += added
        memory[self._places] += rise
        if memory is not self._force.memory:
            arrays.set_values(self._force.memory, memory)

    def heat_out(self) -> list[np.ndarray]:
        """Return the heat [k] [J/m^2] that left the layers so far through the far end of the own and the other side."""
        totals = [np.zeros(len(self.given)) for _ in range(2)]
        for kind, batch, nodes in zip(self._layers.kinds, self._layers.batches, self._layers.nodes, strict=True):
            for side, is_open in enumerate(kind.open_ends):
                if is_open:
                    totals[side][nodes] += batch.heat_out(side)
        return totals

    def _read_rows(self) -> None:
        """Read masters and weights of the slaves where the rows have been built anew."""
        if self._pairs is None or self._pairs.rebuilds == self._rebuilds:
            return
        self._rebuilds = self._pairs.rebuilds
        lists, values = arrays.get(self._pairs.lists), arrays.get(self._pairs.values)
        rows = int(lists[at.ROWS])
        slaves = lists[lists[at.SLAVES] :][:rows]
        first = lists[lists[at.FIRST_ENTRY] :][: rows + 1]
        entries = int(first[rows])
        own = np.repeat(slaves, np.diff(first)).astype(np.int64)
        weights = np.abs(values[lists[at.WEIGHTS] :][:entries])
        weights = weights / np.bincount(own, weights, len(self.given))[own]
        left = ~np.isin(self._slaves, slaves)
        self._slaves = np.concatenate([self._slaves[left], own])
        self._masters = np.concatenate([self._masters[left], lists[lists[at.MASTERS] :][:entries].astype(np.int64)])
        self._weights = np.concatenate([self._weights[left], weights])
