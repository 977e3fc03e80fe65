"""The registry of contact terms."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..base.errors import InputError
from ..cells.internal_force import InternalForce
from ..nodes.boundary_nodes import BoundaryNodes
from ..planning.domain import Domain
from ..scene.scene import Scene

if TYPE_CHECKING:
    pass
from ..scene.contact_models import ImpulseContact, MasslessContact, PenaltyContact
from .massless_contact import MasslessContactTerm
from .term import ContactTerm, ImpulseContactTerm, PenaltyContactTerm


def make_contact(
    scene: Scene, domain: Domain, listed: BoundaryNodes | None, force: InternalForce
) -> ContactTerm | None:
    """The contact term of a body, or None if it can touch nothing. The registry of contact terms."""
    if domain.contact is None:
        return None
    term: ContactTerm
    if len(domain.contact.nodes) == 0:  # supports hold every node of the set along the normals
        term = ContactTerm(scene, domain)
    elif isinstance(scene.contact, MasslessContact):
        term = MasslessContactTerm(scene, domain, force)
    elif isinstance(scene.contact, PenaltyContact):
        term = PenaltyContactTerm(scene, domain)
    elif isinstance(scene.contact, ImpulseContact):
        term = ImpulseContactTerm(scene, domain)
    else:
        raise InputError("Scene.contact", scene.contact, "unknown contact model")
    term.finish(scene, domain)
    return term
