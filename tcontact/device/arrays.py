"""Arrays of the kernels: NumPy memory on the CPU, which the host reads without a copy, Taichi ndarrays on a GPU."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from ..base.memory import aligned
from . import runtime
from .launch import Prepared

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
    device.from_numpy(np.ascontiguousarray(flat, dtype=dtype))
    return device


def share(values: np.ndarray) -> Array:
    """Make a flat array on the device of values that nobody changes: on the CPU their own memory where it fits."""
    fits = values.dtype in (np.float64, np.int32) and values.flags.c_contiguous and values.size > 0
    return values.reshape(-1) if fits and runtime.arch() != "cuda" else put(values)


def zeros(count: int) -> Array:
    """Make a flat float64 array of zeros on the device."""
    if runtime.arch() == "cuda":  # without an array of zeros on the host
        ti = runtime.load()
        return ti.ndarray(ti.f64, max(count, 1))
    return put(np.broadcast_to(0.0, max(count, 1)))


def whole_numbers(count: int) -> Array:
    """Make a flat int32 array of zeros on the device."""
    if runtime.arch() == "cuda":
        ti = runtime.load()
        return ti.ndarray(ti.i32, max(count, 1))
    return put(np.zeros(max(count, 1), dtype=np.int32))


def get(array: Array) -> np.ndarray:
    """Return the values on the host: the array itself on the CPU (copy it to keep it), a copy on a GPU."""
    return array if isinstance(array, np.ndarray) else array.to_numpy()


def part(array: Array, first: int, count: int) -> np.ndarray:
    """Return `count` values from `first` on, on the host, without the others; like `get`."""
    if isinstance(array, np.ndarray):
        return array[first : first + count]
    found = zeros(count)
    _copy_part()(array, first, found)
    return found.to_numpy()


def copy(source: Array, target: Array) -> None:
    """Copy the values of an array to one of the same type and size, on the device."""
    if isinstance(source, np.ndarray):
        target[:] = source
    elif "i32" in str(source.dtype):
        _copy_wholes()(source, target)
    else:
        _copy_part()(source, 0, target)


@functools.cache
def _copy_wholes() -> Prepared:
    from ..kernels.language.copies import copy_wholes

    return Prepared(copy_wholes)


@functools.cache
def _copy_into() -> Prepared:
    from ..kernels.language.copies import copy_into

    return Prepared(copy_into)


@functools.cache
def _copy_part() -> Prepared:
    from ..kernels.language.copies import copy_part

    return Prepared(copy_part)


def set_values(array: Array, values: np.ndarray, first: int = 0) -> None:
    """Overwrite values of a device array from `first` on, or all of them."""
    flat = np.ascontiguousarray(values).reshape(-1)
    if isinstance(array, np.ndarray):
        array[first : first + flat.size] = flat
        return
    whole = flat.astype(np.float64)
    if flat.size < int(np.prod(array.shape)):
        if "i32" not in str(array.dtype):  # without the other values, which stay on the device
            _copy_into()(put(whole), array, first)
            return
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
