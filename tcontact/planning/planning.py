"""Plan a run: the terms of the scene, and for every body its numbering, masses and contact lists, as host data.

Nothing is planned for a term that the scene does not have.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..base.errors import InputError
from ..kernels.columns import (
    APPLIES,
    DAMPED,
    FREE_OBSTACLES,
    FRICTION,
    HEATED,
    HOURGLASS,
    LAYERS,
    LOADS,
    MISES_MAXIMUM,
    PAIRED,
    PLASTIC,
    PLASTIC_HOURGLASS,
    PRESSURE_MAXIMUM,
    PULLED,
    RIGID_BODIES,
    RIGID_PARTS,
    SPRINGS,
    VISCOUS,
)
from ..mesh.box_arrays import BoxMesh
from ..mesh.late_rows import Rows, rows_of
from ..mesh.mesh import Mesh
from ..scene.body import Body
from ..scene.contact_models import ImpulseContact, MasslessContact
from ..scene.friction_models import CELL_VISCOSITY, FrictionLayer
from ..scene.layer_metals import warms_bodies
from ..scene.scene import Scene
from .applied_loads import loaded_nodes
from .body_plan import FRICTION_TERMS, BodyPlan, ContactPlan
from .contact_graph import contact_graph
from .describe import describe
from .domain import Domain
from .domain_groups import domains_of
from .lumped_mass import NodeMasses, node_areas
from .measured import Layout, probe_columns
from .node_order import grid_order, inverse, lanes_apart, lowest_nodes, renumbered_late, slab_order
from .node_volumes import body_volumes
from .probe_places import probe_places
from .redistribution import redistribute
from .removal import JointRemoval, MasslessNodes, check_clusters, massless_nodes
from .rigid import RigidPlan, names_of, rigid_parts
from .springs import check_massless, spring_nodes
from .static_solver import check_poisson, static_solver


@dataclass(frozen=True)
class Plan:
    """The scene and one plan per body."""

    scene: Scene
    bodies: tuple[BodyPlan, ...]

    def __repr__(self) -> str:
        """Return the description of the plan."""
        return f"Plan\n{self.describe()}"

    @cached_property
    def domains(self) -> tuple[Domain, ...]:
        """Domains: groups of bodies that take their steps together."""
        return domains_of(self.scene, self.bodies)

    @property
    def contact_term(self) -> str | None:
        """Name of the contact term, or None if nothing can touch."""
        if not self.scene.touching:
            return None
        names = {MasslessContact: "massless-contact", ImpulseContact: "impulse-contact"}
        return names.get(type(self.scene.contact), "penalty-contact")

    @property
    def terms(self) -> tuple[str, ...]:
        """Names of the terms of the run."""
        found = dict.fromkeys(name for body in self.bodies for name in body.terms)
        if self.scene.springs:
            found["springs"] = None
        if self.contact_term:
            found[self.contact_term] = None
            if self.scene.friction is not None:
                found[FRICTION_TERMS[type(self.scene.friction)]] = None
            if any(body.viscous_cells for body in self.bodies):
                found["cell-viscosity"] = None
        if any(body.probes for body in self.scene.bodies):
            found["probes"] = None
        if self.scene.maxima:
            found["maxima"] = None
        if self.rigid:
            found["rigid-bodies"] = None
        return (*found, "ledger")

    @cached_property
    def layout(self) -> Layout:
        """Layout of the rows of its history."""
        scene, can_touch = self.scene, self.scene.touching
        blocks = [block for body in self.bodies for block in body.body.blocks]
        present = {
            HOURGLASS: any(block.formulation == "reduced" for block in blocks),
            PLASTIC: any(block.material.plastic for block in blocks),
            PLASTIC_HOURGLASS: any(block.material.plastic and block.formulation == "reduced" for block in blocks),
            VISCOUS: any(body.dissipates for body in self.bodies),
            FRICTION: can_touch and scene.friction is not None,
            LAYERS: can_touch and isinstance(scene.friction, FrictionLayer),
            HEATED: can_touch and isinstance(scene.friction, FrictionLayer) and warms_bodies(scene),
            LOADS: can_touch and scene.tracked,
            PAIRED: bool(scene.body_pairs),
            APPLIES: any(body.loads for body in scene.bodies),
            PULLED: callable(scene.gravity),
            SPRINGS: bool(scene.springs),
            MISES_MAXIMUM: "von_mises" in scene.maxima,
            PRESSURE_MAXIMUM: "pressure" in scene.maxima,
            RIGID_BODIES: bool(self.rigid),
            FREE_OBSTACLES: bool(names_of(self.rigid)["free"]),
            RIGID_PARTS: bool(names_of(self.rigid)["part"]),
        }
        names = tuple(scene.obstacle_label(i) for i in range(len(scene.obstacles))) if present[LOADS] else ()
        damping = [] if scene.damping is None else [DAMPED, scene.damping.name]
        pairs = tuple(pair.name for pair in scene.body_pairs)
        terms = [*damping, *(term for term, is_there in present.items() if is_there)]
        return Layout(terms, names, pairs, probe_columns(scene), names_of(self.rigid))

    @property
    def rigid(self) -> tuple[RigidPlan, ...]:
        """The rigid bodies of all domains."""
        return tuple(body for domain in self.domains for body in domain.rigid)

    @property
    def columns(self) -> tuple[str, ...]:
        """Columns of the history that depend on the terms of the scene."""
        return tuple(column.name for column in self.layout.shown if column.term)

    @property
    def factors(self) -> dict[str, float]:
        """Factors of the integrals over time of the damping, by the names of their columns."""
        return {} if self.scene.damping is None else self.scene.damping.factors

    def describe(self, scheme: Any = None) -> str:
        """Describe terms, sizes, kernels and bytes of the run; scheme: None = central difference.

        An implicit scheme names its equations, the solver of its linear systems and why it was chosen.
        """
        if getattr(scheme, "implicit", False):
            return str(scheme.describe(self))

        return describe(self)


def plan(scene: Scene) -> Plan:
    """Plan a scene: decide which terms, arrays and kernels its run has, and what they cost, without starting it.

    Returns a `Plan`: `describe()` is its text, `bodies` has the masses, removal and contact lists of every body. Raises
    `InputError` where the contact set cannot be made massless, and for options that the scene has no use for.
    """
    if not isinstance(scene, Scene):
        raise InputError("scene", scene, "give a tcontact.Scene")
    joint = JointRemoval(scene)
    planned = Plan(scene, tuple(_plan_body(scene, index, joint) for index in range(len(scene.bodies))))
    asked = scene.contact.cell_viscosity if isinstance(scene.contact, MasslessContact) else None
    massless = any(body.contact is not None and body.contact.graph is not None for body in planned.bodies)
    if asked and massless and not any(body.viscous_cells for body in planned.bodies):
        remedy = "contact cells are viscous only where friction meets removal='normal'; leave it at None"
        raise InputError("MasslessContact.cell_viscosity", asked, remedy)
    if isinstance(scene.contact, MasslessContact):
        for body in planned.bodies:
            if body.contact is not None and body.contact.graph is not None:
                if scene.contact.solver != "auto":
                    static_solver(scene, body)  # raises where the solver asked for does not apply
                check_poisson(scene, body)
    return planned


def _by_blocks(body: Body, order: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return the cells of a body in this order block after block, tetrahedra so that the lanes of packs stand apart.

    place [n]: number of every node in the plan.
    """
    mesh = body.mesh
    if len(body.blocks) > 1:
        rank = np.empty(mesh.cell_count, dtype=np.int64)
        for number, block in enumerate(body.blocks):
            rank[block.numbers] = number
        order = order[np.argsort(rank[order], kind="stable")]
    first = 0
    for block in body.blocks:
        own = order[first : first + block.count]
        if block.kind == "tet4":
            own[:] = own[lanes_apart(lowest_nodes(place, mesh.cell_rows, own, block.facts.corners))]
        first += len(own)
    return order


def _plan_body(scene: Scene, index: int, joint: JointRemoval) -> BodyPlan:
    body, label = scene.bodies[index], scene.label(index)
    mesh = body.mesh
    masses = NodeMasses(body)
    lumped = masses.total
    can_touch = scene.can_touch(index)
    node_order, cell_order = _order(mesh, _facing(scene, body) if can_touch and scene.obstacles else None)
    place = inverse(node_order)
    cell_order = _by_blocks(body, cell_order, place)
    driven = np.isfinite(body.prescribed)
    free = ~driven & ~body.tied[:, None]
    tensors: dict[str, np.ndarray] = {"nodes": np.zeros(0, dtype=np.int64), "values": np.zeros((0, 3, 3))}
    contact: ContactPlan | None = None
    massless: MasslessNodes | None = None
    if can_touch and isinstance(scene.contact, MasslessContact):
        massless = massless_nodes(scene, index, joint)
        if len(massless.nodes):
            check_clusters(body, massless, scene.label(index))
            massless = massless if body.images is None else massless.masters(body.images)
            moved = redistribute(masses, massless, free, scene.contact.depth)
            tensors = {"nodes": moved.nodes, "values": moved.tensors}
    cells = renumbered_late(place, mesh.cell_rows, cell_order)
    probes = probe_places(body)
    mesh.release()  # of a box: from here on cells have the numbering of the plan
    first = np.zeros(0, dtype=np.int64)
    if can_touch:
        contact = _plan_contact(body, massless, place, cells, cell_order, _cell_viscosity(scene))
        first = contact.nodes
    held = place[np.flatnonzero(~free.all(axis=1))]
    around = np.zeros(0, dtype=np.int64)  # nodes of contact cells: they sum up corner rows
    if contact is not None and contact.graph is not None:
        around = cells[contact.graph.cells].reshape(-1)
    loaded = place[loaded_nodes(body)]
    if callable(scene.gravity) and not len(loaded):
        loaded = np.zeros(1, dtype=np.int64)  # the data of a gravity that varies stand behind the loads of a node
    tied = place[spring_nodes(scene, index)]
    check_massless(scene, index, place, contact)
    special = np.unique(np.concatenate([first, place[tensors["nodes"]], held, around, loaded, tied]))
    boundary = np.concatenate([first, np.setdiff1d(special, first)]).astype(np.int64)
    images, total = None, lumped
    if body.images is not None:
        images, total = body.images.renumbered(node_order, place), body.images.total(lumped)
        boundary = images.boundary(first, special)
    mass = total[node_order[boundary]][:, None, None] * np.eye(3)
    row = np.full(mesh.node_count, -1)
    row[boundary] = np.arange(len(boundary))
    mass[row[place[tensors["nodes"]]]] = tensors["values"]
    free_here = free[node_order[boundary]]
    inverses = _inverses(mass, free_here, contact)
    gravity = scene.gravity_function.at(np.zeros(1))[0]
    rows, axes = np.nonzero(driven[node_order[boundary]])
    return BodyPlan(
        label=label,
        body=body,
        node_order=node_order,
        cell_order=cell_order,
        places=rows_of(mesh.node_rows, node_order),
        rows=cells,
        lumped=lumped[node_order],
        gravity=gravity,
        boundary=boundary,
        tensors=mass,
        inverses=inverses,
        loads=mass @ gravity,
        support_rows=rows,
        support_axes=axes,
        speeds=body.prescribed[node_order[boundary]][rows, axes],
        driven=_driven(body, node_order[boundary[rows]], axes),
        contact=contact,
        damping=scene.damping,
        viscosity=scene.viscosity,
        images=images,
        pulled=callable(scene.gravity),
        rigid=rigid_parts(body, label, lumped, mass, row[place]) if body.rigid_parts else (),
        probes=probes,
    )


def _facing(scene: Scene, body: Body) -> np.ndarray:
    """Return the normal [3] of the obstacle that is nearest to the contact nodes of a body, at its centre."""
    touching = body.initial_at(body.contact_nodes)
    nearest = min(scene.obstacles, key=lambda obstacle: float(obstacle.gap(touching).min()))
    centre = sum(places.sum(axis=0) for places in body.initial_portions()) / body.mesh.node_count
    return np.asarray(nearest.normal_at(centre[None])[0])


def _order(mesh: Mesh, facing: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the order of the nodes and of the cells of a mesh in the plan, see `slab_order`."""
    known = grid_order(mesh.lines, mesh.kind, facing) if isinstance(mesh, BoxMesh) else None
    return slab_order(mesh.nodes, mesh.cells, facing) if known is None else known


def _driven(body: Body, nodes: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Return for components [r] of the nodes the number of the axis that drives them, -1 without a function of time."""
    starts, count = {}, 0
    for support in body.driven:
        starts[id(support)] = count
        count += len(support.axes)
    numbers = [starts[id(support)] + motion.number if support.varies else -1 for support, motion in body.motions[1]]
    return np.array([*numbers, -1])[np.nan_to_num(body.motions[0][nodes, axes], nan=-1.0).astype(int)]


def _cell_viscosity(scene: Scene) -> float:
    """Return beta of contact cells with normal removal; 0 without friction."""
    if scene.friction is None or not isinstance(scene.contact, MasslessContact):
        return 0.0
    asked = scene.contact.cell_viscosity
    if asked is None:
        return CELL_VISCOSITY if scene.largest_friction > 0.0 else 0.0
    return float(asked)


def _plan_contact(
    body: Body,
    massless: MasslessNodes | None,
    place: np.ndarray,
    cells: Rows,
    cell_order: np.ndarray,
    viscosity: float,
) -> ContactPlan:
    """Make the contact lists of a body; viscosity: beta of its contact cells if the removal is normal."""
    areas = node_areas(body.mesh.node_rows, body.contact_faces)
    everyone, named = body.contact_nodes, cells
    nodes = everyone
    if body.images is not None:  # only masters are contact nodes
        areas = body.images.total(areas)
        nodes = np.unique(body.images.master[everyone])
        named = place[body.images.master][np.argsort(place)[np.asarray(cells)]]
    if massless is None:
        nodes = nodes[np.argsort(place[nodes])]
        return ContactPlan(place[nodes], np.sort(place[everyone]), areas[nodes])
    if len(massless.nodes) == 0:
        none = np.zeros(0)
        return ContactPlan(massless.nodes, np.sort(place[everyone]), none, massless.removal)
    internal = place[massless.nodes]
    order = np.argsort(internal)
    repeated = None if body.mesh.repeated is None else body.mesh.repeated[cell_order]
    volumes = body_volumes(body, cells, place)
    graph = contact_graph(named, internal[order], body.mesh.node_count, repeated, volumes)
    index = np.empty(body.mesh.node_count, dtype=np.int64)
    index[internal] = np.arange(len(internal))
    into = index[graph.nodes]
    block = 1 if (massless.rank == 1).all() else 3
    return ContactPlan(
        nodes=graph.nodes,
        all_nodes=np.sort(place[everyone]),
        areas=areas[massless.nodes][into],
        removal=massless.removal,
        basis=massless.basis[into],
        block=block,
        graph=graph,
        viscosity=viscosity if massless.removal == "normal" else 0.0,
    )


def _inverses(mass: np.ndarray, free: np.ndarray, contact: ContactPlan | None) -> np.ndarray:
    """Return the inverse mass on the components that are neither prescribed nor massless; zero on the others."""
    moving = free[:, :, None] * np.eye(3)
    if contact is not None and contact.basis is not None:
        moving[: len(contact.nodes)] -= np.einsum("kic,kjc->kij", contact.basis, contact.basis)
    result = np.zeros_like(mass)
    if len(mass):
        inside = moving @ mass @ moving
        values, vectors = np.linalg.eigh(inside)
        scale = np.abs(values).max(axis=1, keepdims=True)
        keep = values > 1e-6 * np.where(scale > 0, scale, 1.0)
        none = np.linalg.norm(moving, axis=(1, 2)) < 1e-6
        inverse = np.where(keep & ~none[:, None], 1.0 / np.where(keep, values, 1.0), 0.0)
        result = np.einsum("kia,ka,kja->kij", vectors, inverse, vectors)
        diagonal = np.abs(inside - inside * np.eye(3)).max(axis=(1, 2)) == 0.0  # keep axis-aligned masses exact
        entries = np.diagonal(inside, axis1=1, axis2=2)
        kept = (entries > 1e-6 * scale) & ~none[:, None]
        exact = np.where(kept, 1.0 / np.where(kept, entries, 1.0), 0.0)[:, :, None] * np.eye(3)
        result[diagonal] = exact[diagonal]
    return result
