"""MPRGP with pairs of bodies: product with T^t K T, its preconditioner, length of a projected step (METHOD 7).

d = T y gives every slave the normal motion of its masters (contact/pair_rows.py). The diagonal block of T^t K T at a
master is K_mm and what its slaves hand over,

    D_m = K_mm + sum_s P_sm^2 (l_s . D_s l_s) b b^t,   b = B_m^t nu_s,   l_s: lift of the slave (contact/pair_rows.py),

or, with friction, K_mm + sum_s P_sm^2 B_m^t B_s D_s B_s^t B_m, without the terms between two slaves. It is the block
from which node_basis.py makes the basis of the node. These blocks do not bound the eigenvalues; the length of a
projected step comes from the largest one, found by power iteration.
"""

from ..contact.constraint_rows import normal_of
from ..contact.islands import first_node, node_count
from ..contact.pair_rows import collect, entry, lift_of, pair_row, spread, weight
from ..engine import ti
from ..language.threads import item, leader, meet, over_threads, turns
from ..language.vectors import load
from ..node_places import PLACES
from ..pair_places import FIRST_ENTRY, MASTERS, ROWS, SLAVES
from .control import PAIR_STEP, STATS, SWEEPS
from .massless_node import basis_of, square
from .node_basis import into_basis, into_motion, part, put, set_basis
from .parts import part_of, parts, product_of

POWER = 12  # iterations that estimate the largest eigenvalue
LONG = 1.9  # length of a projected step times the largest eigenvalue; below 2 it converges
SAFETY = 1.1  # of the estimate
MANY = 100.0  # products of a solve after which the length is estimated anew


@ti.func
def note_products(stats: ti.template(), island, done):
    """Note the number of products of a linear problem that has ended; after many the length is estimated anew."""
    at = island * STATS
    stats[at + SWEEPS] = stats[at + SWEEPS] + done
    if done > MANY:
        stats[at + PAIR_STEP] = 0.0


@ti.func
def multiply_coupled(
    contact: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    system: ti.template(),
    island,
    block: ti.template(),
):
    """Set the product of all packs of an island with T^t K T, without the bases of the nodes.

    The motion y of every node stands in `increment`.
    """
    at = ti.static(PLACES[block])
    stride = system.stiffness.shape[0]
    spread(coupling, contact, rows, system.increment, 0, stride, block)
    for turn in range(parts(contact, island)):
        pack, node, count = part_of(contact, system, island, turn)
        if count > 0:
            force = product_of(contact, system, pack, node, block)
            moved = part(system, system.increment, node, 0, block)
            for i, j in ti.static(ti.ndrange(block, block)):
                diagonal = load(system.response, node + (at.diagonal + i * block + j) * stride, system.lanes)
                force[i] += diagonal * moved[j]
            put(system, system.response, node, count, at.product, block, force)
    collect(coupling, contact, rows, system.response, at.product * stride, stride, block)


@ti.func
def multiply_in_bases(
    contact: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    system: ti.template(),
    island,
    block: ti.template(),
):
    """Set the product of all packs of an island with T^t K T, in the bases of the nodes."""
    at = ti.static(PLACES[block])
    multiply_coupled(contact, rows, coupling, system, island, block)
    for turn in range(parts(contact, island)):
        _pack, node, count = part_of(contact, system, island, turn)
        if count > 0:
            force = part(system, system.response, node, at.product, block)
            put(system, system.response, node, count, at.product, block, into_basis(system, node, force, block))
    meet(contact)


@ti.func
def shared_stiffness(contact: ti.template(), rows: ti.template(), system: ti.template(), k, block: ti.template()):
    """Return the stiffness [3, 3] [N/m] of slave k that a motion of its masters meets."""
    own = square(system.inverse, k, system.stiffness.shape[0], block)
    basis = basis_of(contact.basis, k, block)
    result = basis @ own @ basis.transpose()
    if ti.static(not contact.options.static_friction):
        normal = normal_of(rows, pair_row(rows, k))
        lift = basis.transpose() @ lift_of(contact, rows, k, block)
        result = lift.dot(own @ lift) * normal.outer_product(normal)
    return result


@ti.func
def precondition(
    contact: ti.template(), rows: ti.template(), coupling: ti.template(), system: ti.template(), block: ti.template()
):
    """Set `System.inverse`, the inverse of the diagonal blocks D of all nodes."""
    at = ti.static(PLACES[block])
    stride = system.stiffness.shape[0]
    count, number = node_count(contact), 0
    for turn in range(turns(contact, count)):
        k = item(contact, turn)
        for i in ti.static(range(block * block)):
            system.inverse[i * stride + k] = system.response[(at.diagonal + i) * stride + k]
    meet(contact)
    if leader(contact) == 1:  # one row after another
        number = coupling.lists[ROWS]
    for back in range(number):
        r = number - 1 - back
        k = entry(coupling, SLAVES, r)
        handed = shared_stiffness(contact, rows, system, k, block)
        for i in range(entry(coupling, FIRST_ENTRY, r), entry(coupling, FIRST_ENTRY, r + 1)):
            m = entry(coupling, MASTERS, i)
            if m < count:
                basis = basis_of(contact.basis, m, block)
                there = weight(coupling, i) * weight(coupling, i) * (basis.transpose() @ handed @ basis)
                for a, b in ti.static(ti.ndrange(block, block)):
                    place = (a * block + b) * stride + m
                    system.inverse[place] = system.inverse[place] + there[a, b]
    meet(contact)
    for turn in range(turns(contact, count)):
        k = item(contact, turn)
        inverse = square(system.inverse, k, stride, block).inverse()
        for i, j in ti.static(ti.ndrange(block, block)):
            system.inverse[(i * block + j) * stride + k] = inverse[i, j]
    meet(contact)


@ti.func
def pair_step(
    contact: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    system: ti.template(),
    island,
    alone,
    block: ti.template(),
):
    """Return the length of a projected step; alone: the length without rows of pairs."""
    at = ti.static(PLACES[block])
    stats = ti.static(system.stats)
    stride, place = system.stiffness.shape[0], island * STATS
    result = alone
    if coupling.lists[ROWS] > 0:
        if stats[place + PAIR_STEP] == 0.0:
            begin = first_node(contact, island)
            nodes = first_node(contact, island + 1) - begin
            for turn in range(parts(contact, island)):
                _pack, node, count = part_of(contact, system, island, turn)
                if count > 0:
                    set_basis(system, node, count, block, contact.options.bounds)
            for turn in range(turns(contact, nodes)):
                k = begin + item(contact, turn)
                for j in ti.static(range(block)):  # any vector that no symmetry makes special
                    system.response[(at.direction + j) * stride + k] = ti.sin(1.0 + 7.0 * k + 3.0 * j)
            largest = 1.0
            for _ in range(POWER):
                total = 0.0
                meet(contact)
                for turn in range(parts(contact, island)):
                    _pack, node, count = part_of(contact, system, island, turn)
                    if count > 0:
                        direction = part(system, system.response, node, at.direction, block)
                        motion = into_motion(system, node, direction, block)
                        put(system, system.increment, node, count, 0, block, motion)
                multiply_in_bases(contact, rows, coupling, system, island, block)
                before = 0.0
                for turn in range(turns(contact, nodes)):
                    k = begin + item(contact, turn)
                    for j in ti.static(range(block)):
                        one = system.response[(at.direction + j) * stride + k]
                        two = system.response[(at.product + j) * stride + k]
                        before += one * one
                        total += two * two
                sums = over_threads(contact, [before, total], ("sum", "sum"))
                before, total = sums[0], sums[1]
                largest = ti.sqrt(total / before)
                for turn in range(turns(contact, nodes)):
                    k = begin + item(contact, turn)
                    for j in ti.static(range(block)):
                        two = system.response[(at.product + j) * stride + k]
                        system.response[(at.direction + j) * stride + k] = two / ti.sqrt(total)
            meet(contact)
            if leader(contact) == 1:
                stats[place + PAIR_STEP] = LONG / (SAFETY * largest)
            meet(contact)
        result = stats[place + PAIR_STEP]
    return result
