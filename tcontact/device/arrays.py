"""Arrays of the kernels: NumPy memory on the CPU, which the host reads without a copy, Taichi ndarrays on a GPU."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

import numpy as np

from ..base.memory import aligned
from . import runtime
from .joint import Joint, Part, copies, read, write

Array = Any  # numpy.ndarray on the CPU, taichi.Ndarray or Part on a GPU; flat, one-dimensional

_joint: ContextVar[Joint | None] = ContextVar("joint", default=None)  # in which arrays stand that are made now


@contextmanager
def standing_in(joint: Joint | None) -> Iterator[None]:
    """Let arrays of a GPU that are made inside stand in a joint, or alone (None)."""
    token = _joint.set(joint)
    try:
        yield
    finally:
        _joint.reset(token)


def _part(dtype: type, count: int, values: np.ndarray | None = None) -> Part | None:
    """Return a new part of the present joint, if there is one that still takes any."""
    joint = _joint.get()
    return joint.part(dtype, count, values) if joint is not None and joint.takes(dtype, count) else None


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
    part = _part(dtype, flat.size, flat)
    if part is not None:
        return part
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
        return _part(np.float64, max(count, 1)) or ti.ndarray(ti.f64, max(count, 1))
    return put(np.broadcast_to(0.0, max(count, 1)))


def whole_numbers(count: int) -> Array:
    """Make a flat int32 array of zeros on the device."""
    if runtime.arch() == "cuda":
        ti = runtime.load()
        return _part(np.int32, max(count, 1)) or ti.ndarray(ti.i32, max(count, 1))
    return put(np.zeros(max(count, 1), dtype=np.int32))


def rows(array: Array, count: int, width: int = 3) -> np.ndarray:
    """Return the rows [count, width] of an array on the host as `get` does; of no rows it holds a number of no use."""
    return get(array)[: count * width].reshape(count, width)


def get(array: Array) -> np.ndarray:
    """Return the values on the host: the array itself on the CPU (copy it to keep it), a copy on a GPU."""
    return array if isinstance(array, np.ndarray) else array.to_numpy()


def alone(array: Array) -> Array:
    """Return an array that stands in no joint: itself, or a copy of the part of one."""
    with standing_in(None):
        return put(array.to_numpy()) if isinstance(array, Part) else array


def part(array: Array, first: int, count: int) -> np.ndarray:
    """Return `count` values from `first` on, on the host, without the others; like `get`."""
    if isinstance(array, np.ndarray):
        return array[first : first + count]
    return array.read(first, count) if isinstance(array, Part) else read(array, _type(array), first, count)


def placed(array: Array) -> tuple[Array, int]:
    """Return what a launch is given for an array of a GPU, and where it begins there: in a joint array, or at 0."""
    return array.place if isinstance(array, Part) else (array, 0)


def copy(source: Array, target: Array) -> None:
    """Copy the values of an array to one of the same type and size, on the device."""
    if isinstance(source, np.ndarray):
        target[:] = source
        return
    (given, first), (taking, start) = placed(source), placed(target)
    copies(_type(source))(given, first, taking, start, int(np.prod(source.shape)))


def set_values(array: Array, values: np.ndarray, first: int = 0) -> None:
    """Overwrite values of a device array from `first` on, or all of them."""
    flat = np.ascontiguousarray(values).reshape(-1)
    if isinstance(array, np.ndarray):
        array[first : first + flat.size] = flat
    elif isinstance(array, Part):
        array.write(flat, first)
    else:
        flat = flat.astype(_type(array), copy=False)
        if flat.size == int(np.prod(array.shape)):
            array.from_numpy(flat)
        else:
            write(array, _type(array), first, flat)


def _type(array: Array) -> type:
    """Return the type of the numbers of an array of a GPU."""
    return np.int32 if "i32" in str(array.dtype) else np.float64


def size_in_bytes(arrays: list[Array]) -> int:
    """Return the memory of the arrays [bytes]."""
    total = 0
    for array in arrays:
        count = int(np.prod(array.shape))
        total += count * (array.itemsize if isinstance(array, np.ndarray) else (4 if "i32" in str(array.dtype) else 8))
    return total
