"""Viscosity of the contact cells: a Kelvin-Voigt stress that damps the mesh-scale flutter of sliding (METHOD 3).

    sigma_v = eta (lambda tr D I + 2 mu D),   f_k = int sigma_v grad N_k dv,   eta = beta h/c

D is the strain rate of the step that ends at the present positions x, with H = d(x - x_before)/dx:

    D = (H + H^t - H^t H) / (2 dt) = F^-t (E - E_before)/dt F^-1

the rate of Green's strain, pushed forward: exactly zero for a rigid motion, however far it turns in a step. The linear
law measures forces and strains in the reference state, and so does its viscosity: D = (H + H^t)/(2 dt), H by X there.
Cells are integrated as their elastic force is: points, one volume change, or mean gradient with hourglass stiffness.

The force is part of f wherever contact asks for it. In the static solve x are the positions of the iteration and
x_before those of the row before, so that massless components are damped implicitly, with K + eta/dt K as the tangent of
a cell (exact for the linear law). On components with mass it acts as the rate of the step before the kick, explicitly.
The dissipation of that step is  (f^{n-1} + f^n)/2 . (x^n - x^{n-1}).
"""

import functools

import taichi as ti

from .. import elements
from ..cells.cell_phase import gather
from ..lanes import (
    CHUNK_BITS,
    CHUNK_COUNT,
    CONNECTIVITY,
    END_PACK,
    FIRST_PACK,
    GRAIN,
    LAME,
    LANE,
    MATERIAL,
    ROW,
    SEGMENT,
    WIDTH,
)
from ..language import tensor3
from ..language.compile_options import KEEP_VECTORS, compiled_with
from ..language.signatures import Signature, kernel_of
from ..language.vectors import MASK, load
from ..materials import LAWS, linear_elastic
from ..nodes.boundary_nodes import row
from .friction import put_three, three

# `viscous`, one array: numbers, of every boundary node [s, 3] the displacement and the viscous force of the last row,
# eta [s] of every contact cell in the lanes of their packs, the force of every corner there, and eta of the contact
# cells in the order of their pairs.
# numbers: 1/dt [1/s] of the rates, power of the last step [W]; boundary nodes, lanes, corners, and where
# lanes and own rows of contact cells begin among those of all cells
RATE, POWER, NODES, LANES, CORNERS, FIRST_LANE, FIRST_ROW = 0, 1, 2, 3, 4, 5, 6
NUMBERS = 7


@ti.func
def force_place(viscous: ti.template()):
    """Return where the viscous forces begin; the displacements stand before them, from NUMBERS on."""
    return NUMBERS + 3 * int(viscous[NODES])


@ti.func
def eta_place(viscous: ti.template()):
    return NUMBERS + 6 * int(viscous[NODES])


@ti.func
def rows_place(viscous: ti.template()):
    return eta_place(viscous) + int(viscous[LANES])


@ti.func
def cells_place(viscous: ti.template()):
    return rows_place(viscous) + 3 * int(viscous[CORNERS])


@ti.func
def stress_of_step(h, parameters):
    """The law of the increments: [sigma, sigma:e/2, tr e] of the strain e = (H + H^t - H^t H)/2 of a step."""
    square = tensor3.transposed_product(h, h)
    e = [[0.5 * ((h[i][j] + h[j][i]) - square[i][j]) for j in range(3)] for i in range(3)]
    trace = tensor3.trace(e)
    stress = tensor3.plus_identity(tensor3.scaled(2.0 * parameters[1], e), parameters[0] * trace)
    return [stress, 0.5 * tensor3.dot(stress, e), trace]


@ti.func
def at_rest(corner, c: ti.template()):
    """Component c of the reference position of a corner, out of its position and displacement (6)."""
    return corner[c]


@ti.func
def present(corner, c: ti.template()):
    """Component c of the present position of a corner, over the lanes."""
    return corner[c] + corner[3 + c]


def make_block_viscosity(kind: str, law: str):
    """Make block_viscosity(body, viscous, first, end): corner forces of the contact cells of one kind and law.

    first, end: segments (cell_phase.py) of a chunk.
    """
    corners, width = elements.CORNERS[kind], WIDTH
    linear = LAWS[law].linear
    law_of = linear_elastic.update if linear else stress_of_step
    force_of = elements.force_of(kind, law) if linear else elements.FUNCTIONS[kind].step_force
    place_of = at_rest if linear else present

    @ti.func
    def block_viscosity(body: ti.template(), viscous: ti.template(), first, end):
        rate = viscous[RATE]
        for segment in range(first, end):
            at = segment * SEGMENT
            lane_at = eta_place(viscous) + body.segments[at + LANE] - int(viscous[FIRST_LANE])
            row_at = rows_place(viscous) + 3 * (body.segments[at + ROW] - int(viscous[FIRST_ROW]))
            material = body.segments[at + MATERIAL] + LAME
            stiff, shear = rate * body.params[material], rate * body.params[material + 1]
            for pack in range(body.segments[at + FIRST_PACK], body.segments[at + END_PACK]):
                start = body.segments[at + CONNECTIVITY] + pack * (corners * width)
                corner = [gather(body, start + k * width, width) for k in range(corners)]
                past = [earlier(body, viscous, start + k * width, width) for k in range(corners)]
                d = [[corner[k][3 + c] - past[k][c] for k in range(corners)] for c in range(3)]
                x = [[place_of(corner[k], c) for k in range(corners)] for c in range(3)]
                eta = load(viscous, lane_at + pack * width, width)  # 0 in padding lanes
                answer = force_of(x, d, eta, [stiff, shear], law_of, None)
                for k in ti.static(range(corners)):
                    for lane in ti.static(range(width)):
                        place = (row_at + 3 * (start + k * width + lane)) & MASK
                        for c in ti.static(range(3)):
                            viscous[place + c] = answer[0][c][k][lane]

    return block_viscosity


@functools.cache
def make_viscous_phase(cells: tuple[tuple[str, str], ...]):
    """Viscous corner forces of the contact cells of kinds of cells (element, law); memoised.

    viscous_phase(body, viscous, stride): the second half of the chunks of a `bundles.Body` holds the contact cells;
    `viscous` gets the force of every corner of theirs; stride as in cell_phase.py.
    """
    phases, count = [make_block_viscosity(kind, law) for kind, law in cells], len(cells)

    @ti.func
    def viscous_phase(body: ti.template(), viscous: ti.template(), stride: ti.template()):
        chunks = int(body.params[CHUNK_COUNT]) // 2
        for s in range(chunks * stride):
            if s % stride == 0:
                table = (int(body.params[CHUNK_COUNT]) // 2 + s // stride) * (count + 3)
                for i in ti.static(range(count)):
                    phases[i](body, viscous, body.chunk_table[table + i], body.chunk_table[table + i + 1])

    return viscous_phase


@functools.cache
def make_viscous_pass(cells: tuple[tuple[str, str], ...], signature: Signature):
    """The phase as a kernel of its own, for many contact cells; signature: a Body, and a Launch with viscous_cells."""
    viscous_phase = make_viscous_phase(cells)

    @ti.func
    def viscous_pass(body: ti.template(), launch: ti.template()):
        viscous_phase(body, launch.viscous_cells, GRAIN)

    return compiled_with(kernel_of(viscous_pass, signature), **KEEP_VECTORS)


@ti.func
def earlier(body: ti.template(), viscous: ti.template(), start, width: ti.template()):
    """Displacement (3) of one corner at the row before, each a vector over the lanes."""
    number = [(body.node_info[body.connectivity[start + lane]] >> (2 * CHUNK_BITS)) - 1 for lane in range(width)]
    at = [(NUMBERS + 3 * s) & MASK for s in number]
    return [ti.Vector([viscous[i + c] for i in at]) for c in range(3)]


@ti.func
def viscous_force(body: ti.template(), viscous: ti.template(), s):
    """The viscous force [3] of boundary node s, all its contact cells together."""
    total = ti.Vector.zero(ti.f64, 3)
    first = rows_place(viscous) - 3 * int(viscous[FIRST_ROW])
    for i in range(body.corner_rows[s], body.corner_rows[s + 1]):
        total += three(viscous, first + 3 * body.corner_rows[i])
    return total


@ti.func
def viscous_load(body: ti.template(), boundary: ti.template(), viscous: ti.template()):
    """At a row: the viscous force joins that of the cells, its power is taken, and rates count from here."""
    power = 0.0
    for s in range(boundary.nodes.shape[0]):
        place = NUMBERS + 3 * s
        now, last = viscous_force(body, viscous, s), three(viscous, force_place(viscous) + 3 * s)
        here = row(body.u, boundary.nodes[s])
        power += 0.5 * (now + last).dot(here - three(viscous, place))
        for j in ti.static(range(3)):
            body.special_force[3 * s + j] = body.special_force[3 * s + j] + now[j]
        put_three(viscous, force_place(viscous) + 3 * s, now)
        put_three(viscous, place, here)
    viscous[POWER] = power * viscous[RATE]


@ti.func
def stiffen(pairs: ti.template(), viscous: ti.template(), block: ti.template(), begin, end):
    """Pair stiffnesses of contact cells begin .. end with their viscosity: (1 + eta/dt) K of the cell."""
    for cell in range(begin, end):
        factor = 1.0 + viscous[RATE] * viscous[cells_place(viscous) + cell]
        for i in range(pairs.start[cell] * block * block, pairs.start[cell + 1] * block * block):
            pairs.values[i] = factor * pairs.values[i]
