"""Friction of the kick where the normal n of a row differs from the removed direction m of its node (METHOD 3).

    t = T^t s - n (m . T^t s)/(n . m),   so that m . t = 0   and   T t = s,   n . t = p - lambda

T [2, 3]: two tangents of the contact; s [2]: the friction in them. A node with normal removal has no mass along m, so a
force there would move nothing. Of the contact force p n + T^t s on a node the static solve has balanced the component
along m, as lambda n; so friction may be any force without it, and its part along n belongs to the pressing force p, by
which the cone is measured. The rows of A = T - (T m) n^t/(n . m) turn forces s into t = A^t s and velocities of the
components with mass into the slip of the node in the plane of the contact, A v. Where n = m all this is T.
"""

from ..engine import ti
from .constraint_rows import friction_cone, number_of, pressing_of, sum_of_cones
from .friction import LIMIT, SLIP_SPEED, friction_force, node_place, tangents

ALIGNED = 1e-13  # sine of the angle between n and m, or part of a force in massless components, that is rounding
STEEP = 0.5  # cosine between n and m below which the part along m is left out instead of turned into pressing force
CONE_ROUNDS = 10  # iterations between the friction of a row and its pressing force, at most
CONE_CHANGE = 1e-12  # relative change of the pressing force at which they end
LEAST_SHARE = 0.5  # of lambda in the pressing force: friction at most doubles it


@ti.func
def massive_tangents(contact: ti.template(), k, normal):
    """Return A [2, 3] of a row of node k with this normal, and A n [2]: how its friction adds to the pressing force.

    A n is exactly 0 where the normal is the removed direction, and where friction is part of the static solve.
    """
    across = tangents(normal)
    presses = ti.Vector([0.0, 0.0])
    if ti.static(contact.options.model == "massless" and contact.options.block == 1):
        removed = ti.Vector([contact.basis[3 * k + i] for i in ti.static(range(3))])
        leaning = across @ removed
        if leaning.norm_sqr() > ALIGNED * ALIGNED:
            along = normal
            if ti.abs(normal.dot(removed)) < STEEP:
                along = removed
            across = across - leaning.outer_product(along) / along.dot(removed)
            presses = across @ normal
    return across, presses


@ti.func
def slip_speed_of(contact: ti.template(), k, normal, velocity):
    """Return the slip speed [m/s] of node k in the plane of a contact out of its velocity [3] relative to the partner.

    With normal removal the velocity has no part along the removed direction; that of the node follows from its contact.
    """
    speed = (velocity - normal.dot(velocity) * normal).norm()
    if ti.static(contact.options.model == "massless" and contact.options.block == 1):
        across, presses = massive_tangents(contact, k, normal)
        if presses.norm_sqr() > 0.0:
            speed = (across @ velocity).norm()
    return speed


@ti.func
def kick_force(
    contact: ti.template(), rows: ti.template(), k, r, across, presses, mobility, slip, limit
):  # fmt: skip
    """Return the friction [3] [N] of row r of node k; across, presses: of `massive_tangents`; limit [N]: for lambda."""
    pressing = number_of(rows, r, rows.at.pressing)
    sliding = ti.Vector([0.0, 0.0])
    total, allowed = pressing, limit
    for _ in range(CONE_ROUNDS):
        sliding = friction_force(contact.options.friction, mobility, slip, allowed, contact.friction[SLIP_SPEED])
        if limit <= 0.0 or presses.norm_sqr() == 0.0:
            break
        before = total
        total = pressing / ti.max(LEAST_SHARE, 1.0 - presses.dot(sliding) / before)
        allowed = ti.min(friction_cone(rows, r, total), layer_cap(contact, rows, k, r))
        if ti.abs(total - before) <= CONE_CHANGE * pressing:
            break
    return massive_part(contact, k, across.transpose() @ sliding)


@ti.func
def layer_cap(contact: ti.template(), rows: ti.template(), k, r):
    """Return the largest friction [N] that the layer of node k leaves to its row r whatever its pressing force."""
    cap = 1e300
    if ti.static(contact.options.layered):
        cone = friction_cone(rows, r, number_of(rows, r, rows.at.pressing))
        cones = sum_of_cones(rows, k, pressing_of(rows, k))
        cap = contact.friction[node_place(k, LIMIT)] * (cone / ti.max(cones, 1e-300))
    return cap


@ti.func
def without_massless_components(contact: ti.template(), k, vector):
    """Return a vector [3] without the massless components of node k, whose friction the static solve includes."""
    for j in ti.static(range(contact.options.block)):
        column = ti.Vector([contact.basis[(3 * k + i) * contact.options.block + j] for i in ti.static(range(3))])
        vector = vector - column.dot(vector) * column
    return vector


@ti.func
def massive_part(contact: ti.template(), k, force):
    """Return a force [3] of the kick without its part in massless components, where the static solve has friction."""
    if ti.static(contact.options.static_friction):
        rest = without_massless_components(contact, k, force)
        if (force - rest).norm() > ALIGNED * force.norm():
            force = rest
    return force
