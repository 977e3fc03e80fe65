"""What a law consists of. Each law is one file of this package that ends with `LAW = Law(...)`; its name is the file's.

With H = grad u, F = I + H, J = det F, E = (F^t F - I)/2 (METHOD 0) a law answers, per reference volume,

    update(H, parameters[, old]) -> [P, W, J - 1[, new]]      P = dW/dF [Pa], W [J/m^3]

in 3x3 lists, without branches or library calls: entries are scalars or vectors of lanes (one cell or several at once).
Everything is put together from H and J - 1, never from F - I or J minus one, so that at a strain of 1e-9 the stress
keeps its digits and the energy is still a square. Quadrature weights are applied by the element, outside the law.

`parameters` are those of the material (tcontact/scene/materials.py), in its order. The first belongs to the volume
change
(mean dilatation takes it out and applies it per cell), and parameters[0] + 2 parameters[1] is lambda + 2 mu at small
strains (hourglass stiffness). A law with `state` keeps these numbers at every quadrature point, 0 at the start: `old`
is the list of the committed ones, `new` what they become if the step is committed.
"""

from typing import Any, NamedTuple

import taichi as ti


class Tangent(NamedTuple):
    """A part of A_ab = G_a . d2W/dF dF . G_b, the stiffness between two corners with G = grad N at a point.

    point(F, parameters, pressure[, old]) -> data; corner(data, G_a) -> a; pair(data, G_a, G_b, a, b) -> A_ab [3, 3].
    pressure: with one volume change per cell that of the cell, at parameters[0] = 0; else 0.
    """

    point: Any
    corner: Any
    pair: Any


class StepLaw(NamedTuple):
    """What implicit schemes ask of a law (kernels/cells/implicit_rules.py), in E [3, 3] and j = J - 1, S = dW/dE.

    energy(E, j, parameters); stress(E, j, parameters) -> S; stress_change(E, j, parameters, along): the derivative of
    S along a change of E; discrete(E0, E1, dE, j0, j1, parameters) -> S* with S* : dE = W1 - W0, and its derivative
    discrete_change(.., along, growth) along a change of E1 that makes J1 grow by `growth`; None: no such stress.
    """

    energy: Any
    stress: Any
    stress_change: Any
    discrete: Any = None
    discrete_change: Any = None


class Law(NamedTuple):
    """A law by its functions; parameters, state: names of the numbers it takes and keeps.

    tangents: parts whose sum is the second derivative; step: for implicit schemes, None = they refuse the law;
    linear: stress and strain are those of small strains; refusal: where the law stops to be elliptic, and what to use
    instead; "" if it does not: then an equilibrium need not be checked for a tangent that is not positive definite.
    """

    parameters: tuple[str, ...]
    update: Any
    tangents: tuple[Tangent, ...]
    step: StepLaw | None = None
    linear: bool = False
    state: tuple[str, ...] = ()
    refusal: str = ""


@ti.func
def moved_corner(data, g):
    return data[0] @ g


@ti.func
def pair_of_form(data, ga, gb, a, b):
    same = ga.dot(data[1] @ gb)
    c1, c2 = data[2], data[3]
    return ti.Matrix(
        [
            [c1 * b[i] * a[j] + c2 * a[i] * b[j] + (same if ti.static(i == j) else 0.0) for j in ti.static(range(3))]
            for i in ti.static(range(3))
        ]
    )


@ti.func
def pair_with_rest(data, ga, gb, a, b):
    return pair_of_form(data, ga, gb, a, b) + ga.dot(gb) * data[4]


def tangent_form(point: Any, rest: bool = False) -> Tangent:
    """Return A_ab = (G_a . T G_b) I + c1 b x a + c2 a x b [+ (G_a . G_b) R] with a = M G_a, b = M G_b.

    point(F, parameters, pressure) -> [M, T, c1, c2[, R]]; rest: with an R.
    """
    return Tangent(point, moved_corner, pair_with_rest if rest else pair_of_form)
