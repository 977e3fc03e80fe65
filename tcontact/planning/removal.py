"""Choose the mass that the contact nodes lose: the set K and a basis of its massless directions (METHOD 1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..base.errors import InputError
from ..mesh.geometry import cells_at
from ..scene.body import Body
from ..scene.contact_models import MasslessContact
from ..scene.meeting import area_vectors
from ..scene.obstacles import Obstacle
from ..scene.periodic import Images
from ..scene.reach import within_reach
from ..scene.scene import Scene
from .metal_removal import ONE_SIDE, check_full, contact_metals, fast_metal, keeps_normals, own_normals, removal_before
from .rotation import moves_as_one, spin

FACING = np.cos(np.radians(15.0))  # a face within 15 degrees of its plane may lose normal mass only
SPINS = 0.05  # [rad]: a body that spins by less in the duration keeps its normals
PARALLEL = 1.0 - 1e-9
FLAT = 1e-6  # a direction shorter than this in the free components of a node counts as supported


@dataclass(frozen=True)
class MasslessNodes:
    """The massless nodes of a body.

    nodes [k]: numbers in the mesh; basis [k, 3, 3]: unit columns that span the massless directions, then zero columns;
    rank [k]: number of massless directions; removal: "normal" or "full".
    """

    nodes: np.ndarray
    basis: np.ndarray
    rank: np.ndarray
    removal: str

    def masters(self, images: Images) -> MasslessNodes:
        """Drop the images that follow a master."""
        kept = images.master[self.nodes] == self.nodes
        return replace(self, nodes=self.nodes[kept], basis=self.basis[kept], rank=self.rank[kept])


class JointRemoval:
    """The removal that bodies share which pairs connect to each other, found once for each such group of bodies."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._normals: dict[int, np.ndarray | None] = {}  # by the first body of a group
        self._removals: dict[int, str] = {}
        self._checked: set[int] = set()

    def normal(self, index: int) -> np.ndarray | None:
        """Return the direction [3] along which the group of a body may lose its mass, see `common_normal`."""
        group = self.scene.groups[index]
        if group[0] not in self._normals:
            self._normals[group[0]] = common_normal(self.scene, group)
        return self._normals[group[0]]

    def removal(self, index: int) -> str:
        """Return "normal" or "full" for the group of a body, where the scene leaves it open."""
        group = self.scene.groups[index]
        if group[0] not in self._removals:
            direction = self.normal(index)
            full = direction is None or _rubs_held_aslant(self.scene, group, direction)
            full = full or (removal_before(self.scene, group) == "full" and not fast_metal(self.scene, group))
            self._removals[group[0]] = "full" if full else "normal"
        return self._removals[group[0]]

    def check_full(self, index: int) -> None:
        """Refuse full removal of metals in the group of a body at too fast an impact. Raises `InputError`."""
        group = self.scene.groups[index]
        if group[0] not in self._checked:
            for number in group:
                check_full(self.scene, number, self.normal(index) is not None)
            self._checked.add(group[0])


def choose_removal(scene: Scene, index: int, joint: JointRemoval | None = None) -> str:
    """Resolve "auto": normal removal where the normal of a node cannot turn, else full.

    It cannot if all obstacles within reach are planes that share one direction, none of them turns, every contact face
    faces one of them, and the body does not start with a spin that turns it by 0.05 rad in the duration. Bodies in
    contact with each other share one removal: normal if one direction serves them all (`common_normal`). A metal has
    normal removal over planes of one direction, however its faces lean, and in every fast impact (metal_removal.py).
    In a run from the end of another one a body keeps the removal that it had, whatever its spin, unless the obstacles,
    the faces or a fast impact call for the other one. joint: what is known of such groups of bodies.
    """
    assert isinstance(scene.contact, MasslessContact)
    if scene.contact.removal != "auto":
        return scene.contact.removal
    if scene.pairs_at[index]:
        return (joint or JointRemoval(scene)).removal(index)
    body = scene.bodies[index]
    if keeps_normals(scene, [index]):
        return "normal"
    before, normals = removal_before(scene, [index]), _plane_normals(scene, index)
    if before == "full" or normals is None:
        return "full"
    facing = (-(_outward(body) @ normals.T)).max(axis=1)
    faces = (facing > FACING).all() or bool(contact_metals(body))
    return "normal" if faces and not _spins(scene, [index]) else "full"


def removals(scene: Scene) -> tuple[str | None, ...]:
    """Return the removal of every body of a scene, None where contact nodes keep their mass."""
    if not isinstance(scene.contact, MasslessContact):
        return (None,) * len(scene.bodies)
    joint = JointRemoval(scene)
    return tuple(
        choose_removal(scene, number, joint) if scene.can_touch(number) else None for number in range(len(scene.bodies))
    )


def _obstacles(scene: Scene, index: int) -> list[Obstacle]:
    """Return the obstacles within reach of a body."""
    reached = within_reach(scene.starting(index), scene.obstacles, scene.duration, scene.largest_gravity)
    return [scene.obstacles[number] for number in reached]


def _plane_normals(scene: Scene, index: int) -> np.ndarray | None:
    """Return the normals [m, 3] of the obstacles within reach if all are planes of one direction that do not turn."""
    obstacles = _obstacles(scene, index)
    if not all(obstacle.shape == "plane" and not obstacle.turns for obstacle in obstacles):
        return None
    normals = np.array([obstacle.frame[2] for obstacle in obstacles])
    return None if (np.abs(normals @ normals[0]) < PARALLEL).any() else normals


def _outward(body: Body) -> np.ndarray:
    """Return the unit outward normals [k, 3] of the contact faces at the start."""
    areas = area_vectors(body.initial_at(body.contact_faces))
    return np.asarray(areas / np.linalg.norm(areas, axis=1)[:, None])


def _spins(scene: Scene, numbers: Sequence[int]) -> bool:
    """Return whether one of some bodies turns by more than `SPINS` in the duration, with the spin of its start.

    What had normal removal in the run from whose end this one starts keeps it: `NormalWatch` warns of its rotation.
    """
    return removal_before(scene, numbers) != "normal" and any(_turn(scene, number) > SPINS for number in numbers)


def _turn(scene: Scene, index: int) -> float:
    """Return by how much [rad] a body turns in the duration, with the spin of its start."""
    body = scene.starting(index)
    if moves_as_one(body.initial_velocity):
        return 0.0
    return float(np.linalg.norm(spin(body, body.initial_velocity, body.initial_nodes))) * scene.duration


def common_normal(scene: Scene, numbers: Sequence[int]) -> np.ndarray | None:
    """Return the direction [3] along which bodies that pairs connect, with these numbers, may lose their mass.

    All their contact faces lie within 15 degrees of it (45 in a fast impact of metals, such as balls), none of the
    bodies turns, and an obstacle is a plane across it. None if there is no such direction.
    """
    bodies = [scene.bodies[number] for number in numbers]
    limit = ONE_SIDE if keeps_normals(scene, numbers) else FACING
    normals = [_outward(body) for body in bodies]
    first = normals[0][0]
    total = sum((np.where(part @ first > 0.0, 1.0, -1.0)[:, None] * part).sum(axis=0) for part in normals)
    if not np.linalg.norm(total) > 0.0:
        return None
    direction = np.asarray(total / np.linalg.norm(total))
    for obstacle in scene.obstacles:
        across = obstacle.shape == "plane" and not obstacle.turns
        if not across or abs(obstacle.frame[2] @ direction) < limit:
            return None
        direction = np.array(obstacle.frame[2])
    aligned = all((np.abs(part @ direction) > limit).all() for part in normals)
    return direction if aligned and not _spins(scene, numbers) else None


def _rubs_held_aslant(scene: Scene, numbers: Sequence[int], direction: np.ndarray) -> bool:
    """Return whether there is friction, and contact nodes are held along an axis neither along nor across a direction.

    The removed direction of such a node is not that of its contact: what friction would give to it finds no mass.
    Metals in a fast impact are left out, since they cannot lose all of it.
    """
    aslant = (np.abs(direction) > FLAT) & (np.abs(direction) < PARALLEL)
    bodies = [scene.bodies[number] for number in numbers]
    held = any((~np.isnan(body.prescribed[body.contact_nodes]) & aslant).any() for body in bodies)
    return held and scene.largest_friction > 0.0 and not keeps_normals(scene, numbers)


def massless_nodes(scene: Scene, index: int, joint: JointRemoval | None = None) -> MasslessNodes:
    """Find the nodes of the contact set that lose mass, and their massless directions.

    A supported component keeps its mass; a node whose massless directions are all supported leaves K. With normal
    removal the normals are those of the obstacles within reach, on an edge of a block those of all its faces, as the
    node may be held by any of them; for a metal, unless they are planes of one direction,
    those of its contact faces. joint: what is known of bodies that pairs connect. Raises `InputError` for full removal
    of a metal in a fast impact.
    """
    assert isinstance(scene.contact, MasslessContact)
    joint = joint or JointRemoval(scene)
    body, removal = scene.bodies[index], choose_removal(scene, index, joint)
    nodes = body.contact_nodes
    free = np.isnan(body.prescribed[nodes])  # [k, 3]; rigid parts have no contact nodes
    normals = np.broadcast_to(np.zeros(3), (len(nodes), 1, 3))
    if scene.pairs_at[index]:
        common = joint.normal(index)
        if removal == "normal" and common is None:
            remedy = "bodies in contact with each other lose their normal mass only if all their contact faces lie"
            remedy += " within 15 degrees of one direction and none of them turns; use 'full' or 'auto'"
            raise InputError("MasslessContact.removal", removal, remedy)
        normals = normals if common is None else np.broadcast_to(common, normals.shape)
        if removal == "full":
            joint.check_full(index)
    elif removal == "full":
        check_full(scene, index)
    elif contact_metals(body) and _plane_normals(scene, index) is None:
        normals = own_normals(body)
    else:
        places = body.initial_at(nodes)
        normals = np.concatenate([one.normals_at(places) for one in _obstacles(scene, index)], axis=1)
    candidates = free if removal == "full" else np.concatenate([free, normals.reshape(len(nodes), -1)], axis=1)
    patterns, member = np.unique(candidates, axis=0, return_inverse=True)
    member = member.reshape(-1)
    basis = np.zeros((len(nodes), 3, 3))
    rank = np.zeros(len(nodes), dtype=np.int64)
    for index, pattern in enumerate(patterns):
        open_axes = pattern[:3].astype(bool)
        directions = np.eye(3)[open_axes] if removal == "full" else pattern[3:].reshape(-1, 3) * open_axes
        columns = orthonormal(directions)
        basis[member == index, :, : columns.shape[1]] = columns
        rank[member == index] = columns.shape[1]
    kept = rank > 0
    return MasslessNodes(nodes[kept], basis[kept], rank[kept], removal)


def orthonormal(directions: np.ndarray) -> np.ndarray:
    """Return orthonormal columns [3, r] that span the rows; a rest shorter than 1e-6 does not count.

    Gram-Schmidt in the order of the rows leaves a single unit direction as it is, to the bit.
    """
    columns: list[np.ndarray] = []
    for direction in directions:
        rest = direction - sum((column * (column @ direction) for column in columns), np.zeros(3))
        if len(columns) == 2:  # the third one is known, without the rounding of two projections
            third = np.cross(columns[0], columns[1])
            rest = third * (third @ direction)
        length = np.linalg.norm(rest)
        if length > FLAT:
            columns.append(np.asarray(rest) / length)
    return np.array(columns).T if columns else np.zeros((3, 0))


def check_clusters(body: Body, massless: MasslessNodes, name: str) -> None:
    """Refuse a contact set that is not held: the static solve needs every cluster of K tied to nodes with mass.

    A cluster (K nodes connected through cells) is held if no rigid motion of it leaves its neighbours with mass, and
    the components that its nodes keep, at rest. name: of the body, for messages. Raises `InputError`.
    """
    mesh = body.mesh
    inside = np.zeros(mesh.node_count, dtype=bool)
    inside[massless.nodes] = True
    rows = mesh.cell_rows
    near, numbers = np.unique(rows[cells_at(inside, rows)], return_inverse=True)
    cells = numbers.reshape(-1, rows.shape[1])  # from here on nodes are numbered as in `near`
    inside, places = inside[near], mesh.nodes_at(near)
    mine = inside[cells]
    label = np.where(inside, np.arange(len(near)), len(near))
    while True:  # smallest label wins, through the cells
        lowest = np.where(mine, label[cells], len(near)).min(axis=1)
        before = label.copy()
        np.minimum.at(label, cells[mine], np.broadcast_to(lowest[:, None], cells.shape)[mine])
        label[inside] = label[label[inside]]
        if (label == before).all():
            break
    owner = np.where(mine, label[cells], len(near)).min(axis=1)
    kept = np.eye(3) - np.einsum("kic,kjc->kij", massless.basis, massless.basis)
    place = np.searchsorted(massless.nodes, near)
    for cluster in np.unique(owner):
        members = np.unique(cells[owner == cluster])
        neighbours, own = members[~inside[members]], members[inside[members]]
        where = ", ".join(f"{part:.4g}" for part in places[own[0]])
        which = f"{len(own)} contact nodes of {name} around node {near[own[0]]} at ({where})"
        if len(neighbours) == 0:
            raise InputError(
                "Body.contact",
                body.contact,
                f"no node with mass lies next to the {which}; make the contact set smaller (only the faces"
                " that can touch) or the mesh finer",
            )
        centre = places[own].mean(axis=0)
        scale = np.abs(places[members] - centre).max()
        gram = np.zeros((6, 6))
        for nodes, held in ((neighbours, np.broadcast_to(np.eye(3), (len(neighbours), 3, 3))), (own, kept[place[own]])):
            arm = (places[nodes] - centre) / scale
            modes = np.zeros((len(nodes), 3, 6))
            modes[:, :, :3] = np.eye(3)
            for axis in range(3):
                modes[:, :, 3 + axis] = np.cross(np.eye(3)[axis], arm)
            rows = (held @ modes).reshape(-1, 6)
            gram += rows.T @ rows
        values = np.linalg.eigvalsh(gram)
        if values[0] < 1e-9 * values[-1]:
            raise InputError(
                "MasslessContact.removal",
                massless.removal,
                f"the {which} can turn about their {len(neighbours)} neighbours with mass;"
                f" {_remedy_of_turning(massless.removal)}",
            )


def _remedy_of_turning(removal: str) -> str:
    if removal == "full":
        need = "full removal needs three not in line, nor nearly so, as in very thin cells"
        return f"{need}: use removal='normal', a finer mesh or cells of a lower aspect ratio"
    return "the cells are so thin that these are nearly in line: use cells of a lower aspect ratio"
