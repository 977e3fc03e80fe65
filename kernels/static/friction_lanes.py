"""Sweeps with Coulomb friction where contact nodes have one row each: the nodes of a pack at once, one per lane.

    d = free + lambda D^-1 n + D^-1 T^t t,   g + n.d + e lambda = 0 or lambda = 0,   t against slip, |t| <= c(lambda)

free = D^-1 (r_k - sum_j K_kj d_j); T: the tangents in the massless components. This is the problem that `sliding.py`
solves for a single node. What stays the same in all sweeps of a linear problem is computed once, by `begin_friction`,
and stands in System.response (places: node_places.FrictionPlaces); `end_friction` stores pressing force and friction in
the rows.
"""

from ..contact.constraint_rows import normal_of, number_of, set_number, set_vector, vector_of
from ..contact.friction import ROUNDS as ROOT_ROUNDS
from ..contact.friction import SINGULAR, STOPPED, tangents
from ..contact.islands import first_node
from ..engine import ti
from ..lanes import SWEEP_LANES as LANES
from ..language.vectors import load
from ..node_places import FRICTION_PLACES
from .massless_node import basis_of, entries, square
from .node_basis import lanes_inside, part, put
from .sliding import CLOSED, ROUNDS, SEARCH, friction_cap


@ti.func
def begin_friction(contact: ti.template(), rows: ti.template(), system: ti.template(), island, block: ti.template()):
    """Compute what the sweeps need of every node of an island, with the friction of the last solve as first guess."""
    at = ti.static(FRICTION_PLACES)
    stride = system.stiffness.shape[0]
    for k in range(first_node(contact, island), first_node(contact, island + 1)):
        flexible, normal = square(system.inverse, k, stride, block), entries(system.normals, k, stride, 0, block)
        across = tangents(normal_of(rows, k))
        there = across @ basis_of(contact.basis, k, block)
        response, turned = flexible @ normal, flexible @ there.transpose()
        mobility, coupling = there @ turned, there @ response
        slip, friction = across @ vector_of(rows, k, rows.at.slip), across @ vector_of(rows, k, rows.at.traction)
        for j in ti.static(range(block)):
            system.response[(at.response + j) * stride + k] = response[j]
            for t in ti.static(range(2)):
                system.response[(at.across + t * block + j) * stride + k] = there[t, j]
                system.response[(at.turned + t * block + j) * stride + k] = turned[j, t]
        system.response[at.compliance * stride + k] = normal.dot(response) + contact.compliance[k]
        system.response[at.mobility * stride + k] = mobility[0, 0]
        system.response[(at.mobility + 1) * stride + k] = mobility[0, 1]
        system.response[(at.mobility + 2) * stride + k] = mobility[1, 1]
        for t in ti.static(range(2)):
            system.response[(at.coupling + t) * stride + k] = coupling[t]
            system.response[(at.slip + t) * stride + k] = slip[t]
            system.response[(at.friction + t) * stride + k] = friction[t]
        system.response[at.coefficient * stride + k] = number_of(rows, k, rows.at.coefficient)
        system.response[at.cap * stride + k] = friction_cap(contact, rows, k, k)
        system.response[at.pressing * stride + k] = number_of(rows, k, rows.at.pressing)
        system.response[at.shift * stride + k] = 0.0


@ti.func
def end_friction(contact: ti.template(), rows: ti.template(), system: ti.template(), island):
    """Set pressing force and friction of the rows of an island to those of the last sweep."""
    at = ti.static(FRICTION_PLACES)
    stride = system.stiffness.shape[0]
    for k in range(first_node(contact, island), first_node(contact, island + 1)):
        set_number(rows, k, rows.at.pressing, system.response[at.pressing * stride + k])
        friction = entries(system.response, k, stride, at.friction, 2)
        set_vector(rows, k, rows.at.traction, tangents(normal_of(rows, k)).transpose() @ friction)


@ti.func
def some(lanes):
    """Return whether a condition holds in some lane."""
    one = ti.Vector([1.0 for _ in range(LANES)])
    return ti.select(lanes, one, one - one).max() > 0.0


@ti.func
def coulomb_lanes(mobility, slip, limit, start, running):
    """Return friction (2) and shift in the running lanes, as `coulomb_force` does; start: shift to begin with, or 0."""
    zero = ti.Vector([0.0 for _ in range(LANES)])
    a, b, c = mobility[0], mobility[1], mobility[2]
    trace, whole = a + c, a * c - b * b
    regular = whole > SINGULAR * trace * trace
    determinant = ti.select(regular, whole, zero)
    along = [c * slip[0] - b * slip[1], a * slip[1] - b * slip[0]]
    sticking = [zero - along[i] / ti.select(regular, whole, zero + 1.0) for i in range(2)]
    sticks = along[0] * along[0] + along[1] * along[1] <= limit * whole * limit * whole
    size = slip[0] * slip[0] + slip[1] * slip[1]
    if some(running and not regular):  # what no force can stop is left
        scale = ti.max(trace * trace, zero + 1e-300)
        least = [zero - (a * slip[0] + b * slip[1]) / scale, zero - (b * slip[0] + c * slip[1]) / scale]
        left = [slip[0] + a * least[0] + b * least[1], slip[1] + b * least[0] + c * least[1]]
        stops = left[0] * left[0] + left[1] * left[1] <= STOPPED * STOPPED * size
        stops = stops and least[0] * least[0] + least[1] * least[1] <= limit * limit
        sticks = ti.select(regular, sticks, stops)
        for i in ti.static(range(2)):
            sticking[i] = ti.select(regular, sticking[i], least[i])
    slides = limit > 0.0
    searching = running and slides and not sticks
    positive = ti.select(slides, limit, zero + 1.0)
    low, high = zero, ti.sqrt(size) / positive
    shift = ti.max(1e-2 * STOPPED * high, high - 0.5 * trace)
    shift = ti.select(start > 0.0, ti.select(start < high, start, shift), shift)
    turn = 0
    while some(searching) and turn < ROOT_ROUNDS:
        whole = determinant + shift * (trace + shift)
        along[0] = (c + shift) * slip[0] - b * slip[1]
        along[1] = (a + shift) * slip[1] - b * slip[0]
        size = along[0] * along[0] + along[1] * along[1]
        excess = ti.sqrt(size) - positive * whole
        searching = searching and ti.max(excess, zero - excess) > 1e-14 * positive * whole
        low = ti.select(excess > 0.0, shift, low)
        high = ti.select(excess > 0.0, high, shift)
        curvature = (c + shift) * along[0] * along[0] - 2.0 * b * along[0] * along[1]
        curvature += (a + shift) * along[1] * along[1]
        trial = shift + size * excess / (positive * ti.max(curvature, zero + 1e-300))
        trial = ti.select(trial > low, ti.select(trial < high, trial, 0.5 * (low + high)), 0.5 * (low + high))
        shift = ti.select(searching, trial, shift)
        turn += 1
    whole = determinant + shift * (trace + shift)
    whole = ti.select(whole > 0.0, whole, zero + 1.0)
    along[0] = (c + shift) * slip[0] - b * slip[1]
    along[1] = (a + shift) * slip[1] - b * slip[0]
    sliding = [zero - along[i] / whole for i in range(2)]
    friction = [ti.select(slides, ti.select(sticks, sticking[i], sliding[i]), zero) for i in range(2)]
    return [friction[0], friction[1], ti.select(sticks, zero, shift)]


@ti.func
def update_pack_with_friction(contact: ti.template(), system: ti.template(), first, count, rest, block: ti.template()):
    """Solve the contact problems of a pack of nodes; rest: sum_j K_kj d_j; return the largest defect [N]."""
    at = ti.static(FRICTION_PLACES)
    zero = ti.Vector([0.0 for _ in range(LANES)])
    inside = lanes_inside(system, count)
    values = ti.static(system.response)
    right, old = part(system, system.right, first, 0, block), part(system, system.increment, first, 0, block)
    inverse = part(system, system.inverse, first, 0, block * block)
    normal, response = part(system, system.normals, first, 0, block), part(system, values, first, at.response, block)
    there, turned = part(system, values, first, at.across, 2 * block), part(system, values, first, at.turned, 2 * block)
    mobility, coupling = part(system, values, first, at.mobility, 3), part(system, values, first, at.coupling, 2)
    slip, friction = part(system, values, first, at.slip, 2), part(system, values, first, at.friction, 2)
    compliance, coefficient, cap, pressing, shift = part(system, values, first, at.compliance, 5)
    gap = load(system.gaps, first, LANES)
    free = [zero for _ in range(block)]
    for i in ti.static(range(block)):
        for j in ti.static(range(block)):
            free[i] += inverse[i * block + j] * (right[j] - rest[j])
    for i in ti.static(range(block)):
        gap += normal[i] * free[i]
        for t in ti.static(range(2)):
            slip[t] = slip[t] + there[t * block + i] * free[i]
    touches = compliance > 0.0
    soft = ti.select(touches, compliance, zero + 1.0)
    drag = coefficient * ti.sqrt(coupling[0] * coupling[0] + coupling[1] * coupling[1])
    steep = gap < 0.0 and drag >= compliance
    running = inside and touches
    low, high, off = zero, zero, zero
    turn = 0
    while some(running) and turn < SEARCH:
        wanted = ti.max(zero, (zero - gap - coupling[0] * friction[0] - coupling[1] * friction[1]) / soft)
        if turn >= ROUNDS:
            further = 2.0 * ti.max(pressing, (zero - gap) / soft)
            wanted = ti.select(high > 0.0, 0.5 * (low + high), further)
        pressing = ti.select(running, wanted, pressing)
        limit = ti.min(coefficient * pressing, cap)
        sliding = [slip[t] + pressing * coupling[t] for t in range(2)]
        found = coulomb_lanes(mobility, sliding, limit, shift, running)
        for t in ti.static(range(2)):
            friction[t] = ti.select(running, found[t], friction[t])
        shift = ti.select(running, found[2], shift)
        after = gap + coupling[0] * friction[0] + coupling[1] * friction[1] + compliance * pressing
        missed = ti.select(pressing > 0.0, ti.max(after, zero - after), ti.max(zero, zero - after))
        off = ti.select(running, missed, off)
        low = ti.select(after < 0.0, pressing, low)
        high = ti.select(after < 0.0, high, pressing)
        turn += 1
        if turn >= ROUNDS:
            running = running and steep and off > CLOSED * ti.max(gap, zero - gap)
    pressing = ti.select(touches, pressing, zero)
    for t in ti.static(range(2)):
        friction[t] = ti.select(touches, friction[t], zero)
    moved = [zero for _ in range(block)]
    largest, total = zero, zero
    for i in ti.static(range(block)):
        moved[i] = free[i] + pressing * response[i] + turned[i] * friction[0] + turned[block + i] * friction[1]
        change = ti.select(inside, moved[i] - old[i], zero)
        largest = ti.max(largest, change, zero - change)
        total += change * change
    put(system, system.increment, first, count, 0, block, moved)
    put(system, values, first, count, at.friction, 2, friction)
    put(system, values, first, count, at.pressing, 2, [pressing, shift])
    stiffness = load(system.stiffness, first, LANES)
    defect = ti.select(inside, stiffness * ti.max(largest, off), zero).max()
    for lane in ti.static(range(LANES)):
        if lane < count:
            k = first + lane
            contact.active[k] = ti.select(pressing[lane] > 0.0, 1, 0)
            if contact.compliance[k] > 0.0:
                own = stiffness[lane] * largest[lane] + ti.select(
                    pressing[lane] > 0.0, ti.sqrt(total[lane]) / contact.compliance[k], 0.0
                )
                defect = ti.max(defect, own, off[lane] / contact.compliance[k])
    return defect
