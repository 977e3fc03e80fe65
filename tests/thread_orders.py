"""The threads of every launch in reversed order, on the CUDA device that runs them one by one (fake_cuda.sh)."""

import os
from collections.abc import Callable

import numpy as np

VARIABLE = "FAKE_CUDA_REVERSE"  # read before every launch
COUNT = 64


def both_orders(make: Callable[[], dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Return what a function gives with the threads reversed, as "reversed/..", and the orders; {} on a real device.

    Kernels that the process has compiled already are launched again.
    """
    if "FAKE_CUDA_DIR" not in os.environ:
        return {}
    found = {"order": order()}
    os.environ[VARIABLE] = "1"
    try:
        again = make() | {"order": order()}
    finally:
        del os.environ[VARIABLE]
    return found | {f"reversed/{key}": value for key, value in again.items()}


def order() -> np.ndarray:
    """Return the turn [n] at which every thread of a launch came."""
    from tcontact.kernels.engine import ti

    @ti.kernel
    def note(turns: ti.types.ndarray(ti.i32, ndim=1), count: ti.types.ndarray(ti.i32, ndim=1)):
        for thread in range(turns.shape[0]):
            turns[thread] = ti.atomic_add(count[0], 1)

    turns, count = np.zeros(COUNT, dtype=np.int32), np.zeros(1, dtype=np.int32)
    note(turns, count)
    return turns


def compared(found: dict[str, np.ndarray]) -> set[str]:
    """Compare bit by bit what came in both orders; return the first words of the names."""
    assert (found["order"] == np.arange(COUNT)).all()
    assert (found["reversed/order"] == np.arange(COUNT)[::-1]).all()
    names = set()
    for key, values in found.items():
        name = key.removeprefix("reversed/")
        if name != key and name != "order" and values.dtype == float:
            names.add(name.partition("/")[0])
            assert np.array_equal(found[name], values, equal_nan=True), name
    return names
