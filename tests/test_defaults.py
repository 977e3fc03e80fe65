"""The table of defaults says what the code does, and leaves none out."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import re
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import tcontact as tc
from tcontact import friction_layer
from tcontact.mesh import elements
from tcontact.schemes.implicit.scheme import ImplicitScheme
from tcontact.show import render

TEXT = (Path(__file__).resolve().parents[1] / "docs" / "DEFAULTS.md").read_text(encoding="utf-8")
ROWS = dict(re.findall(r"^\| `([^`]+)` \| `([^`]+)` \| .{4,} \|$", TEXT, flags=re.MULTILINE))
PUBLIC = [getattr(tc, name) for name in tc.__all__ if name != "friction_layer"]
PUBLIC += [ImplicitScheme, friction_layer.solve, render.render_frames, render.Camera]
# where things are, and what a run leaves: nothing to explain
PLACES = {"point", "center", "normal", "axis", "radius", "size", "origin", "spacing", "inside"}
NOTHING = (None, (), "", False, dataclasses.MISSING)
OPTIONS = {field.name for field in dataclasses.fields(ImplicitScheme)}
SAME = {"material", "thickness", "heat_share", "plastic_heat", "initial_temperature", "method", "arch"}


def defaults() -> Iterator[tuple[str, object]]:
    """Name and default of everything public, options of implicit schemes once."""
    for item in PUBLIC:
        if dataclasses.is_dataclass(item):
            shared = issubclass(item, ImplicitScheme) and item is not ImplicitScheme
            for field in dataclasses.fields(item):
                if shared and field.name in OPTIONS:
                    continue
                made = field.default_factory is not dataclasses.MISSING and item is tc.Scene
                yield f"{item.__name__}.{field.name}", field.default_factory() if made else field.default
        elif inspect.isfunction(item):
            for parameter in inspect.signature(item).parameters.values():
                if parameter.default is not parameter.empty:
                    yield f"{item.__name__}({parameter.name})", parameter.default


def written(name: str) -> str:
    """A constant as it stands in its file: tests may have changed the one in memory."""
    module, _, constant = name.rpartition(".")
    for node in ast.parse(Path(find_spec(module).origin).read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == constant:
            return ast.unparse(node.value)
    raise KeyError(name)


KNOWN = dict(defaults())


@pytest.mark.parametrize("name", ROWS)
def test_the_table_says_what_the_code_does(name):
    words = {"np": np, "MasslessContact": tc.MasslessContact, "STAINLESS_304": friction_layer.STAINLESS_304}
    said = eval(ROWS[name], words)
    if name.startswith("tcontact."):
        assert eval(written(name), words) == said
    elif name.startswith("{"):  # facts of the kinds of cells, one by one
        assert eval(name, {"ELEMENTS": elements.ELEMENTS, "FORMULATIONS": elements.FORMULATIONS}) == said
    else:
        assert KNOWN[name] == said


def test_no_default_is_left_out():
    missing = []
    for name, value in KNOWN.items():
        owner, part = re.fullmatch(r"(\w+)[.(](\w+)\)?", name).groups()
        same = owner == "solve" and part in SAME and value == KNOWN.get(f"FrictionLayer.{part}", value)
        nothing = any(value is none or (isinstance(value, tuple) and value == none) for none in NOTHING)
        placed = owner in ("Plane", "Sphere", "Cylinder", "Box", "Sdf") or owner.endswith("_mesh")
        where = placed and part in PLACES
        if name not in ROWS and not (same or nothing or where or owner in ("Result", "Mesh", "render_picture")):
            missing.append(f"{name} = {value!r}")
    assert not [name for name in missing if name != "render_frames(animation) = True"]
