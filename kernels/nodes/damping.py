"""Mass-proportional damping f = -rate M v in the leapfrog, with the velocity v^n of the time level.

    v^n = v^{n-1/2} + k0 a,  v^{n+1/2} = v^n + k1 a,  M a = r - rate M v^n
    a = M^+ (r - rate M v^{n-1/2})/(1 + rate k0)

(central: with k0 = k1 = dt/2 it is v^{n+1/2} = [(1 - rate dt/2) v^{n-1/2} + dt M^-1 r]/(1 + rate dt/2), and the stable
step stays what it is; Belytschko, Liu and Moran, Nonlinear Finite Elements, ch. 6.)
Massless components have no damping. A damping law has a name (tcontact/scene/dissipation.py), known at compile time
("" for none), and a branch in each of these functions.
"""

from ..engine import ti
from ..lanes import DAMPING, KICK_BEFORE


@ti.func
def damped_acceleration(law: ti.template(), body: ti.template(), undamped, old):
    """Return a component of the acceleration of an ordinary node; undamped: without damping, old: its velocity."""
    acceleration = undamped
    if ti.static(law == "mass-damping"):
        rate = body.params[DAMPING]
        acceleration = (undamped - rate * old) / (1.0 + rate * body.params[KICK_BEFORE])
    return acceleration


@ti.func
def damped_response(law: ti.template(), body: ti.template(), mass, velocity, force, flexible):
    """Return force and acceleration by a unit force [3, 3] of a boundary node, from those without damping."""
    net, response = force, flexible
    if ti.static(law == "mass-damping"):
        rate = body.params[DAMPING]
        net = force - rate * (mass @ velocity)
        response = flexible / (1.0 + rate * body.params[KICK_BEFORE])
    return net, response


@ti.func
def damping_force(law: ti.template(), body: ti.template(), mass, inverse, velocity, net):
    """Return the damping force on a boundary node at v^n; velocity: before the kick, net: force without damping."""
    force = ti.Vector.zero(ti.f64, 3)
    if ti.static(law == "mass-damping"):
        rate, kick_before = body.params[DAMPING], body.params[KICK_BEFORE]
        rest = net - rate * (mass @ velocity)
        middle = velocity + kick_before / (1.0 + rate * kick_before) * (inverse @ rest)
        force = rate * (mass @ middle)
    return force
