"""What a scene needs: the terms that exist, and for every body its numbering, masses and contact lists. Host data only.

`plan(scene)` decides; terms allocate and launch. Nothing is planned for a term that the scene does not have.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from .contact_graph import ContactGraph, contact_graph, heirs
from .contact_models import ImpulseContact, MasslessContact
from .dissipation import BulkViscosity, Damping
from .elements import FORMULATIONS
from .errors import InputError
from .friction_models import Coulomb, FrictionLayer, RegularizedCoulomb, cell_viscosity
from .kernels.columns import DAMPED, FRICTION, HOURGLASS, LAYERS, LOADS, VISCOUS
from .lumped_mass import cell_masses, node_areas
from .measured import Layout
from .mesh_geometry import parallelepipeds
from .packing import slab_order
from .periodic import Images
from .redistribution import redistribute
from .removal import MasslessNodes, check_clusters, massless_nodes
from .scene import Body, Scene
from .static_solver import static_solver

if TYPE_CHECKING:
    from .domain import Domain

# up to so many cells one thread does the work, for a body many steps per launch
SMALL = {name: formulation.small for name, formulation in FORMULATIONS.items()}


FRICTION_TERMS: dict[type, str] = {
    Coulomb: "coulomb-friction",
    RegularizedCoulomb: "regularized-friction",
    FrictionLayer: "friction-layer",
}


@dataclass(frozen=True)
class ContactPlan:
    """Contact lists of one body, in its internal numbering.

    nodes [k]: contact nodes, the first rows of the boundary list; all_nodes: every node of the contact set (gaps);
    areas [k] [m^2]; for massless contact also basis [k, 3, 3], block (1 or 3 massless components a node), the graph and
    viscosity: beta of the contact cells, 0 without (METHOD 3).
    """

    nodes: np.ndarray
    all_nodes: np.ndarray
    areas: np.ndarray
    removal: str | None = None
    basis: np.ndarray | None = None
    block: int = 3
    graph: ContactGraph | None = None
    viscosity: float = 0.0


@dataclass(frozen=True)
class BodyPlan:
    """One body in its internal numbering: node i is node `node_order[i]` of the user, cell e is `cell_order[e]`.

    lumped [n] [kg]: ordinary lumped mass; boundary [s]: nodes with tensor mass, supports or contact; tensors and
    inverses [s, 3, 3]: their mass and its inverse on the components that move freely; loads [s, 3] [N]: gravity;
    support_rows, support_axes [r]: prescribed components; speeds [r] [m/s]; images: of a periodic body, whose masters
    alone have mass, loads and contact.
    """

    label: str
    body: Body
    node_order: np.ndarray
    cell_order: np.ndarray
    reference: np.ndarray
    cells: np.ndarray
    lumped: np.ndarray
    gravity: np.ndarray
    boundary: np.ndarray
    tensors: np.ndarray
    inverses: np.ndarray
    loads: np.ndarray
    support_rows: np.ndarray
    support_axes: np.ndarray
    speeds: np.ndarray
    contact: ContactPlan | None
    damping: Damping | None = None
    viscosity: BulkViscosity | None = None
    images: Images | None = None

    @property
    def small(self) -> bool:
        """Whether the body takes many steps per launch."""
        return len(self.cells) <= SMALL[self.element]

    @property
    def few_contact_cells(self) -> bool:
        """Whether there are massless contact cells, and so few that one thread does them."""
        graph = None if self.contact is None else self.contact.graph
        return graph is not None and len(graph.cells) <= SMALL[self.element]

    @property
    def viscous_cells(self) -> bool:
        """Whether its contact cells are viscous."""
        return self.contact is not None and self.contact.viscosity > 0.0

    @property
    def dissipates(self) -> bool:
        """Whether its rows have a viscous power."""
        return self.viscosity is not None or self.viscous_cells

    @property
    def mass(self) -> np.ndarray:
        """Mass tensors [n, 3, 3] [kg] of all nodes in the user's numbering, after redistribution."""
        result = self.lumped[:, None, None] * np.eye(3)
        result[self.boundary] = self.tensors
        return self.to_user(result)

    @cached_property
    def place(self) -> np.ndarray:
        """Internal number [n] of every node of the user."""
        return np.argsort(self.node_order)

    def to_user(self, values: np.ndarray) -> np.ndarray:
        """Values [n, ...] of the nodes as the user numbers them, in an array of their own."""
        return np.take(values, self.place, axis=0)  # four times as fast as an index in brackets

    @property
    def element(self) -> str:
        """Name of the element its kernels are made for: the kind of its cells and, but for "full", the formulation."""
        return self.body.element

    @cached_property
    def variant(self) -> str:
        """The element with what its kernels may use: "-affine" where it helps that all cells are parallelepipeds."""
        differ = FORMULATIONS[self.element].affine is not None
        return self.element + "-affine" if differ and parallelepipeds(self.reference, self.cells) else self.element

    @property
    def options(self) -> dict[str, Any]:
        """What its kernels are made with besides the ordinary step; empty without."""
        found: dict[str, Any] = {} if self.damping is None else {"damped": self.damping.name}
        return found if self.viscosity is None else {**found, "viscous": True}

    @property
    def heirs(self) -> tuple[np.ndarray, np.ndarray]:
        """Who takes what the static solve leaves unbalanced, as `contact_graph.heirs`."""
        assert self.contact is not None
        count = len(self.contact.nodes)
        if self.images is None:
            return heirs(self.cells, self.reference, self.boundary, count)
        rows = np.flatnonzero(self.images.master[self.boundary] == self.boundary)
        start, own = heirs(self.images.master[self.cells], self.reference, self.boundary[rows], count)
        return start, rows[own]

    @property
    def terms(self) -> tuple[str, ...]:
        """Names of the physics this body has."""
        names = ["internal-force"]
        if self.images is not None:
            names.append("periodic")
        if self.gravity.any():
            names.append("gravity")
        if len(self.support_rows):
            names.append("supports")
        if self.damping is not None:
            names.append(self.damping.name)
        if self.viscosity is not None:
            names.append("bulk-viscosity")
        return tuple(names)


@dataclass(frozen=True)
class Plan:
    """The scene and one plan per body."""

    scene: Scene
    bodies: tuple[BodyPlan, ...]

    @cached_property
    def domains(self) -> tuple[Domain, ...]:
        """The bodies in the groups that take their steps together."""
        from .domain import domains_of

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
        """Names of the physics that will be built."""
        found = dict.fromkeys(name for body in self.bodies for name in body.terms)
        if self.contact_term:
            found[self.contact_term] = None
            if self.scene.friction is not None:
                found[FRICTION_TERMS[type(self.scene.friction)]] = None
            if any(body.viscous_cells for body in self.bodies):
                found["cell-viscosity"] = None
        return (*found, "ledger")

    @cached_property
    def layout(self) -> Layout:
        """Of the rows of its history."""
        scene, touching = self.scene, self.scene.touching
        present = {
            HOURGLASS: any(body.body.formulation == "reduced" for body in self.bodies),
            VISCOUS: any(body.dissipates for body in self.bodies),
            FRICTION: touching and scene.friction is not None,
            LAYERS: touching and isinstance(scene.friction, FrictionLayer),
            LOADS: touching and scene.tracked,
        }
        names = tuple(scene.obstacle_label(i) for i in range(len(scene.obstacles))) if present[LOADS] else ()
        damping = [] if scene.damping is None else [DAMPED, scene.damping.name]
        return Layout([*damping, *(term for term, is_there in present.items() if is_there)], names)

    @property
    def columns(self) -> tuple[str, ...]:
        """Columns of the history that only such a scene has."""
        return tuple(column.name for column in self.layout.shown if column.term)

    @property
    def factors(self) -> dict[str, float]:
        """Factors of integrals over time in the history, by the names of their columns."""
        return {} if self.scene.damping is None else self.scene.damping.factors

    def describe(self, scheme: Any = None) -> str:
        """Terms, sizes, kernels and bytes of the run, before anything is allocated; scheme: None = central difference.

        An implicit scheme names its equations, the solver of its linear systems and why that one.
        """
        if getattr(scheme, "implicit", False):
            return str(scheme.describe(self))
        from .describe import describe

        return describe(self)


def plan(scene: Scene) -> Plan:
    """Decide what exists for the scene. Raises `InputError` where the contact set cannot be made massless."""
    if not isinstance(scene, Scene):
        raise InputError("scene", scene, "give a tcontact.Scene")
    planned = Plan(scene, tuple(_plan_body(scene, body, scene.label(i)) for i, body in enumerate(scene.bodies)))
    asked = scene.contact.cell_viscosity if isinstance(scene.contact, MasslessContact) else None
    massless = any(body.contact is not None and body.contact.graph is not None for body in planned.bodies)
    if asked and massless and not any(body.viscous_cells for body in planned.bodies):
        remedy = "contact cells are viscous where friction meets removal='normal' alone; leave it at None"
        raise InputError("MasslessContact.cell_viscosity", asked, remedy)
    if isinstance(scene.contact, MasslessContact) and scene.contact.solver != "auto":
        for body in planned.bodies:
            if body.contact is not None and body.contact.graph is not None:
                static_solver(scene, body)  # refuses what it cannot solve
    return planned


def _plan_body(scene: Scene, body: Body, label: str) -> BodyPlan:
    mesh = body.mesh
    masses = cell_masses(mesh, body.material.density)
    lumped = np.zeros(mesh.node_count)
    np.add.at(lumped, mesh.cells, masses)
    touching = scene.touching and body.touches
    facing = None
    if touching:
        start = body.initial_nodes
        nearest = min(scene.obstacles, key=lambda obstacle: float(obstacle.gap(start[body.contact_nodes]).min()))
        facing = nearest.normal_at(start.mean(axis=0)[None])[0]
    node_order, cell_order = slab_order(mesh.nodes, mesh.cells, facing)
    place = np.empty(mesh.node_count, dtype=np.int64)
    place[node_order] = np.arange(mesh.node_count)
    free = np.isnan(body.prescribed)
    tensors: dict[str, np.ndarray] = {"nodes": np.zeros(0, dtype=np.int64), "values": np.zeros((0, 3, 3))}
    contact: ContactPlan | None = None
    massless: MasslessNodes | None = None
    if touching and isinstance(scene.contact, MasslessContact):
        massless = massless_nodes(scene, body)
        if len(massless.nodes):
            check_clusters(body, massless)
            massless = massless if body.images is None else massless.masters(body.images)
            moved = redistribute(mesh, masses, massless, free, scene.contact.depth, body.images)
            tensors = {"nodes": moved.nodes, "values": moved.tensors}
    cells = place[mesh.cells[cell_order]]
    first = np.zeros(0, dtype=np.int64)
    if touching:
        contact = _plan_contact(body, massless, place, cells, _cell_viscosity(scene))
        first = contact.nodes
    held = place[np.flatnonzero(~free.all(axis=1))]
    special = np.unique(np.concatenate([first, place[tensors["nodes"]], held]))
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
    gravity = np.zeros(3) if scene.gravity is None else np.asarray(scene.gravity)
    rows, axes = np.nonzero(~free_here)
    return BodyPlan(
        label=label,
        body=body,
        node_order=node_order,
        cell_order=cell_order,
        reference=mesh.nodes[node_order],
        cells=cells,
        lumped=lumped[node_order],
        gravity=gravity,
        boundary=boundary,
        tensors=mass,
        inverses=inverses,
        loads=mass @ gravity,
        support_rows=rows,
        support_axes=axes,
        speeds=body.prescribed[node_order[boundary]][rows, axes],
        contact=contact,
        damping=scene.damping,
        viscosity=scene.viscosity,
        images=images,
    )


def _cell_viscosity(scene: Scene) -> float:
    given = scene.contact.cell_viscosity if isinstance(scene.contact, MasslessContact) else 0.0
    return cell_viscosity(given, scene.friction)


def _plan_contact(
    body: Body, massless: MasslessNodes | None, place: np.ndarray, cells: np.ndarray, viscosity: float
) -> ContactPlan:
    """viscosity: beta of the contact cells where the removal is normal."""
    areas = node_areas(body.mesh.nodes, body.contact_faces)
    everyone, named = body.contact_nodes, cells
    touching = everyone
    if body.images is not None:  # the masters stand for all
        areas = body.images.total(areas)
        touching = np.unique(body.images.master[everyone])
        named = place[body.images.master][np.argsort(place)[cells]]
    if massless is None:
        touching = touching[np.argsort(place[touching])]
        return ContactPlan(place[touching], np.sort(place[everyone]), areas[touching])
    if len(massless.nodes) == 0:
        none = np.zeros(0)
        return ContactPlan(massless.nodes, np.sort(place[everyone]), none, massless.removal)
    internal = place[massless.nodes]
    order = np.argsort(internal)
    graph = contact_graph(named, internal[order], body.mesh.node_count)
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
    """Inverse mass on the components that are neither prescribed nor massless; zero on the others."""
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
