"""Sources of Taichi functions from expressions: straight lines of arithmetic, each result that is used again once.

As the signatures of kernels, sources are kept in `linecache`, where Taichi finds them.
"""

from __future__ import annotations

import linecache
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..engine import ti
from .expressions import Expression, Graph
from .transcendental import exponential_less_one, exponential_split, inverse_cube_root, log_split, logarithm

SCOPE = {
    "ti": ti,
    "exponential_less_one": exponential_less_one,
    "exponential_split": exponential_split,
    "inverse_cube_root": inverse_cube_root,
    "log_split": log_split,
    "logarithm": logarithm,
}
CALLS = {
    "inverse": "1.0 / {}",
    "log": "logarithm({})",
    "exp": "1.0 + exponential_less_one({})",
    "sqrt": "ti.sqrt({})",
    "inverse_cube_root": "inverse_cube_root({})",
    "log_split": "log_split({})",
    "exponential_split": "exponential_split({})",
    "first": "{}[0]",
    "second": "{}[1]",
}


def body(
    graph: Graph, roots: Sequence[Expression], symbols: Mapping[str, str], answer: Callable[[list[str]], str]
) -> str:
    """Return the lines of a function that computes expressions.

    symbols: the text of each symbol; answer: makes the text of the last lines of those of the expressions.
    """
    order = graph.reachable(roots)
    uses: dict[int, int] = {}
    for part in [*roots, *(part for a in order for part in a.parts if isinstance(part, Expression))]:
        uses[part.place] = uses.get(part.place, 0) + 1
    texts: dict[int, str] = {}
    lines = []
    for a in order:
        parts = [texts[part.place] if isinstance(part, Expression) else part for part in a.parts]
        if a.operation == "number":
            texts[a.place] = f"({a.parts[0]!r})"
            continue
        if a.operation == "symbol":
            text = symbols[a.parts[0]]
        elif a.operation == "sum":
            left, right = sorted(a.parts, key=lambda part: _opposite(part) is not None)
            less = _opposite(right)
            text = f"{texts[left.place]} " + (f"+ {texts[right.place]}" if less is None else f"- {texts[less.place]}")
        elif a.operation == "product":
            text = f"{parts[0]} * {parts[1]}"
        else:
            text = CALLS[a.operation].format(*parts)
        if a.operation in CALLS or uses[a.place] > 1:
            texts[a.place] = f"t{len(lines)}"
            lines.append(f"    {texts[a.place]} = {text}\n")
        else:
            texts[a.place] = text if a.operation == "symbol" else f"({text})"
    return "".join(lines) + answer([texts[root.place] for root in roots])


def _opposite(a: Expression) -> Expression | None:
    """Return b where a is -b."""
    negative = a.operation == "product" and a.parts[0].operation == "number" and a.parts[0].parts[0] == -1.0
    return a.parts[1] if negative else None


def function(name: str, arguments: str, source: str, scope: Mapping[str, Any] | None = None) -> Any:
    """Return the `ti.func` of this name with these lines."""
    text = f"def {name}({arguments}):\n{source}"
    file = f"<law {name} {abs(hash(text))}>"
    linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)
    space = SCOPE | dict(scope or {})
    exec(compile(text, file, "exec"), space)
    return ti.func(space[name])
