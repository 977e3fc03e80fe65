"""Launch a kernel again and again at little cost.

Taichi's ordinary call costs 11 us and 5 us per array. `Prepared` fills the launch context itself, through interfaces
that Taichi does not promise to keep: if any of them is missing, it makes ordinary calls. A context whose arrays
are NumPy memory is kept: a launch with the same arrays only sets the numbers, 2 to 4 us in all however many arrays.
Arrays of a GPU need a new context for every launch, since Taichi leaves one there that cannot be filled again: 1 us per
array, and as much or more for what Taichi does with each. Small ones therefore share two (joint.py).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np


class Prepared:
    """A kernel whose calls skip the argument checks; the first call is an ordinary one and compiles.

    Arguments must keep their types from call to call: flat arrays, floats, ints. Arrays are kept alive.
    """

    def __init__(self, kernel: Callable[..., None]) -> None:
        self.kernel = kernel
        self._ready: tuple[Any, Any, Any] | None = None
        self._arrays: dict[int, tuple[Any, tuple[Any, ...]]] = {}
        self._ordinary = False
        self._context: Any = None  # the last context, if it may be used again
        self._filled: tuple[Any, ...] = ()
        self._places: tuple[list[tuple[int]], list[int]] | None = None  # of arrays of a GPU alone, and of the numbers

    def __call__(self, *arguments: Any) -> None:
        if self._ready is None:
            taken = tuple(getattr(value, "made", value) for value in arguments)  # a joint array of a GPU: Taichi's own
            self.kernel(*taken)
            if not self._ordinary:
                self._prepare(taken)
            return
        if self._places is not None:
            self._launch_on_device(arguments, *self._places)
            return
        make, compiled, launch = self._ready
        filled, context = self._filled, self._context
        if context is None:
            filled, context = (None,) * len(arguments), make()
        known, keep = self._arrays, True
        for index, value in enumerate(arguments):
            if value is filled[index] and type(value) is np.ndarray:
                continue
            kind = type(value)
            if kind is float:
                context.set_arg_float((index,), value)
            elif kind is int:
                context.set_arg_int((index,), value)
            elif isinstance(value, np.floating):
                context.set_arg_float((index,), float(value))
            elif isinstance(value, np.ndarray):
                found = known.get(id(value)) or self._remember(value)
                context.set_arg_external_array_with_shape((index,), *found[1])
            else:
                context.set_arg_ndarray((index,), value.arr)
                keep = False
        self._filled, self._context = (arguments, context) if keep else ((), None)
        launch(compiled, context)

    def _launch_on_device(self, arguments: tuple[Any, ...], places: list[tuple[int]], numbers: list[int]) -> None:
        """Launch with arrays of a GPU at these places and numbers at the others."""
        assert self._ready is not None
        make, compiled, launch = self._ready
        context = make()
        deque(map(context.set_arg_ndarray, places, [arguments[index].arr for (index,) in places]), 0)
        for index in numbers:
            value = arguments[index]
            fill = context.set_arg_int if isinstance(value, int) else context.set_arg_float
            fill((index,), value if isinstance(value, int) else float(value))
        launch(compiled, context)

    def _remember(self, array: np.ndarray) -> tuple[Any, tuple[Any, ...]]:
        if not array.flags.c_contiguous:
            raise ValueError("kernel arrays must be contiguous")
        entry = (array, (int(array.ctypes.data), array.nbytes, array.shape, 0))
        self._arrays[id(array)] = entry
        return entry

    def _prepare(self, arguments: tuple[Any, ...]) -> None:
        """Find the compiled kernel of these arguments; use ordinary calls if Taichi has changed."""
        try:
            from ..kernels.engine import ti

            impl = ti.lang.impl
            primal = self.kernel._primal  # type: ignore[attr-defined]
            program = impl.get_runtime().prog
            inner = primal.compiled_kernels[primal.ensure_compiled(*arguments)]
            compiled = program.compile_kernel(program.config(), program.get_device_caps(), inner)
            self._ready = (inner.make_launch_context, compiled, program.launch_kernel)
            numbers = [index for index, value in enumerate(arguments) if isinstance(value, int | float)]
            others = [(index,) for index in range(len(arguments)) if index not in numbers]
            if others and all(hasattr(arguments[index], "arr") for (index,) in others):
                self._places = others, numbers
        except (AttributeError, KeyError, TypeError):
            self._ordinary = True
