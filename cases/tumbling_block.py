"""A soft block tumbles freely: momenta and energy stay what they were at the start.

A neo-Hookean block with three different edges is thrown with a spin about a skew axis and a stretching motion; nothing
touches it. Conserving schemes keep energy, momentum and angular momentum to rounding at steps far beyond the stable one
of the explicit scheme; kind, law and formulation choose the cells.
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
from tcontact.show.plots import energies

SCHEME = {"scheme": "discrete-gradient", "dt": 2e-4}


@checked
def scene(
    *,
    cells: int = 6,
    kind: choices.Kind = "hex8",
    formulation: choices.Formulation = "full",
    law: choices.Law = "neo-hookean",
    young: float = 1e7,
    poisson: float = 0.3,
    density: float = 1000.0,
    size: float = 0.1,
    spin: float = 200.0,
    stretch: float = 60.0,
    duration: float = 0.02,
) -> tc.Scene:
    """A block size x size/2 x size/3 with `cells` cells along its longest edge flies freely.

    SI units. spin: angular velocity [rad/s]; stretch: rate of the shearing motion at the start [1/s].
    """
    choices.positive(cells=cells, size=size)
    material = choices.material(law, young, poisson, density)
    edges = np.array([1.0, 1 / 2, 1 / 3]) * size
    counts = tuple(int(max(1, round(cells * edge / size))) for edge in edges)
    mesh = tc.box_mesh(size=tuple(edges), cells=counts, kind=kind, origin=tuple(-edges / 2))
    axis = spin * np.array([2.0, 3.0, 6.0]) / 7.0

    def velocity(x: np.ndarray) -> np.ndarray:
        return np.cross(axis, x) + stretch * x[:, [1, 0, 2]] + np.array([1.0, 2.0, 3.0])

    block = tc.Body(mesh, material, velocity, name="block", formulation=formulation)
    return tc.Scene(bodies=[block], duration=duration)


def comparison(**parameters: object) -> dict[str, tuple[tc.Scene, object]]:
    """Compare schemes at steps of 0.2 ms, the explicit one at its own: who keeps the energy."""
    own = scene(**parameters)
    schemes = (
        tc.CentralDifference(),
        tc.Trapezoidal(dt=2e-4),
        tc.Midpoint(dt=2e-4),
        tc.Gonzalez(dt=2e-4),
        tc.DiscreteGradient(dt=2e-4),
    )
    return {scheme.name: (own, scheme) for scheme in schemes}


def draw_comparison(path: Path, histories: dict[str, dict[str, np.ndarray]]) -> None:
    """Draw the energy of the schemes over that at the start."""
    energies(path, histories)


def checks(result: tc.Result) -> list[ck.Check]:
    """Check momentum, angular momentum and energy, as far as the scheme conserves them."""
    history, conserves = result.history, getattr(result.scheme, "conserves", ())
    found = [ck.finished(result), ck.thrown(result), ck.momentum_balance(result, 1e-10)]
    turned = history["angular_momentum"]
    change = np.abs(turned - turned[0]).max() / np.linalg.norm(turned[0])
    if "angular momentum" in conserves and not result.scene.bodies[0].material.linear:
        found.append(ck.at_most("change of angular momentum", change, 1e-10))
    if "energy" in conserves:
        found.append(ck.energy(result, 1e-10))
    return found


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "tumbling-block", *sys.argv[1:]]))
