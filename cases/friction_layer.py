"""A thin layer of metal under sliding contact heats, softens and, at high speed, all but melts.

This is section 2 of Le Tallec, Dambakizi and Hauret (2007): one cell at 34 m/s and 1.3 GPa, a layer of 10 um, 200
points, steps of 1 ns to 0.6 us; then again at a speed that brings the surface to melting. The paper states no constants
of its metal, so its Figs. 2 and 3 are reproduced in kind. There is no mechanical scene: velocity and pressure are
given.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np

import tcontact as tc
from tcontact import friction_layer as layer
from tcontact.cases._inputs import checked
from tcontact.device import runtime
from tcontact.friction_layer import figures, study
from tcontact.results import checks as ck
from tcontact.results import report

SNAPSHOTS = 6  # yield limits over the depth, evenly spread over the run


@dataclass(frozen=True)
class Runs:
    """Results of what the case ran, by label, the runs that end at the snapshots, and the parameters as given."""

    results: Mapping[str, layer.LayerResult]
    profiles: Mapping[str, list[layer.LayerResult]]
    velocities: Mapping[str, float]
    metal: layer.Metal
    parameters: Mapping[str, object]


@checked
def solve(
    *,
    velocity: float = 34.0,
    melting_velocity: float | None = 340.0,
    pressure: float = 1.3e9,
    thickness: float = 10e-6,
    points: int = 200,
    grading: float = 1.0,
    dt: float = 1e-9,
    duration: float = 0.6e-6,
    metal: Literal["stainless-304", "copper", "aluminium-6061"] = "stainless-304",
    heat_share: float = 0.5,
    plastic_heat: float = 0.0,
    initial_temperature: float = 300.0,
    method: Literal["bracketed-newton", "thermal-softening-secant", "stress-secant"] = "bracketed-newton",
) -> Runs:
    """Solve the layer at `velocity` and, unless None, at `melting_velocity`; SI units, see `friction_layer.solve`."""
    parameters = dict(locals())
    if metal not in layer.METALS:
        raise tc.InputError("metal", metal, "use one of " + ", ".join(layer.METALS))
    options = {
        name: parameters[name]
        for name in ("pressure", "thickness", "points", "grading", "dt", "heat_share", "plastic_heat", "method")
    } | {"initial_temperature": initial_temperature, "arch": runtime.arch()}
    velocities = {f"{speed:g} m/s": speed for speed in (velocity, melting_velocity) if speed is not None}
    times = [duration * (k + 1) / SNAPSHOTS for k in range(SNAPSHOTS)]
    profiles = {
        label: [layer.solve(layer.METALS[metal], speed, duration=time, **options) for time in times]
        for label, speed in velocities.items()
    }
    results = {label: runs[-1] for label, runs in profiles.items()}
    return Runs(results, profiles, velocities, layer.METALS[metal], parameters)


def checks(runs: Runs) -> list[ck.Check]:
    """Check the laws of the model for every run, and the independent figures where the parameters are theirs."""
    found = []
    for label, run in runs.results.items():
        found += _laws(label, run, runs)
    defaults = solve.__kwdefaults__
    same = {name for name, value in runs.parameters.items() if value == defaults[name]}
    if set(defaults) - same <= {"points", "grading", "velocity", "melting_velocity", "method"}:
        for label, speed in runs.velocities.items():
            found += _figures(label, speed, runs.results[label])
    return found


def _laws(label: str, run: layer.LayerResult, runs: Runs) -> list[ck.Check]:
    """Check what holds for any layer: (7) summed over the depth, the heat balance, bounds of stress and temperature."""
    metal, stress = runs.metal, np.sqrt(3.0) * run.shear_stress[:, 0]
    thickness, weight = run.depth[-1], np.gradient(run.depth)
    weight[[0, -1]] /= 2.0
    compliance = thickness / (3.0 * metal.shear_modulus)
    sum_of_7 = compliance * (stress[-1] - stress[0]) + run.plastic_strain[0] @ weight
    share, plastic = runs.parameters["heat_share"], runs.parameters["plastic_heat"]
    heat = share * run.slip_work[0] + plastic * run.plastic_work[0] - run.carried_heat[0]
    hottest = max(metal.melting_temperature, runs.parameters["initial_temperature"])
    return [
        ck.equals(f"{label}: failed steps", run.failures[0], 0),
        ck.at_most(f"{label}: hottest / melting", run.surface_temperature.max() / hottest, 1.0),
        ck.at_most(f"{label}: rise of tau in a step", np.diff(stress).max(), 0.0),
        ck.at_most(
            f"{label}: sig / yield limit - 1", (stress[-1] / np.maximum(run.yield_stress[0], 1e-300)).max() - 1.0, 1e-11
        ),
        ck.at_most(f"{label}: sum of (7)", abs(sum_of_7) / max(compliance * stress[0], 1e-300), 1e-12),
        ck.at_most(f"{label}: heat balance", abs(run.heat[0] - heat) / max(heat, 1e-300), 1e-12),
    ]


def _figures(label: str, speed: float, run: layer.LayerResult) -> list[ck.Check]:
    """Check the errors against the independent code of `friction_layer.study`, at its times."""
    if speed == 34.0:
        hot, weak, _ = study.errors(run, speed)
        return [
            ck.at_most(f"{label}: temperature error / rise, 0.1..0.6 us", hot, 2e-3),
            ck.at_most(f"{label}: tau error, 0.1..0.6 us", weak, 2e-3),
        ]
    if speed == 340.0:
        at = [round(time / run.dt) for time in study.TIMES]
        hot = np.abs(run.surface_temperature[at, 0] / study.REFERENCE[speed][0] - 1.0)
        weak = np.abs(1e-6 * run.shear_stress[at, 0] / study.REFERENCE[speed][1] - 1.0)
        return [
            ck.at_most(f"{label}: temperature error at 0.3 us", hot[2], 3e-3),
            ck.at_most(f"{label}: tau error at 0.3 us", weak[2], 3e-3),
            ck.at_most(f"{label}: tau error at 0.6 us", weak[5], 1e-2),
        ]
    return []


def write(runs: Runs, out: Path) -> None:
    """Write history.csv, profile.csv, yield-limit.png (Fig. 2) and surface.png (Fig. 3)."""
    history: dict[str, np.ndarray] = {"time": next(iter(runs.results.values())).time}
    profile: dict[str, list[np.ndarray]] = {}
    for label, run in runs.results.items():
        name = label.replace(" m/s", "")
        history |= {f"surface_temperature_{name}": run.surface_temperature[:, 0]}
        history |= {f"shear_stress_{name}": run.shear_stress[:, 0]}
        for snapshot in runs.profiles[label]:
            columns = {
                "velocity": np.full(len(run.depth), runs.velocities[label]),
                "time": np.full(len(run.depth), snapshot.time[-1]),
                "depth": snapshot.depth,
                "yield_stress": snapshot.yield_stress[0],
                "temperature": snapshot.temperature[0],
                "plastic_strain": snapshot.plastic_strain[0],
            }
            for column, values in columns.items():
                profile.setdefault(column, []).append(values)
    report.write_history(out / "history.csv", history)
    report.write_history(out / "profile.csv", {name: np.concatenate(parts) for name, parts in profile.items()})
    figures.yield_limits(out / "yield-limit.png", runs.profiles)
    figures.surface(out / "surface.png", runs.results, runs.metal.melting_temperature)


def summary(runs: Runs) -> dict[str, object]:
    """Return scalars for summary.json and the table."""
    return {
        label: {
            "surface_temperature": run.surface_temperature[-1, 0],
            "shear_stress": run.shear_stress[-1, 0],
            "slip_work": run.slip_work[0],
            "heat": run.heat[0],
            "failures": int(run.failures[0]),
            "evaluations_per_step": run.evaluations[0] / run.steps,
            "steps": run.steps,
            "dt": run.dt,
            "wall_s": run.wall_s,
            "compile_s": run.compile_s,
        }
        for label, run in runs.results.items()
    }


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "friction-layer", *sys.argv[1:]]))
