"""Friction layers under the contact nodes of a GPU, between contact load and kick, by its one block of threads.

    |t| = min(stick, tau of the layer, mu P)                                                        (METHOD 5)

It does what tcontact/contact/layered_friction.py does on a CPU: friction work and impulses are collected
until a layer step is due, which spends them (SPEND), or the layers are solved together with the kick (SOLVE). The block
decides which; a thread per layer takes the step (step/device_layers.py); the block judges its error, chooses the length
of the next ones, and goes on with the kick, or asks for a further step: a SPEND that ends a layer step of several
mechanical steps may be followed by a SOLVE. That one takes the launches of the next step that is offered
(step/device_control.py).
"""

from ..columns import SUMS
from ..contact.constraint_rows import number_of
from ..contact.friction import FORCE, KICK_FORCE, LIMIT, SPEED, node_place
from ..contact.friction import KICK_WORK as FRICTION_KICK_WORK
from ..contact.friction import WORK as FRICTION_WORK
from ..contact.islands import node_count
from ..engine import ti
from ..language.joint_lists import number_of_list
from ..language.threads import item, largest_of, leader, meet, over_threads, turns
from ..layer_places import (
    AREA,
    BEFORE,
    BODIES,
    BODY_OF,
    CHANGE,
    CLOSE,
    COEFFICIENT,
    COLUMNS,
    COOL,
    COUNT,
    EASY,
    ELAPSED,
    ENTRIES,
    ENTRY,
    ERROR,
    FIRST,
    FRICTION_IMPULSE,
    GIVEN,
    GIVEN_BEFORE,
    HEAD,
    HEAT_SHARE,
    KICK,
    KICK_WORK,
    LAST,
    LAST_FORCE,
    MAXIMUM_SPAN,
    MEAN_SHEAR,
    MELTING_RISE,
    MOST_SUBSTEPS,
    NODE,
    OWED,
    PARTNERS,
    PHASE,
    PLASTIC,
    PLASTIC_HEAT,
    POWER,
    PRESSED,
    PRESSURE,
    PRESSURE_IMPULSE,
    REST,
    RISE,
    ROUNDING,
    SHARE,
    SLID,
    SLIDES,
    SMALLEST_WORK,
    SOFTNESS,
    SOLVE,
    SPAN,
    SPEND,
    START_GIVEN,
    START_PLASTIC,
    START_RISE,
    START_SHEAR,
    STARTS,
    STEADY,
    STRESS,
    SUBSTEPS,
    TOLERANCE,
    USED,
    WAITING,
    WARM,
    WARMING,
    WORK,
)
from .device_columns import set_columns
from .device_numbers import of_all, of_node, of_used, set_node, size
from .layer1d_residual import SQRT3


@ti.func
def follow_partners(contact: ti.template(), rows: ti.template(), obstacles: ti.template()):
    """Change to the layers of what presses hardest on the nodes, and to the mean coefficient of all rows by force."""
    slots = ti.static(contact.options.slots)
    columns = size(contact, COLUMNS)
    for turn in range(turns(contact, node_count(contact))):
        k = item(contact, turn)
        hardest, slot, several, total, friction = 0.0, 0, 0, 0.0, 0.0
        for p in ti.static(range(slots)):
            pressing = number_of(rows, k * slots + p, rows.at.pressing)
            if pressing > 0.0:
                several += 1
                total += pressing
                friction += number_of(rows, k * slots + p, rows.at.coefficient) * pressing
            if pressing > hardest:
                hardest, slot = pressing, p
        if hardest > 0.0:
            obstacle = ti.min(obstacles.candidates[k * slots + slot], columns - 1)
            body = number_of_list(contact.layer_lists, BODY_OF, k)
            batch = number_of_list(contact.layer_lists, PARTNERS, body * columns + obstacle)
            set_node(contact, USED, k, ti.cast(batch, ti.f64))
            mean = ti.select(several > 1, friction / total, number_of(rows, k * slots + slot, rows.at.coefficient))
            set_node(contact, COEFFICIENT, k, mean)
    meet(contact)


@ti.func
def work_of(contact: ti.template(), k):
    """Return the friction work [J/m^2] of the last step and of the kick before it at node k."""
    work = contact.friction[node_place(k, FRICTION_WORK)]
    if ti.static(contact.options.static_friction):
        work += contact.friction[node_place(k, FRICTION_KICK_WORK)]
    return work / of_node(contact, AREA, k)


@ti.func
def pending_of(contact: ti.template(), k):
    """Return the friction work [J/m^2] of the last kick that the layer of node k has not taken."""
    work = contact.friction[node_place(k, FRICTION_WORK)]
    if ti.static(contact.options.static_friction):
        work = contact.friction[node_place(k, FRICTION_KICK_WORK)]
    return work / of_node(contact, AREA, k) - of_node(contact, KICK_WORK, k)


@ti.func
def collect(contact: ti.template(), k, dt, work, force, pressure):
    """Collect friction work [J/m^2] and impulses of the last kick or step of dt [s]; force [N], pressure [Pa]."""
    set_node(contact, WAITING, k, of_node(contact, WAITING, k) + work)
    impulse = of_node(contact, FRICTION_IMPULSE, k) + force / of_node(contact, AREA, k) * dt
    set_node(contact, FRICTION_IMPULSE, k, impulse)
    set_node(contact, PRESSURE_IMPULSE, k, of_node(contact, PRESSURE_IMPULSE, k) + pressure * dt)


@ti.func
def note_levels(contact: ti.template(), rows: ti.template(), before):
    """Collect what the last step did at every node, note its pressure and friction; return 1 if a contact closes."""
    closes = 0.0
    slots = ti.static(contact.options.slots)
    for turn in range(turns(contact, node_count(contact))):
        k = item(contact, turn)
        area, pressing = of_node(contact, AREA, k), 0.0
        for p in ti.static(range(slots)):
            pressing += number_of(rows, k * slots + p, rows.at.pressing)
        pressure = pressing / area
        work = work_of(contact, k)
        force, last = contact.friction[node_place(k, FORCE)], of_node(contact, LAST, k)
        if ti.static(contact.options.static_friction):
            mean = 0.5 * (of_node(contact, LAST_FORCE, k) + force)
            collect(contact, k, before, work, mean, 0.5 * (last + pressure))
            added = contact.friction[node_place(k, KICK_FORCE)] / area * contact.layers[KICK]
            set_node(contact, FRICTION_IMPULSE, k, of_node(contact, FRICTION_IMPULSE, k) + added)
        elif contact.layers[KICK] > 0.0:  # the kick belongs to the level before
            collect(contact, k, contact.layers[KICK], work, force, last)
        else:
            waiting = of_node(contact, WAITING, k) + (work - of_node(contact, KICK_WORK, k))
            set_node(contact, WAITING, k, waiting)
        if pressure > 0.0 and of_node(contact, PRESSED, k) == 0.0:
            closes = 1.0
        set_node(contact, PRESSED, k, ti.select(pressure > 0.0, 1.0, 0.0))
        set_node(contact, PRESSURE, k, pressure)
        set_node(contact, LAST, k, ti.max(pressure, 0.0))
        set_node(contact, LAST_FORCE, k, force)
    return closes


@ti.func
def note_onset(contact: ti.template(), closes, dt):
    """End long layer steps where contacts close or nodes start to slide; dt [s]: of the last kick or step."""
    largest = HEAD + NODE * node_count(contact) + ENTRY * size(contact, ENTRIES)
    for body in range(size(contact, BODIES)):
        top, first = 0.0, number_of_list(contact.layer_lists, STARTS, body)
        for turn in range(turns(contact, number_of_list(contact.layer_lists, STARTS, body + 1) - first)):
            k = first + item(contact, turn)
            top = ti.max(top, work_of(contact, k))
        top = largest_of(contact, top)
        if leader(contact) == 1:
            contact.layers[largest + body] = ti.max(contact.layers[largest + body], top)
    meet(contact)
    starts, slid = 0.0, 0.0
    for turn in range(turns(contact, node_count(contact))):
        k = item(contact, turn)
        area, body = of_node(contact, AREA, k), number_of_list(contact.layer_lists, BODY_OF, k)
        work = work_of(contact, k)
        rounding = ROUNDING * of_node(contact, LAST_FORCE, k) * contact.friction[node_place(k, SPEED)] * dt / area
        slides = ti.select(work > ti.max(SMALLEST_WORK * contact.layers[largest + body], rounding), 1.0, 0.0)
        before = of_node(contact, SLID, k)
        starts, slid = ti.max(starts, slides - before), ti.max(slid, before)
        set_node(contact, SLID, k, slides)
    found = over_threads(contact, [closes, starts, slid], ("max", "max", "max"))
    if leader(contact) == 1:
        if found[0] > 0.0 or found[1] > 0.0:
            contact.layers[SPAN] = 1.0
        if found[1] > 0.0 and found[2] == 0.0:
            first = ti.min(float(FIRST), contact.layers[MOST_SUBSTEPS])
            contact.layers[SUBSTEPS] = ti.max(contact.layers[SUBSTEPS], first)
    meet(contact)


@ti.func
def warmth(contact: ti.template(), k):
    """Return the rise [K] that changes of the surface temperature of node k are compared with."""
    return ti.max(of_used(contact, RISE, k), WARM * contact.layers[MELTING_RISE])


@ti.func
def note_power(contact: ti.template()):
    """End a long layer step when the friction power differs so much from that of the last one that it shows."""
    elapsed, most = contact.layers[ELAPSED], 0.0
    if contact.layers[SPAN] > 1.0 and elapsed > 0.0:
        for turn in range(turns(contact, node_count(contact))):
            k = item(contact, turn)
            other = ti.abs(of_node(contact, WAITING, k) - of_node(contact, POWER, k) * elapsed)
            warming = contact.layers[SOFTNESS] / ti.sqrt(elapsed) * other
            most = ti.max(most, warming / warmth(contact, k))
        most = largest_of(contact, most)
        if leader(contact) == 1:
            if most > contact.layers[TOLERANCE]:
                contact.layers[SPAN] = 1.0
    meet(contact)


@ti.func
def begin_layers(contact: ti.template(), rows: ti.template(), obstacles: ti.template(), before, after):
    """Collect what the last step did, and say what the layers do; before, after [s]: steps that end and start here."""
    kick = 0.5 * (before + after)
    layers = ti.static(contact.layers)
    if ti.static(contact.options.layers.several):
        follow_partners(contact, rows, obstacles)
    closes = note_levels(contact, rows, before)
    meet(contact)
    last = kick
    if ti.static(contact.options.static_friction):
        last = before
    note_onset(contact, closes, last)
    if leader(contact) == 1:
        if ti.static(contact.options.static_friction):
            layers[ELAPSED] = layers[ELAPSED] + before
            layers[COUNT] = layers[COUNT] + 1.0
        elif layers[KICK] > 0.0:
            layers[ELAPSED] = layers[ELAPSED] + layers[KICK]
            layers[COUNT] = layers[COUNT] + 1.0
    meet(contact)
    note_power(contact)
    if leader(contact) == 1:
        due = layers[COUNT] >= layers[SPAN] or after == 0.0
        if ti.static(not contact.options.static_friction):
            due = due or layers[SPAN] == 1.0
        phase = REST
        if layers[COUNT] > 0.0 and due:
            layers[COUNT] = 0.0
            if layers[ELAPSED] > 0.0:
                phase = SPEND
        if phase == REST and solves(contact, kick) == 1:
            phase = SOLVE
        layers[PHASE] = phase
    meet(contact)
    prepare(contact, before, kick)


@ti.func
def solves(contact: ti.template(), kick):
    """Return 1 if the layers are solved together with the kick [s]."""
    found = 0
    if ti.static(not contact.options.static_friction):
        if contact.layers[SPAN] == 1.0 and kick > 0.0:
            found = 1
    return found


@ti.func
def prepare(contact: ti.template(), before, kick):
    """Compute the columns of the layer step that comes; for a SOLVE note the values before it."""
    phase, span = contact.layers[PHASE], 0.0
    if phase == SPEND:
        span = contact.layers[ELAPSED]
    if phase == SOLVE:
        span = kick
        for turn in range(turns(contact, node_count(contact))):
            k = item(contact, turn)
            set_node(contact, START_RISE, k, of_used(contact, RISE, k))
            set_node(contact, START_PLASTIC, k, of_all(contact, PLASTIC, k))
            set_node(contact, START_GIVEN, k, of_all(contact, GIVEN, k))
        if leader(contact) == 1:
            contact.layers[SHARE] = before / (2.0 * kick)
    if phase != REST:
        set_columns(contact, span / contact.layers[SUBSTEPS])


@ti.func
def end_layers(contact: ti.template(), before, after):
    """Judge the layer step; return 1 if the kick is next and its limit of friction is set, 0 for another layer step."""
    kick = 0.5 * (before + after)
    layers = ti.static(contact.layers)
    phase = layers[PHASE]
    if phase != REST:
        judge(contact)
    again = 0
    if phase == SPEND:
        for turn in range(turns(contact, node_count(contact))):
            k = item(contact, turn)
            set_node(contact, FRICTION_IMPULSE, k, 0.0)
            set_node(contact, PRESSURE_IMPULSE, k, 0.0)
        again = solves(contact, kick)
        meet(contact)
        if leader(contact) == 1:
            layers[ELAPSED] = 0.0
            if again == 1:
                layers[PHASE] = SOLVE
        meet(contact)
    if again == 1:
        prepare(contact, before, kick)
    else:
        set_limits(contact, phase, kick)
    return 1 - again


@ti.func
def set_limits(contact: ti.template(), phase, kick):
    """Set the largest friction of every node for the kick or the static solve that comes; phase: of the last step."""
    lagging = phase != SOLVE and contact.layers[SPAN] > 1.0
    if ti.static(contact.options.static_friction):
        lagging = True
    for turn in range(turns(contact, node_count(contact))):
        k = item(contact, turn)
        limit = 0.0
        if lagging:
            limit = ti.select(of_node(contact, PRESSED, k) > 0.0, of_node(contact, START_SHEAR, k), 1e300)
            set_node(contact, KICK_WORK, k, 0.0)
        elif phase == SOLVE:
            limit = of_node(contact, MEAN_SHEAR, k)
        place = node_place(k, LIMIT)
        contact.friction[place] = ti.min(limit * of_node(contact, AREA, k), 1e300)
    meet(contact)
    if leader(contact) == 1:
        if phase != SOLVE:
            contact.layers[SHARE] = 1.0
        contact.layers[KICK] = ti.select(lagging, kick, 0.0)
    meet(contact)


@ti.func
def judge(contact: ti.template()):
    """Estimate the error of the layer step and choose the length of the next ones.

    Backward Euler errs by half the second difference in a step; friction that uses the stress of the last step errs by
    its change since then. While a layer step spans several mechanical ones, the surface temperature of their rows errs
    by up to its change, and heating is not known within the step.
    """
    off, drift, closest, warming = 0.0, 0.0, 1e300, 0.0
    layers = ti.static(contact.layers)
    for turn in range(turns(contact, node_count(contact))):
        k = item(contact, turn)
        warming = ti.max(warming, ti.abs(of_node(contact, WARMING, k)) / warmth(contact, k))
        stress = of_used(contact, STRESS, k)
        if of_node(contact, SLIDES, k) > 0.0 and stress > 0.0:
            change, last = of_used(contact, CHANGE, k), of_used(contact, BEFORE, k)
            off = ti.max(off, ti.abs(0.5 * (change - last)) / stress)
            drift = ti.max(drift, ti.abs(change) / stress)
            closest = ti.min(closest, of_used(contact, CLOSE, k))
    found = over_threads(contact, [off, drift, closest, warming], ("max", "max", "min", "max"))
    if leader(contact) == 1:
        off, drift, warming = found[0], found[1], found[3]
        span, parts, tolerance = layers[SPAN], layers[SUBSTEPS], layers[TOLERANCE]
        lagging = span > 1.0
        if ti.static(contact.options.static_friction):
            lagging = True
        worst = ti.select(span > 1.0, ti.max(off, warming), off)
        layers[ERROR] = ti.select(lagging, ti.max(worst, drift * parts), worst)
        share = ti.select(span > 1.0, ti.max(worst, drift), off) / tolerance
        # heating later than the work was done makes a layer near melting too soft
        if share > 1.0 or not found[2] > COOL:
            if span > 1.0:
                layers[SPAN] = 1.0
            elif share > 1.0:
                more = ti.ceil(parts * ti.min(2.0, ti.sqrt(share)))
                layers[SUBSTEPS] = ti.min(layers[MOST_SUBSTEPS], more)
        elif share < EASY and parts > 1.0:
            layers[SUBSTEPS] = ti.ceil(0.5 * parts)
        elif drift < EASY * tolerance and warming < STEADY * tolerance:
            layers[SPAN] = ti.min(2.0 * span, float(MAXIMUM_SPAN))
    meet(contact)


@ti.func
def at_row(contact: ti.template(), start: ti.template(), k, end):
    """Return a value at the row: between that before the kick and that at the end of it."""
    share, before = contact.layers[SHARE], of_node(contact, start, k)
    return ti.select(share == 1.0, end, before + share * (end - before))


@ti.func
def measure_layers(contact: ti.template(), out: ti.template(), first):
    """Put the numbers of a row (layer_places.ROW) into `out` from place `first` on; behind the kick."""
    layers = ti.static(contact.layers)
    heat, given, owed, late_share, late_area = 0.0, 0.0, 0.0, 0.0, 0.0
    hottest, lowest = -1e300, 1e300
    for turn in range(turns(contact, node_count(contact))):
        k = item(contact, turn)
        area, waiting, work = of_node(contact, AREA, k), of_node(contact, WAITING, k), of_all(contact, WORK, k)
        pending = pending_of(contact, k)
        done = work + waiting - of_node(contact, OWED, k) + pending
        plastic = layers[PLASTIC_HEAT] * at_row(contact, START_PLASTIC, k, of_all(contact, PLASTIC, k))
        if ti.static(contact.options.layers.plain):
            heat += area * (layers[HEAT_SHARE] * done + plastic)
            given += area * done
        else:
            heat += area * (done + plastic)
            to_obstacle = of_all(contact, GIVEN, k)
            share = ti.min(ti.max(ti.select(work > 0.0, to_obstacle / ti.max(work, 1e-300), 0.0), 0.0), 1.0) * area
            given += area * (at_row(contact, START_GIVEN, k, to_obstacle) - of_node(contact, GIVEN_BEFORE, k))
            owed += share * waiting
            late_share += share * pending
            late_area += area * pending
        hottest = ti.max(hottest, at_row(contact, START_RISE, k, of_used(contact, RISE, k)))
        shear = of_used(contact, STRESS, k) / SQRT3
        if shear > 0.0:
            shown = at_row(contact, START_SHEAR, k, shear)
            lowest = ti.select(shown > 0.0, ti.min(lowest, shown), lowest)
    sums = over_threads(contact, [heat, given, owed, late_share, late_area], ("sum",) * 5)
    ends = over_threads(contact, [hottest, lowest], ("max", "min"))
    if leader(contact) == 1:
        late = contact.sums[SUMS.friction_after]
        if ti.static(contact.options.layers.plain):
            out[first] = sums[0] - layers[HEAT_SHARE] * late
            out[first + 1] = (1.0 - layers[HEAT_SHARE]) * (sums[1] - late)
        else:
            total = sums[1] + sums[2] + sums[3]
            if layers[SHARE] == 1.0 and sums[4] > 0.0:  # the layers did not take the kick with it
                total -= late * sums[3] / sums[4]
            out[first] = sums[0] - late - total
            out[first + 1] = total
        out[first + 2] = ends[0]
        out[first + 3] = ti.select(ends[1] < 1e300, ends[1], 0.0)
        out[first + 4] = layers[ERROR]
        out[first + 5] = layers[SUBSTEPS] / layers[SPAN]
