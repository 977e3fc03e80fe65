"""Walk from an object of this package to every array and number that it holds, by the path of attributes to it.

The walk enters every object of this package, lists, tuples and dictionaries; it leaves out immutable ones: frozen
dataclasses (scene, plan, scheme), kernels, modules. An object that has `checkpoint()` is one leaf.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import is_dataclass
from typing import Any

import numpy as np

from . import arrays
from .joint import Joint, Part, Whole
from .launch import Prepared

# written in every step before it is read
SCRATCH = ("trial", "answer", "_scratch", "raw", "_raw", "_parts", "corner_forces", "partial_sums", "ledger", "_kept",
           "_builds", "_table", "_next_looks", "lists", "_of_lists", "_bundles")  # fmt: skip
PLAIN = (bool, int, float, str, type(None))


class Leaf:
    """A value of a run with its path, its holder and the key there."""

    def __init__(self, path: str, owner: Any, key: Any, value: Any) -> None:
        self.path, self.owner, self.key, self.value = path, owner, key, value

    @property
    def present(self) -> Any:
        """Return the value that stands there now."""
        return self.owner[self.key] if isinstance(self.owner, (list, dict, tuple)) else getattr(self.owner, self.key)

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


class Saved:
    """Marks an object that saves itself."""

    def __init__(self, owner: Any) -> None:
        self.owner = owner


def leaves(thing: Any) -> Iterator[Leaf]:
    """Return the leaves of an object; each is reached by one path only, but for arrays."""
    return _leaves(thing, set())


def _leaves(thing: Any, seen: set[int], path: str = "", owner: Any = None, key: Any = None) -> Iterator[Leaf]:
    plain = isinstance(thing, (list, tuple)) and all(isinstance(item, PLAIN) for item in thing)
    if plain or isinstance(thing, (*PLAIN, np.generic)):
        if not isinstance(owner, tuple):  # immutable
            yield Leaf(path, owner, key, thing)
    elif id(thing) in seen or isinstance(thing, (type, Prepared, Joint, Whole)):
        return
    elif isinstance(thing, (np.ndarray, Part)) or type(thing).__module__.endswith(".lang._ndarray"):
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
