"""MPRGP: modified proportioning with reduced gradient projections, for contact nodes with constraint rows (METHOD 2).

    min 1/2 d.K d - r.d   with   g_k + n_k.d_k >= 0

Dostal and Schoberl, Comput. Optim. Appl. 30 (2005) 23-43. In the bases of node_basis.py, d_k = T z_k, every diagonal
block of K is the identity and the constraint is a bound on one component, z_k1 >= bound; several rows of a node bound
one component each (several_bounds.py). The gradient K z - b has a free part (components above their bounds) and a
chopped part (components at their bounds that pull away from the obstacle). Each iteration takes one of three steps
along a direction p:

- conjugate gradient: minimise along p, the free gradient made conjugate to the last direction.
- expansion: if that step would cross a bound, stop at the bound, then take a projected step along the free gradient.
- proportioning: if the chopped gradient exceeds the free one, p is the chopped gradient, which releases those nodes.

The bases precondition K, whose eigenvalues then do not exceed the number of contact nodes of one cell: the length of a
projected step needs no estimate, except with pairs of bodies, which couple more nodes (pair_step.py). A direction of
negative curvature shows that K is indefinite; the solve then ends, and the sweeps take over.

The phases are functions of one pack, at most LANES nodes of one colour. Sums are taken in a fixed order. Threads that
share the loops take a node each, as a pack of its own.
"""

from ..contact.pair_rows import spread
from ..engine import ti
from ..language.threads import leader, meet, over_threads
from ..language.vectors import load
from ..node_places import PLACES
from .control import (
    BEFORE,
    F_REF,
    LINEAR,
    PIVOT,
    RESIDUAL,
    SETTINGS,
    STATS,
    STEP_LENGTH,
    goals,
    needs_products,
)
from .node_basis import into_basis, into_force, into_motion, lanes_inside, part, put, set_basis, zeros
from .pair_step import multiply_in_bases, note_products, pair_step, precondition
from .parts import part_of, parts, product_of
from .several_bounds import row_of

UNLIMITED = 1e300
NEGLIGIBLE = 1e-20  # a residual over F_ref that changes no digit of any increment


@ti.func
def put_motion(system: ti.template(), node, count, vector, block: ti.template()):
    """Store T times a vector as the increments of a pack: its neighbours read them in the next product with K."""
    put(system, system.increment, node, count, 0, block, into_motion(system, node, vector, block))


@ti.func
def bounds_of(system: ti.template(), node, block: ti.template(), bounds: ti.template()):
    """Return the lower bounds of the first components [bounds] of z in a pack."""
    places = ti.static(PLACES[block].bounds)
    return [load(system.response, node + places[i] * system.stiffness.shape[0], system.lanes) for i in range(bounds)]


@ti.func
def slack_of(system: ti.template(), node, block: ti.template(), bounds: ti.template()):
    """Return the distances [bounds] of the first components of z from their bounds in a pack."""
    slack = part(system, system.response, node, ti.static(PLACES[block]).position, bounds)
    lowest = bounds_of(system, node, block, bounds)
    for i in ti.static(range(bounds)):
        slack[i] = slack[i] - lowest[i]
    return slack


@ti.func
def split(system: ti.template(), node, block: ti.template(), bounds: ti.template()):
    """Return the free gradient [block] of a pack and its chopped gradient [bounds]."""
    zero = zeros(system)
    free = part(system, system.response, node, ti.static(PLACES[block]).gradient, block)
    slack = slack_of(system, node, block, bounds)
    chopped = [zero for _ in range(bounds)]
    for i in ti.static(range(bounds)):
        chopped[i] = ti.select(slack[i] > 0.0, zero, ti.min(free[i], zero))
        free[i] = ti.select(slack[i] > 0.0, free[i], zero)
    return free, chopped


@ti.func
def begin(system: ti.template(), node, count, step, block: ti.template(), bounds: ti.template()):
    """Set the bases of a pack, and z to a projected gradient step from d = 0."""
    at = ti.static(PLACES[block])
    zero = zeros(system)
    set_basis(system, node, count, block, bounds)
    position = into_basis(system, node, part(system, system.right, node, 0, block), block)
    for i in ti.static(range(block)):
        position[i] = step * position[i]
    lowest = bounds_of(system, node, block, bounds)
    for i in ti.static(range(bounds)):
        position[i] = ti.max(position[i], lowest[i])
    put(system, system.response, node, count, at.position, block, position)
    put(system, system.response, node, count, at.direction, block, [zero for _ in range(block)])
    put_motion(system, node, count, position, block)


@ti.func
def multiply_all(
    contact: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    system: ti.template(),
    island,
    block: ti.template(),
):
    """Set the product with K of all packs of an island, in the bases of its nodes."""
    if ti.static(contact.options.coupled):
        multiply_in_bases(contact, rows, coupling, system, island, block)
    else:
        for turn in range(parts(contact, island)):
            pack, node, count = part_of(contact, system, island, turn)
            if count > 0:
                multiply(contact, system, pack, node, count, block)


@ti.func
def multiply(contact: ti.template(), system: ti.template(), pack, node, count, block: ti.template()):
    """Set the product of a pack: the forces [in the bases of its nodes] that the motion of their neighbours causes.

    pack: the one of the sweeps, in which the nodes stand.
    """
    set_product(system, node, count, product_of(contact, system, pack, node, block), block)


@ti.func
def set_product(system: ti.template(), node, count, force, block: ti.template()):
    """Set the product of a pack to forces from its neighbours."""
    product = into_basis(system, node, force, block)
    put(system, system.response, node, count, ti.static(PLACES[block]).product, block, product)


@ti.func
def set_gradient(contact: ti.template(), system: ti.template(), node, count, block: ti.template()):
    """Set the gradient K z - b of a pack after the product with z.

    Without pairs of bodies the product lacks what the diagonal block of a node adds, z itself.
    """
    at = ti.static(PLACES[block])
    gradient = part(system, system.response, node, at.product, block)
    position = part(system, system.response, node, at.position, block)
    right = into_basis(system, node, part(system, system.right, node, 0, block), block)
    for i in ti.static(range(block)):
        if ti.static(contact.options.coupled):
            gradient[i] = gradient[i] - right[i]
        else:
            gradient[i] += position[i] - right[i]
    put(system, system.response, node, count, at.gradient, block, gradient)


@ti.func
def measure_direction(
    contact: ti.template(), system: ti.template(), node, count, block: ti.template(), bounds: ti.template()
):
    """Complete K p of a pack after the product with p; return p.K p, gradient.p and the step along -p to the bound.

    Each result is a vector over the lanes.
    """
    at = ti.static(PLACES[block])
    zero = zeros(system)
    direction = part(system, system.response, node, at.direction, block)
    gradient = part(system, system.response, node, at.gradient, block)
    product = part(system, system.response, node, at.product, block)
    curvature, slope = zero, zero
    for i in ti.static(range(block)):
        if ti.static(not contact.options.coupled):
            product[i] += direction[i]
        curvature += direction[i] * product[i]
        slope += direction[i] * gradient[i]
    put(system, system.response, node, count, at.product, block, product)
    slack = slack_of(system, node, block, bounds)
    inside = lanes_inside(system, count)
    reach = zero + UNLIMITED
    for i in ti.static(range(bounds)):
        towards = inside and direction[i] > 0.0
        reach = ti.min(reach, ti.select(towards, slack[i] / ti.max(direction[i], 1e-300), zero + UNLIMITED))
    return [ti.select(inside, curvature, zero), ti.select(inside, slope, zero), reach]


@ti.func
def advance(system: ti.template(), node, count, length, block: ti.template(), bounds: ti.template()):
    """Take a step of this length along -p: update z of a pack and its gradient."""
    at = ti.static(PLACES[block])
    position = part(system, system.response, node, at.position, block)
    gradient = part(system, system.response, node, at.gradient, block)
    direction = part(system, system.response, node, at.direction, block)
    product = part(system, system.response, node, at.product, block)
    for i in ti.static(range(block)):
        position[i] = position[i] - length * direction[i]
        gradient[i] = gradient[i] - length * product[i]
    lowest = bounds_of(system, node, block, bounds)
    for i in ti.static(range(bounds)):
        position[i] = ti.max(position[i], lowest[i])
    put(system, system.response, node, count, at.position, block, position)
    put(system, system.response, node, count, at.gradient, block, gradient)


@ti.func
def expand(system: ti.template(), node, count, step, block: ti.template(), bounds: ti.template()):
    """Take a projected step of a pack along its free gradient, from where the last step has met a bound."""
    at = ti.static(PLACES[block])
    free, _chopped = split(system, node, block, bounds)
    position = part(system, system.response, node, at.position, block)
    for i in ti.static(range(block)):
        position[i] = position[i] - step * free[i]
    lowest = bounds_of(system, node, block, bounds)
    for i in ti.static(range(bounds)):
        position[i] = ti.max(position[i], lowest[i])
    put(system, system.response, node, count, at.position, block, position)
    put_motion(system, node, count, position, block)


@ti.func
def measure_gradient(system: ti.template(), node, count, step, block: ti.template(), bounds: ti.template()):
    """Return what decides on the next step, each a vector over the lanes of a pack.

    The reduced free gradient times the free one, the square of the chopped gradient, the free gradient times K p, and
    the largest component of the unbalanced force [N]. The reduced gradient is cut where a step would cross the bound.
    """
    zero = zeros(system)
    product = part(system, system.response, node, ti.static(PLACES[block]).product, block)
    free, chopped = split(system, node, block, bounds)
    slack = slack_of(system, node, block, bounds)
    reduced = ti.min(slack[0] / step, free[0]) * free[0]
    conjugate = free[0] * product[0]
    pulling = chopped[0] * chopped[0]
    for i in ti.static(range(1, block)):
        if ti.static(i < bounds):
            reduced += ti.min(slack[i] / step, free[i]) * free[i]
            pulling += chopped[i] * chopped[i]
        else:
            reduced += free[i] * free[i]
        conjugate += free[i] * product[i]
    for i in ti.static(range(bounds)):
        free[i] = free[i] + chopped[i]
    force = into_force(system, node, free, block)
    residual = zero
    for i in ti.static(range(block)):
        residual = ti.max(residual, force[i], zero - force[i])
    inside = lanes_inside(system, count)
    results = [reduced, pulling, conjugate, residual]
    return [ti.select(inside, result, zero) for result in results]


@ti.func
def set_direction(
    system: ti.template(), node, count, proportional, factor, block: ti.template(), bounds: ti.template()
):
    """Set the next direction: free gradient less factor times the last one, or (proportional = 0) chopped gradient."""
    at = ti.static(PLACES[block])
    direction = part(system, system.response, node, at.direction, block)
    free, chopped = split(system, node, block, bounds)
    for i in ti.static(range(block)):
        direction[i] = proportional * (free[i] - factor * direction[i])
    for i in ti.static(range(bounds)):
        direction[i] = direction[i] + (1.0 - proportional) * chopped[i]
    put(system, system.response, node, count, at.direction, block, direction)
    put_motion(system, node, count, direction, block)


@ti.func
def finish(contact: ti.template(), system: ti.template(), node, count, block: ti.template(), bounds: ti.template()):
    """Set the increments of a pack, and as active the rows of nodes at their bounds that press on their partners."""
    at = ti.static(PLACES[block])
    put_motion(system, node, count, part(system, system.response, node, at.position, block), block)
    slack = slack_of(system, node, block, bounds)
    pressing = part(system, system.response, node, at.gradient, bounds)
    for lane in ti.static(range(system.lanes)):
        if lane < count:
            active = 0
            for i in ti.static(range(bounds)):
                if slack[i][lane] <= 0.0 and pressing[i][lane] > 0.0:
                    active += 1 << row_of(contact, system, node + lane, i, block)
            contact.active[node + lane] = active


@ti.func
def mprgp(
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
    stats, settings = ti.static(system.stats, system.settings)
    bounds = ti.static(contact.options.bounds)
    zero = zeros(system)
    at, its = island * STATS, island * SETTINGS
    minimum, aim, accepted = goals(stats, settings, island)
    step = settings[its + STEP_LENGTH]
    if ti.static(contact.options.coupled):
        precondition(contact, rows, coupling, system, block)
        step = pair_step(contact, rows, coupling, system, island, step, block)
    definite = ti.select(stats[at + PIVOT] > 0.0, 1, 0)
    if definite == 1:
        for turn in range(parts(contact, island)):
            _pack, node, count = part_of(contact, system, island, turn)
            if count > 0:
                begin(system, node, count, step, block, bounds)
    running, projected = definite, 1  # projected: z comes from a projected step, so the next product is with z, not p
    done, proportional, factor, curvature, residual = 0.0, 0.0, 0.0, 0.0, 0.0
    while running == 1:
        meet(contact)
        multiply_all(contact, rows, coupling, system, island, block)
        done += 1.0
        expands = 0
        if projected == 1:
            proportional = 0.0
            for turn in range(parts(contact, island)):
                _pack, node, count = part_of(contact, system, island, turn)
                if count > 0:
                    set_gradient(contact, system, node, count, block)
        else:
            sums = [zero, zero, zero + UNLIMITED]
            for turn in range(parts(contact, island)):
                _pack, node, count = part_of(contact, system, island, turn)
                if count > 0:
                    found = measure_direction(contact, system, node, count, block, bounds)
                    sums[0] += found[0]
                    sums[1] += found[1]
                    sums[2] = ti.min(sums[2], found[2])
            totals = over_threads(contact, [sums[0].sum(), sums[1].sum(), sums[2].min()], ("sum", "sum", "min"))
            curvature = totals[0]
            length, reach = totals[1] / curvature, totals[2]
            if not curvature > 0.0:
                definite, running = 0, 0
            else:
                for turn in range(parts(contact, island)):
                    _pack, node, count = part_of(contact, system, island, turn)
                    if count > 0:
                        advance(system, node, count, ti.min(length, reach), block, bounds)
                if length > reach:
                    expands = 1
                    for turn in range(parts(contact, island)):
                        _pack, node, count = part_of(contact, system, island, turn)
                        if count > 0:
                            expand(system, node, count, step, block, bounds)
        projected = expands
        if running == 1 and expands == 0:
            sums = [zero, zero, zero, zero]
            for turn in range(parts(contact, island)):
                _pack, node, count = part_of(contact, system, island, turn)
                if count > 0:
                    found = measure_gradient(system, node, count, step, block, bounds)
                    for i in ti.static(range(3)):
                        sums[i] += found[i]
                    sums[3] = ti.max(sums[3], found[3])
            totals = over_threads(
                contact, [sums[0].sum(), sums[1].sum(), sums[2].sum(), sums[3].max()], ("sum", "sum", "sum", "max")
            )
            reduced, chopped = totals[0], totals[1]
            residual = totals[3] / stats[at + F_REF]
            factor = 0.0
            if proportional == 1.0:
                factor = totals[2] / curvature
            proportional = ti.select(chopped <= reduced, 1.0, 0.0)
            more = needs_products(settings, island, done, residual, minimum, aim, accepted)
            running = ti.select(more and residual > NEGLIGIBLE, 1, 0)
            if not reduced + chopped < UNLIMITED:  # not a number: the sweeps report it
                definite, running = 0, 0
            if running == 1:
                for turn in range(parts(contact, island)):
                    _pack, node, count = part_of(contact, system, island, turn)
                    if count > 0:
                        set_direction(system, node, count, proportional, factor, block, bounds)
    meet(contact)
    if leader(contact) == 1:
        note_products(stats, island, done)
    if definite == 1:
        for turn in range(parts(contact, island)):
            _pack, node, count = part_of(contact, system, island, turn)
            if count > 0:
                finish(contact, system, node, count, block, bounds)
        if ti.static(contact.options.coupled):
            spread(coupling, contact, rows, system.increment, 0, system.stiffness.shape[0], block)
        if settings[its + LINEAR] == 1.0 and leader(contact) == 1:
            stats[at + BEFORE], stats[at + RESIDUAL] = stats[at + RESIDUAL], residual
    meet(contact)
    return definite
