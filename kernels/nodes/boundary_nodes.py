"""Kick and drift of the boundary nodes: those with tensor mass, supports or contact (METHOD 1 and 2).

    a = M^+ (f_ext - f),  v^n = v^{n-1/2} + k0 a,  v^{n+1/2} = v^n + k1 a,  x^{n+1} = x^n + dt v^{n+1/2}

M^+ is zero in prescribed and massless components: prescribed ones keep their velocity, massless ones do not move here,
since the static solve places them. special_force is the internal force less the contact force.
"""

from ..columns import BOUNDARY, BOUNDARY_SUMS, FIRST, SUPPORT, SUPPORT_SUMS
from ..engine import ti
from ..lanes import DRIFT, GRAVITY, KICK_AFTER, KICK_BEFORE
from ..language.counted import counted
from ..language.entries import row
from ..language.threads import item, meet, put_sums, turns
from .damping import damping_force

BOUNDARY_PLACES = tuple(range(FIRST.boundary, FIRST.boundary + BOUNDARY_SUMS))
SUPPORT_PLACES = tuple(range(FIRST.support, FIRST.support + SUPPORT_SUMS))
BOUNDARY_COMBINE, SUPPORT_COMBINE = ("sum",) * BOUNDARY_SUMS, ("sum",) * SUPPORT_SUMS


@ti.func
def symmetric(tensors: ti.template(), s):
    """Return entry s of flat symmetric tensors (xx, yy, zz, xy, yz, xz) as a matrix."""
    xx, yy, zz = tensors[6 * s], tensors[6 * s + 1], tensors[6 * s + 2]
    xy, yz, xz = tensors[6 * s + 3], tensors[6 * s + 4], tensors[6 * s + 5]
    return ti.Matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


@ti.func
def damp(body: ti.template(), boundary: ti.template(), contact: ti.template(), law: ti.template()):
    """Add the damping force at v^n to special_force, before support reactions and kick."""
    for turn in range(turns(contact, boundary.nodes.shape[0])):
        s = item(contact, turn)
        net = row(boundary.load, s) - row(body.special_force, s)
        mass, inverse = symmetric(boundary.mass, s), symmetric(boundary.inverse_mass, s)
        force = damping_force(law, body, mass, inverse, row(body.v, boundary.nodes[s]), net)
        for j in ti.static(range(3)):
            body.special_force[3 * s + j] = body.special_force[3 * s + j] + force[j]
    meet(contact)


@ti.func
def weight(body: ti.template(), boundary: ti.template(), s):
    """Return M g of boundary node s."""
    return symmetric(boundary.mass, s) @ ti.Vector([body.params[GRAVITY + j] for j in range(3)])


@ti.func
def kick_and_drift(body: ti.template(), boundary: ti.template(), contact: ti.template(), loaded: ti.template()):
    """Advance u and v of the boundary nodes by the steps in `params`; sum up energy and momentum at time level n.

    loaded: name of the term of loads other than gravity (loads.py), whose work is counted apart; "" without.
    """
    kick_before, kick_after, drift = body.params[KICK_BEFORE], body.params[KICK_AFTER], body.params[DRIFT]
    sums = ti.Vector.zero(ti.f64, BOUNDARY_SUMS)
    for turn in range(turns(contact, boundary.nodes.shape[0])):
        s = item(contact, turn)
        node = boundary.nodes[s]
        acceleration = symmetric(boundary.inverse_mass, s) @ (row(boundary.load, s) - row(body.special_force, s))
        displacement = row(body.u, node)
        velocity = row(body.v, node) + kick_before * acceleration
        momentum = symmetric(boundary.mass, s) @ velocity
        spin = (row(body.position, node) + displacement).cross(momentum)
        share = counted(contact, s)
        sums[BOUNDARY.kinetic] += share * (0.5 * velocity.dot(momentum))
        for j in ti.static(range(3)):
            sums[BOUNDARY.momentum + j] += share * momentum[j]
            sums[BOUNDARY.angular_momentum + j] += share * spin[j]
        if ti.static(loaded != ""):
            sums[BOUNDARY.load_work] += share * weight(body, boundary, s).dot(displacement)
        else:
            sums[BOUNDARY.load_work] += share * row(boundary.load, s).dot(displacement)
        velocity += kick_after * acceleration
        for j in ti.static(range(3)):
            body.v[3 * node + j] = velocity[j]
            body.u[3 * node + j] = displacement[j] + drift * velocity[j]
    put_sums(contact, boundary.sums, BOUNDARY_PLACES, [sums[j] for j in range(BOUNDARY_SUMS)], BOUNDARY_COMBINE)


@ti.func
def component_count(supports: ti.template()):
    """Return the number of prescribed components; beside driven ones stands a table (driven_supports.py)."""
    count = supports.components.shape[0]
    if ti.static(supports.driven):
        count = count // 2
    return count


@ti.func
def support_reactions(
    body: ti.template(), boundary: ti.template(), supports: ti.template(), contact: ti.template()
):  # fmt: skip
    """Sum up the reactions M a + f - f_ext of all prescribed components, and their power."""
    sums = ti.Vector.zero(ti.f64, SUPPORT_SUMS)
    for turn in range(turns(contact, component_count(supports))):
        i = item(contact, turn)
        s, axis = supports.components[i] // 3, supports.components[i] % 3
        net = row(boundary.load, s) - row(body.special_force, s)
        inertia = symmetric(boundary.mass, s) @ (symmetric(boundary.inverse_mass, s) @ net)
        reaction = 0.0
        for j in ti.static(range(3)):
            if j == axis:
                reaction = inertia[j] - net[j]
                sums[SUPPORT.support_force + j] += reaction
        sums[SUPPORT.support_power] += reaction * supports.speeds[i]
    put_sums(contact, supports.sums, SUPPORT_PLACES, [sums[j] for j in range(SUPPORT_SUMS)], SUPPORT_COMBINE)
