"""Contact forces on nodes that keep their mass, the baselines of the comparison (METHOD 2, end).

    penalty   lambda_p = kappa A_k max(0, -g_p(x^n)),  energy 1/2 kappa A_k max(0, -g_p)^2
    impulse   if g_p(x^n) <= 0: the smallest change of the velocity v* after the kick with nu_p . v >= 0;
              lambda = impulse / dt

The contact nodes come first in the list of boundary nodes.
"""

from ..columns import SUMS
from ..engine import ti
from ..language.counted import counted
from ..language.entries import row
from ..language.threads import item, meet, sum_of, turns
from ..nodes.boundary_nodes import symmetric
from .constraint_rows import normal_of, number_of, set_number, set_vector, velocity_of
from .islands import node_count
from .local_contact import multipliers


@ti.func
def penalty_load(contact: ti.template(), rows: ti.template()):
    """Set the penalty forces of all rows, and sum up their energy."""
    energy = 0.0
    for turn in range(turns(contact, node_count(contact))):
        k = item(contact, turn)
        energy += counted(contact, k) * penalty_node(contact, rows, k)
    contact.sums[SUMS.contact] = sum_of(contact, energy)


@ti.func
def penalty_node(contact: ti.template(), rows: ti.template(), k):
    """Set the penalty forces of the rows of node k; return their energy [J]."""
    slots = ti.static(rows.options.slots)
    energy = 0.0
    for p in ti.static(range(slots)):
        r = k * slots + p
        overlap = ti.max(0.0, 0.0 - number_of(rows, r, rows.at.gap))
        energy += 0.5 * contact.penalty_stiffness[k] * overlap * overlap
        put_force(
            rows,
            k,
            p,
            contact.penalty_stiffness[k] * overlap,
            contact.penalty_stiffness[k] * overlap * normal_of(rows, r),
        )
    return energy


@ti.func
def impulse_load(body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), span):
    """Set the impulse forces of all rows; span: time [s] over which an impulse acts, 0 if no step is taken."""
    for turn in range(turns(contact, node_count(contact))):
        impulse_node(body, boundary, contact, rows, span, item(contact, turn))
    meet(contact)


@ti.func
def impulse_node(body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), span, k):
    """Set the impulse forces of the rows of node k."""
    slots = ti.static(rows.options.slots)
    time = ti.max(span, 1e-300)
    flexible = symmetric(boundary.inverse_mass, k)
    net = row(boundary.load, k) - row(body.special_force, k)
    free = row(body.v, contact.nodes[k]) + span * (flexible @ net)
    normals = ti.Matrix.zero(ti.f64, slots, 3)
    speeds = ti.Vector.one(ti.f64, slots)
    for p in ti.static(range(slots)):
        r = k * slots + p
        if number_of(rows, r, rows.at.gap) <= 0.0 and span > 0.0:
            direction = normal_of(rows, r)
            speeds[p] = 0.0 - direction.dot(velocity_of(rows, r, rows.at.velocity))
            for j in ti.static(range(3)):
                normals[p, j] = direction[j]
    impulses = multipliers(free, normals, speeds, flexible, 0.0, slots)
    for p in ti.static(range(slots)):
        direction = ti.Vector([normals[p, j] for j in ti.static(range(3))])
        put_force(rows, k, p, impulses[p] / time, impulses[p] / time * direction)


@ti.func
def put_force(rows: ti.template(), k, p: ti.template(), pressing, force):
    """Set the force of row p of node k, and lambda where friction asks for it."""
    r = k * ti.static(rows.options.slots) + p
    set_vector(rows, r, rows.at.force, force)
    if ti.static(rows.at.pressing >= 0):
        set_number(rows, r, rows.at.pressing, pressing)
