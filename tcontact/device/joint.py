"""Small arrays of a GPU that stand in two large ones, since a launch takes the host time for every array that it names.

A `Part` serves where an array of its own would: the host reads and writes it like one, and a kernel is given the large
arrays of its `Joint` instead (kernels/language/joint_arrays.py), which puts the parts back in their places.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from . import runtime
from .launch import Prepared

ALIGNED = 32  # numbers; parts begin at multiples of it, as threads beside each other read best
MOST = 2**30  # numbers of a type; places are int32


class Joint:
    """Parts that stand in one array of float64 and one of int32, made when one of them is first needed on the device.

    The array of int32 begins with place and size of every part, in the order in which they were made. Parts are made
    until then; where `full`, and beyond MOST numbers, others have to stand alone.
    """

    def __init__(self) -> None:
        self.parts: list[Part] = []
        self._sizes: dict[type, int] = {np.float64: 0, np.int32: 0}
        self.reals, self.wholes = Whole(self, np.float64), Whole(self, np.int32)
        self.full = False

    def takes(self, dtype: type, size: int) -> bool:
        """Return whether there may be another part of so many numbers."""
        return not self.full and self._sizes[dtype] + size <= MOST

    def part(self, dtype: type, size: int, values: np.ndarray | None = None) -> Part:
        """Return a new part with a copy of these values, or with zeros."""
        self._sizes[dtype] += size
        found = Part(self, len(self.parts), dtype, size)
        found.waiting = None if values is None else np.array(values, dtype=dtype)
        self.parts.append(found)
        return found

    def fill(self) -> None:
        """Make the two arrays and send the values that wait."""
        if self.full:
            return
        from ..kernels.language.joint_arrays import HEAD

        self.full = True
        ends: dict[type, int] = {np.float64: 0, np.int32: HEAD * len(self.parts)}
        for part in self.parts:
            part.first = -(-ends[part.type] // ALIGNED) * ALIGNED
            ends[part.type] = part.first + part.size
        self.wholes.array, self.reals.array = _made(np.int32, ends[np.int32]), _made(np.float64, 1 + ends[np.float64])
        table = np.array([(part.first, part.size) for part in self.parts], dtype=np.int32)
        write(self.wholes, np.int32, 0, table.reshape(-1))
        for part in self.parts:
            if part.waiting is not None:
                part.from_numpy(part.waiting)
            part.waiting = None


class Whole:
    """One of the two arrays of a joint; `arr` is what a launch needs of it."""

    def __init__(self, joint: Joint, dtype: type) -> None:
        self.joint, self.type = joint, dtype
        self.array: Any = None

    @property
    def arr(self) -> Any:
        """What Taichi launches with."""
        return self.made.arr

    @property
    def made(self) -> Any:
        """The array of Taichi."""
        self.joint.fill()
        return self.array


class Part:
    """A flat array that stands in a joint, from place `first` on; number: which one of its parts.

    It has the names of an array of Taichi that the host uses. waiting: its values before the joint is made; None: 0.
    """

    def __init__(self, joint: Joint, number: int, dtype: type, size: int) -> None:
        self.joint, self.number, self.type, self.size = joint, number, dtype, size
        self.first = 0
        self.waiting: np.ndarray | None = None

    @property
    def shape(self) -> tuple[int]:
        """Its size, as the shape of an array."""
        return (self.size,)

    @property
    def dtype(self) -> Any:
        """The type of its numbers, as Taichi calls it."""
        ti = runtime.load()
        return ti.f64 if self.type is np.float64 else ti.i32

    @property
    def whole(self) -> Whole:
        """The array in which it stands."""
        return self.joint.reals if self.type is np.float64 else self.joint.wholes

    @property
    def place(self) -> tuple[Whole, int]:
        """The array in which it stands, on the device, and where it begins there."""
        self.joint.fill()
        return self.whole, self.first

    def read(self, first: int, count: int) -> np.ndarray:
        """Return a copy of `count` numbers from place `first` of it on."""
        if self.joint.full:
            return read(self.whole, self.type, self.first + first, count)
        return np.array(self._values()[first : first + count])

    def write(self, values: np.ndarray, first: int) -> None:
        """Overwrite the numbers from place `first` of it on."""
        flat: np.ndarray = np.ascontiguousarray(values, dtype=self.type).reshape(-1)
        if self.joint.full:
            write(self.whole, self.type, self.first + first, flat)
            return
        self.waiting = self._values()
        self.waiting[first : first + flat.size] = flat

    def to_numpy(self) -> np.ndarray:
        """Return a copy of its numbers."""
        return self.read(0, self.size)

    def from_numpy(self, values: np.ndarray) -> None:
        """Overwrite all its numbers."""
        self.write(values, 0)

    def _values(self) -> np.ndarray:
        return np.zeros(self.size, dtype=self.type) if self.waiting is None else self.waiting


def read(array: Any, dtype: type, first: int, count: int) -> np.ndarray:
    """Return a copy of `count` numbers from place `first` of an array of a GPU on, without the others."""
    found = _made(dtype, count)
    copies(dtype)(array, first, found, 0, count)
    return np.asarray(found.to_numpy())


def write(array: Any, dtype: type, first: int, flat: np.ndarray) -> None:
    """Overwrite the numbers from place `first` of an array of a GPU on; the others stay on the device."""
    given = _made(dtype, flat.size)
    given.from_numpy(flat)
    copies(dtype)(given, 0, array, first, flat.size)


def _made(dtype: type, count: int) -> Any:
    ti = runtime.load()
    return ti.ndarray(ti.f64 if dtype is np.float64 else ti.i32, count)


@functools.cache
def copies(dtype: type) -> Prepared:
    """Return the launch (source, first, target, start, count) that copies on the device."""
    from ..kernels.language.copies import copy_reals, copy_wholes

    return Prepared(copy_reals if dtype is np.float64 else copy_wholes)
