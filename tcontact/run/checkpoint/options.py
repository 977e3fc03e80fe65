"""The options of checkpoints."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ...base import validate
from ...base.errors import InputError


@dataclass(frozen=True)
class Checkpoint:
    """Options for checkpoints in the output folder of a run, from which `tcontact.resume` continues.

    every_seconds [s]: of wall time; checkpoints come less often where they would take more than 1 % of it; every_steps:
    after so many steps, or soon after (bodies of few cells do many steps at once); either or both. Ctrl-C, SIGTERM
    and SIGHUP leave one too. origin: plain data kept with it for resuming: {"case": name, "set": [...]} of the command
    line; keep: write one at the end as well, and do not remove them when the run has finished, if work follows that a
    kill may interrupt, such as pictures. Raises `InputError`.
    """

    every_seconds: float | None = None
    every_steps: int | None = None
    origin: Mapping[str, Any] = field(default_factory=dict)
    keep: bool = False

    def __post_init__(self) -> None:
        if self.every_seconds is None and self.every_steps is None:
            raise InputError("checkpoint", None, "give every_seconds or every_steps")
        if self.every_seconds is not None:
            validate.keep(self, "checkpoint.every_seconds", low=0.0)
        if self.every_steps is not None:
            validate.whole("checkpoint.every_steps", self.every_steps, 1)
        validate.flag("checkpoint.keep", self.keep)
        remedy = "give a dictionary of plain data: text, numbers, lists and dictionaries of these"
        if not isinstance(self.origin, Mapping):
            raise InputError("checkpoint.origin", self.origin, remedy)
        try:
            json.dumps(dict(self.origin))
        except (TypeError, ValueError, RecursionError) as error:
            raise InputError("checkpoint.origin", self.origin, f"{remedy} ({error})") from error


def checked(value: Any, out: Any) -> Checkpoint | None:
    """Make the options from seconds, a dictionary, the options or None. Raises `InputError`."""
    if value is None:
        return None
    if isinstance(value, Mapping):
        known = ("every_seconds", "every_steps", "origin", "keep")
        for name in value:
            if name not in known:
                raise InputError("checkpoint", name, "use " + ", ".join(known))
        value = Checkpoint(**value)
    elif not isinstance(value, Checkpoint):
        value = Checkpoint(every_seconds=validate.number("checkpoint", value, low=0.0))
    if out is None:
        raise InputError("checkpoint", value, "needs a folder: give out too")
    return value
