"""Compiler options of Taichi for single kernels.

`KEEP_VECTORS`: a `ti.Vector` of lanes stays one SIMD value; otherwise Taichi splits every vector into scalars. Each
kernel with lanes needs it. On CUDA Taichi cannot compile functions of such values, and they are split.
`LEAVE_TO_LLVM`: Taichi does not search for common subexpressions. Its search takes time with the square of the length
of a kernel, up to 70 % of the compilation of a long one, and LLVM finds them too. Bits and speed stay the same, except
for loops over cells, which become 5 to 10 % slower.
"""

import functools

from ..engine import ti

KEEP_VECTORS = {"real_matrix_scalarize": False}
LEAVE_TO_LLVM = {"opt_level": 0}


def compiled_with(kernel, **options):
    """Return the kernel with these `ti.cfg` options, which are set only while its first call compiles it.

    The attribute `.kernel` of the result is the kernel without this wrapper.
    """
    compiled = False

    @functools.wraps(kernel)
    def call(*arguments):
        nonlocal compiled
        if compiled:
            return kernel(*arguments)
        chosen = options if ti.cfg.arch != ti.cuda else {k: options[k] for k in options if k not in KEEP_VECTORS}
        before = {name: getattr(ti.cfg, name) for name in chosen}
        try:
            for name, value in chosen.items():
                setattr(ti.cfg, name, value)
            answer = kernel(*arguments)
        finally:
            for name, value in before.items():
                setattr(ti.cfg, name, value)
        compiled = True
        return answer

    call.kernel = kernel
    return call
