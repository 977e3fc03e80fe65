"""Two blocks of 304 steel slide on each other under 1.3 GPa: friction heats a layer, the layer warms both blocks.

The blocks start on the verge of yield, as metal behind a plane wave; smooth walls confine them on all sides but the one
that they share, and drive them past each other at a constant speed. Between them a friction layer with two sides bears
what a thin film of hot metal bears; the heat that it does not keep warms the cells behind it, and plastic flow warms
them too (Steinberg and Guinan, in the film and in the blocks). No joule is missing:

    heat of the layers + heat given to the blocks + heat of plastic flow + cold work = friction work + plastic work

What the blocks have uncovered at their ends has nothing to press on, and flows.
"""

from __future__ import annotations

import sys
from pathlib import Path

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np

import tcontact as tc
from tcontact.cases import _choices as choices
from tcontact.cases._inputs import checked
from tcontact.friction_layer import STAINLESS_304
from tcontact.results import checks as ck
from tcontact.show import plots

SCHEME = {"scheme": "central-difference", "cfl": 0.2}


VERGE = 0.95  # von Mises stress at the start over the yield stress


@checked
def scene(
    *,
    cells: int = 8,
    speed: float = 34.0,
    pressure: float = 1.3e9,
    coefficient: float = 0.3,
    height: float = 2e-3,
    heat_share: float = 0.9,
    points: int = 40,
    thickness: float = 3e-6,
    tolerance: float = 1e-2,
    removal: choices.Removal = "auto",
    duration: float = 6e-7,
) -> tc.Scene:
    """Blocks twice as long as high in plane strain, the upper one `cells` cells high, the lower one half as many more.

    SI units. speed: of the blocks past each other; pressure: between them at the start; heat_share: of the plastic work
    of the blocks that becomes heat; points, thickness, tolerance, coefficient: of the layer.
    """
    choices.positive(height=height, cells=cells, pressure=pressure, speed=speed, duration=duration)
    metal = tc.metal("stainless-304", heat_share=heat_share)
    layer = tc.FrictionLayer(coefficient=coefficient, points=points, thickness=thickness, tolerance=tolerance)
    bodies = [
        _block("upper", metal, pressure, height, cells, 0.5 * speed),
        _block("lower", metal, pressure, height, max(1, round(1.5 * cells)), -0.5 * speed),
    ]
    contact = tc.MasslessContact(removal)
    return tc.Scene(bodies, duration=duration, contact=contact, friction=layer, pairs=[tc.Pair("upper", "lower")])


def _block(name: str, metal: tc.ElastoPlastic, pressure: float, height: float, cells: int, speed: float) -> tc.Body:
    """Return a block, squeezed without a displacement of the face that it shares, and the walls that drive it."""
    upper = name == "upper"
    size = np.array((2.0 * height, height / 4.0, height))
    mesh = tc.box_mesh(tuple(size), (2 * cells, 1, cells), origin=(0.0, 0.0, 0.0 if upper else -height))
    mises = min(VERGE * metal.hardening.yield_stress, pressure)
    volume = np.log1p((2.0 / 3.0 * mises - pressure) / metal.bulk_modulus)
    shape = mises / (6.0 * metal.lame_mu)
    stretches = np.exp(volume / 3.0 + np.array((shape, shape, -2.0 * shape)))
    walls = [tc.Support(side, "x", speed) for side in ("xmin", "xmax")]
    walls += [tc.Support(side, "y") for side in ("ymin", "ymax")]
    walls.append(tc.Support("zmax" if upper else "zmin", "xz", (speed, 0.0)))
    return tc.Body(
        mesh,
        metal,
        (speed, 0.0, 0.0),
        contact="zmin" if upper else "zmax",
        supports=walls,
        name=name,
        displacement=lambda nodes: (stretches - 1.0) * (nodes - 0.5 * size * (1.0, 1.0, 0.0)),
        metal=STAINLESS_304,
    )


def tractions(result: tc.Result) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean pressure and shear [Pa] of the area that the blocks share, in every row."""
    upper, lower = result.scene.bodies
    face = upper.initial_nodes[upper.contact_nodes]
    length, width = np.ptp(face, axis=0)[:2]
    way = result.history["time"] * (upper.velocity[0] - lower.velocity[0])
    force = result.pair_force["upper-lower"] / (width * (length - way))[:, None]
    return force[:, 2], -force[:, 0]


def squeeze(scene: tc.Scene) -> float:
    """Return the elastic pressure [Pa] across the sliding plane in a block at the start."""
    body = scene.bodies[0]
    across, _, along = np.ptp(body.initial_nodes, axis=0) / np.ptp(body.mesh.nodes, axis=0)
    volume = across * across * along
    metal = body.material
    return float(metal.bulk_modulus * (1.0 - volume) + 4.0 / 3.0 * metal.lame_mu * np.log(across / along))


def joules(result: tc.Result) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Return where the heat and the cold work stand, in every row, and the work of friction and plastic flow [J]."""
    history, metal = result.history, result.scene.bodies[0].material
    stand = {
        "layers": history["layer_heat"],
        "blocks, from the layers": history["body_heat"],
        "blocks, of plastic flow": history["plastic_heat"],
        "cold work": (1.0 - metal.heat_share) * history["plastic_work"],
    }
    return stand, history["friction_work"] + history["plastic_work"]


def draw(result: tc.Result, folder: Path, title: str) -> None:
    """Draw tractions, temperatures, and where the work has gone; plastic strain and temperature of cells, as frames."""
    history, time = result.history, result.history["time"]
    stand, _work = joules(result)
    pressure, shear = tractions(result)
    rows = {
        ("pressure", "Pa"): {"mean": (time, pressure)},
        ("shear", "Pa"): {"mean": (time, shear), "softest layer": (time, history["layer_shear_min"])},
        ("temperature", "K"): {
            "hottest layer": (time, history["layer_temperature_max"]),
            "hottest cell": (time, history["temperature_max"]),
        },
        ("heat", "J"): {name: (time, part) for name, part in stand.items()},
    }
    plots.panels(folder / "sliding.png", rows, title)
    if (folder / "result.vtkhdf").exists():
        from tcontact.results.files.vtkhdf import ResultData
        from tcontact.show.render import render_frames

        data = ResultData.open(folder / "result.vtkhdf")
        for field in ("plastic_strain", "temperature") if len(data) else ():
            render_frames(folder / "result.vtkhdf", folder / field, field, view="above", animation=False, title=title)


def checks(result: tc.Result) -> list[ck.Check]:
    """Check the general laws, where every joule stands, and that the layers bear at most mu p and do not melt."""
    scene, history = result.scene, result.history
    found = [
        ck.finished(result),
        ck.momentum_balance(result, 1e-6),
        ck.no_pull(result, "upper-lower", np.array((0.0, 0.0, 1.0))),
        ck.energy(result, 4e-3),
    ]
    if not result.ok:
        return found
    stand, work = joules(result)
    motion = sum(0.5 * body.mass * body.velocity[0] ** 2 for body in scene.bodies)
    missing = np.abs(sum(stand.values()) - work).max() / max(history["friction_work"].max(), 1e-300)
    force, model = np.abs(result.pair_force["upper-lower"]), scene.friction
    return [
        *found,
        ck.between("kinetic energy at the start / m v^2/2", history["kinetic"][0] / motion, 1.0 - 1e-6, 1.0 + 1e-6),
        ck.between("pressure at the start / squeeze", tractions(result)[0][0] / squeeze(scene), 0.99, 1.01),
        ck.equals("static solves not converged", int((history["static_residual"] > 1e-4).sum()), 0),
        ck.at_most("joules missing, of the friction work", float(missing), 1e-6),
        ck.at_most(
            "shear over mu times the pressure", (force[:, 0] / force[:, 2]).max() / model.coefficient, 1.0 + 1e-9
        ),
        ck.at_most(
            "hottest layer over melting",
            history["layer_temperature_max"].max() / STAINLESS_304.melting_temperature,
            1.0,
        ),
    ]


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "metal-slide", *sys.argv[1:]]))
