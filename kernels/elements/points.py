"""Integration points: contribution of one point to the force of its cell, for every kind of element.

    H = G A^-1 = G (cof A)^t / D,    dW/dG = D P A^-t = P cof A,    G = du/dr,  A = dX/dr,  D = det A

Weights are applied to the forces and the energy of a cell, outside the law.

Elements use plain arithmetic on nested lists [component][corner]: an entry is a scalar (one cell) or a `ti.Vector` of
lanes (several cells, one SIMD value); packs and arrays do not appear. Unary minus and `ti.bit_cast` do not compile for
vectors in Taichi 1.7.4: write 0.0 - a, use `tensor3.to_bits`. Differences of displacements within a cell are formed
first, never sums of displacements (METHOD 6).
"""

from ..engine import ti
from ..language import tensor3
from ..language.point_memory import respond


@ti.func
def geometry(a):
    """Return [cof A, cof A / det A, det A] of a[c][j] = dX_c/dr_j."""
    m = tensor3.cofactor(a)
    d = tensor3.determinant(a, m)
    return [m, tensor3.scaled(1.0 / d, m), d]


@ti.func
def point_force(g, shape, parameters, law: ti.template(), memory: ti.template(), point):
    """Return [dW/dG as [component][direction], energy, det F - 1] of one Gauss point of weight 1.

    g[c][j] = du_c/dr_j; shape: `geometry` of the point; law: a law (materials/law.py), parameters: its parameters;
    memory: state of its points, point: number of this point (point_memory.py).
    """
    answer = respond(law, tensor3.product_transposed(g, shape[1]), parameters, memory, point, shape[2])
    return [tensor3.product(answer[0], shape[0]), shape[2] * answer[1], answer[2]]


def of_shape(force, shape):
    """Return a force function with its shape of cells fixed (hex8_shapes.py)."""

    @ti.func
    def force_of(x, u, weight, parameters, law: ti.template(), memory: ti.template()):
        return force(x, u, weight, parameters, law, memory, shape)

    return force_of


@ti.func
def dot(a, b):
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@ti.func
def plus(a, b):
    """Return a + b."""
    return [a[0] + b[0], a[1] + b[1], a[2] + b[2]]


@ti.func
def cross(a, b):
    """Return a x b."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
