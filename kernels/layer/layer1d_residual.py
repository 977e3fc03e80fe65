"""Plastic sum in the equation for sig = sqrt3 tau of a friction layer (METHOD 5, equation (7) of the paper).

    R(sig) = C (sig - sig_tr) + sum over nodes w (ep'(sig) - ep),    C = sum over sides H/(3G)
    ep' = max(ep, ((sig/(Y0 F))^(1/n) - 1)/beta),   F = (1 + a_P P - b_T (T - T_ref)) exp(-f T/(T_f - T))
    T = Tz + Bq q,   q = offset + share W,   W = t (v - drag t),   t = min(sig/sqrt3, cap)

Values are vectors over `width` cells. A material is the list of `material`, a side the list [first node, end of zone].
"""

import functools

from ..engine import ti
from ..language.transcendental import exponential_less_one, logarithm
from ..language.vectors import load, store

WEIGHT, GAIN, LINK, BACK, WARMTH, ROOM = range(6)  # columns of a node: w; elimination; Bq; 1/Bq
NODE = 6
MATERIAL = 12  # numbers per side in params, see `material`
FAR_END = 11  # of them the conductance of the far end [W/(m^2 K)]
SQRT3 = 1.7320508075688772
SCRATCH = 3  # numbers per node and lane that an evaluation stores
SMALL = 1e-7  # change of ln(1 + beta ep) whose square is negligible
ROUNDING = 4e-16  # relative rounding error of sig and of the temperature


@ti.func
def magnitude(a):
    """Return |a| of lanes; for vectors kept whole neither abs nor unary minus compiles."""
    return ti.max(a, 0.0 - a)


@ti.func
def square_root(a):
    """Return sqrt(a) of lanes."""
    return ti.Vector([ti.sqrt(a[lane]) for lane in range(a.n)])


@ti.func
def material(params: ti.template(), side: ti.template(), pressure):
    """Return the constants of a side, as lanes where the pressure enters.

    [Y0, n, beta, b_T, f, T_f, T_f - base, 1 + a_P P - b_T (T - T_ref) at the base temperature, largest rise with
    strength, base, rho c, share of the plastic work that heats]
    """
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
    """Return [W, dW/dsig]: heat of slip per area and time [W/m^2] from the transmitted traction, and its derivative."""
    traction = ti.min(sig / SQRT3, cap)
    slope = ti.select(sig < SQRT3 * cap, (velocity - 2.0 * drag * traction) / SQRT3, 0.0 * sig)
    return [traction * (velocity - drag * traction), slope]


@functools.cache
def make_residual(width: int, stride: int, sides: int):
    """Return the ti.func `residual` below, memoised."""

    @ti.func
    def plastic_sums(nodes: ti.template(), arrays: ti.template(), base, scratch_base, side, mat, sig, heat):
        """Return sums over the nodes of a zone: [sum w (ep' - ep), derivative by sig, rounding error, fastest, margin].

        The rounding error is that by T; fastest: largest derivative of l = ln(1 + beta ep') by sig; margin > 0: no node
        is closer than SMALL to the onset of flow. l, beta ep' and dl/dsig are stored in scratch. heat: [q, dq/dsig] of
        the side; arrays: [rise, growth, scratch].
        """
        over_yield, over_exponent = sig / mat[0], 1.0 / mat[1]
        over_sig, steep = 1.0 / ti.max(sig, 1e-300), mat[4] * mat[5]
        total, slope, steepness = 0.0 * sig, 0.0 * sig, 0.0 * sig
        fastest, margin = 0.0 * sig, 0.0 * sig + 1.0
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
            rate = over_exponent * (over_sig + by_heat * (warmth * heat[1]))
            stretch = ti.select(flows, weight * (grown + 1.0), 0.0 * sig)
            fastest = ti.max(fastest, rate)
            margin = ti.min(margin, magnitude(extra) - SMALL * (grown + 1.0))
            total += ti.select(flows, weight * extra, 0.0 * sig)
            slope += stretch * rate
            steepness += stretch * (by_heat * absolute)
            here = scratch_base + SCRATCH * n * stride
            store(arrays[2], here, strain, width)
            store(arrays[2], here + stride, grown, width)
            store(arrays[2], here + 2 * stride, rate, width)
        return [total / mat[2], slope / mat[2], steepness * (ROUNDING * over_exponent / mat[2]), fastest, margin]

    @ti.func
    def residual(nodes: ti.template(), arrays: ti.template(), bases, zones, mats, slip, flows, sig):
        """Return these sums over all sides; slip: [velocity, drag, cap], flows: [offset, share] per side."""
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
        fastest, margin = found[0][3], found[0][4]
        if ti.static(sides == 2):
            total += found[1][0]
            slope += found[1][1]
            rounding += found[1][2]
            fastest, margin = ti.max(fastest, found[1][3]), ti.min(margin, found[1][4])
        return [total, slope, rounding, fastest, margin]

    return residual
