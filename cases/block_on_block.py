"""A block slides on another one, drags it along by friction, and comes to rest on it.

The lower block is free to move along a smooth floor. While the upper one slides, rigid blocks would have the relative
deceleration mu g (1 + m1/m2); they end with the common velocity m1 V/(m1 + m2), and friction turns the kinetic energy
of the relative motion into heat. The meshes do not match, and the direction of sliding is not that of the cells. Both
blocks start compressed by the weight as columns would be; what is left to settle is small.
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
from tcontact.results import checks as ck
from tcontact.show import plots

STIFFNESS = 1e5  # Young's modulus of the upper block in density x gravity x height
UPPER = np.array((1.5, 1.0, 1.0))  # size of the blocks over the height of the upper one
LOWER = np.array((3.0, 2.0, 0.5))
AFTER = 1.3  # duration over the time after which rigid blocks move together


@checked
def scene(
    *,
    cells: int = 4,
    lower_cells: int | None = None,
    kind: choices.Kind = "hex8",
    friction: float = 0.3,
    speed: float = 1.0,
    direction: float = 20.0,
    turn: float = 17.0,
    young: float | None = None,
    stiffness: float = 1.0,
    poisson: float = 0.3,
    density: float = 1000.0,
    height: float = 1.0,
    gravity: float = 9.81,
    contact: choices.ContactBetween = "massless",
    removal: choices.Removal = "auto",
    penalty: float | None = None,
    cell_viscosity: float | None = None,
    tolerance: float | None = None,
) -> tc.Scene:
    """The upper block, `cells` cells high, slides on the lower one, with `lower_cells` a height (None: 3/4 as many).

    SI units. direction: of the velocity [degrees] from the long edge of the lower block; turn: of the upper block about
    the vertical [degrees]; young: modulus of the upper block, None is 1e5 density gravity height; stiffness: modulus of
    the lower block over that of the upper one; penalty: of contact=penalty, on nodes with their ordinary mass, in
    multiples of young/h of the slave (None = 10); cell_viscosity: of the contact cells (None: 0.2 with normal removal).
    """
    choices.positive(cells=cells, lower_cells=lower_cells, friction=friction, speed=speed, stiffness=stiffness)
    choices.positive(density=density, height=height, gravity=gravity)
    young = STIFFNESS * density * gravity * height if young is None else young
    pressure = density * gravity * height * UPPER.prod() / LOWER[:2].prod()
    for name, value, modulus, load in (
        ("young", young, young, density * gravity * height),
        ("stiffness", stiffness, stiffness * young, pressure + density * gravity * LOWER[2] * height),
    ):
        if not load < 0.5 * modulus:
            raise tc.InputError(
                name, value, f"the block would be pressed flat: give more than {2.0 * value * load / modulus:g}"
            )
    laws = [choices.material("linear", modulus, poisson, density) for modulus in (young, stiffness * young)]
    counts = [np.maximum(1, np.round(UPPER * cells).astype(int)),
              np.maximum(1, np.round(LOWER * (lower_cells or 0.75 * cells)).astype(int))]  # fmt: skip
    sizes = [UPPER * height, LOWER * height]
    meshes = [
        tc.box_mesh(size, tuple(map(int, count)), kind, (-size[0] / 2, -size[1] / 2, start))
        for size, count, start in zip(sizes, counts, (0.0, -sizes[1][2]), strict=True)
    ]
    meshes[0] = meshes[0].rotated(((0, 0, 1), np.radians(turn)))

    def lower_sag(nodes: np.ndarray) -> np.ndarray:
        return _sag(nodes[:, 2] + sizes[1][2], sizes[1][2], density * gravity, pressure, laws[1].young)

    def upper_sag(nodes: np.ndarray) -> np.ndarray:
        below = lower_sag(np.zeros((1, 3)))
        return below + _sag(nodes[:, 2], sizes[0][2], density * gravity, 0.0, laws[0].young)

    along = np.array([np.cos(np.radians(direction)), np.sin(np.radians(direction)), 0.0])
    upper = tc.Body(meshes[0], laws[0], speed * along, contact="zmin", displacement=upper_sag, name="upper")
    lower = tc.Body(meshes[1], laws[1], contact=("zmin", "zmax"), displacement=lower_sag, name="lower")
    ratio = UPPER.prod() / LOWER.prod()
    found = tc.Scene(
        [upper, lower],
        [tc.Plane((0, 0, -sizes[1][2]))],
        duration=AFTER * speed / (friction * gravity * (1.0 + ratio)),
        gravity=(0, 0, -gravity),
        contact=tc.MasslessContact(removal, cell_viscosity=cell_viscosity, tolerance=tolerance),
        pairs=[tc.Pair("upper", "lower", friction=tc.Coulomb(friction))],
    )
    return choices.with_penalty(found, contact, penalty)


def comparison(**parameters: object) -> dict[str, tc.Scene]:
    """Compare contact nodes without mass with penalties of 1 and 10 young/h on ordinary mass."""
    return choices.beside_penalties(scene, parameters)


def _sag(z: np.ndarray, height: float, weight: float, pressure: float, young: float) -> np.ndarray:
    """Return the displacement of a column under its weight [N/m^3] and a pressure on its top, at heights z."""
    shortening = (weight * (height * z - z**2 / 2.0) + pressure * z) / young
    return np.stack([0.0 * z, 0.0 * z, -shortening], axis=1)


def _masses(scene: tc.Scene) -> list[float]:
    """Return the masses [kg] of the two boxes."""
    upper, lower = scene.bodies
    ratio = upper.material.density / lower.material.density * UPPER.prod() / LOWER.prod()
    mass = lower.material.density * np.ptp(lower.mesh.nodes, axis=0).prod()
    return [ratio * mass, mass]


def motion(result: tc.Result) -> tuple[np.ndarray, np.ndarray]:
    """Return the velocities [m/s] of the centres of the two blocks along the start velocity in every row."""
    scene, history = result.scene, result.history
    masses = _masses(scene)
    start = np.asarray(scene.bodies[0].velocity)
    along = start / np.linalg.norm(start)
    force = result.pair_force["upper-lower"] @ along
    impulse = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(history["time"]))])
    return start @ along + impulse / masses[0], -impulse / masses[1]


def rigid(scene: tc.Scene) -> tuple[float, float, float]:
    """Return relative deceleration [m/s^2], common velocity [m/s] and lost energy [J] of rigid blocks."""
    first, second = _masses(scene)
    speed = float(np.linalg.norm(scene.bodies[0].velocity))
    deceleration = scene.pairs[0].friction.coefficient * -scene.gravity[2] * (1.0 + first / second)
    return deceleration, first * speed / (first + second), 0.5 * first * second / (first + second) * speed**2


def draw(result: tc.Result, folder: Path, title: str) -> None:
    """Draw the velocities of both blocks and the friction over the pressure, beside those of rigid blocks."""
    time, scene = result.history["time"], result.scene
    upper, lower = motion(result)
    deceleration, common, _lost = rigid(scene)
    stop = upper[0] / deceleration
    exact = np.array([0.0, stop, result.time])
    force = result.pair_force["upper-lower"]
    weight = _masses(scene)[0] * -scene.gravity[2]
    mu = scene.pairs[0].friction.coefficient
    panels = {
        ("velocity", "m/s"): {
            "upper block": (time, upper),
            "lower block": (time, lower),
            "rigid upper": (exact, np.array([upper[0], common, common])),
            "rigid lower": (exact, np.array([0.0, common, common])),
        },
        ("friction / weight", "-"): {
            "computed": (time, np.linalg.norm(force[:, :2], axis=1) / weight),
            "rigid blocks": (np.array([0.0, stop, stop, result.time]), mu * np.array([1.0, 1.0, 0.0, 0.0])),
        },
    }
    plots.panels(folder / "motion.png", panels, title)


def checks(result: tc.Result) -> list[ck.Check]:
    """Check energy and momentum, |t| <= mu lambda, deceleration, common velocity and work against rigid blocks."""
    scene, history = result.scene, result.history
    found = [ck.finished(result), ck.energy(result, 1e-2), ck.momentum_balance(result, 1e-6)]
    if choices.is_exact(scene):
        height = np.ptp(scene.bodies[0].mesh.nodes[:, 2])
        force = result.pair_force["upper-lower"]
        excess = np.linalg.norm(force[:, :2], axis=1) - scene.pairs[0].friction.coefficient * force[:, 2]
        # with full removal normals turn with the faces, and the static solve stops at a residual
        exact = max(1e-6, 10.0 * history["static_residual"].max() if scene.contact.removal == "full" else 0.0)
        found += [
            ck.at_most("overlap / height", max(0.0, -history["gap_min"].min()) / height, 1e-8),
            ck.at_most("friction beyond mu x pressure", excess.max() / force[:, 2].max(), exact),
        ]
    if not result.ok:
        return found
    time = history["time"]
    upper, lower = motion(result)
    deceleration, common, lost = rigid(scene)
    slides = time < 0.8 * upper[0] / deceleration
    slope = -np.polyfit(time[slides], (upper - lower)[slides], 1)[0]
    late = time > 1.1 * upper[0] / deceleration
    ends = np.array([part[late].mean() for part in (upper, lower)])
    found += [
        ck.between("relative deceleration / rigid", slope / deceleration, 0.97, 1.03),
        ck.at_most("end velocities against the common one / start", np.abs(ends - common).max() / upper[0], 0.02),
        ck.between("work of friction / energy that rigid blocks lose", history["friction_work"][-1] / lost, 0.9, 1.05),
    ]
    return found


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "block-on-block", *sys.argv[1:]]))
