"""Two free cubes meet obliquely; their meshes do not match and are turned against each other.

The upper cube comes from above with a speed along the face too; frictionless contact turns both. No exact solution is
known, but momentum and energy must be conserved, and the cubes part after one touch.
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

OBLIQUE = np.array((1.0, 0.4, -1.0))  # direction of the velocity, the normal part being 1
AFTER = 3.0  # duration in edges over the wave speed of the softer cube


@checked
def scene(
    *,
    cells: int = 8,
    lower_cells: int | None = None,
    kind: choices.Kind = "hex8",
    law: choices.Law = "neo-hookean",
    mach: float = 0.05,
    young: float = 1e7,
    stiffness: float = 1.0,
    poisson: float = 0.3,
    density: float = 1000.0,
    size: float = 0.1,
    turn: float = 17.0,
    contact: choices.ContactBetween = "massless",
    removal: choices.Removal = "full",
    penalty: float | None = None,
    tolerance: float | None = None,
) -> tc.Scene:
    """The upper cube of `cells` cells along an edge falls on the lower one of `lower_cells` (None: one fourth more).

    SI units. mach: normal speed over the wave speed of the lower cube; stiffness: modulus of the upper cube over that
    of the lower one; turn: angle between the meshes about the vertical [degrees]; penalty: of contact=penalty, on nodes
    with their ordinary mass, in multiples of young/h of the slave (None = 10).
    """
    choices.positive(cells=cells, lower_cells=lower_cells, mach=mach, young=young, stiffness=stiffness, size=size)
    gap = 0.002 * size
    count = lower_cells or max(cells + 1, round(1.25 * cells))
    below = tc.box_mesh((size,) * 3, (count,) * 3, kind, (-size / 2, -size / 2, -size))
    above = tc.box_mesh((size,) * 3, (cells,) * 3, kind, (-size / 2, -size / 2, gap))
    above = above.rotated(((0, 0, 1), np.radians(turn))).translated((0.25 * size, 0.1 * size, 0.0))
    upper, lower = (choices.material(law, modulus, poisson, density) for modulus in (stiffness * young, young))
    velocity = mach * lower.wave_speed * OBLIQUE
    bodies = [
        tc.Body(above, upper, velocity=velocity, contact="zmin", name="upper"),
        tc.Body(below, lower, contact="zmax", name="lower"),
    ]
    duration = AFTER * size / min(upper.wave_speed, lower.wave_speed)
    found = tc.Scene(bodies, duration=duration, contact=tc.MasslessContact(removal, tolerance=tolerance))
    return choices.with_penalty(found, contact, penalty)


def comparison(**parameters: object) -> dict[str, tc.Scene]:
    """Compare contact nodes without mass with penalties of 1 and 10 young/h on ordinary mass."""
    return choices.beside_penalties(scene, parameters)


def checks(result: tc.Result) -> list[ck.Check]:
    """Check that energy and momentum are conserved and that the cubes touch once.

    A penalty changes the energy near its stable step and may let the cubes bounce, which is not judged.
    """
    history, exactly = result.history, choices.is_exact(result.scene)
    found = [ck.finished(result), ck.thrown(result), ck.momentum_balance(result, 1e-10)]
    found += [ck.energy(result, 1e-2)] if exactly else []
    if not result.ok:
        return found
    angular = history["angular_momentum"]
    force = result.pair_force["upper-lower"][:, 2]
    pressed = np.abs(force) > 1e-6 * np.abs(force).max()
    found += [
        ck.at_most(
            "change of the angular momentum", np.abs(angular - angular[0]).max() / np.abs(angular[0]).max(), 1e-2
        ),
        ck.between("touches", float((np.diff(pressed.astype(int)) > 0).sum()), 1.0, 1.0 if exactly else np.inf),
        ck.at_most("pull / largest push", max(0.0, -force.min()) / force.max(), 1e-12),
    ]
    return found


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "two-cubes", *sys.argv[1:]]))
