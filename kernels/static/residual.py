"""Right side and residual of the static solve at the present state (solve.py).

right = B^t (f_ext - f),   residual: the largest over the nodes of what contact does not balance of it
"""

from ..contact.cell_viscosity import viscous_force
from ..contact.constraint_rows import EPSILON, sum_of_rows
from ..contact.islands import first_node
from ..contact.pair_rows import collect as collect_forces
from ..engine import ti
from ..lanes import WIDTH
from ..language.entries import row
from ..language.threads import item, item_between, leader, over_threads, turns, turns_between
from ..nodes.device_nodes import first_of_corner
from .chosen_rows import choose_rows
from .control import (
    BEFORE,
    F_REF,
    MINIMUM_FORCE,
    REACH,
    RESIDUAL,
    ROUNDING,
    SETTINGS,
    STATS,
    STIFFEST,
)
from .massless_node import (
    along,
    balance,
    constraint_violation,
    constraints,
    entries,
    largest,
    unbalanced,
)
from .sliding import measure_slip


@ti.func
def assemble(
    body: ti.template(),
    boundary: ti.template(),
    contact: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    system: ti.template(),
    viscous: ti.template(),
    island,
):
    """Set the right sides and constraints of the linear problem of an island, and measure its static residual."""
    scale, residual, rounding = measure_nodes(body, boundary, contact, rows, coupling, system, viscous, island)
    if ti.static(contact.options.coupled):
        begin = first_node(contact, island)
        if ti.static(rows.at.lift >= 0):
            reach = system.settings[island * SETTINGS + REACH]
            for turn in range(turns(contact, first_node(contact, island + 1) - begin)):
                choose_rows(contact, rows, system, begin + item(contact, turn), reach)
        collect_forces(coupling, contact, rows, system.right, 0, system.stiffness.shape[0], contact.options.block)
        for turn in range(turns(contact, first_node(contact, island + 1) - begin)):
            k = begin + item(contact, turn)
            residual = ti.max(residual, assemble_node(body, boundary, contact, rows, coupling, system, k))
    largest_of = over_threads(contact, [scale, residual, rounding], ("max", "max", "max"))
    if leader(contact) == 1:
        note_measure(system, island, largest_of[0], largest_of[1], largest_of[2])


@ti.func
def measure_nodes(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), coupling: ti.template(),
    system: ti.template(), viscous: ti.template(), island,
):  # fmt: skip
    """Set right sides and, but for pairs, constraints of an island; return force scale, residual and rounding [N].

    They are the largest ones of the nodes of this thread.
    """
    scale = system.settings[island * SETTINGS + MINIMUM_FORCE]
    residual = 0.0
    rounding = 0.0
    begin = first_node(contact, island)
    for turn in range(turns_between(contact, begin, first_node(contact, island + 1))):
        k = item_between(contact, begin, turn)
        rounding = ti.max(rounding, rounding_of_node(body, contact, system, island, k))
        scale = ti.max(scale, measure_node(body, boundary, contact, system, viscous, k))
        if ti.static(not contact.options.coupled):
            residual = ti.max(residual, assemble_node(body, boundary, contact, rows, coupling, system, k))
    return scale, residual, rounding


@ti.func
def note_measure(system: ti.template(), island, scale, residual, rounding):
    """Note the force scale of an island [N], its residual [N] and the rounding error of that [N]."""
    stats = ti.static(system.stats)
    at = island * STATS
    stats[at + F_REF] = scale
    stats[at + BEFORE] = stats[at + RESIDUAL]
    stats[at + RESIDUAL] = residual / scale
    stats[at + ROUNDING] = rounding / scale


@ti.func
def rounding_of_node(body: ti.template(), contact: ti.template(), system: ti.template(), island, k):
    """Return the rounding error [N] of the residual of node k."""
    moved = row(body.u, contact.nodes[k]).norm() * system.stats[island * STATS + STIFFEST]
    if contact.compliance[k] > 0.0:
        moved += (row(contact.reference, k) + row(body.u, contact.nodes[k])).norm() / contact.compliance[k]
    return EPSILON * moved


@ti.func
def measure_node(
    body: ti.template(),
    boundary: ti.template(),
    contact: ti.template(),
    system: ti.template(),
    viscous: ti.template(),
    k,
):
    """Set the right side B^t (f_ext - f) of node k; return the sum of |f_cell| [N]."""
    force, magnitude = collect(body, contact, k)
    if ti.static(contact.options.viscous):
        force += viscous_force(body, contact, viscous, k)
    set_right(boundary, contact, system, k, force)
    return magnitude


@ti.func
def set_right(boundary: ti.template(), contact: ti.template(), system: ti.template(), k, force):
    """Set the right side B^t (f_ext - f) of node k; force [3] [N]: f."""
    block = ti.static(contact.options.block)
    stride = system.stiffness.shape[0]
    right = along(contact, k, row(boundary.load, k) - force)
    for j in ti.static(range(block)):
        system.right[j * stride + k] = right[j]


@ti.func
def assemble_node(
    body: ti.template(),
    boundary: ti.template(),
    contact: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    system: ti.template(),
    k,
):
    """Set the constraints of node k; return its residual [N] with the right side, of pairs T^t times it."""
    block, slots = ti.static(contact.options.block, contact.options.slots)
    stride = system.stiffness.shape[0]
    normals, gaps = constraints(contact, rows, k, block, slots)
    out_of_balance = 0.0 - entries(system.right, k, stride, 0, block)
    residual = 0.0
    if ti.static(contact.options.static_friction):
        out_of_balance = out_of_balance - along(contact, k, sum_of_rows(rows, k, rows.at.traction))
        pressing, _rest = balance(out_of_balance, normals, contact.active[k], block, slots)
        residual = measure_slip(body, boundary, contact, rows, coupling, k, pressing)
    rest = unbalanced(out_of_balance, normals, gaps, contact.active[k], contact.compliance[k], block, slots)
    residual = ti.max(residual, largest(rest))
    # a linearised gap is not the gap, and a wall may have moved away from a node that was predicted to move with it
    closed = ti.Vector([(contact.active[k] >> p) & 1 for p in ti.static(range(slots))])
    residual = ti.max(residual, system.stiffness[k] * constraint_violation(contact, rows, k, gaps, closed, slots))
    if ti.static(rows.at.lift < 0):  # else choose_rows has set them
        for p in ti.static(range(slots)):
            system.gaps[p * stride + k] = gaps[p]
            for j in ti.static(range(block)):
                system.normals[(p * block + j) * stride + k] = normals[p, j]
    return residual


@ti.func
def collect(body: ti.template(), contact: ti.template(), k):
    """Return the sum of the forces of the contact cells at node k [3], and the sum of their magnitudes [N]."""
    force = ti.Vector.zero(ti.f64, 3)
    magnitude = 0.0
    for i in range(body.corner_rows[k], body.corner_rows[k + 1]):
        part = corner_force(body, contact, body.corner_rows[i])
        force += part
        magnitude += part.norm()
    return force, magnitude


@ti.func
def corner_force(body: ti.template(), contact: ti.template(), place):
    """Return the force [3] of a corner of a contact cell from its row, or from its place where cells have threads."""
    force = ti.Vector.zero(ti.f64, 3)
    if ti.static(contact.options.threads > 1):
        for j in ti.static(range(3)):
            force[j] = body.rows[first_of_corner(place) + j * WIDTH]
    else:
        force = row(body.rows, place)
    return force
