"""The explicit step: internal force of packed cells, then kick and drift of the nodes, in one launch.

    f_i = dW/du_i,   a = g - f/m,   v_n = v + kick_before a,   v <- v_n + kick_after a,   u <- u + drift v

(METHOD 2: leapfrog with kick_before = dt_old/2, kick_after = dt_new/2, drift = dt_new.)
With v = 0, g = 0, kick_before = drift = 0 and kick_after = 1 the same kernel gives v = -f/m and leaves u alone.

First the cells (cell_phase.py), then the nodes (node_phase.py). Chunks and node ranges are fixed in number: same bits
on any number of threads.

`params`: kick_before [s], kick_after [s], drift [s], gravity [m/s^2] (3), the parameters of the law (materials/), and
what only some bodies have (lanes.py).
"""

import functools

import taichi as ti

from .cell_phase import make_cell_phase
from .compile_options import KEEP_VECTORS, compiled_with
from .lanes import GRAIN, WIDTH
from .materials import LAWS
from .node_phase import node_phase
from .signatures import Signature, kernel_of


@functools.cache
def make_step(
    kind: str, law: str, signature: Signature, width: int | None = None, damped: bool = False, viscous: bool = False
):
    """Step kernel of a cell kind with a law, memoised; every array flat, u and v [3n], rows zero on entry and exit.

    step(first, end, ranges, *arrays of a `bundles.Body` in the order of the signature): the cells of chunks
    first..end, then the nodes in `ranges` parts (0: none); index arrays from `packing.pack_cells`, packed `width` wide
    (default WIDTH). With a law that has state `commit` comes after `ranges`: whether the points keep what it
    becomes.
    damped: with mass-proportional damping; viscous: with bulk viscosity.
    """
    cell_phase = make_cell_phase(kind, law, width or WIDTH, viscous)

    @ti.func
    def step_and_commit(first, end, ranges, commit, body: ti.template()):
        cell_phase(first, end, body, GRAIN, commit)
        node_phase(body, ranges, GRAIN, damped)

    @ti.func
    def step(first, end, ranges, body: ti.template()):
        step_and_commit(first, end, ranges, 0, body)

    numbers = ("first", "end", "ranges")
    if LAWS[law].state:
        return compiled_with(kernel_of(step_and_commit, signature, (*numbers, "commit")), **KEEP_VECTORS)
    return compiled_with(kernel_of(step, signature, numbers), **KEEP_VECTORS)
