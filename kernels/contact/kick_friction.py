"""Friction on the components of contact nodes that have mass, as an impulse of the kick (METHOD 3).

    v = v* + M^-1 p,   p = -M v*_T if |p| <= mu lambda span, else scaled to that limit

v* is the velocity relative to the partner after the kick over `span` [s] without friction. Stick is exact, without
creep. The work up to time level n is that of the part of the kick before it, -t.(v^{n-1/2} + v^n)/2 k0. At the last
level, where no step follows, friction is that of a kick into one more step of the same length, so that this row and the
state at the end are those of a run that goes on; only the part of the kick before the level is taken.
An obstacle that moves freely is kicked by the same impulses: v* then has its motion by all other forces, and M^-1 the
motion of its point by a unit impulse. Its nodes are solved one after another, again and again; every such solve lowers
the kinetic energy, so that any number of nodes sticks to a light obstacle.
"""

from ..columns import SUMS
from ..engine import ti
from ..lanes import DRIFT, KICK_AFTER, KICK_BEFORE
from ..language.counted import counted
from ..language.entries import row
from ..language.threads import item, leader, over_threads, put_sums, turns
from ..nodes.boundary_nodes import symmetric
from ..nodes.damping import damped_response
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
from .free_obstacles import begin_free_friction, point_mobility, press_free, wall_acceleration
from .friction import MEAN_SPEED, MOBILITY, SPEED, add_work, layer_limit, node_place, note_kick
from .friction_record import begin_kick, record_kick
from .islands import node_count
from .massive_tangents import kick_force, massive_tangents, without_massless_components

NODE_ROUNDS = 300  # iterations over the rows of a node with several rows, at most; two walls at a small angle take 100
NODE_CHANGE = 1e-13  # change of the forces over the pressing forces at which they end
FREE_ROUNDS = 50  # iterations over all nodes where obstacles move freely, at most
FREE_CHANGE = 1e-8  # change of the forces over the pressing forces at which they end


@ti.func
def kick_span(body: ti.template(), contact: ti.template()):
    """Return the time [s] of the kick for which friction is found; where no step follows, as if another one did.

    Layers, which such a kick would heat twice as long, take it as it is.
    """
    before, after = body.params[KICK_BEFORE], body.params[KICK_AFTER]
    span = before + after
    if ti.static(not contact.options.layered):
        span = before + ti.select(body.params[DRIFT] > 0.0, after, before)
    return span


@ti.func
def velocity_without_friction(body: ti.template(), boundary: ti.template(), k, damped: ti.template()):
    """Return velocity before the kick, acceleration without friction, and acceleration by a unit force [3, 3]."""
    node = boundary.nodes[k]
    velocity = row(body.v, node)
    flexible = symmetric(boundary.inverse_mass, k)
    net = row(boundary.load, k) - row(body.special_force, k)
    net, flexible = damped_response(damped, body, symmetric(boundary.mass, k), velocity, net, flexible)
    return velocity, flexible @ net, flexible


@ti.func
def kick_friction(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), obstacles: ti.template(),
    rigid: ti.template(), damped: ti.template(),
):  # fmt: skip
    """Set the friction of the kick in all rows, and sum up its work."""
    early, late = 0.0, 0.0
    if ti.static(contact.options.free and contact.options.recorded):
        begin_kick(contact)
    if ti.static(contact.options.free):  # one thread takes all nodes, one after another
        if leader(contact) == 1:
            settle_free_friction(body, boundary, contact, rows, obstacles, rigid, damped)
            for k in range(node_count(contact)):
                before, after, _moved, far = kick_friction_node(
                    body, boundary, contact, rows, obstacles, rigid, damped, k
                )
                if ti.static(contact.options.recorded):
                    record_kick(contact, k, before, after, far)
                early += before
                late += after
    else:
        if ti.static(contact.options.recorded):
            begin_kick(contact)
        for turn in range(turns(contact, node_count(contact))):
            k = item(contact, turn)
            before, after, _change, slip = kick_friction_node(
                body, boundary, contact, rows, obstacles, rigid, damped, k
            )
            if ti.static(contact.options.recorded):
                record_kick(contact, k, before, after, slip)
            early += counted(contact, k) * before
            late += counted(contact, k) * after
    if ti.static(contact.options.blocks > 1):
        put_sums(contact, None, (SUMS.friction_before, SUMS.friction_after), [early, late], ("sum", "sum"))
    else:
        works = over_threads(contact, [early, late], ("sum", "sum"))
        add_work(contact, works[0])
        contact.sums[SUMS.friction_after] = works[1]


@ti.func
def settle_free_friction(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), obstacles: ti.template(),
    rigid: ti.template(), damped: ti.template(),
):  # fmt: skip
    """Find the friction on obstacles that move freely, node after node, again and again."""
    begin_free_friction(rigid, obstacles, rows, contact, body)
    for k in range(node_count(contact)):
        clear_node(contact, rows, k)
    for _ in range(FREE_ROUNDS):
        change, pressing = 0.0, 0.0
        for k in range(node_count(contact)):
            for p in ti.static(range(contact.options.slots)):
                pressing += number_of(rows, k * contact.options.slots + p, rows.at.pressing)
            change += kick_friction_node(body, boundary, contact, rows, obstacles, rigid, damped, k)[2]
        if change <= FREE_CHANGE * pressing:
            break


@ti.func
def clear_node(contact: ti.template(), rows: ti.template(), k):
    """Set the friction of the kick of node k to 0."""
    for p in ti.static(range(contact.options.slots)):
        set_vector(rows, k * contact.options.slots + p, rows.at.kick_friction, ti.Vector.zero(ti.f64, 3))


@ti.func
def kick_friction_node(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), obstacles: ti.template(),
    rigid: ti.template(), damped: ti.template(), k,
):  # fmt: skip
    """Set the friction of the rows of node k; return its work [J] before and after the time level, change and slip.

    The change [N] is that of the forces since the last call, where obstacles move freely; the slip [m] the longest one
    of its rows in the step that starts there, where it is recorded.
    """
    slots = ti.static(contact.options.slots)
    before, after, span = body.params[KICK_BEFORE], body.params[KICK_AFTER], kick_span(body, contact)
    work_before, work_after = 0.0, 0.0
    pressed = 0.0
    for p in ti.static(range(slots)):
        pressed += number_of(rows, k * slots + p, rows.at.pressing)
    forces = ti.Matrix.zero(ti.f64, slots, 3)
    moved, slip_path, done, strongest = 0.0, 0.0, 0.0, 0.0
    if ti.static(contact.options.free):
        for p in ti.static(range(slots)):
            known = vector_of(rows, k * slots + p, rows.at.kick_friction)
            for j in ti.static(range(3)):
                forces[p, j] = known[j]
    if pressed > 0.0 and span > 0.0:
        velocity, acceleration, flexible = velocity_without_friction(body, boundary, k, damped)
        for _ in range(ti.static(1 if slots == 1 else NODE_ROUNDS)):
            change = 0.0
            for p in ti.static(range(slots)):
                r = k * slots + p
                pressing = number_of(rows, k * slots + p, rows.at.pressing)
                if pressing > 0.0:
                    others = ti.Vector.zero(ti.f64, 3)
                    for q in ti.static(range(slots)):
                        if q != p:
                            others += ti.Vector([forces[q, j] for j in ti.static(range(3))])
                    across, presses = massive_tangents(contact, k, normal_of(rows, r))
                    wall = velocity_of(rows, r, rows.at.velocity)
                    relative_mobility = flexible
                    if ti.static(contact.options.free):
                        own = ti.Vector([forces[p, j] for j in ti.static(range(3))])
                        given = point_mobility(rigid, obstacles, contact, body, k, r)
                        wall += span * (wall_acceleration(rigid, obstacles, contact, body, k, r) + given @ own)
                        relative_mobility += given
                    relative = velocity + span * (acceleration + flexible @ others) - wall
                    if ti.static(contact.options.static_friction):
                        relative = without_massless_components(contact, k, relative)
                    slip = across @ relative
                    limit = friction_cone(rows, r, pressing)
                    if ti.static(contact.options.layered):
                        limit = layer_limit(contact, k, limit, sum_of_cones(rows, k, pressing_of(rows, k)))
                    if ti.static(contact.options.static_friction):
                        there = vector_of(rows, k * slots + p, rows.at.traction)
                        limit = limit_beside(contact, across, there, slip, limit)
                    mobility = span * (across @ relative_mobility @ across.transpose())
                    if mobility[0, 0] + mobility[1, 1] <= 0.0:
                        limit = 0.0  # no mass: its friction is that of the static solve
                    force = kick_force(contact, rows, k, r, across, presses, mobility, slip, limit)
                    if ti.static(contact.options.free):
                        before_this = ti.Vector([forces[p, j] for j in ti.static(range(3))])
                        moved += (force - before_this).norm()
                        press_free(rigid, obstacles, contact, body, k, r, force - before_this)
                    for j in ti.static(range(3)):
                        change += ti.abs(force[j] - forces[p, j])
                        forces[p, j] = force[j]
            if change <= NODE_CHANGE * pressed:
                break
        total = ti.Vector.zero(ti.f64, 3)
        for p in ti.static(range(slots)):
            total += ti.Vector([forces[p, j] for j in ti.static(range(3))])
        acceleration += flexible @ total
        for p in ti.static(range(slots)):
            force = ti.Vector([forces[p, j] for j in ti.static(range(3))])
            first = velocity - velocity_of(rows, k * slots + p, rows.at.velocity)
            rate = acceleration
            if ti.static(contact.options.free):
                rate = rate - wall_acceleration(rigid, obstacles, contact, body, k, k * slots + p)
            middle = first + before * rate
            last = first + span * rate
            early = 0.0 - 0.5 * before * force.dot(first + middle)
            late = 0.0 - 0.5 * after * force.dot(middle + last)
            work_before += early
            work_after += late
            if ti.static(contact.options.recorded and not contact.options.static_friction):
                if number_of(rows, k * slots + p, rows.at.pressing) > 0.0:
                    across = massive_tangents(contact, k, normal_of(rows, k * slots + p))[0]
                    slip_path = ti.max(slip_path, body.params[DRIFT] * (across @ last).norm())
            done = done + early + late
    for p in ti.static(range(slots)):
        force = ti.Vector([forces[p, j] for j in ti.static(range(3))])
        set_vector(rows, k * slots + p, rows.at.kick_friction, force)
        if ti.static(contact.options.layered):
            strongest = ti.max(strongest, friction_of_row(contact, rows, k * slots + p, force).norm())
    if ti.static(contact.options.layered):
        note_kick(contact, k, done, strongest)
    return work_before, work_after, moved, slip_path


@ti.func
def limit_beside(contact: ti.template(), across, there, slip, limit):
    """Return the largest friction k [N] of the kick in a row that has friction t [3] [N] of the static solve.

    Together they have the limit c. Where friction layers have changed it since the static solve, t may be along the
    slip [2]: k = -a + sqrt(a^2 + c^2 - t^2) with the part a of t against it, c - |t| where all of t is. Else c is that
    of the static solve, and t has it where it slips: k = sqrt(c^2 - t^2).
    """
    rest = limit * limit - there.dot(there)
    if ti.static(contact.options.layered):
        against = 0.0 - (across @ there).dot(slip) / ti.max(slip.norm(), 1e-300)
        rest = ti.max(0.0, ti.sqrt(ti.max(0.0, against * against + rest)) - against)
    else:
        rest = ti.sqrt(ti.max(0.0, rest))
    return rest


@ti.func
def friction_of_row(contact: ti.template(), rows: ti.template(), r, force):
    """Return the friction [3] [N] of row r out of that of the kick and, where it has one, of the static solve."""
    if ti.static(contact.options.static_friction):
        force = force + vector_of(rows, r, rows.at.traction)
    return force


@ti.func
def layer_slip(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), damped: ti.template()
):
    """Set the input of the friction layers: slip speed of every node without friction, and its change by a force."""
    for turn in range(turns(contact, node_count(contact))):
        k = item(contact, turn)
        layer_slip_node(body, boundary, contact, rows, damped, k)


@ti.func
def layer_slip_node(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), damped: ti.template(), k
):
    """Set slip speed and mobility of node k at the row with the largest pressing force."""
    slots = ti.static(contact.options.slots)
    span = kick_span(body, contact)
    largest, speed, mobility, mean = 0.0, 0.0, 0.0, 0.0
    for p in ti.static(range(slots)):
        r = k * slots + p
        pressing = number_of(rows, k * slots + p, rows.at.pressing)
        if pressing > largest:
            largest = pressing
            across = massive_tangents(contact, k, normal_of(rows, r))[0]
            velocity, acceleration, flexible = velocity_without_friction(body, boundary, k, damped)
            wall = velocity_of(rows, r, rows.at.velocity)
            slip = across @ (velocity + span * acceleration - wall)
            speed = slip.norm()
            if speed > 0.0:
                mean = 0.5 * slip.dot(slip + across @ (velocity - wall)) / speed
                mobility = slip.dot(span * (across @ flexible @ across.transpose()) @ slip) / (speed * speed)
    contact.friction[node_place(k, SPEED)] = speed
    contact.friction[node_place(k, MOBILITY)] = mobility
    contact.friction[node_place(k, MEAN_SPEED)] = mean
