"""Timing in turns: every kind of work gets a batch in each round, so that what else the machine does hits all alike."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from time import perf_counter

import numpy as np

MOST_ROUNDS = 40
COPY_BYTES = 2**27  # size of the source of a copy: several times any last-level cache
Work = Callable[[], float]  # function that does one batch and returns what one unit took [s]


def rounds(works: Mapping[str, Work], seconds: float, least: int) -> dict[str, np.ndarray]:
    """Return the seconds per unit of every work, an entry per round: at least `least`, more while the budget lasts.

    The order turns with the rounds, so that nobody always runs first.
    """
    taken: dict[str, list[float]] = {name: [] for name in works}
    names, started, number = list(works), perf_counter(), 0
    while number < least or (number < MOST_ROUNDS and perf_counter() - started < seconds * number / (number + 1)):
        for place in range(len(names)):
            name = names[(place + number) % len(names)]
            taken[name].append(works[name]())
        number += 1
    return {name: np.array(values) for name, values in taken.items()}


def spread(values: np.ndarray) -> dict[str, float]:
    """Return median, quartiles, smallest and largest, and the number of values."""
    first, median, third = np.quantile(values, (0.25, 0.5, 0.75))
    return {
        "median": float(median),
        "first_quartile": float(first),
        "third_quartile": float(third),
        "low": float(np.min(values)),
        "high": float(np.max(values)),
        "batches": len(values),
    }


def batch(step: Callable[[], object], steps: int, finish: Callable[[], object] = lambda: None) -> Work:
    """Return the work of so many calls of a step; finish: waits until they are done."""

    def work() -> float:
        begin = perf_counter()
        for _ in range(steps):
            step()
        finish()
        return (perf_counter() - begin) / steps

    return work


def host_copy(threads: int) -> Work:
    """Return the work of numpy.copyto, the array shared out over the threads, in seconds per byte read or written."""
    count = COPY_BYTES // 8
    source, target = np.ones(count), np.zeros(count)
    ends = np.linspace(0, count, threads + 1).astype(int)
    parts = [slice(low, high) for low, high in pairwise(ends)]
    pool = ThreadPoolExecutor(threads)

    def work() -> float:
        begin = perf_counter()
        list(pool.map(lambda part: np.copyto(target[part], source[part]), parts))
        return (perf_counter() - begin) / (2 * COPY_BYTES)

    work()  # the pages exist from here on
    return work


def load() -> float:
    """Return how many processes want a core, averaged over the last minute; nan where the system does not say."""
    try:
        return os.getloadavg()[0]
    except (AttributeError, OSError):
        return float("nan")
