"""Points of integration: what one of them adds to the force of its cell, for every kind of element.

    H = G A^-1 = G (cof A)^t / D,    dW/dG = D P A^-t = P cof A,    G = du/dr,  A = dX/dr,  D = det A

Weights are applied once to the forces and the energy of a cell, outside the law.

Written in plain arithmetic on nested lists [component][corner]: an entry may be a scalar (one cell) or a `ti.Vector`
of lanes (that many cells at once, one SIMD value of the machine). Nothing here knows of packs or arrays.
Unary minus and `ti.bit_cast` do not compile for vectors in Taichi 1.7.4: write 0.0 - a, use `tensor3.to_bits`.
Displacement differences to corners of the same cell come first, never sums of displacements (METHOD 6).
"""

import taichi as ti

from ..language import tensor3
from ..language.point_memory import respond


@ti.func
def geometry(a):
    """[cof A, cof A / det A, det A] of a[c][j] = dX_c/dr_j."""
    m = tensor3.cofactor(a)
    d = tensor3.determinant(a, m)
    return [m, tensor3.scaled(1.0 / d, m), d]


@ti.func
def point_force(g, shape, parameters, law: ti.template(), memory: ti.template(), point):
    """One Gauss point, of weight 1: [dW/dG as [component][direction], energy, det F - 1].

    g[c][j] = du_c/dr_j, shape: its `geometry`; law: the update of a law (materials/law.py) with its parameters; memory:
    what its points keep, point: the number of this one (point_memory.py).
    """
    answer = respond(law, tensor3.product_transposed(g, shape[1]), parameters, memory, point)
    return [tensor3.product(answer[0], shape[0]), shape[2] * answer[1], answer[2]]


def with_jacobian(force, jacobian_of):
    """The force function of an element from one that asks how to get A (`hex_gradients`, `affine_gradients`)."""

    @ti.func
    def force_of(x, u, weight, parameters, law: ti.template(), memory: ti.template()):
        return force(x, u, weight, parameters, law, memory, jacobian_of)

    return force_of


@ti.func
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@ti.func
def plus(a, b):
    return [a[0] + b[0], a[1] + b[1], a[2] + b[2]]


@ti.func
def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
