"""Blocks are dropped on each other and on a plane, and come to rest: every interface carries the weight above it.

Five soft blocks whose meshes do not match, each turned against the one below, start with gaps of 5 mm. They bounce,
mass damping takes their energy, and then nothing may move any more: no overlap, no drift, and the force on the plane
and between any two blocks is the weight of what stands above. Without friction such a stack is not stable for ever: a
block of mass m that carries the weight W at a distance e beside its middle tilts by 12 W e/(E s^3) (a beam of length
and width s), and what stands on it slides down the slope, at 24 W^2 e/(m E s^3 rate) against the damping. Two blocks
do so within 10 %. Of five of the default stiffness e grows by a factor of ten in about a minute; with a tenth of the
stiffness the stack falls apart after 40 s (30000 steps). Friction (`friction=0.3`) holds it.
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

SETTLED = 14.0  # times 1/omega from the landing of the last block to the end, omega of the stack on its foot


@checked
def scene(
    *,
    cells: int = 3,
    blocks: int = 5,
    kind: choices.Kind = "hex8",
    law: choices.Law = "neo-hookean",
    drop: float = 5e-3,
    size: float = 0.1,
    young: float = 2e6,
    poisson: float = 0.3,
    density: float = 1000.0,
    gravity: float = 9.81,
    turn: float = 7.0,
    friction: float = 0.0,
    damping: float | None = None,
    removal: choices.Removal = "auto",
    tolerance: float | None = None,
    duration: float | None = None,
) -> tc.Scene:
    """Cubes of `cells` cells along an edge, every second one of one more, with gaps `drop` below each.

    SI units. turn: angle between two blocks [degrees]; friction: coefficient on floor and blocks; damping: rate of
    the mass damping [1/s], None: twice the lowest angular frequency of the stack, which is then damped the fastest;
    duration: None for as long as it takes to settle.
    """
    for name, count, least in (("cells", cells, 2), ("blocks", blocks, 2)):
        if isinstance(count, bool) or not isinstance(count, int) or count < least:
            raise tc.InputError(name, count, f"give a whole number of at least {least}")
    choices.positive(drop=drop, size=size, young=young, density=density, gravity=gravity, damping=damping)
    choices.positive(duration=duration)
    choices.not_negative(friction=friction)
    material = choices.material(law, young, poisson, density)
    omega = np.pi / 2.0 * np.sqrt(young / density) / (blocks * size)
    rate = 2.0 * omega if damping is None else damping
    found = []
    for number in range(blocks):
        count = cells + number % 2
        mesh = tc.box_mesh((size,) * 3, (count,) * 3, kind, (-size / 2, -size / 2, drop + number * (size + drop)))
        mesh = mesh.rotated(((0, 0, 1), np.radians(turn * number)), about=(0.0, 0.0, 0.0))
        found.append(tc.Body(mesh, material, contact=("zmin", "zmax"), name=f"block-{number + 1}"))
    way = blocks * drop
    fall = np.sqrt(2.0 * way / gravity) + way * rate / gravity  # not less than it takes with damping
    lasts = fall + SETTLED / min(omega, 0.5 * rate)
    return tc.Scene(
        found,
        [tc.Plane(name="floor")],
        duration=lasts if duration is None else duration,
        gravity=(0.0, 0.0, -gravity),
        damping=tc.MassDamping(rate),
        friction=tc.Coulomb(friction) if friction > 0.0 else None,
        contact=tc.MasslessContact(removal, tolerance=tolerance),
        pairs=[tc.Pair(f"block-{number}", f"block-{number + 1}") for number in range(1, blocks)],
    )


def checks(result: tc.Result) -> list[ck.Check]:
    """Check that every interface carries the weight above it, that nothing overlaps or moves at the end, the ledger."""
    scene, history = result.scene, result.history
    size = min(body.mesh.shortest_edge for body in scene.bodies)
    found = [
        ck.finished(result),
        ck.touched(result),
        ck.energy(result, 1e-2),
        ck.momentum_balance(result, 1e-10),
        ck.at_most("overlap / cell", np.max([0.0, -np.min(history["gap_min"])]) / size, 1e-3),
    ]
    if not result.ok:
        return found
    weights = np.array([body.mass for body in scene.bodies])[::-1].cumsum()[::-1] * -scene.gravity[2]
    forces = [history["contact_force"][-1, 2], *(-force[-1, 2] for force in result.pair_force.values())]
    names = ["floor", *result.pair_force]
    found += [
        ck.at_most(f"force / weight, {name}: error", abs(force / weight - 1.0), 1e-3)
        for name, force, weight in zip(names, forces, weights, strict=True)
    ]
    time, late = history["time"], history["time"] > 0.9 * result.time
    way = np.trapezoid(history["momentum"][late], time[late], axis=0) / ck.mass(result)
    fastest = np.linalg.norm(result.velocity, axis=1).max()
    return [
        *found,
        ck.at_most("way in the last tenth / cell", np.abs(way).max() / size, 1e-3),
        ck.at_most("fastest node at the end x duration / cell", fastest * result.time / size, 1e-2),
    ]


def curves(result: tc.Result) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the weight of the stack, to plot."""
    weight = ck.mass(result) * -result.scene.gravity[2]
    return {"weight": (np.array([0.0, result.time]), np.array([weight, weight]))}


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "stack", *sys.argv[1:]]))
