"""A bar of two materials hits a rigid wall: waves are reflected where they meet, with an exact contact force.

The bar (poisson 0, linear law, a cross-section A) arrives with the speed v. A compression of the stress Z1 v runs up
the part at the wall, Z = rho c; where the parts meet, the share R of it comes back, and the wall doubles that. A wave
takes the same time T through either part, so that the reflection at the free end comes later:

    F = Z1 A v              0 < s < 2 T,   s = time since touch
    F = Z1 A v (1 + 2 R)   2 T < s < 4 T,   R = (Z2 - Z1)/(Z2 + Z1)
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

LAST = 3.8  # end of the run after touch, in T
SETTLED = 0.4  # part of a level, in T at each end, that its mean leaves out: the front is steep, not a step


@checked
def scene(
    *,
    cells: int = 40,
    kind: choices.Kind = "hex8",
    second_kind: choices.Kind | None = None,
    young: float = 1e7,
    density: float = 1000.0,
    second_young: float = 4e7,
    second_density: float = 1500.0,
    length: float = 0.1,
    width: float | None = None,
    speed: float = 0.5,
    gap: float = 1e-4,
    removal: choices.Removal = "auto",
) -> tc.Scene:
    """A bar of two parts, each of `cells` cells along its length, arrives at a wall.

    SI units. young, density: of the part at the wall; second_young, second_density: of the other one; kind,
    second_kind: cells of the parts, hex8 beside wedge6 or one kind (None: the same); length: of the part at the wall;
    width: of the bar, None = length/10.
    """
    choices.positive(young=young, density=density, second_young=second_young, second_density=second_density)
    choices.positive(length=length, width=width, speed=speed, gap=gap)
    first = choices.material("linear", young, 0.0, density)
    second = choices.material("linear", second_young, 0.0, second_density)
    side, other = length / 10.0 if width is None else width, length * second.wave_speed / first.wave_speed
    mesh = bar(side, length, other, cells, kind, second_kind or kind)
    materials = {"first": first, "second": second}
    body = tc.Body(mesh.translated((0.0, 0.0, gap)), materials, (0.0, 0.0, -speed), contact="zmin", name="bar")
    duration = gap / speed + LAST * length / first.wave_speed
    return tc.Scene([body], [tc.Plane()], duration, contact=tc.MasslessContact(removal=removal))


def bar(side: float, length: float, other: float, cells: int, kind: str, second_kind: str) -> tc.Mesh:
    """Return a bar along z of two parts with these lengths and kinds of cells, its cell sets "first" and "second"."""
    sizes, parts, nodes = (length, other), [], []
    for number, one in enumerate((kind, second_kind)):
        # along x, so that the sides of prisms that are quadrilaterals face the other part
        box = tc.box_mesh((sizes[number], side, side), (cells, 1, 1), one, origin=(length * number, 0.0, 0.0))
        nodes.append(box.nodes[:, [1, 2, 0]])
        parts.append((one, box.cells + number * box.node_count))
    points, number = _merged(np.concatenate(nodes))
    joined: dict[str, list[np.ndarray]] = {}
    for one, rows in parts:
        joined.setdefault(one, []).append(number[rows])
    mesh = tc.Mesh(points, {one: np.concatenate(rows) for one, rows in joined.items()},
                   node_sets={"zmin": np.flatnonzero(points[:, 2] == 0.0)})  # fmt: skip
    low = mesh.cell_centres()[:, 2] < length
    return mesh.with_sets(cell_sets={"first": np.flatnonzero(low), "second": np.flatnonzero(~low)})


def _merged(nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the different nodes, and the number [n] of every node among them."""
    size = 1e-6 * np.ptp(nodes[:, 0])
    _, first, number = np.unique(np.round(nodes / size), axis=0, return_index=True, return_inverse=True)
    return nodes[first], number.reshape(-1)


def levels(scene: tc.Scene) -> tuple[float, float, float, float]:
    """Return the time of touch [s], T [s], Z1 A v [N] and R."""
    body = scene.bodies[0]
    first, second = body.material["first"], body.material["second"]
    area = np.prod(np.ptp(body.mesh.nodes[:, :2], axis=0))
    low = body.mesh.cell_centres()[body.mesh.cell_sets["second"], 2].min()
    below = body.mesh.nodes[body.mesh.nodes[:, 2] < low, 2]
    touch, passage = body.mesh.bounds[0][2] / -body.velocity[2], np.ptp(below) / first.wave_speed
    z, other = (one.density * one.wave_speed for one in (first, second))
    return touch, passage, -z * area * body.velocity[2], (other - z) / (other + z)


def exact_force(times: np.ndarray, dt: float, scene: tc.Scene) -> np.ndarray:
    """Return the exact contact force [N] averaged over [t - dt/2, t + dt/2] at each of the times [s], up to 4 T."""
    touch, passage, force, share = levels(scene)

    def impulse(when: np.ndarray) -> np.ndarray:
        s = np.clip(when - touch, 0.0, None)
        return force * (s + 2.0 * share * np.clip(s - 2.0 * passage, 0.0, None))

    return (impulse(times + dt / 2) - impulse(times - dt / 2)) / dt


def curves(result: tc.Result) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the exact contact force, to plot."""
    times = np.linspace(0.0, result.scene.duration, 4001)
    return {"exact": (times, exact_force(times, times[1], result.scene))}


def checks(result: tc.Result) -> list[ck.Check]:
    """Check both levels of the contact force, the share that is reflected, momentum and energy."""
    scene, history = result.scene, result.history
    touch, passage, force, share = levels(scene)
    coarse = max(1.0, 80.0 / (scene.bodies[0].mesh.node_count / 4.0 - 1.0))
    found = [ck.finished(result), ck.touched(result), ck.momentum_balance(result, 1e-8)]
    found += [ck.thrown(result), ck.pushing(result), ck.no_overlap(result), ck.energy(result, 5e-3 * coarse)]
    if not result.ok:
        return found
    means = []
    for begin, end in ((SETTLED, 2.0 - SETTLED), (2.0 + SETTLED, LAST - SETTLED)):
        limits = np.array([touch + begin * passage, touch + end * passage])
        given = np.interp(limits, history["time"], history["impulse"][:, 2])
        means.append(float(given[1] - given[0]) / ((end - begin) * passage * force))
    found.append(ck.at_most("force before the reflection, error", abs(means[0] - 1.0), 5e-3 * coarse))
    reflected = 0.5 * (means[1] - means[0])
    found.append(ck.at_most("share reflected, error", abs(reflected - share), 8e-3 * coarse))
    return found


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "layered-bar", *sys.argv[1:]]))
