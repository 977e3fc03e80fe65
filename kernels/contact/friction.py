"""Local friction problem of one row: find the tangential force t that obeys the law with the slip it causes (METHOD 3).

    s = s* + W t,   |t| <= c,   t = -c s/|s| where it slips,   c = mu lambda

s* is the slip without friction and W [2, 2] the change of slip by a unit force, in two tangents of the contact. An
impulse on a node with mass and a node of the static solve pose this same problem. It is the optimality condition of
min 1/2 t.W t + s*.t over |t| <= c: t = -(W + a)^-1 s*, with a >= 0 such that |t| = c when it slips.
The regularised law (Oden and Martins 1985) is |t| = c phi(|s|/e), phi(z) = z (2 - z) for z < 1, else 1; it creeps
instead of sticking.
"""

from ..columns import SUMS
from ..engine import ti
from ..lanes import FRICTION_NODE
from ..language.threads import leader

# `friction`: slip speed [m/s] of the regularised law, step [s] of the static solve; then for every contact node:
# largest friction force [N] that its layer transmits; slip speed [m/s] after the kick without friction, its change by a
# unit force [m/(s N)] and the mean of the speeds before and after the kick; work [J] and force [N] of friction in the
# last kick or step; displacement (3) [m] from which the static solve measures slip; then the laws (friction_laws.py)
SLIP_SPEED, STEP, FIRST = 0, 1, 2
LIMIT, SPEED, MOBILITY, MEAN_SPEED, WORK, FORCE, ORIGIN = 0, 1, 2, 3, 4, 5, 6
# where friction is part of the static solve, whose layers need neither mobility nor mean speed: work [J] of friction in
# the last kick, which WORK does not have there, and force [N] that it added to FORCE
KICK_WORK, KICK_FORCE = MOBILITY, MEAN_SPEED
NODE = FRICTION_NODE

SINGULAR = 1e-12  # W is singular when its determinant is below this times its trace squared
STOPPED = 1e-6  # the row sticks when this ratio of the slip, or less, remains
ROUNDS = 60  # iterations of the root search, at most


@ti.func
def tangents(normal):
    """Return two unit vectors [2, 3] perpendicular to a unit normal and to each other; zeros where it is 0."""
    smallest = 0
    for j in ti.static(range(1, 3)):
        if normal[j] * normal[j] < normal[smallest] * normal[smallest]:
            smallest = j
    axis = ti.Vector([ti.select(smallest == j, 1.0, 0.0) for j in range(3)])
    first = axis.cross(normal)
    first = first / ti.max(first.norm(), 1e-300)
    second = normal.cross(first)
    return ti.Matrix([[first[j] for j in range(3)], [second[j] for j in range(3)]])


@ti.func
def shifted(mobility, slip, shift):
    """Return -(W + a)^-1 s*; for a = 0 and a singular W, s* without its part that no force can change."""
    a, b, c = mobility[0, 0], mobility[0, 1], mobility[1, 1]
    trace = a + c
    determinant = a * c - b * b
    if determinant <= SINGULAR * trace * trace:
        determinant = 0.0
    whole = determinant + shift * (trace + shift)
    force = ti.Vector([b * slip[1] - (c + shift) * slip[0], b * slip[0] - (a + shift) * slip[1]])
    if whole > 0.0:
        force = force / whole
    elif trace > 0.0:
        force = ti.Vector([0.0 - a * slip[0] - b * slip[1], 0.0 - b * slip[0] - c * slip[1]]) / (trace * trace)
    else:
        force = ti.Vector([0.0, 0.0])
    return force


@ti.func
def mobilised(slip, scale):
    """Return the ratio phi of c that a slip of this size mobilises by the regularised law."""
    result = 1.0
    z = slip / scale
    if z < 1.0:
        result = z * (2.0 - z)
    return result


@ti.func
def coulomb_force(mobility, slip, limit, start):
    """Return the friction force t [2] of Coulomb's law and its shift a; start: a to begin with, 0 where none is known.

    With n = w (W + a)^-1 s* and w = det(W + a) the force has the size |n|/w. It falls with a: safeguarded Newton of
    w/|n| = 1/c, which is nearly linear in a.
    """
    a, b, c = mobility[0, 0], mobility[0, 1], mobility[1, 1]
    trace, determinant = a + c, a * c - b * b
    along = ti.Vector([c * slip[0] - b * slip[1], a * slip[1] - b * slip[0]])
    force = ti.Vector([0.0, 0.0])
    sticks = False
    if determinant > SINGULAR * trace * trace:
        force = along / (0.0 - determinant)
        sticks = along.norm_sqr() <= (limit * determinant) ** 2
    else:
        determinant = 0.0
        force = shifted(mobility, slip, 0.0)
        left = slip + mobility @ force  # not zero where no force can stop the slip
        sticks = force.norm() <= limit and left.norm() <= STOPPED * slip.norm()
    shift = 0.0
    if not sticks:
        low, high = 0.0, slip.norm() / limit
        # exact where the mobility is the same in all directions; never 0, since there a singular mobility hides the
        # slip that no force can stop
        shift = ti.max(1e-2 * STOPPED * high, high - 0.5 * trace)
        if start > 0.0 and start < high:
            shift = start
        whole = 1.0
        for _ in range(ROUNDS):
            whole = determinant + shift * (trace + shift)
            along = ti.Vector([(c + shift) * slip[0] - b * slip[1], (a + shift) * slip[1] - b * slip[0]])
            square = along.norm_sqr()
            size, allowed = ti.sqrt(square), limit * whole
            if ti.abs(size - allowed) <= 1e-14 * allowed:
                break
            if size > allowed:
                low = shift
            else:
                high = shift
            curvature = (c + shift) * along[0] ** 2 - 2.0 * b * along[0] * along[1] + (a + shift) * along[1] ** 2
            trial = shift + square * (size / limit - whole) / ti.max(curvature, 1e-300)
            if not (trial > low and trial < high):
                trial = 0.5 * (low + high)
            shift = trial
        force = along / (0.0 - whole)
    return force, shift


@ti.func
def regularized_force(mobility, slip, limit, scale):
    """Return the friction force t [2] of the regularised law."""
    # |t(a)| - c phi(a |t(a)|) falls with a: bisection
    low, high = 0.0, slip.norm() / limit
    size = shifted(mobility, slip, high).norm()
    while size > limit * mobilised(high * size, scale):
        high = 2.0 * high
        size = shifted(mobility, slip, high).norm()
    shift = high
    force = ti.Vector([0.0, 0.0])
    for _ in range(ROUNDS):
        force = shifted(mobility, slip, shift)
        size = force.norm()
        allowed = limit * mobilised(shift * size, scale)
        if ti.abs(size - allowed) <= 1e-14 * limit:
            break
        if size > allowed:
            low = shift
        else:
            high = shift
        shift = 0.5 * (low + high)
    return force


@ti.func
def friction_force(law: ti.template(), mobility, slip, limit, scale):
    """Return the friction force t [2]; limit: c; scale: e, the slip that fully mobilises the regularised law."""
    force, _shift = friction_from(law, mobility, slip, limit, scale, 0.0)
    return force


@ti.func
def friction_from(law: ti.template(), mobility, slip, limit, scale, start):
    """Return the friction force t [2] and its shift a, of the regularised law 0; start: see `coulomb_force`."""
    force, shift = ti.Vector([0.0, 0.0]), 0.0
    if limit > 0.0:
        if ti.static(law == "coulomb"):
            force, shift = coulomb_force(mobility, slip, limit, start)
        else:
            force = regularized_force(mobility, slip, limit, scale)
    return force, shift


@ti.func
def node_place(k, number: ti.template()):
    """Return where a number of node k stands in `friction`."""
    return FIRST + NODE * k + number


@ti.func
def layer_limit(contact: ti.template(), k, cone, cones):
    """Return the largest friction [N] of a row of node k with its cone [N] and the shear force of the layer.

    cones: sum of those of all rows of the node, which share the shear force in proportion.
    """
    return ti.min(cone, contact.friction[node_place(k, LIMIT)] * (cone / ti.max(cones, 1e-300)))


@ti.func
def note_kick(contact: ti.template(), k, work, strongest):
    """Keep for the layer of node k the work [J] of friction in the kick, and its force.

    strongest [N]: largest friction of a row, where it is part of the static solve together with that friction.
    """
    if ti.static(contact.options.static_friction):
        contact.friction[node_place(k, KICK_WORK)] = work
        contact.friction[node_place(k, KICK_FORCE)] = strongest - contact.friction[node_place(k, FORCE)]
    else:
        contact.friction[node_place(k, WORK)] = work
        contact.friction[node_place(k, FORCE)] = strongest


@ti.func
def add_work(contact: ti.template(), before):
    """Add work [J] of friction up to the time level, which every thread knows."""
    if leader(contact) == 1:
        contact.sums[SUMS.friction_before] = contact.sums[SUMS.friction_before] + before


@ti.func
def clear_work(contact: ti.template()):
    """Set the work of friction to 0, before the phases of the step add to it."""
    contact.sums[SUMS.friction_before] = 0.0
    contact.sums[SUMS.friction_after] = 0.0
