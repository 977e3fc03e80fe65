"""Friction in the massless components of contact nodes, solved within the static solve (METHOD 3).

    slip s = T (x^{n+1} - x^n - displacement of the partner),   t = -c s/|s| where s is not 0,   |t| <= c = mu lambda

T: the two tangents of the contact. The work of friction over a step is -(t^n + t^{n+1}).s/2, the trapezoidal rule that
the energy balance uses for all forces.
"""

from ..contact.constraint_rows import (
    friction_cone,
    normal_of,
    number_of,
    set_number,
    set_vector,
    sum_of_cones,
    sum_of_rows,
    vector_of,
    velocity_of,
)
from ..contact.friction import (
    FORCE,
    LIMIT,
    ORIGIN,
    SLIP_SPEED,
    STEP,
    WORK,
    add_work,
    friction_force,
    friction_from,
    layer_limit,
    node_place,
    tangents,
)
from ..contact.friction_record import record_step
from ..contact.islands import node_count
from ..contact.local_contact import multipliers
from ..contact.pair_rows import entry, is_slave, pair_row, weight
from ..engine import ti
from ..language.counted import counted
from ..language.entries import put_three, row, three
from ..language.threads import item, meet, sum_of, turns
from ..pair_places import FIRST_ENTRY, MASTERS, NODE_ROW
from .massless_node import basis_of, entries, largest, settle, square, violated

NODE_ROUNDS = 10  # iterations over the rows of a node with several rows, at most
NODE_CHANGE = 1e-14  # relative change of its increment at which they end
ROUNDS = 2  # iterations between normal and tangential force of one row in a sweep; the sweeps converge them
SEARCH = 100  # trials of the pressing force where these iterations diverge, at most
CLOSED = 1e-12  # gap over the gap without contact at which the search ends
UNSOLVED = 1e-30  # least residual of a row that slips, over the friction that it can have and its pressing force


@ti.func
def slip_since_last_row(body: ti.template(), contact: ti.template(), rows: ti.template(), k, r):
    """Return the displacement [3] [m] of node k relative to the partner of its row r since `restart_slip`."""
    step = row(body.u, contact.nodes[k]) - three(contact.friction, node_place(k, ORIGIN))
    return step - contact.friction[STEP] * velocity_of(rows, r, rows.at.mean_velocity)


@ti.func
def slip_of(
    body: ti.template(),
    boundary: ti.template(),
    contact: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    k,
    r,
):
    """Return the displacement [3] [m] of node k relative to the obstacle or the masters of its row r."""
    slip = slip_since_last_row(body, contact, rows, k, r)
    if ti.static(contact.options.coupled):
        if is_slave(coupling, k) and r == pair_row(rows, k):
            slip = slip_on_masters(body, boundary, contact, coupling, k)
    return slip


@ti.func
def slip_on_masters(body: ti.template(), boundary: ti.template(), contact: ti.template(), coupling: ti.template(), k):
    """Return the displacement [3] [m] of a slave relative to its masters since `restart_slip`."""
    slip = since_last_row(body, boundary, contact, k)
    r = entry(coupling, NODE_ROW, k)
    for i in range(entry(coupling, FIRST_ENTRY, r), entry(coupling, FIRST_ENTRY, r + 1)):
        there = since_last_row(body, boundary, contact, entry(coupling, MASTERS, i))
        slip = slip - weight(coupling, i) * there
    return slip


@ti.func
def since_last_row(body: ti.template(), boundary: ti.template(), contact: ti.template(), s):
    """Return the displacement [3] [m] of boundary node s since `restart_slip`; other than contact nodes are held."""
    step = contact.friction[STEP] * row(body.v, boundary.nodes[s])
    if s < node_count(contact):
        step = row(body.u, contact.nodes[s]) - three(contact.friction, node_place(s, ORIGIN))
    return step


@ti.func
def restart_slip(body: ti.template(), contact: ti.template()):
    """Measure slip from the present displacement on."""
    for turn in range(turns(contact, node_count(contact))):
        k = item(contact, turn)
        put_three(contact.friction, node_place(k, ORIGIN), row(body.u, contact.nodes[k]))
    meet(contact)


@ti.func
def sliding_work(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), coupling: ti.template()
):
    """Add the work of friction in the step that ends here, and restart the slip."""
    work = 0.0
    for turn in range(turns(contact, node_count(contact))):
        k = item(contact, turn)
        work += counted(contact, k) * sliding_work_node(body, boundary, contact, rows, coupling, k)
    add_work(contact, sum_of(contact, work))
    restart_slip(body, contact)


@ti.func
def sliding_work_node(
    body: ti.template(),
    boundary: ti.template(),
    contact: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    k,
):
    """Return the work [J] done by the friction on node k in the step, and store the friction for the next."""
    slots = ti.static(contact.options.slots)
    own, strongest, path = 0.0, 0.0, 0.0
    for p in ti.static(range(slots)):
        now = vector_of(rows, k * slots + p, rows.at.traction)
        then = vector_of(rows, k * slots + p, rows.at.traction_before)
        if now.dot(now) + then.dot(then) > 0.0:
            own -= 0.5 * (now + then).dot(slip_of(body, boundary, contact, rows, coupling, k, k * slots + p))
            strongest = ti.max(strongest, now.norm())
        if ti.static(contact.options.recorded):
            r = k * slots + p
            if now.dot(now) + then.dot(then) > 0.0 or number_of(rows, r, rows.at.pressing) > 0.0:
                slip = tangents(normal_of(rows, r)) @ slip_of(body, boundary, contact, rows, coupling, k, r)
                path = ti.max(path, slip.norm())
        set_vector(rows, k * slots + p, rows.at.traction_before, now)
        if ti.static(contact.options.varied):
            if contact.friction[STEP] > 0.0:
                slip = slip_of(body, boundary, contact, rows, coupling, k, k * slots + p)
                normal = normal_of(rows, k * slots + p)
                speed = (slip - normal.dot(slip) * normal).norm() / contact.friction[STEP]
                set_number(rows, k * slots + p, rows.at.slip_speed, speed)
    contact.friction[node_place(k, WORK)] = own
    contact.friction[node_place(k, FORCE)] = strongest
    if ti.static(contact.options.recorded):
        record_step(contact, k, path, own)
    return own


@ti.func
def friction_cap(contact: ti.template(), rows: ti.template(), k, r):
    """Return the largest friction force [N] that row r of node k transmits whatever its pressing force."""
    cap = 1e300
    if ti.static(rows.at.shear_limit >= 0):
        cap = number_of(rows, r, rows.at.shear_limit)
    if ti.static(contact.options.layered):
        cap = ti.min(cap, contact.friction[node_place(k, LIMIT)])
    return cap


@ti.func
def friction_limit(contact: ti.template(), rows: ti.template(), k, p: ti.template(), pressing: ti.template()):
    """Return the largest friction force [N] that row p of node k can transmit; pressing [slots] [N]: of its rows."""
    limit = friction_cone(rows, k * ti.static(contact.options.slots) + p, pressing[p])
    if ti.static(contact.options.layered):
        limit = layer_limit(contact, k, limit, sum_of_cones(rows, k, pressing))
    return limit


@ti.func
def measure_slip(
    body: ti.template(),
    boundary: ti.template(),
    contact: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    k,
    pressing,
):
    """Set the slip of the rows of node k for the sweeps; return by how much [N] friction exceeds its limit.

    A row that slips has at least a residual that is not zero, so that forces in balance without the friction that it
    should have (a body in uniform motion that is only compressed along the normal) do not count as solved.
    """
    slots = ti.static(contact.options.slots)
    excess = 0.0
    for p in ti.static(range(slots)):
        r = k * slots + p
        friction = vector_of(rows, k * slots + p, rows.at.traction)
        limit = friction_limit(contact, rows, k, p, pressing)
        excess = ti.max(excess, friction.norm() - limit)
        slip = slip_of(body, boundary, contact, rows, coupling, k, r)
        excess = ti.max(excess, ti.select(slip.dot(slip) > 0.0, UNSOLVED * ti.min(limit, pressing[p]), 0.0))
        set_vector(rows, k * slots + p, rows.at.slip, slip)
    return excess


@ti.func
def solve_single_row(
    contact: ti.template(), rows: ti.template(), system: ti.template(), k, d, flexible, b, scale, block: ti.template()
):
    """Solve the contact problem of a node with one row; return increment, active mask and violation [m].

    d: increment with the forces of the last sweep. Normal and tangential force are iterated in turn, which converges
    where mu |coupling| < compliance. Elsewhere the pressing force is bisected between a value that leaves an overlap
    and one that opens the contact.
    """
    normal = entries(system.normals, k, system.stiffness.shape[0], 0, block)
    across = tangents(normal_of(rows, k))
    there = across @ b
    response = flexible @ normal
    compliance = normal.dot(response) + contact.compliance[k]
    friction = across @ vector_of(rows, k, rows.at.traction)
    pressing = number_of(rows, k, rows.at.pressing)
    d = d - (pressing * response + flexible @ (there.transpose() @ friction))
    off = 0.0
    if compliance > 0.0:
        mobility = there @ flexible @ there.transpose()
        coupling = there @ response
        gap = system.gaps[k] + normal.dot(d)
        slip = across @ vector_of(rows, k, rows.at.slip) + there @ d
        steep = gap < 0.0 and number_of(rows, k, rows.at.coefficient) * coupling.norm() >= compliance
        low, high = 0.0, 0.0
        shift = 0.0
        for turn in range(ti.select(steep, SEARCH, ROUNDS)):
            if turn < ROUNDS:
                pressing = ti.max(0.0, (0.0 - gap - coupling.dot(friction)) / compliance)
            elif high > 0.0:
                pressing = 0.5 * (low + high)
            else:
                pressing = 2.0 * ti.max(pressing, (0.0 - gap) / compliance)
            limit = friction_limit(contact, rows, k, 0, [pressing])
            there_now = slip + pressing * coupling
            friction, shift = friction_from(contact.options.friction, mobility, there_now, limit, scale, shift)
            after = gap + coupling.dot(friction) + compliance * pressing
            off = violated(after, pressing)
            if turn >= ROUNDS - 1 and off <= CLOSED * ti.abs(gap):
                break
            if after < 0.0:
                low = pressing
            else:
                high = pressing
    else:
        pressing = 0.0
        friction = ti.Vector([0.0, 0.0])
    d += pressing * response + flexible @ (there.transpose() @ friction)
    set_number(rows, k, rows.at.pressing, pressing)
    set_vector(rows, k, rows.at.traction, across.transpose() @ friction)
    return d, ti.select(pressing > 0.0, 1, 0), off


@ti.func
def solve_several_rows(
    contact: ti.template(),
    rows: ti.template(),
    system: ti.template(),
    k,
    d,
    flexible,
    b,
    scale,
    block: ti.template(),
    slots: ti.template(),
):
    """Solve the contact problem of a node with several rows; return increment, active mask and violation [m].

    d: increment with the forces of the last sweep. Each iteration solves for the pressing forces of all rows at once,
    so that dependent normals share them as in `balance`, then for the friction of one row after another.
    """
    stride = system.stiffness.shape[0]
    normals = ti.Matrix(
        [
            [system.normals[(p * block + j) * stride + k] for j in ti.static(range(block))]
            for p in ti.static(range(slots))
        ]
    )
    gaps = entries(system.gaps, k, stride, 0, slots)
    pressing = ti.Vector([number_of(rows, k * slots + p, rows.at.pressing) for p in ti.static(range(slots))])
    for _ in range(NODE_ROUNDS):
        before = d
        d = d - flexible @ (normals.transpose() @ pressing)
        pressing = multipliers(d, normals, gaps, flexible, contact.compliance[k], slots)
        d += flexible @ (normals.transpose() @ pressing)
        for p in ti.static(range(slots)):
            across = tangents(normal_of(rows, k * slots + p))
            there = across @ b
            friction = across @ vector_of(rows, k * slots + p, rows.at.traction)
            d = d - flexible @ (there.transpose() @ friction)
            slip = across @ vector_of(rows, k * slots + p, rows.at.slip) + there @ d
            mobility = there @ flexible @ there.transpose()
            limit = friction_limit(contact, rows, k, p, pressing)
            friction = friction_force(contact.options.friction, mobility, slip, limit, scale)
            d += flexible @ (there.transpose() @ friction)
            set_vector(rows, k * slots + p, rows.at.traction, across.transpose() @ friction)
        if largest(d - before) <= NODE_CHANGE * largest(d):
            break
    mask, off = 0, 0.0
    after = gaps + normals @ d + contact.compliance[k] * pressing
    for p in ti.static(range(slots)):
        set_number(rows, k * slots + p, rows.at.pressing, pressing[p])
        off = ti.max(off, violated(after[p], pressing[p]))
        if pressing[p] > 0.0:
            mask += 1 << p
    return d, mask, off


@ti.func
def update_with_friction(
    contact: ti.template(),
    rows: ti.template(),
    system: ti.template(),
    k,
    rest,
    block: ti.template(),
    slots: ti.template(),
):
    """Solve the contact problem of node k with friction for rest = r_k - sum_j K_kj d_j; return the defect [N]."""
    flexible = square(system.inverse, k, system.stiffness.shape[0], block)
    d, mask, off = solve_with_friction(contact, rows, system, k, flexible @ rest, flexible, block, slots)
    stiffness = ti.select(contact.compliance[k] > 0.0, 1.0 / ti.max(contact.compliance[k], 1e-300), system.stiffness[k])
    return ti.max(settle(contact, system, k, d, mask, block), stiffness * off)


@ti.func
def solve_with_friction(
    contact: ti.template(),
    rows: ti.template(),
    system: ti.template(),
    k,
    free,
    flexible,
    block: ti.template(),
    slots: ti.template(),
):
    """Solve the contact problem of node k with friction; return increment, active mask and violation [m].

    free: increment without contact; flexible [block, block] [m/N]: what a unit force adds to it.
    """
    stride = system.stiffness.shape[0]
    b = basis_of(contact.basis, k, block)
    scale = ti.max(contact.friction[SLIP_SPEED] * contact.friction[STEP], 1e-300)
    d = free + flexible @ (b.transpose() @ sum_of_rows(rows, k, rows.at.traction))
    for p in ti.static(range(slots)):
        pressing = number_of(rows, k * slots + p, rows.at.pressing)
        d += pressing * (flexible @ entries(system.normals, k, stride, p * block, block))
    mask, off = 0, 0.0
    if ti.static(slots == 1):
        d, mask, off = solve_single_row(contact, rows, system, k, d, flexible, b, scale, block)
    else:
        d, mask, off = solve_several_rows(contact, rows, system, k, d, flexible, b, scale, block, slots)
    return d, mask, off
