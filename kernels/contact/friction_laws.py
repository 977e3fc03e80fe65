"""Coefficient of friction of every row where it depends on the slip speed v, the pressure p or the obstacle (METHOD 3).

    mu(v, p) = T(v, p) + (static - kinetic) exp(-decay v),   |t| <= min(mu lambda, limit A)

T is a table, linear in v and p between its entries and constant beyond its ends; that of Coulomb's law has one entry,
kinetic. v is the slip speed after the last kick, or the mean one of the last step of the static solve, which is exactly
0 where the row stuck; p = lambda / A. mu is constant within a kick and within a static solve, so that each has one
solution as with a constant coefficient. A row that has just got its partner takes the speed from the velocities.

A run that goes on from the end of another one (`simulate(initial=)`) starts with a static solve in which nothing moves.
What its nodes are in equilibrium with is the friction of that end, which was within mu of a speed and pressure that are
no longer known: in this solve mu is the largest of the law, so that the nodes stay and the friction is the same.

Behind the numbers of the contact nodes in `contact.friction` stand their areas A [k] [m^2], the records of the laws, of
the pairs of bodies first and then of the obstacles, and their tables (speeds, pressures, coefficients).
"""

from ..engine import ti
from ..lanes import DECAY, FRICTION_LAW, HELD, JUMP, PRESSURES, SHEAR_LIMIT, SPEEDS, TABLE
from ..language.entries import row
from ..language.threads import item, meet, turns
from ..pair_places import AREA, FIRST_ENTRY, MASTERS, NODE_ROW, PAIRS, SIDES
from .constraint_rows import normal_of, number_of, set_number, velocity_of
from .friction import FIRST, NODE
from .islands import node_count
from .massive_tangents import slip_speed_of
from .obstacle_rows import position
from .obstacles import VELOCITY, velocity_at
from .pair_rows import entry, pair_row, row_number, weight

NOBODY = -1.0  # number of the partner of a slave without a row


@ti.func
def interval(numbers: ti.template(), first, count, value):
    """Return the last of `count` rising numbers that is not above a value, and the share of the way to the next."""
    low, high = 0, count
    while high - low > 1:
        middle = (low + high) // 2
        if numbers[first + middle] <= value:
            low = middle
        else:
            high = middle
    here, there = numbers[first + low], numbers[first + ti.min(low + 1, count - 1)]
    share = 0.0
    if there > here:
        share = ti.min(1.0, ti.max(0.0, (value - here) / (there - here)))
    return low, share


@ti.func
def coefficient(numbers: ti.template(), laws, law, speed, pressure):
    """Return mu of a law at a slip speed [m/s] and a pressure [Pa]; laws: place of the first record in the numbers."""
    record = laws + FRICTION_LAW * law
    rows, columns = int(numbers[record + SPEEDS]), int(numbers[record + PRESSURES])
    first = laws + int(numbers[record + TABLE])
    i, along = interval(numbers, first, rows, speed)
    j, across = interval(numbers, first + rows, columns, pressure)
    table = first + rows + columns
    above, right = ti.min(i + 1, rows - 1), ti.min(j + 1, columns - 1)
    near = numbers[table + columns * i + j]
    near += across * (numbers[table + columns * i + right] - near)
    far = numbers[table + columns * above + j]
    far += across * (numbers[table + columns * above + right] - far)
    falling = numbers[record + JUMP] * ti.exp(0.0 - numbers[record + DECAY] * speed)
    return near + along * (far - near) + falling


@ti.func
def largest_coefficient(numbers: ti.template(), laws, law):
    """Return the largest mu of a law at any slip speed and pressure."""
    record = laws + FRICTION_LAW * law
    rows, columns = int(numbers[record + SPEEDS]), int(numbers[record + PRESSURES])
    table = laws + int(numbers[record + TABLE]) + rows + columns
    largest = numbers[table]
    for i in range(1, rows * columns):
        largest = ti.max(largest, numbers[table + i])
    return largest + ti.max(0.0, numbers[record + JUMP])


@ti.func
def coefficient_or_largest(numbers: ti.template(), laws, law, speed, pressure, held):
    """Return mu of a law at a slip speed [m/s] and a pressure [Pa], the largest one if held is 1."""
    mu = 0.0
    if held == 1:
        mu = largest_coefficient(numbers, laws, law)
    else:
        mu = coefficient(numbers, laws, law, speed, pressure)
    return mu


@ti.func
def velocity_now(body: ti.template(), boundary: ti.template(), contact: ti.template(), s, rate):
    """Return the velocity [3] [m/s] of boundary node s; rate: 1 over the step [1/s] that its massless part has done."""
    velocity = row(body.v, boundary.nodes[s])
    if ti.static(contact.options.static_friction):
        if s < node_count(contact):
            block = ti.static(contact.options.block)
            for j in ti.static(range(block)):
                column = ti.Vector([contact.basis[(3 * s + i) * block + j] for i in ti.static(range(3))])
                moved = column.dot(row(body.u, contact.nodes[s])) - contact.displacement_before[s * block + j]
                velocity += rate * moved * column
    return velocity


@ti.func
def speed_now(
    body: ti.template(),
    boundary: ti.template(),
    obstacles: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    contact: ti.template(),
    k,
    r,
    rate,
):
    """Return the slip speed [m/s] of row r of node k out of the velocities of both sides."""
    slip = velocity_now(body, boundary, contact, k, rate)
    paired = 0
    if ti.static(contact.options.coupled):
        if r == pair_row(rows, k):
            paired = 1
            own = entry(coupling, NODE_ROW, k)
            if own >= 0:
                for i in range(entry(coupling, FIRST_ENTRY, own), entry(coupling, FIRST_ENTRY, own + 1)):
                    master = velocity_now(body, boundary, contact, entry(coupling, MASTERS, i), rate)
                    slip = slip - weight(coupling, i) * master
    if ti.static(contact.options.moving):
        if paired == 0:
            if ti.static(rows.at.velocity >= 0):
                slip = slip - velocity_of(rows, r, rows.at.velocity)
            else:
                x = position(contact.reference, k, body.u, contact.nodes[k])
                slip = slip - velocity_at(obstacles, obstacles.candidates[r], x, VELOCITY)
    return slip_speed_of(contact, k, normal_of(rows, r), slip)


@ti.func
def note_slip(
    body: ti.template(),
    boundary: ti.template(),
    obstacles: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    contact: ti.template(),
):
    """Note the slip speed of all rows after a kick."""
    slots = ti.static(rows.options.slots)
    for turn in range(turns(contact, slots * node_count(contact))):
        r = item(contact, turn)
        speed = speed_now(body, boundary, obstacles, rows, coupling, contact, r // slots, r, 0.0)
        set_number(rows, r, rows.at.slip_speed, speed)
    meet(contact)


@ti.func
def law_of_row(obstacles: ti.template(), rows: ti.template(), coupling: ti.template(), contact: ti.template(), k, r):
    """Return the number of the law of row r of node k as a real number: of pairs that of its first master."""
    law = float(obstacles.candidates[r])
    if ti.static(contact.options.coupled):
        law += float(coupling.lists[PAIRS])
        if r == pair_row(rows, k):
            own = entry(coupling, NODE_ROW, k)
            law = NOBODY
            if own >= 0:
                law = float(entry(coupling, SIDES, entry(coupling, FIRST_ENTRY, own)) // 2)
    return law


@ti.func
def set_coefficients(
    body: ti.template(),
    boundary: ti.template(),
    obstacles: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    contact: ti.template(),
    every,
    first,
    step,
):
    """Set the coefficient of all rows (every = 1), or of those with a new partner; step [s]: the next one.

    first = 1: there is no step before. A slave whose masters have several laws takes their mean with its weights.
    Rows of the law HELD have not met a partner yet in the start solve of a run that goes on from another one.
    """
    slots, count = ti.static(rows.options.slots), node_count(contact)
    areas = FIRST + NODE * count
    laws = areas + count
    rate = ti.select(step > 0.0, 1.0 / ti.max(step, 1e-300), 0.0)
    for turn in range(turns(contact, slots * count)):
        r = item(contact, turn)
        k = r // slots
        law = law_of_row(obstacles, rows, coupling, contact, k, r)
        before = number_of(rows, r, rows.at.law)
        held = ti.select(before == HELD and first == 0, 1, 0)
        changed = first == 1 or law != before
        if held == 1 and law < 0.0:
            changed = False
        if changed:
            set_number(rows, r, rows.at.law, law)
            speed = speed_now(body, boundary, obstacles, rows, coupling, contact, k, r, rate)
            set_number(rows, r, rows.at.slip_speed, speed)
        if (changed or every == 1) and law >= 0.0:
            speed, pressing = number_of(rows, r, rows.at.slip_speed), number_of(rows, r, rows.at.pressing)
            area = contact.friction[areas + k]
            mu, limit = 0.0, 0.0
            paired = 0
            if ti.static(contact.options.coupled):
                if r == pair_row(rows, k):
                    paired = 1
                    own = entry(coupling, NODE_ROW, k)
                    area = row_number(coupling, own, AREA)
                    for i in range(entry(coupling, FIRST_ENTRY, own), entry(coupling, FIRST_ENTRY, own + 1)):
                        share, pair = weight(coupling, i), entry(coupling, SIDES, i) // 2
                        pressure = pressing / ti.max(area, 1e-300)
                        mu += share * coefficient_or_largest(contact.friction, laws, pair, speed, pressure, held)
                        limit += share * contact.friction[laws + FRICTION_LAW * pair + SHEAR_LIMIT]
            if paired == 0:
                pressure = pressing / ti.max(area, 1e-300)
                mu = coefficient_or_largest(contact.friction, laws, int(law), speed, pressure, held)
                limit = contact.friction[laws + FRICTION_LAW * int(law) + SHEAR_LIMIT]
            set_number(rows, r, rows.at.coefficient, ti.max(0.0, mu))
            set_number(rows, r, rows.at.shear_limit, ti.max(0.0, limit) * area)
    meet(contact)
