"""Root search for the one unknown of a layer step, sig = sqrt3 tau, in a bracket (METHOD 5, R of `layer1d_residual`).

R is increasing and convex below min(sig_tr, s_melt). Safeguarded Newton keeps a bracket. Where the plastic sum and the
elastic drop differ by more than a factor of 2, it solves for the logarithm of their ratio, since close to melting the
sum grows exponentially. The other methods try the secants of the paper first (`layer1d_secant`).
"""

import functools

from ..engine import ti
from ..language.transcendental import logarithm
from .layer1d_residual import ROUNDING, SMALL, magnitude, make_residual
from .layer1d_secant import make_secant

NEWTON, THERMAL_SOFTENING, STRESS = range(3)  # methods
TOLERANCE = 1e-13  # of |R| over C sig_tr
MAXIMUM_EVALUATIONS = 100


@functools.cache
def make_solve(width: int, stride: int, sides: int, method: int):
    """Return the ti.func `solve` below, memoised."""
    residual = make_residual(width, stride, sides)
    secant = make_secant(width, stride, method == THERMAL_SOFTENING)

    @ti.func
    def solve(nodes: ti.template(), arrays: ti.template(), bases, zones, mats, slip, flows, compliance, bracket):
        """Return [sig, plastic sum, failures, evaluations, shift]; scratch holds the strains at sig - shift.

        arrays: [rise with Tz, growth, scratch]; bases: addresses [first node of the pack, scratch];
        zones: per side [first, end] of the nodes that may yield; slip: [velocity, drag, cap]; flows: per side [offset,
        share]; bracket: [sig_tr, s_melt, first guess, 1 in lanes to solve].
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
        turn, shift = 0, zero
        while turn < MAXIMUM_EVALUATIONS and running.max() > 0.0:
            found = residual(nodes, arrays, bases, zones, mats, slip, flows, sig)
            count += running
            total = ti.select(running > 0.0, found[0], total)
            drop = compliance * (trial - sig)
            value = total - drop
            low, high = ti.select(value < 0.0, sig, low), ti.select(value > 0.0, sig, high)
            step = (0.0 - value) / (found[1] + compliance)
            new = sig + step
            far = ti.min(total, drop) * 2.0 < ti.max(total, drop)
            steep = found[1] / ti.max(total, 1e-300) + compliance / ti.max(drop, 1e-300)
            by_ratio = sig - logarithm(ti.max(total, 1e-300) / ti.max(drop, 1e-300)) / steep
            new = ti.select(far, ti.select(ti.min(total, drop) > 0.0, by_ratio, new), new)
            finest = TOLERANCE * compliance * trial + found[2]
            within = ti.select(magnitude(value) <= finest, running, zero)
            # the last sig is where the plastic sum is large enough: the remaining residual lowers sig, never raises it
            enough = ti.select(value >= 0.0 - TOLERANCE * compliance * trial, one, zero)
            settled = within * enough
            small = ti.select(magnitude(value) <= 1e-6 * compliance * trial, one, zero)
            # a step outside the bracket is replaced; the trial stress itself is allowed, the melting bound is not
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
            # a last step so small that the strains change linearly needs no evaluation
            linear = ti.select(found[3] * magnitude(step) <= SMALL, ti.select(found[4] > 0.0, running, zero), zero)
            linear = linear * (1.0 - ti.max(settled, stalled))
            shift = ti.select(linear > 0.0, step, shift)
            total = ti.select(linear > 0.0, found[0] + found[1] * step, total)
            running = running - ti.max(ti.max(settled, stalled), linear)
            sig = ti.select(running > 0.0, new, sig)
            turn += 1
        if ti.static(method == NEWTON):
            failed = running
        return [sig + shift, total, failed, count, shift]

    return solve
