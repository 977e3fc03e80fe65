"""Bases of contact nodes with two or three rows, in which every row is a bound on one component (METHOD 7).

    B = [n_1; n_2; n_3],  d = T z with T = B^-1 S:   g_i + n_i.d >= 0 becomes z_i >= -g_i / s_i

With two rows n_3 = D (n_1 x n_2), so that the third component is free and not coupled with the others in D. The scales
s_i = (A_ii sum_j |A_ij| / (A_ii A_jj)^1/2)^-1/2 with A = B^-t D B^-1 leave no eigenvalue of T^t D T above 1: the length
of a projected step is that of nodes with one row, whose T^t D T is the identity (node_basis.py).
"""

from ..engine import ti
from ..node_places import PLACES
from .massless_node import entries, square

UNBOUNDED = -1e300
SIZE = 3  # a node with fewer components has no two independent rows


@ti.func
def row_of(contact: ti.template(), system: ti.template(), k, i: ti.template(), block: ti.template()):
    """Return the row of node k to which bound i belongs."""
    row = 0
    if ti.static(contact.options.slots > 1):
        row = int(system.response[ti.static(PLACES[block].rows[i]) * system.stiffness.shape[0] + k])
    return row


@ti.func
def set_several_bounds(system: ti.template(), k, bounds: ti.template()):
    """Set T, T^-t and the bounds of node k if it has two rows or more, else that it has no second and third bound."""
    at = ti.static(PLACES[SIZE])
    stride = system.stiffness.shape[0]
    first, second = entries(system.normals, k, stride, 0, SIZE), entries(system.normals, k, stride, SIZE, SIZE)
    bounded = ti.Vector([0 for _ in range(SIZE)])
    scale = ti.Vector.one(ti.f64, SIZE)
    if second.norm_sqr() > 0.0:
        stiffness = square(system.inverse, k, stride, SIZE).inverse()
        across = first.cross(second)
        third = stiffness @ across
        bounded = ti.Vector([1, 1, 0])
        if ti.static(bounds == SIZE):
            last = entries(system.normals, k, stride, 2 * SIZE, SIZE)
            if last.norm_sqr() > 0.0:
                third, bounded[2] = last, 1
        rows = ti.Matrix.rows([first, second, third / third.norm()])
        basis = rows.inverse()
        turned = basis.transpose() @ stiffness @ basis
        for i in ti.static(range(SIZE)):
            total = 0.0
            for j in ti.static(range(SIZE)):
                total += ti.abs(turned[i, j]) / ti.sqrt(turned[i, i] * turned[j, j])
            scale[i] = 1.0 / ti.sqrt(turned[i, i] * total)
        for i, j in ti.static(ti.ndrange(SIZE, SIZE)):
            system.response[(at.basis + i * SIZE + j) * stride + k] = basis[i, j] * scale[j]
            system.response[(at.inverse + i * SIZE + j) * stride + k] = rows[j, i] / scale[j]
        system.response[at.bound * stride + k] = (0.0 - system.gaps[k]) / scale[0]
    for i in ti.static(range(1, bounds)):
        bound = UNBOUNDED
        if bounded[i] == 1:
            bound = (0.0 - system.gaps[i * stride + k]) / scale[i]
        system.response[ti.static(at.bounds[i]) * stride + k] = bound
