"""Supports: held or driven displacement components of a set of nodes, by constants or by functions of time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..base import validate
from ..base.errors import FunctionError, InputError
from .time_functions import TimeFunction

SAMPLES = 257  # samples of a function of time for the largest speed


class Prescribed(NamedTuple):
    """The motion that a support prescribes along one axis.

    key: equal for equal motions; axis: its number; number: that of the axis in the support; speed [m/s]: at t = 0 (0
    for a displacement, whose rate the run computes); displacement [m]: at t = 0, None where the support gives none.
    """

    key: tuple[Any, ...]
    axis: int
    number: int
    speed: float
    displacement: float | None


@dataclass(frozen=True)
class Support:
    """Held or driven displacement components of a named set.

    set: name of a node or face set of the mesh; axes: letters out of "xyz"; velocity [m/s]: one number for all named
    axes or one per axis (0 = held), or a callable(t) that returns these at the time t [s]; displacement [m]: the same
    for the displacement from the positions in the mesh, instead of a velocity: nodes start with its value at t = 0, and
    their positions are exact at every step. Raises `InputError`, also where a callable does not return finite numbers
    at t = 0; where it fails later, the run stops with the reason "function-failed".
    """

    set: str
    axes: str
    velocity: Any = 0.0
    displacement: Any = None

    def __post_init__(self) -> None:
        if not isinstance(self.set, str):
            raise InputError("Support.set", self.set, "give the name of a node or face set")
        known = isinstance(self.axes, str) and self.axes and set(self.axes) <= set("xyz")
        if not known or len(set(self.axes)) != len(self.axes):
            raise InputError("Support.axes", self.axes, "give distinct letters out of 'xyz', for example 'z' or 'xy'")
        self._check("Support.velocity", self.velocity)
        if self.displacement is not None:
            self._check("Support.displacement", self.displacement)
            if callable(self.velocity) or np.any(np.asarray(self.velocity) != 0.0):
                remedy = "a displacement is given too; leave one of the two out"
                raise InputError("Support.velocity", self.velocity, remedy)
        if self.varies:
            self.function().at(np.zeros(1))

    def _check(self, field: str, value: Any) -> None:
        if callable(value):
            return
        if not validate.shape_of(field, value, "give one number, one for each axis, or a function of time"):
            validate.keep(self, field)
        else:
            found = tuple(validate.floats(field, value, (len(self.axes),)).tolist())
            object.__setattr__(self, field.rpartition(".")[2], found)

    @property
    def varies(self) -> bool:
        """Return whether a function of time drives it."""
        return callable(self.velocity) or callable(self.displacement)

    @property
    def kind(self) -> str:
        """Return what it prescribes, "velocity" or "displacement"."""
        return "velocity" if self.displacement is None else "displacement"

    def function(self) -> TimeFunction:
        """Return its velocity or displacement along each axis as a function of time."""
        value = getattr(self, self.kind)
        return TimeFunction(f"Support.{self.kind} of {self.set!r}", value, len(self.axes), uniform=True)

    def motions(self) -> Iterator[Prescribed]:
        """Yield the motion along each axis. Raises `FunctionError`."""
        function = self.function()
        start = function.at(np.zeros(1))[0]
        for number, (letter, now) in enumerate(zip(self.axes, start.tolist(), strict=True)):
            key: tuple[Any, ...] = (self.kind, now)
            if self.varies:
                part = () if function.single else (number, len(self.axes))
                key = (self.kind, "function", id(function.value), *part)
            place = now if self.kind == "displacement" else None
            yield Prescribed(key, "xyz".index(letter), number, 0.0 if place is not None else now, place)

    def largest_speed(self, duration: float) -> float:
        """Return the largest speed [m/s] that its function prescribes in the duration, up to where the function fails.

        It is 0 for constants.
        """
        if not self.varies or duration <= 0.0:
            return 0.0
        function, values = self.function(), []
        try:
            for time in np.linspace(0.0, float(duration), SAMPLES):
                values.append(function.at(np.array([time]))[0])
        except FunctionError:  # the run stops there
            pass
        rates = np.array(values)
        if self.kind == "displacement":
            rates = np.diff(rates, axis=0) * (SAMPLES - 1) / duration
        return float(np.linalg.norm(rates, axis=1).max(initial=0.0))
