"""Springs and dashpots between the mean positions of two sets of nodes, or of one set and a fixed point (METHOD 1).

    q = q_0 + sum_i w_i u_i,  d = q_B - q_A,  r = q_B' - q_A',  n = d/|d|,  P = n n^T
    F_A = -F_B = k (|d| - l) n + c P r^n

or, along axes, k P (d - d_0) + c P r^n with P the projector on these axes; node i takes w_i F. The dashpot acts on
the rate at the time level, r^n = r* - k0 W F_c with r* before its own force F_c and W = sum_i w_i^2 M_i^+ over both
ends, so that x = P r^n follows from (1 + k0 c P W P) x = P r* (for a node: that of damping.py). In the first row, where
k0 = 0, k1 takes its place. Springs that share nodes repeat this in turns.

Nodes that rigid parts carry move with these (carried_springs.py).

As arguments of a kernel are few, the numbers of springs stand behind the mass tensors in `boundary.mass`: four numbers;
for each spring those below; for each entry its boundary node, its weight, and 1 where a rigid part carries it; for each
carrier the number of the rigid body, s and a_0.
"""

from ..columns import SPRING, SPRING_SUMS
from ..engine import ti
from ..lanes import KICK_AFTER, KICK_BEFORE, SPRING_CARRIER, SPRING_ENTRY, SPRING_HEAD, SPRING_NUMBERS
from ..language.entries import put_three, row, three
from ..language.threads import item, leader, meet, over_threads, turns
from .boundary_nodes import symmetric
from .carried_springs import carried_rate
from .damping import damped_response

COUNT, ROUNDS, SUMS_PLACE, CARRIERS_AT = range(SPRING_HEAD)  # springs; most turns of dashpots; first sum; carriers
# 1 if it acts along axes; first entry of end A, of end B, behind end B; k, c, l; axes (0 or 1); q_0 of both ends; d_0;
# elastic force on A, its energy; force of the dashpot on A; first carrier, behind the last one
ALONG_AXES, FIRST_A, FIRST_B, LAST_B, STIFFNESS, DAMPING, LENGTH, AXES = 0, 1, 2, 3, 4, 5, 6, 7
PLACE_A, PLACE_B, REST, ELASTIC, ENERGY, RESISTING, FIRST_CARRIER, LAST_CARRIER = 10, 13, 16, 19, 22, 23, 26, 27
CHANGE = 1e-13  # change of the forces of dashpots over their size at which turns end


@ti.func
def head(boundary: ti.template(), which):
    """Return number `which` of the header."""
    return int(boundary.mass[6 * boundary.nodes.shape[0] + which])


@ti.func
def place_of(boundary: ti.template(), i):
    """Return where the numbers of spring i begin."""
    return 6 * boundary.nodes.shape[0] + SPRING_HEAD + SPRING_NUMBERS * i


@ti.func
def whole(boundary: ti.template(), i, which):
    """Return integer `which` of spring i."""
    return int(boundary.mass[place_of(boundary, i) + which])


@ti.func
def entry_of(boundary: ti.template(), entry):
    """Return boundary node and weight of an entry, and 1 where a rigid part carries the node."""
    place = place_of(boundary, head(boundary, COUNT)) + SPRING_ENTRY * entry
    return int(boundary.mass[place]), boundary.mass[place + 1], boundary.mass[place + 2]


@ti.func
def vector_between(body: ti.template(), boundary: ti.template(), contact: ti.template(), i):
    """Return d = q_B - q_A of spring i [m]."""
    place = place_of(boundary, i)
    vector = three(boundary.mass, place + PLACE_B) - three(boundary.mass, place + PLACE_A)
    if leader(contact) == 0:
        vector = ti.Vector.zero(ti.f64, 3)
    first = whole(boundary, i, FIRST_A)
    for turn in range(turns(contact, whole(boundary, i, LAST_B) - first)):
        entry = first + item(contact, turn)
        s, weight, _carried = entry_of(boundary, entry)
        sign = ti.select(entry < whole(boundary, i, FIRST_B), -weight, weight)
        vector += sign * row(body.u, boundary.nodes[s])
    total = over_threads(contact, [vector[j] for j in range(3)], ("sum",) * 3)
    return ti.Vector([total[j] for j in range(3)])


@ti.func
def projector(boundary: ti.template(), i, vector):
    """Return P of spring i with the vector d between its ends."""
    axes = three(boundary.mass, place_of(boundary, i) + AXES)
    result = ti.Matrix([[axes[0], 0.0, 0.0], [0.0, axes[1], 0.0], [0.0, 0.0, axes[2]]])
    if whole(boundary, i, ALONG_AXES) == 0:
        normal = vector / ti.max(vector.norm(), 1e-300)
        result = normal.outer_product(normal)
    return result


@ti.func
def pull(body: ti.template(), boundary: ti.template(), contact: ti.template(), i, force):
    """Add the force on end A of spring i, and the opposite one on end B, which may share nodes with it."""
    for end in ti.static(range(2)):
        first = whole(boundary, i, ti.static(FIRST_A + end))
        for turn in range(turns(contact, whole(boundary, i, ti.static(FIRST_A + end + 1)) - first)):
            s, weight, _carried = entry_of(boundary, first + item(contact, turn))
            sign = ti.static(1.0 - 2.0 * end) * weight
            for j in ti.static(range(3)):
                body.special_force[3 * s + j] = body.special_force[3 * s + j] - sign * force[j]
        meet(contact)


@ti.func
def rate_between(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rigid: ti.template(), level, i,
    damped: ti.template(), damped_parts: ti.template(),
):  # fmt: skip
    """Return r of spring i before the kick, its change per second of kick with the present forces, and W.

    damped, damped_parts: damping of nodes and of rigid parts that these forces do not hold; level: see `move_bodies`.
    """
    rate, change = ti.Vector.zero(ti.f64, 3), ti.Vector.zero(ti.f64, 3)
    flexible = ti.Matrix.zero(ti.f64, 3, 3)
    first = whole(boundary, i, FIRST_A)
    for turn in range(turns(contact, whole(boundary, i, LAST_B) - first)):
        entry = first + item(contact, turn)
        s, weight, carried = entry_of(boundary, entry)
        sign = ti.select(entry < whole(boundary, i, FIRST_B), -weight, weight)
        velocity, inverse = row(body.v, boundary.nodes[s]), symmetric(boundary.inverse_mass, s)
        net = row(boundary.load, s) - row(body.special_force, s)
        net, inverse = damped_response(damped, body, symmetric(boundary.mass, s), velocity, net, inverse)
        rate += (1.0 - carried) * sign * velocity
        change += sign * (inverse @ net)
        flexible += weight * weight * inverse
    if ti.static(contact.options.threads > 1):
        rates = [rate[0], rate[1], rate[2], change[0], change[1], change[2]]
        total = over_threads(contact, rates, ("sum",) * 6)
        soft = over_threads(contact, [flexible[j // 3, j % 3] for j in range(9)], ("sum",) * 9)
        for j in ti.static(range(3)):
            rate[j], change[j] = total[j], total[3 + j]
            for k in ti.static(range(3)):
                flexible[j, k] = soft[3 * j + k]
    if ti.static(rigid.tied):
        begin = 6 * boundary.nodes.shape[0] + head(boundary, CARRIERS_AT)
        for c in range(whole(boundary, i, FIRST_CARRIER), whole(boundary, i, LAST_CARRIER)):
            place = begin + SPRING_CARRIER * c
            moving, moved, soft = carried_rate(body, boundary, rigid, place, level, damped_parts)
            rate += moving
            change += moved
            flexible += soft
    return rate, change, flexible


@ti.func
def spring_forces(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rigid: ti.template(), level,
    damped: ti.template(),
):  # fmt: skip
    """Add the forces of springs and dashpots to special_force; threads share the nodes of a spring.

    rigid: bodies, of which parts carry nodes; level: number of the next time level in the launch.
    """
    count = head(boundary, COUNT)
    for i in range(count):
        place = place_of(boundary, i)
        stiffness, vector = boundary.mass[place + STIFFNESS], vector_between(body, boundary, contact, i)
        stretch = vector - three(boundary.mass, place + REST)
        if whole(boundary, i, ALONG_AXES) == 0:
            length = vector.norm()
            stretch = (length - boundary.mass[place + LENGTH]) / ti.max(length, 1e-300) * vector
        stretch = projector(boundary, i, vector) @ stretch
        if leader(contact) == 1:
            put_three(boundary.mass, place + ELASTIC, stiffness * stretch)
            boundary.mass[place + ENERGY] = 0.5 * stiffness * stretch.dot(stretch)
            put_three(boundary.mass, place + RESISTING, ti.Vector.zero(ti.f64, 3))
        pull(body, boundary, contact, i, stiffness * stretch)
    before, after = body.params[KICK_BEFORE], body.params[KICK_AFTER]
    span = ti.select(before > 0.0, before, after)
    for _ in range(head(boundary, ROUNDS)):
        changed, size = 0.0, 0.0
        for i in range(count):
            damping = boundary.mass[place_of(boundary, i) + DAMPING]
            if damping > 0.0:
                old = three(boundary.mass, place_of(boundary, i) + RESISTING)
                along = projector(boundary, i, vector_between(body, boundary, contact, i))
                rate, change, flexible = rate_between(body, boundary, contact, rigid, level, i, damped, damped)
                rate += span * change
                soft = span * (along @ flexible @ along)
                unit = ti.Matrix.identity(ti.f64, 3)
                force = damping * ((unit + damping * soft).inverse() @ (along @ rate + soft @ old))
                if leader(contact) == 1:
                    put_three(boundary.mass, place_of(boundary, i) + RESISTING, force)
                pull(body, boundary, contact, i, force - old)
                changed += (force - old).norm()
                size += force.norm()
        if changed <= CHANGE * size:
            break


@ti.func
def measure_springs(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rigid: ti.template(), level,
    damped: ti.template(),
):  # fmt: skip
    """Sum up energy, work of the dashpots in both parts of the kick, and the force of fixed points.

    special_force holds all forces of the kick but the damping of rigid parts; rigid, level: see `spring_forces`.
    """
    before, after = body.params[KICK_BEFORE], body.params[KICK_AFTER]
    sums = ti.Vector.zero(ti.f64, SPRING_SUMS)
    for i in range(head(boundary, COUNT)):
        place = place_of(boundary, i)
        elastic, resisting = three(boundary.mass, place + ELASTIC), three(boundary.mass, place + RESISTING)
        rate, change, _flexible = rate_between(body, boundary, contact, rigid, level, i, "", damped)
        sums[SPRING.spring_energy] += boundary.mass[place + ENERGY]
        sums[SPRING.spring_before] += before * resisting.dot(rate + 0.5 * before * change)
        sums[SPRING.spring_after] += after * resisting.dot(rate + (before + 0.5 * after) * change)
        if whole(boundary, i, FIRST_B) == whole(boundary, i, LAST_B):
            for j in ti.static(range(3)):
                sums[SPRING.spring_force + j] += elastic[j] + resisting[j]
    for j in ti.static(range(SPRING_SUMS)):
        boundary.sums[head(boundary, SUMS_PLACE) + j] = sums[j]
