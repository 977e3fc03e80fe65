"""The methods of a study: a way to resolve contact, with a time scheme. Their names are read here.

A name is CONTACT, CONTACT@SCHEME, or one of these with *F. CONTACT: massless-normal, massless-full, massless-depth-D (D
layers), impulse, massless-penalty-K and penalty-K, with K in the problem's unit of stiffness (young/h unless it says
otherwise); SCHEME: a name of `tcontact.schemes.SCHEMES`, central-difference if none is given; *F takes F times the step
that the cfl number of the study asks for, which is what implicit schemes are for.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from ...base.errors import InputError
from ...scene.contact_models import ContactModel, ImpulseContact, MasslessContact, PenaltyContact
from ...schemes import SCHEMES
from ...schemes.explicit.central_difference import CentralDifference
from ...schemes.implicit.discrete_gradient import DiscreteGradient

Build = Callable[[float, float], ContactModel]  # (number in the name, unit of stiffness [N/m^3]) -> model

NUMBER = r"(\d+(?:\.\d*)?(?:e[+-]?\d+)?)"
FAMILIES: dict[str, tuple[str, Build]] = {
    "massless-normal": ("massless-normal", lambda _, unit: MasslessContact(removal="normal")),
    "massless-full": ("massless-full", lambda _, unit: MasslessContact(removal="full")),
    "massless-depth-D": (r"massless-depth-(\d+)", lambda d, unit: MasslessContact(depth=int(d))),
    "massless-penalty-K": (f"massless-penalty-{NUMBER}", lambda k, unit: MasslessContact(penalty=k * unit)),
    "penalty-K": (f"penalty-{NUMBER}", lambda k, unit: PenaltyContact(stiffness=k * unit)),
    "impulse": ("impulse", lambda _, unit: ImpulseContact()),
}
STANDARD = (
    "massless-normal",
    "massless-full",
    "massless-depth-3",
    "massless-penalty-10",
    "penalty-1",
    "penalty-10",
    "penalty-100",
    "impulse",
)


@dataclass(frozen=True)
class Method:
    """One method: its name, its contact model for a unit of stiffness [N/m^3], its time scheme.

    scheme(cfl, step): the cfl number counts in `step` [s], or in the stable step of the method itself if that is None.
    """

    name: str
    contact: Callable[[float], ContactModel]
    scheme: Callable[..., Any]


def method(name: str) -> Method:
    """Return the method of the given name. Raises `InputError` with the known ones."""
    whole, _, times = name.partition("*")
    contact, _, scheme = whole.partition("@")
    scheme = scheme or CentralDifference.name
    try:
        longer = float(times or 1.0)
    except ValueError:
        longer = 0.0
    if not 0.0 < longer < float("inf"):
        raise InputError("--methods", name, f"{times!r} is no number above 0 to multiply the step with")
    if scheme not in SCHEMES:
        raise InputError("--methods", name, f"{scheme!r} is no scheme; use one of " + ", ".join(SCHEMES))
    for pattern, build in FAMILIES.values():
        found = re.fullmatch(pattern, contact)
        if found:
            number = float(found.group(1)) if found.groups() else 0.0
            if found.groups() and not 0.0 < number < float("inf"):
                break
            return Method(
                name=name,
                contact=partial(build, number),
                scheme=partial(_scheme, SCHEMES[scheme], longer),
            )
    raise InputError("--methods", name, f"use {', '.join(FAMILIES)} (D, K: numbers above 0), with @SCHEME if wanted")


def _scheme(kind: Any, longer: float, cfl: float, step: float | None = None) -> Any:
    return kind(cfl=longer * cfl) if step is None else kind(dt=longer * cfl * step)


def standard(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the given names, and the first of them with the conserving implicit scheme at twice the step."""
    return (*names, f"{names[0]}@{DiscreteGradient.name}*2")
