"""Bulk viscosity: an extra pressure q in cells whose volume changes, to spread shocks over a few of them.

    e = V'/V,   q = -rho h (c1 c + c2^2 h max(-e, 0)) e,   f_k = -q dV/dx_k,   dissipation -q V'

with V' from v^{n-1/2}; the step to x^n dissipates -(q^{n-1} + q^n)/2 V' dt, so cells remember their q. rho and h are
those of the present state (h: volume over the largest mid-face area, in tetrahedra the shortest height), c that of the
reference state. The linear part (Landshoff) acts in compression and expansion and takes the ringing, the quadratic one
(von Neumann and Richtmyer, J. Appl. Phys. 21, 232, 1950) only in compression and takes the shock; h keeps both away
from slow deformation. One pressure a cell and the exact dV/dx_k keep linear and angular momentum exact. Each cell also
answers its rate

    2 xi omega = (c1 c + c2^2 h max(-e, 0)) h corners sum over k of |dV/dx_k|^2 / V^2      [1/s]

the eigenvalue of M^-1 C of the cell alone with equal corner masses: a bound for the body (tcontact/stable_step.py).
Where that times the step is above 2, which no stable step allows, q is cut down to it. Cells with a massless corner
have no viscosity: that corner has no velocity, and the static solve sees elastic forces.
"""

import taichi as ti

from . import tensor3
from .cells import hex_corner_forces, hex_modes, tet_corner_forces, tet_derivatives
from .reduced_hex import dot, hex_slopes

FLATTEST = 1e-9  # a cell of less than this share of its reference volume is taken to have it: the guards stop the run


@ti.func
def pressure_rate(change, volume, reference, area, speed, square):
    """[-q/(reference density e), e, rate V^2 / (corners sum |dV/dx_k|^2) over volume^2], h = volume/area."""
    size = ti.max(volume, FLATTEST * reference)
    e = change / size
    h = size / area
    stretch = h * (speed + square * h * ti.max(0.0 - e, 0.0))
    return [(reference / size) * stretch, e, stretch / (size * size)]


@ti.func
def hex_viscosity(x, u, v, speed, square):
    """[corner forces [component][corner], -q, V', rate] of a hex8, q and forces per reference density.

    -q and V' have a common factor out of each other: their product is the power. speed: c1 c, square: c2^2.
    """
    mode_x = [hex_modes(x[c]) for c in range(3)]
    mode_u = [hex_modes(u[c]) for c in range(3)]
    mode_v = [hex_modes(v[c]) for c in range(3)]
    reference = hex_slopes(mode_x)[0]
    now = hex_slopes([[mode_x[c][m] + mode_u[c][m] for m in range(7)] for c in range(3)])
    slopes = now[1]
    change = dot(slopes[0], [mode_v[c][0] for c in range(3)])
    square_sum = dot(slopes[0], slopes[0])
    largest = square_sum
    for m in ti.static(range(1, 6)):
        change += dot(slopes[m], [mode_v[c][m] for c in range(3)])
        length = dot(slopes[m], slopes[m])
        square_sum += length
        if ti.static(m < 3):
            largest = ti.max(largest, length)
    answer = pressure_rate(change, now[0], reference, 4.0 * ti.sqrt(largest), speed, square)
    push = answer[0] * answer[1] * (1.0 / 64.0)
    zero = push * 0.0
    mode_f = [[push * slopes[m][c] for m in range(6)] + [zero] for c in range(3)]
    return [[hex_corner_forces(mode_f[c]) for c in range(3)], push, change, 64.0 * answer[2] * square_sum]


@ti.func
def tet_viscosity(x, u, v, speed, square):
    """The same for a tet4."""
    a = [tet_derivatives(x[c]) for c in range(3)]
    g = [tet_derivatives(u[c]) for c in range(3)]
    w = [tet_derivatives(v[c]) for c in range(3)]
    reference = tensor3.determinant(a, tensor3.cofactor(a))
    now = [[a[c][j] + g[c][j] for j in range(3)] for c in range(3)]
    slopes = tensor3.cofactor(now)  # [component][corner - 1]; the slope of corner 0 is minus their sum
    change = tensor3.dot(slopes, w)
    sums = [slopes[c][0] + slopes[c][1] + slopes[c][2] for c in range(3)]
    largest = dot(sums, sums)
    square_sum = largest
    for j in ti.static(range(3)):
        column = [slopes[c][j] for c in range(3)]
        length = dot(column, column)
        square_sum += length
        largest = ti.max(largest, length)
    answer = pressure_rate(change, tensor3.determinant(now, slopes), reference, ti.sqrt(largest), speed, square)
    push = answer[0] * answer[1] * (1.0 / 6.0)
    force = [tet_corner_forces([push * slopes[c][j] for j in range(3)]) for c in range(3)]
    return [force, push, change, 4.0 * answer[2] * square_sum]


VISCOSITIES = {
    "hex8": hex_viscosity,
    "hex8-affine": hex_viscosity,
    "hex8-reduced": hex_viscosity,
    "hex8-mean-dilatation": hex_viscosity,
    "hex8-mean-dilatation-affine": hex_viscosity,
    "tet4": tet_viscosity,
}
