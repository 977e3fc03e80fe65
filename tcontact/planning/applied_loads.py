"""Pack the loads of a domain for the kernels (kernels/load_places.py): shares of nodes and faces, and functions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..kernels.load_places import (
    ASKS,
    ENTRIES,
    ENTRY,
    FACE,
    FACES,
    HEAD,
    NODE,
    NODES,
    PULLS,
    STRIDE,
)
from ..mesh.mesh import Mesh
from ..scene.body import Body
from ..scene.loads import Load
from ..scene.periodic import Images
from ..scene.time_functions import TimeFunction
from .body_plan import BodyPlan
from .domain import Domain
from .lumped_mass import node_areas


@dataclass(frozen=True, eq=False)
class Shares:
    """Shares of the nodes of a body in a load, in the numbering of the mesh.

    nodes [k], weights [k] [m^2 or 1] and groups [k]: the value of the load that they multiply; faces [f, 4] under a
    pressure, with their groups [f].
    """

    nodes: np.ndarray
    weights: np.ndarray
    groups: np.ndarray
    faces: np.ndarray
    face_groups: np.ndarray


@dataclass(frozen=True, eq=False)
class OwnForce:
    """An own force of a body: its nodes [k] in the domain and the place of its numbers in a row."""

    load: Load
    nodes: np.ndarray
    place: int


@dataclass(frozen=True, eq=False)
class PackedLoads:
    """Data of the loads of a domain.

    data: head, nodes, entries, faces and rows of kernels/load_places.py; table: where the rows begin there; width:
    numbers of a row; rows: number of rows; functions: values of a row, each with its place; own: own forces.
    """

    data: np.ndarray
    table: int
    width: int
    rows: int
    functions: tuple[tuple[TimeFunction, int], ...]
    own: tuple[OwnForce, ...]


def shares_of(load: Load, mesh: Mesh, images: Images | None) -> Shares:
    """Return the shares of the nodes of a mesh in a load; images: of a periodic body."""
    none, zero = np.zeros(0, dtype=np.int64), np.zeros(0)
    if load.on_nodes(mesh):
        nodes = load.nodes(mesh, images)
        weights = np.full(len(nodes), 1.0 if load.own else 1.0 / len(nodes))
        groups = np.arange(len(nodes)) if load.own else np.zeros(len(nodes), dtype=np.int64)
        return Shares(nodes, weights, groups, np.zeros((0, 4), dtype=np.int64), none)
    faces = load.faces(mesh)
    apart = np.arange(len(faces)) if load.placed else np.zeros(len(faces), dtype=np.int64)
    if load.kind == "pressure":
        return Shares(none, zero, none, faces, apart)
    parts = faces[:, None] if load.placed else [faces]
    found = []
    for group, part in enumerate(parts):
        areas = node_areas(mesh.nodes, part)
        nodes = np.unique(part)
        found.append((nodes, areas[nodes], np.full(len(nodes), group)))
    nodes, weights, groups = (np.concatenate(part) for part in zip(*found, strict=True))
    if load.kind == "force":
        weights = weights / weights.sum()
    return Shares(nodes, weights, groups, np.zeros((0, 4), dtype=np.int64), none)


def loaded_nodes(body: Body) -> np.ndarray:
    """Return the nodes of a body that loads act on, masters of periodic images, in the numbering of its mesh."""
    found = [np.zeros(0, dtype=np.int64)]
    for load in body.loads:
        found.append(load.nodes(body.mesh) if load.on_nodes(body.mesh) else load.faces(body.mesh).reshape(-1))
    nodes = np.unique(np.concatenate(found))
    return nodes if body.images is None else body.images.once(nodes)


def pack_loads(domain: Domain) -> PackedLoads | None:
    """Return the loads of a domain; None without loads and with constant gravity."""
    if not domain.loaded:
        return None
    width, varies, once = 3 * domain.pulled, domain.pulled, False
    row = np.full(len(domain.reference), -1)
    row[domain.boundary] = np.arange(len(domain.boundary))
    functions, own = [], []
    entries: list[tuple[np.ndarray, ...]] = []
    faces: list[tuple[np.ndarray, ...]] = []
    for body, start in zip(domain.bodies, domain.node_start, strict=False):
        place, master = _numbering(body, int(start))
        for load in body.body.loads:
            shares = shares_of(load, body.body.mesh, body.body.images)
            components = 1 if load.kind == "pressure" else 3
            if load.own:
                nodes = place[shares.nodes]
                own.append(OwnForce(load, nodes, width))
                entries.append((nodes, np.ones(len(nodes)), width + 3 * np.arange(len(nodes))))
                width += 3 * len(nodes)
                varies = once = True
                continue
            entries.append((master[shares.nodes], shares.weights, width + components * shares.groups))
            faces.append((place[shares.faces], master[shares.faces], width + shares.face_groups))
            function = load.function(body.body.mesh)
            functions.append((function, width))
            width += function.size
            varies, once = varies or load.varies, once or load.placed
    loaded = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *(part[0] for part in entries),
                                       *(part[1].reshape(-1) for part in faces)]))  # fmt: skip
    number = np.full(len(domain.reference), -1)
    number[loaded] = np.arange(len(loaded))
    nodes = np.zeros((len(loaded), NODE))
    nodes[:, 0] = row[loaded]
    lists = [np.stack([number[who], weights, places], axis=1) for who, weights, places in entries]
    pressed = [np.concatenate([corners, number[who], places[:, None]], axis=1) for corners, who, places in faces]
    entry_list = np.concatenate([np.zeros((0, ENTRY)), *lists])
    face_list = np.concatenate([np.zeros((0, FACE)), *pressed])
    rows = 1
    if varies and not own:
        rows += 1 if domain.small and once else domain.table_rows
    head = np.zeros(HEAD)
    head[[NODES, ENTRIES, FACES]] = len(nodes), len(entry_list), len(face_list)
    head[STRIDE], head[PULLS], head[ASKS] = width if rows > 1 else 0, domain.pulled, bool(own)
    data = np.concatenate([head, nodes.ravel(), entry_list.ravel(), face_list.ravel(), np.zeros(rows * width)])
    return PackedLoads(data, len(data) - rows * width, width, rows, tuple(functions), tuple(own))


def constant_forces(plan: BodyPlan) -> np.ndarray:
    """Return the sum [n, 3] [N] of the constant tractions and forces on every node of a body without images."""
    result = np.zeros_like(plan.reference)
    for load in plan.body.loads:
        shares = shares_of(load, plan.body.mesh, None)
        np.add.at(result, plan.place[shares.nodes], shares.weights[:, None] * np.asarray(load.value))
    return result


def _numbering(body: BodyPlan, start: int) -> tuple[np.ndarray, np.ndarray]:
    """Return for every node of the mesh its number in the domain and that of its master; start: first node."""
    place = body.place + start
    return place, place if body.images is None else body.images.master[body.place] + start
