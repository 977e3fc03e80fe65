"""Guards: check every row and stop a run that has failed, with place and remedy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.errors import FunctionError
from ..scene.scene import Scene
from ..scene.tension_limit import tension_advice
from ..schemes import ImplicitScheme, Scheme
from ..schemes.explicit.body_view import BodyView
from ..schemes.explicit.central_difference import DEFAULT_CFL
from .checkpoint.keeper import Keeper
from .history import History
from .worst_cell import worst_cell_of

GROWTH = 10.0  # energy over that of the start and of the work done above which a run has diverged
AT_ONCE = 2  # rows up to which a value that is not finite comes from the start and not from the step
FAST = 0.1  # share of the wave speed below which a motion makes no shock
LATEST = 0.1  # share of the rows before a stop in which the motion may be that of the failure itself
FAILED = ("diverged", "inverted-cell", "not-converged")  # reasons that what happened before may have
TINY = 1e-14  # energy per volume over density c^2 below which it is rounding


@dataclass(frozen=True)
class Stop:
    """The stop of a run: reason as in `Result.reason`, and a message with place, time and remedy."""

    reason: str
    message: str


class Guards:
    """Checks for NaN, inverted cells, energy growth and static solves that did not converge."""

    def __init__(self, scene: Scene, states: list[BodyView], scheme: Scheme) -> None:
        self.scene, self.scheme = scene, scheme
        self.states = states
        self.floor = self.rounding()
        self.nonlinear = [not state.plan.body.linear for state in states]

    def rounding(self) -> float:
        """Return the energy [J] up to which a change is rounding."""
        return sum(TINY * float(state.plan.lumped.sum()) * state.plan.body.wave_speed**2 for state in self.states)

    def limits(self, history: History, jacobian: float) -> dict[str, float]:
        """Return the limits at which a launch of many rows ends, for `check` to judge the row.

        jacobian: det F at or below which it ends.
        """
        if history.steps == 0:
            return {}
        minimum = max(0.0, jacobian) if any(self.nonlinear) else -np.inf
        return {"jacobian": minimum, "energy": self._most(history)}

    def _most(self, history: History) -> float:
        """Return the energy [J] above which a run has diverged; one that starts below 0 may gain as much as another."""
        budget = history.budget()
        return (GROWTH if budget >= 0.0 else 2.0 - GROWTH) * budget + self.floor

    def _growth(self, energy: float, history: History) -> str:
        """Return how an energy [J] has grown above `_most`, in words."""
        budget = history.budget()
        given = f"the {budget:.3g} J that the run started with or was given"
        if budget >= 0.0:
            return f"the energy grew to {energy:.3g} J, over {GROWTH:g} times {given}"
        return f"the energy grew to {energy:.3g} J from {given}, by over {GROWTH - 1.0:g} times as much"

    def check(self, row: np.ndarray, history: History, over_limit: bool, step: float = 0.0) -> Stop | None:
        """Return the stop that the last row requires, or None.

        over_limit: the step is above the stable one; step [s]: the one that has been made since the row.
        """
        layout = history.layout
        time = f"at t = {row[layout.place['time'].start]:.6g} s"
        remedy = "the step is above the stable one (Result.dt_limit): use a smaller dt or cfl < 1"
        tension = tension_advice(self.scene.bodies)
        if any(self.nonlinear) and not row[layout.place["jacobian_min"]][0] > 0.0:
            law, where = self.worst(step, failing=True)
            if over_limit:
                return Stop("diverged", f"{where} {time}; {remedy}")
            from ..kernels.materials import LAWS  # imports Taichi

            advice = LAWS[law].refusal or self._against_inversion(history)
            advice += f"; {tension}" if tension else ""  # beyond it a body expands, and springs back through itself
            return Stop("inverted-cell", f"{where} {time}; {advice}")
        finite = bool(np.isfinite(row[layout.summed]).all())
        energy = layout.stored(row)
        if not finite or energy > self._most(history):
            what = self._growth(energy, history) if finite else "a value is not finite"
            _law, where = self.worst(step)
            advice = remedy if over_limit else "lower cfl, or the contact stiffness"
            if not (finite or over_limit) and history.steps <= AT_ONCE:
                advice = "look at the units of velocities, loads, gravity and density: no step is small enough"
            elif isinstance(self.scheme, ImplicitScheme):
                advice = self.scheme.remedy
            if tension and not over_limit:
                advice = f"{tension}; if nothing is pulled so far, {advice}"
            return Stop("diverged", f"{what} {time}; {where}; {advice}")
        for state in self.states:
            if state.trouble:
                where = f"; {self.worst(step)[1]} there" if self.scheme.implicit else ""
                where += f"; {tension}" if tension else ""
                return Stop("not-converged", f"{state.plan.label}, {time}: {state.trouble}{where}")
        return None

    def is_fast(self, history: History) -> bool:
        """Return whether bodies may have had a shock: they moved fast before the last rows, or an obstacle is driven.

        The kinetic energy is taken as if the lightest body had it all.
        """
        lightest = min(float(state.plan.lumped.sum()) for state in self.states)
        kinetic = history.columns()["kinetic"]
        before = kinetic[: max(1, int((1.0 - LATEST) * len(kinetic)))]
        speed = np.sqrt(2.0 * float(before.max(initial=0.0)) / lightest)
        slowest = min(material.wave_speed for state in self.states for material in state.plan.body.materials)
        bodies = [self.scene.starting(number) for number in range(len(self.scene.bodies))]
        start = max(float(np.linalg.norm(body.initial_velocity, axis=1).max()) for body in bodies)
        moves = any(obstacle.moves for obstacle in self.scene.obstacles)
        return moves or len(kinetic) <= 2 * AT_ONCE or max(speed, start) > FAST * slowest

    def _against_inversion(self, history: History) -> str:
        """Return the remedy for crushed cells: in a shock bulk viscosity, as a smaller step does not help."""
        if not self.scheme.implicit and not self.is_fast(history):
            step = "a smaller dt"
            if self.scheme.dt is None:
                step = f"a lower cfl, such as {0.5 * (self.scheme.cfl or DEFAULT_CFL):.3g}"
            what = "loads, supports or contact press the cell through itself"
            return (
                f"nothing is fast, so that this is no shock: {what}; use {step}, refine the mesh there, or press less"
            )
        elsewhere = "without a shock, refine the mesh there or lower the speed"
        if self.scheme.implicit:
            return f"use a smaller dt; in a shock use scheme='central-difference' with BulkViscosity; {elsewhere}"
        viscosity = self.scene.viscosity
        if viscosity is None:
            advice = "in a shock give the scene viscosity=tc.BulkViscosity(), which helps more than a lower cfl"
            return f"{advice}; {elsewhere}"
        more = 2.0 * viscosity.quadratic
        return f"in a shock give more viscosity, such as BulkViscosity(quadratic={more:.3g}), or use tet4; {elsewhere}"

    def worst(self, step: float, failing: bool = False) -> tuple[str, str]:
        """Return the law of the cell with the smallest det F at the row, and the cell in words.

        step [s]: that since the row; failing: among the cells of nonlinear laws.
        """
        worst = None
        for state, may in zip(self.states, self.nonlinear, strict=True):
            if failing and not may:
                continue
            with np.errstate(all="ignore"):
                there = state.displacement_before(step)
            cell, value = worst_cell_of(state.plan.body, there, failing)
            if worst is None or not value >= worst[2]:
                worst = state, cell, value
        assert worst is not None
        state, cell, value = worst
        body = state.plan.body
        place = ", ".join(f"{part:.4g}" for part in body.mesh.cell_centres()[cell])
        everyone = np.arange(body.mesh.cell_count)
        law = next(block.material.law for block in body.blocks if cell in everyone[block.numbers])
        return law, f"cell {cell} of {state.plan.label} (reference centre {place}) has det F = {value:.3g}"


def early_stop(time: float, end: float, failed: FunctionError | None, cut: str, keeper: Keeper | None) -> Stop | None:
    """Return why a run without a fault ends at a time [s]: a function failed, or a signal `cut` it; None at its end."""
    kept = f"at t = {time:.6g} s; everything up to then is kept"
    if failed is not None:
        return Stop("function-failed", f"{failed}; stopped {kept}")
    if time >= end:
        return None
    if keeper is not None and keeper.written:
        kept += f"; `tcontact resume {keeper.folder}` goes on from there"
    return Stop("interrupted", f"stopped by {cut} {kept}")


def explained(stop: Stop | None, entered: str) -> Stop | None:
    """Return a stop with what came before it in the message: bodies that met where no contact holds them, or ""."""
    if stop is None or not entered or stop.reason not in FAILED:
        return stop
    return Stop(stop.reason, f"{stop.message}; before that {entered}")
