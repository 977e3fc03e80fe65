"""A law from the formula of its strain energy W alone: stress and tangents are derived here.

    P = dW/dH (backward in one pass),  C = dP/dH,  A_ab = G_a . C . G_b;  for implicit schemes S = dW/dE and dS/dE

`traced_energy` calls the formula with symbols. J has slopes of its own, dJ/dH = cof F and dJ/dE = cof C/J. Stress and
energy are formed as small_strains.py says, so that a formula of F keeps its digits at small strains. Where the argument
of a logarithm or a root, or a divisor, has passed 0, the law has no meaning: `update` returns BEYOND as J - 1, which
stops a run as an inverted cell does. The last parameter is the modulus of the hourglass stiffness.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from ..engine import ti
from ..language.emission import body, function
from ..language.expressions import Derivative, Expression
from ..language.small_strains import SmallStrains
from ..language.traced_energy import SIDES, Traced, traced
from .law import Law, StepLaw, Tangent

BEYOND = -2.0
LIMITED = ("log", "sqrt", "inverse_cube_root", "inverse")


def nested(texts: Sequence[str], side: int = 3) -> str:
    """Return the text of a matrix from those of its entries."""
    rows = [", ".join(texts[side * i : side * (i + 1)]) for i in range(len(texts) // side)]
    return "[" + ", ".join(f"[{row}]" for row in rows) + "]"


def symbols(count: int, **places: str) -> dict[str, str]:
    """Return the texts of the parameters, and of 3x3 symbols by their letter: {letter: text with {i} and {j}}."""
    found = {f"p{k}": f"parameters[{k}]" for k in range(count)}
    for letter, text in places.items():
        found |= {f"{letter}{i}{j}": text.format(i=i, j=j) for i, j in SIDES}
    return found


class OwnLaw(NamedTuple):
    """A law for the kernels, and the text that tells it from others."""

    law: Law
    formula: str


def update_source(at: Traced, count: int) -> str:
    """Return the lines of `update`."""
    small = SmallStrains(at.graph)
    stress = [small.parts(slope).change for slope in at.graph.gradient(at.energy, at.strain)]
    energy, change = small.beyond(at.energy), small.parts(at.volume).change
    limits = []
    for a in at.graph.reachable([at.energy]):
        own = small.parts(a.parts[0]) if a.operation in LIMITED else None
        if own is not None and own.change is not at.graph.of(0.0) and a.parts[0] is not at.volume:
            limits.append(at.graph.product(own.value, own.rest))
    limits = list(dict.fromkeys(limits))

    def answer(texts: list[str]) -> str:
        lines = f"    change = {texts[10]}\n"
        for text in texts[11:]:
            lines += f"    change = ti.select({text} > 0.0, change, 0.0 * change + ({BEYOND}))\n"
        return lines + f"    return [{nested(texts[:9])}, {texts[9]}, change]\n"

    roots = [*stress, energy, change, *limits]
    return body(at.graph, roots, symbols(count, h="h[{i}][{j}]"), answer)


def tangent_source(at: Traced, count: int) -> str:
    """Return the lines of `point`: the blocks C_ik[j, l] of i, k = 00, 01, 02, 11, 12, 22."""
    g = at.graph
    whole = g.sum(at.energy, g.product(g.symbol("q"), at.volume))  # the pressure of the cell is that of q J
    stress = g.gradient(whole, at.strain)
    slopes = [Derivative(g, {one: g.of(1.0)}) for one in at.strain]
    roots = []
    for i, k in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
        for j, l in SIDES:  # noqa: E741
            row, column = (3 * i + j, 3 * k + l) if (i, j) <= (k, l) else (3 * k + l, 3 * i + j)
            roots.append(slopes[column](stress[row]))

    def answer(texts: list[str]) -> str:
        parts = ", ".join(f"ti.Matrix({nested(texts[9 * b : 9 * b + 9])})" for b in range(6))
        return f"    return [{parts}]\n"

    texts = symbols(count) | {"q": "pressure"}
    texts |= {f"h{i}{j}": f"f[{i}, {j}]" + (" - 1.0" if i == j else "") for i, j in SIDES}
    return body(g, g.plain(roots), {name: f"({text})" for name, text in texts.items()}, answer)


@ti.func
def corner(data, g):
    """Return the gradient itself."""
    return g


@ti.func
def pair(data, ga, gb, a, b):
    m01, m02, m12 = ga.dot(data[1] @ gb), ga.dot(data[2] @ gb), ga.dot(data[4] @ gb)
    m10, m20, m21 = gb.dot(data[1] @ ga), gb.dot(data[2] @ ga), gb.dot(data[4] @ ga)
    return ti.Matrix(
        [
            [ga.dot(data[0] @ gb), m01, m02],
            [m10, ga.dot(data[3] @ gb), m12],
            [m20, m21, ga.dot(data[5] @ gb)],
        ]
    )


def step_law(at: Traced, count: int) -> StepLaw:
    """Return the functions for implicit schemes of an energy of E."""
    g = at.graph
    small = SmallStrains(g)
    slopes = g.gradient(at.energy, at.strain)
    both = [0.5 * (slopes[3 * i + j] + slopes[3 * j + i]) for i, j in SIDES]
    along = Derivative(g, {one: g.symbol(f"a{i}{j}") for one, (i, j) in zip(at.strain, SIDES, strict=True)})
    texts = symbols(count, e="e[{i}, {j}]", a="along[{i}, {j}]") | {"j": "j"}

    def made(name: str, more: str, roots: list[Expression], matrix: bool) -> Any:
        def answer(found: list[str]) -> str:
            return f"    return {f'ti.Matrix({nested(found)})' if matrix else found[0]}\n"

        return function(name, f"e, j, parameters{more}", body(g, roots, texts, answer))

    return StepLaw(
        made("energy", "", [small.beyond(at.energy)], False),
        made("stress", "", [small.parts(one).change for one in both], True),
        made("stress_change", ", along", g.plain([along(one) for one in both]), True),
    )


def law_of(name: str, energy: Callable[..., Any], parameters: Sequence[str]) -> OwnLaw:
    """Return the law of an energy(strain, **parameters); parameters: their names, the volumetric one first.

    Raises `NotPlain` for a function that is no plain arithmetic.
    """
    at, count = traced(energy, parameters), len(parameters)
    source = update_source(at, count)
    update = function("update", "h, parameters", source)
    point = function("point", "f, parameters, pressure", tangent_source(at, count))
    own = traced(energy, parameters, of_strain=True)
    last = function("modulus", "parameters", f"    return parameters[{count}]\n")
    refusal = f"the law {name!r} ends at such strains: det F, or the argument of a logarithm, a root or a quotient of"
    refusal += " its energy, is not above 0, or it loses ellipticity; look at its energy, in a shock give the scene"
    refusal += " viscosity=tc.BulkViscosity()"
    step = None if own is None else step_law(own, count)
    law = Law((*parameters, "modulus"), update, (Tangent(point, corner, pair),), step, refusal=refusal, modulus=last)
    return OwnLaw(law, hashlib.sha256(source.encode()).hexdigest()[:16])
