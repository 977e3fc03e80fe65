"""Time schemes by name; each one file that reads like its formula."""

from __future__ import annotations

from typing import Any

from ..errors import InputError
from .central_difference import CentralDifference

SCHEMES: dict[str, type[CentralDifference]] = {CentralDifference.name: CentralDifference}


def scheme_of(value: Any) -> CentralDifference:
    """A scheme object, from itself or from its name. Raises `InputError` for anything else."""
    if isinstance(value, str):
        if value not in SCHEMES:
            raise InputError("scheme", value, "use one of " + ", ".join(repr(name) for name in SCHEMES))
        return SCHEMES[value]()
    if not isinstance(value, CentralDifference):
        raise InputError("scheme", value, "give a scheme object or one of " + ", ".join(repr(name) for name in SCHEMES))
    return value
