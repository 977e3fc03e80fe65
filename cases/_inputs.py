"""Refusal of what a case cannot compute with, in the words of its own parameters.

`checked` stands before `scene` or `solve` of every case. It compares what is given with the annotations: numbers are
numbers, of a size that products and powers of them leave finite, whole numbers are whole, words are known ones. What
goes wrong further inside, in a mesh, a material or a formula, is said of the parameter that was given.
"""

from __future__ import annotations

import functools
import math
import types
import typing
from collections.abc import Callable
from inspect import signature
from typing import Any, Literal, TypeVar

import numpy as np

from tcontact.base import validate
from tcontact.base.errors import InputError
from tcontact.scene.materials import LAWS

LOW, HIGH = 1e-60, 1e60  # sizes of a number that is not 0, as of meshes
LARGEST = 10**9  # of whole numbers
WORD_LAWS = tuple(LAWS)  # those of the package; laws of the user are registered later
Case = TypeVar("Case", bound=Callable[..., Any])


def checked(build: Case) -> Case:
    """Return a `scene` or `solve` that raises `InputError` of the parameter at fault."""
    defaults = {name: parameter.default for name, parameter in signature(build).parameters.items()}

    @functools.wraps(build)
    def built(**given: Any) -> Any:
        hints = typing.get_type_hints(build)
        known = {name: _value(name, value, hints[name]) if name in hints else value for name, value in given.items()}
        changed = {name: value for name, value in known.items() if value != defaults.get(name)}
        try:
            with np.errstate(over="raise", divide="raise", invalid="raise"):
                return build(**known)
        except InputError as error:
            raise _named(error, changed, defaults) from error
        except (ArithmeticError, IndexError, ValueError) as error:
            if not changed:
                raise
            name = _farthest(changed, defaults)
            remedy = f"the case cannot compute with that ({error}): give values nearer to the defaults"
            raise InputError(name, changed[name], f"{remedy}, here {defaults[name]!r}") from error

    built.__kwdefaults__ = defaults
    return typing.cast(Case, built)


def _value(name: str, value: Any, hint: Any) -> Any:
    """Return a value that suits an annotation: a number as a float. Raises `InputError`."""
    union = typing.get_origin(hint) in (typing.Union, types.UnionType)
    kinds = typing.get_args(hint) if union else (hint,)
    if value is None and type(None) in kinds:
        return None
    words = [word for kind in kinds if typing.get_origin(kind) is Literal for word in typing.get_args(kind)]
    if words:
        return validate.choice(name, value, LAWS if tuple(words) == WORD_LAWS else words)
    if bool in kinds:
        return validate.flag(name, value)
    if int in kinds:
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
            raise InputError(name, value, "give a whole number")
        if abs(value) > LARGEST:
            raise InputError(name, value, f"give a whole number of at most {LARGEST:g}")
    elif float in kinds:
        value = validate.number(name, value)
        if value != 0.0 and not LOW <= abs(value) <= HIGH:
            raise InputError(name, value, f"give values nearer to the defaults, of a size from {LOW:g} to {HIGH:g}")
    elif str in kinds and not isinstance(value, str):
        raise InputError(name, value, "give a text")
    return value


def _named(error: InputError, changed: dict[str, Any], defaults: dict[str, Any]) -> InputError:
    """Return an error of the parameter that was given, in the place of one of something that was made of it."""
    if not changed:
        return error
    same = [name for name, value in changed.items() if type(value) is type(error.value) and value == error.value]
    own, name = error.field.rpartition(".")[2], _farthest(changed, defaults)
    if own == name or own in same:
        return error
    if len(same) == 1:
        return InputError(same[0], changed[same[0]], error.remedy)
    return InputError(name, changed[name], f"{error}; the default is {defaults[name]!r}")


def _farthest(changed: dict[str, Any], defaults: dict[str, Any]) -> str:
    """Return the parameter that is farthest from its default, in powers of ten."""

    def distance(name: str) -> float:
        value, usual = changed[name], defaults[name]
        if not isinstance(value, (int, float)) or isinstance(value, bool):
            return 0.5
        usual = usual if isinstance(usual, (int, float)) and usual != 0 else 1.0
        return math.inf if value * usual <= 0 else abs(math.log10(value / usual))

    return max(changed, key=distance)
