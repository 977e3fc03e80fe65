"""Node phase of the force pass: sum the force of every node, then kick and drift the ordinary nodes.

    a = g - f/m,   v_n = v + kick_before a,   v <- v_n + kick_after a,   u <- u + drift v

Each node sums its force rows in the order of the chunks and clears them for the next step. A boundary node also adds
the corner forces of its contact cells, rows corner_rows[s] .. corner_rows[s + 1] of the same array; its force is stored
in special_force [3*s+c], and it is not moved here. With params[FREE] = 1 (products) all nodes are ordinary ones.
`node_sums` [ranges, NODE_SUMS] (columns.py) are those of the moved nodes, with u before the drift and v_n.
"""

from ..columns import NODE_SUMS, NODES
from ..engine import ti
from ..lanes import CHUNK_BITS, CHUNK_MASK, DRIFT, FREE, GRAVITY, KICK_AFTER, KICK_BEFORE
from .damping import damped_acceleration


@ti.func
def node_phase(
    body: ti.template(),
    ranges,
    kinds: ti.template(),
    stride: ti.template(),
    damped: ti.template(),
    cornered: ti.template(),
):
    """Sum and clear the force rows of every node, then move it if it is an ordinary one.

    stride: iterations of the outer loop per node range; kinds: number of kinds of cells in chunk_table (cell_phase.py);
    damped: name of the damping law (damping.py), "" without; cornered: with contact cells.
    """
    for s in range(ranges * stride):
        if s % stride == 0:
            part = s // stride
            nodes = body.node_info.shape[0]
            kick_before, kick_after, drift = body.params[KICK_BEFORE], body.params[KICK_AFTER], body.params[DRIFT]
            gravity = [body.params[GRAVITY + c] for c in range(3)]
            free = body.params[FREE] == 1.0
            kinetic = 0.0
            momentum = [0.0, 0.0, 0.0]
            spin = [0.0, 0.0, 0.0]
            moved = [0.0, 0.0, 0.0]
            for i in range(part * nodes // ranges, (part + 1) * nodes // ranges):
                info = body.node_info[i]
                force = [0.0, 0.0, 0.0]
                for c in range(info & CHUNK_MASK, ((info >> CHUNK_BITS) & CHUNK_MASK) + 1):
                    row = 3 * (body.chunk_table[c * (kinds + 3) + kinds + 1] + i)
                    for d in ti.static(range(3)):
                        force[d] += body.rows[row + d]
                        body.rows[row + d] = 0.0
                boundary = (info >> (2 * CHUNK_BITS)) - 1
                if ti.static(cornered):
                    if boundary >= 0:
                        for place in range(body.corner_rows[boundary], body.corner_rows[boundary + 1]):
                            row = 3 * body.corner_rows[place]
                            for d in ti.static(range(3)):
                                force[d] += body.rows[row + d]
                if boundary >= 0 and not free:
                    for d in ti.static(range(3)):
                        body.special_force[3 * boundary + d] = force[d]
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
