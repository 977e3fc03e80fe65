"""The plan of a run on several ranks: the first one plans the scene, cuts it and gives every rank its part.

The others keep an outline of the plan. Where ranks share a contact, or a run goes on with another number of ranks, all
of them plan the whole scene, and each takes its part from that: they need lists of the whole contact.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..device.team import Team
from ..planning.partition.domain_part import DomainPart, cut_domain, domain_part, shares_contact
from ..planning.partition.message import packed, unpacked
from ..planning.partition.outline import PlanOutline, outlined, told
from ..planning.planning import Plan
from ..scene.scene import Scene
from .rank_files import on_first


def plan_and_parts(
    team: Team, scene: Scene, make: Callable[[], Plan], contact_ranks: int | None, whole: bool = False
) -> tuple[Plan | PlanOutline, list[DomainPart]]:
    """Return the plan of a scene, or its outline, and the part of this rank of every domain.

    make: makes the plan; contact_ranks: as in `cut_domain`; whole: all ranks need the plan.
    Raises `InputError` on all ranks.
    """
    found: dict[str, Any] = {}

    def first() -> tuple[Any, Any]:
        planned = found["plan"] = make()
        cuts = found["cuts"] = [cut_domain(domain, scene, team.size, contact_ranks) for domain in planned.domains]
        shared = any(shares_contact(domain, cut) for domain, cut in zip(planned.domains, cuts, strict=True))
        return (None, cuts) if whole or shared else (told(planned), None)

    outline, cuts = on_first(team, first)
    if outline is None:
        planned = found["plan"] if team.leads else make()
        return planned, [domain_part(*pair, team.rank) for pair in zip(planned.domains, cuts, strict=True)]
    if not team.leads:
        known = outlined(scene, outline)
        messages = team.received_share()
        return known, [unpacked(*pair, scene) for pair in zip(messages, known.domains, strict=True)]
    planned, cuts = found["plan"], found["cuts"]
    for rank in range(1, team.size):
        pairs = zip(planned.domains, cuts, strict=True)
        team.send_share(rank, [packed(domain_part(domain, cut, rank)) for domain, cut in pairs])
    parts = [domain_part(domain, cut, 0) for domain, cut in zip(planned.domains, cuts, strict=True)]
    for body in scene.bodies:
        body.mesh.release()
    return planned, parts
