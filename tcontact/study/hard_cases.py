"""The hard cases: where a contact code can break, what it must do there, and what it did.

A case builds its runs, small or at full size, and judges their results by checks. The verdict is computed:

    right     every run finished and every check passed       wrong    finished, but a check failed
    refused   `InputError` before anything ran                stopped  a guard ended the run
    crashed   anything else

and compared with what is expected: a refusal or a stop counts only if its message names the remedy.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np

from .. import checks as ck
from ..errors import InputError
from ..result import Result
from ..scene import Scene
from ..schemes.central_difference import CentralDifference

TOLERANCE = 1e-4  # of the static solve where the scene names none


@dataclass(frozen=True, eq=False)
class Run:
    """One run of a case: the scene, its time scheme, how many steps make a row."""

    scene: Scene
    scheme: CentralDifference = field(default_factory=CentralDifference)
    history_every: int = 1


@dataclass(frozen=True, eq=False)
class HardCase:
    """A hard case.

    name; hard: what is hard about it; runs(full) -> its runs; judge(results) -> checks; expected: the verdicts that
    are right answers; says: what the message of a refusal or a stop must contain; remedy: what the user should do.
    """

    name: str
    hard: str
    runs: Callable[[bool], list[Run]]
    judge: Callable[[list[Result]], list[ck.Check]]
    expected: tuple[str, ...] = ("right",)
    says: str = ""
    remedy: str = ""


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


def register() -> dict[str, HardCase]:
    """All hard cases by name."""
    from .hard import impacts, invariances, long_runs, materials, meshes, starts, steps

    modules = (materials, meshes, impacts, starts, steps, long_runs, invariances)
    found: dict[str, HardCase] = {}
    for case in (case for module in modules for case in module.cases()):
        assert case.name not in found, case.name
        found[case.name] = case
    return found


def choose(names: Sequence[str] | None) -> list[HardCase]:
    """The named cases, all without names. Raises `InputError` with the known ones."""
    known = register()
    for name in names or ():
        if name not in known:
            raise InputError("--methods", name, "use hard cases by name: " + ", ".join(known))
    return [known[name] for name in names or known]


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
                result = tc.simulate(run.scene, run.scheme, threads=threads, history_every=run.history_every)
                results.append(result)
            stopped = [result for result in results if not result.ok]
            checks = case.judge(results) if not stopped else []
            verdict = "stopped" if stopped else "right" if all(check.passed for check in checks) else "wrong"
            detail = "; ".join(f"{result.reason}: {result.message}" for result in stopped)
        except InputError as error:
            verdict, detail = "refused", str(error)
        except Exception as error:  # a crash is a row of the table, not its end
            verdict, detail = "crashed", f"{type(error).__name__}: {error}"
    if verdict == "wrong":
        detail = "; ".join(f"{check.name} {check.value:.3g} ({check.bound})" for check in checks if not check.passed)
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
        return float(max((float(measure(result)) for result in results), default=np.nan))


def sound(results: Sequence[Result], energy: float = 0.05, momentum: float = 1e-8) -> list[ck.Check]:
    """The laws every impact obeys, worst of the results.

    Energy, momentum against impulses, no overlap, forces that push, massless nodes in balance to the tolerance.
    """
    worst = max(results, key=lambda result: float(np.abs(result.history["energy_error"]).max()))
    pushing = [ck.pushing(result) for result in results if len(result.scene.obstacles) == 1]
    residual = _worst(results, lambda result: result.history["static_residual"].max())
    return [
        ck.energy(worst, energy),
        *sorted(pushing, key=lambda check: check.value)[:1],
        ck.at_most("static residual", residual, TOLERANCE),
        max((ck.momentum_balance(result, momentum) for result in results), key=lambda check: check.value),
        max((ck.no_overlap(result) for result in results), key=lambda check: check.value),
    ]
