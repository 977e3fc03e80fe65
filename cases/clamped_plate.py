"""An elastic ball falls on a round plate clamped at its rim, both of tetrahedra, against Hertz's spring on thin modes.

The plate comes from a mesh file: one that the case writes for Gmsh and reads again, or a file of one's own. A thin
plate (Kirchhoff) of radius R, thickness h, stiffness D = E h^3/(12 (1 - nu^2)) swings in the modes

    W = J0(k r) - J0(k R)/I0(k R) I0(k r),   J0 I1 + J1 I0 = 0 at k R,   omega = k^2 sqrt(D/(rho h))

between which and the ball stands Hertz's spring F = 4/3 E* sqrt(r) d^1.5 with 1/E* = 2 (1 - nu^2)/E (as Zener 1941 for
an infinite plate). The plate gives way, swings back and hits the ball again. Shear, which the thin plate has not, makes
the real one softer by some per cent; tetrahedra make it stiffer, by 15 % with three layers, a tenth with four, more
where Poisson's ratio is large. The force, of a contact half as wide as the plate is thick, is up to 15 % larger. The
linear law leaves out the stretching of the middle plane, a tenth at a deflection of half the thickness.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import meshio
import numpy as np
from scipy.optimize import brentq
from scipy.special import i0, i1, j0, j1

import tcontact as tc
from tcontact.cases import _choices as choices
from tcontact.cases._inputs import checked
from tcontact.mesh.mapped import tetrahedra
from tcontact.results import checks as ck
from tcontact.show import plots

MODES = 20  # of the thin plate; the last of them is shorter than the contact is wide
STEPS = 20000  # of its motion
FINER = 0.4  # size of the plate's cells in the middle over the mean one
HIT = 0.6  # radius of the part of the plate that can touch, in radii of the ball


class Motion(NamedTuple):
    """Motion of ball and thin plate: times [s], force [N], mean deflection [m], speed of the ball at the end [m/s]."""

    time: np.ndarray
    force: np.ndarray
    deflection: np.ndarray
    speed: float


@checked
def scene(
    *,
    cells: int = 12,
    layers: int = 3,
    ball_cells: int = 8,
    mesh: str | None = None,
    law: choices.Law = "linear",
    mach: float = 0.02,
    young: float = 1e7,
    poisson: float = 0.3,
    density: float = 1000.0,
    radius: float = 0.05,
    plate_radius: float = 3.0,
    thickness: float = 0.4,
    removal: choices.Removal = "auto",
    tolerance: float | None = None,
) -> tc.Scene:
    """A ball of `ball_cells` faces along a quarter of its rim falls on a plate of 4 `cells` around, `layers` deep.

    SI units; plate_radius and thickness in radii of the ball. mesh: a file with a round plate across the z axis, whose
    set of faces "top" can be hit and whose set "rim" is held; it takes the place of the sizes of the plate. mach: speed
    over sqrt(young/density).
    """
    for name, count, least in (("cells", cells, 3), ("layers", layers, 2), ("ball_cells", ball_cells, 3)):
        if isinstance(count, bool) or not isinstance(count, int) or count < least:
            raise tc.InputError(name, count, f"give a whole number of at least {least}")
    choices.positive(mach=mach, young=young, density=density, radius=radius)
    choices.positive(plate_radius=plate_radius, thickness=thickness)
    if plate_radius <= 2.0 * HIT:
        raise tc.InputError("plate_radius", plate_radius, f"give more than {2.0 * HIT:g} radii of the ball")
    material = choices.material(law, young, poisson, density)
    if mesh is None:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "plate.msh"
            write_plate(file, plate_radius * radius, thickness * radius, cells, layers)
            whole = tc.read_mesh(file)
    else:
        whole = tc.read_mesh(mesh)
    low, high = whole.bounds
    centre = np.array([*(0.5 * (low + high))[:2], high[2]])
    top = whole.faces_of("top")
    near = np.linalg.norm((whole.nodes[top].mean(axis=1) - centre)[:, :2], axis=1) < HIT * radius
    if not near.any():
        raise tc.InputError("mesh", mesh, "its set top has no faces where the ball comes down")
    gap = 0.01 * radius
    ball = tc.ball_mesh(radius, ball_cells, "tet4").translated(centre + np.array((0, 0, radius + gap)))
    speed = mach * np.sqrt(young / density)
    bodies = [
        tc.Body(ball, material, (0.0, 0.0, -speed), contact="low", name="ball"),
        tc.Body(
            whole.with_sets(face_sets={"hit": top[near]}),
            material,
            contact="hit",
            supports=[tc.Support("rim", "xyz")],
            name="plate",
        ),
    ]
    contact = tc.MasslessContact(removal, tolerance=tolerance)
    motion = thin_plate(bodies)
    released = motion.time[np.flatnonzero(motion.force)[-1]]
    return tc.Scene(bodies, duration=gap / speed + 1.1 * released, contact=contact)


def write_plate(file: Path, radius: float, thickness: float, cells: int, layers: int) -> None:
    """Write a round plate of tetrahedra below z = 0 for Gmsh, finer in its middle, with the face sets top and rim."""
    disc = tc.cylinder_mesh(radius, thickness, cells, axis="y", center=(0.0, 0.5 * thickness, 0.0), layers=layers)
    x, z, y = disc.nodes.T
    inward = FINER + (1.0 - FINER) * np.hypot(x, y) / radius
    nodes = np.stack([x * inward, -y * inward, z - thickness], axis=1)
    sets = {"top": disc.face_sets["ymax"], "rim": disc.face_sets["rim"]}
    plate = tetrahedra(tc.Mesh(nodes, disc.cells, "hex8", face_sets=sets))
    parts = [("tetra", plate.cells), *(("triangle", plate.face_sets[name]) for name in sets)]
    groups = [np.full(len(corners), number) for number, (_, corners) in enumerate(parts, 1)]
    names = {"plate": np.array([1, 3]), "top": np.array([2, 2]), "rim": np.array([3, 2])}
    data = {"gmsh:physical": groups, "gmsh:geometrical": groups}
    meshio.write(file, meshio.Mesh(plate.nodes, parts, cell_data=data, field_data=names), "gmsh22", binary=True)


def thin_plate(bodies) -> Motion:
    """Return the motion of a rigid ball on Hertz's spring and a thin plate, over four periods of the plate."""
    ball, plate = bodies
    law, mass, speed = ball.material, ball.mass, -float(ball.initial_velocity[0, 2])
    size, radius = np.ptp(plate.mesh.nodes, axis=0), 0.5 * float(np.ptp(ball.mesh.nodes[:, 2]))
    ends = np.array([brentq(lambda x: j0(x) * i1(x) / i0(x) + j1(x), (n - 0.2) * np.pi, (n + 0.3) * np.pi)
                     for n in range(1, MODES + 1)])  # fmt: skip
    share = np.linspace(0.0, 1.0, 4001)
    shape = j0(ends[:, None] * share) - (j0(ends) / i0(ends))[:, None] * i0(ends[:, None] * share)
    mean = np.trapezoid(2.0 * shape * share, share, axis=1)
    masses = plate.mass * np.trapezoid(2.0 * shape**2 * share, share, axis=1)
    middle = shape[:, 0]
    stiffness = law.young * size[2] ** 3 / (12.0 * (1.0 - law.poisson**2))
    squares = (2.0 * ends / size[0]) ** 4 * stiffness / (law.density * size[2])
    spring = 2.0 / 3.0 * law.young / (1.0 - law.poisson**2) * np.sqrt(radius)
    step = 8.0 * np.pi / np.sqrt(squares[0]) / STEPS
    way, swing, rate = 0.0, np.zeros(MODES), np.zeros(MODES)
    force, deflection = np.zeros(STEPS), np.zeros(STEPS)
    for k in range(STEPS):
        force[k] = spring * max(way - swing @ middle, 0.0) ** 1.5
        deflection[k] = swing @ mean
        speed -= force[k] / mass * step
        rate += step * (force[k] * middle / masses - squares * swing)
        way, swing = way + step * speed, swing + step * rate
    return Motion(step * np.arange(STEPS), force, deflection, -speed)


def measured(result: tc.Result) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the force on the ball [N], its velocity upward [m/s] and the mean deflection of the plate [m], in rows.

    Mean deflection: the integral of the momentum that the ball has not, over the mass of the plate.
    """
    ball, plate = result.scene.bodies
    time, force = result.history["time"], result.history["pair_force:ball-plate"][:, 2]

    def integral(values):
        return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(time))])

    velocity = ball.initial_velocity[0, 2] + integral(force) / ball.mass
    rest = ball.mass * velocity - result.history["momentum"][:, 2]
    return force, velocity, integral(rest) / plate.mass


def touch(scene: tc.Scene) -> float:
    """Return the time [s] at which the ball comes to the plate."""
    ball, plate = scene.bodies
    gap = ball.mesh.nodes[:, 2].min() - plate.mesh.nodes[:, 2].max()
    return float(gap / -ball.initial_velocity[0, 2])


def curves(result: tc.Result) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the force of Hertz's spring on the thin plate, to plot."""
    motion, start = thin_plate(result.scene.bodies), touch(result.scene)
    shown = motion.time + start < result.time
    return {"thin plate": (motion.time[shown] + start, motion.force[shown])}


def draw(result: tc.Result, folder: Path, title: str) -> None:
    """Draw force and mean deflection beside those of the thin plate."""
    motion, start = thin_plate(result.scene.bodies), touch(result.scene)
    time, shown = result.history["time"], motion.time + start < result.time
    force, _, deflection = measured(result)
    thin = motion.time[shown] + start
    panels = {
        ("contact force", "N"): {"computed": (time, force), "thin plate": (thin, motion.force[shown])},
        ("mean deflection", "m"): {"computed": (time, deflection), "thin plate": (thin, motion.deflection[shown])},
    }
    plots.panels(folder / "deflection.png", panels, title)


def checks(result: tc.Result) -> list[ck.Check]:
    """Check force, duration, deflection and rebound against the thin plate; no pull, no overlap, and the ledger."""
    scene, time = result.scene, result.history["time"]
    plate = scene.bodies[1].mesh
    edges = plate.nodes[plate.cells[:, [0, 0, 0, 1, 1, 2]]] - plate.nodes[plate.cells[:, [1, 2, 3, 2, 3, 3]]]
    poisson = scene.bodies[1].material.poisson
    locking = (1.0 - poisson) / (1.0 - 2.0 * poisson) / 1.75  # 1 at .3
    coarse = locking * (np.median(np.linalg.norm(edges, axis=2)) / np.ptp(plate.nodes[:, 2])) ** 2
    found = [
        ck.finished(result),
        ck.thrown(result),
        ck.momentum_balance(result, 1e-10),
        ck.energy(result, 1e-2),
        ck.pair_overlap(result, scene.bodies[0].mesh.shortest_edge, 1e-6),
    ]
    if not result.ok:
        return found
    force, velocity, deflection = measured(result)
    motion = thin_plate(scene.bodies)
    within = motion.time + touch(scene) < result.time
    lasted = [np.ptp(times[values > 1e-3 * values.max()])
              for times, values in ((time, force), (motion.time, motion.force))]  # fmt: skip
    sag = deflection.max() / motion.deflection[within].max()
    rebound = (velocity[-1] - motion.speed) / -velocity[0]
    return [
        *found,
        ck.no_pull(result, "ball-plate", np.array((0.0, 0.0, 1.0))),
        ck.between("largest force / thin plate", force.max() / motion.force.max(), 0.9, 1.15 + 0.3 * coarse),
        ck.between("first to last touch / thin plate", lasted[0] / lasted[1], 0.95 - 0.3 * coarse, 1.05),
        ck.between("largest mean deflection / thin plate", sag, 0.95 - 0.4 * coarse, 1.1),
        ck.between("rebound - thin plate / speed", rebound, -0.1 - 0.3 * coarse, 0.1 + 0.3 * coarse),
    ]


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "clamped-plate", *sys.argv[1:]]))
