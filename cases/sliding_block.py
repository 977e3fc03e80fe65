"""An elastic block on a plane with friction: slides to a stop, holds on an incline, slides down it.

motion=stop: thrown along a level plane, it stops after v^2/(2 mu g). motion=hold: on an incline with mu just above
tan(angle) and mass damping it must not creep at all. motion=slide: from rest, undamped, a = g (sin - mu cos). The
incline is the plane z = 0 under a tilted gravity. The block starts compressed by its own weight as a column would be;
what is left to settle is small.

An elastic block on a rigid plane flutters while it slides: contact opens in turns, and what lands at another than the
sliding speed transmits less than mu times its pressure. Two things must be told apart. Flutter of the whole block, the
same at every mesh size, is physics of an undamped body: it is why a block without damping creeps down where mu is only
just above tan(angle). Flutter of single cells, faster the finer they are, is not: it comes with nodes that lose their
mass along the normal only, and the viscosity of the contact cells ends it (cell_viscosity=0 shows it: angle=21.6,
friction=0.321, cells=8 lose 5 % of the friction). From rest a block is 2 to 3 % too fast after 300 transits: that is
how it starts, at any mesh size. From friction 0.6 on some friction is lost in spite of the viscosity, and the run says
so.

compare=true shows holding beside the regularised law, which creeps, and beside the block without damping.
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
from tcontact.results import checks as ck
from tcontact.show import plots

DEFAULTS = {  # friction [-], angle [degrees], speed [m/s], damping [c/height]
    "stop": (0.3, 0.0, 1.0, 0.0),
    "hold": (0.37, 20.0, 0.0, 0.5),
    "slide": (0.2, 20.0, 0.0, 0.0),
}
STIFFNESS = 1e5  # Young's modulus in density x gravity x height
TRANSITS = 400.0  # of waves through the height in a run on the incline


@checked
def scene(
    *,
    cells: int = 4,
    motion: Literal["stop", "hold", "slide"] = "stop",
    friction: float | None = None,
    angle: float | None = None,
    speed: float | None = None,
    damping: float | None = None,
    viscosity: float = 0.0,
    slip_speed: float | None = None,
    kind: choices.Kind = "hex8",
    young: float | None = None,
    poisson: float = 0.3,
    density: float = 1000.0,
    height: float = 1.0,
    gravity: float = 9.81,
    contact: choices.Contact = "massless",
    removal: choices.Removal = "auto",
    penalty: float | None = None,
    sweeps: int = 10,
    cell_viscosity: float | None = None,
    tolerance: float | None = None,
    duration: float | None = None,
) -> tc.Scene:
    """A block half as long again as it is high and wide, `cells` cells high (linear law), lies on a plane.

    SI units, angle in degrees. None = what the motion asks for: friction .3 | .37 | .2, angle 0 | 20 | 20, speed down
    the plane 1 | 0 | 0, mass damping 0 | .5 | 0 in wave speed/height; young: 1e5 density gravity height; duration:
    to a fifth after the stop, or 400 wave transits of the height. viscosity: linear bulk viscosity; slip_speed: of the
    regularised law, None = Coulomb's; penalty: multiples of young/h; cell_viscosity: of the contact cells, in their
    height over the wave speed (None: 0.2 with normal removal).
    """
    if motion not in DEFAULTS:
        raise tc.InputError("motion", motion, "use one of " + ", ".join(DEFAULTS))
    given = (friction, angle, speed, damping)
    friction, angle, speed, damping = (
        usual if value is None else value for value, usual in zip(given, DEFAULTS[motion], strict=True)
    )
    choices.positive(height=height, gravity=gravity, density=density, cells=cells)
    choices.not_negative(damping=damping, viscosity=viscosity)
    if not 0.0 <= angle < 90.0:
        raise tc.InputError("angle", angle, "give degrees from 0 to below 90")
    steep = np.tan(np.radians(angle))
    if motion == "stop" and not (friction * speed > 0.0 and steep < friction):
        raise tc.InputError("friction", friction, "a block stops if it moves down with friction above tan(angle)")
    if motion == "hold" and not steep < friction:
        remedy = f"a block holds with friction above tan(angle), {steep:.4g} here; or take motion=slide"
        raise tc.InputError("friction", friction, remedy)
    if motion == "slide" and not friction < steep:
        remedy = f"a block slides off with friction below tan(angle), {steep:.4g} here; or take motion=hold"
        raise tc.InputError("friction", friction, remedy)
    material = choices.material(
        "linear", STIFFNESS * density * gravity * height if young is None else young, poisson, density
    )
    down, press = gravity * np.sin(np.radians(angle)), gravity * np.cos(np.radians(angle))
    mesh = tc.box_mesh((1.5 * height, height, height), (max(1, round(1.5 * cells)), cells, cells), kind)
    model = choices.contact_model(
        contact,
        removal=removal,
        penalty=penalty,
        unit=material.young * cells / height,
        depth=1,
        sweeps=sweeps,
        tolerance=tolerance,
        cell_viscosity=cell_viscosity,
    )
    if duration is None:
        stopping = speed / (friction * press - down) if motion == "stop" else 0.0
        duration = 1.2 * stopping + (0.0 if motion == "stop" else TRANSITS * height / material.wave_speed)

    def sag(nodes: np.ndarray) -> np.ndarray:
        z = nodes[:, 2]
        shortening = material.density * press / material.young * (height * z - z**2 / 2.0)
        return np.stack([0.0 * z, 0.0 * z, -shortening], axis=1)

    block = tc.Body(mesh, material, (speed, 0.0, 0.0), contact="zmin", displacement=sag, name="block")
    law = tc.Coulomb(friction) if slip_speed is None else tc.RegularizedCoulomb(friction, slip_speed)
    return tc.Scene(
        [block],
        [tc.Plane()],
        duration=duration,
        gravity=(down, 0.0, -press),
        contact=model,
        friction=law,
        damping=tc.MassDamping(damping * material.wave_speed / height) if damping > 0.0 else None,
        viscosity=tc.BulkViscosity(linear=viscosity, quadratic=0.0) if viscosity > 0.0 else None,
    )


def comparison(**parameters: object) -> dict[str, tc.Scene]:
    """Compare holding on the incline by Coulomb's law, by the regularised law, which creeps, and without damping."""
    parameters = {"motion": "hold"} | parameters
    slip_speed = parameters.pop("slip_speed", None)
    undamped = parameters | {"damping": 0.0}
    return {
        "Coulomb": scene(**parameters),
        "regularised": scene(**parameters, slip_speed=1e-3 if slip_speed is None else slip_speed),
        "Coulomb, undamped": scene(**undamped),
    }


def compared(result: tc.Result) -> dict[tuple[str, str], tuple[np.ndarray, np.ndarray]]:
    """Return what tells the runs apart: distance and speed of the centre, which creeps or rests, and the friction."""
    time, force = result.history["time"], result.history["contact_force"]
    path, speed = travel(result)
    weight = ck.mass(result) * -result.scene.gravity[2]
    return {
        ("distance", "m"): (time, path),
        ("speed", "m/s"): (time, speed),
        ("friction / weight", "-"): (time, -force[:, 0] / weight),
    }


def travel(result: tc.Result) -> tuple[np.ndarray, np.ndarray]:
    """Return distance [m] and speed [m/s] of the centre of mass along the plane in every row."""
    time = result.history["time"]
    speed = result.history["momentum"][:, 0] / ck.mass(result)
    path = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))])
    return path, speed


def rigid(scene: tc.Scene) -> tuple[float, float, float]:
    """Return acceleration [m/s^2] of a rigid block that slides, time [s] and distance [m] to its stop (inf: none)."""
    down, press, speed = scene.gravity[0], -scene.gravity[2], scene.bodies[0].velocity[0]
    acceleration = down - scene.friction.coefficient * press
    if acceleration >= 0.0:
        return acceleration, np.inf, np.inf
    return acceleration, speed / -acceleration, speed**2 / (-2.0 * acceleration)


def curves(result: tc.Result) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the weight that the plane carries, to plot."""
    weight = ck.mass(result) * -result.scene.gravity[2]
    return {"weight across the plane": (np.array([0.0, result.time]), np.array([weight, weight]))}


def draw(result: tc.Result, folder: Path, title: str) -> None:
    """Draw distance and speed of the centre and friction over pressure, beside those of a rigid block."""
    scene, time = result.scene, result.history["time"]
    acceleration, stop, _ = rigid(scene)
    start = scene.bodies[0].velocity[0]
    moving = np.minimum(time, stop) if acceleration < 0.0 else time
    limit = scene.friction.coefficient * np.where(time <= stop, 1.0, 0.0)
    if stop == 0.0 or (start == 0.0 and acceleration < 0.0):
        limit = np.full_like(time, scene.gravity[0] / -scene.gravity[2])
    block = {
        ("distance", "m"): moving * (start + acceleration * moving / 2),
        ("speed", "m/s"): start + acceleration * moving,
        ("friction / weight", "-"): limit,
    }
    found = compared(result)
    panels = {name: {"computed": found[name], "rigid block": (time, block[name])} for name in block}
    plots.panels(folder / "motion.png", panels, title)


def checks(result: tc.Result) -> list[ck.Check]:
    """Check the general laws, |t| <= mu lambda, and what the motion must be: distance, rest or acceleration."""
    scene, history = result.scene, result.history
    mu = scene.friction.coefficient
    quick = result.dt > 0.25 * result.dt_limit
    found = [ck.finished(result), ck.touched(result), ck.momentum_balance(result, 1e-5), ck.pushing(result)]
    if choices.is_exact(scene):
        found.append(ck.no_overlap(result))
    settling = scene.bodies[0].velocity[0] == 0.0 and rigid(scene)[0] < 0.0  # little energy, most of it dissipated
    found.append(ck.energy(result, (6e-2 if settling else 4e-3) if quick else 4e-3))
    pressed = np.maximum(history["contact_force"][:, 2], 0.0)
    excess = np.linalg.norm(history["contact_force"][:, :2], axis=1) - mu * pressed
    found.append(ck.at_most("friction beyond mu x pressure", excess.max() / pressed.max(), 1e-6))
    if not (result.ok and isinstance(scene.contact, tc.MasslessContact)) or not isinstance(scene.friction, tc.Coulomb):
        return found
    path, speed = travel(result)
    acceleration, stop, distance = rigid(scene)
    weight = ck.mass(result) * -scene.gravity[2]
    found.append(ck.between("mean pressure / weight", history["impulse"][-1, 2] / (weight * result.time), 0.98, 1.02))
    length = np.ptp(scene.bodies[0].mesh.nodes[:, 0])
    if acceleration > 0.0 and scene.damping is None:
        gained = (speed[-1] - speed[0]) / result.time / acceleration
        found.append(ck.between("acceleration / rigid", gained, 0.99, 1.01))
    elif 0.0 < stop < 0.9 * result.time and scene.damping is None:
        late = path[history["time"] > 1.1 * stop]
        found.append(ck.between("stop distance / rigid", late[-1] / distance, 0.98, 1.025))
        rest = abs(late[-1] - late[0]) / (result.time - 1.1 * stop)
        found.append(ck.at_most("mean speed after the stop / speed", rest / scene.bodies[0].velocity[0], 1e-3))
    elif settling and scene.damping is not None:
        drift = np.ptp(path[len(path) // 2 :])
        found.append(ck.at_most("drift, second half / length", drift / length, 1e-9))
    return found


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "sliding-block", *sys.argv[1:]]))
