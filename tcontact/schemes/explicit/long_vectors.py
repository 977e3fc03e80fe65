"""Vectors [3n] of all nodes, portion by portion: temporaries stay in the cache and small beside the vectors."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...mesh.geometry import chunks_of

PORTION = 3 << 12  # numbers at a time, of whole nodes


def portions(vector: np.ndarray) -> Iterator[slice]:
    """Yield the portions of a vector [3n]."""
    return chunks_of(len(vector), PORTION)


def nodes_of(part: slice) -> slice:
    """Return the nodes of a portion."""
    return slice(part.start // 3, part.stop // 3)


def dot(a: np.ndarray, mass: np.ndarray, b: np.ndarray) -> float:
    """Return a.M b with a mass [n] of every node, without BLAS, whose idle threads would occupy cores."""
    total = 0.0
    for part in portions(a):
        products = (a[part] * b[part]).reshape(-1, 3)
        total += float(((products[:, 0] + products[:, 1] + products[:, 2]) * mass[nodes_of(part)]).sum())
    return total


class Vectors:
    """Keeps vectors in 16 bits, each over its largest number, to the sum of which an error of 1e-3 does no harm."""

    def __init__(self) -> None:
        self._kept: list[tuple[float, np.ndarray]] = []

    def add(self, vector: np.ndarray, largest: float) -> None:
        """Keep a vector whose largest magnitude is known."""
        kept = np.empty(len(vector), dtype=np.float16)
        for part in portions(vector):
            kept[part] = vector[part] * (1.0 / largest if largest > 0.0 else 0.0)
        self._kept.append((largest, kept))

    def sum(self, weights: np.ndarray, room: np.ndarray) -> np.ndarray:
        """Return the sum of the vectors with these weights, in `room`; they are dropped."""
        room[:] = 0.0
        for weight, (largest, kept) in zip(weights, self._kept, strict=True):
            for part in portions(room):
                room[part] += weight * largest * kept[part].astype(np.float64)
        self._kept = []
        return room
