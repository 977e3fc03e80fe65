"""Checks: a value with a name against a bound, and the checks that hold for every impact.

A case returns a list of these from `checks(result)`; `tcontact run` prints them, writes them into summary.json and
fails when one does. A value that is not a number never passes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..kernels.columns import COLUMNS
from ..mesh.mesh import Mesh
from .result import Result


@dataclass(frozen=True)
class Check:
    """One value against its bound.

    name: what is checked; value: what the run gave; bound: the condition in words, such as "<= 0.05"; passed: whether
    the value meets it.
    """

    name: str
    value: float | str
    bound: str
    passed: bool

    def to_dict(self) -> dict[str, Any]:
        """Return the check as plain data for summary.json; a value that is not finite becomes text."""
        value = self.value
        if isinstance(value, float) and not math.isfinite(value):
            value = str(value)
        return {"name": self.name, "value": value, "bound": self.bound, "passed": self.passed}


def at_most(name: str, value: float, bound: float) -> Check:
    """Check that value <= bound."""
    return Check(name, float(value), f"<= {bound:.4g}", bool(value <= bound))


def at_least(name: str, value: float, bound: float) -> Check:
    """Check that value >= bound."""
    return Check(name, float(value), f">= {bound:.4g}", bool(value >= bound))


def between(name: str, value: float, low: float, high: float) -> Check:
    """Check that low <= value <= high."""
    return Check(name, float(value), f"{low:.5g} .. {high:.5g}", bool(low <= value <= high))


def equals(name: str, value: float, wanted: float) -> Check:
    """Check that value == wanted, for counts."""
    return Check(name, float(value), f"= {wanted:g}", bool(value == wanted))


def finished(result: Result) -> Check:
    """Check that the run reached its end, at the time that its scene asks for."""
    whole = bool(result.time >= result.scene.duration * (1.0 - 1e-9))
    return Check("finished", result.reason, "= finished", result.reason == "finished" and whole)


def momentum_balance(result: Result, bound: float) -> Check:
    """Check that the momentum changes by the impulse of contact, supports, loads, gravity and damping, in every row.

    The value is the largest deviation relative to the largest momentum or impulse of the run.
    """
    history, scene = result.history, result.scene
    change = history["momentum"] - history["momentum"][0]
    impulse = sum(history[column.name] for column in COLUMNS if column.impulse and column.name in history)
    if scene.gravity is not None and not callable(scene.gravity):
        moved = mass(result) + scene.rigid_mass
        impulse = impulse + np.outer(history["time"], moved * np.asarray(scene.gravity, dtype=float))
    parts = [
        np.abs(history[name]).max(initial=0.0) for name in ("momentum", "impulse", "support_impulse") if name in history
    ]
    scale = max(*parts, np.abs(impulse).max(), np.finfo(float).tiny)
    return at_most("momentum = impulses", np.abs(change - impulse).max() / scale, bound)


def thrown(result: Result) -> Check:
    """Check the momentum at the start against mass times mean velocity of the nodes, uniform or affine on a box."""
    wanted = np.zeros(3)
    for body in result.scene.bodies:
        wanted = wanted + body.mass * body.initial_velocity.mean(axis=0)
    momentum = result.history["momentum"]
    error = np.linalg.norm(momentum[0] - wanted) / np.linalg.norm(wanted)
    return at_most("momentum at the start / m v, error", error if np.isfinite(momentum).all() else np.nan, 1e-6)


def pushing(result: Result) -> Check:
    """Check that contact forces push: the smallest normal component over the steps and, at the end, over the nodes.

    The value is relative to the largest contact force. The check is for scenes with one flat obstacle.
    """
    normal = result.scene.obstacles[0].frame[2]
    total = result.history["contact_force"] @ normal
    nodes = result.contact_node_force @ normal
    scale = max(np.abs(total).max(), np.finfo(float).tiny)
    return at_least("contact pushes", np.min([total.min(), nodes.min(), 0.0]) / scale, 0.0)


def touched(result: Result) -> Check:
    """Check that the bodies touched an obstacle: the number of rows of the history with a contact force."""
    largest = np.abs(result.history["contact_force"]).max(axis=1)
    return at_least("rows with contact", np.sum(largest > 0.0) if np.isfinite(largest).all() else np.nan, 1)


def one_touch(result: Result, pair: str) -> Check:
    """Check that two bodies touch once: how often their force rises from 0."""
    force = np.linalg.norm(result.pair_force[pair], axis=1)
    pressed = force > 1e-6 * force.max()
    times = np.sum(np.diff(pressed.astype(int)) > 0) + pressed[0]
    return equals("touches", float(times) if np.isfinite(force).all() else np.nan, 1)


def no_pull(result: Result, pair: str, normal: np.ndarray) -> Check:
    """Check that the force on the first body of a pair, along the normal out of the second, never pulls."""
    force = result.pair_force[pair] @ normal
    return at_most(
        "pull / largest push", -np.min([0.0, *force]) / max(np.abs(force).max(), np.finfo(float).tiny), 1e-12
    )


def pair_overlap(result: Result, size: float, bound: float) -> Check:
    """Check the deepest overlap of bodies that touch each other, relative to the size of a face [m]."""
    gaps = [column for name, column in result.history.items() if name.startswith("pair_gap_min:")]
    return at_most("overlap / face", np.max([0.0, *(-np.min(column) for column in gaps)]) / size, bound)


def mean_time(time: np.ndarray, impulse: np.ndarray) -> float:
    """Return the mean time [s] of a force with such a running impulse [N s] in rows: first moment over integral."""
    given = np.diff(impulse)
    with np.errstate(invalid="ignore"):
        return float(np.divide(given @ (time[1:] + time[:-1]) / 2.0, given.sum()))


def no_overlap(result: Result) -> Check:
    """Check the deepest overlap relative to the size of the body, for the exact constraint."""
    size = max(float(np.ptp(body.mesh.nodes, axis=0).max()) for body in result.scene.bodies)
    return at_most("overlap / size", abs(np.max([0.0, -np.min(result.history["gap_min"])])) / size, 1e-12)


def energy(result: Result, bound: float) -> Check:
    """Check the largest energy error of the run relative to the largest kinetic + elastic energy."""
    return at_most("energy error", float(np.abs(result.history["energy_error"]).max()), bound)


def no_gain(result: Result, bound: float) -> Check:
    """Check the largest rise of the energy above its start, relative to the largest kinetic + elastic energy."""
    history = result.history
    largest = float((history["kinetic"] + history["elastic"]).max())
    gain = float((history["energy"] - history["energy"][0]).max())
    return at_most("energy gained", gain / max(largest, 1e-300), bound)


def mass(result: Result) -> float:
    """Return the total mass of the bodies [kg], from their reference volumes."""
    return sum(body.mass for body in result.scene.bodies)


def volume(mesh: Mesh) -> float:
    """Return the volume of a mesh [m^3] in the reference state."""
    return float(mesh.cell_volumes().sum())
