"""The register of the hard cases."""

from __future__ import annotations

from collections.abc import Sequence

from ...base.errors import InputError
from .hard import impacts, invariances, long_runs, materials, meshes, starts, steps
from .hard_cases import HardCase


def register() -> dict[str, HardCase]:
    """Return all hard cases by name."""
    modules = (materials, meshes, impacts, starts, steps, long_runs, invariances)
    found: dict[str, HardCase] = {}
    for case in (case for module in modules for case in module.cases()):
        assert case.name not in found, case.name
        found[case.name] = case
    return found


def choose(names: Sequence[str] | None) -> list[HardCase]:
    """Return the named cases, all without names. Raises `InputError` with the known ones."""
    known = register()
    for name in names or ():
        if name not in known:
            raise InputError("--methods", name, "use hard cases by name: " + ", ".join(known))
    return [known[name] for name in names or known]
