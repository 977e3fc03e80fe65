"""A metal plate strikes a rigid wall: an elastic wave and a plastic shock with an exact solution, up to 1500 m/s.

The plate is a column of cells in uniaxial strain, its sides held; a wall that stands still is the middle plane of two
equal plates that meet at twice the speed. From the touch on an elastic wave runs up, followed (or, at high speed,
overtaken) by a plastic shock; behind it the metal rests. Stress at the wall, plastic strain, temperature and the speed
of the shock follow from the jump conditions (`_metal_shock.py`). The run ends at 0.6 of the time at which the elastic
wave, come back from the free end, meets the shock.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Literal

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np

import tcontact as tc
from tcontact.cases import _choices as choices
from tcontact.cases._inputs import checked
from tcontact.cases._metal_shock import MetalShock
from tcontact.results import checks as ck
from tcontact.show import plots

SHARE = 0.6  # of the time in which the waves at the wall are alone
# young [Pa], poisson, density, Y0 [Pa], H [Pa], c [J/(kg K)], shock curve
METALS = {
    "steel": (200e9, 0.3, 7850.0, 300e6, 1e9, 470.0, tc.MieGrueneisen(1.49, 2.17)),
    "copper": (124e9, 0.34, 8930.0, 90e6, 0.0, 385.0, tc.MieGrueneisen(1.489, 2.0, sound_speed=3940.0)),
}
EQUATIONS = {"steel": "bulk", "copper": "mie-grueneisen"}


@checked
def scene(
    *,
    cells: int = 100,
    kind: choices.Kind = "hex8",
    formulation: Literal["auto", "full", "reduced", "mean-dilatation"] = "auto",
    metal: Literal["steel", "copper"] = "steel",
    equation: Literal["bulk", "barrier", "mie-grueneisen"] | None = None,
    speed: float | None = None,
    linear: float = 0.15,
    quadratic: float = 1.5,
    heat_share: float = 1.0,
    length: float = 0.1,
    gap: float = 1e-6,
    contact: choices.Contact = "massless",
    removal: choices.Removal = "auto",
    penalty: float | None = None,
    depth: int = 1,
    sweeps: int = 10,
    tolerance: float | None = None,
) -> tc.Scene:
    """A square column of a metal, all its `cells` cells along its length, flies down from `gap` above the plane z = 0.

    SI units. formulation: auto = mean-dilatation for hexes; equation: of state, None = bulk for steel, mie-grueneisen
    for copper; speed: None = 50 m/s for steel, 500 m/s for copper; linear, quadratic: of the bulk viscosity, both 0 =
    none; penalty: None = exact, else multiples of young/h (contact=penalty: None = 10).
    """
    if metal not in METALS:
        raise tc.InputError("metal", metal, "use one of " + ", ".join(METALS))
    words = {"bulk": "bulk", "barrier": "barrier", "mie-grueneisen": METALS[metal][6]}
    equation = EQUATIONS[metal] if equation is None else equation
    if equation not in words:
        raise tc.InputError("equation", equation, "use one of " + ", ".join(words))
    young, poisson, density, strength, modulus, heat, _curve = METALS[metal]
    speed = {"steel": 50.0, "copper": 500.0}[metal] if speed is None else speed
    choices.positive(length=length, cells=cells, speed=speed)
    choices.not_negative(gap=gap, linear=linear, quadratic=quadratic)
    material = tc.ElastoPlastic(
        young,
        poisson,
        density,
        tc.LinearHardening(strength, modulus),
        heat_share=heat_share,
        specific_heat=heat,
        pressure=words[equation],
    )
    side = length / 8.0
    mesh = tc.box_mesh(size=(side, side, length), cells=(1, 1, cells), kind=kind, origin=(-side / 2, -side / 2, gap))
    held = [tc.Support(f"{axis}{end}", axis) for axis in "xy" for end in ("min", "max")]
    model = choices.contact_model(
        contact,
        removal=removal,
        penalty=penalty,
        unit=young * cells / length,
        depth=depth,
        sweeps=sweeps,
        tolerance=tolerance,
    )
    chosen = None if formulation == "auto" else formulation
    plate = tc.Body(mesh, material, (0.0, 0.0, -speed), contact="zmin", supports=held, name="plate", formulation=chosen)
    shock = MetalShock(material, speed)
    alone = 2.0 * length / (max(shock.elastic_speed, shock.shock_speed) + shock.shock_speed)
    viscosity = tc.BulkViscosity(linear, quadratic) if linear > 0.0 or quadratic > 0.0 else None
    return tc.Scene(
        bodies=[plate],
        obstacles=[tc.Plane()],
        duration=gap / speed + SHARE * alone,
        contact=model,
        viscosity=viscosity,
    )


def exact(scene: tc.Scene) -> tuple[MetalShock, float, float]:
    """Return the exact waves, the time of touch [s] and the force at the wall [N]."""
    body = scene.bodies[0]
    speed, size = -body.velocity[2], np.ptp(body.mesh.nodes, axis=0)
    shock = MetalShock(body.material, speed)
    touch = scene.obstacles[0].gap(body.mesh.nodes).min() / speed
    return shock, touch, shock.behind.stress * size[0] * size[1]


def profile(result: tc.Result) -> dict[str, np.ndarray]:
    """Return by layer of cells at the end: height at rest above the lower end [m], J, plastic strain, temperature."""
    mesh = result.scene.bodies[0].mesh
    bottom, top = mesh.nodes[:, 2].min(), mesh.nodes[:, 2].max()
    count = choices.cells_of(mesh)
    h = (top - bottom) / count
    level = np.rint((mesh.nodes[:, 2] - bottom) / h).astype(int)
    place = np.bincount(level, result.position[:, 2]) / np.bincount(level)
    layer = ((mesh.nodes[mesh.cells, 2].mean(axis=1) - bottom) / h).astype(int)
    found = {"height": h * (np.arange(count) + 0.5), "volume ratio": np.diff(place) / h}
    for name, values in result.metals.items():
        found[name.replace("_", " ")] = np.bincount(layer, values) / np.bincount(layer)
    return found


def front(result: tc.Result) -> float:
    """Return the height at rest [m] of the plastic shock at the end: plastic strain half that behind it."""
    shock, _, _ = exact(result.scene)
    now = profile(result)
    half = 0.5 * shock.behind.strain
    behind = np.flatnonzero(now["plastic strain"] >= half)
    last = behind[-1] if len(behind) else 0
    if not 0 < last < len(now["height"]) - 1:
        return float("nan")
    one, two = now["plastic strain"][last : last + 2]
    return float(now["height"][last] + (one - half) / (one - two) * (now["height"][1] - now["height"][0]))


def curves(result: tc.Result) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the contact force by the jump conditions, to plot."""
    _, touch, force = exact(result.scene)
    return {"jump conditions": (np.array([0, touch, touch, result.scene.duration]), force * np.array([0, 0, 1, 1]))}


def draw(result: tc.Result, folder: Path, title: str) -> None:
    """Draw volume ratio, plastic strain and temperature along the plate at the end beside the exact waves."""
    shock, touch, _ = exact(result.scene)
    now, state, metal = profile(result), shock.behind, result.scene.bodies[0].material
    ends = [speed * (result.time - touch) for speed in (shock.shock_speed, shock.elastic_speed)]
    ends[1] = max(ends)
    x = np.array([0.0, ends[0], ends[0], ends[1], ends[1], np.ptp(result.scene.bodies[0].mesh.nodes[:, 2])])
    known = {
        ("volume ratio", "-"): [1.0 - state.compression, 1.0 - shock.ahead.compression, 1.0],
        ("plastic strain", "-"): [state.strain, 0.0, 0.0],
        ("temperature", "K"): [state.temperature, metal.initial_temperature, metal.initial_temperature],
    }
    rows = {}
    for key, values in known.items():
        rows[key] = {"run": (now["height"], now[key[0]]), "exact": (x, np.repeat(values, 2))}
    plots.panels(folder / "profile.png", rows, title, ("height at rest", "m"))


def checks(result: tc.Result) -> list[ck.Check]:
    """Check the general laws; plateau, impulse, shock speed, plastic strain, temperature against the exact waves."""
    scene, history = result.scene, result.history
    found = [ck.finished(result), ck.touched(result), ck.momentum_balance(result, 1e-8), ck.pushing(result)]
    if choices.is_exact(scene):
        found.append(ck.no_overlap(result))
    if not result.ok or not isinstance(scene.contact, tc.MasslessContact):
        return found
    shock, touch, force = exact(scene)
    state, smooth = shock.behind, scene.viscosity is not None
    hot = isinstance(scene.bodies[0].material.pressure, tc.MieGrueneisen)  # its heat presses one step late
    coarse = max(1.0, 100.0 / choices.cells_of(scene.bodies[0].mesh))
    time = history["time"] - touch
    flat = time > 0.3 * time[-1]
    plateau = history["contact_force"][flat, 2] / force
    now = profile(result)
    reach = shock.shock_speed * time[-1]
    behind = (now["height"] > 0.1 * reach) & (now["height"] < 0.7 * reach)
    strain = now["plastic strain"][behind].mean() / state.strain
    found += [
        ck.energy(result, (6e-3 if hot else 3e-3) * coarse),
        ck.at_most("plateau / exact, error", abs(plateau.mean() - 1.0), 1.5e-2 * coarse),
        ck.at_most("plateau, rms", plateau.std(), 1e-2 * coarse),
        ck.at_most(
            "impulse / exact, error",
            abs(history["impulse"][-1, 2] / (force * time[-1]) - 1.0),
            2.5e-2 * coarse,
        ),
        ck.at_most(
            "plastic strain behind the shock / exact, error", abs(strain - 1.0), (0.02 if smooth else 0.1) * coarse
        ),
    ]
    if smooth:
        warm = now["temperature"][behind].mean()
        found += [
            ck.at_most("shock speed / exact, error", abs(front(result) / reach - 1.0), 0.01 * coarse),
            ck.at_most("temperature / exact, error", abs(warm / state.temperature - 1.0), 0.03 * coarse),
        ]
    return found


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "plate-impact", *sys.argv[1:]]))
