"""A metal plate strikes another one obliquely: friction stress against slip, by normal and transverse plane waves.

The pressure-shear friction experiment in the kind of Irfan and Prakash (2000): until the wave comes back from the
nearer free surface the impact gives the pressure, and the friction sends a transverse wave into both plates. With the
components v_n and v_t of the speed and the impedances rho c of the two plates, Z = Z1 Z2/(Z1 + Z2), elastic plates have

    p = Z_p v_n,   tau = min(Z_s v_t, what friction transmits),   slip = v_t - tau/Z_s

exactly: rho c_p v_n/2 and rho c_s v_t/2 for equal plates that stick, mu p where dry friction slides. The plates are so
wide that waves from their edges come too late: one cell fills the width, and its lateral inertia holds it.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np

import tcontact as tc
from tcontact.cases import _choices as choices
from tcontact.cases._inputs import checked
from tcontact.friction_layer import ALUMINIUM_6061, COPPER, STAINLESS_304
from tcontact.results import checks as ck
from tcontact.show import plots

METALS = {"stainless-304": STAINLESS_304, "copper-ofhc-half-hard": COPPER, "aluminium-6061-t6": ALUMINIUM_6061}
Plate = Literal["stainless-304", "copper-ofhc-half-hard", "aluminium-6061-t6"]
WIDTH = 40.0  # width of the plates over the thickness of one
SEEN = 0.9  # the run ends at this share of the time in which the normal wave comes back


@checked
def scene(
    *,
    cells: int = 40,
    speed: float = 100.0,
    angle: float = 30.0,
    friction: Literal["layer", "coulomb"] = "layer",
    coefficient: float = 0.3,
    law: Literal["plastic", "elastic"] = "plastic",
    flyer: Plate = "stainless-304",
    target: Plate = "stainless-304",
    thickness: float = 2e-3,
    gap: float = 1e-7,
    removal: choices.Removal = "auto",
    tolerance: float | None = None,
) -> tc.Scene:
    """The upper plate, with `cells` cells through its thickness, flies on the lower one, with half as many more.

    SI units. angle: between velocity and normal [degrees]; friction: by layers with two sides, whose heat warms the
    plates if they are plastic, or dry; coefficient: mu, of dry friction and the most that a layer transmits; law:
    Steinberg and Guinan, or linear elasticity.
    """
    choices.positive(cells=cells, speed=speed, thickness=thickness)
    choices.not_negative(gap=gap, coefficient=coefficient)
    if not 0.0 <= angle < 90.0:
        raise tc.InputError("angle", angle, "give degrees from the normal, at least 0 and below 90")
    for name, given, known in (
        ("friction", friction, ("layer", "coulomb")),
        ("law", law, ("plastic", "elastic")),
        ("flyer", flyer, tuple(METALS)),
        ("target", target, tuple(METALS)),
    ):
        if given not in known:
            raise tc.InputError(name, given, "use one of " + ", ".join(known))
    laws: list[tc.Material] = [tc.metal(name) for name in (flyer, target)]
    if law == "elastic":
        laws = [tc.LinearElastic(metal.young, metal.poisson, metal.density) for metal in laws]
    width, turn = WIDTH * thickness, np.radians(angle)
    velocities = (speed * np.sin(turn), 0.0, -speed * np.cos(turn)), (0.0, 0.0, 0.0)
    bodies = [
        tc.Body(
            tc.box_mesh((width, width, thickness), (1, 1, count), origin=(-width / 2, -width / 2, start)),
            material,
            velocity,
            contact=side,
            supports=[tc.Support("ymin", "y"), tc.Support("ymax", "y")],
            name=name,
            metal=METALS[metal] if friction == "layer" else None,
        )
        for name, metal, material, velocity, side, count, start in zip(
            ("flyer", "target"),
            (flyer, target),
            laws,
            velocities,
            ("zmin", "zmax"),
            (cells, max(1, round(1.5 * cells))),
            (gap, -thickness),
            strict=True,
        )
    ]
    model = tc.FrictionLayer(coefficient=coefficient) if friction == "layer" else tc.Coulomb(coefficient)
    duration = gap / (speed * np.cos(turn)) + SEEN * 2.0 * thickness / max(one.wave_speed for one in laws)
    return tc.Scene(
        bodies,
        duration=duration,
        contact=tc.MasslessContact(removal, tolerance=tolerance),
        pairs=[tc.Pair("flyer", "target")],
        friction=model,
    )


@dataclass(frozen=True)
class Waves:
    """What plane elastic waves give: time of touch [s], v_n and v_t [m/s], joint impedances [Pa s/m], area [m^2].

    bulk: joint impedance of plates without any resistance to shear, the least that plastic flow leaves.
    """

    touch: float
    normal: float
    transverse: float
    pressing: float
    shearing: float
    bulk: float
    area: float

    @property
    def pressure(self) -> float:
        """Return the pressure [Pa] of elastic plates."""
        return self.pressing * self.normal

    @property
    def sticking(self) -> float:
        """Return the shear stress [Pa] of elastic plates that stick."""
        return self.shearing * self.transverse


def exact(scene: tc.Scene) -> Waves:
    """Return what plane elastic waves give for a scene of this case."""
    flyer, target = scene.bodies
    along, _, down = flyer.velocity
    size = np.ptp(flyer.mesh.nodes, axis=0)
    gap = flyer.mesh.nodes[:, 2].min() - target.mesh.nodes[:, 2].max()
    laws = [body.material for body in scene.bodies]
    bulks = [one.lame_lambda + 2.0 / 3.0 * one.lame_mu for one in laws]
    joint = [
        1.0 / sum(1.0 / np.sqrt(one.density * modulus) for one, modulus in zip(laws, moduli, strict=True))
        for moduli in ([one.lame_lambda + 2.0 * one.lame_mu for one in laws], [one.lame_mu for one in laws], bulks)
    ]
    return Waves(float(gap / -down), -down, along, *map(float, joint), float(size[0] * size[1]))


def tractions(result: tc.Result) -> tuple[np.ndarray, np.ndarray]:
    """Return pressure and shear [Pa] between the plates in every row."""
    force = result.pair_force["flyer-target"] / exact(result.scene).area
    return force[:, 2], -force[:, 0]


def slip(result: tc.Result) -> tuple[np.ndarray, np.ndarray]:
    """Return slip speed [m/s] and shear [Pa] while the plates touch, means over steps: from the work of friction."""
    _pressure, shear = tractions(result)
    mean, work = 0.5 * (shear[1:] + shear[:-1]), np.diff(result.history["friction_work"])
    rubs = mean > 1e-3 * shear.max()
    with np.errstate(divide="ignore", invalid="ignore"):
        speed = work / np.diff(result.history["time"]) / (mean * exact(result.scene).area)
    return speed[rubs], mean[rubs]


def draw(result: tc.Result, folder: Path, title: str) -> None:
    """Draw pressure and shear over time, beside elastic plates; shear against slip; heat and temperature."""
    waves, history = exact(result.scene), result.history
    time, (pressure, shear) = history["time"], tractions(result)
    step = np.array([0.0, waves.touch, waves.touch, result.time])
    shape = np.array([0.0, 0.0, 1.0, 1.0])
    limit = result.scene.friction.coefficient * pressure
    rows = {
        ("pressure", "Pa"): {"computed": (time, pressure), "elastic waves": (step, waves.pressure * shape)},
        ("shear", "Pa"): {
            "computed": (time, shear),
            "mu times pressure": (time, limit),
            "elastic plates that stick": (step, waves.sticking * shape),
        },
        ("energy", "J"): {"friction work": (time, history["friction_work"])},
    }
    heats = {"plastic_work": "plastic work", "layer_heat": "heat in the layers", "body_heat": "heat in the plates"}
    for name, label in heats.items():
        if name in history:
            rows["energy", "J"][label] = (time, history[name])
    if "layer_temperature_max" in history:
        rows["temperature", "K"] = {"hottest surface": (time, history["layer_temperature_max"])}
    plots.panels(folder / "tractions.png", rows, title)
    speed, friction = slip(result)
    lines = {"computed": (speed, friction)}
    lines["elastic waves"] = waves.transverse - np.array([0.0, waves.sticking]) / waves.shearing, (0.0, waves.sticking)
    plots.against(folder / "friction.png", lines, ("slip speed", "m/s"), ("shear", "Pa"), title)


def checks(result: tc.Result) -> list[ck.Check]:
    """Check the general laws and the waves: pressure, shear, slip and work of elastic plates; bounds of plastic ones.

    Plastic flow leaves a pressure between those of fluid and elastic plates; friction never exceeds mu p, and the heat
    is the work of friction.
    """
    scene, history, waves = result.scene, result.history, exact(result.scene)
    found = [
        ck.finished(result),
        ck.thrown(result),
        ck.momentum_balance(result, 1e-8),
        ck.no_pull(result, "flyer-target", np.array((0.0, 0.0, 1.0))),
        ck.pair_overlap(result, float(np.ptp(scene.bodies[0].mesh.nodes[:, 2])), 1e-9),
    ]
    if not result.ok:
        return found
    model, elastic = scene.friction, isinstance(scene.bodies[0].material, tc.LinearElastic)
    coarse = max(1.0, 40.0 / choices.cells_of(scene.bodies[0].mesh))
    tolerance = scene.contact.tolerance or 1e-4
    found += [
        ck.energy(result, 4e-3 * coarse),
        ck.equals("static solves not converged", int((history["static_residual"] > tolerance).sum()), 0),
    ]
    time, (pressure, shear) = history["time"], tractions(result)
    flat = time > waves.touch + 0.1 * (result.time - waves.touch)
    low, high = 1.0 - 0.01 * coarse, 1.0 + 0.01 * coarse
    plateau = pressure[flat].mean() / waves.pressure
    least = 1.0 if elastic else waves.bulk / waves.pressing
    found.append(ck.between("pressure / elastic waves", plateau, least * low, high))
    excess = (np.abs(shear) - model.coefficient * pressure)[flat].max() / waves.pressure
    found.append(ck.at_most("shear above mu p, of the pressure", excess, 1e-9))
    if waves.sticking > 0.0 and elastic and isinstance(model, tc.Coulomb):
        bears = min(waves.sticking, model.coefficient * waves.pressure)
        found.append(ck.between("shear / elastic waves", shear[flat].mean() / max(bears, 1e-300), low, high))
    work = history["friction_work"]
    if elastic:  # whatever the friction: slip = v_t - tau/Z_s
        rate = np.abs(shear) * (waves.transverse - shear / waves.shearing) * waves.area
        wanted = float((0.5 * (rate[1:] + rate[:-1]) * np.diff(time)).sum())
        given = waves.sticking * waves.transverse * waves.area * (result.time - waves.touch)
        off = abs(work[-1] - wanted) / max(given, 1e-300)
        found.append(ck.at_most("friction work less shear x slip of the waves", off, 0.02 * coarse))
    if isinstance(model, tc.FrictionLayer):
        heat = history["layer_heat"] + history.get("body_heat", 0.0)
        off = np.abs(heat - work).max() / max(float(work.max()), 1e-300)
        found.append(ck.at_most("heat less friction work, of that", off, 1e-9))
    return found


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "oblique-plate-impact", *sys.argv[1:]]))
