"""One step of a friction layer, of the cells in the lanes of one thread (METHOD 5, equations (7) and (8) of the paper).

It restarts from the yield limit if required, solves a tridiagonal system and the scalar equation for sig, and sets the
new state (`layer1d_phases`, `layer1d_solve`). With two sides the heat is divided such that the surface temperatures
obey the contact conductance:

    q_A = g (Tz_B - Tz_A) + (1 + g (Bq_B - Bq_A)) W/2,  q_B = W - q_A,  g = 1/(1/conductance + Bq_A + Bq_B)

A cell that has never been in contact is left as it is; an open cell conducts heat but neither slips nor flows.
"""

import functools

from ..engine import ti
from ..language.vectors import load, store
from . import layer1d_residual as eq
from .layer1d_phases import make_phases
from .layer1d_residual import FAR_END, MATERIAL, NODE, SQRT3, WARMTH
from .layer1d_solve import NEWTON, make_solve

# numbers of a cell: sqrt3 tau [Pa], stress from which the next step starts, its last two changes, 1 - sig/s_melt, last
# pressure [Pa], 1: it flowed, 1: it has been in contact, slip work and plastic work [J/m^2], failed steps, evaluations,
# drag [m/(s Pa)] and cap [Pa] of the traction
STRESS, TRIAL, CHANGE, BEFORE, CLOSE, PRESSURE, FLOWED = range(7)
WARM, WORK, PLASTIC_WORK, FAILURES, EVALUATIONS, DRAG, CAP = range(7, 14)
CELL = 14
# with two sides follows the heat through the surface into the second one [J/m^2]; with open far ends the temperature
# beyond the far end of every side, less the base [K], and then the heat that left through it [J/m^2]
OTHER = CELL
MELTING = 0.05  # below this CLOSE the first guess has the last distance to melting, else it is extrapolated in time
SETTINGS = 5  # numbers behind the materials in params: heat share, g, C, dt, 1: the yield limit may raise sig


def far_places(sides: int) -> tuple[int, int]:
    """Return where the temperatures beyond the far ends begin in a cell, and the heat that left through these."""
    return CELL + sides - 1, CELL + 2 * sides - 1


def cell_numbers(sides: int, ends: bool) -> int:
    """Return how many numbers a cell has; ends: its far ends are open."""
    return CELL + sides - 1 + 2 * sides * ends


@ti.func
def melting_stress(heat, velocity, drag, cap):
    """Return the sig that generates the heat W = `heat`; 1e300 if there is none."""
    root = velocity * velocity - 4.0 * drag * heat
    traction = 2.0 * heat / ti.max(velocity + eq.square_root(ti.max(root, 0.0 * root)), 1e-300)
    reached = ti.select(root >= 0.0, traction, 0.0 * root + 1e300)
    return ti.select(reached < cap, SQRT3 * ti.min(reached, 1e290), 0.0 * root + 1e300)


@functools.cache
def make_layer_step(width: int, stride: int, sides: int, heating: bool, method: int, ends: bool):
    """Return the ti.func `layer_step` below, memoised; arguments: as of `layer1d.make_layer`."""
    yield_limit, eliminate, substitute, commit = make_phases(width, stride, heating)
    solve = make_solve(width, stride, sides, method)
    far_at, out_at = far_places(sides)

    @ti.func
    def partition(nodes: ti.template(), rise: ti.template(), base, side_nodes, share, conductance):
        """Return [offset, share] of each side: its heat is offset + share W."""
        if ti.static(sides == 1):
            return [[0.0 * share, share]]
        else:
            even = conductance * (load(rise, base + side_nodes * stride, width) - load(rise, base, width))
            part = 0.5 + 0.5 * conductance * (nodes[side_nodes * NODE + WARMTH] - nodes[WARMTH])
            return [[even, part], [0.0 - even, 1.0 - part]]

    @ti.func
    def beyond(cells: ti.template(), place, zero):
        """Return the temperature beyond a far end, 0 where all are insulated."""
        found = zero
        if ti.static(ends):
            found = load(cells, place, width)
        return found

    @ti.func
    def zone_end(reach, first, end):
        """Return the end of the nodes that may yield in any lane; methods without a bracket need all nodes."""
        found = end
        if ti.static(method == NEWTON):
            found = ti.max(ti.cast(reach.max(), ti.i32), first)
        return found

    @ti.func
    def layer_step(
        nodes: ti.template(), params: ti.template(), settings, rise: ti.template(), growth: ti.template(),
        hardening: ti.template(), carried: ti.template(), cells: ti.template(), scratch: ti.template(), side_nodes,
        all_nodes, base, spare, cell, speed, pressing,
    ):  # fmt: skip
        """Take a step of `width` cells and return their sig; speed [m/s], pressing [Pa]: of the contact.

        settings: [heat share, g, C, dt, 1 where the yield limit may raise sig]; base, spare, cell: addresses of the
        first node of the pack and lane, in `scratch`, and of the numbers of the cells.
        """
        share, conductance, compliance, dt, reload = settings[0], settings[1], settings[2], settings[3], settings[4]
        firsts, lasts = [0, side_nodes], [side_nodes, all_nodes]
        zero = ti.Vector([0.0 for _ in range(width)])
        one = zero + 1.0
        pressed = ti.select(pressing > 0.0, one, zero)
        warm = ti.max(load(cells, cell + WARM * stride, width), pressed)
        sig = zero
        if warm.max() > 0.0:
            mats = [eq.material(params, s, ti.max(pressing, zero)) for s in range(sides)]
            last = load(cells, cell + PRESSURE * stride, width)
            old = load(cells, cell + STRESS * stride, width)
            trial = load(cells, cell + TRIAL * stride, width)
            fresh = ti.select(last > 0.0, zero, pressed)
            # how sig fell as the contact opened says nothing of the steps after it has closed
            change = ti.select(fresh > 0.0, zero, load(cells, cell + CHANGE * stride, width))
            before = ti.select(fresh > 0.0, zero, load(cells, cell + BEFORE * stride, width))
            # a layer that flows is at its limit already
            risen = ti.select(pressing > last, one, 1.0 - load(cells, cell + FLOWED * stride, width))
            restart = ti.max(fresh, pressed * reload * risen)
            if restart.max() > 0.0:
                limit = zero + 1e300
                for s in ti.static(range(sides)):
                    lowest = yield_limit(rise, hardening, base, firsts[s], lasts[s], mats[s])
                    limit = ti.min(limit, lowest)
                limit = ti.select(restart > 0.0, limit, trial)
                trial = ti.select(fresh > 0.0, limit, ti.max(limit, trial))
                old = ti.max(old, trial)
            trial *= pressed
            slip = [
                speed * pressed,
                load(cells, cell + DRAG * stride, width),
                load(cells, cell + CAP * stride, width),
            ]
            far = [beyond(cells, cell + (far_at + s) * stride, zero) for s in range(sides)]
            for s in ti.static(range(sides)):
                eliminate(nodes, rise, carried, base, firsts[s], lasts[s], mats[s], far[s])
            flows = partition(nodes, rise, base, side_nodes, zero + share, pressed * conductance)
            top = eq.generated(trial, slip[0], slip[1], slip[2])[0]
            found = [
                substitute(
                    nodes,
                    rise,
                    hardening,
                    base,
                    firsts[s],
                    lasts[s],
                    mats[s],
                    trial,
                    flows[s][0] + flows[s][1] * top,
                )
                for s in range(sides)
            ]
            room = [(found[s][0] - flows[s][0]) / ti.max(flows[s][1], 1e-300) for s in range(sides)]
            largest, reach = room[0], found[0][1]
            if ti.static(sides == 2):
                largest, reach = ti.min(largest, room[1]), ti.max(reach, found[1][1])
            solving = ti.select(largest > 0.0, ti.select(trial > 0.0, one, zero), zero)
            melt = melting_stress(largest, slip[0], slip[1], slip[2])
            zones = [[firsts[s], zone_end(found[s][1] * solving, firsts[s], lasts[s])] for s in range(sides)]
            sig = solving * trial
            total, shift = zero, zero
            if zone_end(reach * solving, 0, 1) > 0:
                close = load(cells, cell + CLOSE * stride, width)
                guess = old + 2.0 * change - before
                guess = ti.select(close < MELTING, melt * (1.0 - close), guess)
                answer = solve(
                    nodes,
                    [rise, growth, scratch],
                    [base, spare],
                    zones,
                    mats,
                    slip,
                    flows,
                    compliance,
                    [trial, melt, guess, solving],
                )
                shift = answer[4]
                close = ti.select(solving > 0.0, 1.0 - answer[0] / melt, one)
                store(cells, cell + CLOSE * stride, close, width)
                total = ti.select(solving > 0.0, answer[1], zero)
                # the remaining residual lowers sig: the sum of (7) is exact and sig <= Y holds
                sig = ti.min(ti.min(answer[0], old), trial - total / compliance)
                sig = ti.select(solving > 0.0, ti.max(sig, zero), zero)
                failures = load(cells, cell + FAILURES * stride, width) + answer[2]
                store(cells, cell + FAILURES * stride, failures, width)
                count = load(cells, cell + EVALUATIONS * stride, width) + answer[3]
                store(cells, cell + EVALUATIONS * stride, count, width)
            heat = eq.generated(sig, slip[0], slip[1], slip[2])[0]
            for s in ti.static(range(sides)):
                commit(
                    nodes,
                    [rise, growth, hardening, carried, scratch],
                    base,
                    spare,
                    zones[s],
                    lasts[s],
                    mats[s],
                    flows[s][0] + flows[s][1] * heat,
                    solving,
                    sig,
                    shift,
                )
            if ti.static(sides == 2):
                given = load(cells, cell + OTHER * stride, width)
                given += dt * (flows[1][0] + flows[1][1] * heat)
                store(cells, cell + OTHER * stride, given, width)
            if ti.static(ends):
                for s in ti.static(range(sides)):
                    warmer = load(rise, base + (lasts[s] - 1) * stride, width) - far[s]
                    out = load(cells, cell + (out_at + s) * stride, width)
                    out += (dt * params[s * MATERIAL + FAR_END]) * warmer
                    store(cells, cell + (out_at + s) * stride, out, width)
            work = load(cells, cell + WORK * stride, width) + dt * heat
            plastic = load(cells, cell + PLASTIC_WORK * stride, width) + sig * total
            store(cells, cell + STRESS * stride, sig, width)
            store(cells, cell + TRIAL * stride, solving * (trial - total / compliance), width)
            store(cells, cell + CHANGE * stride, sig - old, width)
            store(cells, cell + BEFORE * stride, change, width)
            store(cells, cell + PRESSURE * stride, pressing, width)
            store(cells, cell + FLOWED * stride, ti.select(total > 0.0, one, zero), width)
            store(cells, cell + WARM * stride, warm, width)
            store(cells, cell + WORK * stride, work, width)
            store(cells, cell + PLASTIC_WORK * stride, plastic, width)
        return sig

    return layer_step
