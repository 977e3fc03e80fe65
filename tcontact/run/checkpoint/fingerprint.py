"""Make a fingerprint of a scene in words, which shows whether another scene is the same and what differs.

It holds all fields of all dataclasses of the scene and the scheme, so that new options are included. A function counts
by its values: one of the nodes by those at the nodes, one of time by `SAMPLES` values, evenly spaced over the duration.
A function of time that differs over less than `duration / SAMPLES` may go unnoticed here; its values at the times of
the run are compared besides (`obstacles.call_record`).
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...mesh.mesh import Mesh
from ...scene.body import Body
from ...scene.loads import COMPONENTS, Load
from ...scene.obstacles import Obstacle, Sdf
from ...scene.own_laws import OwnMaterial
from ...scene.rigid import RigidPart
from ...scene.scene import Scene
from ...scene.supports import Support

SHORT = 12  # longest array that is written out
AT_ONCE = 1 << 22  # bytes of an array that are read at once
IN_PORTIONS = ("nodes", "cells")  # arrays of a mesh
SAMPLES = 4096  # values of a function of time
BITS, DIGITS = 30, 9  # binary digits of arrays and decimal ones of numbers where they are rounded
# objects with fields that may be functions of time, and these fields
FUNCTIONS_OF_TIME = (Obstacle, RigidPart, Support, Load)
FIELDS = ("velocity", "angular_velocity", "displacement", *COMPONENTS)


@dataclass(frozen=True)
class Reading:
    """How values become text: times [s] at which functions of time are read; rounded: without their last digits."""

    times: np.ndarray
    rounded: bool


def fingerprint(scene: Scene, scheme: Any, samples: int = SAMPLES, rounded: bool = False) -> dict[str, str]:
    """Return every property that the motion depends on by name: numbers with all digits, arrays by their contents.

    samples: number of values of a function of time; rounded: leave the last digits away, in which processors differ.
    The start of a run from the end of another one (`initial`) is in its checkpoint only.
    Raises `InputError` for a function of time that gives two values at one time: no run with it can be repeated.
    """
    found: dict[str, str] = {}
    reading = Reading(scene.duration * (np.arange(samples) + 0.381966) / samples, rounded)
    for field in (field for field in fields(scene) if field.init):
        value = getattr(scene, field.name)
        if field.name == "gravity" and callable(value):
            value = {"function": _samples(value, "gravity", reading.times)}
        _add(found, field.name, value, reading)
    _add(found, "scheme", scheme, reading)
    return found


def differences(stored: Mapping[str, str], present: Mapping[str, str]) -> list[str]:
    """Return the names of the properties in which two fingerprints differ."""
    names = [*stored, *(name for name in present if name not in stored)]
    return [name for name in names if not _equal(stored.get(name), present.get(name))]


def _equal(first: str | None, second: str | None) -> bool:
    """Return whether two texts are equal, or tell the same numbers: 1000 and 1000.0 are one."""
    if first == second or first is None or second is None:
        return first == second
    try:
        return bool(ast.literal_eval(first) == ast.literal_eval(second))
    except (ValueError, SyntaxError, RecursionError, MemoryError):  # no numbers
        return False


def compare(stored: Mapping[str, str], present: Mapping[str, str]) -> None:
    """Raise `InputError` that names what differs from the run that left the checkpoint."""
    names = differences(stored, present)
    if names:
        first = names[0]
        others = f" (and {', '.join(names[1:4])}{', ...' if len(names) > 4 else ''})" if len(names) > 1 else ""
        was = stored.get(first, "not there")
        remedy = f"the run that is to go on had {was}{others}; resume it as it was, or start a new run elsewhere"
        raise InputError(first, present.get(first, "not there"), remedy)


def _properties(thing: Any, place: str, times: np.ndarray) -> dict[str, Any]:
    """Return the fields of a dataclass, functions by their values."""
    if isinstance(thing, Mesh):
        own = {field.name: getattr(thing, field.name) for field in fields(thing) if field.name not in IN_PORTIONS}
        return {name: Portions(thing, name) for name in IN_PORTIONS} | own
    found = {field.name: getattr(thing, field.name) for field in fields(thing)}
    if isinstance(thing, Body):
        found |= {"velocity": thing.initial_velocity, "displacement": thing.initial_displacement}
        found["loads"] = [load.by_time(thing.mesh, thing.images) for load in thing.loads]
    if isinstance(thing, OwnMaterial):
        found["energy"] = thing.formula
    if isinstance(thing, Sdf) and (callable(thing.distance) or callable(thing.gradient)):
        found |= {"distance": thing.grid[..., 0], "gradient": thing.grid[..., 1:]}
    if isinstance(thing, FUNCTIONS_OF_TIME):
        for name in FIELDS:
            if callable(found.get(name)):
                found[name] = {"function": _samples(found[name], f"{place}.{name}", times)}
    return found


def _samples(function: Callable[[float], Any], name: str, times: np.ndarray) -> np.ndarray:
    """Return values [n, k] at the times [n]; NaN where the function fails, which ends a run at that time."""

    def value(time: float) -> np.ndarray:
        try:
            given = np.array(function(time), dtype=np.complex128).ravel()
        except Exception:  # the run stops there with a message
            return np.full(3, np.nan)
        return given.view(np.float64) if given.imag.any() else given.real

    rows = [value(float(time)) for time in times]
    for number in (0, len(times) // 2, len(times) - 1):
        if not np.array_equal(rows[number], again := value(float(times[number])), equal_nan=True):
            remedy = (
                f"it gave {rows[number].tolist()} and then {again.tolist()} at t = {times[number]:.6g} s, and no run"
                " with it can be resumed, or shared among processes; make it a function of the time alone, or run one"
                " process without checkpoints"
            )
            raise InputError(name, function, remedy)
    return np.concatenate(rows)


@dataclass(frozen=True)
class Portions:
    """An array of a mesh by its name, read in portions, so that it need not be there as a whole."""

    mesh: Mesh
    name: str


def _text(portions: Iterable[np.ndarray], shape: tuple[int, ...] | None, unit: int | None) -> str:
    """Return the text of an array, given in portions of its rows; shape: of the array, None: from the portions.

    unit: power of 2 of whose multiples there are to be, None = the numbers as they are.
    """
    total, rows, short = hashlib.sha256(), 0, list[np.ndarray]()
    for portion in portions:
        part = np.ascontiguousarray(portion if unit is None else _rounded(portion, unit))
        total.update(part.data)
        rows += len(part)
        if sum(one.size for one in short) <= SHORT:
            short.append(part)
    shape = (rows, *part.shape[1:]) if shape is None else shape
    if np.prod(shape) <= SHORT:
        return str(np.concatenate(short).reshape(shape).tolist())
    return f"{part.dtype.name} {shape} {total.hexdigest()[:16]}"


def _unit(portions: Iterable[np.ndarray], reading: Reading) -> int | None:
    """Return the power of 2 to whose multiples an array is rounded: its largest value has `BITS` digits. None: to none.

    It is that of the whole array, however that comes in portions.
    """
    if not reading.rounded:
        return None
    largest = 0.0
    for portion in portions:
        if portion.dtype.kind != "f":
            return None
        largest = max(largest, float(np.abs(portion[np.isfinite(portion)]).max(initial=0.0)))
    return int(np.frexp(largest)[1]) - BITS


def _rounded(array: np.ndarray, unit: int) -> np.ndarray:
    """Return an array rounded to multiples of a power of 2, without -0."""
    return np.asarray(np.ldexp(np.rint(np.ldexp(array, -unit)), unit) + 0.0)


def _add(found: dict[str, str], name: str, value: Any, reading: Reading) -> None:
    """Add the text of a value to `found`, of a compound value by parts."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            _add(found, f"{name}.{key}", item, reading)
    elif isinstance(value, Portions):
        found[name] = _text(value.mesh.portions(value.name), None, _unit(value.mesh.portions(value.name), reading))
    elif is_dataclass(value) and not isinstance(value, type):
        found[name] = Mesh.__name__ if isinstance(value, Mesh) else type(value).__name__  # a box is a mesh
        for key, item in _properties(value, name, reading.times).items():
            _add(found, f"{name}.{key}", item, reading)
    elif isinstance(value, np.ndarray):
        portions = np.array_split(value, max(1, value.nbytes // AT_ONCE)) if value.ndim else [value]
        found[name] = _text(portions, value.shape or (1,), _unit(portions, reading))
    elif isinstance(value, (list, tuple)):
        if all(isinstance(item, (bool, int, float, str, np.generic)) for item in value):
            plain = (item.item() if isinstance(item, np.generic) else item for item in value)
            found[name] = str([_number(item, reading) for item in plain])
        else:
            for index, item in enumerate(value):
                _add(found, f"{name}[{index}]", item, reading)
    elif isinstance(value, np.generic):
        found[name] = repr(_number(value.item(), reading))
    elif callable(value):
        found[name] = f"function {getattr(value, '__qualname__', type(value).__name__)}"
    else:
        found[name] = str(value) if hasattr(value, "value") else repr(_number(value, reading))


def _number(value: Any, reading: Reading) -> Any:
    """Return a number as it is to be read, anything else as it is."""
    return float(f"{value:.{DIGITS}g}") if reading.rounded and isinstance(value, float) else value
