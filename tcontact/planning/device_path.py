"""What threads of a GPU step of a scene, and what keeps a domain on the kernels of the CPU there, which are slow."""

from __future__ import annotations

from ..scene.cell_blocks import AVERAGED
from ..scene.contact_models import ImpulseContact, MasslessContact, PenaltyContact
from ..scene.friction_models import FrictionLayer
from ..scene.layer_metals import warms_bodies
from ..scene.scene import Scene
from .domain import Domain


def hindrances(scene: Scene, domain: Domain) -> list[str]:
    """Return by name what keeps a domain from being stepped by threads of a GPU; empty: nothing does.

    Supports, springs and loads are of all kinds but own forces of the user, contact is that with obstacles and between
    bodies, with or without friction, friction layers among it.
    """
    contact, layered = domain.contact, isinstance(scene.friction, FrictionLayer)
    blocks = [block.own.own for block in domain.blocks]
    found = {
        "mixed precision": bool(domain.mixed and len(domain.boundary)),
        "a contact set without nodes": contact is not None and not len(contact.nodes),
        "contact of another kind": contact is not None
        and not isinstance(scene.contact, MasslessContact | PenaltyContact | ImpulseContact),
        "obstacles that move freely without contact": contact is None and bool(domain.rigid),
        "obstacles that move freely beside pairs of bodies": bool(domain.pairs and domain.rigid),
        "friction layers between bodies": layered and bool(domain.pairs),
        "friction layers that warm cells": layered and contact is not None and warms_bodies(scene),
        "rigid parts": any(one.part is not None for one in domain.rigid),
        "own forces": any(load.own for body in domain.bodies for load in body.body.loads),
        "periodic bodies": domain.images is not None,
        "bulk viscosity": domain.viscosity is not None,
        "node-averaged cells": any(block.formulation == AVERAGED for block in blocks),
        "probes or maxima": bool(scene.maxima) or any(body.body.probes for body in domain.bodies),
    }
    return [name for name, there in found.items() if there]
