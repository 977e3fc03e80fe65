"""The problems of a study: each is a module and named like its file, bar-impact in bar_impact.py.

A problem has `scene(cells=..., ...)` with keyword parameters, `errors(result)` (name -> relative error; `ERRORS` lists
the names, the main one first), `SIZES` and `METHODS` (defaults), and `unit(scene)` (the stiffness [N/m^3] that the K of
the method penalty-K multiplies). It may have `displaced(scene)`, the scene with its start, once its contact is known;
`step(scene)`, the step [s] in which cfl counts for all methods alike; `SCHEMES = False` where no implicit one runs it;
`REFERENCE`, a line on what the errors refer to; and `reference` (see `tcontact.lab.study.reference`), which turns
`errors` into `errors(result, reference)`.
"""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType
from typing import Any

from ....base.errors import InputError, hint


def names() -> list[str]:
    """Return the names of all problems, sorted."""
    return sorted(path.stem.replace("_", "-") for path in Path(__file__).parent.glob("[a-z]*.py"))


def load(name: str) -> ModuleType:
    """Return the problem's module. Raises `InputError` with the known names."""
    if name not in names():
        known = [*names(), "friction-layer", "hard-cases"]
        raise InputError("case", name, hint(name, known) + "use one of " + ", ".join(known))
    return importlib.import_module(f"{__name__}.{name.replace('-', '_')}")


def cell_stiffness(scene: Any) -> float:
    """Return young/h [N/m^3], h the shortest edge of the first body's cells."""
    body = scene.bodies[0]
    return body.material.young / body.mesh.shortest_edge


def column(cells: int, length: float, young: float, density: float, gap: float = 0.0) -> tuple[Any, Any]:
    """Return mesh and linear material (poisson 0) of a square bar along z, `cells` cells long and one wide."""
    import tcontact as tc

    width = length / 8.0
    mesh = tc.box_mesh(size=(width, width, length), cells=(1, 1, cells), origin=(-width / 2, -width / 2, gap))
    return mesh, tc.LinearElastic(young=young, poisson=0.0, density=density)
