"""The plan of a run on several ranks: the first one plans the scene, cuts it and gives every rank its part.

The others keep an outline of the plan. Where a run goes on with another number of ranks, all of them plan the whole
scene, and each takes its part from that: they need the parts of the ranks before.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from ..contact.shared_facts import WholeContact
from ..device.team import Team
from ..planning.partition.domain_part import DomainPart, cut_domain, domain_parts, kept_by, shares_contact
from ..planning.partition.message import packed, unpacked
from ..planning.partition.outline import PlanOutline, outlined, told
from ..planning.planning import Plan
from ..scene.scene import Scene
from .rank_files import on_first


def plan_and_parts(
    team: Team, scene: Scene, make: Callable[[], Plan], contact_ranks: int | None, whole: bool = False
) -> tuple[Plan | PlanOutline, list[DomainPart], list[str]]:
    """Return the plan of a scene, or its outline, the part of this rank of every domain, and warnings of the first one.

    make: makes the plan; contact_ranks: as in `cut_domain`; whole: all ranks need the plan.
    Raises `InputError` on all ranks.
    """
    found: dict[str, Any] = {}

    def first() -> tuple[Any, Any]:
        planned = found["plan"] = make()
        cuts = found["cuts"] = [cut_domain(domain, scene, team.size, contact_ranks) for domain in planned.domains]
        return (None, cuts) if whole else (told(planned), None)

    outline, cuts = on_first(team, first)
    if outline is None:
        planned = found["plan"] if team.leads else make()
        return planned, next(_parts(scene, planned, cuts, [team.rank])), []
    if not team.leads:
        known = outlined(scene, outline)
        messages = team.received_share()
        return known, [unpacked(*pair, scene) for pair in zip(messages, known.domains, strict=True)], []
    planned, others = found["plan"], range(1, team.size)
    said = _unshared(scene, planned, found["cuts"]) if (contact_ranks or 1) > 1 else []
    parts = _parts(scene, planned, found["cuts"], [*others, 0])
    for rank, there in zip(others, parts, strict=False):
        team.send_share(rank, [packed(part) for part in there])
    own = next(parts)
    for body in scene.bodies:
        body.mesh.release()
    return planned, own, said


def _unshared(scene: Scene, planned: Plan, cuts: Sequence[np.ndarray]) -> list[str]:
    """Return a text for every contact that one rank has although the user has asked for more, with the reason."""
    found = []
    for domain, cut in zip(planned.domains, cuts, strict=True):
        touching = [body.label for body in domain.bodies if body.contact is not None]
        if touching and not shares_contact(domain, cut):
            labels, why = ", ".join(touching), kept_by(domain, scene)
            found.append(f"contact_ranks has no effect: the first rank has the whole contact of {labels}, due to {why}")
    return found


def _parts(scene: Scene, planned: Plan, cuts: Sequence[np.ndarray], ranks: Sequence[int]) -> Iterator[list[DomainPart]]:
    """Yield for every one of some ranks its part of all domains."""
    wholes = [WholeContact(scene, domain) for domain in planned.domains]
    each = [domain_parts(domain, cut, ranks) for domain, cut in zip(planned.domains, cuts, strict=True)]
    for parts in zip(*each, strict=True):
        for whole, part in zip(wholes, parts, strict=True):
            whole.add_to(part)
        yield list(parts)
