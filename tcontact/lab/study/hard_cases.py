"""The hard cases: where a contact code can break, what it must do there, and what it did.

A case builds its runs, small or at full size, and judges their results by checks. The verdict is computed:

    right     every run finished and every check passed       wrong    finished, but a check failed
    refused   `InputError` before anything ran                stopped  a guard ended the run
    crashed   anything else

and compared with what is expected: a refusal or a stop counts only if its message names the remedy.

A case compares what it claims with something that its own run did not compute: an exact solution, a rigid body, or the
figures of independent code in `tcontact.lab.study.hard.references`. So it must come out wrong where the computation is
spoilt: `tests/sabotage.py` takes the wall away, alters modulus, density, duration, gravity or the contact method behind
its back. What a case cannot feel of that for a physical reason it declares in `cannot_feel`.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...results import checks as ck
from ...results.result import Result
from ...scene.scene import Scene
from ...schemes.explicit.central_difference import CentralDifference

TOLERANCE = 1e-4  # tolerance of the static solve where the scene names none
CHANGES = ("wall", "method", "modulus", "density", "duration", "gravity")  # what a case may declare that it cannot feel


def nothing(reason: str, but: str = "") -> dict[str, str]:
    """Return `cannot_feel` of a pure property: no change may alter its verdict, but one at most, for one reason."""
    return {change: reason for change in CHANGES if change != but}


@dataclass(frozen=True, eq=False)
class Run:
    """One run of a case: the scene, its time scheme, how many steps make a row, its precision."""

    scene: Scene
    scheme: CentralDifference = field(default_factory=CentralDifference)
    history_every: int = 1
    precision: str = "f64"


@dataclass(frozen=True, eq=False)
class HardCase:
    """A hard case.

    name; hard: what is hard about it; runs(full) -> its runs; judge(results) -> checks if every run finished,
    judge_stopped(results) -> checks if a guard ended one; expected: the verdicts that are right answers; says: what the
    message of a refusal or a stop must contain; remedy: what the user should do; cannot_feel: changes (of CHANGES) that
    must not alter the verdict, each with the physical reason.
    """

    name: str
    hard: str
    runs: Callable[[bool], list[Run]]
    judge: Callable[[list[Result]], list[ck.Check]]
    expected: tuple[str, ...] = ("right",)
    says: str = ""
    remedy: str = ""
    judge_stopped: Callable[[list[Result]], list[ck.Check]] = lambda results: []
    cannot_feel: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a case did: verdict, whether it is an expected one, in words, and the largest errors of its runs."""

    case: HardCase
    verdict: str
    as_expected: bool
    detail: str
    energy_error: float
    momentum_error: float
    static_residual: float
    steps: int
    wall_s: float
    checks: list[ck.Check]


def evaluate(case: HardCase, full: bool = False, threads: int | None = None) -> Outcome:
    """Run a case and judge it."""
    import tcontact as tc

    begun = perf_counter()
    results: list[Result] = []
    checks: list[ck.Check] = []
    detail = ""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            for run in case.runs(full):
                options: dict[str, Any] = {
                    "threads": threads,
                    "history_every": run.history_every,
                    "precision": run.precision,
                }
                result = tc.simulate(run.scene, run.scheme, **options)
                results.append(result)
            stopped = [result for result in results if not result.ok]
            checks = case.judge_stopped(results) if stopped else case.judge(results)
            verdict = "stopped" if stopped else "right"
            verdict = verdict if all(check.passed for check in checks) else "wrong"
            detail = "; ".join(f"{result.reason}: {result.message}" for result in stopped)
        except InputError as error:
            verdict, detail = "refused", str(error)
        except Exception as error:  # a crash is a row of the table, not its end
            verdict, detail = "crashed", f"{type(error).__name__}: {error}"
    if verdict == "wrong":
        detail = "; ".join(_words(check) for check in checks if not check.passed)
    named = verdict not in ("refused", "stopped") or (bool(case.says) and case.says in detail)
    return Outcome(
        case=case,
        verdict=verdict,
        as_expected=verdict in case.expected and named,
        detail=detail,
        energy_error=_worst(results, lambda result: np.abs(result.history["energy_error"]).max()),
        momentum_error=_worst(results, lambda result: float(ck.momentum_balance(result, 0.0).value)),
        static_residual=_worst(results, lambda result: result.history["static_residual"].max()),
        steps=sum(result.steps for result in results),
        wall_s=perf_counter() - begun,
        checks=checks,
    )


def _worst(results: Sequence[Result], measure: Callable[[Result], Any]) -> float:
    with np.errstate(all="ignore"):
        return float(np.max([float(measure(result)) for result in results])) if results else np.nan


def sound(results: Sequence[Result], energy: float = 0.05, momentum: float = 1e-8) -> list[ck.Check]:
    """Check the laws that every impact obeys, the worst of the results.

    Contact at all; energy, momentum against impulses, no overlap, forces that push, massless nodes in balance to the
    tolerance.
    """
    pushing = [ck.pushing(result) for result in results if len(result.scene.obstacles) == 1]
    residual = _worst(results, lambda result: result.history["static_residual"].max())
    return [
        worst([ck.touched(result) for result in results]),
        worst([ck.energy(result, energy) for result in results]),
        *([worst(pushing)] if pushing else []),
        ck.at_most("static residual", residual, TOLERANCE),
        worst([ck.momentum_balance(result, momentum) for result in results]),
        worst([ck.no_overlap(result) for result in results]),
    ]


def worst(checks: Sequence[ck.Check]) -> ck.Check:
    """Pick one of several runs' results of a check: a failed one, else the one with the largest magnitude."""
    return max(checks, key=lambda check: (not check.passed, abs(float(check.value))))


def _words(check: ck.Check) -> str:
    """Return name, value and bound of a check as text."""
    value = check.value if isinstance(check.value, str) else f"{check.value:.3g}"
    return f"{check.name} {value} ({check.bound})"
