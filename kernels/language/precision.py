"""Precision of the arithmetic of a function: float64, or float32 where `in_single` inlines it.

A function computes in the type of its arguments if no constant of its own widens them: Taichi makes a constant of the
type that is the default when the function is inlined. `in_single` makes float32 the default while it inlines a
function, so that the physics is written once. Constants of the size of a type (the smallest number, a floor that must
differ from 1) are `by_precision`.
"""

import functools
from typing import Any

from ..engine import ti


def single() -> bool:
    """Return whether the function that is inlined here computes in float32."""
    return ti.lang.impl.get_runtime().default_fp == ti.f32


def by_precision(double: float, in_float32: float) -> float:
    """Return the constant for the precision of the function that is inlined here; use it within `ti.static`."""
    return in_float32 if single() else double


def in_single(function: Any) -> Any:
    """Return a `ti.func` whose constants are float32, as those of all functions that it calls."""

    @functools.wraps(function)
    def inlined(*arguments: Any, **named: Any) -> Any:
        runtime = ti.lang.impl.get_runtime()
        before = runtime.default_fp
        runtime.default_fp = ti.f32
        try:
            return function(*arguments, **named)
        finally:
            runtime.default_fp = before

    return inlined


def or_in_single(function: Any) -> Any:
    """Return a decorator of a `ti.func` that inlines `function` in its place where the arithmetic is float32."""

    def decorate(double: Any) -> Any:
        @functools.wraps(double)
        def inlined(*arguments: Any, **named: Any) -> Any:
            return (function if single() else double)(*arguments, **named)

        return inlined

    return decorate
