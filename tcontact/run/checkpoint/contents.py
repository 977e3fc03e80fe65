"""Collect the state of a run: every array and number that its objects hold, by the path of attributes to it.

The walk starts at the `Run` and enters every object of this package, lists, tuples and dictionaries; it leaves out
immutable ones: frozen dataclasses (scene, plan, scheme), kernels, modules. A new term or scheme needs no code for
checkpoints, as long as its attributes hold all that it keeps from step to step: arrays of the device or of NumPy,
numbers, text, lists of these. An object that keeps something else, or grows, has `checkpoint() -> dict` of arrays
and such values, and `restore(dict)`. Arrays are saved if they differ from those of a run that was just made.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import is_dataclass
from typing import Any

import numpy as np

from ...device import arrays
from ...device.launch import Prepared

# written in every step before it is read
SCRATCH = ("trial", "answer", "_scratch", "raw", "_raw", "_parts", "corner_forces", "partial_sums", "ledger", "_kept",
           "_builds", "lists", "_of_lists", "_bundles")  # fmt: skip
PLAIN = (bool, int, float, str, type(None))

Prints = dict[str, tuple[str, int]]  # array by path: first path to the same array, checksum


class Leaf:
    """A value of a run with its path, its holder and the key there."""

    def __init__(self, path: str, owner: Any, key: Any, value: Any) -> None:
        self.path, self.owner, self.key, self.value = path, owner, key, value

    @property
    def is_array(self) -> bool:
        """Return whether the value is an array, of NumPy or of the device."""
        return isinstance(self.value, np.ndarray) or hasattr(self.value, "from_numpy")

    def put(self, value: Any) -> None:
        """Set the value; arrays in place, as kernels hold references to them."""
        if self.is_array and isinstance(value, np.ndarray) and self._fits(value):
            if isinstance(self.value, np.ndarray):
                self.value[...] = value
            else:
                self.value.from_numpy(value)
        elif isinstance(self.owner, (list, dict)):
            self.owner[self.key] = value
        elif not isinstance(self.owner, tuple):
            setattr(self.owner, self.key, value)
        else:
            raise ValueError(f"{self.path} has another size")

    def _fits(self, value: np.ndarray) -> bool:
        return tuple(self.value.shape) == value.shape and arrays.get(self.value).dtype == value.dtype


def collect(run: Any, new: Prints) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Return arrays and plain values of a run by path, without arrays that are still as in `new`."""
    found: dict[str, np.ndarray] = {}
    values: dict[str, Any] = {}
    firsts: dict[int, str] = {}
    for leaf in _leaves(run, set()):
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
        for leaf in _leaves(run, set())
        if leaf.is_array
    }


def shapes(run: Any) -> dict[str, tuple[int, ...] | None]:
    """Return the paths of a run that `restore` knows, with the shapes of arrays; None for other values."""
    return {leaf.path: tuple(leaf.value.shape) if leaf.is_array else None for leaf in _leaves(run, set())}


def differs(stored: dict[str, list], new: Prints, found: dict[str, np.ndarray]) -> list[str]:
    """Return the paths of arrays left out of a checkpoint that differ from those of the saved run."""
    return [path for path, known in stored.items() if path not in found and list(new.get(path, ())) != known]


def restore(run: Any, found: dict[str, np.ndarray], values: dict[str, Any]) -> None:
    """Restore the state that `collect` returned to a new run. Raises `KeyError` for a path that it does not have."""
    leaves = list(_leaves(run, set()))
    places = {leaf.path: leaf for leaf in leaves}
    own: dict[str, dict[str, Any]] = {leaf.path: {} for leaf in leaves if isinstance(leaf.value, Saved)}
    for path, value in [*values.items(), *found.items()]:
        before, slash, name = path.rpartition("/")
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


class Saved:
    """Marks an object that saves itself."""

    def __init__(self, owner: Any) -> None:
        self.owner = owner


def _leaves(thing: Any, seen: set[int], path: str = "", owner: Any = None, key: Any = None) -> Iterator[Leaf]:
    plain = isinstance(thing, (list, tuple)) and all(isinstance(item, PLAIN) for item in thing)
    if plain or isinstance(thing, (*PLAIN, np.generic)):
        if not isinstance(owner, tuple):  # immutable
            yield Leaf(path, owner, key, thing)
    elif id(thing) in seen or isinstance(thing, (type, Prepared)):
        return
    elif isinstance(thing, np.ndarray) or type(thing).__module__.endswith(".lang._ndarray"):
        yield Leaf(path, owner, key, thing)
    elif isinstance(thing, (list, tuple)):
        seen.add(id(thing))
        for index, item in enumerate(thing):
            yield from _leaves(item, seen, f"{path}.{index}", thing, index)
    elif isinstance(thing, dict):
        seen.add(id(thing))
        for name, item in thing.items():
            if isinstance(name, str):
                yield from _leaves(item, seen, f"{path}.{name}", thing, name)
    elif type(thing).__module__.startswith("tcontact") and hasattr(thing, "__dict__"):
        seen.add(id(thing))
        if hasattr(thing, "checkpoint"):
            yield Leaf(path, owner, key, Saved(thing))
        elif not (is_dataclass(thing) and _frozen(thing)):
            for name, item in list(vars(thing).items()):
                if name not in SCRATCH:
                    yield from _leaves(item, seen, f"{path}.{name}" if path else name, thing, name)


def _frozen(thing: Any) -> bool:
    return bool(type(thing).__dataclass_params__.frozen)


def _check(content: np.ndarray) -> int:
    return zlib.crc32(np.ascontiguousarray(content).view(np.uint8).data, content.size)
