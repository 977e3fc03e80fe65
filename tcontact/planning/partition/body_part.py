"""The part of a body that one rank has: the same body with fewer cells, in the numbering of a mesh of its own.

    a_i = (w_i - sum_r f_i^r) / m_i,       f_i^r: force of the cells of part r

A node on a cut has a copy in every part with a cell at it, and there it is a boundary node, whose force other ranks add
to. Every copy has the whole mass m_i and weight w_i of the node, adds the forces of all ranks in one order, and so
moves with the bits of all others; the ledger counts the copy of the lowest rank alone. What acts on a body (contact,
loads, springs, rigid parts, driven supports) acts on nodes that the first rank alone has, so that its lists are those
of the whole plan in another numbering; components that are held at a constant velocity may be on any rank.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from ...mesh.elements import ELEMENTS, MIXED
from ...mesh.mesh import Mesh
from ...mesh.mixed_cells import in_rows
from ...mesh.ordered_mesh import Facts, Ordered, OrderedMesh
from ...mesh.parts import Sets, part_of
from ...scene.body import Body
from ...scene.cell_blocks import blocks_of
from ...scene.periodic import Images
from ..applied_loads import loaded_nodes
from ..body_plan import BodyPlan, ContactPlan, held_nodes
from ..lumped_mass import NodeMasses
from ..node_order import inverse, lanes_apart, lowest_nodes, renumbered
from ..probe_places import ProbePlace
from .graph_part import graph_part
from .parts import Part
from .shared_contact import BodyShare

ACTING = ("supports", "loads", "point_masses", "springs", "probes", "rigid_parts")


@dataclass(frozen=True, eq=False)
class BodyPart:
    """What one rank has of a body.

    whole: plan of the whole body, or its outline (outline.py); part: its cells and nodes in the mesh; plan: of the
    part, without nodes where it has no cells of the body; its `lumped` is that of its own cells; nodes [n]: numbers of
    the nodes of `plan` in `whole`, ascending; shared: for every other rank with copies, ascending, the boundary nodes
    [k] of `plan`, in the order of both; mass [n] [kg]: whole mass of its nodes.
    """

    whole: Any
    part: Part
    plan: BodyPlan
    nodes: np.ndarray
    shared: tuple[tuple[int, np.ndarray], ...]
    mass: np.ndarray


def acting_nodes(plan: BodyPlan, tied: np.ndarray, touching: bool = True) -> np.ndarray:
    """Return the nodes [k] of the mesh, ascending, that the first rank must have.

    Something acts on them beside the cells, constant gravity and supports that no function of time drives.
    tied: nodes of the mesh that springs of the scene connect; touching: contact is part of it, and so are the nodes
    that have the mass of contact nodes; else only those of the contact set that supports hold, whose gaps it measures.
    """
    body, inside = plan.body, np.zeros(plan.node_count, dtype=bool)
    rows = np.setdiff1d(np.arange(len(plan.boundary)), _plainly_held(plan))
    if not touching:
        driven = plan.support_rows[plan.driven >= 0]
        rows = np.unique(np.concatenate([driven, *(rigid.nodes for rigid in plan.rigid)])).astype(np.int64)
        if plan.contact is not None and plan.contact.graph is not None:
            inside[held_nodes(plan.contact)] = True
    inside[plan.boundary[rows]] = True
    if touching and plan.contact is not None:
        inside[plan.contact.all_nodes] = True
        if plan.contact.graph is not None:
            inside[plan.rows[plan.contact.graph.cells]] = True
    found = [plan.node_order[inside], tied, loaded_nodes(body)]
    found += [body.mesh.nodes_of(point.set) for point in body.point_masses]
    return np.unique(np.concatenate(found)).astype(np.int64)


def _plainly_held(plan: BodyPlan) -> np.ndarray:
    """Return the boundary nodes with supports that no function of time drives, and with their ordinary mass."""
    ordinary = plan.lumped[plan.boundary][:, None, None] * np.eye(3)
    same = (plan.tensors == ordinary).all(axis=(1, 2))
    held = np.setdiff1d(plan.support_rows, plan.support_rows[plan.driven >= 0])
    held = held[same[held]]
    if plan.images is not None:
        held = held[~np.isin(plan.boundary[held], plan.images.members)]
    for rigid in plan.rigid:
        held = np.setdiff1d(held, rigid.nodes)
    return held


def body_part(plan: BodyPlan, part: Part, acts: bool, share: BodyShare | None = None, shared: bool = False) -> BodyPart:
    """Return what one rank has of a planned body.

    acts: it has all nodes on which something acts, and the contact, unless ranks share it; shared: they do; share: what
    this rank has of it then.
    """
    body = _part_of_body(plan.body, part, acts, share is not None)
    nodes = np.sort(plan.place[part.nodes]).astype(np.int32)
    node_order = np.searchsorted(part.nodes, plan.node_order[nodes]).astype(np.int32)
    place, number = inverse(node_order), np.full(plan.node_count, -1, dtype=np.int64)
    number[nodes] = np.arange(len(nodes))
    touching = np.zeros(0, dtype=np.int64)
    graph = None if plan.contact is None else plan.contact.graph
    if graph is not None and (share is not None or (acts and not shared)):
        cells = graph.cells if share is None else graph.cells[share.cells]
        touching = np.searchsorted(part.cells, plan.cell_order[cells])
    inside = np.zeros(len(plan.cell_order), dtype=bool)
    inside[part.cells] = True
    kept = plan.cell_order[inside[plan.cell_order]]
    cell_order = _cell_order(body, np.searchsorted(part.cells, kept), place, touching).astype(np.int32)
    lumped = plan.lumped[nodes].copy()
    copies = np.sort(place[part.copies])
    lumped[copies] = NodeMasses(body).total[node_order[copies]]
    images = None
    mass = plan.lumped if plan.images is None else plan.images.total(plan.lumped)
    if acts and plan.images is not None:
        images = Images(number[plan.images.master[nodes]], plan.images.period)
    kept_rows = np.flatnonzero(number[plan.boundary] >= 0)  # those of the whole plan, in their order
    if share is not None and plan.contact is not None:
        kept_rows = np.concatenate([share.nodes, kept_rows[kept_rows >= len(plan.contact.nodes)]])
    old = number[plan.boundary[kept_rows]]
    more = np.setdiff1d(copies, old)
    if plan.pulled and not len(old) and not len(more):
        more = np.zeros(1, dtype=np.int64)  # as in planning.py: the data of the gravity stand behind its load
    boundary = np.concatenate([old, more])
    own = mass[nodes[more]][:, None, None] * np.eye(3)
    row_of = np.full(len(plan.boundary), -1, dtype=np.int64)
    row_of[kept_rows] = np.arange(len(kept_rows))
    counted = part.owner[node_order] == part.rank  # the reaction of a support is that of one copy
    mine = row_of[plan.support_rows] >= 0
    mine[mine] = counted[boundary[row_of[plan.support_rows[mine]]]]
    ordered = Ordered(plan.places[nodes], renumbered(place, body.mesh.cells, cell_order), node_order, cell_order)
    found = replace(
        plan,
        body=with_mesh(body, OrderedMesh.of(ordered, Facts.of(body.mesh))),
        node_order=node_order,
        cell_order=cell_order,
        places=ordered.places,
        rows=ordered.rows,
        lumped=lumped,
        boundary=boundary,
        tensors=np.concatenate([plan.tensors[kept_rows], own]),
        inverses=np.concatenate([plan.inverses[kept_rows], _inverted(own)]),
        loads=np.concatenate([plan.loads[kept_rows], own @ plan.gravity]),
        support_rows=row_of[plan.support_rows[mine]],
        support_axes=plan.support_axes[mine],
        speeds=plan.speeds[mine],
        driven=plan.driven[mine],
        rigid=tuple(replace(one, nodes=row_of[one.nodes]) for one in plan.rigid) if acts else (),
        contact=_contact(plan.contact, number, inverse(cell_order.astype(np.int64))[touching], share)
        if share is not None or (acts and not shared)
        else None,
        images=images,
        probes=_probes(plan, part),
    )
    row = np.full(len(nodes), -1, dtype=np.int64)
    row[boundary] = np.arange(len(boundary))
    copied = tuple((other, row[place[places]]) for other, places in part.shared)
    return BodyPart(plan, part, found, nodes, copied, mass[nodes])


def _inverted(mass: np.ndarray) -> np.ndarray:
    """Return the inverse of mass tensors [k, 3, 3] of ordinary nodes."""
    return np.eye(3) / mass[:, 0, :1, None]


def no_part(plan: BodyPlan, rank: int) -> BodyPart:
    """Return the part of a rank without cells of the body: its plan has no nodes."""
    none = np.zeros(0, dtype=np.int64)
    empty = {name: getattr(plan, name)[:0] for name in ("node_order", "cell_order", "places", "rows", "lumped")}
    empty |= {name: getattr(plan, name)[:0] for name in ("boundary", "tensors", "inverses", "loads", "speeds")}
    empty |= dict.fromkeys(("support_rows", "support_axes", "driven"), none)
    part = Part(rank, none, none, none, ())
    found = replace(plan, **empty, contact=None, images=None, rigid=(), probes=_probes(plan, part))
    found.__dict__["blocks"] = ()  # those of its body are the blocks of the whole mesh
    return BodyPart(plan, part, found, none, (), np.zeros(0))


def _probes(plan: BodyPlan, part: Part) -> tuple[ProbePlace, ...]:
    """Return what a part has of the probes: its cells, and the nodes that it owns."""
    cells, nodes = (part.cells, np.ones(len(part.cells), dtype=bool)), (part.nodes, part.owner == part.rank)
    return tuple(place.part(*(cells if place.probe.facts.of_cells else nodes)) for place in plan.probes)


def _part_of_body(body: Body, part: Part, acts: bool, touches: bool) -> Body:
    """Return the body with the cells of a part; its checks are those of the whole body, which has passed them.

    acts: with all that acts on it; touches: with a part of its contact.
    """
    mesh = body.mesh
    node_sets, face_sets = (dict(own) if acts else {} for own in (mesh.node_sets, mesh.face_sets))
    smaller = _mesh_of(mesh, part, node_sets, face_sets)
    return body_of(body, smaller, part.nodes, acts, touches)


def body_of(body: Body, smaller: Mesh, nodes: np.ndarray, acts: bool, touches: bool) -> Body:
    """Return the body with the mesh of a part, which has these nodes [n] of its own; acts, touches: as above."""
    given = {field.name: getattr(body, field.name) for field in fields(Body)}
    given |= {"mesh": smaller, "velocity": _rows(body.initial_velocity, nodes)}
    given |= {"displacement": _rows(body.initial_displacement, nodes)}
    if isinstance(body.material, Mapping):
        given["material"] = {name: one for name, one in body.material.items() if name in smaller.cell_sets}
    faces, images = body.contact_faces[:0], None
    motions: tuple[np.ndarray, tuple[Any, ...]] = np.broadcast_to(np.nan, (len(nodes), 3)), ()
    if acts or touches:
        faces = np.searchsorted(nodes, body.contact_faces)
        there = nodes[np.minimum(faces, len(nodes) - 1)] == body.contact_faces
        faces = faces[there.all(axis=1)]
        if acts and body.images is not None:
            images = Images(np.searchsorted(nodes, body.images.master[nodes]), body.images.period)
    if acts:
        motions = _rows(body.motions[0], nodes), body.motions[1]
    else:
        given |= dict.fromkeys(ACTING, ()) | dict.fromkeys(("periodic",) if touches else ("contact", "periodic"))
    result = object.__new__(Body)
    result.__dict__.update(given)
    result.__dict__.update(
        contact_faces=faces,
        images=images,
        motions=motions,
        initial_velocity=given["velocity"],
        initial_displacement=given["displacement"],
        spring_speed=body.spring_speed,
        blocks=blocks_of(smaller, given["material"], given["formulation"]) if smaller.cell_count else (),
    )
    return result


def with_mesh(body: Body, mesh: Mesh) -> Body:
    """Return the body with another mesh that is equal to its own."""
    result = copy(body)
    blocks = tuple(replace(block, mesh=mesh) for block in body.blocks)
    result.__dict__.update(mesh=mesh, blocks=blocks)
    return result


def _rows(values: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Return rows of values [n, 3]; a view where all rows are one."""
    return np.broadcast_to(values[0], (len(numbers), 3)) if values.strides[0] == 0 else values[numbers]


def _mesh_of(mesh: Mesh, part: Part, node_sets: Sets, face_sets: Sets) -> Mesh:
    """Return the mesh of a part with these sets of the whole; nodes that are there without cells stand in none.

    It is not checked, as the whole mesh has been.
    """
    if not len(part.cells):
        kind = mesh.cell_counts[0][0]
        none = np.zeros((0, ELEMENTS[kind].corners), dtype=np.int64)
        return Mesh.trusted(mesh.nodes_at(part.nodes), none, kind, {}, {})
    given = part_of(mesh, node_sets, face_sets, mesh.cell_sets, part.cells)
    nodes, cells, kind = given["nodes"], given["cells"], given.get("kind", MIXED)
    cells = in_rows(tuple(cells.items())) if kind == MIXED else cells
    of_nodes, of_faces, of_cells = (given[name] for name in ("node_sets", "face_sets", "cell_sets"))
    if len(nodes) < len(part.nodes):
        used = np.zeros(mesh.node_count, dtype=bool)
        for _, rows in mesh.chosen_cells(part.cells):
            used[rows] = True
        place = np.flatnonzero(used[part.nodes])
        nodes, cells = mesh.nodes_at(part.nodes), place[cells]
        of_nodes, of_faces = ({name: place[ids] for name, ids in own.items()} for own in (of_nodes, of_faces))
    return Mesh.trusted(nodes, cells, kind, of_nodes, of_faces, of_cells)


def _cell_order(body: Body, order: np.ndarray, place: np.ndarray, touching: np.ndarray) -> np.ndarray:
    """Return the cells of a part block after block, in this order [m]; tetrahedra as in planning.py.

    place [n]: number of every node in the plan; touching [c]: contact cells, which keep their order.
    """
    rank, contact = np.zeros(len(order), dtype=np.int64), np.zeros(len(order), dtype=bool)
    for number, block in enumerate(body.blocks):
        rank[block.numbers] = number
    contact[touching] = True
    found = [order[:0]]
    for number, block in enumerate(body.blocks):
        own = order[rank[order] == number]
        free, held = own[~contact[own]], own[contact[own]]
        if block.kind == "tet4" and len(free):
            free = free[lanes_apart(lowest_nodes(place, body.mesh.cell_rows, free, block.facts.corners))]
        found.append(np.concatenate([free, held]) if block.kind == "tet4" else own)
    return np.concatenate(found)


def _contact(
    contact: ContactPlan | None, number: np.ndarray, cells: np.ndarray, share: BodyShare | None
) -> ContactPlan | None:
    """Return contact lists in the numbering of a part; number [n]: of every node there; cells [c]: contact cells."""
    if contact is None:
        return None
    graph = contact.graph
    if share is not None:
        nodes, everyone = number[contact.nodes[share.nodes]], number[contact.all_nodes]
        if graph is not None:
            none = np.zeros(0, dtype=np.int64)
            graph, _ = graph_part(graph, share.nodes, np.zeros(len(share.nodes), dtype=bool), none, share.cells)
            graph = replace(graph, nodes=nodes, cells=cells)
        return replace(
            contact,
            nodes=nodes,
            all_nodes=everyone[everyone >= 0],
            areas=contact.areas[share.nodes],
            basis=None if contact.basis is None else contact.basis[share.nodes],
            graph=graph,
        )
    if graph is not None:
        graph = replace(graph, nodes=number[graph.nodes], cells=cells)
    return replace(contact, nodes=number[contact.nodes], all_nodes=number[contact.all_nodes], graph=graph)
