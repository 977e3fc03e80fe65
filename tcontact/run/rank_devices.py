"""The GPUs of the ranks of a run: what is refused there, and whether their memory suffices."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable, Sequence
from typing import Any

from ..base.errors import InputError
from ..device import runtime
from ..device.cuda import VISIBLE
from ..device.team import Team
from ..planning.device_path import hindrances
from ..planning.partition.domain_part import DomainPart
from ..planning.planning import Plan
from ..scene.scene import Scene
from .device_room import check_device
from .rank_files import on_all


def sharing(contact_ranks: int | None, arch: str) -> int | None:
    """Return how many ranks share the contact, see `cut_domain`: on GPUs the first one has all of it.

    Raises `InputError` where more are asked for there.
    """
    if arch == "cpu":
        return contact_ranks
    if contact_ranks not in (None, 1):
        remedy = "on GPUs the first rank has the whole contact; leave it out, or use arch='cpu'"
        raise InputError("contact_ranks", contact_ranks, remedy)
    return 1


def check_as_many(before: int, ranks: int, arch: str) -> None:
    """Refuse to go on on GPUs with a run of another number of ranks. Raises `InputError`."""
    if arch == "cuda" and before != ranks:
        remedy = f"{before} process(es) wrote the checkpoint, and on GPUs as many go on: start so many, or run again"
        raise InputError("arch", arch, remedy)


def start_on_ranks(team: Team, scene: Scene, parts: Sequence[DomainPart], arch: str, threads: int | None) -> None:
    """Start the compiler on every rank.

    Raises `InputError` on all ranks for options of any of them, and for what GPUs of several ranks do not do.
    """
    if arch == "cuda":
        team.agree(_refusal(lambda: _check_path(scene, parts, arch)))
        here = Plan(scene, tuple(plan for part in parts for plan in part.domain.bodies))
        here.__dict__["domains"] = tuple(part.domain for part in parts)
        known: list[tuple[Any, int]] = []

        def together(needed: int) -> int:
            """Return the bytes that the ranks need which share the device of this one."""
            place = platform.node(), os.environ.get(VISIBLE)
            known.extend(team.comm.allgather((place, needed)))
            return sum(size for other, size in known if other == place)

        error = _refusal(lambda: check_device(here, arch, together))
        if not known:  # this rank has no device, or an array that is too large: the others wait for what it needs
            team.comm.allgather(("", 0))
        team.agree(error)
    on_all(team, lambda: runtime.start(arch, threads))


def _refusal(check: Callable[[], None]) -> InputError | None:
    """Return the error of a check, None without one."""
    try:
        check()
    except InputError as error:
        return error
    return None


def _check_path(scene: Scene, parts: Sequence[DomainPart], arch: str) -> None:
    """Refuse what threads of a GPU do not step. Raises `InputError`."""
    slow = {name: None for part in parts for name in hindrances(scene, part.domain)}
    if slow:
        remedy = f"on several ranks with {', '.join(slow)}: leave it out, take one process, or use arch='cpu'"
        raise InputError("arch", arch, f"a GPU steps no scene {remedy}")
