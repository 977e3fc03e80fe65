"""A bar strikes another one along their axis: an exact plateau of the force, exchanged speeds if they are equal.

Two square bars (poisson 0, linear law, impedances Z = sqrt(E rho) A, wave speeds c, length L). From the touch on both
faces move together, and the force is constant until the first wave comes back from a free end:

    F = V Z1 Z2 / (Z1 + Z2),   0 < t - t_touch < 2 L / max(c1, c2)

Equal bars then part: the first one rests and the second one has its speed. The meshes do not match: 2 x 2 cells of the
upper bar stand on 3 x 3 of the lower one.
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

AFTER = 1.5  # the run ends this long after the touch, in wave periods 2 L/c of the slower bar


@checked
def scene(
    *,
    cells: int = 20,
    kind: choices.Kind = "hex8",
    speed: float = 1.0,
    young: float = 2e9,
    stiffness: float = 1.0,
    density: float = 2000.0,
    length: float = 1.0,
    gap: float = 1e-3,
    contact: choices.ContactBetween = "massless",
    removal: choices.Removal = "auto",
    penalty: float | None = None,
    tolerance: float | None = None,
) -> tc.Scene:
    """The upper bar, with `cells` cells along its length, flies down on the lower one, which has half as many more.

    SI units. stiffness: modulus of the lower bar over that of the upper one; gap at the start [m]; penalty: of
    contact=penalty, on nodes with their ordinary mass, in multiples of young/h of the slave (None = 10).
    """
    choices.positive(cells=cells, speed=speed, young=young, stiffness=stiffness, length=length)
    choices.not_negative(gap=gap)
    laws = [choices.material("linear", modulus, 0.0, density) for modulus in (young, stiffness * young)]
    side = 0.1 * length
    meshes = [
        tc.box_mesh((side, side, length), (across, across, count), kind, (-side / 2, -side / 2, start))
        for across, count, start in ((2, cells, gap), (3, max(1, round(1.5 * cells)), -length))
    ]
    upper = tc.Body(meshes[0], laws[0], velocity=(0, 0, -speed), contact="zmin", name="upper")
    lower = tc.Body(meshes[1], laws[1], contact="zmax", name="lower")
    duration = gap / speed + AFTER * 2.0 * length / min(law.wave_speed for law in laws)
    found = tc.Scene([upper, lower], duration=duration, contact=tc.MasslessContact(removal, tolerance=tolerance))
    return choices.with_penalty(found, contact, penalty)


def comparison(**parameters: object) -> dict[str, tc.Scene]:
    """Compare contact nodes without mass with penalties of 1 and 10 young/h on ordinary mass."""
    return choices.beside_penalties(scene, parameters)


def exact(scene: tc.Scene) -> tuple[float, float, float]:
    """Return the time of touch [s], the time of the plateau [s] and its force [N]."""
    upper, lower = scene.bodies
    speed, size = -upper.velocity[2], np.ptp(upper.mesh.nodes, axis=0)
    gap = upper.mesh.nodes[:, 2].min() - lower.mesh.nodes[:, 2].max()
    one, two = (np.sqrt(body.material.young * body.material.density) for body in scene.bodies)
    fastest = max(body.material.wave_speed for body in scene.bodies)
    return gap / speed, 2.0 * size[2] / fastest, speed * one * two / (one + two) * size[0] * size[1]


def curves(result: tc.Result) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the exact force on the upper bar while the plateau lasts, to plot."""
    touch, lasts, force = exact(result.scene)
    return {"exact plateau": (np.array([0, touch, touch, touch + lasts]), force * np.array([0, 0, 1, 1]))}


def checks(result: tc.Result) -> list[ck.Check]:
    """Check energy and momentum; mean and ripple of the plateau; the speeds after the impact of equal bars.

    A penalty has energy errors and ripples of its own, which are not judged.
    """
    scene, exactly = result.scene, choices.is_exact(result.scene)
    found = [ck.finished(result), ck.momentum_balance(result, 1e-10)]
    found += [ck.energy(result, 1e-2)] if exactly else []
    if not result.ok:
        return found
    touch, lasts, plateau = exact(scene)
    time, force = result.history["time"], result.pair_force["upper-lower"][:, 2] / plateau
    flat = force[(time > touch + 0.25 * lasts) & (time < touch + 0.85 * lasts)]
    if exactly:
        ripple = np.sqrt(((flat - flat.mean()) ** 2).mean())
        found += [
            ck.between("plateau / exact", flat.mean(), 0.99, 1.01),
            ck.at_most("ripple of the plateau", ripple, 2e-2),
        ]
    upper, lower = scene.bodies
    if upper.material == lower.material:
        speed, count = -upper.velocity[2], upper.mesh.node_count
        ends = [part[:, 2].mean() / -speed for part in (result.velocity[:count], result.velocity[count:])]
        found += [ck.at_most("speed of the first bar / start", abs(ends[0]), 0.05),
                  ck.between("speed of the second bar / start", ends[1], 0.95, 1.05)]  # fmt: skip
    return found


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "two-bars", *sys.argv[1:]]))
