"""The explicit step: internal force of packed cells, then kick and drift of the nodes, in one launch.

    f_i = dW/du_i,   a = g - f/m,   v_n = v + kick_before a,   v <- v_n + kick_after a,   u <- u + drift v

(METHOD 2: leapfrog with kick_before = dt_old/2, kick_after = dt_new/2, drift = dt_new.)
With v = 0, g = 0, kick_before = drift = 0 and kick_after = 1 the kernel gives v = -f/m and does not change u.

The cells come first (cell_phase.py, before it node_volumes.py where volume changes are averaged at nodes), then the
nodes (node_phase.py). The result has the same bits
for the same numbers of chunks and node ranges, on any number of threads. `params`: lanes.py.
"""

import functools

from ..cells.cell_phase import make_cell_phase
from ..cells.node_volumes import make_volume_phase
from ..engine import ti
from ..lanes import GRAIN
from ..language.compile_options import KEEP_VECTORS, compiled_with
from ..language.signatures import Signature, kernel_of
from ..materials import LAWS
from ..nodes.node_phase import node_phase


@functools.cache
def make_step(
    kinds: tuple[tuple[str, str], ...],
    signature: Signature,
    damped: str = "",
    viscous: bool = False,
    cornered: bool = False,
    mixed: bool = False,
    apart: bool = False,
):
    """Return the step kernel for kinds of cells (element, law), memoised.

    step(first, end, ranges, *arrays of a `bundles.Body` in the order of the signature) takes the cells of chunks
    first..end, then the nodes in `ranges` parts (0: none). All arrays are flat; `rows` is zero at the start. For laws
    with state, `commit` follows `ranges`: 1 if the points store their new state.
    damped: name of the damping law (damping.py); viscous: with bulk viscosity; cornered: with contact cells; mixed: in
    mixed precision (mixed_cells.py); apart: averages of all nodes stand there before (`make_volumes`).
    """
    cell_phase, volume_phase = make_cell_phase(kinds, viscous, cornered, mixed), make_volume_phase(kinds)
    count = len(kinds)

    @ti.func
    def step_and_commit(first, end, ranges, commit, body: ti.template()):
        if ti.static(body.averaged):
            last = end
            if ti.static(apart):
                last = ti.select(ranges > 0, first, end)
            volume_phase(first, last, body, GRAIN, ti.min(ranges, 1))
        cell_phase(first, end, body, GRAIN, commit)
        node_phase(body, ranges, count, GRAIN, damped, cornered)

    @ti.func
    def step(first, end, ranges, body: ti.template()):
        step_and_commit(first, end, ranges, 0, body)

    numbers = ("first", "end", "ranges")
    if any(LAWS[law].state for _, law in kinds):
        return compiled_with(kernel_of(step_and_commit, signature, (*numbers, "commit")), **KEEP_VECTORS)
    return compiled_with(kernel_of(step, signature, numbers), **KEEP_VECTORS)


@functools.cache
def make_volumes(kinds: tuple[tuple[str, str], ...], signature: Signature):
    """Return the kernel volumes(first, end, *arrays), memoised: the averages of `make_step` with `apart`.

    The volume changes of the cells in chunks first..end are new, those of other cells stand as they are.
    """
    volume_phase = make_volume_phase(kinds)

    @ti.func
    def volumes(first, end, body: ti.template()):
        volume_phase(first, end, body, GRAIN, 1)

    return compiled_with(kernel_of(volumes, signature, ("first", "end")), **KEEP_VECTORS)
