"""Generation of kernel signatures from bundles, NamedTuples whose annotations say what each field is (arguments.py).

A Taichi kernel must list its arrays one by one. `kernel_of` writes that list: one argument for every array that a scene
has, in the order of the bundles, and a body that puts them back into bundles and calls a `ti.func`. `arguments`
flattens the bundles of the host in the same order. A field that is None is no argument; a field that is no array is a
compile-time option. Arrays that stand in joint ones (joint_arrays.py) share two arguments.
"""

import linecache
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ..engine import ti
from .arguments import ARRAY, INDEX, Array, Index, Shared
from .joint_arrays import WHOLES, JointArray, Place

MAXIMUM_ARGUMENTS = 64  # arguments of a kernel in Taichi, arrays and numbers


class Signature(NamedTuple):
    """Arguments of a kernel, hashable: name and class of every bundle, and the fields that it has.

    joint: the fields that are parts of joint arrays, by their labels.
    """

    bundles: tuple[tuple[str, type, tuple[str, ...]], ...]
    joint: tuple[tuple[str, Place], ...] = ()

    def arguments(self) -> dict[str, type]:
        """Return the array arguments in order, with their annotations."""
        found: dict[str, type] = {}
        joint = dict(self.joint)
        for name, bundle, present in self.bundles:
            for field in present:
                if not is_array(bundle, field):
                    continue
                text = label(name, bundle, field)
                if text in joint:
                    found |= {need: Index if need == WHOLES else Array for need in joint[text].needs}
                else:
                    found.setdefault(text, bundle.__annotations__[field])
        return found


def is_array(bundle: type, field: str) -> bool:
    """Return whether a field of a bundle is an array."""
    annotation = bundle.__annotations__[field]
    return isinstance(annotation, type) and issubclass(annotation, (Array, Index))


def label(name: str, bundle: type, field: str) -> str:
    """Return the argument name of a field; shared arrays have one name for all bundles."""
    return field if bundle.__annotations__[field] is Shared else f"{name}_{field}"


def signature_of(bundles: dict[str, Any]) -> Signature:
    """Return the signature of bundles that hold arrays of the host, without the fields that are None."""
    present = {
        name: tuple(field for field in bundle._fields if getattr(bundle, field) is not None)
        for name, bundle in bundles.items()
    }
    kinds = tuple((name, type(bundle), present[name]) for name, bundle in bundles.items())
    places = {text: place_of(array) for text, array in labelled(bundles)}
    return Signature(kinds, tuple((text, place) for text, place in places.items() if place is not None))


def labelled(bundles: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Return the label of every array of the bundles and the array."""
    for name, bundle in bundles.items():
        for field in bundle._fields:
            if is_array(type(bundle), field) and getattr(bundle, field) is not None:
                yield label(name, type(bundle), field), getattr(bundle, field)


def place_of(array: Any) -> Place | None:
    """Return where an array of the host stands in the joint ones; None for an array that stands alone."""
    return Place(array.number, array.type is np.int32) if hasattr(array, "joint") else None


def arguments(bundles: dict[str, Any]) -> tuple[Any, ...]:
    """Return the arrays of the bundles in the order of their signature.

    Raises `TypeError` for parts of different joint arrays, of which a kernel takes one pair.
    """
    found: dict[str, Any] = {}
    for text, array in labelled(bundles):
        place = place_of(array)
        if place is None:
            found.setdefault(text, array)
            continue
        for need in place.needs:
            whole = array.joint.wholes if need == WHOLES else array.joint.reals
            if found.setdefault(need, whole) is not whole:
                raise TypeError(f"{text} stands in another joint array than the arguments before it")
    return tuple(found.values())


def kernel_of(
    function, signature: Signature, numbers: tuple[str, ...] = (), reals: tuple[str, ...] = (), **options
):  # fmt: skip
    """Make a `ti.kernel` that calls function(*numbers, *reals, *bundles).

    numbers, reals: names of arguments i32 and f64, which come first; options: values of the fields that are no arrays.
    Raises `TypeError` for more arguments than Taichi takes, which it would refuse only when the kernel is called.
    """
    arrays = signature.arguments()
    kinds = [f"{name}: {'INDEX' if issubclass(kind, Index) else 'ARRAY'}" for name, kind in arrays.items()]
    scope: dict[str, Any] = {"ti": ti, "function": function, "ARRAY": ARRAY, "INDEX": INDEX, "JointArray": JointArray}
    built, joint = [], dict(signature.joint)
    for name, bundle, _present in signature.bundles:
        parts = []
        for field in bundle._fields:
            value = label(name, bundle, field) if is_array(bundle, field) else f"option_{field}"
            given = value in arrays or value.startswith("option_")
            parts.append(f"{field}={joint[value].source if value in joint else value if given else None}")
        scope[bundle.__name__] = bundle
        built.append(f"ti.static({bundle.__name__}({', '.join(parts)}))")
    named = {field for _name, bundle, _present in signature.bundles for field in bundle._fields}
    scope |= {f"option_{field}": options.get(field) for field in named}
    heads = [*(f"{number}: ti.i32" for number in numbers), *(f"{real}: ti.f64" for real in reals), *kinds]
    title = function.__name__
    if len(heads) > MAXIMUM_ARGUMENTS:
        shares = ", ".join(f"{name} {len(present)}" for name, _bundle, present in signature.bundles)
        raise TypeError(
            f"kernel {title} has {len(heads)} arguments ({shares}), Taichi takes {MAXIMUM_ARGUMENTS}: join some arrays"
        )
    source = f"def {title}({', '.join(heads)}):\n    function({', '.join([*numbers, *reals, *built])})\n"
    file = f"<kernel {title} {id(function)}>"
    linecache.cache[file] = (len(source), None, source.splitlines(keepends=True), file)
    exec(compile(source, file, "exec"), scope)
    return ti.kernel(scope[title])
