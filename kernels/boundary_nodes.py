"""Kick and drift of the nodes that are not ordinary: tensor mass, supports, contact (METHOD 1 and 2).

    a = M^+ (f_ext - f),  v^n = v^{n-1/2} + k0 a,  v^{n+1/2} = v^n + k1 a,  x^{n+1} = x^n + dt v^{n+1/2}

M^+ is zero in prescribed and massless components: prescribed ones keep their velocity, massless ones stay at rest here
and are placed by the static solve. `force` is the internal force less the contact force. The list is short: one thread.
"""

import taichi as ti

from .arguments import ARRAY, INDEX

SUMS = 8  # kinetic energy, momentum (3), angular momentum (3), work of the loads


@ti.func
def symmetric(tensors: ti.template(), s):
    """Row s of flat symmetric tensors (xx, yy, zz, xy, yz, xz) as a matrix."""
    xx, yy, zz = tensors[6 * s], tensors[6 * s + 1], tensors[6 * s + 2]
    xy, yz, xz = tensors[6 * s + 3], tensors[6 * s + 4], tensors[6 * s + 5]
    return ti.Matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


@ti.func
def row(values: ti.template(), s):
    return ti.Vector([values[3 * s + j] for j in ti.static(range(3))])


@ti.func
def hand_over(k, total, force: ti.template(), contact_force_out: ti.template()):
    """The contact force of node k goes into the output and leaves the force of the node."""
    for j in ti.static(range(3)):
        contact_force_out[3 * k + j] = total[j]
        force[3 * k + j] = force[3 * k + j] - total[j]


@ti.kernel
def kick_and_drift(
    nodes: INDEX,
    mass: ARRAY,
    inverse_mass: ARRAY,
    load: ARRAY,
    force: ARRAY,
    reference: ARRAY,
    kick_before: ti.f64,
    kick_after: ti.f64,
    drift: ti.f64,
    u: ARRAY,
    v: ARRAY,
    sums_out: ARRAY,
):
    """u, v are advanced in place; sums_out [8]: sums over the list at time level n."""
    ti.loop_config(serialize=True)
    for _ in range(1):
        sums = ti.Vector.zero(ti.f64, SUMS)
        for s in range(nodes.shape[0]):
            node = nodes[s]
            acceleration = symmetric(inverse_mass, s) @ (row(load, s) - row(force, s))
            displacement = row(u, node)
            velocity = row(v, node) + kick_before * acceleration
            momentum = symmetric(mass, s) @ velocity
            spin = (row(reference, node) + displacement).cross(momentum)
            sums[0] += 0.5 * velocity.dot(momentum)
            for j in ti.static(range(3)):
                sums[1 + j] += momentum[j]
                sums[4 + j] += spin[j]
            sums[7] += row(load, s).dot(displacement)
            velocity += kick_after * acceleration
            for j in ti.static(range(3)):
                v[3 * node + j] = velocity[j]
                u[3 * node + j] = displacement[j] + drift * velocity[j]
        for j in ti.static(range(SUMS)):
            sums_out[j] = sums[j]


@ti.kernel
def support_reactions(
    slots: INDEX,
    axes: INDEX,
    speeds: ARRAY,
    mass: ARRAY,
    inverse_mass: ARRAY,
    load: ARRAY,
    force: ARRAY,
    sums_out: ARRAY,
):
    """Reaction M a + f - f_ext of every prescribed component (row, axis); sums_out [4]: total force, power."""
    ti.loop_config(serialize=True)
    for _ in range(1):
        sums = ti.Vector.zero(ti.f64, 4)
        for i in range(slots.shape[0]):
            s, axis = slots[i], axes[i]
            net = row(load, s) - row(force, s)
            inertia = symmetric(mass, s) @ (symmetric(inverse_mass, s) @ net)
            reaction = 0.0
            for j in ti.static(range(3)):
                if j == axis:
                    reaction = inertia[j] - net[j]
                    sums[j] += reaction
            sums[3] += reaction * speeds[i]
        for j in ti.static(range(4)):
            sums_out[j] = sums[j]
