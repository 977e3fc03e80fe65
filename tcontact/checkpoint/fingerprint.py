"""The physics of a scene in plain words, to tell whether another scene is the same and what differs."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from ..errors import InputError
from ..mesh import Mesh
from ..scene import Body, Scene

SHORT = 12  # numbers of an array that are written out


def fingerprint(scene: Scene, scheme: Any) -> dict[str, str]:
    """Every property that the motion depends on, by its name: numbers with all digits, arrays by their contents.

    A run that started from the end of another one (`initial`) is known by the state in its checkpoint alone.
    """
    found: dict[str, str] = {}
    for index, body in enumerate(scene.bodies):
        _add(found, f"bodies[{index}]", _body(body))
    for index, obstacle in enumerate(scene.obstacles):
        place = f"obstacles[{index}]"
        _add(found, f"{place}.shape", obstacle.shape)
        for name in ("reference", "frame", "parameters", "grid", "name"):
            _add(found, f"{place}.{name}", getattr(obstacle, name))
        for name in ("velocity", "angular_velocity"):
            _add(found, f"{place}.{name}", _rate(getattr(obstacle, name), scene.duration))
    for field in fields(scene):
        if field.name not in ("bodies", "obstacles"):
            _add(found, field.name, getattr(scene, field.name))
    _add(found, "scheme", scheme)
    return found


def compare(stored: Mapping[str, str], present: Mapping[str, str]) -> None:
    """Raise `InputError` that names what differs from the run that left the checkpoint."""
    names = [name for name in [*stored, *(set(present) - set(stored))] if stored.get(name) != present.get(name)]
    if names:
        first = names[0]
        others = f" (and {', '.join(names[1:4])}{', ...' if len(names) > 4 else ''})" if len(names) > 1 else ""
        was = stored.get(first, "not there")
        remedy = f"the run that is to go on had {was}{others}; resume it as it was, or start a new run elsewhere"
        raise InputError(first, present.get(first, "not there"), remedy)


def _body(body: Body) -> dict[str, Any]:
    found = {field.name: getattr(body, field.name) for field in fields(body)}
    return found | {"velocity": body.initial_velocity, "displacement": body.initial_displacement}


def _rate(rate: Any, duration: float) -> Any:
    """A function of time by values of it."""
    if not callable(rate):
        return rate
    return {"function": np.array([np.asarray(rate(duration * part), float) for part in (0.0, 0.1234567, 0.5, 0.987)])}


def _add(found: dict[str, str], name: str, value: Any) -> None:
    if isinstance(value, Mesh):
        value = {"kind": value.kind, "nodes": value.nodes, "cells": value.cells}
    if isinstance(value, Mapping):
        for key, item in value.items():
            _add(found, f"{name}.{key}", item)
    elif is_dataclass(value) and not isinstance(value, type):
        found[name] = type(value).__name__
        for field in fields(value):
            _add(found, f"{name}.{field.name}", getattr(value, field.name))
    elif isinstance(value, np.ndarray):
        array = np.ascontiguousarray(value)
        if array.size <= SHORT:
            found[name] = str(array.tolist())
        else:
            found[name] = f"{array.dtype.name} {array.shape} {hashlib.sha256(array.tobytes()).hexdigest()[:16]}"
    elif isinstance(value, (list, tuple)):
        if all(isinstance(item, (bool, int, float, str, np.generic)) for item in value):
            found[name] = str([item.item() if isinstance(item, np.generic) else item for item in value])
        else:
            for index, item in enumerate(value):
                _add(found, f"{name}[{index}]", item)
    elif isinstance(value, np.generic):
        found[name] = repr(value.item())
    elif callable(value):
        found[name] = f"function {getattr(value, '__qualname__', type(value).__name__)}"
    else:
        found[name] = str(value) if hasattr(value, "value") else repr(value)
