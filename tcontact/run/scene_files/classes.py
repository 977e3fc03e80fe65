"""The classes that a scene file can name, by their places."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from ...friction_layer import metals
from ...scene.contact_models import ImpulseContact, MasslessContact, PenaltyContact
from ...scene.dissipation import BulkViscosity, Damping
from ...scene.friction_models import Coulomb, FrictionLayer, FrictionTable, NoFriction, RegularizedCoulomb
from ...scene.materials import LAWS
from ...scene.metals import HARDENINGS, ElastoPlastic, MieGrueneisen
from ...scene.obstacles import Box, Cylinder, Plane, Sdf, Sphere
from ...scene.own_laws import OWN
from ...scene.rigid import RigidPart
from ...schemes import SCHEMES

# place -> type word -> class; a place with one class needs no word
CLASSES: dict[str, dict[str, type]] = {
    "material": {kind.__name__: kind for kind in (*LAWS.values(), ElastoPlastic)},
    "hardening": {kind.__name__: kind for kind in HARDENINGS},
    "pressure": {"MieGrueneisen": MieGrueneisen},
    "obstacles": {kind.__name__: kind for kind in (Plane, Sphere, Cylinder, Box, Sdf)},
    "contact": {kind.__name__: kind for kind in (MasslessContact, PenaltyContact, ImpulseContact)},
    "friction": {
        kind.__name__: kind for kind in (Coulomb, FrictionTable, RegularizedCoulomb, FrictionLayer, NoFriction)
    },
    "damping": {kind.__name__: kind for kind in Damping.__subclasses__()},
    "viscosity": {"BulkViscosity": BulkViscosity},
    "metal": {"Metal": metals.Metal},
    "rigid_parts": {"RigidPart": RigidPart},
    "scheme": dict(SCHEMES),
}
NESTED = ("hardening", "pressure", "friction")  # arguments that are objects of plain data themselves
METALS = {name: metal for name, metal in vars(metals).items() if isinstance(metal, metals.Metal)}
SCENE_PARTS = ("contact", "friction", "damping", "viscosity")  # places that may be "none"
RUN = ("scheme", "frames", "threads", "arch", "precision", "history_every", "history_rows")
SURFACE = ("surface", "cells", "margin", "scale")  # options of an Sdf from a file of triangles


def keys_of(kind: type) -> list[str]:
    """Return the names of the arguments of a dataclass."""
    return [field.name for field in fields(kind) if field.init]


def words_of(place: str) -> dict[str, type]:
    """Return the classes that a place takes by their words; materials with those of `tcontact.register_law`."""
    return CLASSES[place] | OWN if place == "material" else CLASSES[place]


def word_of(place: str, value: Any) -> str | None:
    """Return the type word of an object at a place; None if its class is not one of those there."""
    for word, kind in words_of(place).items():
        if type(value) is kind:
            return word
    return None
