"""What ranks other than the first know of a whole plan: names and counts, no arrays of nodes or cells.

The first rank plans the whole scene, cuts it and gives every rank its part (run/rank_plan.py). What a run needs of
whole bodies beside that, the first rank does alone (device/lead.py).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...scene.body import Body
from ...scene.pairs import BodyPair
from ...scene.scene import Scene
from ..body_plan import BodyPlan, ContactPlan
from ..measured import Layout
from ..planning import Plan


@dataclass(frozen=True, eq=False)
class BodyOutline:
    """The outline of a planned body.

    support_rows [r]: as in `BodyPlan`; contact: without its graph and basis, `nodes` [k] in the user's numbering.
    """

    label: str
    body: Body
    node_count: int
    support_rows: np.ndarray
    viscous_cells: bool
    contact: ContactPlan | None


@dataclass(frozen=True, eq=False)
class DomainOutline:
    """The outline of a domain; its attributes are those of `Domain`."""

    bodies: tuple[BodyOutline, ...]
    numbers: tuple[int, ...]
    node_start: np.ndarray
    contact_start: np.ndarray
    mixed: bool
    pairs: tuple[BodyPair, ...]


@dataclass(frozen=True, eq=False)
class PlanOutline:
    """The outline of a plan; its attributes are those of `Plan`."""

    scene: Scene
    bodies: tuple[BodyOutline, ...]
    domains: tuple[DomainOutline, ...]
    terms: tuple[str, ...]
    layout: Layout
    factors: dict[str, float]


def forget_cells(planned: Plan | PlanOutline) -> None:
    """Let a plan forget its cells, which nothing needs once the run of every rank is made.

    Values of whole bodies need the order of their nodes, their masses and what their blocks are.
    """
    if isinstance(planned, PlanOutline):
        return
    for domain in planned.domains:
        domain.__dict__.pop("blocks", None)
    for plan in planned.bodies:
        plan.__dict__["blocks"] = tuple(replace(one, rows=np.array(one.rows[:0])) for one in plan.blocks)
        plan.__dict__.update(rows=np.array(plan.rows[:0]), cell_order=np.array(plan.cell_order[:0]))
        plan.__dict__.update(node_order=plan.node_order.astype(np.int32))  # half the memory
        plan.body.mesh.release()


def forget_places(planned: Plan | PlanOutline) -> None:
    """Let a plan forget the positions of its nodes, which the ranks have of their parts.

    What is left has the right shape and takes no memory.
    """
    if isinstance(planned, PlanOutline):
        return
    for domain in planned.domains:
        domain.__dict__.pop("reference", None)
        for plan in domain.bodies:
            plan.__dict__.pop("place", None)  # follows from the order of the nodes
            plan.__dict__["places"] = np.broadcast_to(np.nan, plan.places.shape)


def told(planned: Plan) -> dict[str, Any]:
    """Return the outline of a plan as plain data, which hold nothing of the scene."""
    bodies = [
        {"label": one.label, "node_count": one.node_count, "support_rows": one.support_rows,
         "viscous_cells": one.viscous_cells, "contact": _contact_told(one)}
        for one in planned.bodies
    ]  # fmt: skip
    number = {id(pair): place for place, pair in enumerate(planned.scene.body_pairs)}
    domains = [
        {
            "numbers": one.numbers,
            "node_start": one.node_start,
            "contact_start": one.contact_start,
            "mixed": one.mixed,
            "pairs": [number[id(pair)] for pair in one.pairs],
        }
        for one in planned.domains
    ]
    return {"bodies": bodies, "domains": domains, "terms": planned.terms, "layout": planned.layout,
            "factors": planned.factors}  # fmt: skip


def _contact_told(plan: BodyPlan) -> ContactPlan | None:
    contact = plan.contact
    if contact is None:
        return None
    return replace(contact, nodes=plan.node_order[contact.nodes], all_nodes=np.zeros(0), basis=None, graph=None)


def outlined(scene: Scene, known: dict[str, Any]) -> PlanOutline:
    """Return the outline of the plan of a scene from what `told` says of it."""
    bodies = tuple(BodyOutline(body=body, **one) for one, body in zip(known["bodies"], scene.bodies, strict=True))
    domains = tuple(
        DomainOutline(
            tuple(bodies[n] for n in one["numbers"]),
            **one | {"pairs": tuple(scene.body_pairs[number] for number in one["pairs"])},
        )
        for one in known["domains"]
    )
    return PlanOutline(scene, bodies, domains, known["terms"], known["layout"], known["factors"])
