"""The semi-explicit step: leapfrog on what has mass, static contact solve on what has none."""

from dataclasses import dataclass, field

import numpy as np
from scipy import sparse
from scipy.linalg import eigh
from scipy.sparse.linalg import eigsh

from oracle.cells import assemble, energy, internal_force, quadrature, tangent
from oracle.friction import SlidingContact, scaled_back
from oracle.mass import Redistribution, face_area_weights, lumped_cell_mass, redistribute
from oracle.static_contact import StaticContact


@dataclass(frozen=True)
class Body:
    """Mesh, law, density [kg/m^3], contact faces [f, 4|3]; supported components [n, 3], their velocity [n, 3] [m/s]."""

    nodes: np.ndarray
    cells: np.ndarray
    kind: str
    law: object
    density: float
    contact_faces: np.ndarray | None = None
    supported: np.ndarray | None = None
    support_velocity: np.ndarray | None = None


@dataclass(frozen=True)
class Plane:
    """A rigid wall through `point` with the unit normal into the body, moving at `velocity` [m/s]."""

    point: tuple
    normal: tuple
    velocity: tuple = (0.0, 0.0, 0.0)

    @property
    def unit(self):
        return np.asarray(self.normal, float) / np.linalg.norm(self.normal)


@dataclass(frozen=True)
class Massless:
    """Contact nodes without mass; penalty [N/m^3] or None for the exact constraint."""

    removal: str = "full"
    penalty: float | None = None
    depth: int = 1


@dataclass(frozen=True)
class Penalty:
    """Penalty [N/m^3] on nodes that keep their mass."""

    stiffness: float


@dataclass(frozen=True)
class Impulse:
    """Moreau-Jean impulses with restitution 0 on nodes that keep their mass."""


@dataclass
class History:
    """Rows n = 0..steps and the end state."""

    dt: float
    time: np.ndarray
    kinetic: np.ndarray
    elastic: np.ndarray
    contact: np.ndarray
    external_work: np.ndarray
    friction_work: np.ndarray
    viscous_work: np.ndarray
    contact_force: np.ndarray
    support_force: np.ndarray
    gravity_force: np.ndarray
    momentum: np.ndarray
    angular_momentum: np.ndarray
    gap_min: np.ndarray
    mass: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    node_force: np.ndarray
    row_displacement: list = field(default_factory=list)

    @property
    def energy(self):
        lost = self.friction_work + self.viscous_work
        return self.kinetic + self.elastic + self.contact + lost - self.external_work

    @property
    def energy_error(self):
        return np.abs(self.energy - self.energy[0]).max() / (self.kinetic + self.elastic).max()

    @property
    def impulse(self):
        return running(self.contact_force, self.dt)


def running(force, dt):
    """Trapezoidal running integral of rows [s, ...]."""
    total = np.zeros_like(force)
    total[1:] = np.cumsum((force[1:] + force[:-1]) * dt / 2, axis=0)
    return total


def stable_step(body, penalty=None, normals=()):
    """2 / omega_max of the free body with its standard lumped mass; a penalty on its contact nodes may be added."""
    quad = quadrature(body.nodes, body.cells, body.kind)
    count = len(body.nodes)
    mass = np.repeat(assemble(body.cells, lumped_cell_mass(quad, body.density), count), 3)
    stiffness = tangent(quad, body.law, np.zeros((count, 3)))
    if penalty is not None:
        area = face_area_weights(body.nodes, body.contact_faces)
        block = sum(np.outer(normal, normal) for normal in normals)
        stiffness = stiffness + sparse.block_diag([penalty * a * block for a in area], format="csr")
    root = sparse.diags(mass**-0.5)
    scaled = root @ stiffness @ root
    last = scaled.shape[0] - 1
    if last < 1200:
        largest = eigh(scaled.toarray(), eigvals_only=True, subset_by_index=[last, last])[0]
    else:
        largest = eigsh(scaled, k=1, which="LA", tol=1e-10, return_eigenvectors=False)[0]
    return 2 / np.sqrt(largest)


def heights(nodes, cells):
    """Return the shortest height [m]: of the parallelepiped of a hex, or of a tetrahedron or prism times sqrt 2."""
    corner = nodes[cells]
    if cells.shape[1] == 4:
        rows = np.linalg.inv(corner[:, 1:] - corner[:, :1])  # their columns: gradients of the shape functions
        every = np.concatenate([rows, -rows.sum(axis=2, keepdims=True)], axis=2)
        return np.sqrt(2) / np.linalg.norm(every, axis=1).max(axis=1)
    elif cells.shape[1] == 6:
        middle, along = corner[:, :3] + corner[:, 3:], corner[:, 3:].mean(axis=1) - corner[:, :3].mean(axis=1)
        rows = np.linalg.inv(np.stack([*(0.5 * (middle[:, k] - middle[:, 0]) for k in (1, 2)), along], axis=1))
        every = np.concatenate([rows, -rows[:, :, :2].sum(axis=2, keepdims=True)], axis=2)
        return np.sqrt(2) / np.linalg.norm(every, axis=1).max(axis=1)
    else:
        faces = [((1, 2, 5, 6), (0, 3, 4, 7)), ((2, 3, 6, 7), (0, 1, 4, 5)), ((4, 5, 6, 7), (0, 1, 2, 3))]
        axes = np.stack([corner[:, list(a)].mean(1) - corner[:, list(b)].mean(1) for a, b in faces], axis=1)
    return 1 / np.linalg.norm(np.linalg.inv(axes), axis=1).max(axis=1)


def free_inverse(tensor, free):
    """Inverse of the mass tensors on their massive free components, zero elsewhere [n, 3, 3]."""
    inside = tensor * free[:, :, None] * free[:, None, :]
    return np.linalg.pinv(inside, rcond=1e-10, hermitian=True)


def run(body, planes, velocity, steps=None, duration=None, cfl=0.9, dt=None, contact=None, gravity=None, start=None,
        keep_rows=False, friction=None, viscosity=None):  # fmt: skip
    """Run `steps` steps (or to `duration` [s]) from the displacement `start` [n, 3] and velocity [3] or [n, 3].

    dt [s], or cfl times the stable step. contact: Massless, Penalty, Impulse or None; friction: Coulomb's coefficient
    (with full removal of a linear law only); viscosity: beta of the contact cells (massless contact, linear law).
    """
    nodes, count = body.nodes, len(body.nodes)
    quad = quadrature(nodes, body.cells, body.kind)
    dt = cfl * stable_step(body) if dt is None else dt
    steps = int(np.ceil(duration / dt - 1e-9)) if steps is None else steps
    free = np.ones((count, 3), bool) if body.supported is None else ~body.supported
    driven = np.zeros((count, 3)) if body.support_velocity is None else body.support_velocity * ~free
    normals = np.array([plane.unit for plane in planes]).reshape(-1, 3)
    rates = np.array([plane.velocity for plane in planes], float).reshape(-1, 3)
    origins = np.array([plane.point for plane in planes], float).reshape(-1, 3)

    cell_mass = lumped_cell_mass(quad, body.density)
    lumped = assemble(body.cells, cell_mass, count)
    touching = np.zeros(0, int)
    area = np.zeros(count)
    if contact is not None:
        touching = np.unique(body.contact_faces)
        area = face_area_weights(nodes, body.contact_faces)
    static = None
    if isinstance(contact, Massless):
        spread = redistribute(nodes, body.cells, cell_mass, touching, contact.removal, normals, contact.depth, free)
        static = StaticContact(quad, body.law, spread.contact, spread.basis, normals, free, area, contact.penalty)
    else:
        spread = Redistribution(lumped[:, None, None] * np.eye(3), np.zeros(0, int), np.zeros((0, 3, 3)))
    if viscosity:
        eta = viscosity * heights(nodes, body.cells) / np.sqrt((body.law.lam + 2 * body.law.mu) / body.density)
        static.viscosity(eta / dt, quad)
    sliding = SlidingContact(static, friction) if friction and static and contact.removal == "full" else None
    mass = spread.tensor
    inverse = free_inverse(mass, free)
    weight = np.zeros((count, 3)) if gravity is None else mass @ np.asarray(gravity, float)
    stiffness = contact.stiffness if isinstance(contact, Penalty) else getattr(contact, "penalty", None)

    u = np.zeros((count, 3)) if start is None else start.copy()
    v = np.broadcast_to(np.asarray(velocity, float), (count, 3)).copy()
    v[~free] = driven[~free]
    v[spread.contact] -= np.einsum("kij,kj->ki", spread.removed, v[spread.contact])
    rows = {name: [] for name in History.__dataclass_fields__}
    rubbed, dragged = 0.0, None
    lost, resisting = 0.0, np.zeros((count, 3))

    for n in range(steps + 1):
        time = n * dt
        points = origins + rates * time
        first = n == 0
        load = np.zeros((count, 3))
        rubbing = np.zeros((len(planes), 3))
        if sliding is not None:
            shift = rates * (0 if first else dt)
            u, pressing, drag, slip = sliding.solve(nodes, u, points, shift, weight)
            place_contact = np.zeros((len(spread.contact), len(planes)))
            place_contact[static.pair_node, static.pair_plane] = pressing
            load[spread.contact] = place_contact @ normals
            np.add.at(load, spread.contact[static.pair_node], drag)
            np.add.at(rubbing, static.pair_plane, drag)
            rubbed -= np.sum((drag if dragged is None else drag + dragged) * slip) / 2
            dragged = drag
        elif static is not None:
            u, table, _, _ = static.solve(nodes, u, points, weight)
            load[spread.contact] = table @ normals
            place_contact = table
        else:
            place = nodes[touching] + u[touching]
            gap = np.einsum("kpi,pi->kp", place[:, None] - points, normals)
            if isinstance(contact, Penalty):
                place_contact = stiffness * area[touching][:, None] * np.maximum(0, -gap)
                load[touching] = place_contact @ normals
        if first:
            u_start = u.copy()
        inner = internal_force(quad, body.law, u)
        if viscosity:
            resisted, resisting = resisting, static.viscous_force(u)
            inner += resisting
            if not first:
                lost += np.sum((resisted + resisting) * (u - static.before)) / 2
            static.step_from(u)
        kick = np.einsum("nij,nj->ni", inverse, weight - inner + load)
        span = dt / 2 if first else dt
        after = v + span * kick
        pushed = np.zeros((len(touching), len(planes))) if isinstance(contact, Impulse) else None
        if isinstance(contact, Impulse):
            for k, gaps in zip(touching, gap, strict=True):
                for p in np.flatnonzero(gaps <= 0):
                    hit = max(0.0, -lumped[k] * normals[p] @ (after[k] - rates[p]))
                    after[k] += hit * normals[p] / lumped[k] * free[k]
                    load[k] += hit * normals[p] / span
                    pushed[np.searchsorted(touching, k), p] = hit / span
        late = 0.0
        if friction and sliding is None:
            pressing = place_contact if pushed is None else pushed
            for k, presses in zip(touching, pressing, strict=True):
                drag = scaled_back(lumped[k], after[k], rates, normals, presses, span, friction)
                after[k] += span * drag.sum(axis=0) / lumped[k]
                load[k] += drag.sum(axis=0)
                rubbing += drag
                mean = v[k] if first else (v[k] + after[k]) / 2
                rubbed -= np.sum(drag * ((0 if first else dt / 2) * ((v[k] + mean) / 2 - rates)))
                late -= np.sum(drag * (dt / 2 * ((mean + after[k]) / 2 - rates)))
        middle = v if first else (v + after) / 2
        change = (after - v) / span
        reaction = np.einsum("nij,nj->ni", mass, change) + inner - weight - load
        reaction[free] = 0

        place = nodes + u
        moving = np.einsum("nij,nj->ni", mass, middle)
        opening = np.einsum("kpi,pi->kp", place[touching][:, None] - points, normals)
        stored = 0.0
        if stiffness is not None:
            stored = stiffness / 2 * np.sum(area[touching][:, None] * np.maximum(0, -opening) ** 2)
        rows["time"].append(time)
        rows["kinetic"].append(np.sum(middle * moving) / 2)
        rows["elastic"].append(energy(quad, body.law, u))
        rows["contact"].append(stored)
        rows["friction_work"].append(rubbed)
        rows["viscous_work"].append(lost)
        rubbed += late
        rows["contact_force"].append(load.sum(axis=0))
        rows["support_force"].append(reaction.sum(axis=0))
        rows["gravity_force"].append(weight.sum(axis=0))
        rows["momentum"].append(moving.sum(axis=0))
        rows["angular_momentum"].append(np.cross(place, moving).sum(axis=0))
        rows["gap_min"].append(opening.min() if opening.size else np.inf)
        power = np.sum(reaction * driven)
        if contact is not None and not isinstance(contact, Impulse):
            power += np.sum(place_contact @ np.sum(normals * rates, axis=1))
        power += np.sum(rubbing * rates)
        rows["external_work"].append((np.sum(weight * (u - u_start)), power))
        if keep_rows:
            rows["row_displacement"].append(u.copy())
        v = after
        if n < steps:
            u = u + dt * v

    gravity_work, power = np.array(rows["external_work"]).T
    rows["external_work"] = gravity_work + running(power, dt)
    kept = rows.pop("row_displacement")
    table = {name: np.array(value) for name, value in rows.items() if value is not None and len(value)}
    table.update(dt=dt, mass=mass, displacement=u, velocity=middle, node_force=load)
    return History(row_displacement=kept, **table)
