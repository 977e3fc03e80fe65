"""Bulk viscosity: an extra pressure q in cells whose volume changes, to spread shocks over a few of them.

    e = V'/V,   q = -rho h (c1 c + c2^2 h max(-e, 0)) e,   f_k = -q dV/dx_k,   dissipation -q V'

with V' from v^{n-1/2}; the step to x^n dissipates -(q^{n-1} + q^n)/2 V' dt, so cells remember their q. rho and h are
those of the present state (h: volume over the largest mid-face area, in tetrahedra the shortest height), c that of the
reference state. The linear part (Landshoff) acts in compression and expansion and takes the ringing, the quadratic one
(von Neumann and Richtmyer, J. Appl. Phys. 21, 232, 1950) only in compression and takes the shock; h keeps both away
from slow deformation. One pressure a cell and the exact dV/dx_k keep linear and angular momentum exact. Each cell also
answers its rate

    2 xi omega = (c1 c + c2^2 h max(-e, 0)) h corners sum over k of |dV/dx_k|^2 / V^2      [1/s]

the eigenvalue of M^-1 C of the cell alone with equal corner masses: a bound for the body
(tcontact/schemes/explicit/stable_step.py).
Where that times the step is above 2, which no stable step allows, q is cut down to it. Cells with a massless corner
have no viscosity: that corner has no velocity, and the static solve sees elastic forces. The volume and its slopes are
those of the element (elements/).
"""

import taichi as ti

FLATTEST = 1e-9  # a cell of less than this share of its reference volume is taken to have it: the guards stop the run


@ti.func
def pressure_rate(change, volume, reference, area, speed, square):
    """[-q/(reference density e), e, rate V^2 / (corners sum |dV/dx_k|^2) over volume^2], h = volume/area."""
    size = ti.max(volume, FLATTEST * reference)
    e = change / size
    h = size / area
    stretch = h * (speed + square * h * ti.max(0.0 - e, 0.0))
    return [(reference / size) * stretch, e, stretch / (size * size)]
