"""Settings of a case: `--set KEY=VALUE`, read by the type that its `scene` declares for KEY, and keys of the scheme."""

from __future__ import annotations

import types
import typing
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
from inspect import signature
from types import ModuleType
from typing import Any, Literal

from ..base.errors import InputError, hint
from ..schemes import SCHEMES

SCHEME_KEYS: dict[str, Any] = {
    "scheme": str,
    "cfl": float,
    "dt": float,
    "alpha": float,
    "chi": float,
    "mass": str,
    "reproject": bool,
}
TRUTH = {"true": True, "yes": True, "on": True, "1": True, "false": False, "no": False, "off": False, "0": False}


@dataclass(frozen=True)
class Settings:
    """What the user set: parameters of the scene, options of the scheme, whether to run the case's comparison."""

    scene: dict[str, Any] = field(default_factory=dict)
    scheme: dict[str, Any] = field(default_factory=dict)
    compare: bool = False


def read(name: str, case: ModuleType, pairs: Sequence[str]) -> Settings:
    """Sort KEY=VALUE pairs for the case called `name`. Raises `InputError` with the known keys or values."""
    builder = _builder(case)
    hints = typing.get_type_hints(builder)
    known = {key: hints.get(key, str) for key in signature(builder).parameters}
    of_scheme = SCHEME_KEYS if hasattr(case, "scene") else {}
    extra: dict[str, Any] = {"compare": bool} if hasattr(case, "comparison") else {}
    scene: dict[str, Any] = {}
    scheme: dict[str, Any] = {}
    compare = False
    for pair in pairs:
        key, equals, text = pair.partition("=")
        key = key.strip()
        if not equals:
            raise InputError("--set", pair, "give KEY=VALUE, for example --set cells=8")
        if key in known:
            scene[key] = value(key, text, known[key])
        elif key in extra:
            compare = value(key, text, bool)
        elif key in of_scheme:
            scheme[key] = value(key, text, of_scheme[key])
        else:
            words = [*known, *extra, *of_scheme]
            raise InputError(
                "--set", key, f"{name} has no such parameter; {hint(key, words)}it knows {', '.join(words)}"
            )
    return Settings(scene, scheme, compare)


def built(build: Callable[..., Any], parameters: dict[str, Any]) -> Any:
    """Return what a case makes of the parameters. Raises `InputError`, also where they are too large or too small."""
    try:
        return build(**parameters)
    except InputError:
        raise
    except (ArithmeticError, IndexError, ValueError) as error:
        if not parameters:
            raise
        given = " ".join(f"{name}={value}" for name, value in parameters.items())
        remedy = f"the case cannot compute with that ({error}): give values nearer to the defaults"
        raise InputError("--set", given, remedy) from error


def defaults(case: ModuleType) -> dict[str, Any]:
    """Return the default of every parameter of the case."""
    return {key: parameter.default for key, parameter in signature(_builder(case)).parameters.items()}


def _builder(case: ModuleType) -> Any:
    """Return the function that takes the parameters: `scene`, or `solve` of a case without a scene."""
    return case.scene if hasattr(case, "scene") else case.solve


def value(key: str, text: str, kind: Any) -> Any:
    """Return the text as a value of the declared type: int, float, bool, str, Literal, or one of these or None."""
    text = text.strip()
    kinds = typing.get_args(kind) if typing.get_origin(kind) in (typing.Union, types.UnionType) else (kind,)
    for choice in kinds:
        if choice is type(None):
            if text.lower() in ("none", "null", ""):
                return None
        elif typing.get_origin(choice) is Literal:
            if text in typing.get_args(choice):
                return text
        elif choice is bool:
            if text.lower() in TRUTH:
                return TRUTH[text.lower()]
        else:
            try:
                return choice(text)
            except ValueError:
                continue
    raise InputError(f"--set {key}", text, "give " + " or ".join(map(_wanted, kinds)))


def _wanted(kind: Any) -> str:
    if typing.get_origin(kind) is Literal:
        return "one of " + ", ".join(typing.get_args(kind))
    named = {int: "a whole number", float: "a number", bool: "true or false", str: "text", type(None): "none"}
    return named.get(kind, str(kind))


def scheme(options: dict[str, Any], case: Any = None) -> Any:
    """Return the time scheme that the options ask for, else the case's own (its SCHEME). Raises `InputError`."""
    return changed(dict(getattr(case, "SCHEME", {})), options)


def options_of(scheme: Any) -> dict[str, Any]:
    """Return the options of a scheme that are not their defaults, with its name."""
    values = {item.name: getattr(scheme, item.name) for item in fields(scheme) if item.init}
    defaults = {item.name: item.default for item in fields(scheme)}
    return {"scheme": scheme.name} | {name: value for name, value in values.items() if value != defaults[name]}


def changed(own: dict[str, Any], options: dict[str, Any]) -> Any:
    """Return the time scheme with its own options, but for those given: dt takes the place of cfl, and cfl that of dt.

    Another scheme keeps those that it has too; central differences start anew, as an implicit step is too long for
    them. Raises `InputError`.
    """
    name = options.get("scheme", own.get("scheme", "central-difference"))
    if name not in SCHEMES:
        raise InputError("--set scheme", name, hint(name, SCHEMES) + "use one of " + ", ".join(SCHEMES))
    taken = {item.name for item in fields(SCHEMES[name])}
    dropped = {"dt", "cfl"} if "dt" in options or "cfl" in options else set()
    kept = set() if options.get("scheme") == "central-difference" else taken - dropped
    options = {key: value for key, value in options.items() if key != "scheme"}
    for key in options:
        if key not in taken:
            raise InputError(f"--set {key}", options[key], f"{name} has no such option")
    if options.get("cfl") is not None and options.get("dt") is not None:
        raise InputError("--set cfl, dt", (options["cfl"], options["dt"]), "give one of them")
    return SCHEMES[name](**({key: value for key, value in own.items() if key in kept} | options))
