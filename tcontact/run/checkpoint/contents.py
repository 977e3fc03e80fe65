"""Collect the state of a run: every array and number that its objects hold, by the path of attributes to it.

The walk (device/leaves.py) starts at the `Run`. A new term or scheme needs no code for checkpoints, as long as its
attributes hold all that it keeps from step to step: arrays of the device or of NumPy, numbers, text, lists of these. An
object that keeps something else, or grows, has `checkpoint() -> dict` of arrays and such values, and `restore(dict)`.
Arrays are saved if they differ from those of a run that was just made.
"""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np

from ...device import arrays
from ...device.leaves import PLAIN, Saved, leaves

Prints = dict[str, tuple[str, int]]  # array by path: first path to the same array, checksum


def collect(run: Any, new: Prints) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Return arrays and plain values of a run by path, without arrays that are still as in `new`."""
    found: dict[str, np.ndarray] = {}
    values: dict[str, Any] = {}
    firsts: dict[int, str] = {}
    for leaf in leaves(run):
        if isinstance(leaf.value, Saved):
            for name, value in leaf.value.owner.checkpoint().items():
                target = values if isinstance(value, (*PLAIN, list)) else found
                target[f"{leaf.path}/{name}"] = np.asarray(value) if target is found else value
        elif leaf.is_array:
            first = firsts.setdefault(id(leaf.value), leaf.path)
            known, check = new.get(leaf.path, ("", 0))
            if first == leaf.path or first != known:
                content = arrays.get(leaf.value)
                if first != known or check != _check(content):
                    found[leaf.path] = content
        elif isinstance(leaf.value, np.generic):
            found[leaf.path] = np.asarray(leaf.value)
        else:
            values[leaf.path] = list(leaf.value) if isinstance(leaf.value, tuple) else leaf.value
    return found, values


def prints(run: Any) -> Prints:
    """Return the fingerprints of all arrays of a new run."""
    firsts: dict[int, str] = {}
    return {
        leaf.path: (firsts.setdefault(id(leaf.value), leaf.path), _check(arrays.get(leaf.value)))
        for leaf in leaves(run)
        if leaf.is_array
    }


def shapes(run: Any) -> dict[str, tuple[int, ...] | None]:
    """Return the paths of a run that `restore` knows, with the shapes of arrays; None for other values."""
    return {leaf.path: tuple(leaf.value.shape) if leaf.is_array else None for leaf in leaves(run)}


def differs(stored: dict[str, list], new: Prints, found: dict[str, np.ndarray]) -> list[str]:
    """Return the paths of arrays left out of a checkpoint that differ from those of the saved run."""
    return [path for path, known in stored.items() if path not in found and list(new.get(path, ())) != known]


def restore(run: Any, found: dict[str, np.ndarray], values: dict[str, Any]) -> None:
    """Restore the state that `collect` returned to a new run; what it does not name stays as it is in a new run.

    Raises `KeyError` for a path that the run does not have: every object makes all attributes that it will have when it
    is made itself.
    """
    places = {leaf.path: leaf for leaf in leaves(run)}
    own: dict[str, dict[str, Any]] = {path: {} for path, leaf in places.items() if isinstance(leaf.value, Saved)}
    for path, value in [*values.items(), *found.items()]:
        before, slash, name = path.rpartition("/")
        if path not in places and before not in own:
            raise KeyError(f"it holds {path}, which a run of this version does not have")
        if slash:
            own[before][name] = value
            continue
        leaf = places[path]
        if isinstance(value, np.ndarray):
            leaf.put(value[()] if value.ndim == 0 else np.array(value))
        elif isinstance(leaf.value, tuple):
            if list(leaf.value) != value:
                leaf.put(tuple(value))
        else:
            leaf.put(value)
    for path, saved in own.items():
        places[path].value.owner.restore(saved)


def _check(content: np.ndarray) -> int:
    return zlib.crc32(np.ascontiguousarray(content).view(np.uint8).data, content.size)
