"""Projected block Gauss-Seidel over the contact nodes, several nodes of one colour at a time (METHOD 2).

    d_k <- d_k + omega (D_k^-1 (r_k - sum_j K_kj d_j) - d_k),   j not k,
    then projected onto  g_k + n_k . d_k + e lambda_k >= 0  in the norm of D_k

D_k is the diagonal block of K_KK at node k, r_k the right side, e the compliance of a penalty (0: exact constraint).
The projected method converges for symmetric positive definite K and omega in (0, 2) (Cryer 1971). Every sweep ends with
all constraints satisfied.

A soft mode of the whole contact (cells much taller than wide that lift off) makes the sweeps slow. They are then
accelerated (Nesterov 1983): each pair of a forward and a backward sweep starts from d extrapolated along its last
change. The factor of the extrapolation grows from pair to pair and restarts from 0 when a pair goes back (O'Donoghue
and Candes 2015). A symmetric pair damps every mode without rotating it, which the acceleration needs.

The defect of a sweep is the largest change of a node times its stiffness. It is the residual of the node before its
update, so it estimates the remaining residual from above.
"""

from ..contact.constraint_rows import EPSILON
from ..contact.islands import first_node, first_pack, island_count
from ..contact.local_contact import multipliers
from ..engine import ti
from ..lanes import SWEEP_LANES as LANES
from ..language.threads import item, largest_of, leader, meet, sum_of, turns
from ..language.vectors import load, store
from ..sweep_places import (
    ACCELERATED,
    BACKWARD,
    CHECKED,
    COUNT,
    DEFECT,
    FACTOR,
    MARK,
    OMEGA,
    RUNNING,
    STALLING,
    STATE,
    STRAIGHT,
    SWEEP_LIMIT,
)
from .control import (
    BEFORE,
    F_REF,
    LINEAR,
    MAXIMUM_IN_ALL,
    MAXIMUM_SWEEPS,
    POLISHING_SWEEPS,
    REACH,
    RELAXATION,
    RESIDUAL,
    ROUNDING,
    SETTINGS,
    STATS,
    SWEEPS,
    goals,
)
from .friction_lanes import begin_friction, end_friction, update_pack_with_friction
from .massless_node import entries, in_space, settle, square
from .neighbours import forces_at, neighbour_forces
from .sliding import update_with_friction

STALLED = 0.7  # a sweep that leaves more than this ratio of a residual at rounding level is the last one
INTERVAL = 10.0  # sweeps between two checks of their progress
SLOW = 0.1  # sweeps that leave more than this ratio of the residual over one interval are accelerated from then on
EXTENSION = 50.0  # accelerated sweeps that are allowed after an interval that reduced the residual
LANE_NUMBERS = list(range(LANES))


@ti.func
def prepare(contact: ti.template(), system: ti.template(), island, block: ti.template()):
    """Set `response` of every node of an island with a single row per node: D^-1 n and 1/(n D^-1 n + e)."""
    stride = system.stiffness.shape[0]
    lanes, zero = ti.Vector(LANE_NUMBERS), ti.Vector([0.0 for _ in range(LANES)])
    for pack in range(first_pack(contact, island), first_pack(contact, island + 1)):
        first = system.pack_start[pack]
        count = system.pack_start[pack + 1] - first
        normal = [load(system.normals, first + i * stride, LANES) for i in range(block)]
        compliance = zero
        for i in ti.static(range(block)):
            response = load(system.inverse, first + i * block * stride, LANES) * normal[0]
            for j in ti.static(range(1, block)):
                response += load(system.inverse, first + (i * block + j) * stride, LANES) * normal[j]
            compliance += normal[i] * response
            keep(system, first + i * stride, lanes < count, response)
        compliance += ti.Vector([contact.compliance[first + ti.min(lane, count - 1)] for lane in range(LANES)])
        positive = compliance > 0.0
        inverse = ti.select(positive, 1.0 / ti.select(positive, compliance, zero + 1.0), zero)
        keep(system, first + block * stride, lanes < count, inverse)


@ti.func
def keep(system: ti.template(), place, inside, values):
    """Store numbers of the nodes of a pack in `response`, without the lanes beyond it."""
    store(system.response, place, ti.select(inside, values, load(system.response, place, LANES)), LANES)


@ti.func
def update_pack(contact: ti.template(), system: ti.template(), first, count, rest, relaxation, block: ti.template()):
    """Solve the contact problems of nodes first .. first + count, each with a single row, one node per lane.

    rest: sum_j K_kj d_j, a vector over the lanes for each component. Lanes beyond the pack are computed but not stored.
    Returns the largest defect [N].
    """
    stride = system.stiffness.shape[0]
    zero = ti.Vector([0.0 for _ in range(LANES)])
    right = [load(system.right, first + i * stride, LANES) - rest[i] for i in range(block)]
    old = [load(system.increment, first + i * stride, LANES) for i in range(block)]
    violation = zero - load(system.gaps, first, LANES)
    free = [zero for _ in range(block)]
    for i in ti.static(range(block)):
        alone = zero
        for j in ti.static(range(block)):
            alone += load(system.inverse, first + (i * block + j) * stride, LANES) * right[j]
        free[i] = old[i] + relaxation * (alone - old[i])
        violation = violation - load(system.normals, first + i * stride, LANES) * free[i]  # "-=" fails for vectors
    pressing = ti.max(zero, violation) * load(system.response, first + block * stride, LANES)
    lanes = ti.Vector(LANE_NUMBERS)
    largest_change, total = zero, zero
    for i in ti.static(range(block)):
        wanted = free[i] + pressing * load(system.response, first + i * stride, LANES)
        change = ti.select(lanes < count, wanted - old[i], zero)
        store(system.increment, first + i * stride, ti.select(lanes < count, wanted, old[i]), LANES)
        largest_change = ti.max(largest_change, ti.max(change, zero - change))
        total += change * change
    for lane in ti.static(range(LANES)):
        if lane < count:
            contact.active[first + lane] = ti.select(pressing[lane] > 0.0, 1, 0)
    defect = (load(system.stiffness, first, LANES) * largest_change).max()
    if contact.compliance[first] > 0.0:
        for lane in ti.static(range(LANES)):
            if lane < count and pressing[lane] > 0.0:
                k = first + lane
                own = system.stiffness[k] * largest_change[lane] + ti.sqrt(total[lane]) / contact.compliance[k]
                defect = ti.max(defect, own)
    return defect


@ti.func
def update(
    contact: ti.template(), system: ti.template(), k, rest, relaxation, block: ti.template(), slots: ti.template()
):
    """Solve the contact problem of node k exactly for rest = r_k - sum_j K_kj d_j; return the defect [N]."""
    stride = system.stiffness.shape[0]
    old = entries(system.increment, k, stride, 0, block)
    flexible = square(system.inverse, k, stride, block)
    free = old + relaxation * (flexible @ rest - old)
    d = free
    mask, off = 0, 0.0
    normals = ti.Matrix(
        [
            [system.normals[(p * block + j) * stride + k] for j in ti.static(range(block))]
            for p in ti.static(range(slots))
        ]
    )
    gaps = entries(system.gaps, k, stride, 0, slots)
    if (gaps + normals @ free).min() < 0.0:
        pressing = multipliers(free, normals, gaps, flexible, contact.compliance[k], slots)
        d = free + flexible @ (normals.transpose() @ pressing)
        after = gaps + normals @ d + contact.compliance[k] * pressing
        for p in ti.static(range(slots)):
            if pressing[p] > 0.0:
                mask += 1 << p
            if contact.compliance[k] == 0.0:  # no position satisfies all rows
                off = ti.max(off, 0.0 - after[p] - EPSILON * ti.abs(gaps[p]))
    return ti.max(settle(contact, system, k, d, mask, block), system.stiffness[k] * off)


@ti.func
def sweep_once(contact: ti.template(), rows: ti.template(), system: ti.template(), island, relaxation, backward):
    """Update every node of an island once, colour by colour; return the largest defect [N]. backward: 1 to reverse."""
    defect = 0.0
    if ti.static(contact.options.threads > 1):
        defect = sweep_together(contact, rows, system, island, relaxation, backward)
    else:
        defect = sweep_packs(contact, rows, system, island, relaxation, backward)
    return defect


@ti.func
def sweep_packs(contact: ti.template(), rows: ti.template(), system: ti.template(), island, relaxation, backward):
    """Update every node of an island once on one thread, pack by pack; return the largest defect [N]."""
    begin, end = first_pack(contact, island), first_pack(contact, island + 1)
    return sweep_range(contact, rows, system, begin, end, relaxation, backward)


@ti.func
def sweep_range(
    contact: ti.template(), rows: ti.template(), system: ti.template(), begin, end, relaxation, backward
):  # fmt: skip
    """Update every node of packs begin .. end once on one thread, pack by pack; return the largest defect [N]."""
    block, slots = ti.static(contact.options.block, contact.options.slots)
    stride = system.stiffness.shape[0]
    defect = 0.0
    for turn in range(end - begin):
        pack = ti.select(backward == 1, end - 1 - turn, begin + turn)
        rest = neighbour_forces(system, pack, block)
        first = system.pack_start[pack]
        count = system.pack_start[pack + 1] - first
        if ti.static(slots == 1 and not contact.options.static_friction):
            defect = ti.max(defect, update_pack(contact, system, first, count, rest, relaxation, block))
        elif ti.static(contact.options.friction_in_lanes):
            defect = ti.max(defect, update_pack_with_friction(contact, system, first, count, rest, block))
        else:  # the solve of such a node is too long to be compiled for lanes
            for i in ti.static(range(block)):
                own = load(system.right, first + i * stride, LANES) - rest[i]
                for lane in ti.static(range(LANES)):
                    if lane < count:
                        system.response[i * stride + first + lane] = own[lane]
            for k in range(first, first + count):
                own = entries(system.response, k, stride, 0, block)
                if ti.static(contact.options.static_friction):
                    defect = ti.max(defect, update_with_friction(contact, rows, system, k, own, block, slots))
                else:
                    defect = ti.max(defect, update(contact, system, k, own, relaxation, block, slots))
    return defect


@ti.func
def sweep_together(contact: ti.template(), rows: ti.template(), system: ti.template(), island, relaxation, backward):
    """Update every node of an island once with all threads, which share the nodes of each colour.

    The order of the nodes of one colour does not matter; returns the largest defect [N].
    """
    defect = 0.0
    for turn in range(system.colours[island + 1] - system.colours[island]):
        defect = ti.max(defect, sweep_colour(contact, rows, system, island, turn, relaxation, backward))
        meet(contact)
    return largest_of(contact, defect)


@ti.func
def sweep_colour(
    contact: ti.template(), rows: ti.template(), system: ti.template(), island, turn, relaxation, backward
):  # fmt: skip
    """Update the nodes of a colour of an island, which threads share; return the largest defect [N] of this thread.

    turn: number of the colour, which is counted from the last one if backward = 1.
    """
    block, slots = ti.static(contact.options.block, contact.options.slots)
    stride, defect = system.stiffness.shape[0], 0.0
    begin, end = system.colours[island], system.colours[island + 1]
    colour = island_count(contact) + 1 + ti.select(backward == 1, end - 1 - turn, begin + turn)
    pack = system.colours[colour]
    first = system.pack_start[pack]
    for own in range(turns(contact, system.pack_start[system.colours[colour + 1]] - first)):
        place = item(contact, own)
        rest = forces_at(system, pack + place // LANES, place % LANES, block)
        right = entries(system.right, first + place, stride, 0, block)
        if ti.static(contact.options.static_friction):
            change = update_with_friction(contact, rows, system, first + place, right - rest, block, slots)
            defect = ti.max(defect, change)
        else:
            change = update(contact, system, first + place, right - rest, relaxation, block, slots)
            defect = ti.max(defect, change)
    return defect


@ti.func
def clear(contact: ti.template(), system: ti.template(), island):
    """Set d to 0 in an island; `extrapolate` sets the vectors kept for the acceleration before they are read."""
    stride, begin = system.stiffness.shape[0], first_node(contact, island)
    for component in range(ti.static(contact.options.block)):
        for turn in range(turns(contact, first_node(contact, island + 1) - begin)):
            system.increment[component * stride + begin + item(contact, turn)] = 0.0
    meet(contact)


@ti.func
def extrapolate(contact: ti.template(), system: ti.template(), island, factor):
    """Extrapolate d along its last change, before an accelerated pair of sweeps."""
    stride = system.stiffness.shape[0]
    size, begin = stride * ti.static(contact.options.block), first_node(contact, island)
    for component in range(ti.static(contact.options.block)):
        for turn in range(turns(contact, first_node(contact, island + 1) - begin)):
            i = component * stride + begin + item(contact, turn)
            now = system.increment[i]
            further = now
            if factor > 0.0:
                further = now + factor * (now - system.increment[size + i])
            system.increment[size + i] = now
            system.increment[2 * size + i] = further
            system.increment[i] = further
    meet(contact)


@ti.func
def reversed_direction(contact: ti.template(), system: ti.template(), island):
    """Return whether the last pair of sweeps moved d against the change of the pair before."""
    begin, end = first_node(contact, island), first_node(contact, island + 1)
    return sum_of(contact, advance_of_pair(contact, system, begin, end)) < 0.0


@ti.func
def advance_of_pair(contact: ti.template(), system: ti.template(), begin, end):
    """Return the last change of d in nodes begin .. end times the change of the pair of sweeps before."""
    stride = system.stiffness.shape[0]
    size = stride * ti.static(contact.options.block)
    total = 0.0
    for component in range(ti.static(contact.options.block)):
        for turn in range(turns(contact, end - begin)):
            i = component * stride + begin + item(contact, turn)
            now = system.increment[i]
            total += (now - system.increment[2 * size + i]) * (now - system.increment[size + i])
    return total


@ti.func
def begin_sweeps(contact: ti.template(), rows: ti.template(), system: ti.template(), island):
    """Set d to 0 in an island, and compute what its sweeps need of every node."""
    clear(contact, system, island)
    lanes = ti.static(contact.options.threads == 1 and not contact.options.static_friction)
    if ti.static(lanes and contact.options.slots == 1):
        prepare(contact, system, island, contact.options.block)
    if ti.static(contact.options.friction_in_lanes):
        begin_friction(contact, rows, system, island, contact.options.block)


@ti.func
def sweep(contact: ti.template(), rows: ti.template(), system: ti.template(), island):
    """Sweep over an island until its linear problem is solved as far as `goals` asks; stats[SWEEPS] counts sweeps."""
    begin_sweeps(contact, rows, system, island)
    state = started(system, island)
    minimum, aim, accepted = goals(system.stats, system.settings, island)
    decide_sweep(system, island, state, minimum, aim, accepted)
    while state[RUNNING] == 1.0:
        if state[ACCELERATED] == 1.0 and state[BACKWARD] == 0.0:
            extrapolate(contact, system, island, state[FACTOR])
        defect = sweep_once(contact, rows, system, island, state[OMEGA], int(state[BACKWARD]))
        turned = False
        if state[ACCELERATED] == 1.0 and state[BACKWARD] == 1.0:
            turned = reversed_direction(contact, system, island)
        note_sweep(system, island, state, defect, turned)
        decide_sweep(system, island, state, minimum, aim, accepted)
    if ti.static(contact.options.friction_in_lanes):
        end_friction(contact, rows, system, island)
    if leader(contact) == 1:
        note_sweeps(system, island, state)


@ti.func
def started(system: ti.template(), island):
    """Return the state [STATE] of the sweeps of an island before the first one."""
    state = ti.Vector.zero(ti.f64, STATE)
    state[DEFECT], state[MARK] = 1e300, 1e300
    state[OMEGA] = system.settings[island * SETTINGS + RELAXATION]
    state[SWEEP_LIMIT] = system.settings[island * SETTINGS + MAXIMUM_SWEEPS]
    return state


@ti.func
def decide_sweep(system: ti.template(), island, state: ti.template(), minimum, aim, accepted):
    """Decide whether another sweep follows, and how it is made; minimum, aim, accepted: `goals`.

    Above the tolerance MAXIMUM_SWEEPS are allowed, from there to the smaller aim POLISHING_SWEEPS: where compression
    makes K_KK indefinite, more sweeps would only follow the unstable mode. Accelerated sweeps may continue as long as
    they reduce the residual, which they cannot do when a mode is unstable.
    """
    settings = ti.static(system.settings)
    its = island * SETTINGS
    done, residual = state[COUNT], state[DEFECT]
    more = (
        done < minimum
        or (done < settings[its + POLISHING_SWEEPS] and residual > aim and state[STALLING] == 0.0)
        or (done < state[SWEEP_LIMIT] and residual > accepted)
    )
    state[RUNNING] = ti.select(more, 1.0, 0.0)
    if more and done == state[CHECKED] + INTERVAL:
        if state[ACCELERATED] == 0.0 and done > INTERVAL and residual > ti.max(aim, SLOW * state[MARK]):
            state[ACCELERATED] = 1.0
            state[OMEGA] = 1.0  # over-relaxed sweeps circle about the solution: their change gives no direction
        if state[ACCELERATED] == 1.0 and residual < state[MARK]:
            state[SWEEP_LIMIT] = ti.min(ti.max(state[SWEEP_LIMIT], done + EXTENSION), settings[its + MAXIMUM_IN_ALL])
        state[CHECKED], state[MARK] = done, residual


@ti.func
def note_sweep(system: ti.template(), island, state: ti.template(), defect, turned):
    """Note the largest defect [N] of a sweep, and whether a pair of accelerated sweeps turned back."""
    stats = ti.static(system.stats)
    at, before = island * STATS, state[DEFECT]
    residual = defect / stats[at + F_REF]
    state[DEFECT] = residual
    state[COUNT] += 1.0
    if state[ACCELERATED] == 1.0:
        if state[BACKWARD] == 1.0:
            state[STRAIGHT] = ti.select(turned, 0.0, state[STRAIGHT] + 1.0)
            state[FACTOR] = state[STRAIGHT] / (state[STRAIGHT] + 3.0)
        state[BACKWARD] = 1.0 - state[BACKWARD]
    if residual > STALLED * before and residual <= stats[at + ROUNDING]:
        state[STALLING] = 1.0


@ti.func
def note_sweeps(system: ti.template(), island, state: ti.template()):
    """Note the number of sweeps of a linear problem that has ended, and for linear laws its residual."""
    stats = ti.static(system.stats)
    at = island * STATS
    stats[at + SWEEPS] = stats[at + SWEEPS] + state[COUNT]
    if system.settings[island * SETTINGS + LINEAR] == 1.0:
        stats[at + BEFORE], stats[at + RESIDUAL] = stats[at + RESIDUAL], state[DEFECT]


@ti.func
def move(u: ti.template(), contact: ti.template(), system: ti.template(), island):
    """Move x_K += B d in an island; d is scaled down so that no node moves further than REACH.

    The scaled step stays feasible where the gaps are not negative, since the constraints are convex.
    """
    longest = largest_of(contact, longest_increment(contact, system, island))
    move_by(u, contact, system, island, part_of_move(system, island, longest))


@ti.func
def part_of_move(system: ti.template(), island, longest):
    """Return the part of d that moves the nodes of an island; longest [m]: its longest increment."""
    return ti.min(1.0, system.settings[island * SETTINGS + REACH] / ti.max(longest, 1e-300))


@ti.func
def longest_increment(contact: ti.template(), system: ti.template(), island):
    """Return the length [m] of the longest increment d in an island, of those that this thread has."""
    longest, begin = 0.0, first_node(contact, island)
    block = ti.static(contact.options.block)
    stride = system.stiffness.shape[0]
    for turn in range(turns(contact, first_node(contact, island + 1) - begin)):
        longest = ti.max(longest, entries(system.increment, begin + item(contact, turn), stride, 0, block).norm())
    return longest


@ti.func
def move_by(u: ti.template(), contact: ti.template(), system: ti.template(), island, part):
    """Move x_K += part B d in an island."""
    block = ti.static(contact.options.block)
    stride, begin = system.stiffness.shape[0], first_node(contact, island)
    for turn in range(turns(contact, first_node(contact, island + 1) - begin)):
        k = begin + item(contact, turn)
        step = part * in_space(contact, k, entries(system.increment, k, stride, 0, block))
        for j in ti.static(range(3)):
            place = 3 * contact.nodes[k] + j
            u[place] = u[place] + step[j]
    meet(contact)
