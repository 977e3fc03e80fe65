"""Precision of a run: float64, or float32 in the arithmetic of its ordinary cells."""

from __future__ import annotations

from typing import Any

from ..base.errors import InputError
from ..planning.planning import Plan

PRECISIONS = ("f64", "mixed")


def check_precision(precision: Any, scheme: Any, arch: str) -> None:
    """Refuse an unknown precision, and one that a scheme or a backend does not have. Raises `InputError`."""
    if not isinstance(precision, str) or precision not in PRECISIONS:
        raise InputError("precision", precision, "use 'f64' or 'mixed'")
    if precision == "mixed" and scheme.implicit:
        remedy = f"{scheme.name} solves its equations in float64; use precision='f64' or scheme='central-difference'"
        raise InputError("precision", precision, remedy)
    if precision == "mixed" and arch == "cuda":
        raise InputError("precision", precision, "the kernels for CUDA compute in float64; use 'f64' or arch='cpu'")


def set_precision(planned: Plan, precision: str) -> None:
    """Let the domains of a plan compute in this precision."""
    for domain in planned.domains:
        domain.mixed = precision == "mixed"


def precision_of(planned: Plan) -> str:
    """Return the precision in which the domains of a plan compute."""
    return "mixed" if any(domain.mixed for domain in planned.domains) else "f64"
