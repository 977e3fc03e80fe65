"""Constraint rows of rigid obstacles: gap, normal and surface velocity at contact nodes, and loads on the obstacles.

Row r = k * slots + p of node k stands for obstacle candidates[r], the last one of a node in pairs of bodies for these.
Where there are more than MAXIMUM_SLOTS obstacles, the candidates are the nearest ones.
"""

from ..columns import OBSTACLE_LOAD, OBSTACLE_LOADS, SUMS, UNREACHED, loads_place
from ..engine import ti
from ..lanes import MAXIMUM_SLOTS
from ..language.counted import counted
from ..language.entries import row, three
from ..language.threads import item, meet, over_threads, put_sums, turns
from ..nodes.rigid_record import kind_of
from ..rigid_places import FREE
from .constraint_rows import number_of, set_number, set_vector, vector_of
from .friction import ORIGIN, STEP, node_place
from .islands import first_other, island_count, node_count
from .obstacles import MEAN_VELOCITY, POINT, RECORD, VELOCITY, gap_and_normal, gap_normal_face, level_with, velocity_at

SUMMED = ("sum",) * 7  # force, moment and power of an obstacle
LOAD_PLACES = tuple(
    first + j for first in (OBSTACLE_LOAD.obstacle_force, OBSTACLE_LOAD.obstacle_moment) for j in range(3)
)


@ti.func
def position(reference: ti.template(), k, u: ti.template(), node):
    """Return the present position [3] of entry k in a list of nodes, relative to the origin of `reference`."""
    return row(reference, k) + row(u, node)


@ti.func
def fill_row(obstacles: ti.template(), rows: ti.template(), r, x):
    """Fill row r for a node at x."""
    p = obstacles.candidates[r]
    entered = 0.0
    if ti.static(rows.at.face >= 0):
        entered = number_of(rows, r, rows.at.face)
    gap, normal, face = gap_normal_face(obstacles, p, x, entered)
    set_number(rows, r, rows.at.gap, gap)
    set_vector(rows, r, rows.at.normal, normal)
    if ti.static(rows.at.face >= 0):
        set_number(rows, r, rows.at.face, face)
    if ti.static(rows.at.size_squared >= 0):
        away = x - three(obstacles.records, RECORD * p + POINT)
        set_number(rows, r, rows.at.size_squared, ti.max(x.norm_sqr(), away.norm_sqr()))
    if ti.static(rows.at.velocity >= 0):
        set_vector(rows, r, rows.at.velocity, velocity_at(obstacles, p, x, VELOCITY))


@ti.func
def fill_mean_velocity(obstacles: ti.template(), rows: ti.template(), contact: ti.template(), u: ti.template(), k, p):
    """Set the velocity of the obstacle of row p of node k over the step for which slip is measured.

    It is that at the middle between the places of the node at its ends, relative to the obstacle: the arm at one end
    makes the slip on an obstacle that turns wrong in proportion to the step (METHOD 3).
    """
    node, r = contact.nodes[k], k * ti.static(rows.options.slots) + p
    obstacle = obstacles.candidates[r]
    moved = row(u, node) - three(contact.friction, node_place(k, ORIGIN))
    drift = contact.friction[STEP] * three(obstacles.records, RECORD * obstacle + MEAN_VELOCITY)
    middle = position(contact.reference, k, u, node) - 0.5 * (moved - drift)
    set_vector(rows, r, rows.at.mean_velocity, velocity_at(obstacles, obstacle, middle, MEAN_VELOCITY))


@ti.func
def fill_node(obstacles: ti.template(), rows: ti.template(), contact: ti.template(), u: ti.template(), k):
    """Fill the rows of contact node k."""
    x = position(contact.reference, k, u, contact.nodes[k])
    slots = ti.static(rows.options.slots)
    if ti.static(len(contact.options.shapes) > 0):
        for p in range(ti.static(rows.options.obstacle_slots)):
            fill_row(obstacles, rows, k * slots + p, x)
            if ti.static(rows.at.mean_velocity >= 0):
                fill_mean_velocity(obstacles, rows, contact, u, k, p)
        if ti.static(rows.at.face >= 0 and rows.options.obstacle_slots > 1):
            find_level_faces(obstacles, rows, k * slots, x)


@ti.func
def find_level_faces(obstacles: ti.template(), rows: ti.template(), first, x):
    """Let a node at x enter a block by the face that is in one plane with the surface of another obstacle.

    So it slides over the seam of two blocks of one height, whose sides are covered. first: row of the node.
    """
    for p, other in ti.static(ti.ndrange(rows.options.obstacle_slots, rows.options.obstacle_slots)):
        if ti.static(p != other):
            r, gap = first + p, number_of(rows, first + other, rows.at.gap)
            normal = vector_of(rows, first + other, rows.at.normal)
            level = level_with(obstacles, obstacles.candidates[r], x, gap, normal)
            if level != 0.0 and level != number_of(rows, r, rows.at.face):
                set_number(rows, r, rows.at.face, level)
                if number_of(rows, r, rows.at.gap) <= 0.0:
                    fill_row(obstacles, rows, r, x)


@ti.func
def fill_rows(obstacles: ti.template(), rows: ti.template(), contact: ti.template(), u: ti.template()):
    """Fill the rows of all contact nodes at the displacement u."""
    for turn in range(turns(contact, node_count(contact))):
        fill_node(obstacles, rows, contact, u, item(contact, turn))
    meet(contact)


@ti.func
def choose_candidates(obstacles: ti.template(), contact: ti.template(), u: ti.template()):
    """Choose the obstacles with the smallest gaps at each node, if there are more obstacles than slots."""
    if obstacles.records.shape[0] // RECORD > MAXIMUM_SLOTS:
        for turn in range(turns(contact, node_count(contact))):
            choose_at_node(obstacles, contact, u, item(contact, turn))
        meet(contact)


@ti.func
def choose_at_node(obstacles: ti.template(), contact: ti.template(), u: ti.template(), k):
    """Choose the obstacles of node k.

    They are kept in the order of the scene, so that distant obstacles do not change the arithmetic of the others. As
    long as the set is the same, its order stays, and with it the data of the rows (such as friction).
    """
    slots = ti.static(contact.options.slots)
    x = position(contact.reference, k, u, contact.nodes[k])
    found = ti.Vector([-1 for _ in range(MAXIMUM_SLOTS)])
    missing = 0
    for slot in ti.static(range(MAXIMUM_SLOTS)):
        best = 1e300
        for p in range(obstacles.records.shape[0] // RECORD):
            g, _normal = gap_and_normal(obstacles, p, x)
            taken = 0
            for before in ti.static(range(slot)):
                if found[before] == p:
                    taken = 1
            if taken == 0 and g < best:
                best = g
                found[slot] = p
        known = 0
        for other in ti.static(range(MAXIMUM_SLOTS)):
            if obstacles.candidates[slots * k + other] == found[slot]:
                known = 1
        missing += 1 - known
    for _, slot in ti.static(ti.ndrange(MAXIMUM_SLOTS - 1, MAXIMUM_SLOTS - 1)):
        first, second = found[slot], found[slot + 1]
        found[slot] = ti.min(first, second)
        found[slot + 1] = ti.max(first, second)
    if missing > 0:
        for slot in ti.static(range(MAXIMUM_SLOTS)):
            obstacles.candidates[slots * k + slot] = found[slot]


@ti.func
def smallest_gap(obstacles: ti.template(), rows: ti.template(), contact: ti.template(), u: ti.template()):
    """Set the smallest gap of the contact sets to any obstacle, of the rows and of nodes without rows."""
    smallest = UNREACHED
    if ti.static(rows.exist):
        for turn in range(turns(contact, node_count(contact))):
            for p in range(ti.static(rows.options.slots)):
                r = item(contact, turn) * rows.options.slots + p
                smallest = ti.min(smallest, number_of(rows, r, rows.at.gap))
    begin = first_other(contact, 0)
    for turn in range(turns(contact, first_other(contact, island_count(contact)) - begin)):
        k = begin + item(contact, turn)
        x = position(contact.reference, k, u, contact.nodes[k])
        if ti.static(len(contact.options.shapes) > 0):
            for p in range(obstacles.records.shape[0] // RECORD):
                g, _normal = gap_and_normal(obstacles, p, x)
                smallest = ti.min(smallest, g)
    put_sums(contact, contact.sums, (SUMS.gap_min,), [smallest], ("min",))


@ti.func
def obstacle_loads(
    obstacles: ti.template(), rows: ti.template(), contact: ti.template(), rigid: ti.template(), u: ti.template()
):
    """Sum up force and moment on every obstacle, and the power of all obstacles on the bodies.

    The force on an obstacle is opposite to that on the node and acts at the node. Obstacles that move freely supply no
    power: their energy is part of the ledger.
    """
    slots, own = ti.static(rows.options.slots, rows.options.obstacle_slots)
    power = ti.static(loads_place(contact.options.friction != ""))
    if ti.static(contact.options.threads > 1):
        share_obstacle_loads(obstacles, rows, contact, rigid, u)
    else:
        for j in range(power, power + 1 + obstacles.records.shape[0] // RECORD * OBSTACLE_LOADS):
            contact.sums[j] = 0.0
        power_of_all = 0.0
        for k in range(node_count(contact)):
            x = position(contact.reference, k, u, contact.nodes[k])
            share = counted(contact, k)
            for r in range(k * slots, k * slots + own):
                p = obstacles.candidates[r]
                force, moment, supplied = load_of_row(obstacles, rows, contact, rigid, r, x)
                first = power + 1 + OBSTACLE_LOADS * p
                force_place, moment_place = first + OBSTACLE_LOAD.obstacle_force, first + OBSTACLE_LOAD.obstacle_moment
                for j in ti.static(range(3)):
                    contact.sums[force_place + j] = contact.sums[force_place + j] - share * force[j]
                    contact.sums[moment_place + j] = contact.sums[moment_place + j] - share * moment[j]
                power_of_all += share * supplied
        contact.sums[power] = power_of_all


@ti.func
def load_of_row(
    obstacles: ti.template(), rows: ti.template(), contact: ti.template(), rigid: ti.template(), r, x
):  # fmt: skip
    """Return the force [3] on the node at x of row r, its moment about the point of the obstacle, and its power."""
    p = obstacles.candidates[r]
    force = vector_of(rows, r, rows.at.force)
    if ti.static(rows.at.kick_friction >= 0):
        force += vector_of(rows, r, rows.at.kick_friction)
    moment = (x - three(obstacles.records, RECORD * p + POINT)).cross(force)
    supplied = force.dot(velocity_at(obstacles, p, x, VELOCITY))
    if ti.static(contact.options.free):
        supplied = ti.select(kind_of(rigid, p) == FREE, 0.0, supplied)
    return force, moment, supplied


@ti.func
def share_obstacle_loads(
    obstacles: ti.template(), rows: ti.template(), contact: ti.template(), rigid: ti.template(), u: ti.template()
):
    """Sum up the same with several threads, one obstacle after the other."""
    slots, own = ti.static(rows.options.slots, rows.options.obstacle_slots)
    power = ti.static(loads_place(contact.options.friction != ""))
    power_of_all = 0.0
    for p in range(obstacles.records.shape[0] // RECORD):
        sums = ti.Vector.zero(ti.f64, 7)
        for turn in range(turns(contact, node_count(contact))):
            k = item(contact, turn)
            x = position(contact.reference, k, u, contact.nodes[k])
            for r in range(k * slots, k * slots + own):
                if obstacles.candidates[r] == p:
                    force, moment, supplied = load_of_row(obstacles, rows, contact, rigid, r, x)
                    for j in ti.static(range(3)):
                        sums[j] += force[j]
                        sums[3 + j] += moment[j]
                    sums[6] += supplied
        first = power + 1 + OBSTACLE_LOADS * p
        if ti.static(contact.options.blocks > 1):
            places = [first + place for place in LOAD_PLACES]
            put_sums(contact, None, places, [0.0 - sums[j] for j in range(6)], ("sum",) * 6)
            power_of_all += sums[6]
        else:
            totals = over_threads(contact, [sums[j] for j in range(7)], SUMMED)
            for j, place in ti.static(enumerate(LOAD_PLACES)):
                contact.sums[first + place] = 0.0 - totals[j]
            power_of_all += totals[6]
    if ti.static(contact.options.blocks > 1):
        put_sums(contact, None, (power,), [power_of_all], ("sum",))
    else:
        contact.sums[power] = power_of_all
