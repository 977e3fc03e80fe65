"""The choice of the contact term of a scene."""

from __future__ import annotations

from ..base.errors import InputError
from ..cells.internal_force import InternalForce
from ..planning.domain import Domain
from ..scene.contact_models import ImpulseContact, MasslessContact, PenaltyContact
from ..scene.scene import Scene
from .massless_contact import MasslessContactTerm
from .term import ContactTerm, ImpulseContactTerm, PenaltyContactTerm


def make_contact(scene: Scene, domain: Domain, force: InternalForce) -> ContactTerm | None:
    """Make the contact term of a domain; None if its bodies can touch nothing."""
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
    term.finish(scene, domain, force)
    return term
