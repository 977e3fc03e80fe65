"""The stable step of springs at rigid parts against a condensed eigenvalue problem of free nodes and parts."""

import itertools

import numpy as np
import pytest
from oracle import LinearElastic
from oracle.cells import assemble, quadrature, tangent
from oracle.mass import lumped_cell_mass
from scenes import simulate
from stopped_runs import quietly

import tcontact as tc

YOUNG, POISSON, DENSITY = 1e6, 0.3, 1000.0


class Condensed:
    """Mass and stiffness of cubes whose rigid parts have six coordinates each: displacement and rotation vector."""

    def __init__(self, bodies):
        places, sizes = [body.mesh.nodes for body in bodies], [body.mesh.node_count for body in bodies]
        self.places = np.concatenate(places)
        starts = np.cumsum([0, *sizes])
        count = starts[-1]
        stiffness, mass = np.zeros((3 * count, 3 * count)), np.zeros(count)
        for body, first, size in zip(bodies, starts, sizes, strict=False):
            quad = quadrature(body.mesh.nodes, body.mesh.cells, "hex8")
            part, law = slice(3 * first, 3 * (first + size)), LinearElastic(YOUNG, POISSON)
            stiffness[part, part] = tangent(quad, law, np.zeros((size, 3))).toarray()
            mass[first : first + size] = assemble(quad.cells, lumped_cell_mass(quad, DENSITY), size)
        self.owner, self.parts, inertias = np.full(count, -1), [], []
        for body, first in zip(bodies, starts, strict=False):
            for part in body.rigid_parts:
                nodes = body.mesh.nodes_of(part.set) + first
                centre = mass[nodes] @ self.places[nodes] / mass[nodes].sum()
                self.owner[nodes] = len(self.parts)
                self.parts.append((nodes, centre, part.driven))
                more = mass[nodes] * (1.0 + (part.mass or 0.0) / mass[nodes].sum())
                inertias.append(sum(m * cross(x - centre).T @ cross(x - centre) for m, x in
                                    zip(more, self.places[nodes], strict=True)))  # fmt: skip
                mass[nodes] = more
        free = np.flatnonzero(self.owner < 0)
        moves = np.zeros((count, 3, 3 * len(free) + 6 * len(self.parts)))
        for column, node in enumerate(free):
            moves[node, :, 3 * column : 3 * column + 3] = np.eye(3)
        for number, (nodes, centre, _driven) in enumerate(self.parts):
            at = 3 * len(free) + 6 * number
            for node in nodes:
                moves[node, :, at : at + 3] = np.eye(3)
                moves[node, :, at + 3 : at + 6] = -cross(self.places[node] - centre)
        held = [np.arange(6) + 3 * len(free) + 6 * i for i, (*_, driven) in enumerate(self.parts) if driven]
        self.columns = np.setdiff1d(np.arange(moves.shape[2]), np.concatenate([np.zeros(0, int), *held]))
        self.first_part = 3 * len(free)
        flat = moves.reshape(3 * count, -1)
        self.moves, self.stiffness = moves, flat.T @ stiffness @ flat
        self.mass = flat.T @ (np.repeat(mass, 3)[:, None] * flat)

    def add(self, weights, stiffness, rest=None, arrow=(0.0, 0.0, 0.0)):
        """Add a spring; weights [n] are those of the second end less those of the first.

        rest: length without force [m], None for a spring along all axes; arrow [3] [m]: from the first end to the
        second at the start.
        """
        matrix = np.einsum("n,nic->ic", weights, self.moves)
        length = float(np.linalg.norm(arrow))
        own, force = stiffness * np.eye(3), np.zeros(3)
        if rest is not None:
            line = np.array(arrow) / length
            along = np.outer(line, line)
            own = stiffness * (along + (1.0 - rest / length) * (np.eye(3) - along))
            force = stiffness * (length - rest) * line
        self.stiffness += matrix.T @ own @ matrix
        for number, (nodes, centre, _driven) in enumerate(self.parts):  # F.(t x (t x arm))/2 of a rotation vector t
            arm = weights[nodes] @ (self.places[nodes] - centre)
            at = slice(self.first_part + 6 * number + 3, self.first_part + 6 * number + 6)
            bent = 0.5 * (np.outer(force, arm) + np.outer(arm, force)) - force @ arm * np.eye(3)
            self.stiffness[at, at] += bent

    def step(self):
        """Return the critical step 2/omega [s]."""
        rows = np.ix_(self.columns, self.columns)
        root = np.linalg.inv(np.linalg.cholesky(self.mass[rows]))
        return 2.0 / np.sqrt(np.linalg.eigvalsh(root @ self.stiffness[rows] @ root.T)[-1])


def cross(arm):
    """Return the matrix of arm x."""
    return np.array([[0.0, -arm[2], arm[1]], [arm[2], 0.0, -arm[0]], [-arm[1], arm[0], 0.0]])


def cube(name, origin=(0.0, 0.0, 0.0), parts=(), springs=()):
    """A cube of rubber, 0.1 m, 1 kg, with an edge of its upper face and corners of that as node sets."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2), origin=origin)
    x = mesh.nodes - origin
    top = x[:, 2] > 0.099
    sets = {"edge": np.flatnonzero(top & (x[:, 0] > 0.099)), "back": np.flatnonzero(top & (x[:, 0] < 1e-3))}
    for number, (a, b) in enumerate(itertools.product((0.0, 0.1), repeat=2)):
        sets[f"corner-{number}"] = np.flatnonzero(top & (np.abs(x[:, 0] - a) + np.abs(x[:, 1] - b) < 1e-3))
    law = tc.LinearElastic(YOUNG, POISSON, DENSITY)
    return tc.Body(mesh.with_sets(node_sets=sets), law, name=name, rigid_parts=list(parts), springs=list(springs),
                   velocity=(0.0, 1e-4, 1e-3))  # fmt: skip


def critical(bodies):
    """Return the critical step [s] of the condensed problem of bodies with springs to the ground, points and sets."""
    found = Condensed(bodies)
    names = [body.name for body in bodies]
    starts = np.cumsum([0, *(body.mesh.node_count for body in bodies)])

    def weights(index, name):
        nodes = bodies[index].mesh.nodes_of(name)
        result = np.zeros(starts[-1])
        result[nodes + starts[index]] = 1.0 / len(nodes)
        return result

    for index, body in enumerate(bodies):
        for spring in body.springs:
            first, second, point = weights(index, spring.set), np.zeros(starts[-1]), None
            if isinstance(spring.to, str):
                second = weights(index, spring.to)
            elif spring.to is not None and isinstance(spring.to[0], str):
                second = weights(names.index(spring.to[0]), spring.to[1])
            elif spring.to is not None:
                point = np.array(spring.to)
            if spring.directions:
                found.add(second - first, spring.stiffness)
                continue
            arrow = (second @ found.places if point is None else point) - first @ found.places
            rest = np.linalg.norm(arrow) if spring.rest_length is None else spring.rest_length
            found.add(second - first, spring.stiffness, rest, arrow)
    return found.step()


def beside(spring, mass=20.0, other=(), **options):
    """Two cubes, the first with a rigid top and a spring, the second with the rigid parts `other`."""
    part = tc.RigidPart("zmax", mass=mass, **options)
    return [cube("low", parts=[part], springs=[spring]), cube("up", (0.05, 0.02, 0.3), other)]


K = 1e7
LIGHT = tc.RigidPart("zmin", mass=0.3)
SCENES = {
    "ground": [cube("a", parts=[tc.RigidPart("zmax", mass=100.0)], springs=[tc.Spring("zmax", K, 100.0)])],
    "off centre": [cube("a", parts=[tc.RigidPart("zmax", mass=100.0)], springs=[tc.Spring("edge", K, 1e3)])],
    "no mass of its own": [cube("a", parts=[tc.RigidPart("zmax", mass=0.0)], springs=[tc.Spring("edge", K)])],
    "four corners": [
        cube("a", parts=[tc.RigidPart("zmax", mass=50.0)],
             springs=[tc.Spring(f"corner-{number}", K, 50.0) for number in range(4)])
    ],
    "four corners of two parts": [
        cube("a", parts=[tc.RigidPart("zmax", mass=50.0)],
             springs=[tc.Spring(f"corner-{i}", K, to=("b", f"corner-{i}"), axes="xyz") for i in range(4)]),
        cube("b", (0.02, 0.0, 0.2), parts=[tc.RigidPart("zmax", mass=2.0)]),
    ],
    "part to part": beside(tc.Spring("zmax", K, 10.0, to=("up", "zmin")), other=[LIGHT]),
    "edge to part": beside(tc.Spring("edge", K, to=("up", "zmin"), axes="xyz"), other=[LIGHT]),
    "part to nodes": beside(tc.Spring("edge", K, 10.0, to=("up", "zmin"))),
    "part to a driven part": beside(
        tc.Spring("edge", K, to=("up", "zmin")), other=[tc.RigidPart("zmin", driven=True, velocity=(0.0, 0.0, 0.0))]
    ),
    "part to itself": [
        cube("a", parts=[tc.RigidPart("zmax", mass=20.0)], springs=[tc.Spring("edge", K, to="back", axes="yz")])
    ],
    "nodes of both kinds": [cube("a", parts=[tc.RigidPart("zmax", mass=20.0)], springs=[tc.Spring("xmax", K)])],
    "stretched": [
        cube("a", parts=[tc.RigidPart("zmax", mass=20.0)],
             springs=[tc.Spring("edge", K, to=(1.1, 0.05, 0.1), rest_length=0.0)])
    ],
    "soft": beside(tc.Spring("edge", 1e3, 10.0, to=("up", "zmin")), other=[LIGHT]),
}  # fmt: skip


@pytest.mark.filterwarnings("ignore::tcontact.EnergyWarning", "ignore::tcontact.RotationWarning")
@pytest.mark.parametrize("name", SCENES)
def test_the_stable_step_with_rigid_parts_is_below_the_critical_one_and_near_it(name):
    """lambda(K) + lambda(B) with the inverse mass of the parts, not with that of their nodes."""
    bodies = SCENES[name]
    limit = critical(bodies)
    result = simulate(tc.Scene(bodies, duration=2.5 * limit), cfl=0.5)
    assert 0.5 * limit < result.dt_limit <= limit


@pytest.mark.filterwarnings("ignore::tcontact.EnergyWarning")
@pytest.mark.parametrize("name", ["off centre", "four corners", "part to itself"])
def test_runs_near_the_stable_step_of_rigid_parts_on_springs_stay_stable(name):
    """Over 300 steps the energy stays bounded; a step above the critical one is not stable."""
    bodies = SCENES[name]
    limit = critical(bodies)
    result = simulate(tc.Scene(bodies, duration=300 * limit), cfl=0.99)
    early, late = np.array_split(result.history["kinetic"] + result.history["elastic"], 2)
    assert late.max() <= 1.2 * early.max()
    above = quietly(tc.simulate, tc.Scene(bodies, duration=300 * limit), tc.CentralDifference(dt=1.1 * limit))
    assert above.reason == "diverged" or above.history["energy_error"].max() > 1e3
