"""The part of a domain of a rank other than the first, as a message to it: arrays and the sets of its mesh.

It holds nothing of the scene, which may have functions that no message can hold: the receiver has the scene, and puts
materials and options from there. On the nodes of such a part nothing acts but constant gravity, constant supports
(body_part.py), and contact that ranks share.
"""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from ...mesh.ordered_mesh import Facts, Ordered, OrderedMesh
from ...scene.scene import Scene
from ..body_plan import BodyPlan
from .body_part import BodyPart, body_of
from .domain_part import OF_DOMAIN, DomainPart, PartDomain
from .outline import BodyOutline, DomainOutline

OF_SCENE = ("body", "damping", "viscosity")  # what the receiver has
ACTS: dict[str, Any] = {"images": None, "rigid": ()}  # what such a part has not
OF_PART = ("shared", "settings", "surfaces", "counted", "held")  # what a part alone has, or None


def packed(part: DomainPart) -> dict[str, Any]:
    """Return the part of a rank other than the first."""
    options = {name: getattr(part.domain, name) for name in (*OF_DOMAIN, *OF_PART)}
    return {"options": options, "paired": bool(part.domain.pairs), "bodies": [_packed_body(one) for one in part.bodies]}


def _packed_body(own: BodyPart) -> dict[str, Any]:
    plan = {field.name: getattr(own.plan, field.name) for field in fields(BodyPlan) if field.name not in OF_SCENE}
    assert all(plan.pop(name) == none for name, none in ACTS.items())
    found = {"part": own.part, "plan": plan, "nodes": own.nodes, "shared": own.shared, "mass": own.mass}
    return found | ({"mesh": Facts.of(own.plan.body.mesh)} if len(own.nodes) else {})


def unpacked(message: dict[str, Any], whole: DomainOutline, scene: Scene) -> DomainPart:
    """Return the part in a message; whole: outline of the domain; scene: that of the run."""
    bodies = tuple(_unpacked_body(*pair, scene) for pair in zip(message["bodies"], whole.bodies, strict=True))
    there = [number for number, body in enumerate(bodies) if len(body.nodes)]
    pairs = whole.pairs if message["paired"] else ()
    domain = PartDomain(tuple(bodies[n].plan for n in there), tuple(whole.numbers[n] for n in there), pairs)
    for name, value in message["options"].items():
        setattr(domain, name, value)
    return DomainPart(whole, bodies, domain)


def _unpacked_body(found: dict[str, Any], whole: BodyOutline, scene: Scene) -> BodyPart:
    body, part, plan = whole.body, found["part"], found["plan"]
    if "mesh" in found:
        ordered = Ordered(*(plan[name] for name in ("places", "rows", "node_order", "cell_order")))
        body = body_of(body, OrderedMesh.of(ordered, found["mesh"]), part.nodes, False, plan["contact"] is not None)
    plan = BodyPlan(**plan, **ACTS, body=body, damping=scene.damping, viscosity=scene.viscosity)
    if "mesh" not in found:
        plan.__dict__["blocks"] = ()  # those of its body are the blocks of the whole mesh
    return BodyPart(whole, part, plan, found["nodes"], found["shared"], found["mass"])
