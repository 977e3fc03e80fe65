"""Springs and dashpots between the mean positions of two sets of nodes, or of one set and a fixed point (METHOD 2).

    q = q_0 + sum_i w_i u_i,  d = q_B - q_A,  r = q_B' - q_A',  n = d/|d|,  P = n n^T
    F_A = -F_B = k (|d| - l) n + c P r^n

or, along axes, k P (d - d_0) + c P r^n with P the projector on these axes; node i takes w_i F. The dashpot acts on
the rate at the time level, r^n = r* - k0 W F_c with r* before its own force F_c and W = sum_i w_i^2 M_i^+ over both
ends, so that x = P r^n follows from (1 + k0 c P W P) x = P r* (for a node: that of damping.py). In the first row, where
k0 = 0, k1 takes its place. Springs that share nodes repeat this in turns.

`springs.lists`: numbers below, then for each spring ENDS numbers: 1 if it acts along axes, first entry of end A, of end
B, behind end B; then the boundary node of every entry. `springs.values`: for each spring the numbers below, then the
weights of the entries.
"""

import taichi as ti

from ..columns import SPRING, SPRING_SUMS
from ..lanes import KICK_AFTER, KICK_BEFORE
from ..language.entries import put_three, row, three
from .boundary_nodes import symmetric
from .damping import damped_response

COUNT, ROUNDS, SUMS_PLACE, HEAD = 0, 1, 2, 3  # of lists: springs; most turns of dashpots; first of the sums; header
ALONG_AXES, FIRST_A, FIRST_B, LAST_B, ENDS = 0, 1, 2, 3, 4
# of values: k, c, l; axes (0 or 1); q_0 of both ends; d_0; elastic force on A, its energy; force of the dashpot on A
STIFFNESS, DAMPING, LENGTH, AXES, PLACE_A, PLACE_B, REST, ELASTIC, ENERGY, RESISTING = 0, 1, 2, 3, 6, 9, 12, 15, 18, 19
NUMBERS = 22
CHANGE = 1e-13  # change of the forces of dashpots over their size at which turns end


@ti.func
def end_of(springs: ti.template(), i, which):
    """Return number `which` of spring i in lists."""
    return springs.lists[HEAD + ENDS * i + which]


@ti.func
def node_of(springs: ti.template(), entry):
    """Return boundary node and weight of an entry."""
    count = springs.lists[COUNT]
    return springs.lists[HEAD + ENDS * count + entry], springs.values[NUMBERS * count + entry]


@ti.func
def vector_between(body: ti.template(), boundary: ti.template(), springs: ti.template(), i):
    """Return d = q_B - q_A of spring i [m]."""
    vector = three(springs.values, NUMBERS * i + PLACE_B) - three(springs.values, NUMBERS * i + PLACE_A)
    for entry in range(end_of(springs, i, FIRST_A), end_of(springs, i, LAST_B)):
        s, weight = node_of(springs, entry)
        sign = ti.select(entry < end_of(springs, i, FIRST_B), -weight, weight)
        vector += sign * row(body.u, boundary.nodes[s])
    return vector


@ti.func
def projector(springs: ti.template(), i, vector):
    """Return P of spring i with the vector d between its ends."""
    axes = three(springs.values, NUMBERS * i + AXES)
    result = ti.Matrix([[axes[0], 0.0, 0.0], [0.0, axes[1], 0.0], [0.0, 0.0, axes[2]]])
    if end_of(springs, i, ALONG_AXES) == 0:
        normal = vector / ti.max(vector.norm(), 1e-300)
        result = normal.outer_product(normal)
    return result


@ti.func
def pull(body: ti.template(), springs: ti.template(), i, force):
    """Add the force on end A of spring i, and the opposite one on end B."""
    for entry in range(end_of(springs, i, FIRST_A), end_of(springs, i, LAST_B)):
        s, weight = node_of(springs, entry)
        sign = ti.select(entry < end_of(springs, i, FIRST_B), weight, -weight)
        for j in ti.static(range(3)):
            body.special_force[3 * s + j] = body.special_force[3 * s + j] - sign * force[j]


@ti.func
def rate_between(body: ti.template(), boundary: ti.template(), springs: ti.template(), i, damped: ti.template()):
    """Return r of spring i before the kick, its change per second of kick with the present forces, and W."""
    rate, change = ti.Vector.zero(ti.f64, 3), ti.Vector.zero(ti.f64, 3)
    flexible = ti.Matrix.zero(ti.f64, 3, 3)
    for entry in range(end_of(springs, i, FIRST_A), end_of(springs, i, LAST_B)):
        s, weight = node_of(springs, entry)
        sign = ti.select(entry < end_of(springs, i, FIRST_B), -weight, weight)
        velocity, inverse = row(body.v, boundary.nodes[s]), symmetric(boundary.inverse_mass, s)
        net = row(boundary.load, s) - row(body.special_force, s)
        net, inverse = damped_response(damped, body, symmetric(boundary.mass, s), velocity, net, inverse)
        rate += sign * velocity
        change += sign * (inverse @ net)
        flexible += weight * weight * inverse
    return rate, change, flexible


@ti.func
def spring_forces(body: ti.template(), boundary: ti.template(), springs: ti.template(), damped: ti.template()):
    """Add the forces of springs and dashpots to special_force."""
    count = springs.lists[COUNT]
    for i in range(count):
        place = NUMBERS * i
        stiffness, vector = springs.values[place + STIFFNESS], vector_between(body, boundary, springs, i)
        stretch = vector - three(springs.values, place + REST)
        if end_of(springs, i, ALONG_AXES) == 0:
            length = vector.norm()
            stretch = (length - springs.values[place + LENGTH]) / ti.max(length, 1e-300) * vector
        stretch = projector(springs, i, vector) @ stretch
        put_three(springs.values, place + ELASTIC, stiffness * stretch)
        springs.values[place + ENERGY] = 0.5 * stiffness * stretch.dot(stretch)
        put_three(springs.values, place + RESISTING, ti.Vector.zero(ti.f64, 3))
        pull(body, springs, i, stiffness * stretch)
    before, after = body.params[KICK_BEFORE], body.params[KICK_AFTER]
    span = ti.select(before > 0.0, before, after)
    for _ in range(springs.lists[ROUNDS]):
        change_of_forces, size = 0.0, 0.0
        for i in range(count):
            damping = springs.values[NUMBERS * i + DAMPING]
            if damping > 0.0:
                old = three(springs.values, NUMBERS * i + RESISTING)
                along = projector(springs, i, vector_between(body, boundary, springs, i))
                rate, change, flexible = rate_between(body, boundary, springs, i, damped)
                rate += span * change
                soft = span * (along @ flexible @ along)
                unit = ti.Matrix.identity(ti.f64, 3)
                force = damping * ((unit + damping * soft).inverse() @ (along @ rate + soft @ old))
                put_three(springs.values, NUMBERS * i + RESISTING, force)
                pull(body, springs, i, force - old)
                change_of_forces += (force - old).norm()
                size += force.norm()
        if change_of_forces <= CHANGE * size:
            break


@ti.func
def measure_springs(body: ti.template(), boundary: ti.template(), springs: ti.template()):
    """Sum up energy, work of the dashpots in both parts of the kick, and the force of fixed points.

    special_force holds all forces of the kick.
    """
    before, after = body.params[KICK_BEFORE], body.params[KICK_AFTER]
    sums = ti.Vector.zero(ti.f64, SPRING_SUMS)
    for i in range(springs.lists[COUNT]):
        place = NUMBERS * i
        elastic, resisting = three(springs.values, place + ELASTIC), three(springs.values, place + RESISTING)
        rate, change, _flexible = rate_between(body, boundary, springs, i, "")
        sums[SPRING.spring_energy] += springs.values[place + ENERGY]
        sums[SPRING.spring_before] += before * resisting.dot(rate + 0.5 * before * change)
        sums[SPRING.spring_after] += after * resisting.dot(rate + (before + 0.5 * after) * change)
        if end_of(springs, i, FIRST_B) == end_of(springs, i, LAST_B):
            for j in ti.static(range(3)):
                sums[SPRING.spring_force + j] += elastic[j] + resisting[j]
    for j in ti.static(range(SPRING_SUMS)):
        springs.sums[springs.lists[SUMS_PLACE] + j] = sums[j]
