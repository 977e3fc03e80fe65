"""A bar of copper strikes a rigid plane end on and spreads at its foot: the test of Taylor.

Two bars: "copper", 32.4 mm long, radius 3.2 mm, 227 m/s, the bar of the literature on methods (young 117 GPa, poisson
.35, 8930 kg/m^3, yield stress 400 MPa with a hardening of 100 MPa, no friction): at 80 us it is 21.42 to 21.47 mm long
on axisymmetric meshes, and the radius of its foot is 7.22 (Foulk et al. 2021), 7.12 (Simo 1992), 7.11 mm (Zienkiewicz
et al. 1998) where the foot is held to the plane; its lip lifts off a plane that cannot pull, and the foot is about .1
mm wider. "ofhc", 25.4 mm long, radius 3.81 mm, 190 m/s: the experiment gives 16.2 mm, a foot of diameter 13.5 mm and
10.1 mm at a fifth of the length above it (Johnson and Holmquist 1988). A quarter is computed, with planes of symmetry.
The radius of the foot is of first order in the cell size; the cell at the wall overshoots the plastic strain.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, Literal, NamedTuple

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np

import tcontact as tc
from tcontact.cases import _choices as choices
from tcontact.cases import _round_meshes as meshes
from tcontact.cases._inputs import checked
from tcontact.mesh.mapped import tetrahedra
from tcontact.results import checks as ck
from tcontact.show import plots

Law = Literal["linear", "steinberg-guinan", "johnson-cook"]
END = 80e-6  # [s]: the bars have stopped
CELL = 0.64e-3  # [m]: cell size for which the bounds hold as they stand


class Bar(NamedTuple):
    """Size [m], speed [m/s], elastic constants and density of a bar, and its yield stress with linear hardening.

    left: share of its energy that may be left as motion at the end.
    """

    length: float
    radius: float
    speed: float
    young: float
    poisson: float
    density: float
    linear: tc.LinearHardening
    left: float


BARS = {
    "copper": Bar(32.4e-3, 3.2e-3, 227.0, 117e9, 0.35, 8930.0, tc.LinearHardening(400e6, 100e6), 1e-3),
    "ofhc": Bar(25.4e-3, 3.81e-3, 190.0, 117e9, 0.35, 8930.0, tc.LinearHardening(157e6, 425e6), 2e-3),
}
OFHC = tc.JohnsonCook(90e6, 292e6, 0.31, 0.025, 1.09, 1356.0)  # Johnson and Cook 1983
# of linear hardening at END: what, where it is measured, smallest and largest value [m], published
KNOWN = {
    "copper": (("length", 21.39e-3, 21.51e-3, 21.44e-3), ("foot radius", 7.20e-3, 7.55e-3, 7.22e-3)),
    "ofhc": (
        ("length", 16.0e-3, 16.4e-3, 16.2e-3),
        ("foot radius", 6.5e-3, 7.0e-3, 6.75e-3),
        ("radius at a fifth", 4.95e-3, 5.15e-3, 5.05e-3),
    ),
}


@checked
def scene(
    *,
    cells: int = 5,
    kind: Literal["hex8", "tet4"] = "hex8",
    formulation: str | None = None,
    bar: Literal["copper", "ofhc"] = "copper",
    law: Law = "linear",
    speed: float | None = None,
    removal: choices.Removal = "auto",
    depth: int = 1,
    tolerance: float | None = None,
    duration: float = END,
) -> tc.Scene:
    """A bar with `cells` cells across its radius touches the plane z = 0 at the start.

    SI units. formulation: None for the one that suits metals; law: linear hardening, or the yield stress of copper
    after Steinberg and Guinan or Johnson and Cook, with heat; speed: None for that of the bar.
    """
    if isinstance(cells, bool) or not isinstance(cells, int) or cells < 2:
        raise tc.InputError("cells", cells, "give a whole number of at least 2")
    if bar not in BARS:
        raise tc.InputError("bar", bar, "use one of " + ", ".join(BARS))
    laws: dict[str, Any] = {
        "linear": BARS[bar].linear,
        "steinberg-guinan": tc.friction_layer.COPPER,
        "johnson-cook": OFHC,
    }
    if law not in laws:
        raise tc.InputError("law", law, "use one of " + ", ".join(laws))
    choices.positive(speed=speed, duration=duration)
    known = BARS[bar]
    mesh = meshes.quarter_bar(known.radius, known.length, cells)
    if kind == "tet4":
        mesh = tetrahedra(mesh)
    copper = tc.ElastoPlastic(known.young, known.poisson, known.density, laws[law], specific_heat=385.0)
    body = tc.Body(
        mesh,
        copper,
        velocity=(0.0, 0.0, -(known.speed if speed is None else speed)),
        contact="zmin",
        supports=[tc.Support("xmin", "x"), tc.Support("ymin", "y")],
        formulation=formulation,
        name=bar,
    )
    model = tc.MasslessContact(removal=removal, depth=depth, tolerance=tolerance)
    return tc.Scene([body], [tc.Plane()], duration=duration, contact=model)


def comparison(*, law: Law = "linear", **parameters: Any) -> dict[str, tc.Scene]:
    """Compare the three yield stresses."""
    return {name: scene(law=name, **parameters) for name in ("linear", "steinberg-guinan", "johnson-cook")}


def size_of_cells(scene: tc.Scene) -> float:
    """Return the size of the cells [m]: the radius over their number across it."""
    nodes = scene.bodies[0].mesh.nodes
    rim = float(np.hypot(nodes[:, 0], nodes[:, 1]).max())
    levels = np.unique(np.rint(nodes[(nodes[:, :2] < 1e-6 * rim).all(axis=1), 2] / (1e-6 * rim)))
    return float(1e-6 * rim * np.diff(levels).max())


def measured(result: tc.Result) -> dict[str, float]:
    """Return length, radius of the foot, and radius at a fifth of the first length above the foot [m]."""
    height, radius = outline(result)
    length = float(np.ptp(result.scene.bodies[0].mesh.nodes[:, 2]))
    return {
        "length": float(np.ptp(result.position[:, 2])),
        "foot radius": float(radius[0]),
        "radius at a fifth": float(np.interp(height[0] + 0.2 * length, height, radius)),
    }


def outline(result: tc.Result) -> tuple[np.ndarray, np.ndarray]:
    """Return height and largest radius [m] of the layers of nodes, from the foot up."""
    nodes, now = result.scene.bodies[0].mesh.nodes, result.position
    edge = np.hypot(nodes[:, 0], nodes[:, 1]) > (1.0 - 1e-6) * np.hypot(nodes[:, 0], nodes[:, 1]).max()
    layers = np.rint(nodes[edge, 2] / (1e-6 * nodes[:, 2].max())).astype(np.int64)
    _, member = np.unique(layers, return_inverse=True)
    reach = np.hypot(now[edge, 0], now[edge, 1])
    widest = np.zeros(member.max() + 1)
    np.maximum.at(widest, member, reach)
    heights = np.bincount(member, now[edge, 2]) / np.bincount(member)
    return heights, widest


def known(result: tc.Result) -> tuple[tuple[str, float, float, float], ...]:
    """Return the figures that are known for this bar, as in `KNOWN`; none for other speeds, laws and times."""
    body = result.scene.bodies[0]
    bar = BARS[body.name or ""]
    same = body.material.hardening == bar.linear and result.scene.duration == END
    return KNOWN[body.name or ""] if same and -float(body.velocity[2]) == bar.speed else ()


def draw(result: tc.Result, folder: Path, title: str) -> None:
    """Draw the outline of the bar at the start and at the end, with the figures that are known."""
    nodes = result.scene.bodies[0].mesh.nodes
    height, radius = outline(result)
    length, rim = float(nodes[:, 2].max()), float(nodes[:, 0].max())
    lines = {"start": (np.array([rim, rim, 0.0]), np.array([0.0, length, length]))}
    lines["computed"] = (np.append(radius, 0.0), np.append(height, height[-1]))
    for name, _low, _high, published in known(result):
        level = 0.2 * length if "fifth" in name else 0.0
        spot = (np.array([0.0, rim]), np.full(2, published)) if name == "length" else (
            np.full(2, published), level + np.array([0.0, 0.02 * length]))  # fmt: skip
        lines[f"published, {name}"] = spot
    plots.outlines(folder / "profile.png", lines, title)


def checks(result: tc.Result) -> list[ck.Check]:
    """Check the general laws, that every static solve converged, and the shape at the end where it is known."""
    history = result.history
    coarse = max(1.0, size_of_cells(result.scene) / CELL)
    tolerance = result.scene.contact.tolerance or 1e-4
    found = [
        ck.finished(result),
        ck.touched(result),
        ck.pushing(result),
        ck.no_overlap(result),
        ck.energy(result, 3e-3 * coarse),
        ck.equals("static solves not converged", int((history["static_residual"] > tolerance).sum()), 0),
    ]
    if not result.ok or not (figures := known(result)):
        return found
    left = history["kinetic"][-1] / history["kinetic"][0]
    found.append(ck.at_most("kinetic energy left / first", left, BARS[result.scene.bodies[0].name or ""].left))
    there = measured(result)
    for name, low, high, _published in figures:
        middle, half = 0.5 * (low + high), 0.5 * (high - low) * coarse**2
        found.append(ck.between(f"{name} [mm]", 1e3 * there[name], 1e3 * (middle - half), 1e3 * (middle + half)))
    return found


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "taylor-bar", *sys.argv[1:]]))
