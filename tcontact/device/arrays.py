"""Arrays of the kernels: NumPy memory on the CPU, which the host reads without a copy, Taichi ndarrays on a GPU."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.memory import aligned
from . import runtime

Array = Any  # numpy.ndarray on the CPU, taichi.Ndarray on a GPU; flat, one-dimensional


def put(values: np.ndarray) -> Array:
    """Make a flat array on the device with a copy of the values (float64 or int32)."""
    dtype = np.float64 if np.issubdtype(np.asarray(values).dtype, np.floating) else np.int32
    flat = np.asarray(values).reshape(-1)
    if flat.size == 0:
        flat = np.zeros(1)  # kernels never see an empty array
    if runtime.arch() != "cuda":
        array = aligned(flat.size, dtype)
        array[:] = flat
        return array
    ti = runtime.load()
    device = ti.ndarray(ti.f64 if dtype is np.float64 else ti.i32, flat.size)
    device.from_numpy(flat.astype(dtype))
    return device


def share(values: np.ndarray) -> Array:
    """Make a flat array on the device of values that nobody changes: on the CPU their own memory where it fits."""
    fits = values.dtype in (np.float64, np.int32) and values.flags.c_contiguous and values.size > 0
    return values.reshape(-1) if fits and runtime.arch() != "cuda" else put(values)


def zeros(count: int) -> Array:
    """Make a flat float64 array of zeros on the device."""
    return put(np.broadcast_to(0.0, max(count, 1)))


def get(array: Array) -> np.ndarray:
    """Return the values on the host: the array itself on the CPU (copy it to keep it), a copy on a GPU."""
    return array if isinstance(array, np.ndarray) else array.to_numpy()


def set_values(array: Array, values: np.ndarray, first: int = 0) -> None:
    """Overwrite values of a device array from `first` on, or all of them."""
    flat = np.ascontiguousarray(values).reshape(-1)
    if isinstance(array, np.ndarray):
        array[first : first + flat.size] = flat
        return
    whole = flat.astype(np.float64)
    if flat.size < int(np.prod(array.shape)):
        whole = array.to_numpy()
        whole[first : first + flat.size] = flat
    array.from_numpy(whole)


def size_in_bytes(arrays: list[Array]) -> int:
    """Return the memory of the arrays [bytes]."""
    total = 0
    for array in arrays:
        count = int(np.prod(array.shape))
        total += count * (array.itemsize if isinstance(array, np.ndarray) else (4 if "i32" in str(array.dtype) else 8))
    return total
