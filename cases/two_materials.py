"""A bar of two materials between two walls, one of which strikes it: exact reflected and transmitted waves.

One wall begins to move at the speed v into the bar (poisson 0, linear law, cross-section A, impedances Z = rho c) and
sends the stress Z1 v up the first part. Where the parts meet the share R of it comes back, which that wall doubles, and
the share D goes on, which the wall at the other end doubles. With the times T1 and T2 that waves take through the parts

    hammer   F = Z1 A v             0 < t < 2 T1
             F = Z1 A v (1 + 2 R)   2 T1 < t < 2 T1 + 2 min(T1, T2),   R = (Z2 - Z1)/(Z2 + Z1)
    wall     F = Z1 A v 2 D         T1 + T2 < t < T1 + T2 + 2 min(T1, T2),   D = 2 Z2/(Z2 + Z1)

Where 1 + 2 R is negative the bar would pull the hammer: it leaves it, F = 0.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import NamedTuple

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np

import tcontact as tc
from tcontact.cases import _choices as choices
from tcontact.cases._inputs import checked
from tcontact.results import checks as ck

SETTLED = 0.2  # part of a level, at each end, that its mean leaves out: the front is steep, not a step


@checked
def scene(
    *,
    cells: int = 100,
    kind: choices.Kind = "hex8",
    young: float = 1e7,
    density: float = 1000.0,
    second_young: float = 4e7,
    second_density: float = 1500.0,
    length: float = 0.1,
    speed: float = 0.5,
    removal: choices.Removal = "auto",
) -> tc.Scene:
    """A bar of `cells` cells along its length, the lower half of one material and the upper half of another one.

    SI units. young, density: of the half that is struck; second_young, second_density: of the other one.
    """
    if isinstance(cells, bool) or not isinstance(cells, int) or cells < 2:
        raise tc.InputError("cells", cells, "give a whole number of at least 2")
    choices.positive(length=length, speed=speed)
    first = choices.material("linear", young, 0.0, density)
    second = choices.material("linear", second_young, 0.0, second_density)
    mesh = tc.box_mesh((0.1 * length, 0.1 * length, length), (1, 1, cells), kind)
    low = mesh.cell_centres()[:, 2] < (cells // 2) * length / cells
    mesh = mesh.with_sets(cell_sets={"first": np.flatnonzero(low), "second": np.flatnonzero(~low)})
    bar = tc.Body(mesh, {"first": first, "second": second}, contact=["zmin", "zmax"], name="bar")
    hammer = tc.Plane(velocity=(0.0, 0.0, speed), name="hammer")
    wall = tc.Plane(point=(0.0, 0.0, length), normal=(0.0, 0.0, -1.0), name="wall")
    duration = max(level.end for level in levels(bar, speed).values())
    return tc.Scene([bar], [hammer, wall], duration=duration, contact=tc.MasslessContact(removal=removal))


class Level(NamedTuple):
    """A constant force [N] on an obstacle from `begin` to `end` [s]."""

    obstacle: str
    begin: float
    end: float
    force: float


def levels(bar: tc.Body, speed: float) -> dict[str, Level]:
    """Return the exact levels of the force on both walls."""
    first, second = bar.material["first"], bar.material["second"]
    nodes, (low, high) = bar.mesh.nodes, bar.mesh.bounds
    middle = nodes[bar.mesh.cells[bar.mesh.cell_sets["first"]], 2].max()
    one, two = (middle - low[2]) / first.wave_speed, (high[2] - middle) / second.wave_speed
    z, other = (law.density * law.wave_speed for law in (first, second))
    reflected, transmitted = (other - z) / (other + z), 2.0 * other / (other + z)
    force = z * (high - low)[0] * (high - low)[1] * speed
    last = 2.0 * min(one, two)
    return {
        "incident": Level("hammer", 0.0, 2.0 * one, force),
        "reflected": Level("hammer", 2.0 * one, 2.0 * one + last, force * max(0.0, 1.0 + 2.0 * reflected)),
        "transmitted": Level("wall", one + two, one + two + last, force * 2.0 * transmitted),
    }


def found_levels(result: tc.Result) -> dict[str, float]:
    """Return the mean force [N] during each level, without its begin and end."""
    bar, speed, time = result.scene.bodies[0], result.scene.obstacles[0].velocity[2], result.history["time"]
    means = {}
    for name, level in levels(bar, speed).items():
        rest = SETTLED * (level.end - level.begin)
        inside = (time > level.begin + rest) & (time < level.end - rest)
        force = np.abs(result.history[f"obstacle_force:{level.obstacle}"][inside, 2])
        means[name] = float(force.sum()) / max(1, len(force))
    return means


def checks(result: tc.Result) -> list[ck.Check]:
    """Check the force of the wave that is sent, reflected and transmitted, momentum and energy."""
    coarse = max(1.0, 100.0 / (len(np.unique(result.scene.bodies[0].mesh.nodes[:, 2])) - 1))
    found = [ck.finished(result), ck.touched(result), ck.momentum_balance(result, 1e-8), ck.no_overlap(result)]
    found.append(ck.energy(result, 5e-3 * coarse))
    if not result.ok:
        return found
    exact, given = levels(result.scene.bodies[0], result.scene.obstacles[0].velocity[2]), found_levels(result)
    sent = exact["incident"].force
    for name, level in exact.items():
        doubled = 1.0 if name == "incident" else 2.0  # at a rigid wall
        error = abs(given[name] - level.force) / (doubled * sent)
        found.append(ck.at_most(f"{name} wave / incident wave, error", error, 1e-2 * coarse))
    return found


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "two-materials", *sys.argv[1:]]))
