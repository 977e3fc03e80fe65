"""Guard meshio against damaged files: against arrays larger than the file and endless reading at its end."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from .content import MeshFileError

# modules of meshio that allocate arrays of a length read from the file
READERS = (
    "gmsh.common",
    "gmsh._gmsh22",
    "gmsh._gmsh40",
    "gmsh._gmsh41",
    "stl._stl",
    "ply._ply",
    "obj._obj",
    "vtu._vtu",
)
MAKERS = ("empty", "zeros", "ones", "full", "arange")
PER_BYTE, ALWAYS = 64, 2**28  # largest memory of an array, over the size of the file, and at least [bytes]


@contextmanager
def guarded(path: Path) -> Iterator[None]:
    """Raise `MeshFileError` while meshio reads the file for arrays too long for it and for reading beyond its end."""
    from unittest import mock  # it imports asyncio

    numpy = GuardedNumpy(path.stat().st_size)
    with ExitStack() as stack:
        for name in READERS:
            module = importlib.import_module(f"meshio.{name}")
            if hasattr(module, "np"):
                stack.enter_context(mock.patch.object(module, "np", numpy))
            if hasattr(module, "_next_line"):
                stack.enter_context(mock.patch.object(module, "_next_line", _next_line))
        yield


class GuardedNumpy:
    """NumPy with checked functions that make arrays of a given length; size: size of the file [bytes]."""

    def __init__(self, size: int) -> None:
        self.size = size

    def __getattr__(self, name: str) -> Any:
        function = getattr(np, name)
        if name not in MAKERS:
            return function

        def checked(shape: Any, *arguments: Any, **options: Any) -> Any:
            # as Python's integers, which do not overflow; the second argument of arange may be its end
            counts = [shape] if np.ndim(shape) == 0 else list(shape)
            if name == "arange":
                counts = [max([abs(shape), *(abs(a) for a in arguments[:1] if isinstance(a, (int, np.integer)))])]
            total = 8
            for count in counts:
                total *= int(count)
            if abs(total) > PER_BYTE * self.size + ALWAYS:
                raise MeshFileError("it names counts that its size cannot hold; the file is damaged, save it again")
            return function(shape, *arguments, **options)

        return checked

    def fromfile(self, file: Any, dtype: Any = float, count: int = -1, sep: str = "", **options: Any) -> np.ndarray:
        """Read like `numpy.fromfile`, but never more than the file has."""
        least = 2 if sep else np.dtype(dtype).itemsize  # bytes of a number: a digit and a blank as text
        if int(count) * least > self.size + 2:
            raise MeshFileError("it names counts that its size cannot hold; the file is damaged, save it again")
        return np.fromfile(file, dtype, int(count), sep, **options)


def _next_line(stream: Any) -> str:
    """Return the next line of a PLY file that is no comment; meshio's own function never returns at its end."""
    while True:
        line = stream.readline()
        if not line:
            raise MeshFileError("the file ends too early; save it again, complete")
        text = str(line.decode()).strip()
        if text and not text.startswith("comment"):
            return text
