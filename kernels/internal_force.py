"""The explicit step: internal force of packed cells, then kick and drift of the nodes, in one launch.

    f_i = dW/du_i,   a = g - f/m,   v_n = v + kick_before a,   v <- v_n + kick_after a,   u <- u + drift v

(METHOD 2: leapfrog with kick_before = dt_old/2, kick_after = dt_new/2, drift = dt_new.)
With v = 0, g = 0, kick_before = drift = 0 and kick_after = 1 the same kernel gives v = -f/m and leaves u alone.

First the cells (cell_phase.py), then the nodes (node_phase.py). Chunks and node ranges are fixed in number: same bits
on any number of threads.

`params`: kick_before [s], kick_after [s], drift [s], gravity [m/s^2] (3), up to 3 moduli of the law [Pa] (laws.py), and
what only some bodies have (lanes.py).
"""

import functools

import taichi as ti

from .arguments import ARRAY, INDEX
from .bundles import Body
from .cell_phase import make_cell_phase
from .compile_options import KEEP_VECTORS, compiled_with
from .lanes import GRAIN, WIDTHS
from .node_phase import node_phase


@functools.cache
def make_step(kind: str, law: str, width: int | None = None, damped: str = "", viscous: bool = False):
    """Step kernel of a cell kind with a law, memoised; every array flat, u and v [3n], rows zero on entry and exit.

    step(first, end, ranges, connectivity, chunk_table, node_info, position, mass, params, u, v, rows,
    special_force_out, node_sums_out, cell_sums_out): the cells of chunks first..end, then the nodes in `ranges` parts
    (0: none); index arrays from `packing.pack_cells`, packed `width` wide (default WIDTHS[kind]).
    damped: name of the law of damping (damping.py); viscous: with bulk viscosity.
    """
    cell_phase = make_cell_phase(kind, law, width or WIDTHS[kind], viscous)

    @ti.kernel
    def step(
        first: ti.i32,
        end: ti.i32,
        ranges: ti.i32,
        connectivity: INDEX,
        chunk_table: INDEX,
        node_info: INDEX,
        position: ARRAY,
        mass: ARRAY,
        params: ARRAY,
        u: ARRAY,
        v: ARRAY,
        rows: ARRAY,
        special_force_out: ARRAY,
        node_sums_out: ARRAY,
        cell_sums_out: ARRAY,
    ):
        body = ti.static(
            Body(
                connectivity,
                chunk_table,
                node_info,
                position,
                mass,
                params,
                u,
                v,
                rows,
                special_force_out,
                node_sums_out,
                cell_sums_out,
            )
        )
        cell_phase(first, end, body, GRAIN)
        node_phase(body, ranges, GRAIN, damped)

    return compiled_with(step, **KEEP_VECTORS)
