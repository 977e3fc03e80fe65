"""Rows of a contact node that enter its linear problem, where bodies in contact have obstacles beside them (METHOD 7).

A node has up to three rows of obstacles and one of a pair. Those that enter must be linearly independent, so that each
bounds one component of the node (several_bounds.py). The nearest ones are taken: a row in reach (of an obstacle: its
gap is below the longest move of the solve) whose normal has a part of at least INDEPENDENT that is orthogonal to the
rows taken before. Without a row in reach the nearest one enters alone. A row that is left out is measured all the same:
the next solve takes it first if it is violated, and a node that stays deep in one is squeezed, which stops the run.
"""

from ..contact.constraint_rows import set_vector
from ..contact.islands import node_count
from ..contact.pair_rows import pair_row
from ..engine import ti
from ..language.threads import leader, meet
from ..node_places import PLACES
from ..pair_places import SQUEEZED
from .control import REACH
from .massless_node import constraints, entries
from .several_bounds import row_of

INDEPENDENT = 0.05  # sine of the angle between a normal and those taken before it, below which its row is left out
OPPOSED = -0.95  # cosine between two normals below which the farther one is left out: the node could only slip away
SAME = 0.99  # cosine between the normals of two obstacles above which the nearer one stands for both
DEEP = 0.3  # depth in a row, over the longest move of a solve, beyond which a node that has left out a row is squeezed
BEYOND = 1e100  # added to the gap of rows out of reach, to order them behind the others


@ti.func
def choose_rows(contact: ti.template(), rows: ti.template(), system: ti.template(), k, reach):
    """Set the normals and gaps of the rows of node k that enter its linear problem, nearest first, and its lift."""
    block, slots, bounds = ti.static(contact.options.block, contact.options.slots, contact.options.bounds)
    stride = system.stiffness.shape[0]
    normals, gaps = constraints(contact, rows, k, block, slots)
    directions = ti.Matrix.zero(ti.f64, bounds, block)  # orthonormal, of the rows taken
    taken = ti.Vector([-1 for _ in range(bounds)])
    for i in ti.static(range(bounds)):
        nearest = 1e300
        if ti.static(i > 0):
            nearest = 0.5 * BEYOND
        normal, direction = ti.Vector.zero(ti.f64, block), ti.Vector.zero(ti.f64, block)
        gap = 1.0
        for p in ti.static(range(slots)):
            this = ti.Vector([normals[p, j] for j in ti.static(range(block))])
            rest = orthogonal(this, directions, block, bounds)
            place = gaps[p]
            if ti.static(p < slots - 1):
                place = ti.select(gaps[p] <= reach, gaps[p], gaps[p] + BEYOND)
            fits = this.norm() > 0.0 and rest.norm() >= INDEPENDENT * this.norm()
            if place < nearest and fits and cosines(contact, system, k, this, i).min() > OPPOSED:
                nearest, gap, normal, direction = place, gaps[p], this, rest / rest.norm()
                taken[i] = p
        system.gaps[i * stride + k] = gap
        system.response[ti.static(PLACES[block].rows[i]) * stride + k] = float(taken[i])
        for j in ti.static(range(block)):
            directions[i, j] = direction[j]
            system.normals[(i * block + j) * stride + k] = normal[j]
    set_lift(rows, k, normals, taken, block, slots, bounds)


@ti.func
def orthogonal(vector, directions, block: ti.template(), bounds: ti.template()):
    """Return the part of a vector [block] that is orthogonal to orthonormal directions [bounds, block]; 0 is none."""
    rest = vector
    for i in ti.static(range(bounds)):
        direction = ti.Vector([directions[i, j] for j in ti.static(range(block))])
        rest = rest - direction.dot(rest) * direction
    return rest


@ti.func
def cosines(contact: ti.template(), system: ti.template(), k, normal, count: ti.template()):
    """Return the cosines of a normal [block] with those of the first `count` rows that enter at node k; 0 is none."""
    block = ti.static(contact.options.block)
    result = ti.Vector.zero(ti.f64, 3)
    for i in ti.static(range(count)):
        other = entries(system.normals, k, system.stiffness.shape[0], i * block, block)
        result[i] = normal.dot(other) / ti.max(normal.norm() * other.norm(), 1e-300)
    return result


@ti.func
def set_lift(rows: ti.template(), k, normals, taken, block: ti.template(), slots: ti.template(), bounds: ti.template()):
    """Set the lift of the row of pairs of node k: orthogonal to the other rows that enter; 0 if it does not enter."""
    own = ti.Vector([normals[slots - 1, j] for j in ti.static(range(block))])
    directions = ti.Matrix.zero(ti.f64, bounds, block)
    enters = 0
    for i in ti.static(range(bounds)):
        if taken[i] == slots - 1:
            enters = 1
        for p in ti.static(range(slots - 1)):
            if taken[i] == p:
                other = ti.Vector([normals[p, j] for j in ti.static(range(block))])
                rest = orthogonal(other, directions, block, bounds)
                for j in ti.static(range(block)):
                    directions[i, j] = rest[j] / rest.norm()
    lift = ti.Vector.zero(ti.f64, 3)
    if enters == 1:
        rest = orthogonal(own, directions, block, bounds)
        for j in ti.static(range(block)):
            lift[j] = rest[j] / rest.dot(own)
    set_vector(rows, pair_row(rows, k), rows.at.lift, lift)


@ti.func
def find_squeezed(coupling: ti.template(), contact: ti.template(), rows: ti.template(), system: ti.template()):
    """Note a node k that stays deep in a row and has no place for row p beside q, as 1 + (k slots + p) slots + q."""
    meet(contact)
    if leader(contact) == 1:
        find_squeezed_node(coupling, contact, rows, system)
    meet(contact)


@ti.func
def find_squeezed_node(coupling: ti.template(), contact: ti.template(), rows: ti.template(), system: ti.template()):
    """Note such a node by one thread."""
    block, slots, bounds = ti.static(contact.options.block, contact.options.slots, contact.options.bounds)
    reach = system.settings[REACH]
    for k in range(node_count(contact)):
        normals, gaps = constraints(contact, rows, k, block, slots)
        if gaps.min() < 0.0 - DEEP * reach:
            choose_rows(contact, rows, system, k, reach)
            nearest = row_of(contact, system, k, 0, block)
            for p in ti.static(range(slots)):
                normal = ti.Vector([normals[p, j] for j in ti.static(range(block))])
                left_out = normal.norm() > 0.0 and gaps[p] <= reach
                similar = cosines(contact, system, k, normal, bounds)
                for i in ti.static(range(bounds)):
                    enters = row_of(contact, system, k, i, block)
                    of_obstacles = p < slots - 1 and enters < slots - 1  # the nearer one of these stands for both
                    if enters == p or (of_obstacles and similar[i] >= SAME):
                        left_out = False
                if left_out:
                    coupling.values[SQUEEZED] = 1.0 + (k * slots + p) * slots + nearest
