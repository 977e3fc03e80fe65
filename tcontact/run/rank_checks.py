"""What a run on several ranks refuses: scenes that take one rank, and ranks with different scenes."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from typing import Any

from ..base.errors import InputError
from ..device.team import Team
from ..results.result import Result
from ..scene.cell_blocks import AVERAGED
from ..scene.scene import Scene
from .checkpoint.fingerprint import fingerprint
from .rank_files import on_all

COMPARED = 16  # values by which the functions of time of two ranks are compared
ONE_RANK = "on one rank in this version"
ALONE = "start the run without mpiexec"


def check_ranks(scene: Scene, scheme: Any, arch: str, ranks: int) -> None:
    """Refuse what runs on one rank alone. Raises `InputError`, which names the first such field."""
    if scheme.implicit:
        raise InputError("scheme", scheme.name, f"an implicit scheme runs {ONE_RANK}; leave it out, or {ALONE}")
    for number, body in enumerate(scene.bodies):
        if arch != "cpu" and any(AVERAGED in block.element for block in body.blocks):
            remedy = (
                "give formulation='full' (tetrahedra that lock in plastic flow and near poisson 1/2), take hexahedra"
            )
            text = f"tetrahedra with averages at nodes run on CPUs where ranks share them; {remedy}, or leave arch out"
            raise InputError(f"Scene.bodies[{number}].formulation", AVERAGED, text)
    if ranks > 1:
        try:
            import pymetis  # noqa: F401
        except ImportError as error:
            raise InputError("ranks", ranks, "they need pymetis; pip install 'tcontact[mpi]'") from error


def check_alike(team: Team, scene: Scene, scheme: Any, options: Mapping[str, Any]) -> None:
    """Refuse ranks that have different scenes or options, by name: of `simulate` or `resume`, with their values.

    Raises `InputError` on all ranks, which names the first that differs.
    """
    own = on_all(team, lambda: fingerprint(scene, scheme, COMPARED)) | {
        name: repr(value) for name, value in options.items()
    }
    first = team.from_first(own)
    differs = [name for name in [*first, *own] if first.get(name) != own.get(name)]
    error = None
    if differs:
        name, remedy = differs[0], "all ranks run one scene together, with the same options"
        was = first.get(name, "not there")
        found = f"rank {team.rank} has that and the first rank {was}; {remedy}; scenes of their own run without mpiexec"
        error = InputError(name, own.get(name, "not there"), found)
    team.agree(error)


def check_same_start(team: Team, initial: Result) -> None:
    """Refuse ranks that start from results with different values of nodes, where several have such values.

    Raises `InputError` on all ranks.
    """
    own = None
    if initial.whole:
        own = zlib.crc32(initial.velocity.tobytes(), zlib.crc32(initial.position.tobytes()))
    known = team.comm.allgather(own)
    others = [rank for rank, found in enumerate(known) if found not in (None, known[0])]
    if others:
        where = f"rank {others[0]} starts from another result than the first rank"
        raise InputError("initial", initial, f"{where}; all ranks run one scene together, from one result")
