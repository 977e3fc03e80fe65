"""The cases: each is a module with a docstring, `scene(**parameters)` and `checks(result)`.

A case may also have `curves(result)`, known contact forces by label to plot, (times [s], force [N]); `draw(result,
folder, title)`, which adds pictures of its own; `comparison(**parameters)`, scenes by label, or pairs of a scene and
its scheme, that are run and plotted side by side; `compared(result)`, what that plot shows of each run instead of the
usual quantities, (times [s], values) by (name, unit); `draw_comparison(path, histories)`, a picture of its own; and
`SCHEME`, the scheme and its options if it is not the explicit one. A case that is no mechanical scene has
`solve(**parameters)` instead, and `summary(runs)` and `write(runs, folder)` beside `checks(runs)`.

Names, titles and parameters are read from the source without running it, so that listing stays instant.
"""

from __future__ import annotations

import ast
import importlib
import json
from pathlib import Path
from types import ModuleType
from typing import get_args

from tcontact.base.errors import InputError, hint

TIMES = "times.json"  # beside this file


def names() -> list[str]:
    """Return the names of all cases, sorted: the file cube_impact.py is the case cube-impact."""
    return sorted(path.stem.replace("_", "-") for path in Path(__file__).parent.glob("[a-z]*.py"))


def title(name: str) -> str:
    """Return the first line of the case's docstring. Raises `InputError` for an unknown case."""
    return (ast.get_docstring(_source(name)) or "").partition("\n")[0]


def about(name: str) -> str:
    """Return what follows the first line of the case's docstring. Raises `InputError` for an unknown case."""
    return (ast.get_docstring(_source(name)) or "").partition("\n")[2].strip()


def about_parameters(name: str) -> str:
    """Return the docstring of its `scene` or `solve`, which explains its parameters. Raises `InputError`."""
    for item in _source(name).body:
        if isinstance(item, ast.FunctionDef) and item.name in ("scene", "solve"):
            return (ast.get_docstring(item) or "").strip()
    return ""


def parameters(name: str) -> dict[str, tuple[str, str]]:
    """Return type, or words to choose from, and default of each parameter of the case. Raises `InputError`."""
    body = _source(name).body
    known = {
        target.id: item.value
        for item in body
        if isinstance(item, ast.Assign)
        for target in item.targets
        if isinstance(target, ast.Name)
    }
    for item in body:
        if isinstance(item, ast.FunctionDef) and item.name in ("scene", "solve"):
            pairs = zip(item.args.kwonlyargs, item.args.kw_defaults, strict=True)
            return {
                argument.arg: (_kind(argument.annotation, known), _kind(default, known)) for argument, default in pairs
            }
    return {}


def compares(name: str) -> str:
    """Return the first line of the docstring of the case's `comparison`, "" if it has none. Raises `InputError`."""
    for item in _source(name).body:
        if isinstance(item, ast.FunctionDef) and item.name == "comparison":
            return (ast.get_docstring(item) or "").partition("\n")[0]
    return ""


def took(name: str) -> str:
    """Return how long a run of the case with its defaults took on a named processor, "" if it was never measured.

    The figures are made by `tcontact numbers --only times --write`. Raises `InputError` for an unknown case.
    """
    known = json.loads((_path(name).parent / TIMES).read_text(encoding="utf-8"))
    if name not in known["seconds"]:
        return ""
    first, again = known["seconds"][name]
    return f"takes {again:.2g} s, the first time {first:.2g} s ({known['processor']}, {known['cores']} cores)"


def load(name: str) -> ModuleType:
    """Import a case by its name. Raises `InputError` with the known names for an unknown one."""
    _path(name)
    return importlib.import_module(f"{__name__}.{name.replace('-', '_')}")


def _kind(found: ast.expr | None, known: dict[str, ast.expr]) -> str:
    """Return a type or default in a source as text: choices as their words, a name of the module as its value."""
    match found:
        case None:
            return ""
        case ast.Name(id=name) if name in known:
            return _kind(known[name], known)
        case ast.BinOp(left=left, op=ast.BitOr(), right=right):
            return f"{_kind(left, known)} | {_kind(right, known)}"
        case ast.Subscript(value=ast.Name(id="Literal"), slice=words):
            return " | ".join(str(word) for word in ast.literal_eval(words))
        case ast.Attribute(value=ast.Name(id="choices"), attr=name):
            from . import _choices

            return " | ".join(get_args(getattr(_choices, name)))
    return ast.unparse(found)


def _path(name: str) -> Path:
    if name not in names():
        raise InputError("case", name, hint(name, names()) + "use one of " + ", ".join(names()))
    return Path(__file__).parent / f"{name.replace('-', '_')}.py"


def _source(name: str) -> ast.Module:
    return ast.parse(_path(name).read_text(encoding="utf-8"))
