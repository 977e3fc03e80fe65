"""Mass-proportional damping f = -rate M v, exact in the leapfrog: the velocity it acts on is that of the row.

    v^n = v^{n-1/2} + k0 a,  v^{n+1/2} = v^n + k1 a,  M a = r - rate M v^n
    a = M^+ (r - rate M v^{n-1/2})/(1 + rate k0)

(central: with k0 = k1 = dt/2 it is v^{n+1/2} = [(1 - rate dt/2) v^{n-1/2} + dt M^-1 r]/(1 + rate dt/2), and the stable
step stays what it is; Belytschko, Liu and Moran, Nonlinear Finite Elements, ch. 6.)
What has no mass has no damping. Ordinary nodes: `node_phase`.
"""

import taichi as ti

from .boundary_nodes import row, symmetric
from .lanes import DAMPING_RATE


@ti.func
def damp(body: ti.template(), listed: ti.template()):
    """special_force += rate M v^n of the boundary nodes; supports and the kick that follow take it like any force."""
    rate, kick_before = body.params[DAMPING_RATE], body.params[0]
    for s in range(listed.nodes.shape[0]):
        mass = symmetric(listed.mass, s)
        old = row(body.v, listed.nodes[s])
        net = row(listed.load, s) - row(body.special_force, s) - rate * (mass @ old)
        middle = old + kick_before / (1.0 + rate * kick_before) * (symmetric(listed.inverse_mass, s) @ net)
        force = rate * (mass @ middle)
        for j in ti.static(range(3)):
            body.special_force[3 * s + j] = body.special_force[3 * s + j] + force[j]
