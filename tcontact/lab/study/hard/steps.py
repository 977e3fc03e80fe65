"""Steps at and beyond the stable one, and a penalty that would be hopeless on nodes with mass."""

from __future__ import annotations

from dataclasses import replace

import tcontact as tc
from tcontact.cases import bar_impact, cube_impact

from ....results import checks as ck
from ....results.result import Result
from ..hard_cases import HardCase, Run, sound
from .references import against, against_plane_wave, stable_step

TRUE = 1.04  # the limit that the program states is 97 to 100 % of the true one
LEFT = {"duration": "the cube has left the wall before half of the run"}


def cases() -> list[HardCase]:
    """Return the cases: steps."""
    return [
        HardCase(
            "step-0.99",
            "0.99 of the stable step, through contact",
            lambda full: [Run(_cube(full, law), tc.CentralDifference(cfl=0.99)) for law in ("linear", "neo-hookean")],
            lambda results: [
                ck.equals("warnings", sum(len(result.warnings) for result in results), 0),
                stable_step("step", results),
                *against("step-0.99", results),
                *sound(results, energy=0.06, momentum=1e-4),
            ],
            cannot_feel=LEFT,
        ),
        HardCase(
            "step-above-limit",
            "1.005 of the stable step: finished or not, there must be a warning",
            lambda full: [Run(_cube(full, "linear"), tc.CentralDifference(dt=1.005 * limit(_cube(full, "linear"))))],
            lambda results: [
                *_limit(results),
                *against("step-above-limit", results),
                ck.touched(results[0]),
                ck.no_overlap(results[0]),
            ],
            judge_stopped=_limit,
            cannot_feel=LEFT,
            expected=("right", "stopped"),
            says="stable",
            remedy="a smaller dt or cfl < 1",
        ),
        HardCase(
            "step-1.3",
            "1.3 times the true limit: must end as diverged",
            lambda full: [
                Run(_cube(full, "linear"), tc.CentralDifference(dt=1.3 * TRUE * limit(_cube(full, "linear"))))
            ],
            lambda results: [],
            judge_stopped=_limit,
            cannot_feel={
                "method": "the step is too large for the free body, however its contact is resolved",
                "duration": "it blows up in the first half",
            },
            expected=("stopped",),
            says="diverged",
            remedy="a smaller dt or cfl < 1",
        ),
        HardCase(
            "penalty-1e8-massless",
            "a penalty of 1e8 young/h on nodes without mass: same step, same answer as the exact constraint",
            lambda full: [Run(bar_impact.scene(cells=160 if full else 20, penalty=p)) for p in (None, 1e8)],
            lambda results: [
                ck.equals("steps taken for it", results[1].steps / results[0].steps, 1.0),
                _same(results),
                *against_plane_wave(results, 2e-4),
                *sound(results[:1], energy=0.02),
            ],
        ),
    ]


def _cube(full: bool, law: str) -> tc.Scene:
    return cube_impact.scene(cells=8 if full else 4, law=law, duration=8e-3)


def limit(scene: tc.Scene) -> float:
    """Return the stable step [s] that the program states for a scene."""
    return tc.simulate(replace(scene, duration=1e-12)).dt_limit


def _limit(results: list[Result]) -> list[ck.Check]:
    """Check that the program warns of the step and states the limit, as far as it is known."""
    return [
        stable_step("step", results),
        ck.equals("warned of the step", sum(map(_warned, results)), len(results)),
    ]


def _warned(result: Result) -> bool:
    return any("above the stable step" in text for text in result.warnings)


def _same(results: list[Result]) -> ck.Check:
    exact, other = (result.history["contact_force"][:, 2] for result in results)
    return ck.at_most("largest difference of the forces", abs(exact - other).max() / exact.max(), 1e-5)
