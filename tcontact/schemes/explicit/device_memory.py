"""Bytes that a run takes on a GPU, counted from its plan before anything is started."""

from __future__ import annotations

import numpy as np

from ...friction_layer.layer import LAYOUTS
from ...kernels import layer_places as at
from ...kernels.lanes import DEVICE_ROWS
from ...planning.describe import layer_bytes, memory
from ...planning.device_memory import PLACES, REAL, WHOLE, DeviceSize, cells_of, device_size
from ...planning.domain import Domain
from ...planning.planning import Plan
from ...scene.friction_models import FrictionLayer
from ...scene.layer_metals import all_kinds
from .device_step import steps_on_device

COLUMN, MATERIAL, SETTINGS = 6, 12, 5  # numbers in the tables of layers: of a point, of a side, of all (kernels/layer)


def plan_bytes(planned: Plan) -> int:
    """Return the bytes that the domains of a plan take on a GPU together; those of pairs of bodies are left out."""
    return sum(_domain_bytes(planned, domain) for domain in planned.domains)


def plan_places(planned: Plan) -> int:
    """Return the numbers of the largest array of a plan on a GPU."""
    return max(domain_size(domain).places for domain in planned.domains)


def domain_size(domain: Domain) -> DeviceSize:
    """Return what the cells and nodes of a domain take that is stepped with a thread per cell."""
    from ...kernels.elements import FUNCTIONS
    from ...kernels.materials import LAWS

    kept = {kind: FUNCTIONS[kind[0]].points * len(LAWS[kind[1]].state) for kind in domain.kinds}
    return device_size(cells_of(domain, kept), len(domain.reference), domain.plastic, domain.viscous_cells)


def _layer_bytes(planned: Plan, domain: Domain, alone: bool) -> int:
    """Return the bytes that friction layers take on a GPU beyond those on a CPU; alone: its threads step them."""
    scene, contact = planned.scene, domain.contact
    if not isinstance(scene.friction, FrictionLayer) or contact is None or not len(contact.nodes):
        return 0
    pack = LAYOUTS["cuda"][1]
    found = layer_bytes(scene, domain, pack, PLACES) - layer_bytes(scene, domain)
    if not alone:
        return found
    kinds, counts = all_kinds(scene, domain.numbers), np.diff(domain.contact_start)
    entries = sum(int(counts[domain.numbers.index(number)]) for bodies in kinds.values() for number in bodies)
    numbers = at.HEAD + at.NODE * len(contact.nodes) + at.ENTRY * entries + len(counts)
    tables = sum(len(kind.metals) * (scene.friction.points * (COLUMN + 2) + MATERIAL) + SETTINGS + 1 for kind in kinds)
    lists = (len(kinds) + 1) * len(contact.nodes) + entries + len(counts) * (len(scene.obstacles) + 1) + 5 * len(kinds)
    rows = DEVICE_ROWS * len(at.ROW)
    kept = layer_bytes(scene, domain, pack, 0)
    return found + kept + REAL * (2 * numbers + tables + rows + 1) + WHOLE * (lists + at.LISTS + 7)


def _domain_bytes(planned: Plan, domain: Domain) -> int:
    size, alone = domain_size(domain), steps_on_device(planned.scene, domain, "cuda")
    if alone and not len(domain.boundary):
        return size.total
    terms = memory(planned, domain)
    beside = sum(terms.values()) - terms["internal-force"] - terms["state"]
    beside += _layer_bytes(planned, domain, alone)
    if alone:
        return size.total + beside
    points = size.kept - size.state  # the state of the points, which `memory` leaves out
    return size.state + size.search + size.transfer + terms["internal-force"] + points + beside
