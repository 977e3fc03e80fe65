"""Lanczos vectors on a GPU for the stable step with viscous contact cells (schemes/explicit/damped_step.py).

Momenta p and displacements x = M^-1 p, with the mass tensors of the boundary nodes in M; r a rate [1/s]:

    q = K x_k + r C x_k - beta_(k-1) p_(k-1),  alpha_k = x_k.q,  q <- P (q - alpha_k p_k),  y = M^-1 q,
    beta_k^2 = q.y,  p_(k+1) = q/beta_k,  x_(k+1) = y/beta_k

P takes off the massless and supported components of the boundary nodes, on which M^-1 is 0.

K x = (f(u + s x) - f(u))/s, as accelerations by the ordinary masses; C x: viscous forces of a step s x that ends at u,
over s, at the boundary nodes. The momenta are kept in 32 bits. Sums over the threads are made by a fixed tree.
"""

import functools

from ..contact.cell_viscosity import FIRST_ROW, NUMBERS, rows_place
from ..engine import ti
from ..lanes import CHUNK_BITS, DEVICE_BLOCK, WIDTH
from ..language.arguments import ARRAY, INDEX
from ..language.threads import turns_of
from ..nodes.boundary_nodes import symmetric
from ..nodes.device_nodes import first_of_corner
from .device_folds import make_fold

SUMS, LARGEST = 3, 3  # sums of a launch, and the place of the largest number behind them


@functools.cache
def make_damped_lanczos(threads: int):
    """Return the kernels by name, for so many threads a loop, memoised; first, end: nodes of the body."""

    @ti.kernel
    def take_places(u: ARRAY, nodes: INDEX, viscous: ARRAY):
        """Let the step of the viscous cells begin at u itself."""
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for i in range(nodes.shape[0] * 3):
            viscous[NUMBERS + i] = u[3 * nodes[i // 3] + i % 3]

    @ti.kernel
    def displace(
        u: ARRAY, node_info: INDEX, p: ARRAY, x: ARRAY, by: ti.f64, scale: ti.f64, first: ti.i32, end: ti.i32,
        trial: ARRAY, answer: ARRAY, viscous: ARRAY, kept: INDEX,
    ):  # fmt: skip
        """Multiply p and x by a number, keep p and prepare the products; scale: s."""
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(threads):
            for turn in range(turns_of(t, threads, end - first)):
                node = first + t + turn * threads
                s = (node_info[node] >> (2 * CHUNK_BITS)) - 1
                for j in ti.static(range(3)):
                    i = 3 * node + j
                    momentum, moved = by * p[i], by * x[i]
                    p[i], x[i] = momentum, moved
                    trial[i], answer[i] = u[i] + scale * moved, 0.0
                    if s >= 0:
                        viscous[NUMBERS + 3 * s + j] = u[i] - scale * moved
                    kept[i - 3 * first] = ti.bit_cast(ti.cast(momentum, ti.f32), ti.i32)

    @ti.kernel
    def respond(
        here: ARRAY, answer: ARRAY, mass: ARRAY, node_info: INDEX, corner_rows: INDEX, viscous: ARRAY, x: ARRAY,
        q: ARRAY, rate: ti.f64, beta: ti.f64, over: ti.f64, first: ti.i32, end: ti.i32, partial: ARRAY,
    ):  # fmt: skip
        """Put K x + r C x - beta q into q; sum up x.q, x.K x and x.C x; over: 1/s."""
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(threads):
            sums = [0.0, 0.0, 0.0]
            for turn in range(turns_of(t, threads, end - first)):
                node = first + t + turn * threads
                s = (node_info[node] >> (2 * CHUNK_BITS)) - 1
                resisting = ti.Vector.zero(ti.f64, 3)
                if s >= 0:
                    for entry in range(corner_rows[s], corner_rows[s + 1]):
                        at = rows_place(viscous) + first_of_corner(corner_rows[entry] - int(viscous[FIRST_ROW]))
                        for j in ti.static(range(3)):
                            resisting[j] += viscous[at + j * WIDTH]
                for j in ti.static(range(3)):
                    i = 3 * node + j
                    stiff, resists = mass[node] * (here[i] - answer[i]) * over, resisting[j] * over
                    value = stiff + rate * resists
                    if beta > 0.0:
                        value -= beta * q[i]
                    q[i] = value
                    sums[0] += x[i] * value
                    sums[1] += x[i] * stiff
                    sums[2] += x[i] * resists
            for k in ti.static(range(SUMS)):
                partial[k * threads + t] = sums[k]
            partial[LARGEST * threads + t] = 0.0

    @ti.kernel
    def reduce(
        q: ARRAY, p: ARRAY, x: ARRAY, mass: ARRAY, inverse_mass: ARRAY, moving: ARRAY, node_info: INDEX, alpha: ti.f64,
        first: ti.i32, end: ti.i32, partial: ARRAY,
    ):  # fmt: skip
        """Take alpha p off q, project it by P and put M^-1 q into x; sum up q.x, and find the largest number of x."""
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(threads):
            total, most = 0.0, 0.0
            for turn in range(turns_of(t, threads, end - first)):
                node = first + t + turn * threads
                s = (node_info[node] >> (2 * CHUNK_BITS)) - 1
                value, moved = ti.Vector.zero(ti.f64, 3), ti.Vector.zero(ti.f64, 3)
                for j in ti.static(range(3)):
                    value[j] = q[3 * node + j]
                    if alpha != 0.0:
                        value[j] -= alpha * p[3 * node + j]
                if s >= 0:
                    value = symmetric(moving, s) @ value
                    moved = symmetric(inverse_mass, s) @ value
                elif mass[node] > 0.0:
                    moved = value / mass[node]
                for j in ti.static(range(3)):
                    q[3 * node + j] = value[j]
                    x[3 * node + j] = moved[j]
                    most = ti.max(most, ti.abs(moved[j]))
                total += value.dot(moved)
            partial[t], partial[LARGEST * threads + t] = total, most
            for k in ti.static(range(1, SUMS)):
                partial[k * threads + t] = 0.0

    @ti.kernel
    def add_kept(kept: INDEX, weight: ti.f64, fresh: ti.i32, first: ti.i32, end: ti.i32, start: ARRAY):
        """Add a kept vector times its weight to `start`, which is 0 before if it is fresh."""
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(threads):
            for turn in range(turns_of(t, threads, 3 * (end - first))):
                i = t + turn * threads
                old = start[3 * first + i]
                if fresh > 0:
                    old = 0.0
                start[3 * first + i] = old + weight * ti.cast(ti.bit_cast(kept[i], ti.f32), ti.f64)

    own = (take_places, displace, respond, reduce, add_kept)
    return {kernel.__name__: kernel for kernel in own} | {"fold": make_fold(threads, ("sum",) * SUMS + ("max",))}
