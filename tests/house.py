"""The house as a drawing: the modules of the package, the rooms they stand in, and what imports what.

A room is what stands directly below `tcontact`: a package or a single module; `kernels` and `cases` are rooms of it.
What runs under `if __name__ == "__main__"` belongs to the program and not to the module.
"""

from __future__ import annotations

import ast
import functools
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
PLACES = {"tcontact": "tcontact", "kernels": "tcontact.kernels", "cases": "tcontact.cases"}
# from the top floor down: a room imports only what stands below it; "" is the package itself, the names of users
ROOMS = (
    "__main__",
    "commands",
    "lab",
    "cases",
    "",
    "show",
    "run",
    "schemes",
    "contact",
    "cells",
    "nodes",
    "results",
    "planning",
    "scene",
    "friction_layer",
    "mesh",
    "device",
    "kernels",
    "base",
)
KERNEL_ROOMS = (
    "pictures",
    "step",
    "layer",
    "static",
    "contact",
    "cells",
    "nodes",
    "elements",
    "materials",
    "language",
    "columns",
    "node_places",
    "pair_places",
    "rigid_places",
    "volume_places",
    "load_places",
    "layer_places",
    "sweep_places",
    "lanes",
    "engine",
)
HEAVY = {"taichi", "matplotlib", "PIL", "rich", "h5py", "meshio", "imageio_ffmpeg", "scipy", "vtk"}


class Arrow(NamedTuple):
    """One import: from a module to a module; hidden: inside a function."""

    start: str
    end: str
    hidden: bool
    line: int

    def __str__(self) -> str:
        return f"{self.start} -> {self.end} (line {self.line})"


def modules() -> dict[str, Path]:
    """All modules of the package by name."""
    found = {}
    for place, name in PLACES.items():
        for path in sorted((ROOT / place).rglob("*.py")):
            parts = path.relative_to(ROOT / place).with_suffix("").parts
            found[".".join([name, *parts]).removesuffix(".__init__")] = path
    return found


MODULES = modules()


def _targets(name: str, node: ast.Import | ast.ImportFrom, known: Iterable[str]) -> list[str]:
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    base = node.module or ""
    if node.level:
        package = name.split(".") if MODULES[name].name == "__init__.py" else name.split(".")[:-1]
        above = package[: len(package) - node.level + 1]
        base = ".".join([*above, base] if base else above)
    return [f"{base}.{alias.name}" if f"{base}.{alias.name}" in known else base for alias in node.names]


def arrows(sources: Mapping[str, str] | None = None) -> list[Arrow]:
    """All imports, those of other packages too unless only for types. sources: texts to read instead of the files."""
    known = frozenset(MODULES) | frozenset(sources or ())
    texts = {name: (sources or {}).get(name) or MODULES[name].read_text(encoding="utf-8") for name in sorted(known)}
    return [arrow for name, text in texts.items() for arrow in _arrows_of(name, text, known)]


@functools.cache
def _arrows_of(name: str, text: str, known: frozenset[str]) -> tuple[Arrow, ...]:
    """Return the imports of one module; imports are statements, so expressions are not looked at."""
    found: list[Arrow] = []

    def visit(node: ast.AST, hidden: bool, typing: bool = False) -> None:
        for child in ast.iter_child_nodes(node):
            if not isinstance(child, ast.stmt | ast.excepthandler | ast.match_case):
                continue
            if isinstance(child, ast.If) and "__main__" in ast.unparse(child.test):
                continue
            if isinstance(child, ast.Import | ast.ImportFrom):
                ends = [end for end in _targets(name, child, known) if not typing or end.startswith("tcontact")]
                found.extend(Arrow(name, end, hidden, child.lineno) for end in ends if end != name)
            inside = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef)
            types = isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"
            visit(child, hidden or inside, typing or types)

    visit(ast.parse(text), False)
    return tuple(found)


def room(name: str) -> str:
    """The room of a module of the package."""
    return name.partition(".")[2].partition(".")[0]


def kernel_room(name: str) -> str:
    """The room of a module within the kernels."""
    return room(name.partition(".")[2])


def upward(found: Iterable[Arrow]) -> list[str]:
    """Arrows that go up, between rooms of the house or of the kernels."""
    wrong = []
    for arrow in found:
        if arrow.end.partition(".")[0] != "tcontact":
            continue
        start, end, floors = room(arrow.start), room(arrow.end), ROOMS
        if start == end == "kernels":
            start, end, floors = kernel_room(arrow.start), kernel_room(arrow.end), KERNEL_ROOMS
            if "" in (start, end):
                continue
        if start != end and floors.index(start) > floors.index(end):
            wrong.append(str(arrow))
    return wrong


def circles(pairs: Iterable[tuple[str, str]]) -> list[set[str]]:
    """Sets of names that lead to each other."""
    below: dict[str, set[str]] = {}
    for start, end in pairs:
        below.setdefault(start, set()).add(end)
        below.setdefault(end, set())
    while leaves := {name for name, ends in below.items() if not ends}:
        below = {name: ends - leaves for name, ends in below.items() if name not in leaves}
    while below:  # what nothing leads to stands on a circle no more than what leads nowhere
        reached = set().union(*below.values())
        if len(reached & set(below)) == len(below):
            break
        below = {name: ends for name, ends in below.items() if name in reached}
    return [set(below)] if below else []


def needless(found: Iterable[Arrow]) -> list[str]:
    """Imports in functions of modules that lead to no heavy library; kernels are what Taichi compiles, and count."""
    found = list(found)
    heavy = {arrow.start for arrow in found if not arrow.hidden and arrow.end.partition(".")[0] in HEAVY}
    heavy |= {name for name in MODULES if room(name) == "kernels"}
    size = -1
    while size != len(heavy):
        size = len(heavy)
        heavy |= {
            arrow.start for arrow in found if not arrow.hidden and arrow.end in heavy and room(arrow.end) != "kernels"
        }
    return [
        str(arrow)
        for arrow in found
        if arrow.hidden and arrow.end.partition(".")[0] == "tcontact" and arrow.end not in heavy
    ]
