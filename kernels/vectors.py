"""Vectors of lanes as SIMD values of the machine: what the compiler has to be told."""

import functools

import taichi as ti

MASK = 0x3FFFFFFF  # on an index: it tells the compiler that the next ones cannot overflow, and whole vectors are loaded


def keep_vectors(kernel):
    """The kernel, compiled with its vectors intact: a `ti.Vector` of lanes stays one SIMD value of the machine.

    Taichi otherwise splits every vector into scalars. Needed by each kernel that contains a cell phase; the option is
    set only while the first call compiles. `.kernel` of the answer is the plain kernel, compiled after the first call.
    """
    compiled = False

    @functools.wraps(kernel)
    def call(*arguments):
        nonlocal compiled
        if compiled:
            return kernel(*arguments)
        before = ti.cfg.real_matrix_scalarize
        ti.cfg.real_matrix_scalarize = False
        try:
            answer = kernel(*arguments)
        finally:
            ti.cfg.real_matrix_scalarize = before
        compiled = True
        return answer

    call.kernel = kernel
    return call
