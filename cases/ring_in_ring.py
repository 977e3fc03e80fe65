"""An elastic ring turns in another one that it is pressed into, without friction, against the press fit of Lame.

The inner ring is too large by a misfit d and starts compressed into the outer one, both in the equilibrium of plane
stress u = A r + B/r; it spins, which adds its centrifugal widening to the misfit. The faces of two meshes that do not
match leave gaps and overlaps of the size of the sagitta h^2/(8 R), which is as large as the misfit: the gaps of the
start count as closed. The coarser ring is the slave, since the gaps of its rows are nearly the same all around: exactly
where the other one has a multiple of its cells, else up to a fifth of the sagitta of the other one apart as it turns,
and so short a wave changes the pressure several times as much as the same misfit. Neither ring drives the other. The
weights of the rows lag behind by up to .03 of a face, and so does the point where the other ring takes the force.
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
from tcontact.scene.slaves import mean_area
from tcontact.show import plots

INSIDE, OUTSIDE, THICKNESS = 0.5, 1.5, 0.2  # radii and length of the rings over the radius of the fit
LAG = 0.03  # of a face, by which the weights of a row may lag behind

Field = tuple[float, float, float]  # A, B [m^2] and axial strain e of a ring: u_r = A r + B/r, u_z = e z


@checked
def scene(
    *,
    cells: int = 24,
    outer_cells: int = 72,
    kind: Literal["hex8", "wedge6"] = "hex8",
    law: Literal["neo-hookean", "st-venant-kirchhoff"] = "neo-hookean",
    misfit: float = 1e-2,
    mach: float = 0.03,
    turn: float = 0.6,
    young: float = 1e7,
    stiffness: float = 1.0,
    poisson: float = 0.3,
    density: float = 1000.0,
    radius: float = 0.1,
    tolerance: float | None = None,
) -> tc.Scene:
    """A ring of `cells` cells around turns by `turn` of them in one of `outer_cells`, both free.

    SI units. kind: with quadrilaterals around the rings; law: one for large turns. misfit: over the radius of the fit;
    mach: speed at that radius over the wave speed of the softer ring; stiffness: modulus of the inner ring over that of
    the outer one.
    """
    for name, count in (("cells", cells), ("outer_cells", outer_cells)):
        if isinstance(count, bool) or not isinstance(count, int) or count < 3:
            raise tc.InputError(name, count, "give a whole number of at least 3")
    choices.positive(misfit=misfit, mach=mach, turn=turn, young=young, stiffness=stiffness, density=density)
    choices.positive(radius=radius)
    laws = [choices.material(law, modulus, poisson, density) for modulus in (stiffness * young, young)]
    _, inward, outward = press_fit(laws, misfit * radius, radius)
    spin = mach * min(law.wave_speed for law in laws) / radius
    length = THICKNESS * radius
    inner = tc.ring_mesh(INSIDE * radius, radius - change(radius, inward), length, cells, kind, layers=1)
    fitted = radius - change(radius, outward)
    outer = tc.ring_mesh(fitted, OUTSIDE * radius, length, outer_cells, kind, layers=1, start=0.1)
    parts = [
        (inner, laws[0], inward, "outer", "inner", spin),
        (outer, laws[1], outward, "inner", "outer", 0.0),
    ]
    bodies = [
        tc.Body(mesh, material, turning(mesh, field, speed), side, name=name, displacement=moved(mesh.nodes, field))
        for mesh, material, field, side, name, speed in parts
    ]
    slave = "inner" if cells <= outer_cells else "outer"
    pairs = [tc.Pair("inner", "outer", slave=slave, initial_gap="closed")]
    contact = tc.MasslessContact("full", tolerance=tolerance)
    return tc.Scene(bodies, duration=turn * 2.0 * np.pi / cells / spin, contact=contact, pairs=pairs)


def press_fit(laws, misfit: float, radius: float) -> tuple[float, Field, Field]:
    """Return the pressure [Pa] of the fit and the displacements of the inner and the outer ring (Lame)."""
    found = []
    for law, (inside, outside), sign in zip(laws, ((INSIDE, 1.0), (1.0, OUTSIDE)), (-1.0, 1.0), strict=True):
        mean = sign / (outside**2 - inside**2)  # of the stresses across the axis, under unit pressure
        stretch, shear = (1.0 - law.poisson) / law.young, (1.0 + law.poisson) / law.young
        axial = -2.0 * law.poisson / law.young
        found.append(mean * np.array((stretch, shear * (inside * outside * radius) ** 2, axial)))
    pressure = misfit / (change(radius, found[1]) - change(radius, found[0]))
    return float(pressure), tuple(pressure * found[0]), tuple(pressure * found[1])


def change(radius, field: Field):
    """Return the radial displacement [m]."""
    return field[0] * radius + field[1] / radius


def moved(nodes: np.ndarray, field: Field) -> np.ndarray:
    """Return the displacement [n, 3] [m] of the start."""
    radial = field[0] + field[1] / (nodes[:, :2] ** 2).sum(axis=1)
    return nodes * np.stack([radial, radial, np.full(len(nodes), field[2])], axis=1)


def turning(mesh: tc.Mesh, field: Field, speed: float) -> np.ndarray:
    """Return the velocity [n, 3] [m/s] of a ring that turns about the z axis."""
    return np.cross((0.0, 0.0, speed), mesh.nodes + moved(mesh.nodes, field))


def theory(scene: tc.Scene) -> tuple[float, float]:
    """Return the pressure [Pa] between the rings (Lame), and the part of it from the centrifugal widening."""
    inner, outer = scene.bodies
    ends = [np.linalg.norm(body.mesh.nodes[:, :2], axis=1) for body in (inner, outer)]
    radius, law = ends[1].max() / OUTSIDE, inner.material
    tip = np.argmax(ends[0])
    spin = np.linalg.norm(inner.initial_velocity[tip]) / radius
    shape = (1.0 - law.poisson) + (3.0 + law.poisson) * INSIDE**2
    widening = law.density * spin**2 * radius**3 * shape / (4.0 * law.young)
    misfit = ends[0].max() - ends[1].min() + widening
    return press_fit([body.material for body in scene.bodies], misfit, radius)[0], widening / misfit


def spins(result: tc.Result) -> tuple[np.ndarray, np.ndarray]:
    """Return the angular momentum [rows] [kg m^2/s] of the inner and of the outer ring."""
    history = result.history
    total, moment = history["angular_momentum"][:, 2], history["pair_moment:inner-outer"][:, 2]
    steps = 0.5 * (moment[1:] + moment[:-1]) * np.diff(history["time"])
    inner = total[0] + np.concatenate([[0.0], np.cumsum(steps)])
    return inner, total - inner


def draw(result: tc.Result, folder: Path, title: str) -> None:
    """Draw the angular momenta of the rings, and the change of each."""
    time, (inner, outer) = result.history["time"], spins(result)
    panels = {
        ("angular momentum", "N m s"): {"inner ring": (time, inner), "outer ring": (time, outer)},
        ("change of it", "N m s"): {"inner ring": (time, inner - inner[0]), "outer ring": (time, outer)},
    }
    plots.panels(folder / "spin.png", panels, title)


def checks(result: tc.Result) -> list[ck.Check]:
    """Check the pressure and that it is uniform, angular momentum, overlap, and the ledger."""
    scene, history = result.scene, result.history
    slave = scene.body_pairs[0].slave
    body, other = scene.bodies[slave], scene.bodies[1 - slave]
    found = [ck.finished(result), ck.energy(result, 1e-2), ck.pair_overlap(result, mean_size(body), 1e-6)]
    if not result.ok:
        return found
    radius = float(np.linalg.norm(scene.bodies[1].mesh.nodes[:, :2], axis=1).max()) / OUTSIDE
    pressure, sudden = theory(scene)
    pressing = pressure * 2.0 * np.pi * radius * THICKNESS * radius
    first = 0 if slave == 0 else scene.bodies[0].mesh.node_count
    force = np.linalg.norm(result.contact_node_force[first + body.contact_nodes], axis=1)
    cells = [len(one.contact_faces) for one in (body, other)]
    sagitta = (np.pi / cells[1]) ** 2 / 2.0 * radius
    inner, outer = (np.linalg.norm(one.mesh.nodes[:, :2], axis=1) for one in scene.bodies)
    uneven = 0.0 if cells[1] % cells[0] == 0 else 1.5 * sagitta / (inner.max() - outer.min())
    inner_spin, outer_spin = spins(result)
    start, gained = inner_spin[0], inner_spin + outer_spin - inner_spin[0]
    own = inner_spin - start if slave == 0 else outer_spin
    lag = LAG * 2.0 * np.pi * radius / cells[0]
    return [
        *found,
        ck.equals("rows without pressure", np.sum(history["pair_pressed:inner-outer"] < len(force)), 0),
        ck.between("pressure at the end / Lame", force.sum() / pressing, 0.9 - 2.0 * sudden, 1.1 + 2.0 * sudden),
        ck.at_most("spread of the pressure / mean", np.ptp(force) / force.mean(), 0.02 + uneven),
        ck.at_most("angular momentum that the slave takes / start", np.abs(own).max() / start, 1e-5),
        ck.at_most(
            "angular momentum gained / (lag x pressing force x time)",
            np.abs(gained).max() / (lag * pressing * result.time),
            1.0,
        ),
    ]


def mean_size(body: tc.Body) -> float:
    """Return the root of the mean area of the contact faces [m]."""
    return float(np.sqrt(mean_area(body)))


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "ring-in-ring", *sys.argv[1:]]))
