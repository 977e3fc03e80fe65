"""Friction between bodies on the components of contact nodes that have mass, as an impulse of the kick (METHOD 7).

    w_r = v_s - sum_m P_sm v_m,   v = v* + M^-1 B^t t span,   t_r = -W_rr^-1 (w_r - W_rr t_r) if |t_r| <= mu lambda_r

v* is the velocity after the kick over `span` [s] without friction, B has the rows (1, -P), W = span B M^-1 B^t. Rows
are solved one after another, each exactly for the forces of the others (Gauss and Seidel), from the forces of the last
kick; rows of obstacles have the obstacle in place of the masters. Momentum is exact after any number of sweeps.
Friction layers lower the limit; the slip that they are solved with is that of the forces of the last kick in all other
rows.
"""

from ..columns import SUMS
from ..engine import ti
from ..lanes import DRIFT, KICK_AFTER, KICK_BEFORE
from ..language.counted import counted
from ..language.entries import row
from ..language.threads import leader, meet
from ..nodes.boundary_nodes import symmetric
from ..nodes.damping import damped_response
from ..pair_places import FIRST_ENTRY, MASTERS, NODE_ROW, ROWS, SLAVES, VELOCITIES
from .constraint_rows import (
    friction_cone,
    normal_of,
    number_of,
    pressing_of,
    set_vector,
    sum_of_cones,
    vector_of,
    velocity_of,
)
from .friction import KICK_WORK, MEAN_SPEED, MOBILITY, SPEED, WORK, layer_limit, node_place, note_kick, tangents
from .friction_record import begin_kick, record_kick
from .islands import node_count
from .kick_friction import friction_of_row, kick_span, velocity_without_friction
from .massive_tangents import kick_force, massive_tangents
from .pair_rows import entry, pair_row, press_masters, weight

SWEEPS = 100  # over all rows, at most
CHANGE = 1e-10  # change of a force over the largest friction that a row can transmit, at which they end


@ti.func
def node_velocity(body: ti.template(), boundary: ti.template(), coupling: ti.template(), s, after: ti.template()):
    """Return the velocity [3] [m/s] of boundary node s before or after the kick.

    after: after it, with the friction of the last sweep.
    """
    velocity = ti.Vector.zero(ti.f64, 3)
    if ti.static(after):
        first = coupling.lists[VELOCITIES] + 3 * s
        velocity = ti.Vector([coupling.values[first + j] for j in ti.static(range(3))])
    else:
        velocity = row(body.v, boundary.nodes[s])
    return velocity


@ti.func
def accelerate(coupling: ti.template(), s, change):
    """Add to the velocity of boundary node s after the kick."""
    first = coupling.lists[VELOCITIES] + 3 * s
    for j in ti.static(range(3)):
        coupling.values[first + j] = coupling.values[first + j] + change[j]


@ti.func
def mobility_of(body: ti.template(), boundary: ti.template(), damped: ti.template(), s):
    """Return the acceleration [3, 3] [1/kg] of boundary node s by a unit force."""
    zero = ti.Vector.zero(ti.f64, 3)
    inverse, mass = symmetric(boundary.inverse_mass, s), symmetric(boundary.mass, s)
    _net, flexible = damped_response(damped, body, mass, zero, zero, inverse)
    return flexible


@ti.func
def partner(coupling: ti.template(), rows: ti.template(), k, p):
    """Return the row of pairs to which row p of contact node k belongs, -1 for an obstacle."""
    found = -1
    if p == ti.static(rows.options.slots) - 1:
        found = entry(coupling, NODE_ROW, k)
    return found


@ti.func
def apply_impulse(
    body: ti.template(), boundary: ti.template(), coupling: ti.template(), damped: ti.template(), k, r, impulse
):
    """Let an impulse [3] [N s] act on contact node k, and backward on the masters of row r of pairs (-1: none)."""
    accelerate(coupling, k, mobility_of(body, boundary, damped, k) @ impulse)
    if r >= 0:
        for i in range(entry(coupling, FIRST_ENTRY, r), entry(coupling, FIRST_ENTRY, r + 1)):
            m = entry(coupling, MASTERS, i)
            back = (0.0 - weight(coupling, i)) * impulse
            accelerate(coupling, m, mobility_of(body, boundary, damped, m) @ back)


@ti.func
def relative_velocity(
    body: ti.template(), boundary: ti.template(), coupling: ti.template(), rows: ti.template(), k, p, r,
    after: ti.template(),
):  # fmt: skip
    """Return the velocity [3] [m/s] of contact node k relative to the partner of its row p.

    r: the row of pairs that row p is, -1 for an obstacle; after: as in `node_velocity`.
    """
    relative = node_velocity(body, boundary, coupling, k, after)
    if r >= 0:
        for i in range(entry(coupling, FIRST_ENTRY, r), entry(coupling, FIRST_ENTRY, r + 1)):
            there = node_velocity(body, boundary, coupling, entry(coupling, MASTERS, i), after)
            relative = relative - weight(coupling, i) * there
    else:
        relative = relative - velocity_of(rows, k * ti.static(rows.options.slots) + p, rows.at.velocity)
    return relative


@ti.func
def row_mobility(body: ti.template(), boundary: ti.template(), coupling: ti.template(), damped: ti.template(), k, r):
    """Return the acceleration [3, 3] [1/kg] of contact node k relative to its partner by a unit force in its row."""
    total = mobility_of(body, boundary, damped, k)
    if r >= 0:
        for i in range(entry(coupling, FIRST_ENTRY, r), entry(coupling, FIRST_ENTRY, r + 1)):
            square = weight(coupling, i) * weight(coupling, i)
            total += square * mobility_of(body, boundary, damped, entry(coupling, MASTERS, i))
    return total


@ti.func
def limit_of(contact: ti.template(), rows: ti.template(), row_number):
    """Return the largest friction [N] that a row can transmit."""
    limit = friction_cone(rows, row_number, number_of(rows, row_number, rows.at.pressing))
    if ti.static(contact.options.layered):
        k = row_number // ti.static(contact.options.slots)
        limit = layer_limit(contact, k, limit, sum_of_cones(rows, k, pressing_of(rows, k)))
    return limit


@ti.func
def start_from_last_kick(
    body: ti.template(),
    boundary: ti.template(),
    contact: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    damped: ti.template(),
):
    """Set the velocities after the kick with the friction of the last one, as far as rows can still transmit it."""
    slots = ti.static(contact.options.slots)
    span = kick_span(body, contact)
    for s in range(boundary.nodes.shape[0]):
        velocity, acceleration, _flexible = velocity_without_friction(body, boundary, s, damped)
        first = coupling.lists[VELOCITIES] + 3 * s
        last = velocity + span * acceleration
        for j in ti.static(range(3)):
            coupling.values[first + j] = last[j]
    for number in range(slots * node_count(contact)):
        k, p = number // slots, number % slots
        start = vector_of(rows, number, rows.at.kick_friction)
        if limit_of(contact, rows, number) <= 0.0 or span <= 0.0:
            start = ti.Vector.zero(ti.f64, 3)
            set_vector(rows, number, rows.at.kick_friction, start)
        if start.norm_sqr() > 0.0:
            apply_impulse(body, boundary, coupling, damped, k, partner(coupling, rows, k, p), span * start)


@ti.func
def slip_of_row(
    body: ti.template(),
    boundary: ti.template(),
    contact: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    damped: ti.template(),
    number,
):
    """Return slip [2] [m/s] after the kick without the friction of a row, and its change by a unit force [2, 2]."""
    slots = ti.static(contact.options.slots)
    k, p = number // slots, number % slots
    r = partner(coupling, rows, k, p)
    span = kick_span(body, contact)
    across = massive_tangents(contact, k, normal_of(rows, number))[0]
    flexible = row_mobility(body, boundary, coupling, damped, k, r)
    mobility = span * (across @ flexible @ across.transpose())
    own = tangents(normal_of(rows, number)) @ vector_of(rows, number, rows.at.kick_friction)
    last = relative_velocity(body, boundary, coupling, rows, k, p, r, True)
    return across @ last - mobility @ own, mobility


@ti.func
def layer_slip_of_pairs(
    body: ti.template(),
    boundary: ti.template(),
    contact: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    damped: ti.template(),
):
    """Set the input of the friction layers, of the row of each node with the largest pressing force."""
    slots = ti.static(contact.options.slots)
    start_from_last_kick(body, boundary, contact, rows, coupling, damped)
    for k in range(node_count(contact)):
        largest, speed, along, mean = 0.0, 0.0, 0.0, 0.0
        for p in range(slots):
            number = k * slots + p
            if number_of(rows, number, rows.at.pressing) > largest:
                largest = number_of(rows, number, rows.at.pressing)
                slip, mobility = slip_of_row(body, boundary, contact, rows, coupling, damped, number)
                r = partner(coupling, rows, k, p)
                first = relative_velocity(body, boundary, coupling, rows, k, p, r, False)
                speed, along, mean = slip.norm(), 0.0, 0.0
                if speed > 0.0:
                    across = massive_tangents(contact, k, normal_of(rows, number))[0]
                    mean = 0.5 * slip.dot(slip + across @ first) / speed
                    along = slip.dot(mobility @ slip) / (speed * speed)
        contact.friction[node_place(k, SPEED)] = speed
        contact.friction[node_place(k, MOBILITY)] = along
        contact.friction[node_place(k, MEAN_SPEED)] = mean


@ti.func
def kick_pair_friction(
    body: ti.template(),
    boundary: ti.template(),
    contact: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    damped: ti.template(),
):
    """Set the friction of the kick in all rows, and sum up its work."""
    if ti.static(contact.options.recorded):
        begin_kick(contact)
    meet(contact)
    if leader(contact) == 1:  # one row after another
        settle_pair_friction(body, boundary, contact, rows, coupling, damped)
    meet(contact)


@ti.func
def settle_pair_friction(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), coupling: ti.template(),
    damped: ti.template(),
):  # fmt: skip
    """Set the friction of the kick in all rows by one thread, and sum up its work."""
    slots = ti.static(contact.options.slots)
    before, after, span = body.params[KICK_BEFORE], body.params[KICK_AFTER], kick_span(body, contact)
    start_from_last_kick(body, boundary, contact, rows, coupling, damped)
    largest = 0.0
    for number in range(slots * node_count(contact)):
        largest = ti.max(largest, limit_of(contact, rows, number))
    change = 2.0 * CHANGE * largest
    for _sweep in range(SWEEPS):
        if change > CHANGE * largest and span > 0.0:
            change = 0.0
            for number in range(slots * node_count(contact)):
                limit = limit_of(contact, rows, number)
                if limit > 0.0:
                    k, p = number // slots, number % slots
                    old = vector_of(rows, number, rows.at.kick_friction)
                    across, presses = massive_tangents(contact, k, normal_of(rows, number))
                    slip, mobility = slip_of_row(body, boundary, contact, rows, coupling, damped, number)
                    force = kick_force(contact, rows, k, number, across, presses, mobility, slip, limit)
                    change = ti.max(change, (force - old).norm())
                    set_vector(rows, number, rows.at.kick_friction, force)
                    apply_impulse(
                        body, boundary, coupling, damped, k, partner(coupling, rows, k, p), span * (force - old)
                    )
    if ti.static(contact.options.layered):
        for k in range(node_count(contact)):
            strongest = 0.0
            for p in range(slots):
                force = vector_of(rows, k * slots + p, rows.at.kick_friction)
                strongest = ti.max(strongest, friction_of_row(contact, rows, k * slots + p, force).norm())
            note_kick(contact, k, 0.0, strongest)
    early, late = 0.0, 0.0
    for number in range(slots * node_count(contact)):
        force = vector_of(rows, number, rows.at.kick_friction)
        if force.norm_sqr() > 0.0:
            k, p = number // slots, number % slots
            r = partner(coupling, rows, k, p)
            first = relative_velocity(body, boundary, coupling, rows, k, p, r, False)
            last = relative_velocity(body, boundary, coupling, rows, k, p, r, True)
            middle = first + before / span * (last - first)
            early = early - counted(contact, k) * (0.5 * before * force.dot(first + middle))
            late = late - counted(contact, k) * (0.5 * after * force.dot(middle + last))
            if ti.static(contact.options.recorded):
                add, rest = 0.0 - 0.5 * before * force.dot(first + middle), 0.0 - 0.5 * after * force.dot(middle + last)
                across = massive_tangents(contact, k, normal_of(rows, number))[0]
                slip = body.params[DRIFT] * (across @ last).norm()
                record_kick(contact, k, add, rest, slip)
            if ti.static(contact.options.layered):
                work = node_place(k, ti.static(KICK_WORK if contact.options.static_friction else WORK))
                contact.friction[work] = contact.friction[work] - 0.5 * span * force.dot(first + last)
    contact.sums[SUMS.friction_before] = contact.sums[SUMS.friction_before] + early
    contact.sums[SUMS.friction_after] = late
    for r in range(coupling.lists[ROWS]):
        friction = vector_of(rows, pair_row(rows, entry(coupling, SLAVES, r)), rows.at.kick_friction)
        press_masters(coupling, body.special_force, r, friction)
