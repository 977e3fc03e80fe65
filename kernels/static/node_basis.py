"""Bases of contact nodes in which their diagonal block of K is the identity and their row is a bound (METHOD 2).

    D_k^-1 = M M^t,   d_k = T z_k with T = M (1 - w w^t),   (1 - w w^t) M^t n = |M^t n| e_1:

    T^t D_k T = 1,   g_k + n.d_k >= 0 becomes z_k1 >= -g_k / |M^t n|,   a force f becomes T^t f

M is lower triangular (Cholesky), 1 - w w^t with |w|^2 = 2 a Householder reflection. The sign of the first column of M
is chosen so that the first component of M^t n is at most 0: w then does not suffer from cancellation. A node whose row
exerts no force in its massless components (n = 0) has no bound. Nodes with several rows have other bases
(several_bounds.py). All functions work on the nodes of one pack: values are
vectors over the lanes; lanes beyond the pack are computed but neither stored nor summed. Where threads share the nodes
a pack is one node.
"""

from ..engine import ti
from ..language.tensor3 import cofactor, determinant
from ..language.vectors import load, store
from ..node_places import PLACES
from .several_bounds import UNBOUNDED, set_several_bounds


@ti.func
def lanes_inside(system: ti.template(), count):
    """Return which lanes of a pack stand for one of its `count` nodes."""
    return ti.Vector(system.lane_numbers) < count


@ti.func
def zeros(system: ti.template()):
    """Return 0 in every lane."""
    return ti.Vector([0.0 for _ in range(system.lanes)])


@ti.func
def part(system: ti.template(), values: ti.template(), node, first: ti.template(), block: ti.template()):
    """Return components first, first + 1, ... [block] of the pack that begins with `node`."""
    return [load(values, node + (first + i) * system.stiffness.shape[0], system.lanes) for i in range(block)]


@ti.func
def put(system: ti.template(), values: ti.template(), node, count, first: ti.template(), block: ti.template(), new):
    """Store components first, first + 1, ... [block] of the `count` nodes of a pack."""
    inside = lanes_inside(system, count)
    for i in ti.static(range(block)):
        place = node + (first + i) * system.stiffness.shape[0]
        store(values, place, ti.select(inside, new[i], load(values, place, system.lanes)), system.lanes)


@ti.func
def into_motion(system: ti.template(), node, vector, block: ti.template()):
    """Return the displacement d = T z."""
    at = ti.static(PLACES[block])
    basis = part(system, system.response, node, at.basis, block * block)
    return combined(basis, 1, block, vector, block)


@ti.func
def into_basis(system: ti.template(), node, force, block: ti.template()):
    """Return the force T^t f in the basis."""
    at = ti.static(PLACES[block])
    basis = part(system, system.response, node, at.basis, block * block)
    return combined(basis, block, 1, force, block)


@ti.func
def into_force(system: ti.template(), node, gradient, block: ti.template()):
    """Return the force f = T^-t gradient [N]."""
    at = ti.static(PLACES[block])
    inverse = part(system, system.response, node, at.inverse, block * block)
    return combined(inverse, 1, block, gradient, block)


@ti.func
def combined(matrix, along: ti.template(), across: ti.template(), vector, block: ti.template()):
    """Return the product of a matrix and a vector; entry (i, j) stands at i * across + j * along.

    The strides (along, across) are (1, block) for the matrix and (block, 1) for its transpose.
    """
    result = [matrix[i * across] * vector[0] for i in range(block)]
    for i in ti.static(range(block)):
        for j in ti.static(range(1, block)):
            result[i] += matrix[i * across + j * along] * vector[j]
    return result


@ti.func
def lower_triangle(matrix, zero, block: ti.template()):
    """Return the lower triangle M of M M^t = matrix, row by row (Cholesky); zero: in every lane."""
    result = [zero for _ in range(block * block)]
    for j in ti.static(range(block)):
        for i in ti.static(range(j, block)):
            rest = matrix[i * block + j]
            for m in ti.static(range(j)):
                rest = rest - result[i * block + m] * result[j * block + m]
            if ti.static(i == j):
                result[i * block + j] = ti.sqrt(rest)
            else:
                result[i * block + j] = rest / result[j * block + j]
    return result


@ti.func
def inverse_transposed(a, block: ti.template()):
    """Return a^-t, row by row."""
    result = [1.0 / a[0] for _ in range(block * block)]
    if ti.static(block == 3):
        rows = [[a[3 * i + j] for j in range(3)] for i in range(3)]
        minors = cofactor(rows)
        for i, j in ti.static(ti.ndrange(3, 3)):
            result[3 * i + j] = minors[i][j] / determinant(rows, minors)
    return result


@ti.func
def set_basis(system: ti.template(), node, count, block: ti.template(), bounds: ti.template()):
    """Set T, T^-t and the bounds of a pack of nodes from D_k^-1, n and g; bounds: the most that a node has."""
    at = ti.static(PLACES[block])
    zero = zeros(system)
    basis = lower_triangle(part(system, system.inverse, node, 0, block * block), zero, block)
    across = combined(basis, block, 1, part(system, system.normals, node, 0, block), block)  # M^t n, then w
    turned = across[0] > 0.0
    across[0] = ti.select(turned, zero - across[0], across[0])
    square = across[0] * across[0]
    for i in ti.static(range(1, block)):
        square += across[i] * across[i]
    length = ti.sqrt(square)
    across[0] = across[0] - length
    scale = ti.sqrt(2.0 / ti.max(square - 2.0 * length * (across[0] + length) + square, 1e-300))
    for i in ti.static(range(block)):
        across[i] = scale * across[i]
        basis[i * block] = ti.select(turned, zero - basis[i * block], basis[i * block])
    reflected = combined(basis, 1, block, across, block)
    for i, j in ti.static(ti.ndrange(block, block)):
        basis[i * block + j] = basis[i * block + j] - reflected[i] * across[j]
    gap = load(system.gaps, node, system.lanes)
    bound = [ti.select(length > 0.0, (zero - gap) / ti.max(length, 1e-300), zero + UNBOUNDED)]
    put(system, system.response, node, count, at.basis, block * block, basis)
    put(system, system.response, node, count, at.inverse, block * block, inverse_transposed(basis, block))
    put(system, system.response, node, count, at.bound, 1, bound)
    if ti.static(bounds > 1):
        for k in range(node, node + count):
            set_several_bounds(system, k, bounds)
