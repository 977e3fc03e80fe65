"""Passes over the nodes of one side of a friction layer: yield limit, elimination, substitution, new state (METHOD 5).

    rho c w dT_i/dt = conduction between neighbours + w s_i (+ q at the surface),  backward Euler, w: nodal width

The tridiagonal matrix depends on grid, step and material only: T' = Tz + Bq q, with one elimination from the depth to
the surface and one substitution back per step. Node columns are weight, gain, link, back, Bq, 1/Bq:

    d_i = gain_i T_i + link_i d_{i+1},    Tz_i = d_i + back_i Tz_{i-1},    d beyond the far end: its temperature

`base` is the address of the first node of the pack and lane, mat the list of `layer1d_residual.material`.
"""

import functools

from ..engine import ti
from ..language.transcendental import exponential_less_one
from ..language.vectors import load, store
from .layer1d_residual import BACK, GAIN, LINK, NODE, ROOM, SCRATCH, WARMTH

SPARE = 2.0  # released plastic heat takes up to 1/SPARE of the temperature distance to melting in a step


@functools.cache
def make_phases(width: int, stride: int, heating: bool):
    """Return the passes over the nodes of one side as ti.funcs: yield_limit, eliminate, substitute, commit."""

    @ti.func
    def yield_limit(rise: ti.template(), hardening: ti.template(), base, first, end, mat):
        """Return the smallest yield stress over the depth."""
        limit = 0.0 * mat[7] + 1e300
        for n in range(first, end):
            at = base + n * stride
            temperature = load(rise, at, width)
            room = ti.max(mat[6] - temperature, 1e-300)
            factor = exponential_less_one(-mat[4] * (temperature + mat[9]) / room) + 1.0
            strength = mat[0] * load(hardening, at, width) * (mat[7] - mat[3] * temperature) * factor
            limit = ti.min(limit, ti.select(temperature < mat[8], strength, 0.0 * limit))
        return limit

    @ti.func
    def eliminate(nodes: ti.template(), rise: ti.template(), carried: ti.template(), base, first, end, mat, far):
        """Eliminate from the depth to the surface: rise becomes d; carried heat is released as melting allows.

        far: temperature beyond the far end, which counts if that is open.
        """
        before = far
        for k in range(end - first):
            n = end - 1 - k
            at = base + n * stride
            temperature = load(rise, at, width)
            if ti.static(heating):
                energy = load(carried, at, width)
                spare = ti.max(mat[8] - temperature, 0.0 * temperature) * (mat[10] / SPARE)
                released = ti.min(energy, spare)
                store(carried, at, energy - released, width)
                temperature += released / mat[10]
            before = nodes[n * NODE + GAIN] * temperature + nodes[n * NODE + LINK] * before
            store(rise, at, before, width)

    @ti.func
    def substitute(nodes: ti.template(), rise: ti.template(), hardening: ti.template(), base, first, end, mat, top, q):
        """Substitute from the surface to the depth: rise becomes Tz.

        Returns [heat flux through the surface that melts a node, end of the zone that may yield]. A node may yield if
        it does so at the stress `top` and its heat q, judged with exp(-x) >= 1 - x.
        """
        before = 0.0 * mat[7]
        melting, zone = before + 1e300, before
        sharper = 1.0 + mat[4]
        for n in range(first, end):
            at = base + n * stride
            before = load(rise, at, width) + nodes[n * NODE + BACK] * before
            store(rise, at, before, width)
            melting = ti.min(melting, (mat[8] - before) * nodes[n * NODE + ROOM])
            hot = before + nodes[n * NODE + WARMTH] * q
            room = mat[6] - hot
            strength = mat[0] * load(hardening, at, width) * (mat[7] - mat[3] * hot)
            bound = strength * (mat[6] - mat[4] * mat[9] - sharper * hot)
            zone = ti.select(top * room > bound, 0.0 * zone + (n + 1.0), zone)
            zone = ti.select(hot >= mat[8], 0.0 * zone + (n + 1.0), zone)
        return [melting, zone]

    @ti.func
    def commit(nodes: ti.template(), state: ti.template(), base, scratch_base, side, end, mat, q, flowing, sig, shift):
        """Set the new state: rise becomes T', and strains in the scratch array that have grown become the strains.

        state: [rise, growth, hardening, carried, scratch]; side: [first, end of the zone]; shift: sig less the stress
        at which the strains in the scratch array were computed.
        """
        for n in range(side[0], end):
            at = base + n * stride
            store(state[0], at, load(state[0], at, width) + nodes[n * NODE + WARMTH] * q, width)
        for n in range(side[0], side[1]):
            at = base + n * stride
            here = scratch_base + SCRATCH * n * stride
            more_strain = load(state[4], here + 2 * stride, width) * shift
            strain, grown = load(state[4], here, width) + more_strain, load(state[4], here + stride, width)
            grown += (grown + 1.0) * more_strain
            old, hard = load(state[1], at, width), load(state[2], at, width)
            new = ti.select(grown > old, ti.select(flowing > 0.0, grown, old), old)
            harder = exponential_less_one(mat[1] * strain) + 1.0
            store(state[1], at, new, width)
            store(state[2], at, ti.select(new > old, harder, hard), width)
            if ti.static(heating):
                more = load(state[3], at, width) + (mat[11] * sig) * ((new - old) / mat[2])
                store(state[3], at, more, width)

    return yield_limit, eliminate, substitute, commit
