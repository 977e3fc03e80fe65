"""Secant methods of the paper for a layer step (R of `layer1d_residual`), kept for comparison (METHOD 5).

The unknown is sig, or the softening factor of the surface C_T = exp(f T_s/(T_f - T_s)), from which T_s, then
q = (T_s - Tz_s)/Bq_s and sig follow. Neither has a bracket, so any node may yield during the iteration and all are
evaluated. A lane fails if it leaves 0 < sig < s_melt or does not converge.
"""

import functools

from ..engine import ti
from ..language.transcendental import exponential_less_one, logarithm
from ..language.vectors import load
from .layer1d_residual import ROUNDING, SQRT3, WARMTH, magnitude, make_residual

TOLERANCE = 1e-6  # of |R| over C sig_tr: C_T = 1.0002 at 300 K has lost four digits
MAXIMUM_EVALUATIONS = 50


@functools.cache
def make_secant(width: int, stride: int, by_softening: bool):
    """Return the ti.func `secant` below, memoised; by_softening: the unknown is C_T, else sig."""
    residual = make_residual(width, stride, 1)

    @ti.func
    def secant(nodes: ti.template(), arrays: ti.template(), bases, zones, mats, slip, flows, compliance, bracket):
        """Return [sig, plastic sum, succeeded, evaluations]; bracket: [trial, melt, first, solving].

        The first two stresses are sig_tr and 0.999 of it; with C_T the first is half way to melting if sig_tr melts.
        """
        trial, melt, solving = bracket[0], bracket[1], bracket[3]
        one, zero = 0.0 * trial + 1.0, 0.0 * trial
        mat = mats[0]
        warmth = nodes[WARMTH]
        surface = load(arrays[0], bases[0], width)
        per_stress = flows[0][1] * slip[0] * (warmth / SQRT3)  # rise of the surface per sig
        sig = trial
        unknown = trial
        if ti.static(by_softening):
            start = ti.min(surface + per_stress * trial, 0.5 * (surface + mat[6]))
            unknown = exponential_less_one(mat[4] * (start + mat[9]) / (mat[6] - start)) + 1.0
            sig = (start - surface) / per_stress
        before, before_residual = unknown, one
        running, succeeded, count, total = solving, zero, zero, zero
        turn = 0
        while turn < MAXIMUM_EVALUATIONS and running.max() > 0.0:
            valid = ti.select(sig > 0.0, one, zero) * ti.select(sig < melt, one, zero)
            running *= valid
            found = residual(nodes, arrays, bases, zones, mats, slip, flows, sig)
            count += running
            total = ti.select(running > 0.0, found[0], total)
            value = compliance * (sig - trial) + total
            ready = ti.select(magnitude(value) <= TOLERANCE * compliance * trial, running, zero)
            new = unknown - value * (unknown - before) / (value - before_residual)
            if turn == 0:
                new = unknown * (1.0 - 1e-3)
                if ti.static(by_softening):
                    rise = surface + per_stress * (sig * (1.0 - 1e-3))
                    new = exponential_less_one(mat[4] * (rise + mat[9]) / (mat[6] - rise)) + 1.0
            new_sig = new
            if ti.static(by_softening):
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

    return secant
