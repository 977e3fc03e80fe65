"""A steel block slides under pressure on a layer that heats and softens, or against dry friction.

The block is squeezed between a plane and a rigid top that it slides along with it, free of friction: with the friction
layer the plane transmits at most what a thin sheared layer of hot metal bears (some 180 MPa at 34 m/s, less as it nears
melting), dry friction transmits mu times the pressure. compare=true shows both side by side.
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
from tcontact.friction_layer import study
from tcontact.results import checks as ck
from tcontact.show import plots

STEEL = {"young": 200e9, "poisson": 0.3, "density": 7900.0}
SCHEME = {"scheme": "central-difference", "cfl": 0.2}


@checked
def scene(
    *,
    cells: int = 4,
    speed: float = 34.0,
    pressure: float = 1e9,
    friction: Literal["layer", "coulomb"] = "layer",
    coefficient: float = 0.3,
    height: float = 2e-3,
    removal: choices.Removal = "auto",
    law: choices.Law = "linear",
    points: int = 40,
    thickness: float = 10e-6,
    tolerance: float = 1e-2,
    duration: float | None = None,
) -> tc.Scene:
    """A block of 304 steel, twice as long as high and `cells` cells high, slides below a top at a fixed distance.

    SI units. speed: along the plane; pressure: of the squeezed block, uniform at the start; coefficient: mu, of dry
    friction and the most that the layer transmits; points, thickness, tolerance: of the layer; duration: None = until
    shear of 150 MPa would have stopped half of the speed, at most 2 us.
    """
    choices.positive(height=height, cells=cells, pressure=pressure, speed=speed)
    if friction not in ("layer", "coulomb"):
        raise tc.InputError("friction", friction, "use layer or coulomb")
    material = choices.material(law, STEEL["young"], STEEL["poisson"], STEEL["density"])
    mesh = tc.box_mesh((2.0 * height, height, height), (2 * cells, cells, cells))
    strain = pressure / STEEL["young"]
    if not strain < 0.5:
        raise tc.InputError("pressure", pressure, f"give less than half of young = {STEEL['young']:g} Pa")

    def squeezed(nodes: np.ndarray) -> np.ndarray:
        across = STEEL["poisson"] * strain * (nodes - mesh.nodes.mean(axis=0))
        return np.stack([across[:, 0], across[:, 1], -strain * nodes[:, 2]], axis=1)

    block = tc.Body(
        mesh,
        material,
        velocity=(speed, 0.0, 0.0),
        contact="zmin",
        displacement=squeezed,
        supports=[tc.Support("zmax", "z")],
        name="block",
    )
    model: tc.Coulomb | tc.FrictionLayer = tc.Coulomb(coefficient)
    if friction == "layer":
        model = tc.FrictionLayer(coefficient=coefficient, points=points, thickness=thickness, tolerance=tolerance)
    if duration is None:
        duration = min(2e-6, 0.5 * speed * STEEL["density"] * height / 150e6)
    return tc.Scene([block], [tc.Plane()], duration, contact=tc.MasslessContact(removal=removal), friction=model)


def comparison(**parameters: object) -> dict[str, tc.Scene]:
    """Compare the friction layer with dry friction."""
    parameters.pop("friction", None)
    return {"friction layer": scene(**parameters), "dry friction": scene(**parameters, friction="coulomb")}


def compared(result: tc.Result) -> dict[tuple[str, str], tuple[np.ndarray, np.ndarray]]:
    """Return what the friction layer changes: mean shear of the face, speed of the block, work of friction."""
    history, time = result.history, result.history["time"]
    area = float(np.prod(np.ptp(result.scene.bodies[0].mesh.nodes, axis=0)[:2]))
    return {
        ("shear", "Pa"): (time, -history["contact_force"][:, 0] / area),
        ("speed", "m/s"): (time, history["momentum"][:, 0] / ck.mass(result)),
        ("friction work", "J"): (time, history["friction_work"]),
    }


def draw(result: tc.Result, folder: Path, title: str) -> None:
    """Draw shear, speed, work and temperature over time; temperature and shear of the face from below, as frames."""
    history, time = result.history, result.history["time"]
    shear, speed, work = compared(result).values()
    rows = {
        ("shear", "Pa"): {"mean of the face": shear},
        ("speed", "m/s"): {"block": speed},
        ("energy", "J"): {"friction work": work},
    }
    if "layer_heat" in history:
        rows["shear", "Pa"]["softest layer"] = (time, history["layer_shear_min"])
        rows["energy", "J"]["heat in the layers"] = (time, history["layer_heat"])
        rows["temperature", "K"] = {"hottest surface": (time, history["layer_temperature_max"])}
    plots.panels(folder / "sliding.png", rows, title)
    if "layer_heat" in history and (folder / "result.vtkhdf").exists():
        from tcontact.results.files.vtkhdf import ResultData
        from tcontact.show.render import render_frames

        data = ResultData.open(folder / "result.vtkhdf")
        if len(data):
            for field in {"layer_temperature", "layer_shear"} & set(data.point_fields):
                render_frames(
                    folder / "result.vtkhdf", folder / field, field, view="below", animation=False, title=title
                )


def _tractions(result: tc.Result) -> list[ck.Check]:
    """Check the mean pressure against the squeeze of the start, and the shear against mu p or a layer alone at 34 m/s.

    The figures of the layer alone (`friction_layer.study.REFERENCE`, independent code) hold the speed at 34 m/s; under
    the block it drops by tau/(rho c_s), some 7 m/s, which leaves it a little cooler and stronger. Shear of mu p needs
    that the block slides: mu p below rho c_s times the speed.
    """
    history, scene = result.history, result.scene
    body, model = scene.bodies[0], scene.friction
    mesh, material, start = body.mesh, body.material, body.velocity[0]
    length, width, height = np.ptp(mesh.nodes, axis=0)
    top = np.argmax(mesh.nodes[:, 2])
    squeeze = (mesh.nodes[top, 2] - body.initial_nodes[top, 2]) / height * material.young
    shear, _, pressure = history["contact_force"].T * np.array([[-1.0], [1.0], [1.0]]) / (length * width)
    found = [ck.between("mean pressure / squeeze", pressure.mean() / squeeze, 0.97, 1.03)]
    limit = model.coefficient * squeeze
    usual = isinstance(model, tc.FrictionLayer) and model == tc.FrictionLayer(
        coefficient=model.coefficient, points=model.points, thickness=10e-6, tolerance=model.tolerance
    )
    alone = 1e6 * np.array(study.REFERENCE[34.0][1]) if usual and start == 34.0 else np.zeros(0)
    fast = history["momentum"][:, 0] > 0.5 * ck.mass(result) * start
    sliding = limit < 0.4 * np.sqrt(material.lame_mu * material.density) * start
    if sliding and (isinstance(model, tc.Coulomb) or limit < 0.9 * alone.min(initial=np.inf) < np.inf):
        rubbed = shear[fast].sum() / (model.coefficient * pressure[fast].sum())
        found.append(ck.between("shear / (mu pressure), sliding", rubbed, 0.98, 1.001))
    elif len(alone) and limit > 1.1 * alone.max():
        known = np.array(study.TIMES) < result.time
        off = np.abs(np.interp(study.TIMES, history["time"], shear) / alone - 1.0)[known]
        found.append(ck.at_most("shear against the layer alone, error", off.max(initial=0.0), 0.05))
    return found


def checks(result: tc.Result) -> list[ck.Check]:
    """Check the general laws, the squeeze of the block, and dry friction or the layer against independent figures.

    Heat is the share of the friction work; what the block loses is friction work; the surface stays below melting.
    """
    history, model = result.history, result.scene.friction
    quick = result.dt > 0.25 * result.dt_limit
    work = history["friction_work"]
    whole, viscous = history["kinetic"] + history["elastic"], history.get("viscous_work", 0.0 * work)
    ledger = np.abs(whole[0] - whole - work - viscous).max() / whole.max()
    found = [
        ck.finished(result),
        ck.thrown(result),
        ck.touched(result),
        *_tractions(result),
        ck.momentum_balance(result, 1e-5),
        ck.pushing(result),
        ck.at_most("energy lost less friction and viscous work, of the energy", float(ledger), 4e-2 if quick else 4e-3),
        ck.at_most("viscous work of the contact cells, of the energy", float(viscous.max() / whole.max()), 2e-2),
    ]
    if isinstance(model, tc.FrictionLayer):
        off = np.abs(history["layer_heat"] - model.heat_share * work).max() / max(float(work.max()), 1e-300)
        melting = model.material.melting_temperature
        found.append(ck.at_most("heat less its share of the friction work, of that", float(off), 1e-12))
        hottest = float(history["layer_temperature_max"].max())
        found.append(ck.at_most("hottest surface over melting", hottest / melting, 1.0))
    return found


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "hot-slide", *sys.argv[1:]]))
