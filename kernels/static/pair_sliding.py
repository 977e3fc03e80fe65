"""Accelerated solve of the contact nodes with friction between bodies (METHOD 7).

    y' = R(v - tau D^-1 (K v - r)),   v = y' + beta (y' - y),   tau = 1/largest eigenvalue of D^-1 K

in the unknowns y of pair_step.py, where y_s of a slave is its opening and slip. R solves the contact problem of each
node with friction for itself, as if its stiffness were D/tau (`solve_with_friction` in sliding.py). With a fixed limit
of friction this is the proximal gradient method of Beck and Teboulle (2009); the limit mu lambda is that of the last R.
beta grows as theirs, and starts anew where the step turns against the gradient (O'Donoghue and Candes 2015). Nodes that
stick, slide and open are found on the way; rows of obstacles have no masters.
"""

from ..contact.constraint_rows import normal_of, set_number, set_vector, vector_of
from ..contact.friction import tangents
from ..contact.islands import first_node
from ..contact.pair_rows import spread
from ..engine import ti
from ..language.threads import item, leader, meet, over_threads, turns
from ..node_places import PLACES
from .control import (
    F_REF,
    PAIR_STEP,
    PIVOT,
    SETTINGS,
    STATS,
    STEP_LENGTH,
    goals,
    needs_products,
)
from .massless_node import entries, square
from .pair_step import LONG, multiply_coupled, note_products, pair_step, precondition
from .sliding import solve_with_friction

GROWTH = 100.0  # a residual over the smallest one at which the step was too long
UNKNOWN = 1e300


@ti.func
def put_entries(values: ti.template(), k, stride, first: ti.template(), vector: ti.template()):
    """Set components first, first + 1, ... of node k in values [component, node]."""
    for j in ti.static(range(vector.n)):
        values[(first + j) * stride + k] = vector[j]


@ti.func
def set_trial(system: ti.template(), k, v, block: ti.template()):
    """Set the trial motion v of node k, also as its increment, which the product turns into the motion d."""
    stride = system.stiffness.shape[0]
    put_entries(system.response, k, stride, ti.static(PLACES[block]).trial, v)
    put_entries(system.increment, k, stride, 0, v)


@ti.func
def begin_node(contact: ti.template(), rows: ti.template(), system: ti.template(), k, block: ti.template()):
    """Start node k from no motion, with the friction of the last solve in the present tangents."""
    at = ti.static(PLACES[block])
    slots = ti.static(contact.options.slots)
    stride = system.stiffness.shape[0]
    zero = ti.Vector.zero(ti.f64, block)
    put_entries(system.response, k, stride, at.position, zero)
    set_trial(system, k, zero, block)
    for p in ti.static(range(slots)):
        r = k * slots + p
        friction = ti.Vector.zero(ti.f64, 3)
        if normal_of(rows, r).norm_sqr() > 0.0:
            across = tangents(normal_of(rows, r))
            friction = across.transpose() @ (across @ vector_of(rows, r, rows.at.traction))
        else:
            set_number(rows, r, rows.at.pressing, 0.0)
        set_vector(rows, r, rows.at.traction, friction)


@ti.func
def touches(rows: ti.template(), k, slots: ti.template()):
    """Return whether node k has a row."""
    found = 0.0
    for p in ti.static(range(slots)):
        found += normal_of(rows, k * slots + p).norm_sqr()
    return found > 0.0


@ti.func
def step_node(contact: ti.template(), rows: ti.template(), system: ti.template(), k, step, block: ti.template()):
    """Move node k: y' from the product with v; return its defect [N] and (v - y').(y' - y) with its stiffness [J]."""
    at = ti.static(PLACES[block])
    slots = ti.static(contact.options.slots)
    stride = system.stiffness.shape[0]
    v = entries(system.response, k, stride, at.trial, block)
    before = entries(system.response, k, stride, at.position, block)
    gradient = entries(system.response, k, stride, at.product, block) - entries(system.right, k, stride, 0, block)
    flexible = step * square(system.inverse, k, stride, block)
    y = v - flexible @ gradient
    mask, off = 0, 0.0
    if touches(rows, k, slots):
        y, mask, off = solve_with_friction(contact, rows, system, k, y, flexible, block, slots)
    contact.active[k] = mask
    put_entries(system.response, k, stride, at.direction, y - before)
    put_entries(system.response, k, stride, at.position, y)
    change = 0.0
    for j in ti.static(range(block)):
        change = ti.max(change, ti.abs(v[j] - y[j]))
    return system.stiffness[k] * ti.max(change, off), system.stiffness[k] * (v - y).dot(y - before)


@ti.func
def accelerated(
    contact: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    system: ti.template(),
    island,
    block: ti.template(),
):
    """Solve the linear problem of an island as far as `goals` asks; stats[SWEEPS] counts the products with K.

    Returns 1, or 0 if K_KK is indefinite and the increments must not be used.
    """
    at = ti.static(PLACES[block])
    stats, settings = ti.static(system.stats, system.settings)
    begin = first_node(contact, island)
    nodes = first_node(contact, island + 1) - begin
    stride, place, its = system.stiffness.shape[0], island * STATS, island * SETTINGS
    minimum, aim, accepted = goals(stats, settings, island)
    precondition(contact, rows, coupling, system, block)
    step = pair_step(contact, rows, coupling, system, island, settings[its + STEP_LENGTH], block) / LONG
    definite = ti.select(stats[place + PIVOT] > 0.0, 1, 0)
    running, done, speed, smallest = definite, 0.0, 1.0, UNKNOWN
    for turn in range(turns(contact, nodes)):
        begin_node(contact, rows, system, begin + item(contact, turn), block)
    while running == 1:
        multiply_coupled(contact, rows, coupling, system, island, block)
        done += 1.0
        defect, turned = 0.0, 0.0
        for turn in range(turns(contact, nodes)):
            off, along = step_node(contact, rows, system, begin + item(contact, turn), step, block)
            defect = ti.max(defect, off)
            turned += along
        found = over_threads(contact, [defect, turned], ("max", "sum"))
        defect, turned = found[0], found[1]
        residual = defect / step / stats[place + F_REF]
        faster = 0.5 * (1.0 + ti.sqrt(1.0 + 4.0 * speed * speed))
        factor = (speed - 1.0) / faster
        speed = faster
        if turned > 0.0:
            factor, speed = 0.0, 1.0
        more = needs_products(settings, island, done, residual, minimum, aim, accepted)
        running = ti.select(more, 1, 0)
        smallest = ti.min(smallest, residual)
        if not residual < 1e300:
            definite, running = 0, 0
        elif residual > GROWTH * smallest and running == 1:  # the rows have changed since the step was estimated
            if leader(contact) == 1:
                stats[place + PAIR_STEP] = 0.0
            meet(contact)
            longest = pair_step(contact, rows, coupling, system, island, settings[its + STEP_LENGTH], block)
            step = ti.min(0.5 * step, longest / LONG)
            meet(contact)
            if leader(contact) == 1:
                stats[place + PAIR_STEP] = LONG * step
            smallest, factor, speed = UNKNOWN, 0.0, 1.0
            for turn in range(turns(contact, nodes)):
                k = begin + item(contact, turn)
                begin_node(contact, rows, system, k, block)
                put_entries(system.response, k, stride, at.direction, ti.Vector.zero(ti.f64, block))
        for turn in range(turns(contact, nodes)):
            k = begin + item(contact, turn)
            y = entries(system.response, k, stride, at.position, block)
            if running == 1:
                y += factor * entries(system.response, k, stride, at.direction, block)
            set_trial(system, k, y, block)
    meet(contact)
    if leader(contact) == 1:
        note_products(stats, island, done)
    if definite == 1:
        spread(coupling, contact, rows, system.increment, 0, stride, block)
    return definite
