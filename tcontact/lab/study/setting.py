"""Setting of a study: a problem, methods, sizes and steps, and the scene of each run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from types import ModuleType
from typing import Any

from ...base.errors import InputError
from ...scene.contact_models import MasslessContact
from .methods import Method, method

TAKEN = ("cells", "contact", "removal", "penalty", "depth")  # parameters that the study itself sets


@dataclass(frozen=True)
class Study:
    """What to run: problem, names of methods, sizes (cells), cfl numbers, parameters of the scene, seconds, threads.

    error: the one that the table and the figure show, None = the problem's main one.
    """

    name: str
    problem: ModuleType
    methods: Sequence[str]
    sizes: Sequence[int]
    cfls: Sequence[float]
    parameters: dict[str, Any] = field(default_factory=dict)
    budget: float | None = None
    threads: int | None = None
    error: str | None = None

    def __post_init__(self) -> None:
        for name in self.methods:
            method(name)
        if self.error is not None and self.error not in self.problem.ERRORS:
            raise InputError("--error", self.error, "use one of " + ", ".join(self.problem.ERRORS))
        for key in self.parameters:
            if key in TAKEN:
                raise InputError("--set", key, "a study sets it itself: use --sizes and --methods")

    @property
    def shown(self) -> str:
        """The error that the table and the figure show."""
        return self.error or str(self.problem.ERRORS[0])


def build(study: Study, chosen: Method, size: int) -> Any:
    """Return the scene of the study with the method's contact and its start."""
    scene = study.problem.scene(cells=size, **study.parameters)
    model = chosen.contact(study.problem.unit(scene))
    if isinstance(model, MasslessContact) and isinstance(scene.contact, MasslessContact):
        model = replace(model, sweeps=scene.contact.sweeps, tolerance=scene.contact.tolerance)
    scene = replace(scene, contact=model)
    return study.problem.displaced(scene) if hasattr(study.problem, "displaced") else scene
