"""Expressions of a formula: numbers, symbols and operations in a graph that holds each of them once.

A function in plain arithmetic is called once with symbols in place of numbers, and leaves its formula behind. Equal
subexpressions are one node, numbers are folded, and factors that are numbers stand in front. Operations:

    number  symbol  sum(a, b)  product(a, b)  inverse 1/a  log  exp  sqrt  inverse_cube_root a^(-1/3)
    given: a node that brings its own value, slopes and parts at small strains (small_strains.py)

NumPy's functions of expressions, and of arrays of them, give expressions. What is no smooth formula raises `NotPlain`:
comparisons, choices, conversions to a float. `slopes` of all operations give derivatives: `gradient` (backward),
`Derivative` (along changes of the symbols).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

THIRDS = 12  # largest number of thirds of an exponent that becomes products of cube roots
PARAMETER = "p"  # first letter of the symbols of parameters; all others are of the strain
POWERS = 8  # largest whole exponent that becomes products


class NotPlain(TypeError):
    """A function does what is no plain arithmetic; the text says what, and what to do instead."""


BRANCH = "it compares or chooses by values: write one smooth formula without `if`, `abs`, `max`, `min`"


def refused(*_: Any, **__: Any) -> Any:
    """Refuse a comparison or a choice."""
    raise NotPlain(BRANCH)


class Expression:
    """A node of a graph; place: its number there, greater than those of its parts."""

    __slots__ = ("graph", "operation", "parts", "place")

    def __init__(self, graph: Graph, place: int, operation: str, parts: tuple[Any, ...]) -> None:
        self.graph, self.place, self.operation, self.parts = graph, place, operation, parts

    def __add__(self, other: Any) -> Any:
        return np.add(self, other)

    def __radd__(self, other: Any) -> Any:
        return np.add(other, self)

    def __sub__(self, other: Any) -> Any:
        return np.subtract(self, other)

    def __rsub__(self, other: Any) -> Any:
        return np.subtract(other, self)

    def __mul__(self, other: Any) -> Any:
        return np.multiply(self, other)

    def __rmul__(self, other: Any) -> Any:
        return np.multiply(other, self)

    def __truediv__(self, other: Any) -> Any:
        return np.divide(self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return np.divide(other, self)

    def __pow__(self, exponent: Any) -> Any:
        return np.power(self, exponent)

    def __rpow__(self, base: Any) -> Any:
        return np.power(base, self)

    def __neg__(self) -> Any:
        return np.negative(self)

    def __pos__(self) -> Any:
        return self

    __lt__ = __le__ = __gt__ = __ge__ = __eq__ = __ne__ = __bool__ = __abs__ = refused  # type: ignore[assignment]
    __hash__ = object.__hash__

    def __float__(self) -> float:
        raise NotPlain("it converts to a number, as `float` and `math.log` do: use numpy.log and the like")

    __int__ = __complex__ = __index__ = __float__  # type: ignore[assignment]

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **keywords: Any) -> Any:
        """Return what a NumPy function makes of expressions and numbers."""
        rule = FUNCTIONS.get(ufunc.__name__)
        if ufunc.__name__ in ("maximum", "minimum", "absolute", "sign", "greater", "less", "where", "fmax", "fmin"):
            raise NotPlain(BRANCH)
        if rule is None or method != "__call__" or keywords:
            raise NotPlain(f"it calls numpy.{ufunc.__name__}; use {', '.join(FUNCTIONS)}")
        if any(isinstance(one, np.ndarray) for one in inputs):
            return np.frompyfunc(lambda *parts: rule(*map(self.graph.of, parts)), len(inputs), 1)(*inputs)
        return rule(*map(self.graph.of, inputs))


class Given(NamedTuple):
    """The value of a node in parts, at rest, linear in the strain and beyond, and its slopes along symbols."""

    rest: Expression
    linear: Expression
    beyond: Expression
    slopes: list[tuple[Expression, Expression]]


class Graph:
    """The nodes of one formula and what is made of it."""

    def __init__(self) -> None:
        self.table: dict[tuple[Any, ...], Expression] = {}
        self.givens: dict[int, Given] = {}

    def node(self, operation: str, *parts: Any) -> Expression:
        """Return the node of this operation, which is made if it is not there."""
        key = (operation, *(part.place if isinstance(part, Expression) else part for part in parts))
        if key not in self.table:
            self.table[key] = Expression(self, len(self.table), operation, parts)
        return self.table[key]

    def known(self, operation: str, *parts: Expression) -> bool:
        """Return whether there is such a node."""
        return (operation, *(part.place for part in parts)) in self.table

    def of(self, value: Any) -> Expression:
        """Return the expression of a number; expressions as they are."""
        if isinstance(value, Expression):
            return value
        try:
            number = float(value)
        except (TypeError, ValueError) as error:
            raise NotPlain(f"it computes with {type(value).__name__}: use numbers and components") from error
        return self.node("number", number + 0.0)  # no negative zero

    def symbol(self, name: str) -> Expression:
        """Return the symbol of this name."""
        return self.node("symbol", name)

    def given(self, name: str, value: Given) -> Expression:
        """Return a node that brings its own value."""
        found = self.node("given", name)
        self.givens[found.place] = value
        return found

    def parted(self, a: Expression) -> tuple[float, Expression]:
        """Return the number and the rest of a product."""
        if a.operation == "number":
            return a.parts[0], self.of(1.0)
        if a.operation == "product" and a.parts[0].operation == "number":
            return a.parts[0].parts[0], a.parts[1]
        return 1.0, a

    def scaled(self, factor: float, a: Expression) -> Expression:
        """Return factor a."""
        own, rest = self.parted(a)
        factor *= own
        if factor == 0.0 or rest.operation == "number":
            return self.of(factor if factor == 0.0 else factor * rest.parts[0])
        return rest if factor == 1.0 else self.node("product", self.of(factor), rest)

    def sum(self, a: Expression, b: Expression) -> Expression:
        """Return a + b."""
        if a.operation == b.operation == "number":
            return self.of(a.parts[0] + b.parts[0])
        (first, left), (second, right) = self.parted(a), self.parted(b)
        if left is right:
            return self.scaled(first + second, left)
        for one, other in ((a, b), (b, a)):
            if one.operation == "number" and one.parts[0] == 0.0:
                return other
            if one.operation == "number" and other.operation == "sum" and other.parts[0].operation == "number":
                return self.sum(self.sum(one, other.parts[0]), other.parts[1])
        a, b = (b, a) if b.operation == "number" or (a.operation != "number" and b.place < a.place) else (a, b)
        return self.node("sum", a, b)

    def product(self, a: Expression, b: Expression) -> Expression:
        """Return a b."""
        (first, left), (second, right) = self.parted(a), self.parted(b)
        if right.operation == "number" or (left.operation != "number" and right.place < left.place):
            left, right = right, left
        if left.operation == "number":
            return self.scaled(first * second, right)
        if right.operation == "inverse" and right.parts[0] is left:
            return self.of(first * second)
        return self.scaled(first * second, self.node("product", left, right))

    def inverse(self, a: Expression) -> Expression:
        """Return 1/a."""
        factor, rest = self.parted(a)
        if factor == 0.0:
            raise NotPlain("it divides by what is always 0")
        if rest.operation == "inverse":
            return self.scaled(1.0 / factor, rest.parts[0])
        return self.scaled(1.0 / factor, rest if rest.operation == "number" else self.node("inverse", rest))

    def power(self, a: Expression, exponent: Any) -> Expression:
        """Return a^exponent; whole exponents and thirds without logarithm."""
        c = self.of(exponent)
        if c.operation != "number":
            return self.exp(self.product(c, self.log(a)))
        value = c.parts[0]
        if value == round(value) and abs(value) <= POWERS:
            return self.whole(a if value > 0.0 else self.inverse(a), round(abs(value)))
        if 2.0 * value == round(2.0 * value) and abs(value) <= POWERS:
            return self.product(self.sqrt(a), self.power(a, value - 0.5))
        thirds = round(3.0 * value)
        if abs(3.0 * value - thirds) < 1e-12 and abs(thirds) <= THIRDS:
            up = max(0, -(-thirds // 3))
            return self.product(self.whole(a, up), self.whole(self.inverse_cube_root(a), 3 * up - thirds))
        return self.exp(self.scaled(value, self.log(a)))

    def whole(self, a: Expression, count: int) -> Expression:
        """Return a^count, count >= 0, by squares."""
        if count == 0:
            return self.of(1.0)
        half = self.whole(a, count // 2)
        square = half if count == 1 else self.product(half, half)
        return self.product(square, a) if count % 2 and count > 1 else a if count == 1 else square

    def log(self, a: Expression) -> Expression:
        """Return ln a."""
        return self._of_number(np.log, "log", a)

    def exp(self, a: Expression) -> Expression:
        """Return exp a."""
        return self._of_number(np.exp, "exp", a)

    def sqrt(self, a: Expression) -> Expression:
        """Return the square root of a."""
        return self._of_number(np.sqrt, "sqrt", a)

    def inverse_cube_root(self, a: Expression) -> Expression:
        """Return a^(-1/3)."""
        return self._of_number(lambda value: value ** (-1.0 / 3.0), "inverse_cube_root", a)

    def _of_number(self, function: Any, operation: str, a: Expression) -> Expression:
        if a.operation != "number":
            return self.node(operation, a)
        value = a.parts[0]
        if value < 0.0 or (value == 0.0 and operation != "sqrt"):
            if operation != "exp":
                raise NotPlain(f"it takes {operation} of {value:g}")
        return self.of(float(function(value)))

    def slopes(self, a: Expression) -> list[tuple[Expression, Expression]]:
        """Return the parts of a node that change, each with the derivative of the node along it."""
        one = self.of(1.0)
        if a.operation == "sum":
            return [(part, one) for part in a.parts]
        if a.operation == "product":
            return [(a.parts[0], a.parts[1]), (a.parts[1], a.parts[0])]
        if a.operation == "inverse":
            return [(a.parts[0], self.scaled(-1.0, self.product(a, a)))]
        if a.operation == "log":
            return [(a.parts[0], self.inverse(a.parts[0]))]
        if a.operation == "exp":
            return [(a.parts[0], a)]
        if a.operation == "sqrt":
            return [(a.parts[0], self.scaled(0.5, self.inverse(a)))]
        if a.operation == "inverse_cube_root":
            return [(a.parts[0], self.scaled(-1.0 / 3.0, self.whole(a, 4)))]
        if a.operation == "given":
            return self.givens[a.place].slopes
        return []

    def reachable(self, roots: Iterable[Expression]) -> list[Expression]:
        """Return the nodes that these are made of, parts first."""
        found: dict[int, Expression] = {}
        waiting = list(roots)
        while waiting:
            a = waiting.pop()
            if a.place not in found:
                found[a.place] = a
                waiting += [part for part in a.parts if isinstance(part, Expression)]
        return [found[place] for place in sorted(found)]

    def gradient(self, root: Expression, symbols: Iterable[Expression]) -> list[Expression]:
        """Return the derivatives of an expression along symbols, found backward in one pass."""
        zero = self.of(0.0)
        sums = {root.place: self.of(1.0)}
        symbols = list(symbols)
        for a in reversed(self.reachable([root])):
            total = sums.get(a.place)
            if total is None or total is zero:
                continue
            for part, slope in self.slopes(a):
                sums[part.place] = self.sum(sums.get(part.place, zero), self.product(total, slope))
        return [sums.get(symbol.place, zero) for symbol in symbols]

    def plain(self, roots: Iterable[Expression]) -> list[Expression]:
        """Return the expressions with the sum of their parts in place of given nodes."""
        roots, done = list(roots), dict[int, Expression]()
        for a in self.reachable(roots):
            if a.operation == "given":
                own = self.givens[a.place]
                done[a.place] = self.sum(own.rest, self.sum(own.linear, own.beyond))
            elif a.operation in ("number", "symbol"):
                done[a.place] = a
            else:
                done[a.place] = getattr(self, a.operation)(*(done[part.place] for part in a.parts))
        return [done[root.place] for root in roots]


class Derivative:
    """Derivatives of expressions along one change of the symbols, which is given by symbol."""

    def __init__(self, graph: Graph, change: Mapping[Expression, Expression]) -> None:
        self.graph = graph
        self.known = {symbol.place: value for symbol, value in change.items()}

    def __call__(self, a: Expression) -> Expression:
        """Return the derivative of an expression."""
        zero = self.graph.of(0.0)
        for one in self.graph.reachable([a]):
            if one.place not in self.known:
                total = zero
                for part, slope in self.graph.slopes(one):
                    total = self.graph.sum(total, self.graph.product(slope, self.known.get(part.place, zero)))
                self.known[one.place] = total
        return self.known[a.place]


VALUES = {
    "sum": lambda a, b: a + b,
    "product": lambda a, b: a * b,
    "inverse": lambda a: 1.0 / a,
    "log": np.log,
    "exp": np.exp,
    "sqrt": np.sqrt,
    "inverse_cube_root": lambda a: a ** (-1.0 / 3.0),
}


def values(graph: Graph, roots: list[Expression], symbols: Mapping[str, Any]) -> list[Any]:
    """Return the values of expressions, by NumPy, for values of the symbols."""
    roots = graph.plain(roots)
    found: dict[int, Any] = {}
    with np.errstate(all="ignore"):
        for a in graph.reachable(roots):
            if a.operation == "number":
                found[a.place] = a.parts[0]
            elif a.operation == "symbol":
                found[a.place] = symbols[a.parts[0]]
            else:
                found[a.place] = VALUES[a.operation](*(found[part.place] for part in a.parts))
    return [found[root.place] for root in roots]


FUNCTIONS = {
    "add": lambda a, b: a.graph.sum(a, b),
    "subtract": lambda a, b: a.graph.sum(a, a.graph.scaled(-1.0, b)),
    "multiply": lambda a, b: a.graph.product(a, b),
    "divide": lambda a, b: a.graph.product(a, a.graph.inverse(b)),
    "power": lambda a, b: a.graph.power(a, b),
    "float_power": lambda a, b: a.graph.power(a, b),
    "negative": lambda a: a.graph.scaled(-1.0, a),
    "positive": lambda a: a,
    "square": lambda a: a.graph.product(a, a),
    "reciprocal": lambda a: a.graph.inverse(a),
    "sqrt": lambda a: a.graph.sqrt(a),
    "log": lambda a: a.graph.log(a),
    "log1p": lambda a: a.graph.log(1.0 + a),
    "log2": lambda a: a.graph.log(a) / np.log(2.0),
    "log10": lambda a: a.graph.log(a) / np.log(10.0),
    "exp": lambda a: a.graph.exp(a),
    "expm1": lambda a: a.graph.exp(a) - 1.0,
    "sinh": lambda a: 0.5 * (a.graph.exp(a) - a.graph.exp(-a)),
    "cosh": lambda a: 0.5 * (a.graph.exp(a) + a.graph.exp(-a)),
}
for one in ("sqrt", "log", "log1p", "log2", "log10", "exp", "expm1", "sinh", "cosh"):
    setattr(Expression, one, FUNCTIONS[one])  # what NumPy calls for an array of expressions
