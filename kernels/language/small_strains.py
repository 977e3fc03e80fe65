"""Expressions at small strains without loss of digits: value at rest, part linear in the strain, what is beyond.

A stress P(H) with P(0) = 0 is a difference of terms of the size of the moduli: computed as it stands, its relative
error at a strain of 1e-9 is 1e-7, that of the energy larger than 1. Here every node a of a formula becomes a sum

    a = a0 + da,    da = a1 + a2      a0: at H = 0, without H;  a1: linear in H;  a2: what is beyond

by the rules of its operation, none of which subtracts numbers that are nearly equal. With x = db/b0:

    a b:       d = a0 db + b da                         2: a0 b2 + b0 a2 + da db
    1/b:       d = -db r/b0,  r = 1/b                   2: (db b1/b0 - b2) r/b0
    ln b:      d = x - l(x),  l(x) = x - ln(1 + x)      2: x2 - l(x)
    exp b:     d = exp(b0) (db + m(db)),  m(x) = exp(x) - 1 - x       2: exp(b0) (b2 + m(db))
    sqrt b:    d = db/(s + s0)                          2: s0 (x2/2 - x^2/(2 (1 + s/s0)^2))
    b^(-1/3):  d = -b0^(-1/3) x q^3/(1 + q + q^2),  q = (1 + x)^(-1/3)
               2: b0^(-1/3) (-x2/3 + x^2 q^3 (1 + 2q + 3q^2)/(3 (1 + q + q^2)^2))

The stress is da of its formula and the energy a2 of its own, since the parts before them are 0 of a law that is free of
stress at rest. l and m are functions of transcendental.py.
"""

from __future__ import annotations

from typing import NamedTuple

from .expressions import PARAMETER, Expression, Graph, NotPlain


class Parts(NamedTuple):
    """a0, da and a."""

    rest: Expression
    change: Expression
    value: Expression


class SmallStrains:
    """Finds the parts of the expressions of a graph."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self._parts: dict[int, Parts] = {}
        self._orders: dict[int, tuple[Expression, Expression]] = {}

    def parts(self, a: Expression) -> Parts:
        """Return a0, da and a."""
        for one in self.graph.reachable([a]):  # parts first: no deep recursion
            if one.place not in self._parts:
                self._parts[one.place] = self._made(one)
        return self._parts[a.place]

    def _made(self, a: Expression) -> Parts:
        g, zero = self.graph, self.graph.of(0.0)
        if a.operation == "number" or (a.operation == "symbol" and a.parts[0].startswith(PARAMETER)):
            return Parts(a, zero, a)
        if a.operation == "symbol":
            return Parts(zero, a, a)
        if a.operation == "given":
            own = g.givens[a.place]
            change = g.sum(own.linear, own.beyond)
            return Parts(own.rest, change, g.sum(own.rest, change))
        first, *others = [self._parts[part.place] for part in a.parts]
        rest0, change = first.rest, first.change
        if change is zero and all(other.change is zero for other in others):
            return Parts(a, zero, a)
        if a.operation == "sum":
            rest, change = g.sum(rest0, others[0].rest), g.sum(change, others[0].change)
            return Parts(rest, change, g.sum(rest, change))
        if a.operation == "product":
            second = others[0]
            rest = g.product(rest0, second.rest)
            if second.rest.operation == "number" and rest0.operation != "number":
                first, second = second, first
            change = g.sum(g.product(first.rest, second.change), g.product(first.change, second.value))
            return Parts(rest, change, g.sum(rest, change))
        if rest0 is zero and a.operation != "exp":
            raise NotPlain("it divides by, or takes a root, a logarithm or a power of, what is 0 without strain")
        if a.operation == "inverse":
            rest, value = g.inverse(rest0), self._inverse(a.parts[0], first)
            return Parts(rest, g.scaled(-1.0, g.product(g.product(change, value), rest)), value)
        if a.operation == "exp":
            rest, split = g.exp(rest0), g.node("exponential_split", change)
            change = g.product(rest, g.node("first", split))
            return Parts(rest, change, g.sum(rest, change))
        x = g.product(change, g.inverse(rest0))
        if a.operation == "log":
            change = g.sum(x, g.scaled(-1.0, g.node("first", g.node("log_split", x))))
            rest = g.log(rest0)
            return Parts(rest, change, g.sum(rest, change))
        if a.operation == "sqrt":
            rest, value = g.sqrt(rest0), g.sqrt(first.value)
            return Parts(rest, g.product(change, g.inverse(g.sum(value, rest))), value)
        rest, q = g.inverse_cube_root(rest0), self._root(x)
        shrink = g.product(g.product(x, g.whole(q, 3)), g.inverse(1.0 + q + g.product(q, q)))
        return Parts(rest, g.scaled(-1.0, g.product(rest, shrink)), g.product(rest, q))

    def _inverse(self, b: Expression, parts: Parts) -> Expression:
        """Return 1/b; beside its logarithm both have one division."""
        g = self.graph
        if g.known("log", b):
            x = g.product(parts.change, g.inverse(parts.rest))
            return g.product(g.node("second", g.node("log_split", x)), g.inverse(parts.rest))
        return g.inverse(parts.value)

    def _root(self, x: Expression) -> Expression:
        return self.graph.inverse_cube_root(self.graph.sum(self.graph.of(1.0), x))

    def beyond(self, a: Expression) -> Expression:
        """Return a2."""
        self.parts(a)
        for one in self.graph.reachable([a]):
            if one.place not in self._orders:
                self._orders[one.place] = self._order(one)
        return self._orders[a.place][1]

    def _order(self, a: Expression) -> tuple[Expression, Expression]:
        """Return a1 and a2."""
        g, zero = self.graph, self.graph.of(0.0)
        if self._parts[a.place].change is zero:
            return zero, zero
        if a.operation == "symbol":
            return a, zero
        if a.operation == "given":
            return g.givens[a.place].linear, g.givens[a.place].beyond
        first, *others = [self._parts[part.place] for part in a.parts]
        (one, two), *more = [self._orders[part.place] for part in a.parts]
        rest0 = first.rest
        if a.operation == "sum":
            return g.sum(one, more[0][0]), g.sum(two, more[0][1])
        if a.operation == "product":
            second = others[0]
            linear = g.sum(g.product(rest0, more[0][0]), g.product(second.rest, one))
            mixed = g.product(first.change, second.change)
            return linear, g.sum(g.sum(g.product(rest0, more[0][1]), g.product(second.rest, two)), mixed)
        if a.operation == "exp":
            rest, split = g.exp(rest0), g.node("exponential_split", first.change)
            return g.product(rest, one), g.product(rest, g.sum(two, g.node("second", split)))
        inverse = g.inverse(rest0)
        x, x1, x2 = (g.product(part, inverse) for part in (first.change, one, two))
        if a.operation == "inverse":
            outer = g.product(self._parts[a.place].value, inverse)
            beyond = g.product(outer, g.product(first.change, x1) - two)
            return g.scaled(-1.0, g.product(inverse, x1)), beyond
        if a.operation == "log":
            return x1, x2 - g.node("first", g.node("log_split", x))
        own = self._parts[a.place]
        square = g.product(x, x)
        if a.operation == "sqrt":
            ratio = g.inverse(1.0 + own.value / own.rest)
            return 0.5 * own.rest * x1, own.rest * (0.5 * x2 - 0.5 * square * (ratio * ratio))
        q = self._root(x)
        shrink = g.inverse(1.0 + q + q * q)
        bent = square * g.whole(q, 3) * (1.0 + 2.0 * q + 3.0 * (q * q)) * (shrink * shrink)
        return own.rest * x1 / -3.0, own.rest * (bent - x2) / 3.0
