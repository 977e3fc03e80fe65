"""The one unknown of a friction layer, sig = sqrt3 tau: METHOD 5, equation (7) of Le Tallec, Dambakizi, Hauret (2007).

    R(sig) = C (sig - sig_tr) + sum over nodes w (ep'(sig) - ep) = 0,    C = sum over sides H/(3G)
    ep' = max(ep, ((sig/(Y0 F))^(1/n) - 1)/beta),  F = (1 + a_P P - b_T (T - T_ref)) exp(-f T/(T_f - T))
    T = Tz + Bq q,  q = offset + share W,  W = t (v - drag t),  t = min(sig/sqrt3, cap)

R is increasing and convex below min(sig_tr, s_melt). Safeguarded Newton keeps a bracket; where the plastic sum and the
elastic drop differ by more than a factor of 2 it works on the logarithm of their ratio (next to melting the sum is an
exponential). The secants on sig and on the surface's softening factor C_T are the paper's, without safeguards.
Values are vectors over `width` cells. A material is the list of `material`, a side the list [first node, end of zone].
"""

import functools

import taichi as ti

from .transcendental import exponential_less_one, logarithm

MASK = 0x3FFFFFFF  # tells the compiler that the addresses of neighbouring lanes cannot overflow
WEIGHT, GAIN, LINK, BACK, WARMTH, ROOM = range(6)  # columns of a node: w; elimination; Bq; 1/Bq
NODE = 6
MATERIAL = 12  # numbers per side in params, see `material`
SQRT3 = 1.7320508075688772
TOLERANCE, SECANT_TOLERANCE = 1e-13, 1e-6  # of |R| over C sig_tr; C_T = 1.0002 at 300 K has lost four digits
ROUNDING = 4e-16  # of sig and of the temperature
NEWTON, THERMAL_SOFTENING, STRESS = range(3)  # methods
MOST, MOST_SECANT = 100, 50  # evaluations


@ti.func
def load(array: ti.template(), at, width: ti.template()):
    """Lanes at, at + 1, ... of an array."""
    start = at & MASK
    return ti.Vector([array[start + lane] for lane in range(width)])


@ti.func
def store(array: ti.template(), at, values, width: ti.template()):
    """Write lanes at, at + 1, ... of an array."""
    start = at & MASK
    for lane in ti.static(range(width)):
        array[start + lane] = values[lane]


@ti.func
def magnitude(a):
    """|a| of lanes; vectors that stay whole know neither abs nor a sign change."""
    return ti.max(a, 0.0 - a)


@ti.func
def square_root(a):
    """sqrt(a) of lanes."""
    return ti.Vector([ti.sqrt(a[lane]) for lane in range(a.n)])


@ti.func
def material(params: ti.template(), side: ti.template(), pressure):
    """[Y0, n, beta, b_T, f, T_f, T_f - base, 1 + a_P P - b_T (T - T_ref) at the base temperature, highest rise with strength, base,
    rho c, share of the plastic work that heats]; lanes where the pressure enters."""
    at = side * MATERIAL
    yield_stress, exponent, hardening = params[at], params[at + 1], params[at + 2]
    pressure_factor, softening, sharpness = params[at + 3], params[at + 4], params[at + 5]
    melting, reference, base = params[at + 6], params[at + 7], params[at + 8]
    strength = (1.0 + pressure_factor * pressure) - softening * (base - reference)
    highest = ti.min(strength / ti.max(softening, 1e-300), melting - base)
    return [
        yield_stress,
        exponent,
        hardening,
        softening,
        sharpness,
        melting,
        melting - base,
        strength,
        highest,
        base,
        params[at + 9],
        params[at + 10],
    ]


@ti.func
def generated(sig, velocity, drag, cap):
    """[W, dW/dsig]: heat of slip per area and time [W/m^2] from the transmitted traction, and its slope."""
    traction = ti.min(sig / SQRT3, cap)
    slope = ti.select(sig < SQRT3 * cap, (velocity - 2.0 * drag * traction) / SQRT3, 0.0 * sig)
    return [traction * (velocity - drag * traction), slope]


@functools.cache
def make_residual(width: int, stride: int):
    """Plastic sums of one side; memoised ti.func."""

    @ti.func
    def plastic_sums(nodes: ti.template(), arrays: ti.template(), base, scratch_base, side, mat, sig, heat):
        """[sum w (ep' - ep), its slope in sig, what rounding T does to it] over the nodes of a zone.

        ln(1 + beta ep') and beta ep' go to scratch.

        heat: [q, dq/dsig] of the side. arrays: [rise, growth, scratch].
        """
        over_yield, over_exponent = sig / mat[0], 1.0 / mat[1]
        over_sig, steep = 1.0 / ti.max(sig, 1e-300), mat[4] * mat[5]
        total, slope, steepness = 0.0 * sig, 0.0 * sig, 0.0 * sig
        for n in range(side[0], side[1]):
            at = base + n * stride
            warmth, weight = nodes[n * NODE + WARMTH], nodes[n * NODE + WEIGHT]
            temperature = load(arrays[0], at, width) + warmth * heat[0]
            soft, room = mat[7] - mat[3] * temperature, mat[6] - temperature
            inverse = 1.0 / (soft * room)
            over_soft, over_room = inverse * room, inverse * soft
            absolute = temperature + mat[9]
            strain = (logarithm(over_yield * over_soft) + mat[4] * absolute * over_room) * over_exponent
            grown = exponential_less_one(strain)
            extra = grown - load(arrays[1], at, width)
            flows = extra > 0.0
            by_heat = mat[3] * over_soft + steep * over_room * over_room
            stretch = ti.select(flows, weight * (grown + 1.0), 0.0 * sig)
            total += ti.select(flows, weight * extra, 0.0 * sig)
            slope += stretch * (over_sig + by_heat * (warmth * heat[1]))
            steepness += stretch * (by_heat * absolute)
            here = scratch_base + 2 * n * stride
            store(arrays[2], here, strain, width)
            store(arrays[2], here + stride, grown, width)
        scale = over_exponent / mat[2]
        return [total / mat[2], slope * scale, steepness * (ROUNDING * scale)]

    return plastic_sums


@functools.cache
def make_solve(width: int, stride: int, sides: int, method: int):
    """The solve of a step, memoised ti.func; see `solve` inside."""
    plastic_sums = make_residual(width, stride)

    @ti.func
    def residual(nodes: ti.template(), arrays: ti.template(), bases, zones, mats, slip, flows, sig):
        """[plastic sum, slope, rounding]; slip: [velocity, drag, cap], flows: per side [offset, share]."""
        heat = generated(sig, slip[0], slip[1], slip[2])
        found = [
            plastic_sums(
                nodes,
                arrays,
                bases[0],
                bases[1],
                zones[s],
                mats[s],
                sig,
                [flows[s][0] + flows[s][1] * heat[0], flows[s][1] * heat[1]],
            )
            for s in range(sides)
        ]
        total, slope, rounding = found[0][0], found[0][1], found[0][2]
        if ti.static(sides == 2):
            total += found[1][0]
            slope += found[1][1]
            rounding += found[1][2]
        return [total, slope, rounding]

    @ti.func
    def secant(nodes: ti.template(), arrays: ti.template(), bases, zones, mats, slip, flows, compliance, bracket):
        """[sig, plastic sum, succeeded, evaluations] of the paper's secants; bracket: [trial, melt, first, solving].

        A lane fails that leaves the temperatures below melting, or does not end within MOST_SECANT evaluations.
        """
        trial, melt, solving = bracket[0], bracket[1], bracket[3]
        one, zero = 0.0 * trial + 1.0, 0.0 * trial
        mat = mats[0]
        warmth = nodes[WARMTH]
        surface = load(arrays[0], bases[0], width)
        per_stress = flows[0][1] * slip[0] * (warmth / SQRT3)  # rise of the surface per sig
        sig = trial
        unknown = trial
        if ti.static(method == THERMAL_SOFTENING):
            start = ti.min(surface + per_stress * trial, 0.5 * (surface + mat[6]))
            unknown = exponential_less_one(mat[4] * (start + mat[9]) / (mat[6] - start)) + 1.0
            sig = (start - surface) / per_stress
        before, before_residual = unknown, one
        after_first = zero
        running, succeeded, count, total = solving, zero, zero, zero
        turn = 0
        while turn < MOST_SECANT and running.max() > 0.0:
            valid = ti.select(sig > 0.0, one, zero) * ti.select(sig < melt, one, zero)
            running *= valid
            found = residual(nodes, arrays, bases, zones, mats, slip, flows, sig)
            count += running
            total = ti.select(running > 0.0, found[0], total)
            value = compliance * (sig - trial) + total
            ready = ti.select(magnitude(value) <= SECANT_TOLERANCE * compliance * trial, running, zero)
            new = unknown - value * (unknown - before) / (value - before_residual)
            if turn == 0:
                new = unknown * (1.0 - 1e-3)
                if ti.static(method == THERMAL_SOFTENING):
                    near = surface + per_stress * (sig * (1.0 - 1e-3))
                    new = exponential_less_one(mat[4] * (near + mat[9]) / (mat[6] - near)) + 1.0
            new_sig = new
            if ti.static(method == THERMAL_SOFTENING):
                power = logarithm(new)
                new_sig = (mat[5] * power / (mat[4] + power) - mat[9] - surface) / per_stress
            stalled = ti.select(magnitude(new_sig - sig) <= ROUNDING * sig, running, zero)
            small = ti.select(magnitude(value) <= 1e-6 * compliance * trial, one, zero)
            ready = ti.max(ready, stalled * small)
            succeeded += ready
            running = running - ready
            going = running > 0.0
            before, before_residual = ti.select(going, unknown, before), ti.select(going, value, before_residual)
            unknown, sig = ti.select(going, new, unknown), ti.select(going, new_sig, sig)
            turn += 1
        return [sig, total, succeeded, count]

    @ti.func
    def solve(nodes: ti.template(), arrays: ti.template(), bases, zones, mats, slip, flows, compliance, bracket):
        """[sig, plastic sum, failures, evaluations]; scratch holds the strains at the sig that is returned.

        arrays: [rise with Tz, growth, scratch]; bases: addresses [first node of the pack, scratch];
        zones: per side [first, end] of the nodes that may yield; slip: [velocity, drag, cap]; flows: per side [offset,
        share]; bracket: [sig_tr, s_melt, first guess, 1 where sig is wanted].
        """
        trial, melt, solving = bracket[0], bracket[1], bracket[3]
        one, zero = 0.0 * trial + 1.0, 0.0 * trial
        low, high = zero, ti.min(trial, melt)
        sig = ti.max(ti.min(bracket[2], high), 1e-3 * high)
        sig = ti.select(sig < melt, sig, 0.999 * melt)
        sig = ti.select(solving > 0.0, sig, zero)
        running, count, total, failed = solving, zero, zero, zero
        if ti.static(method != NEWTON):
            tried = secant(nodes, arrays, bases, zones, mats, slip, flows, compliance, bracket)
            running = solving * (1.0 - tried[2])
            failed = running
            sig = ti.select(tried[2] > 0.0, tried[0], sig)
            total = ti.select(tried[2] > 0.0, tried[1], zero)
            count = tried[3]
        turn = 0
        while turn < MOST and running.max() > 0.0:
            found = residual(nodes, arrays, bases, zones, mats, slip, flows, sig)
            count += running
            total = ti.select(running > 0.0, found[0], total)
            drop = compliance * (trial - sig)
            value = total - drop
            low, high = ti.select(value < 0.0, sig, low), ti.select(value > 0.0, sig, high)
            new = sig - value / (found[1] + compliance)
            far = ti.min(total, drop) * 2.0 < ti.max(total, drop)
            steep = found[1] / ti.max(total, 1e-300) + compliance / ti.max(drop, 1e-300)
            by_ratio = sig - logarithm(ti.max(total, 1e-300) / ti.max(drop, 1e-300)) / steep
            new = ti.select(far, ti.select(ti.min(total, drop) > 0.0, by_ratio, new), new)
            finest = TOLERANCE * compliance * trial + found[2]
            within = ti.select(magnitude(value) <= finest, running, zero)
            # the last sig is on the side where the plastic sum is enough: what is left over lowers sig, never raises it
            enough = ti.select(value >= 0.0 - TOLERANCE * compliance * trial, one, zero)
            settled = within * enough
            small = ti.select(magnitude(value) <= 1e-6 * compliance * trial, one, zero)
            # a bracketed step: the trial stress itself is a candidate, the melting bound never is
            middle = 0.5 * (low + high)
            middle = ti.select(low > 0.0, middle, 0.5 * high)
            new = ti.select(new > low, new, middle)
            new = ti.select(new < high, new, ti.select(high < trial, middle, ti.select(value < 0.0, high, middle)))
            if turn > 12 and turn % 2 == 0:
                new = middle
            up = sig + 2.0 * finest / (found[1] + compliance)
            up = ti.select(up < high, up, ti.select(high < melt, high, middle))
            new = ti.select(within > enough, up, new)
            stalled = ti.select(magnitude(new - sig) <= ROUNDING * sig, running * small, zero)
            running = running - ti.max(settled, stalled)
            sig = ti.select(running > 0.0, new, sig)
            turn += 1
        if ti.static(method == NEWTON):
            failed = running
        return [sig, total, failed, count]

    return solve
