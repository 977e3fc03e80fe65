"""Rows of pairs of bodies on a GPU: the host builds them anew where the device asks for it, at the end of a block."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...contact.pairs.pair_contact import PairContact
from ...device import arrays
from ...kernels.pair_places import SQUEEZED


def pair_arguments(pairs: PairContact | None) -> dict[str, arrays.Array]:
    """Return the arrays of the rows by the names of kernels/language/bundles.Contact."""
    return {} if pairs is None else {"pair_lists": pairs.lists, "pair_values": pairs.values}


class DevicePairs:
    """The rows of the pairs of a domain; u: displacement, on the device.

    built: how often they were built; a block of steps ends where they are.
    """

    def __init__(self, pairs: PairContact, u: arrays.Array) -> None:
        self._pairs, self._u = pairs, u
        self.built = 0
        self._steps, self._counted = pairs.steps, 0  # before the present block, and of it so far
        self._before: dict[str, Any] | None = None  # the rows that the present block began with, if it built others

    def begin(self) -> None:
        """Begin a block of steps."""
        self._pairs.begin_step()
        self._before = None
        self._steps, self._counted = self._pairs.steps, 0

    def passed(self, steps: int) -> None:
        """Note that so many steps of the present block are done."""
        self._pairs.steps += steps - self._counted
        self._counted = steps

    def end(self) -> None:
        """End a block of steps, which is not taken again."""
        self._before = None

    def build(self) -> None:
        """Build the rows at the present displacement."""
        if self._before is None:
            self._before = self._pairs.checkpoint()
        self._pairs.rebuild(np.array(arrays.get(self._u)).reshape(-1, 3))
        self.built += 1

    def go_back(self) -> None:
        """Take the rows that the block began with, which is taken again."""
        if self._before is not None:
            self._pairs.restore(self._before)
        self._pairs.steps, self._counted = self._steps, 0
        arrays.set_values(self._pairs.values, np.zeros(1), SQUEEZED)

    def replaced(self, bundles: dict[str, Any]) -> dict[str, Any]:
        """Return bundles with the present arrays, since larger ones may have taken their place."""
        return bundles | {"contact": bundles["contact"]._replace(**pair_arguments(self._pairs))}
