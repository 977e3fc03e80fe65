"""Kinds of kernel arguments: flat arrays of float64 and int32 (compiled once, reused at any size)."""

from ..engine import ti

ARRAY = ti.types.ndarray(dtype=ti.f64, ndim=1)
INDEX = ti.types.ndarray(dtype=ti.i32, ndim=1)


class Array:
    """Annotation of a field of a bundle (bundles.py) that is a flat array of float64."""


class Index:
    """Annotation of a field of a bundle that is a flat array of int32."""


class Shared(Array):
    """Annotation of an array of float64 that all bundles with a field of this name share."""
