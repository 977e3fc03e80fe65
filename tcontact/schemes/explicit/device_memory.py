"""Bytes that a run takes on a GPU, counted from its plan before anything is started."""

from __future__ import annotations

from ...planning.describe import memory
from ...planning.device_memory import DeviceSize, cells_of, device_size
from ...planning.domain import Domain
from ...planning.planning import Plan
from .device_step import steps_on_device


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


def _domain_bytes(planned: Plan, domain: Domain) -> int:
    size, alone = domain_size(domain), steps_on_device(planned.scene, domain, "cuda")
    if alone and not len(domain.boundary):
        return size.total
    terms = memory(planned, domain)
    beside = sum(terms.values()) - terms["internal-force"] - terms["state"]
    if alone:
        return size.total + beside
    points = size.kept - size.state  # the state of the points, which `memory` leaves out
    return size.state + size.search + size.transfer + terms["internal-force"] + points + beside
