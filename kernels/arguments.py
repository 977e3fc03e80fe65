"""Kinds of kernel arguments: flat arrays of float64 and int32 (compiled once, reused at any size)."""

import taichi as ti

ARRAY = ti.types.ndarray(dtype=ti.f64, ndim=1)
INDEX = ti.types.ndarray(dtype=ti.i32, ndim=1)
