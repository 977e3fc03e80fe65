"""Constraint rows: the interface between the search for contact and all contact models.

    g_r + n_r . d >= 0,   lambda_r >= 0,   (g_r + n_r . d) lambda_r = 0,   F_r = lambda_r n_r + t_r on the node

Row r = k * slots + p is constraint p of contact node k; d is the displacement of the node from its present position. A
search fills the rows: the gap g (open positive), the unit normal n into the body, the size of the lengths whose
difference g is (for its rounding error), and the velocity of the partner at the node. obstacle_rows.py does this for
rigid obstacles, whose rows have one node of weight 1. Penalty, impulses, prediction, static solve and friction read
rows only. They set the force of every row; `apply_rows` applies it to the node, and the search that filled the row
computes the load of the partner from it.
"""

from ..columns import SUMS
from ..engine import ti
from ..language.counted import counted
from ..language.threads import item, put_sums, so_far, turns
from .islands import node_count

SUMMED = ("sum",) * 4
FORCE_PLACES = tuple(SUMS.contact_force + j for j in range(3))
PRESSED_PLACES = (*FORCE_PLACES, SUMS.contact_nodes)
EPSILON = 32 * 2.220446049250313e-16  # relative rounding error of a gap, or of a sum of many displacements


@ti.func
def number_of(rows: ti.template(), r, place: ti.template()):
    """Return a number of row r; place: one of bundles.RowPlaces, rows.at."""
    return rows.values[r * ti.static(rows.at.width) + place]


@ti.func
def set_number(rows: ti.template(), r, place: ti.template(), value):
    """Set a number of row r."""
    rows.values[r * ti.static(rows.at.width) + place] = value


@ti.func
def vector_of(rows: ti.template(), r, place: ti.template()):
    """Return three numbers of row r as a vector."""
    first = r * ti.static(rows.at.width) + place
    return ti.Vector([rows.values[first + j] for j in ti.static(range(3))])


@ti.func
def set_vector(rows: ti.template(), r, place: ti.template(), vector):
    """Set three numbers of row r."""
    first = r * ti.static(rows.at.width) + place
    for j in ti.static(range(3)):
        rows.values[first + j] = vector[j]


@ti.func
def normal_of(rows: ti.template(), r):
    """Return the unit normal [3] of row r."""
    return vector_of(rows, r, rows.at.normal)


@ti.func
def velocity_of(rows: ti.template(), r, place: ti.template()):
    """Return the velocity [3] [m/s] of the partner of row r; place: rows.at.velocity or mean_velocity. 0 at rest."""
    velocity = ti.Vector.zero(ti.f64, 3)
    if ti.static(place >= 0):
        velocity = vector_of(rows, r, place)
    return velocity


@ti.func
def friction_cone(rows: ti.template(), r, pressing):
    """Return the largest friction [N] that the law of row r allows for a normal force [N]."""
    limit = number_of(rows, r, rows.at.coefficient) * pressing
    if ti.static(rows.at.shear_limit >= 0):
        limit = ti.min(limit, number_of(rows, r, rows.at.shear_limit))
    return limit


@ti.func
def pressing_of(rows: ti.template(), k):
    """Return the normal forces [slots] [N] of node k."""
    slots = ti.static(rows.options.slots)
    return [number_of(rows, k * slots + p, rows.at.pressing) for p in ti.static(range(slots))]


@ti.func
def sum_of_cones(rows: ti.template(), k, pressing: ti.template()):
    """Sum the largest friction [N] of every row of node k for the normal forces [slots] [N]."""
    total = 0.0
    for p in ti.static(range(rows.options.slots)):
        total += friction_cone(rows, k * ti.static(rows.options.slots) + p, ti.max(pressing[p], 0.0))
    return total


@ti.func
def sum_of_rows(rows: ti.template(), k, place: ti.template()):
    """Sum three numbers of every row of node k."""
    slots = ti.static(rows.options.slots)
    total = ti.Vector.zero(ti.f64, 3)
    for p in ti.static(range(slots)):
        total += vector_of(rows, k * slots + p, place)
    return total


@ti.func
def apply_rows_to_node(body: ti.template(), contact: ti.template(), rows: ti.template(), k):
    """Apply the forces of its rows to contact node k, and return their sum [3] [N].

    special_force is the internal force less the contact force.
    """
    total = sum_of_rows(rows, k, rows.at.force)
    for j in ti.static(range(3)):
        contact.force[3 * k + j] = total[j]
        body.special_force[3 * k + j] = body.special_force[3 * k + j] - total[j]
    return total


@ti.func
def apply_rows(body: ti.template(), contact: ti.template(), rows: ti.template()):
    """Apply the forces of the rows to the contact nodes, and sum them up."""
    force = ti.Vector.zero(ti.f64, 3)
    pressed = 0.0
    for turn in range(turns(contact, node_count(contact))):
        k = item(contact, turn)
        total = apply_rows_to_node(body, contact, rows, k)
        force += counted(contact, k) * total
        if total.norm() > 0.0:
            pressed += counted(contact, k)
    put_sums(contact, contact.sums, PRESSED_PLACES, [force[0], force[1], force[2], pressed], SUMMED)


@ti.func
def apply_kick_friction(body: ti.template(), contact: ti.template(), rows: ti.template()):
    """Apply the friction of the kick to the contact nodes, and add it to the sum of the contact forces."""
    force = ti.Vector([so_far(contact, contact.sums, place) for place in ti.static(FORCE_PLACES)])
    for turn in range(turns(contact, node_count(contact))):
        k = item(contact, turn)
        total = sum_of_rows(rows, k, rows.at.kick_friction)
        force += counted(contact, k) * total
        for j in ti.static(range(3)):
            contact.force[3 * k + j] = contact.force[3 * k + j] + total[j]
            body.special_force[3 * k + j] = body.special_force[3 * k + j] - total[j]
    put_sums(contact, contact.sums, FORCE_PLACES, [force[0], force[1], force[2]], ("sum",) * 3)
