"""Bulk viscosity: a viscous pressure q in cells whose volume changes, which spreads shocks over a few cells.

    e = V'/V,   q = -rho h (c1 c + c2^2 h max(-e, 0)) e,   f_k = -q dV/dx_k,   dissipation -q V'

with V' = dV/dx_k . v_k^{n-1/2} at the middle of the step, x = x^n - v dt/2. A rigid step, by any rotation, then has no
V' at all, where the slopes at x^n would see a spin of w as expansion by w^2 dt; for other steps V' dt is the change of
volume to third order. f_k acts along dV/dx_k at x^n: the mean of its slopes at both ends of a step has the same V' in a
rigid one, so what f takes from the motion is what is dissipated. At the start, and in products, no step has ended.
The step to x^n dissipates -(q^{n-1} + q^n)/2 V' dt, so cells store their q. rho, h and V are those
of the present state (h: volume over the largest mid-face area, in tetrahedra the shortest height), c that of the
reference state. The linear part (Landshoff) acts in compression and expansion and damps ringing, the quadratic part
(von Neumann and Richtmyer, J. Appl. Phys. 21, 232, 1950) acts only in compression and damps the shock; the factors h
make both small in slow deformation. One pressure per cell and the exact dV/dx_k keep linear and angular momentum exact.
Each cell also returns its rate

    2 xi omega = (c1 c + c2^2 h max(-e, 0)) h corners sum over k of |dV/dx_k|^2 / V^2      [1/s]

the eigenvalue of M^-1 C of the cell alone with equal corner masses, a bound for the body
(tcontact/schemes/explicit/stable_step.py). Where the rate times the step is above 2, which no stable step allows, q is
reduced so that it is 2. Of elastic laws cells with a massless corner have no viscosity. In those of metals the velocity
of a massless node is the difference of its positions over the step: unknown in the static solve, which takes q into its
forces and its tangent (static/viscous_tangent.py), so q acts on these nodes implicitly. The heat -q V' dt of metals
warms the points of the cell. The volume and its derivatives are those of the element (elements/).
"""

from ..engine import ti

FLATTEST = 1e-9  # smallest ratio of volume to reference volume used here; the host stops runs with such cells


@ti.func
def pressure_rate(change, volume, reference, area, speed, square):
    """Return [-q/(reference density e), e, s, t] with h = volume/area.

    s is the rate over corners sum |dV/dx_k|^2; t: s with the quadratic part twice, for the derivative by V'.
    """
    size = ti.max(volume, FLATTEST * reference)
    e = change / size
    h = size / area
    quadratic = square * h * ti.max(0.0 - e, 0.0)
    stretch = h * (speed + quadratic)
    square_size = size * size
    return [(reference / size) * stretch, e, stretch / square_size, (stretch + h * quadratic) / square_size]
