"""The formula of a strain energy, found by a call of its function with symbols; its derivatives as expressions.

Symbols: h00 .. h22 of the displacement gradient H, or e00 .. e22 of Green's strain E and j = J - 1; p0, p1, .. of the
parameters. `Strain` is what the function is given: it serves symbols and numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from .expressions import Expression, Given, Graph, NotPlain

SIDES = [(i, j) for i in range(3) for j in range(3)]


class Traced(NamedTuple):
    """A formula: its graph, its nine symbols of the strain, J, and the energy."""

    graph: Graph
    strain: list[Expression]
    volume: Expression
    energy: Expression


class Strain:
    """The deformation at a point, from which a strain energy is computed; tensors are 3x3 arrays of NumPy.

    H: displacement gradient grad u; F = I + H; C = F^t F; E = (C - I)/2, Green's strain; J = det F; I1 = tr C;
    I2 = ((tr C)^2 - tr C^2)/2; I1_bar = J^(-2/3) I1 and I2_bar = J^(-4/3) I2, which a change of volume alone does not
    change. Without deformation F = C = I, J = 1 and all invariants are 3. An energy of C, E, J and invariants does not
    depend on rotations; one that uses H or F is not available to implicit schemes.
    """

    def __init__(self, gradient: Any = None, strain: Any = None, volume: Any = None) -> None:
        self._gradient, self._strain, self._volume = gradient, strain, volume

    @property
    def H(self) -> Any:
        """Displacement gradient [3, 3]."""
        if self._gradient is None:
            raise NotPlain("it uses H or F")
        return np.array(self._gradient)

    @property
    def F(self) -> Any:
        """Deformation gradient [3, 3]."""
        return self.H + np.eye(3)

    @property
    def C(self) -> Any:
        """Right Cauchy-Green tensor [3, 3]."""
        return 2.0 * self.E + np.eye(3)

    @property
    def E(self) -> Any:
        """Green's strain [3, 3]."""
        if self._strain is None:
            h = self.H
            self._strain = 0.5 * (h + h.T + h.T @ h)
        return np.array(self._strain)

    @property
    def J(self) -> Any:
        """Volume ratio det F."""
        if self._volume is None:
            h = self.H
            turned = cofactor(h)
            self._volume = 1.0 + (trace(h) + (trace(turned) + determinant(h, turned)))
        return self._volume

    @property
    def I1(self) -> Any:
        """First invariant tr C."""
        return trace(self.C)

    @property
    def I2(self) -> Any:
        """Second invariant ((tr C)^2 - tr C^2)/2."""
        return trace(cofactor(self.C))

    @property
    def I1_bar(self) -> Any:
        """First invariant of J^(-2/3) C."""
        return self.J ** (-2.0 / 3.0) * self.I1

    @property
    def I2_bar(self) -> Any:
        """Second invariant of J^(-2/3) C."""
        return self.J ** (-4.0 / 3.0) * self.I2


def trace(a: Any) -> Any:
    """Return tr a."""
    return a[0][0] + a[1][1] + a[2][2]


def cofactor(a: Any) -> Any:
    """Return cof a = det(a) a^-t."""

    def minor(i: int, j: int) -> Any:
        k, m, n, o = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
        return a[k][n] * a[m][o] - a[k][o] * a[m][n]

    return [[minor(i, j) for j in range(3)] for i in range(3)]


def determinant(a: Any, turned: Any) -> Any:
    """Return det a from a and its cofactor."""
    return a[0][0] * turned[0][0] + a[0][1] * turned[0][1] + a[0][2] * turned[0][2]


def gradient_symbols(graph: Graph) -> tuple[Any, Expression]:
    """Return H [3][3] and J with dJ/dH = cof F = (1 + tr H) I - H^t + cof H."""
    h = [[graph.symbol(f"h{i}{j}") for j in range(3)] for i in range(3)]
    turned = cofactor(h)
    linear = trace(h)
    beyond = trace(turned) + determinant(h, turned)
    slopes = [(h[i][j], turned[i][j] - h[j][i] + ((1.0 + linear) if i == j else 0.0)) for i, j in SIDES]
    return h, graph.given("J", Given(graph.of(1.0), linear, beyond, slopes))


def strain_symbols(graph: Graph) -> tuple[Any, Expression]:
    """Return E [3][3] and J with dJ/dE = cof C/J."""
    e = [[graph.symbol(f"e{i}{j}") for j in range(3)] for i in range(3)]
    c = [[e[i][j] * 2.0 + (1.0 if i == j else 0.0) for j in range(3)] for i in range(3)]
    linear, slopes = trace(e), list[tuple[Expression, Expression]]()
    volume = graph.given("J", Given(graph.of(1.0), linear, graph.symbol("j") - linear, slopes))
    turned = cofactor(c)
    slopes += [(e[i][j], turned[i][j] / volume) for i, j in SIDES]
    return e, volume


def traced(energy: Callable[..., Any], parameters: Sequence[str], of_strain: bool = False) -> Any:
    """Return the formula of energy(strain, **parameters) in H, or in E: then None if it uses H or F.

    Raises `NotPlain` for a function that is no plain arithmetic.
    """
    graph = Graph()
    if of_strain:
        symbols, volume = strain_symbols(graph)
        strain = Strain(strain=symbols, volume=volume)
    else:
        symbols, volume = gradient_symbols(graph)
        strain = Strain(gradient=symbols, volume=volume)
    values = {name: graph.symbol(f"p{k}") for k, name in enumerate(parameters)}
    try:
        found = energy(strain, **values)
    except NotPlain:
        if of_strain:
            return None
        raise
    if not isinstance(found, Expression):
        raise NotPlain(f"it returned {type(found).__name__}: return the energy per reference volume, one number")
    return Traced(graph, [symbols[i][j] for i, j in SIDES], volume, found)
