"""What the contact nodes of a domain slide on: an obstacle, or another body on part of their area."""

from __future__ import annotations

import numpy as np

from ..device import arrays
from ..kernels import pair_places as at
from ..planning.domain import Domain
from ..scene.friction_models import coefficient_of
from ..scene.layer_metals import LayerKind, kinds_of
from ..scene.scene import Scene
from .constraint_rows import ConstraintRows
from .pairs.pair_contact import PairContact


class SlidingPartners:
    """The partner of every contact node [k]: that of the row that presses it hardest; it stays while the node is open.

    used [k]: batch of its layer, -1 for none; areas [k] [m^2]: weight of the node, or the part of it that the other
    body covers; coefficients [k]: of friction, their mean by force at nodes that several rows press; body [k]: number
    of its body in the domain; batches [body, obstacle]: of the layers of a body on each obstacle.
    """

    def __init__(
        self,
        scene: Scene,
        domain: Domain,
        kinds: list[LayerKind],
        rows: ConstraintRows,
        candidates: arrays.Array,
        pairs: PairContact | None,
    ) -> None:
        assert domain.contact is not None
        assert scene.friction is not None
        self._rows, self._candidates, self._pairs = rows, candidates, pairs
        count = len(domain.contact.nodes)
        self._weights = domain.contact.areas
        self.areas, self.coefficients = self._weights.copy(), np.full(count, coefficient_of(scene.friction))
        self.body = np.repeat(np.arange(len(domain.numbers)), np.diff(domain.contact_start))
        self.batches = np.full((len(domain.numbers), max(1, len(scene.obstacles))), -1)  # of a body on an obstacle
        self._on_masters = np.full((len(domain.numbers), len(scene.bodies)), -1)  # of a body on another one
        for place, number in enumerate(domain.numbers):
            for (partner, index), kind in kinds_of(scene, number).items():
                table = self.batches if partner == "obstacle" else self._on_masters
                table[place, index] = kinds.index(kind)
        self._master = np.array([pair.master for pair in domain.pairs], dtype=np.int64)
        self._rebuilds, self._covered, self._between = -1, np.zeros(count), np.full(count, -1)
        used = np.concatenate([self.batches, self._on_masters], axis=1).max(axis=1)
        self.used = used[self.body]

    def look(self) -> None:
        """Find the partners out of the present forces."""
        slots = self._rows.slots
        values = arrays.get(self._rows.values).reshape(-1, slots, self._rows.places.width)
        every, pressing = np.arange(len(values)), values[:, :, self._rows.places.pressing]
        slot = pressing.argmax(axis=1)
        pressed = pressing[every, slot] > 0.0
        obstacle = np.minimum(arrays.get(self._candidates).reshape(-1, slots)[every, slot], self.batches.shape[1] - 1)
        batch, areas = self.batches[self.body, obstacle], self._weights
        if self._pairs is not None:
            self._read_pairs(self._pairs)
            between = (slot == slots - 1) & (self._between >= 0)
            batch, areas = np.where(between, self._between, batch), np.where(between, self._covered, areas)
        self.used = np.where(pressed, batch, self.used)
        self.areas = np.where(pressed, areas, self.areas)
        coefficients, pressing = values[:, :, self._rows.places.coefficient], np.maximum(pressing, 0.0)
        coefficient = coefficients[every, slot]
        several = (pressing > 0.0).sum(axis=1) > 1  # their mean gives the friction of all rows, each bounded by its own
        mean = (coefficients * pressing).sum(axis=1) / np.where(several, pressing.sum(axis=1), 1.0)
        coefficient = np.where(several, mean, coefficient)
        self.coefficients = np.where(pressed, coefficient, self.coefficients)

    def _read_pairs(self, pairs: PairContact) -> None:
        """Read area and partner of the slaves where the rows have been built anew."""
        if pairs.rebuilds == self._rebuilds:
            return
        self._rebuilds = pairs.rebuilds
        lists, values = arrays.get(pairs.lists), arrays.get(pairs.values)
        rows = int(lists[at.ROWS])
        slaves = lists[lists[at.SLAVES] :][:rows]
        first = lists[lists[at.FIRST_ENTRY] :][:rows]
        numbers = values[lists[at.NUMBERS] :][: rows * at.ROW_NUMBERS].reshape(-1, at.ROW_NUMBERS)
        master = self._master[lists[lists[at.SIDES] :][first] // 2]
        self._between[:] = -1
        self._between[slaves] = self._on_masters[self.body[slaves], master]
        self._covered[slaves] = numbers[:, at.AREA]
