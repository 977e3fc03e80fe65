"""Statics of bodies in contact: the patch test, and the static solve of a chain against a dense active set."""

import numpy as np
import pytest
from oracle import meshes
from pair_scenes import soft, total
from pair_statics import Statics

import tcontact as tc
from tcontact.contact.pairs import pair_contact
from tcontact.contact.pairs.coupling import integrals
from tcontact.contact.pairs.surfaces import area_vectors
from tcontact.device import arrays
from tcontact.kernels import pair_places as at

SIDES = ("xmin", "xmax", "ymin", "ymax", "zmin", "zmax")


def patch(kind, degrees, slave):
    """Two blocks of two stiffnesses in contact, meshes turned against each other, the upper one inside the lower."""
    above = tc.box_mesh((1, 1, 1), (4, 4, 2), kind, origin=(-0.5, -0.5, 0.0)).rotated(((0, 0, 1), np.radians(degrees)))
    below = tc.box_mesh((2, 2, 1), (5, 5, 2), kind, origin=(-1.0, -1.0, -1.0))
    parts = (above.translated((0.13, -0.21, 0.0)), 1.0, "zmin", "up"), (below, 2.0, "zmax", "low")
    turn = meshes.rotation(4)
    bodies = [
        tc.Body(mesh.rotated(turn), soft(tc.LinearElastic, young), contact=side, name=name)
        for mesh, young, side, name in parts
    ]
    return tc.Scene(bodies, duration=1.0, pairs=[tc.Pair("up", "low", slave=slave)])


def exposed_load(statics, scene):
    """Nodal forces [n, 3] of a unit pressure on all outer faces, less the part of them that is in contact."""
    load = np.zeros_like(statics.positions)
    for (_quad, _law, place), body in zip(statics.bodies, scene.bodies, strict=True):
        for name in SIDES:
            faces = place[body.mesh.face_sets[name]]
            for a in range(faces.shape[1]):  # of parallelograms and triangles
                np.add.at(load, faces[:, a], -area_vectors(statics.positions, faces) / faces.shape[1])
    (facing,), (pairs,) = statics.facings, statics.candidates
    slave, masters = facing.slave.faces, facing.master_faces
    found = integrals(statics.positions[slave], statics.positions[masters], pairs)
    outward = area_vectors(statics.positions, slave)[pairs[:, 0]]
    outward /= np.linalg.norm(outward, axis=1)[:, None]
    own = found[:, at.SLAVE_PRODUCTS : at.SLAVE_PRODUCTS + 16].reshape(-1, 4, 4).sum(axis=2)
    other = found[:, at.MASTER_PRODUCTS : at.MASTER_PRODUCTS + 16].reshape(-1, 4, 4).sum(axis=1)
    for a in range(4):
        np.add.at(load, slave[pairs[:, 0], a], own[:, a, None] * outward)
        np.add.at(load, masters[pairs[:, 1], a], -other[:, a, None] * outward)
    return load


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
@pytest.mark.parametrize("degrees", [0.0, 17.0])
@pytest.mark.parametrize(("slave", "bound"), [("up", 1e-10), ("low", 2e-3)])
def test_a_patch_under_pressure_has_a_uniform_stress(kind, degrees, slave, bound):
    """The rows of a covered slave pass the patch test; those of one that overhangs but for the rows left out."""
    scene = patch(kind, degrees, slave)
    statics = Statics(scene)
    load = exposed_load(statics, scene)
    u, pressing = statics.closed(load)
    assert np.abs(load.sum(axis=0)).max() <= 1e-14
    assert np.abs(statics.stress(u) + np.eye(3)).max() <= bound
    assert pressing.min() > 0.0
    if slave == "up":
        assert np.abs(pressing / statics.areas - 1.0).max() <= bound


def chain(seed, kind):
    """Three bodies of random displacements on each other, the lowest one above a plane that is not quite parallel."""
    random, bodies = np.random.default_rng(seed), []
    sides = ["zmin"], ["zmin", "zmax"], ["zmax", "zmin"]
    for number, (name, cells, young) in enumerate(zip("abc", (3, 4, 5), (1.0, 4.0, 16.0), strict=True)):
        mesh = tc.box_mesh((1, 1, 0.8), (cells, cells, 3), kind, origin=(-0.5, -0.5, -0.8 * number))
        u = 1e-3 * random.uniform(-1.0, 1.0, mesh.nodes.shape)
        if name == "c":  # presses its lowest nodes on the plane
            u[:, 2] -= np.where(np.abs(mesh.nodes[:, 2] + 1.35) < 0.2, 1.7e-3, 0.0)
        mesh = mesh.rotated(((0, 0, 1), np.radians(11.0 * number))).translated((0.08 * number, -0.05 * number, 0.0))
        material = soft(tc.LinearElastic, young)
        bodies.append(tc.Body(mesh, material, contact=sides[number], name=name, displacement=u))
    plane = tc.Plane((0.0, 0.0, -1.6017), (5e-4, 2e-4, 1.0))
    pairs = [tc.Pair("a", "b"), tc.Pair("b", "c")]
    return tc.Scene(bodies, [plane], 1.0, pairs=pairs, contact=tc.MasslessContact("full", tolerance=1e-8))


def shoulder(seed, kind):
    """Two blocks side by side on a third one, which is master of the left and slave of the right, on one face too."""
    random, bodies = np.random.default_rng(seed), []
    parts = (
        ("a", 1.0, (2, 3, 2), -0.5, "zmin"),
        ("b", 4.0, (4, 4, 3), -0.5, "zmax"),
        ("c", 16.0, (3, 5, 2), 0.06, "zmin"),
    )
    for name, young, cells, start, side in parts:
        size, origin = ((1.1, 1.0, 0.8), (start, -0.5, -0.8)) if name == "b" else ((0.54, 1.0, 0.5), (start, -0.5, 0.0))
        mesh = tc.box_mesh(size, cells, kind, origin=origin)
        u = 1e-3 * random.uniform(-1.0, 1.0, mesh.nodes.shape)
        u[:, 2] += {"a": -5e-4, "b": 0.0, "c": -5e-4}[name]
        velocity = (0.0, 0.0, 0.0) if name == "b" else (0.01, 0.0, -0.02)
        bodies.append(tc.Body(mesh, soft(tc.LinearElastic, young), velocity, side, name=name, displacement=u))
    pairs = [tc.Pair("a", "b"), tc.Pair("b", "c")]
    contact = tc.MasslessContact("full", tolerance=1e-8)
    return tc.Scene(bodies, [tc.Plane((0.0, 0.0, -5.0))], 1.0, pairs=pairs, contact=contact)


SCENES = [(chain, "hex8"), (shoulder, "hex8"), pytest.param(chain, "tet4", marks=pytest.mark.slow)]


@pytest.mark.parametrize(("make", "kind"), SCENES)
def test_three_bodies_above_a_plane_are_solved_as_by_a_dense_active_set(make, kind, monkeypatch):
    """One body, or one node, is slave and master; some rows of every pair press and some do not."""
    monkeypatch.setattr(pair_contact, "SLIP", 1e3)  # the weights stay those of the start
    for seed in range(3):
        scene = make(seed, kind)
        at_rest = [0.0 * body.mesh.nodes for body in scene.bodies]
        moved = [body.initial_displacement for body in scene.bodies]
        state = tc.CentralDifference().states(scene, tc.plan(scene), moved, at_rest)[0]
        before = np.array(arrays.get(state.u)).reshape(-1, 3)
        state.begin_contact(1e-2)
        found = np.array(arrays.get(state.u)).reshape(-1, 3)

        statics = Statics(scene, before)
        moving = np.zeros(before.shape, dtype=bool)
        moving[statics.domain.contact.nodes] = True
        below = np.setdiff1d(statics.domain.contact.nodes, statics.slaves)
        below = below[statics.positions[below, 2] < -1.5]
        plane = scene.obstacles[0]

        def wall(u, below=below, plane=plane, positions=statics.positions):
            normal = np.array(plane.normal) / np.linalg.norm(plane.normal)
            gradient = np.zeros((len(below), *u.shape))
            gradient[np.arange(len(below)), below] = normal
            return gradient.reshape(len(below), -1), (positions[below] + u[below] - plane.point) @ normal

        both = np.intersect1d(statics.slaves, np.concatenate([one.masters for one in statics.rows]))
        assert (len(both) > 0) == (make is shoulder)
        wanted, pressing = statics.equilibrium(before, moving, wall if len(below) else ())
        ends = np.cumsum([len(one.slaves) for one in statics.rows])
        for part in np.split(pressing, ends if len(below) else ends[:-1]):
            assert 0 < (part > 0.0).sum() < len(part)
        assert np.abs(found - wanted).max() <= 1e-6 * np.abs(wanted - before).max()


def test_forces_of_a_node_that_is_slave_and_master_are_in_balance():
    scene = shoulder(1, "hex8")
    result = tc.simulate(scene)
    assert result.ok
    assert all((force[:, 2] != 0.0).any() for force in result.pair_force.values())
    assert total(result, "momentum") <= 1e-12
    assert np.abs(result.history["contact_force"]).max() <= 1e-14
    ends = np.cumsum([body.mesh.node_count for body in scene.bodies])[:-1]
    left, middle, right = (part.sum(axis=0) for part in np.split(result.contact_node_force, ends))
    assert np.abs(left - result.pair_force["a-b"][-1]).max() <= 1e-15
    assert np.abs(right + result.pair_force["b-c"][-1]).max() <= 1e-15
    assert np.abs(middle + left + right).max() <= 1e-15
