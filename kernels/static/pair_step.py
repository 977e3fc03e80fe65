"""MPRGP with pairs of bodies: product with T^t K T, its preconditioner, length of a projected step (METHOD 7).

d = T y gives every slave the normal motion of its masters (contact/pair_rows.py). The diagonal block of T^t K T at a
master is K_mm and what its slaves hand over,

    D_m = K_mm + sum_s P_sm^2 (l_s . D_s l_s) b b^t,   b = B_m^t nu_s,   l_s: lift of the slave (contact/pair_rows.py),

without the terms between two slaves. It is the block from which node_basis.py makes the basis of the node. These blocks
do not bound the eigenvalues; the length of a projected step comes from the largest one, found by power iteration.
"""

import taichi as ti

from ..contact.constraint_rows import normal_of
from ..contact.islands import first_node, first_pack, node_count
from ..contact.pair_rows import along, collect, entry, lift_of, pair_row, spread, weight
from ..lanes import SWEEP_LANES as LANES
from ..language.vectors import load
from ..node_places import PLACES
from ..pair_places import FIRST_ENTRY, MASTERS, ROWS, SLAVES
from .control import PAIR_STEP, STATS
from .massless_node import square
from .neighbours import neighbour_forces
from .node_basis import into_basis, into_motion, part, put, set_basis

POWER = 12  # iterations that estimate the largest eigenvalue
SAFETY = 1.9 / 1.1  # length of a step times the estimate
MANY = 100.0  # products of a solve after which the length is estimated anew


@ti.func
def multiply_coupled(
    contact: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    system: ti.template(),
    island,
    block: ti.template(),
):
    """Set the product of all packs of an island with T^t K T, in the bases of the nodes.

    The motion of every node in its basis stands in `increment`.
    """
    at = ti.static(PLACES[block])
    stride = system.stiffness.shape[0]
    starts = ti.static(system.pack_start)
    spread(coupling, contact, rows, system.increment, 0, stride, block)
    for pack in range(first_pack(contact, island), first_pack(contact, island + 1)):
        node, count = starts[pack], starts[pack + 1] - starts[pack]
        force = neighbour_forces(system, pack, block)
        moved = part(system, system.increment, node, 0, block)
        for i, j in ti.static(ti.ndrange(block, block)):
            force[i] += load(system.response, node + (at.diagonal + i * block + j) * stride, LANES) * moved[j]
        put(system, system.response, node, count, at.product, block, force)
    collect(coupling, contact, rows, system.response, at.product * stride, stride, block)
    for pack in range(first_pack(contact, island), first_pack(contact, island + 1)):
        node, count = starts[pack], starts[pack + 1] - starts[pack]
        force = part(system, system.response, node, at.product, block)
        put(system, system.response, node, count, at.product, block, into_basis(system, node, force, block))


@ti.func
def precondition(
    contact: ti.template(), rows: ti.template(), coupling: ti.template(), system: ti.template(), block: ti.template()
):
    """Set `System.inverse`, the inverse of the diagonal blocks D of all nodes."""
    at = ti.static(PLACES[block])
    stride = system.stiffness.shape[0]
    count, number = node_count(contact), coupling.lists[ROWS]
    for k in range(count):
        for i in ti.static(range(block * block)):
            system.inverse[i * stride + k] = system.response[(at.diagonal + i) * stride + k]
    for back in range(number):
        r = number - 1 - back
        k = entry(coupling, SLAVES, r)
        normal = normal_of(rows, pair_row(rows, k))
        lift, size = lift_of(contact, rows, k, normal, block)
        stiffness = lift.dot(square(system.inverse, k, stride, block) @ lift) / (size * size)
        for i in range(entry(coupling, FIRST_ENTRY, r), entry(coupling, FIRST_ENTRY, r + 1)):
            m = entry(coupling, MASTERS, i)
            if m < count:
                there = weight(coupling, i) * along(contact, m, normal, block)
                for a, b in ti.static(ti.ndrange(block, block)):
                    place = (a * block + b) * stride + m
                    system.inverse[place] = system.inverse[place] + stiffness * there[a] * there[b]
    for k in range(count):
        inverse = square(system.inverse, k, stride, block).inverse()
        for i, j in ti.static(ti.ndrange(block, block)):
            system.inverse[(i * block + j) * stride + k] = inverse[i, j]


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
    stats, starts = ti.static(system.stats, system.pack_start)
    stride, place = system.stiffness.shape[0], island * STATS
    result = alone
    if coupling.lists[ROWS] > 0:
        if stats[place + PAIR_STEP] == 0.0:
            first, end = first_pack(contact, island), first_pack(contact, island + 1)
            for pack in range(first, end):
                set_basis(system, starts[pack], starts[pack + 1] - starts[pack], block, contact.options.bounds)
            for k in range(first_node(contact, island), first_node(contact, island + 1)):
                for j in ti.static(range(block)):  # any vector that no symmetry makes special
                    system.response[(at.direction + j) * stride + k] = ti.sin(1.0 + 7.0 * k + 3.0 * j)
            largest = 1.0
            for _ in range(POWER):
                total = 0.0
                for pack in range(first, end):
                    node, count = starts[pack], starts[pack + 1] - starts[pack]
                    direction = part(system, system.response, node, at.direction, block)
                    put(system, system.increment, node, count, 0, block, into_motion(system, node, direction, block))
                multiply_coupled(contact, rows, coupling, system, island, block)
                before = 0.0
                for k in range(first_node(contact, island), first_node(contact, island + 1)):
                    for j in ti.static(range(block)):
                        one = system.response[(at.direction + j) * stride + k]
                        two = system.response[(at.product + j) * stride + k]
                        before += one * one
                        total += two * two
                largest = ti.sqrt(total / before)
                for k in range(first_node(contact, island), first_node(contact, island + 1)):
                    for j in ti.static(range(block)):
                        two = system.response[(at.product + j) * stride + k]
                        system.response[(at.direction + j) * stride + k] = two / ti.sqrt(total)
            stats[place + PAIR_STEP] = SAFETY / largest
        result = stats[place + PAIR_STEP]
    return result
