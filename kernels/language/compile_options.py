"""Options of Taichi's compiler for one kernel.

`KEEP_VECTORS`: a `ti.Vector` of lanes stays one SIMD value of the machine; Taichi otherwise splits every vector into
scalars. Needed by each kernel with lanes.
`LEAVE_TO_LLVM`: Taichi does not look for common subexpressions itself. Its search takes time with the square of a
kernel's length, up to 70 % of the compilation of a long one, and LLVM finds them too: same bits, same speed but for the
loops over cells, which lose 5 to 10 %.
"""

import functools

import taichi as ti

KEEP_VECTORS = {"real_matrix_scalarize": False}
LEAVE_TO_LLVM = {"opt_level": 0}


def compiled_with(kernel, **options):
    """The kernel with these `ti.cfg` options, which are set only while its first call compiles.

    `.kernel` of the answer is the plain kernel, compiled after the first call.
    """
    compiled = False

    @functools.wraps(kernel)
    def call(*arguments):
        nonlocal compiled
        if compiled:
            return kernel(*arguments)
        before = {name: getattr(ti.cfg, name) for name in options}
        try:
            for name, value in options.items():
                setattr(ti.cfg, name, value)
            answer = kernel(*arguments)
        finally:
            for name, value in before.items():
                setattr(ti.cfg, name, value)
        compiled = True
        return answer

    call.kernel = kernel
    return call
