"""Describe a plan in words: terms, sizes, kernels and bytes, before anything is allocated."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from ..kernels.columns import cell_groups, group_size
from ..kernels.lanes import (
    CONTACT_BLOCK,
    DRIVEN_AXIS,
    FRICTION_NODE,
    ISLAND,
    MAXIMUM_ROWS,
    MAXIMUM_SLOTS,
    OBSTACLE,
    SPRING_ENTRY,
    SPRING_HEAD,
    SPRING_NUMBERS,
)
from ..kernels.rigid_places import HEAD, POSE, RECORD
from ..mesh.elements import FORMULATIONS
from ..mesh.geometry import spanned_heights
from ..scene.friction_laws import law_data, varies
from ..scene.friction_models import FrictionLayer
from ..scene.layer_metals import all_kinds
from ..scene.pairs import held_pairs, held_text
from ..scene.scene import Scene
from .applied_loads import pack_loads
from .body_plan import FRICTION_TERMS, BodyPlan, PlanBlock
from .device_path import hindrances
from .domain import Domain
from .domain_packs import pack_domain
from .measured import raw_groups
from .node_volumes import volume_arrays
from .packing import CellPacks
from .springs import part_carriers, planned_ends
from .static_solver import response_components, static_solver
from .sweep_order import sweep_order

REAL, WHOLE = 8, 4  # bytes of a number
STIFF = 0.5  # omega^2 of springs over (wave speed / height)^2 of the cells from which they shorten the step much
SYMMETRIC = 6


class Plan(Protocol):
    """The parts of a plan that its description reads."""

    @property
    def contact_term(self) -> str | None: ...
    @property
    def domains(self) -> Any: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def terms(self) -> tuple[str, ...]: ...


def describe(plan: Plan) -> str:
    """Describe the terms of the run, and for every body its cells and nodes, its kernels and their bytes."""
    lines = ["terms: " + ", ".join(plan.terms)]
    for domain in plan.domains:
        lines += [_body(plan, body) for body in domain.bodies]
        if domain.springs:
            lines.append(_springs(domain))
        lines.append("  kernels: " + ", ".join(kernels(plan, domain)))
        sizes = [f"{name} {_readable(size)}" for name, size in memory(plan, domain).items()]
        lines.append("  memory: " + ", ".join(sizes))
        if slow := hindrances(plan.scene, domain):
            lines.append(f"  with arch='cuda' on the kernels of the CPU, slowly: {', '.join(slow)}")
    for both in held_pairs(plan.scene):
        lines.append(f"no pair, and the run stops if they meet: {held_text(plan.scene, *both)}")
    return "\n".join(lines)


def _body(plan: Plan, body: BodyPlan) -> str:
    mesh = body.body.mesh
    line = f"{body.label}: "
    if len(body.blocks) == 1:
        line += f"{mesh.cell_count} {body.element} cells, {mesh.node_count} nodes, {_block(body.blocks[0])}"
    else:
        for block in body.blocks:
            line += f"{len(block.cells)} {block.own.element} cells {_named(block)}{_block(block)} + "
        line = f"{line[:-3]}, {mesh.node_count} nodes"
    if body.body.point_masses:
        line += f", {sum(point.mass for point in body.body.point_masses):.6g} kg of point masses"
    if len(body.boundary):
        line += f", {len(body.boundary)} nodes with their own mass tensor, support or contact"
    contact = body.contact
    if contact is not None:
        line += f"; {len(contact.nodes)} contact nodes"
        if contact.graph is not None:
            line += (
                f" without mass ({contact.removal} removal, {contact.block} components a node,"
                f" {len(contact.graph.cells)} contact cells, {contact.graph.colours} colours;"
                f" static solve by {static_solver(plan.scene, body)})"
            )
    return line


def _block(block: PlanBlock) -> str:
    """Return the law of a block and how its forces are integrated."""
    way = FORMULATIONS[block.own.element]
    ways = {"": way.integration, "-stored": way.integration, "-affine": way.affine, "-box": way.box}
    return f"{block.own.material.law} ({ways[block.variant.removeprefix(block.own.element)]})"


def _named(block: PlanBlock) -> str:
    return "" if block.own.region is None else f"in {block.own.region!r} "


def _springs(domain: Domain) -> str:
    """Return the number of the springs, and whether they shorten the stable step."""
    rate = max(domain.spring_rates.values())
    cells = 1.0 / min(
        (spanned_heights(block.own.own.kind, domain.reference, block.cells).min() / block.material.wave_speed)
        for block in domain.blocks
    )
    line = f"  springs: {len(domain.springs)}"
    if rate > 0.0:
        line += f", stable step of the masses upon them alone at least {2.0 / np.sqrt(rate):.3g} s"
    if rate > STIFF * cells**2:
        line += ": they are stiff beside the cells and shorten the step; share them over more nodes or soften them"
    return line


def kernels(plan: Plan, domain: Domain) -> list[str]:
    """List the kernels that a step of a domain launches, each with its parts."""
    cells = "; ".join(", ".join(kind) for kind in domain.kinds)
    beside = [] if domain.images is None else ["images of periodic nodes"]
    if domain.contact is not None:
        massless = domain.contact.graph is not None
        load = {"penalty-contact": "penalty load", "impulse-contact": "impulse load"}.get(
            plan.contact_term or "", "gaps"
        )
        beside.append("massless load, prediction" if massless else load)
        if domain.few_contact_cells and not domain.small:  # otherwise the force pass or the serial step does them
            beside.append("contact cells")
        if domain.viscous_cells:
            beside.append("viscosity of the contact cells")
        if massless:
            beside.append("static solve")
        if plan.scene.friction is not None and len(domain.contact.nodes):
            beside.append("friction")
            beside += ["its coefficients"] if varies(plan.scene) else []
    if domain.springs:
        beside.append("springs")
    if domain.driven:
        beside.append("driven supports")
    if domain.rigid:
        beside.append("motion of rigid bodies")
    if len(domain.support_rows):
        beside.append("support reactions")
    if len(domain.boundary) and domain.damping is not None:
        beside.append("damping of the boundary nodes")
    if domain.loaded:
        beside.append("loads")
    if len(domain.boundary):
        beside.append("kick and drift of the boundary nodes")
    layers = _layered(plan, domain)
    if domain.small:
        parts = ", ".join([*domain.options, "force pass", *beside]) + ("" if layers else "; many steps a launch")
        names = [f"serial_step({cells}: {parts})"]
    else:
        names = [f"step({', '.join([cells, *domain.options])})"]
        names += [f"serial_step({', '.join(beside)})"] if beside else []
        if domain.viscous_cells and not domain.few_contact_cells:
            names.append(f"viscous_pass({cells})")
    return [*names, "layer"] if layers else names


def memory(plan: Plan, domain: Domain) -> dict[str, int]:
    """Return the bytes that the terms of a domain will take, as in `Result.memory`, on up to 8 threads.

    They leave out the state of laws that keep numbers at their quadrature points, the rows of pairs of bodies, and what
    probes and maxima take.
    """
    nodes, packs = len(domain.reference), pack_domain(domain)
    boundary = len(domain.boundary)
    result = {"state": 2 * 3 * REAL * nodes, "internal-force": _force_pass(plan, domain, packs)}
    if boundary:
        loads = pack_loads(domain)
        result["boundary-nodes"] = boundary * (WHOLE + REAL * (2 * SYMMETRIC + 3 + 3))
        result["boundary-nodes"] += 0 if loads is None else loads.data.nbytes
    if len(domain.support_rows):
        result["supports"] = len(domain.support_rows) * (WHOLE + REAL)
    if domain.driven:
        axes = sum(len(support.axes) for support in domain.driven)
        result["supports"] += len(domain.support_rows) * (WHOLE + REAL) + WHOLE
        result["supports"] += DRIVEN_AXIS * axes * domain.table_rows * REAL
    if domain.springs:
        entries = sum(len(end.nodes) for ends in planned_ends(domain) for end in ends)
        carriers = sum(own.size for own in part_carriers(domain))
        numbers = SPRING_HEAD + SPRING_NUMBERS * len(domain.springs) + SPRING_ENTRY * entries + carriers
        result["boundary-nodes"] += numbers * REAL
    if domain.images is not None:
        result["periodic"] = 2 * WHOLE * len(domain.images.followers)
    if domain.rigid:
        rows = (MAXIMUM_ROWS if domain.small else 1) + 1 if any(body.motion for body in domain.rigid) else 0
        size = HEAD + len(domain.rigid) * (RECORD + rows * POSE) + 3 * len(domain.tied)
        ties = len(domain.rigid) + 1 + len(domain.tied) if any(body.part for body in domain.rigid) else 0
        result["rigid-bodies"] = REAL * size + WHOLE * ties
    contact = domain.contact
    if contact is not None:
        count = len(contact.nodes)
        slots = min(len(plan.scene.obstacles), MAXIMUM_SLOTS) + bool(domain.pairs)
        known = count if len(plan.scene.obstacles) <= MAXIMUM_SLOTS else 0  # nodes whose smallest gap a row holds
        bodies = sum(body.contact is not None for body in domain.bodies)
        size = (count + len(contact.all_nodes) - known) * (WHOLE + 3 * REAL) + (bodies + 1) * ISLAND * WHOLE
        size += count * (slots * WHOLE + 3 * REAL) + count * slots * REAL * _row_width(plan, domain)
        size += _obstacles(plan, domain)
        if contact.graph is not None:
            graph, block = contact.graph, contact.block
            order = sweep_order(graph, block)  # padded to lanes
            size += count * REAL * (3 * block + 1 + 3 * block + block * block + slots * (1 + block) + 2)
            solver = domain.projected
            components = response_components(plan.scene, block, slots, bool(domain.pairs), solver)
            size += count * REAL * (components - block - 1)
            size += len(domain.residual_receivers[1]) * WHOLE
            size += order.column.size * (WHOLE + REAL * block * block) + len(graph.column) * 3 * WHOLE
            size += len(graph.pair_nodes) * (4 * WHOLE + REAL * block * block) + len(graph.entry_pairs) * WHOLE
            size += len(packs.corners) * WHOLE
            for cells in domain.blocks:
                if len(cells.contact):
                    _values, gradients, weights = cells.facts.rule
                    size += CONTACT_BLOCK * WHOLE + REAL * (gradients.size + weights.size)
        result[plan.contact_term or "contact"] = size
        if domain.viscous_cells and contact.graph is not None:
            lanes = packs.lanes - packs.first_contact_lane
            numbers = 7 + 6 * boundary + lanes + 3 * packs.corner_rows + len(contact.graph.cells)
            result["cell-viscosity"] = REAL * numbers
        if plan.scene.friction is not None and count:
            laws = law_data(plan.scene, domain.pairs, contact.areas)
            numbers = count * (FRICTION_NODE + 4 * domain.records_friction)
            size = REAL * (2 + numbers + (0 if laws is None else len(laws)))
            result[FRICTION_TERMS[type(plan.scene.friction)]] = size + layer_bytes(plan.scene, domain)
    return result


def _row_width(plan: Plan, domain: Domain) -> int:
    """Count the numbers of a constraint row."""
    contact, scene = domain.contact, plan.scene
    assert contact is not None
    massless, has_friction = contact.graph is not None, scene.friction is not None
    static_friction = massless and has_friction and contact.block > 1
    kicked = has_friction and (not massless or bool(domain.inverses[: len(contact.nodes)].any()))
    now = scene.moving and (kicked or plan.contact_term == "impulse-contact")
    lifted = bool(domain.pairs and scene.obstacles) and massless and not static_friction
    vectors = now + (scene.moving and static_friction) + kicked + 3 * static_friction + lifted
    return 7 + massless + 2 * has_friction + 3 * (vectors + (has_friction and varies(scene)))


def _layered(plan: Plan, domain: Domain) -> bool:
    """Return whether the bodies have friction layers, whose step splits the measurement of every row in two."""
    contact = domain.contact
    return isinstance(plan.scene.friction, FrictionLayer) and contact is not None and len(contact.nodes) > 0


def _obstacles(plan: Plan, domain: Domain) -> int:
    """Count the bytes of the obstacles: their records, a row of records per step where they move, sampled distances."""
    obstacles = plan.scene.obstacles
    rows = 1
    if any(obstacle.moves and not obstacle.free for obstacle in obstacles):
        rows += domain.table_rows + 1
    grids = sum(0 if obstacle.grid is None else obstacle.grid.size for obstacle in obstacles)
    return REAL * (OBSTACLE * rows * len(obstacles) + grids)


def layer_bytes(scene: Scene, domain: Domain, pack: int = 8, solved: int = 128) -> int:
    """Count the bytes of the friction layers of a domain: their state and the space of their solve.

    pack: layers that stand together in memory; solved: largest number that is solved at once.
    """
    friction, total = scene.friction, 0
    if not isinstance(friction, FrictionLayer):
        return 0
    profiles = 3 + (friction.plastic_heat > 0.0)
    for kind, bodies in all_kinds(scene, domain.numbers).items():
        count = sum(int(np.diff(domain.contact_start)[domain.numbers.index(number)]) for number in bodies)
        padded, points = -(-count // pack) * pack, friction.points * len(kind.metals)
        numbers = 14 + len(kind.metals) - 1 + 2
        total += REAL * (padded * (points * profiles + numbers) + min(padded, solved) * points * 3)
    return total


def _force_pass(plan: Plan, domain: Domain, packs: CellPacks) -> int:
    nodes, boundary = len(domain.reference), len(domain.boundary)
    rows = 0
    if domain.small or boundary:
        rows = MAXIMUM_ROWS if domain.small and not _layered(plan, domain) else 1
    viscous = 0
    if domain.viscosity is not None:
        viscous = packs.all_chunks * group_size(*cell_groups(True)) + packs.lanes
    corners = (boundary + 1 + len(packs.corners)) * WHOLE if len(packs.corners) else 0
    width = group_size(*raw_groups(plan.scene, domain))
    averaged = sum(part.nbytes for part in volume_arrays(domain, packs) or ())
    return packs.nbytes + corners + nodes * 4 * REAL + (rows * width + viscous) * REAL + averaged


def _readable(size: int) -> str:
    return f"{size / 1e6:.3g} MB" if size >= 1e5 else f"{size / 1e3:.3g} kB"
