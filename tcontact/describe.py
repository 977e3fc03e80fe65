"""A plan in words: terms, sizes, kernels and bytes, before anything is allocated."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .elements import FORMULATIONS
from .friction_models import FrictionLayer, FrictionModel
from .kernels.lanes import FRICTION_NODE, FRICTION_TRACE, MOST_SLOTS, OBSTACLE, RAW, VISCOUS_HELD, VISCOUS_SUMS
from .packing import WIDTH, append_own_rows, pack_cells
from .plan import FRICTION_TERMS
from .sweep_order import sweep_order
from .terms.contact import MOST_ROWS

if TYPE_CHECKING:
    from .plan import BodyPlan, Plan

REAL, WHOLE = 8, 4  # bytes of a number
SYMMETRIC = 6


def describe(plan: Plan) -> str:
    """Terms of the run, then for every body what it is made of, the kernels it launches and the bytes they work on."""
    lines = ["terms: " + ", ".join(plan.terms)]
    for body in plan.bodies:
        lines.append(_body(body))
        lines.append("  kernels: " + ", ".join(kernels(plan, body)))
        sizes = [f"{name} {_readable(size)}" for name, size in memory(plan, body).items()]
        lines.append("  memory: " + ", ".join(sizes))
    return "\n".join(lines)


def _body(body: BodyPlan) -> str:
    mesh = body.body.mesh
    line = f"{body.label}: {mesh.cell_count} {body.element} cells, {mesh.node_count} nodes, {body.body.material.law}"
    way = FORMULATIONS[body.element]
    line += f" ({way.integration if body.variant == body.element else way.affine})"
    if len(body.boundary):
        line += f", {len(body.boundary)} nodes with their own mass tensor, support or contact"
    contact = body.contact
    if contact is not None:
        line += f"; {len(contact.nodes)} contact nodes"
        if contact.graph is not None:
            line += (
                f" without mass ({contact.removal} removal, {contact.block} components a node,"
                f" {len(contact.graph.cells)} contact cells, {contact.graph.colours} colours)"
            )
    return line


def kernels(plan: Plan, body: BodyPlan) -> list[str]:
    """The kernels a step of the body launches, each with what it does in one launch."""
    law = body.body.material.law
    beside = [] if body.images is None else ["images of periodic nodes"]
    if body.contact is not None:
        massless = body.contact.graph is not None
        load = {"penalty-contact": "penalty load", "impulse-contact": "impulse load"}.get(
            plan.contact_term or "", "gaps"
        )
        beside.append("massless load, prediction" if massless else load)
        if body.few_contact_cells and not body.small:  # else a pass of the other kernel or of this one
            beside.append("contact cells")
        if body.viscous_cells:
            beside.append("viscosity of the contact cells")
        if massless:
            beside.append("static solve")
        if plan.scene.friction is not None and len(body.contact.nodes):
            beside.append("friction")
    if len(body.support_rows):
        beside.append("support reactions")
    if len(body.boundary) and body.damping is not None:
        beside.append("damping of the boundary nodes")
    if len(body.boundary):
        beside.append("kick and drift of the boundary nodes")
    layers = _layered(plan, body)
    if body.small:
        parts = ", ".join([*body.options, "force pass", *beside]) + ("" if layers else "; many steps a launch")
        names = [f"serial_step({body.variant}, {law}: {parts})"]
    else:
        names = [f"step({', '.join([body.variant, law, *body.options])})"]
        names += [f"serial_step({', '.join(beside)})"] if beside else []
        if body.viscous_cells and not body.few_contact_cells:
            names.append(f"viscous_pass({body.variant}, {law})")
    return [*names, "layer"] if layers else names


def memory(plan: Plan, body: BodyPlan) -> dict[str, int]:
    """Bytes by term that the body will take, as in `Result.memory`."""
    nodes = len(body.reference)
    listed = len(body.boundary)
    result = {"state": 2 * 3 * REAL * nodes, "internal-force": _force_pass(body, nodes, _layered(plan, body))}
    if listed:
        result["boundary-nodes"] = listed * (WHOLE + REAL * (2 * SYMMETRIC + 3 + 3))
    if len(body.support_rows):
        result["supports"] = len(body.support_rows) * (2 * WHOLE + REAL)
    if body.images is not None:
        result["periodic"] = 2 * WHOLE * len(body.images.followers)
    contact = body.contact
    if contact is not None:
        slots, count = min(len(plan.scene.obstacles), MOST_SLOTS), len(contact.nodes)
        size = count * (WHOLE + slots * WHOLE + 2 * 3 * REAL) + len(contact.all_nodes) * (WHOLE + 24)
        size += _obstacles(plan, body)
        if contact.graph is not None:
            graph, block = contact.graph, contact.block
            order = sweep_order(graph, block)  # padded to lanes
            size += count * REAL * (3 * block + 1 + 3 * block + block * block + slots * (1 + block) + 2)
            size += len(body.heirs[1]) * WHOLE
            size += order.column.size * (WHOLE + REAL * block * block) + len(graph.column) * 3 * WHOLE
            size += len(graph.pair_nodes) * (4 * WHOLE + REAL * block * block) + len(graph.entry_pairs) * WHOLE
            corners = graph.cells.size * body.cells.shape[1]
            size += corners * WHOLE + (corners + listed if body.viscous_cells else len(graph.corners)) * WHOLE
            size += 8 * body.cells.shape[1] * 3 * REAL
        result[plan.contact_term or "contact"] = size
        if body.viscous_cells and contact.graph is not None:
            lanes = -(-contact.graph.cells.size // WIDTH) * WIDTH
            result["cell-viscosity"] = REAL * (8 + 6 * listed + lanes * (1 + 3 * body.cells.shape[1]))
        if plan.scene.friction is not None and count:
            stays = contact.graph is not None and contact.block > 1
            per_slot = FRICTION_TRACE if stays else 1
            size = REAL * (3 + count * (FRICTION_NODE + slots * per_slot))
            result[FRICTION_TERMS[type(plan.scene.friction)]] = size + _layers(plan.scene.friction, count)
    return result


def _layered(plan: Plan, body: BodyPlan) -> bool:
    """Whether the body has friction layers, which take their step between the two parts of every row."""
    contact = body.contact
    return isinstance(plan.scene.friction, FrictionLayer) and contact is not None and len(contact.nodes) > 0


def _obstacles(plan: Plan, body: BodyPlan) -> int:
    """Records of the obstacles, rows of them while they move, and grids of distances."""
    obstacles = plan.scene.obstacles
    rows = 1
    if plan.scene.moving:
        rows += (MOST_ROWS if body.small else 1) + 1
    grids = sum(0 if obstacle.grid is None else obstacle.grid.size for obstacle in obstacles)
    return REAL * (OBSTACLE * rows * len(obstacles) + grids)


def _layers(friction: FrictionModel, count: int) -> int:
    """State of `count` friction layers and the space to solve them in."""
    if not isinstance(friction, FrictionLayer):
        return 0
    padded = -(-count // 8) * 8
    profiles = 3 + (friction.plastic_heat > 0.0)
    return REAL * (padded * (friction.points * profiles + 14 + 2) + min(padded, 128) * friction.points * 3)


def _force_pass(body: BodyPlan, nodes: int, layered: bool) -> int:
    packs = pack_cells(body.cells, nodes, WIDTH)
    if body.contact is not None and body.contact.graph is not None:
        packs = append_own_rows(packs, body.cells[body.contact.graph.cells]).packs
    rows = 0
    if body.small or len(body.boundary):
        rows = MOST_ROWS if body.small and not layered else 1
    viscous = 0 if body.viscosity is None else VISCOUS_HELD + packs.connectivity.size // packs.corners
    width = RAW + VISCOUS_SUMS * (body.viscosity is not None)
    return packs.nbytes + nodes * 4 * REAL + (rows * width + viscous) * REAL


def _readable(size: int) -> str:
    return f"{size / 1e6:.3g} MB" if size >= 1e5 else f"{size / 1e3:.3g} kB"
