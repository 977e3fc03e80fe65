"""Values of nodes that are put together where a frame is written, in the process beside the run if there is one.

A run has its values in an order of its own and for some nodes only. It hands over copies of them as they are; the rule
of a part says what makes values [n] or [n, 3] in the numbering of the user of them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...mesh.geometry import chunks_of, joined

AT_ONCE = 1 << 14  # nodes in a portion


class Part(NamedTuple):
    """The values of one body in a field.

    rule: a name in `RULES`; now: arrays of this frame; fixed: arrays that are the same in all frames; numbers: the
    remaining arguments of the rule.
    """

    rule: str
    now: tuple[np.ndarray, ...]
    fixed: tuple[np.ndarray, ...] = ()
    numbers: tuple[float, ...] = ()

    def values(self) -> np.ndarray:
        """Return the values of the body in the user's numbering."""
        return RULES[self.rule](self.now, self.fixed, self.numbers)


class LateField(NamedTuple):
    """A field that is put together later, of the parts of all bodies."""

    parts: tuple[Part, ...]

    def values(self) -> np.ndarray:
        """Return the values of all bodies in the user's numbering; no copy for one body."""
        return joined([part.values() for part in self.parts])


def whole(field: np.ndarray | LateField) -> np.ndarray:
    """Return the values of a field, put together if they are not yet."""
    return field.values() if isinstance(field, LateField) else field


def _as_they_are(now: tuple[np.ndarray, ...], _fixed: Any, _numbers: Any) -> np.ndarray:
    """Return values in the user's numbering."""
    return now[0]


def _renumbered(now: tuple[np.ndarray, ...], fixed: tuple[np.ndarray, ...], _numbers: Any) -> np.ndarray:
    """Return values in another order; fixed: the place [n] of every node of the user in them."""
    return np.take(now[0], fixed[0], axis=0)  # four times as fast as an index in brackets


def _spread(now: tuple[np.ndarray, ...], fixed: tuple[np.ndarray, ...], numbers: tuple[float, ...]) -> np.ndarray:
    """Return values of some nodes and zeros elsewhere; fixed: their nodes; numbers: the count of all nodes."""
    result = np.zeros((int(numbers[0]), *now[0].shape[1:]))
    result[fixed[0]] = now[0]
    return result


def _velocity(now: tuple[np.ndarray, ...], fixed: tuple[np.ndarray, ...], numbers: tuple[float, ...]) -> np.ndarray:
    """Return the velocity between two half steps, plus that of massless components, in another order.

    now: velocity before, after, [k, 3] of the massless ones where there are any; fixed: place of every node of the
    user, numbers there of the massless ones; numbers: share of the second one.
    """
    place, result = fixed[0], np.empty(now[0].shape)
    for part in chunks_of(len(place), AT_ONCE):
        before, after = (np.take(values, place[part], axis=0) for values in now[:2])
        result[part] = before + numbers[0] * (after - before)
    if len(now) > 2:
        result[fixed[1]] += now[2]
    return result


RULES: dict[str, Callable[..., np.ndarray]] = {
    "as they are": _as_they_are,
    "renumbered": _renumbered,
    "spread": _spread,
    "velocity": _velocity,
}
