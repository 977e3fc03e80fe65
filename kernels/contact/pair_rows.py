"""Constraint rows of pairs of bodies: one for a slave node, with weights P of the master's nodes (METHOD 7).

    g = nu . (x_s - sum_m P_sm x_m) >= 0,   lambda >= 0,   force lambda nu on s, -P_sm lambda nu on m

The rows stand in the slot of their slave, where an obstacle has none. A change of basis in the normal component makes
the constraint a bound on one number of the slave, y_s = d_s - nu nu.(P d): `spread` is d = T y, `collect` is T^t f. A
slave may be a master of softer bodies: the rows stand in the order of their slaves, the masters of a row before it, so
that one pass through them, or one backward, is T or T^t.

nu is the mean normal of the faces of a row, renewed with every gap; weights and faces are kept until the slip is too
large (`is_stale`). Places of the data: pair_places.py.
"""

import taichi as ti

from ..language.entries import row
from ..pair_places import (
    CENTRE,
    CLOSED,
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
from .constraint_rows import normal_of, number_of, set_number, set_vector
from .islands import node_count

UNREACHED = 1e300  # gap of a node without a row


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
    """Fill the rows of all slaves at the present displacement; without obstacles the other nodes have empty ones."""
    if ti.static(len(contact.options.shapes) == 0):
        clear_rows(contact, rows)
    for r in range(coupling.lists[ROWS]):
        fill_pair_row(coupling, boundary, rows, body, r)


@ti.func
def fill_pair_row(coupling: ti.template(), boundary: ti.template(), rows: ti.template(), body: ti.template(), r):
    """Fill row r; note a slave that is deep in an obstacle, to which its only row does not belong."""
    k = entry(coupling, SLAVES, r)
    if ti.static(len(rows.options.shapes) > 0):  # the row of the obstacle, which this one replaces
        if number_of(rows, k, rows.at.gap) < 0.0 - row_number(coupling, r, SLIP_LIMIT):
            coupling.values[SQUEEZED] = 1.0 + r
    between, normal = apart(coupling, boundary, body, r), present_normal(coupling, body, r)
    set_number(rows, k, rows.at.gap, normal.dot(between) - row_number(coupling, r, CLOSED))
    set_vector(rows, k, rows.at.normal, normal)
    set_number(rows, k, rows.at.size_squared, position(coupling, body, boundary.nodes[k]).norm_sqr())


@ti.func
def clear_rows(contact: ti.template(), rows: ti.template()):
    """Empty the rows of all contact nodes."""
    for k in range(node_count(contact)):
        set_number(rows, k, rows.at.gap, UNREACHED)
        set_vector(rows, k, rows.at.normal, ti.Vector.zero(ti.f64, 3))


@ti.func
def is_stale(coupling: ti.template(), boundary: ti.template(), rows: ti.template(), body: ti.template()):
    """Return 1 if the rows must be built anew: surfaces have moved against each other, or slaves have slipped too far.

    The rows are filled at the present displacement.
    """
    stale = ti.select(coupling.values[STALE] != 0.0, 1, 0)
    largest = 0.0
    for r in range(coupling.lists[ROWS]):
        normal = normal_of(rows, entry(coupling, SLAVES, r))
        slip = apart(coupling, boundary, body, r) - row_vector(coupling, r, ORIGIN)
        slip = slip - normal.dot(slip) * normal
        largest = ti.max(largest, slip.norm())
        if slip.norm() > row_number(coupling, r, SLIP_LIMIT):
            stale = 1
    coupling.values[SLIP] = largest
    count = coupling.lists[SURFACE_NODES]
    mean = ti.Vector.zero(ti.f64, 3)
    for i in range(count):
        mean += since_search(coupling, boundary, body, i)
    mean = mean / ti.max(1.0, float(count))
    for i in range(count):
        if (since_search(coupling, boundary, body, i) - mean).norm() > coupling.values[MARGIN]:
            stale = 1
    return stale


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
def spread(
    coupling: ti.template(),
    contact: ti.template(),
    rows: ti.template(),
    values: ti.template(),
    first,
    stride,
    block: ti.template(),
):
    """Turn y into d = T y: every slave follows the normal motion of its masters.

    y_kj = values[first + j stride + k].
    """
    count = node_count(contact)
    for r in range(coupling.lists[ROWS]):
        k = entry(coupling, SLAVES, r)
        normal = normal_of(rows, k)
        own = along(contact, k, normal, block)
        total = 0.0
        for i in range(entry(coupling, FIRST_ENTRY, r), entry(coupling, FIRST_ENTRY, r + 1)):
            m = entry(coupling, MASTERS, i)
            if m < count:
                there = along(contact, m, normal, block)
                part = 0.0
                for j in ti.static(range(block)):
                    part += there[j] * values[first + j * stride + m]
                total += weight(coupling, i) * part
        for j in ti.static(range(block)):
            place = first + j * stride + k
            values[place] = values[place] + own[j] * (total / own.norm_sqr())


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
    """Turn forces f into T^t f: every slave gives its normal force to its masters too. f_kj as y in `spread`."""
    count, rest = node_count(contact), coupling.lists[ROWS]
    for back in range(rest):
        r = rest - 1 - back
        k = entry(coupling, SLAVES, r)
        normal = normal_of(rows, k)
        own = along(contact, k, normal, block)
        total = 0.0
        for j in ti.static(range(block)):
            total += own[j] * values[first + j * stride + k]
        total = total / own.norm_sqr()
        for i in range(entry(coupling, FIRST_ENTRY, r), entry(coupling, FIRST_ENTRY, r + 1)):
            m = entry(coupling, MASTERS, i)
            if m < count:
                there = along(contact, m, normal, block)
                for j in ti.static(range(block)):
                    place = first + j * stride + m
                    values[place] = values[place] + weight(coupling, i) * total * there[j]


@ti.func
def press_masters(coupling: ti.template(), special_force: ti.template(), r, force):
    """Apply the force [3] [N] of row r on its slave, in the opposite direction, to its masters."""
    for i in range(entry(coupling, FIRST_ENTRY, r), entry(coupling, FIRST_ENTRY, r + 1)):
        place = 3 * entry(coupling, MASTERS, i)
        for j in ti.static(range(3)):
            special_force[place + j] = special_force[place + j] + weight(coupling, i) * force[j]
