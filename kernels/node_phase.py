"""What follows the force pass at the ordinary nodes: their force, kick and drift.

    a = g - f/m,   v_n = v + kick_before a,   v <- v_n + kick_after a,   u <- u + drift v

Each node sums its chunk rows in chunk order, clears them for the next step and moves. Special nodes hand out f in
special_force [3*s+c] and are not moved.
`node_sums` [chunks, NODE_SUMS] (columns.py): of the ordinary nodes only, at u before the drift and v_n.
"""

import taichi as ti

from .columns import NODE_SUMS, NODES
from .damping import damped_acceleration
from .lanes import TABLE


@ti.func
def node_phase(body: ti.template(), ranges, stride: ti.template(), damped: ti.template()):
    """Sum and clear the force rows of every node, then move it; stride: iterations of the outer loop per node range.

    damped: name of the law of damping (damping.py), "" without.
    """
    for s in range(ranges * stride):
        if s % stride == 0:
            part = s // stride
            nodes = body.node_info.shape[0]
            kick_before, kick_after, drift = body.params[0], body.params[1], body.params[2]
            gravity = [body.params[3], body.params[4], body.params[5]]
            kinetic = 0.0
            momentum = [0.0, 0.0, 0.0]
            spin = [0.0, 0.0, 0.0]
            moved = [0.0, 0.0, 0.0]
            for i in range(part * nodes // ranges, (part + 1) * nodes // ranges):
                info = body.node_info[i]
                force = [0.0, 0.0, 0.0]
                for c in range(info & 15, ((info >> 4) & 15) + 1):
                    row = 3 * (body.chunk_table[c * TABLE + 2] + i)
                    for d in ti.static(range(3)):
                        force[d] += body.rows[row + d]
                        body.rows[row + d] = 0.0
                if info >= 256:
                    for d in ti.static(range(3)):
                        body.special_force[3 * ((info >> 8) - 1) + d] = force[d]
                else:
                    m = body.mass[i]
                    inverse = 1.0 / m
                    p = [0.0, 0.0, 0.0]
                    x = [0.0, 0.0, 0.0]
                    for d in ti.static(range(3)):
                        acceleration = gravity[d] - force[d] * inverse
                        old = body.v[3 * i + d]
                        acceleration = damped_acceleration(damped, body, acceleration, old)
                        middle = old + kick_before * acceleration
                        new = old + (kick_before + kick_after) * acceleration
                        here = body.u[3 * i + d]
                        body.v[3 * i + d] = new
                        body.u[3 * i + d] = ti.select(drift == 0.0, here, here + drift * new)
                        p[d] = m * middle
                        x[d] = body.position[3 * i + d] + here
                        kinetic += 0.5 * p[d] * middle
                        momentum[d] += p[d]
                        moved[d] += m * here
                    spin[0] += x[1] * p[2] - x[2] * p[1]
                    spin[1] += x[2] * p[0] - x[0] * p[2]
                    spin[2] += x[0] * p[1] - x[1] * p[0]
            body.node_sums[part * NODE_SUMS + NODES.kinetic] = kinetic
            for d in ti.static(range(3)):
                body.node_sums[part * NODE_SUMS + NODES.momentum + d] = momentum[d]
                body.node_sums[part * NODE_SUMS + NODES.angular_momentum + d] = spin[d]
                body.node_sums[part * NODE_SUMS + NODES.mass_displacement + d] = moved[d]
