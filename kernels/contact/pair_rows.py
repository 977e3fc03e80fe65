"""Constraint rows of pairs of bodies: one for a slave node, with weights P of the master's nodes (METHOD 7).

    g = nu . (x_s - sum_m P_sm x_m) >= 0,   lambda >= 0,   force lambda nu on s, -P_sm lambda nu on m

The rows stand in the last slot of their slaves, behind those of obstacles. A change of basis makes the constraint a
bound on one number of the slave, y_s = d_s - l nu.(P d): `spread` is d = T y, `collect` is T^t f. The lift l is nu
where the slave has no other row, else l.nu = 1 and l.n = 0 for the normals n of its other rows, which then bound y_s as
they bound d_s (static/chosen_rows.py). With friction in the static solve a slave follows the whole motion of its
masters, d_s = y_s + P d, so that y_s holds its slip (static/pair_sliding.py). A slave may be a master of softer bodies:
the rows stand in the order of their slaves, the masters of a row before it, so that one pass through them, or one
backward, is T or T^t.

nu is the mean normal of the faces of a row, renewed with every gap; weights and faces are kept until the slip is too
large (`is_stale`). Places of the data: pair_places.py.
"""

from ..columns import UNREACHED
from ..engine import ti
from ..language.entries import row
from ..language.threads import item, largest_of, leader, meet, over_threads, turns
from ..pair_places import (
    CENTRE,
    CLOSED,
    DEEP,
    FACE_WEIGHTS,
    FACES,
    FIRST_ENTRY,
    FIRST_FACE,
    MARGIN,
    MASTERS,
    NODE_ROW,
    NORMAL,
    NUMBERS,
    ORIGIN,
    ROW_NUMBERS,
    ROWS,
    SEARCHED,
    SLAVES,
    SLIP,
    SLIP_LIMIT,
    SQUEEZED,
    STALE,
    SURFACE,
    SURFACE_NODES,
    WEIGHTS,
)
from .constraint_rows import normal_of, number_of, set_number, set_vector, vector_of
from .islands import node_count


@ti.func
def entry(coupling: ti.template(), section: ti.template(), number):
    """Return a number of a section of the lists."""
    return coupling.lists[coupling.lists[section] + number]


@ti.func
def weight(coupling: ti.template(), i):
    """Return the weight P of entry i."""
    return coupling.values[coupling.lists[WEIGHTS] + i]


@ti.func
def row_number(coupling: ti.template(), r, place: ti.template()):
    """Return a number of row r."""
    return coupling.values[coupling.lists[NUMBERS] + r * ROW_NUMBERS + place]


@ti.func
def row_vector(coupling: ti.template(), r, place: ti.template()):
    """Return three numbers of row r as a vector."""
    first = coupling.lists[NUMBERS] + r * ROW_NUMBERS + place
    return ti.Vector([coupling.values[first + j] for j in ti.static(range(3))])


@ti.func
def position(coupling: ti.template(), body: ti.template(), node):
    """Return the present position [3] [m] of a node relative to the centre of the surfaces."""
    centre = ti.Vector([coupling.values[CENTRE + j] for j in ti.static(range(3))])
    return (row(body.position, node) - centre) + row(body.u, node)


@ti.func
def apart(coupling: ti.template(), boundary: ti.template(), body: ti.template(), r):
    """Return the vector [3] [m] from the masters of row r to its slave, x_s - sum P x_m."""
    result = position(coupling, body, boundary.nodes[entry(coupling, SLAVES, r)])
    for i in range(entry(coupling, FIRST_ENTRY, r), entry(coupling, FIRST_ENTRY, r + 1)):
        there = position(coupling, body, boundary.nodes[entry(coupling, MASTERS, i)])
        result = result - weight(coupling, i) * there
    return result


@ti.func
def present_normal(coupling: ti.template(), body: ti.template(), r):
    """Return the unit normal [3] of row r, out of its masters: the weighted mean of those of its faces."""
    total = row_vector(coupling, r, NORMAL)
    for f in range(entry(coupling, FIRST_FACE, r), entry(coupling, FIRST_FACE, r + 1)):
        first = coupling.lists[FACES] + 4 * f
        corners = [position(coupling, body, coupling.lists[first + j]) for j in range(4)]
        across = (corners[2] - corners[0]).cross(corners[3] - corners[1])
        total += coupling.values[coupling.lists[FACE_WEIGHTS] + f] / across.norm() * across
    return total / total.norm()


@ti.func
def fill_pair_rows(
    coupling: ti.template(), contact: ti.template(), boundary: ti.template(), rows: ti.template(), body: ti.template()
):
    """Fill the rows of all slaves at the present displacement; the other nodes have empty ones."""
    clear_rows(contact, rows)
    meet(contact)
    if ti.static(rows.options.static_friction and rows.options.slots > 1):
        if leader(contact) == 1:  # it notes one of the rows that are deep
            for r in range(coupling.lists[ROWS]):
                fill_pair_row(coupling, boundary, rows, body, r)
    else:
        for turn in range(turns(contact, coupling.lists[ROWS])):
            fill_pair_row(coupling, boundary, rows, body, item(contact, turn))
    meet(contact)


@ti.func
def fill_pair_row(coupling: ti.template(), boundary: ti.template(), rows: ti.template(), body: ti.template(), r):
    """Fill row r."""
    k = entry(coupling, SLAVES, r)
    own = pair_row(rows, k)
    between, normal = apart(coupling, boundary, body, r), present_normal(coupling, body, r)
    set_number(rows, own, rows.at.gap, normal.dot(between) - row_number(coupling, r, CLOSED))
    set_vector(rows, own, rows.at.normal, normal)
    if ti.static(rows.at.size_squared >= 0):
        set_number(rows, own, rows.at.size_squared, position(coupling, body, boundary.nodes[k]).norm_sqr())
    if ti.static(rows.options.static_friction and rows.options.slots > 1):
        leave_obstacles(coupling, rows, r, k)


@ti.func
def leave_obstacles(coupling: ti.template(), rows: ti.template(), r, k):
    """Empty the rows of obstacles of a slave, which friction in the static solve leaves out; note where it is deep.

    The number is that of static/chosen_rows.find_squeezed.
    """
    slots = ti.static(rows.options.slots)
    for p in range(slots - 1):
        row_of_obstacle = k * slots + p
        if number_of(rows, row_of_obstacle, rows.at.gap) < 0.0 - row_number(coupling, r, DEEP):
            coupling.values[SQUEEZED] = 1.0 + row_of_obstacle * slots + (slots - 1)
        clear_row(rows, row_of_obstacle)


@ti.func
def pair_row(rows: ti.template(), k):
    """Return the constraint row of contact node k that belongs to pairs: its last one."""
    slots = ti.static(rows.options.slots)
    return k * slots + (slots - 1)


@ti.func
def clear_rows(contact: ti.template(), rows: ti.template()):
    """Empty the rows of pairs of all contact nodes."""
    for turn in range(turns(contact, node_count(contact))):
        clear_row(rows, pair_row(rows, item(contact, turn)))


@ti.func
def clear_row(rows: ti.template(), r):
    """Empty constraint row r."""
    set_number(rows, r, rows.at.gap, UNREACHED)
    set_vector(rows, r, rows.at.normal, ti.Vector.zero(ti.f64, 3))


@ti.func
def is_stale(
    coupling: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), body: ti.template()
):
    """Return 1 if the rows must be built anew: surfaces have moved against each other, or slaves have slipped too far.

    The rows are filled at the present displacement.
    """
    stale = ti.select(coupling.values[STALE] != 0.0, 1.0, 0.0)
    largest = 0.0
    for turn in range(turns(contact, coupling.lists[ROWS])):
        r = item(contact, turn)
        normal = normal_of(rows, pair_row(rows, entry(coupling, SLAVES, r)))
        slip = apart(coupling, boundary, body, r) - row_vector(coupling, r, ORIGIN)
        slip = slip - normal.dot(slip) * normal
        largest = ti.max(largest, slip.norm())
        if slip.norm() > row_number(coupling, r, SLIP_LIMIT):
            stale = 1.0
    count = coupling.lists[SURFACE_NODES]
    mean = ti.Vector.zero(ti.f64, 3)
    for turn in range(turns(contact, count)):
        mean += since_search(coupling, boundary, body, item(contact, turn))
    total = over_threads(contact, [mean[0], mean[1], mean[2], largest], ("sum", "sum", "sum", "max"))
    mean = ti.Vector([total[0], total[1], total[2]]) / ti.max(1.0, float(count))
    if leader(contact) == 1:
        coupling.values[SLIP] = total[3]
    for turn in range(turns(contact, count)):
        moved = since_search(coupling, boundary, body, item(contact, turn))
        if (moved - mean).norm() > coupling.values[MARGIN]:
            stale = 1.0
    return ti.cast(largest_of(contact, stale), ti.i32)


@ti.func
def since_search(coupling: ti.template(), boundary: ti.template(), body: ti.template(), i):
    """Return the displacement [3] [m] of surface node i since the search."""
    first = coupling.lists[SEARCHED] + 3 * i
    before = ti.Vector([coupling.values[first + j] for j in ti.static(range(3))])
    return row(body.u, boundary.nodes[entry(coupling, SURFACE, i)]) - before


@ti.func
def is_slave(coupling: ti.template(), k):
    """Return whether contact node k has a row of a pair."""
    return entry(coupling, NODE_ROW, k) >= 0


@ti.func
def along(contact: ti.template(), k, vector, block: ti.template()):
    """Return a vector [3] in the massless components [block] of contact node k."""
    result = ti.Vector.zero(ti.f64, block)
    if ti.static(contact.options.plain):
        result = vector
    else:
        for i, j in ti.static(ti.ndrange(3, block)):
            result[j] += contact.basis[(3 * k + i) * block + j] * vector[i]
    return result


@ti.func
def whole(contact: ti.template(), k, values: ti.template(), first, stride, block: ti.template()):
    """Return the vector [3] of contact node k out of its massless components values[first + j stride + k]."""
    result = ti.Vector.zero(ti.f64, 3)
    if ti.static(contact.options.plain):
        result = ti.Vector([values[first + j * stride + k] for j in ti.static(range(3))])
    else:
        for i, j in ti.static(ti.ndrange(3, block)):
            result[i] += contact.basis[(3 * k + i) * block + j] * values[first + j * stride + k]
    return result


@ti.func
def add_along(contact: ti.template(), k, values: ti.template(), first, stride, vector, block: ti.template()):
    """Add a vector [3] in the massless components of contact node k."""
    added = along(contact, k, vector, block)
    for j in ti.static(range(block)):
        values[first + j * stride + k] = values[first + j * stride + k] + added[j]


@ti.func
def lift_of(contact: ti.template(), rows: ti.template(), k, block: ti.template()):
    """Return the motion [3] of slave k, in its massless components, for a unit normal motion of its masters."""
    lift = normal_of(rows, pair_row(rows, k))
    if ti.static(rows.at.lift >= 0):
        found = vector_of(rows, pair_row(rows, k), rows.at.lift)
        lift = ti.Vector.zero(ti.f64, 3)
        for i, j in ti.static(ti.ndrange(3, block)):
            lift[i] += contact.basis[(3 * k + i) * block + j] * found[j]
    else:
        lift = lift / along(contact, k, lift, block).norm_sqr()
    return lift


@ti.func
def followed(contact: ti.template(), rows: ti.template(), k, motion, block: ti.template()):
    """Return how slave k follows a motion [3] of its masters: along its lift, with friction as a whole."""
    result = motion
    if ti.static(not contact.options.static_friction):
        result = normal_of(rows, pair_row(rows, k)).dot(motion) * lift_of(contact, rows, k, block)
    return result


@ti.func
def force_on_masters(contact: ti.template(), rows: ti.template(), k, force, block: ti.template()):
    """Return what slave k hands over to its masters of a force [3] on it; the transpose of `followed`."""
    result = force
    if ti.static(not contact.options.static_friction):
        result = lift_of(contact, rows, k, block).dot(force) * normal_of(rows, pair_row(rows, k))
    return result


@ti.func
def spread(
    coupling: ti.template(),
    contact: ti.template(),
    rows: ti.template(),
    values: ti.template(),
    first,
    stride,
    block: ti.template(),
):
    """Turn y into d = T y: every slave follows the normal motion of its masters, with friction their whole motion.

    y_kj = values[first + j stride + k].
    """
    count, rest = node_count(contact), 0
    meet(contact)
    if leader(contact) == 1:  # one row after another
        rest = coupling.lists[ROWS]
    for r in range(rest):
        k = entry(coupling, SLAVES, r)
        total = ti.Vector.zero(ti.f64, 3)
        for i in range(entry(coupling, FIRST_ENTRY, r), entry(coupling, FIRST_ENTRY, r + 1)):
            m = entry(coupling, MASTERS, i)
            if m < count:
                total += weight(coupling, i) * whole(contact, m, values, first, stride, block)
        add_along(contact, k, values, first, stride, followed(contact, rows, k, total, block), block)
    meet(contact)


@ti.func
def collect(
    coupling: ti.template(),
    contact: ti.template(),
    rows: ti.template(),
    values: ti.template(),
    first,
    stride,
    block: ti.template(),
):
    """Turn forces f into T^t f: every slave gives its masters what it shares with them. f_kj as y in `spread`."""
    count, rest = node_count(contact), 0
    meet(contact)
    if leader(contact) == 1:  # one row after another
        rest = coupling.lists[ROWS]
    for back in range(rest):
        r = rest - 1 - back
        k = entry(coupling, SLAVES, r)
        force = force_on_masters(contact, rows, k, whole(contact, k, values, first, stride, block), block)
        for i in range(entry(coupling, FIRST_ENTRY, r), entry(coupling, FIRST_ENTRY, r + 1)):
            m = entry(coupling, MASTERS, i)
            if m < count:
                add_along(contact, m, values, first, stride, weight(coupling, i) * force, block)
    meet(contact)


@ti.func
def press_all_masters(coupling: ti.template(), body: ti.template(), contact: ti.template(), rows: ti.template()):
    """Apply the forces of all rows to the masters."""
    meet(contact)
    if leader(contact) == 1:
        for r in range(coupling.lists[ROWS]):
            force = vector_of(rows, pair_row(rows, entry(coupling, SLAVES, r)), rows.at.force)
            press_masters(coupling, body.special_force, r, force)
    meet(contact)


@ti.func
def press_masters(coupling: ti.template(), special_force: ti.template(), r, force):
    """Apply the force [3] [N] of row r on its slave, in the opposite direction, to its masters."""
    for i in range(entry(coupling, FIRST_ENTRY, r), entry(coupling, FIRST_ENTRY, r + 1)):
        place = 3 * entry(coupling, MASTERS, i)
        for j in ti.static(range(3)):
            special_force[place + j] = special_force[place + j] + weight(coupling, i) * force[j]
