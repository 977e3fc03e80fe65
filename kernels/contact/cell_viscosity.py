"""Viscosity of the contact cells: a Kelvin-Voigt stress that damps oscillations at mesh scale in sliding (METHOD 3).

    sigma_v = eta (lambda tr D I + 2 mu D),   f_k = int sigma_v grad N_k dv,   eta = beta h/c

D is the strain rate of the step that ends at the present positions x, with H = d(x - x_before)/dx:

    D = (H + H^t - H^t H) / (2 dt) = F^-t (E - E_before)/dt F^-1

the rate of Green's strain, pushed forward: exactly zero for a rigid motion with any rotation in a step. The linear law
measures forces and strains in the reference state; its viscosity is D = (H + H^t)/(2 dt) with H = d(x - x_before)/dX.
The integration is that of the elastic force: points, one volume change, or mean gradient with hourglass stiffness.

In the static solve x are the positions of the iteration and x_before those of the last time level, so that massless
components are damped implicitly, with the tangent K + eta/dt K of a cell (exact for the linear law; of a metal see
static/damping_tangent.py). On components with mass the force of the step before the kick acts, explicitly. A step
dissipates (f^{n-1} + f^n)/2 . (x^n - x^{n-1}).
"""

import functools

from .. import elements
from ..cells.cell_phase import gather
from ..engine import ti
from ..lanes import (
    CHUNK_BITS,
    CHUNK_COUNT,
    CONNECTIVITY,
    CONTACT_BLOCK,
    END_PACK,
    FIRST_CELL,
    FIRST_PACK,
    GRAIN,
    LAME,
    LANE,
    LAST_CELL,
    MATERIAL,
    ROW,
    SEGMENT,
    WIDTH,
)
from ..language import tensor3
from ..language.compile_options import KEEP_VECTORS, compiled_with
from ..language.entries import put_three, row, three
from ..language.signatures import Signature, kernel_of
from ..language.threads import item, leader, over_threads, put_sums, turns
from ..language.vectors import MASK, load
from ..materials import LAWS, linear_elastic
from ..materials.law import Law
from ..nodes.device_nodes import first_of_corner
from .islands import island_count

# The array `viscous` holds: the numbers below; displacement and viscous force [s, 3] of the boundary nodes at the last
# time level; eta [s] of the contact cells, by lanes of their packs; their corner forces; eta of the contact cells in
# the order of `Pairs`. Where cells have threads, the lanes and corner forces stand as device_viscosity.py says.
# numbers: 1/dt [1/s]; power of the last step [W]; counts of boundary nodes, lanes and corners; first lane and first
# force row of the contact cells among those of all cells, of threads their first place in `connectivity`
RATE, POWER, NODES, LANES, CORNERS, FIRST_LANE, FIRST_ROW = 0, 1, 2, 3, 4, 5, 6
NUMBERS = 7


@ti.func
def force_place(viscous: ti.template()):
    """Return the start of the viscous forces; the displacements stand before them, from NUMBERS on."""
    return NUMBERS + 3 * int(viscous[NODES])


@ti.func
def eta_place(viscous: ti.template()):
    """Return the start of eta by lanes."""
    return NUMBERS + 6 * int(viscous[NODES])


@ti.func
def rows_place(viscous: ti.template()):
    """Return the start of the corner forces."""
    return eta_place(viscous) + int(viscous[LANES])


@ti.func
def cells_place(viscous: ti.template()):
    """Return the start of eta by contact cells."""
    return rows_place(viscous) + 3 * int(viscous[CORNERS])


@ti.func
def stress_of_step(h, parameters):
    """Return [sigma, sigma:e/2, tr e] for the strain e = (H + H^t - H^t H)/2 of a step, in the form of a law."""
    square = tensor3.transposed_product(h, h)
    e = [[0.5 * ((h[i][j] + h[j][i]) - square[i][j]) for j in range(3)] for i in range(3)]
    trace = tensor3.trace(e)
    stress = tensor3.plus_identity(tensor3.scaled(2.0 * parameters[1], e), parameters[0] * trace)
    return [stress, 0.5 * tensor3.dot(stress, e), trace]


STEP_LAW = Law(("lam", "mu"), stress_of_step, ())


@ti.func
def at_rest(corner, c: ti.template()):
    """Return component c of the reference position of a corner from its position and displacement (6)."""
    return corner[c]


@ti.func
def present(corner, c: ti.template()):
    """Return component c of the present position of a corner from its position and displacement (6)."""
    return corner[c] + corner[3 + c]


def step_parts(kind: str, law: str, thread: bool = False):
    """Return force function, law and positions of the viscosity of a kind of cell with a law.

    The functions give the force of a step, and a component of the position of a corner that the force is taken at;
    thread: for a thread with a cell of its own.
    """
    if LAWS[law].linear and elements.FUNCTIONS[kind].averaged:  # its viscosity is that of the change of shape alone
        return elements.step_force_of(kind, thread), linear_elastic.LAW, at_rest
    if LAWS[law].linear:
        element = elements.UNSTORED.get(kind, kind)
        return (elements.thread_force_of if thread else elements.force_of)(element, law), linear_elastic.LAW, at_rest
    return elements.step_force_of(kind, thread), STEP_LAW, present


def make_block_viscosity(kind: str, law: str):
    """Return block_viscosity(body, viscous, first, end): it sets the corner forces of contact cells of a kind and law.

    first, end: segments (cell_phase.py) of a chunk.
    """
    corners, width = elements.CORNERS[kind], WIDTH
    force_of, law_of, place_of = step_parts(kind, law)

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
    """Return viscous_phase(body, viscous, stride), which sets the viscous corner forces of all contact cells; memoised.

    cells: their kinds (element, law). The second half of the chunks of a `bundles.Body` holds the contact cells;
    stride: as in cell_phase.py.
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
    """Return the viscous phase as a parallel kernel, for many contact cells.

    signature: of a Body and a Launch with viscous_cells.
    """
    viscous_phase = make_viscous_phase(cells)

    @ti.func
    def viscous_pass(body: ti.template(), launch: ti.template()):
        viscous_phase(body, launch.viscous_cells, GRAIN)

    return compiled_with(kernel_of(viscous_pass, signature), **KEEP_VECTORS)


@ti.func
def earlier(body: ti.template(), viscous: ti.template(), start, width: ti.template()):
    """Return the displacement (3) of a corner at the last time level, each component a vector over the lanes."""
    number = [(body.node_info[body.connectivity[start + lane]] >> (2 * CHUNK_BITS)) - 1 for lane in range(width)]
    at = [(NUMBERS + 3 * s) & MASK for s in number]
    return [ti.Vector([viscous[i + c] for i in at]) for c in range(3)]


@ti.func
def viscous_force(body: ti.template(), contact: ti.template(), viscous: ti.template(), s):
    """Return the viscous force [3] of boundary node s, summed over its contact cells."""
    total = ti.Vector.zero(ti.f64, 3)
    if ti.static(contact.options.threads > 1):
        for i in range(body.corner_rows[s], body.corner_rows[s + 1]):
            first = rows_place(viscous) + first_of_corner(body.corner_rows[i] - int(viscous[FIRST_ROW]))
            for j in ti.static(range(3)):
                total[j] += viscous[first + j * WIDTH]
    else:
        first = rows_place(viscous) - 3 * int(viscous[FIRST_ROW])
        for i in range(body.corner_rows[s], body.corner_rows[s + 1]):
            total += three(viscous, first + 3 * body.corner_rows[i])
    return total


@ti.func
def viscous_load(body: ti.template(), boundary: ti.template(), contact: ti.template(), viscous: ti.template()):
    """Add the viscous force to that of the cells, set its power, and store displacement and force for the next step."""
    power = 0.0
    for turn in range(turns(contact, boundary.nodes.shape[0])):
        s = item(contact, turn)
        place = NUMBERS + 3 * s
        now, last = viscous_force(body, contact, viscous, s), three(viscous, force_place(viscous) + 3 * s)
        here = row(body.u, boundary.nodes[s])
        power += 0.5 * (now + last).dot(here - three(viscous, place))
        for j in ti.static(range(3)):
            body.special_force[3 * s + j] = body.special_force[3 * s + j] + now[j]
        put_three(viscous, force_place(viscous) + 3 * s, now)
        put_three(viscous, place, here)
    if ti.static(contact.options.blocks > 1):
        put_sums(contact, None, [contact.sums.shape[0] + island_count(contact)], [power], ("sum",))
    else:
        power = over_threads(contact, [power], ("sum",))[0]
        if leader(contact) == 1:
            viscous[POWER] = power * viscous[RATE]


@ti.func
def stiffen(pairs: ti.template(), contact: ti.template(), viscous: ti.template(), block: ti.template(), number):
    """Multiply the stiffness of the cells of contact block `number` by 1 + eta/dt, to include their viscosity."""
    at = number * CONTACT_BLOCK
    first_cell = pairs.blocks[at + FIRST_CELL]
    for turn in range(turns(contact, pairs.blocks[at + LAST_CELL] - first_cell)):
        cell = first_cell + item(contact, turn)
        factor = 1.0 + viscous[RATE] * viscous[cells_place(viscous) + cell]
        for i in range(pairs.start[cell] * block * block, pairs.start[cell + 1] * block * block):
            pairs.values[i] = factor * pairs.values[i]
