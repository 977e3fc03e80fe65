"""A nearly incompressible beam swings: the trapezoidal rule gains energy until it breaks, conserving schemes keep it.

This is the contrast of section 3.1 of Le Tallec, Dambakizi and Hauret 2007. A beam 1 m x 0.1 m in plane strain
(neo-Hookean, mu 1 MPa, rho 1000, mean dilatation) is clamped at its left end and thrown up with v_y = speed
(x/length)^2; it bends through large rotations. compare=true runs every implicit scheme at the same step and plots their
energies.
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

SCHEME = {"scheme": "discrete-gradient", "dt": 0.02}


@checked
def scene(
    *,
    cells: int = 20,
    ratio: float = 10.0,
    shear: float = 1e6,
    density: float = 1000.0,
    length: float = 1.0,
    speed: float = 5.0,
    duration: float = 3.0,
) -> tc.Scene:
    """A beam of `cells` hexes along its length, a tenth as many through its height and one across, swings.

    SI units. ratio: lambda/mu; shear: mu; speed: of the free end at the start.
    """
    choices.positive(cells=cells, ratio=ratio, shear=shear, length=length, speed=speed)
    poisson = ratio / (2.0 * (ratio + 1.0))
    material = tc.NeoHookean(young=2.0 * shear * (1.0 + poisson), poisson=poisson, density=density)
    rows = max(1, round(cells / 10))
    box = tc.box_mesh(size=(length, length / 10, length / cells), cells=(cells, rows, 1))
    mesh = tc.Mesh(box.nodes, box.cells, "hex8", {"all": np.arange(box.node_count)}, box.face_sets)
    beam = tc.Body(
        mesh,
        material,
        velocity=lambda x: speed * (x[:, :1] / length) ** 2 * np.array([0.0, 1.0, 0.0]),
        supports=[tc.Support("xmin", "xyz"), tc.Support("all", "z")],
        name="beam",
        formulation="mean-dilatation",
    )
    return tc.Scene(bodies=[beam], duration=duration)


def comparison(**parameters: object) -> dict[str, tuple[tc.Scene, object]]:
    """Compare the implicit schemes at a step of 0.02 s (0.01 s from lambda/mu = 100 on): who keeps the energy."""
    own = scene(**parameters)
    dt = 0.02 if parameters.get("ratio", 10.0) < 100.0 else 0.01
    schemes = (
        tc.Trapezoidal(dt=dt),
        tc.Midpoint(dt=dt),
        tc.StressAveraging(dt=dt),
        tc.TransportAveraging(dt=dt),
        tc.HilberHughesTaylor(dt=dt),
        tc.PaperImplicit(dt=dt),
        tc.Gonzalez(dt=dt),
        tc.DiscreteGradient(dt=dt),
    )
    return {scheme.name: (own, scheme) for scheme in schemes}


def draw_comparison(path: Path, histories: dict[str, dict[str, np.ndarray]]) -> None:
    """Draw the energy of the schemes over that at the start."""
    energies(path, histories)


def checks(result: tc.Result) -> list[ck.Check]:
    """Check that conserving schemes keep the energy; others only report what became of it."""
    if result.reason == "diverged":
        return [ck.at_least("energy / energy at the start", result.history["energy"].max(), 2.0 * start(result))]
    energy, body = result.history["energy"], result.scene.bodies[0]
    tip, cells = float(np.abs(body.initial_velocity).max()), len(np.unique(np.round(body.mesh.nodes[:, 0], 12))) - 1
    thrown = start(result) / (
        ck.mass(result) * tip**2 / 10.0
    )  # m v^2/10 of the parabola; lumped mass: more by 5/(3 n^2)
    found = [ck.finished(result), ck.at_most("energy thrown in, error", abs(thrown - 1.0), 5.0 / cells**2)]
    if "energy" in conserved(result):
        found.append(ck.energy(result, 1e-8))
    else:
        found.append(ck.between("energy at the end / at the start", energy[-1] / energy[0], 0.0, 10.0))
    return found


def start(result: tc.Result) -> float:
    """Return the energy at the start [J]."""
    return float(result.history["energy"][0])


def conserved(result: tc.Result) -> tuple[str, ...]:
    """Return what the scheme of the run conserves."""
    return tuple(getattr(result.scheme, "conserves", ()))


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "incompressible-beam", *sys.argv[1:]]))
