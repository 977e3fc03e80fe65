"""A cube strikes a wall with the paper's implicit scheme: penetration energy with and without redistributed mass.

This is Fig. 4 of Le Tallec, Dambakizi and Hauret 2007. The cube of the case cube-impact strikes a wall with a penalty
of 1000 E/h; the inertia follows the trapezoidal rule, stiffness and contact follow backward Euler, and the step is the
stable one of the explicit scheme. On ordinary mass the penetration energy jumps up and down, on redistributed mass it
rises and falls once. compare=true runs both at three steps.
"""

from __future__ import annotations

import sys
from pathlib import Path

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np

import tcontact as tc
from tcontact.cases import _choices as choices
from tcontact.cases import cube_impact
from tcontact.cases._inputs import checked
from tcontact.results import checks as ck
from tcontact.show.plots import penetration_energies

SCHEME = {"scheme": "paper-implicit", "cfl": 1.0}
STEPS = (1.0, 0.5, 0.25)  # steps of the comparison, over the stable step of the explicit scheme
NAMES = ("ordinary", "redistributed")


@checked
def scene(
    *,
    cells: int = 8,
    redistributed: bool = True,
    penalty: float = 1000.0,
    law: choices.Law = "neo-hookean",
    speed: float = 10 / 3.6,
    duration: float = 4e-3,
) -> tc.Scene:
    """The cube, with redistributed or ordinary mass, strikes a wall with a penalty in multiples of young/h.

    SI units; cells along an edge, law, speed and duration as in cube-impact. redistributed: contact nodes without mass.
    """
    contact = "massless" if redistributed else "penalty"
    return cube_impact.scene(cells=cells, law=law, speed=speed, contact=contact, penalty=penalty, duration=duration)


def comparison(**parameters: object) -> dict[str, tuple[tc.Scene, object]]:
    """Compare redistributed with ordinary mass, each at three steps."""
    parameters.pop("redistributed", None)
    scenes = {f"{name} mass": scene(**parameters, redistributed=name == "redistributed") for name in NAMES}
    return {
        f"{name}, {share:g} dt": (own, tc.PaperImplicit(cfl=share)) for name, own in scenes.items() for share in STEPS
    }


def draw_comparison(path: Path, histories: dict[str, dict[str, np.ndarray]]) -> None:
    """Draw the penetration energy over time: ordinary mass left, redistributed mass right, as in the paper."""
    panels: dict[str, dict[str, dict[str, np.ndarray]]] = {f"{name} mass": {} for name in NAMES}
    for label, history in histories.items():
        mass, _, step = label.partition(", ")
        panels[mass][step] = history
    penetration_energies(path, panels)


def variation(result: tc.Result) -> float:
    """Return all changes of the penetration energy together over twice its largest value: 1 for a rise and a fall."""
    stored = result.history["contact"]
    return float(np.abs(np.diff(stored)).sum() / (2.0 * stored.max()))


def _share(result: tc.Result) -> float:
    """Return the largest penetration energy over that of the first plane wave, (rho c v A)^2/(2 penalty A).

    The force begins with that of the wave and overshoots by 31 % (1-D); nodes with mass bounce on the penalty.
    """
    scene, body = result.scene, result.scene.bodies[0]
    contact = scene.contact
    stiffness = contact.penalty if isinstance(contact, tc.MasslessContact) else contact.stiffness
    pressure = body.material.density * body.material.wave_speed * -body.velocity[2]
    area = np.cbrt(ck.volume(body.mesh)) ** 2
    return float(result.history["contact"].max() / (pressure**2 * area / (2.0 * stiffness)))


def checks(result: tc.Result) -> list[ck.Check]:
    """Check momentum, how large the penetration energy gets, and how often it rises and falls."""
    found = [ck.finished(result), ck.thrown(result), ck.touched(result)]
    found += [ck.momentum_balance(result, 1e-9), ck.pushing(result)]
    if not result.ok or not result.history["contact"].max() > 0.0:
        return found
    smooth = isinstance(result.scene.contact, tc.MasslessContact)
    found.append(ck.between("largest penetration energy / plane wave", _share(result), 0.9, 1.75 if smooth else np.inf))
    name, value = "variation of the penetration energy", variation(result)
    if result.dt >= 0.9 * result.dt_limit:
        found.append(ck.at_most(name, value, 1.1) if smooth else ck.at_least(name, value, 2.0))
    else:
        found.append(ck.at_most(name, value, 1.2) if smooth else ck.at_least(name, value, 1.5))
    return found


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "penetration-energy", *sys.argv[1:]]))
