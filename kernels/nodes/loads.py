"""Loads of the boundary nodes: what boundary.load = f_ext is at a time level, and the work of the loads.

    F_a = weight_a t,    F_a = -p [a x b + xi_a/3 a x d + eta_a/3 d x b]    on corner a of a face

t: force or traction; p: pressure on the bilinear face x = c + a xi + b eta + d xi eta with the corners at xi_a, eta_a =
+-1, and outward normal dx/dxi x dx/deta. F_a is the exact integral of -p N_a n dA, so that a closed surface under a
uniform pressure has no net force and no net moment. A triangle is a face with its last corner twice, exact too.
Work from level n to n+1: sum of (F^n + F^{n+1})/2 . (u^{n+1} - u^n), also of massless nodes, which have no velocity.
load_places.py says where the data stand.
"""

from ..columns import APPLIED
from ..engine import ti
from ..lanes import GRAVITY, KICK_BEFORE
from ..language.entries import put_three, row, three
from ..language.threads import item, leader, over_threads, turns
from ..load_places import (
    ASKS,
    ENTRIES,
    ENTRY,
    FACE,
    FACES,
    FORCE,
    FORCE_BEFORE,
    HEAD,
    NODE,
    NODES,
    PLACE_BEFORE,
    PULLS,
    STARTED,
    STRIDE,
    SUMS_AT,
)
from .boundary_nodes import symmetric, weight

XI, ETA = (-1.0, 1.0, 1.0, -1.0), (-1.0, -1.0, 1.0, 1.0)


@ti.func
def head(boundary: ti.template(), place):
    """Return a number at the head of the data."""
    return int(boundary.load[3 * boundary.nodes.shape[0] + place])


@ti.func
def asks(boundary: ti.template()):
    """Return 1 if the host must compute the loads of a level after the nodes have moved."""
    return head(boundary, ASKS)


@ti.func
def apply_loads(body: ti.template(), boundary: ti.template(), number):
    """Set the loads of the boundary nodes to those of row `number`, at the present positions."""
    load = ti.static(boundary.load)
    node_at = 3 * boundary.nodes.shape[0] + HEAD
    entry_at = node_at + NODE * head(boundary, NODES)
    face_at = entry_at + ENTRY * head(boundary, ENTRIES)
    row_at = face_at + FACE * head(boundary, FACES) + number * head(boundary, STRIDE)
    if head(boundary, PULLS) == 1:
        put_three_from(body.params, GRAVITY, load, row_at)
        for s in range(boundary.nodes.shape[0]):
            put_three(load, 3 * s, weight(body, boundary, s))
    for j in range(head(boundary, NODES)):
        put_three(load, node_at + NODE * j + FORCE, ti.Vector.zero(ti.f64, 3))
    for i in range(head(boundary, ENTRIES)):
        at = entry_at + ENTRY * i
        add(load, node_at, int(load[at]), load[at + 1] * three(load, row_at + int(load[at + 2])))
    for i in range(head(boundary, FACES)):
        at = face_at + FACE * i
        press(body, load, node_at, at, load[row_at + int(load[at + 8])])
    for j in range(head(boundary, NODES)):
        at = node_at + NODE * j
        s = int(load[at])
        put_three(load, 3 * s, weight(body, boundary, s) + three(load, at + FORCE))


@ti.func
def put_three_from(values: ti.template(), place, others: ti.template(), start):
    """Set three numbers of an array to three of another one."""
    for j in ti.static(range(3)):
        values[place + j] = others[start + j]


@ti.func
def add(load: ti.template(), node_at, j, force):
    """Add a force [3] to that on loaded node j."""
    place = node_at + NODE * j + FORCE
    for c in ti.static(range(3)):
        load[place + c] = load[place + c] + force[c]


@ti.func
def press(body: ti.template(), load: ti.template(), node_at, at, pressure):
    """Add the forces of a pressure [Pa] on the face whose data begin at `at`."""
    shares = corner_shares(body, load, at, pressure)
    for i in ti.static(range(4)):
        add(load, node_at, int(load[at + 4 + i]), shares[i])


@ti.func
def corner_shares(body: ti.template(), load: ti.template(), at, pressure):
    """Return the forces [3] of a pressure [Pa] on the four corners of the face whose data begin at `at`."""
    first = int(load[at])
    along, across, twist = ti.Vector.zero(ti.f64, 3), ti.Vector.zero(ti.f64, 3), ti.Vector.zero(ti.f64, 3)
    for i in ti.static(range(1, 4)):
        corner = int(load[at + i])
        x = row(body.position, corner) - row(body.position, first) + (row(body.u, corner) - row(body.u, first))
        along += 0.25 * XI[i] * x
        across += 0.25 * ETA[i] * x
        twist += 0.25 * XI[i] * ETA[i] * x
    middle, over_xi, over_eta = along.cross(across), along.cross(twist), twist.cross(across)
    return [-pressure * (middle + XI[i] / 3.0 * over_xi + ETA[i] / 3.0 * over_eta) for i in range(4)]


@ti.func
def measure_loads(body: ti.template(), boundary: ti.template(), contact: ti.template()):
    """Sum up the loads of the level and their work in the step that ended there; keep both for the next one."""
    load = ti.static(boundary.load)
    node_at = 3 * boundary.nodes.shape[0] + HEAD
    total, work, kick = ti.Vector.zero(ti.f64, 3), 0.0, 0.0
    for turn in range(turns(contact, head(boundary, NODES))):
        at = node_at + NODE * item(contact, turn)
        s = int(load[at])
        here, force = row(body.u, boundary.nodes[s]), three(load, at + FORCE)
        total += force
        kick += 0.5 * force.dot(symmetric(boundary.inverse_mass, s) @ force)
        work += 0.5 * (three(load, at + FORCE_BEFORE) + force).dot(here - three(load, at + PLACE_BEFORE))
        put_three(load, at + FORCE_BEFORE, force)
        put_three(load, at + PLACE_BEFORE, here)
    place = head(boundary, SUMS_AT)
    sums = over_threads(contact, [total[0], total[1], total[2], work, kick], ("sum",) * 5)
    if leader(contact) == 1:
        boundary.sums[place + APPLIED.applied_step] = sums[3] * head(boundary, STARTED)
        boundary.sums[place + APPLIED.applied_kick] = sums[4] * body.params[KICK_BEFORE] ** 2
        boundary.sums[place + APPLIED.half_step] = body.params[KICK_BEFORE]
        load[node_at - HEAD + STARTED] = 1.0
        for j in ti.static(range(3)):
            boundary.sums[place + APPLIED.applied_force + j] = sums[j]
            boundary.sums[place + APPLIED.gravity + j] = body.params[GRAVITY + j]
