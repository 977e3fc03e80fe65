"""Record of a material law: its functions and parameters. Each law is one file that ends with `LAW = Law(...)`.

With H = grad u, F = I + H, J = det F, E = (F^t F - I)/2 (METHOD 0) a law gives, per reference volume,

    update(H, parameters[, old]) -> [P, W, J - 1[, new]]      P = dW/dF [Pa], W [J/m^3]

in 3x3 lists, without branches or library calls: entries are scalars or vectors of lanes (one cell or several at once).
All terms are formed from H and J - 1 directly, not from the differences F - I or J minus one, so that stress and energy
stay accurate at a strain of 1e-9. Quadrature weights are applied by the element, outside the law.

`parameters` are those of the material (tcontact/scene/materials.py), in its order. The first belongs to the volume
change (mean dilatation replaces it by 0 and applies it per cell), and `modulus(parameters)` is lambda + 2 mu at small
strains (hourglass stiffness). A law with `state` has these numbers at every quadrature point, 0 at the start: `old` is
the list of the stored values, `new` the values after the step.
"""

from typing import Any, NamedTuple

from ..engine import ti


class Tangent(NamedTuple):
    """Functions of one part of A_ab = G_a . d2W/dF dF . G_b, the stiffness between two corners with G = grad N.

    point(F, parameters, pressure[, old]) -> data; corner(data, G_a) -> a; pair(data, G_a, G_b, a, b) -> A_ab [3, 3].
    pressure: of the cell if it has one volume change, with parameters[0] = 0; else 0. form: names what the data of a
    `tangent_form` holds, "rest" or "plain"; "" of another tangent.
    """

    point: Any
    corner: Any
    pair: Any
    form: str = ""


class StepLaw(NamedTuple):
    """Functions of a law for implicit schemes (kernels/cells/implicit_rules.py), of E [3, 3] and j = J - 1; S = dW/dE.

    energy(E, j, parameters); stress(E, j, parameters) -> S; stress_change(E, j, parameters, along): the derivative of
    S along a change of E; discrete(E0, E1, dE, j0, j1, parameters) -> S* with S* : dE = W1 - W0, and its derivative
    discrete_change(.., along, growth) along a change of E1 that makes J1 grow by `growth`; None: no such stress.
    """

    energy: Any
    stress: Any
    stress_change: Any
    discrete: Any = None
    discrete_change: Any = None


@ti.func
def lame_modulus(parameters):
    """Return lambda + 2 mu of a law whose parameters begin with lambda and mu."""
    return parameters[0] + 2.0 * parameters[1]


class Plastic(NamedTuple):
    """Functions of a law with plastic flow, whose `update` takes one more argument and returns one more number.

    update(H, parameters, old, pressure) -> [.., new, dissipation]: pressure: of the cell [U' [Pa], mean of J - 1], or
    [] where every point has its own; dissipation [J/m^3] of the step. With a pressure of the cell P and W are those of
    the change of shape alone, and the cell adds volume(change, parameters, old) -> [pressure U', energy U, slope U'']
    of that mean. secant(old, parameters): ratio of the secant modulus to the elastic one, for the hourglass stiffness.
    heated(old, parameters, rise) -> numbers of the state from the temperature rise on, after heat that raises the
    temperature by `rise` [K]. strain, warming: places in the state of plastic strain and temperature rise; share,
    initial_temperature, strength: places of these among the parameters (strength: of the yield stress, which products
    set to HIGH so that nothing yields). rates: the parameters are followed by the length of the step that ends at the
    present state [s]. always: the state of points that do not flow changes too, as their temperature does.
    """

    volume: Any
    secant: Any
    heated: Any
    strain: int
    warming: int
    share: int
    initial_temperature: int
    strength: int
    rates: bool = False
    always: bool = False


HIGH = 1e100  # a yield stress [Pa] that is never reached, over the modulus


class Law(NamedTuple):
    """A material law; parameters, state: names of its parameters and of its state at a quadrature point.

    tangents: parts whose sum is the second derivative; step: functions for implicit schemes, None: refused there;
    linear: stress and strain are those of small strains; refusal: message that says where the law loses ellipticity and
    what to use instead. With "" it never does, and equilibria are not checked for a positive definite tangent.
    modulus(parameters): lambda + 2 mu at small strains; plastic: functions of a law with plastic flow.
    """

    parameters: tuple[str, ...]
    update: Any
    tangents: tuple[Tangent, ...]
    step: StepLaw | None = None
    linear: bool = False
    state: tuple[str, ...] = ()
    refusal: str = ""
    modulus: Any = lame_modulus
    plastic: Plastic | None = None

    @property
    def rates(self) -> bool:
        """Return whether the length of the step follows the parameters."""
        return self.plastic is not None and self.plastic.rates


@ti.func
def moved_corner(data, g):
    """Return a = M G_a."""
    return data[0] @ g


@ti.func
def pair_of_form(data, ga, gb, a, b):
    """Return (G_a . T G_b) I + c1 b x a + c2 a x b."""
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
    """Return the form with (G_a . G_b) R added."""
    return pair_of_form(data, ga, gb, a, b) + ga.dot(gb) * data[4]


def tangent_form(point: Any, rest: bool = False) -> Tangent:
    """Return the Tangent A_ab = (G_a . T G_b) I + c1 b x a + c2 a x b [+ (G_a . G_b) R], a = M G_a, b = M G_b.

    point(F, parameters, pressure) -> [M, T, c1, c2[, R]]; rest: with R.
    """
    if rest:
        return Tangent(point, moved_corner, pair_with_rest, "rest")
    return Tangent(point, moved_corner, pair_of_form, "plain")
