"""Which faces of two bodies may meet: their distances and angles decide, not the axes, units or order of a scene."""

import numpy as np
import pytest
from oracle import meshes

import tcontact as tc
from tcontact.planning.planning import plan
from tcontact.scene.meeting import FACING, area_vectors, facing_faces, unit

LOW = (-0.01, -0.013, -0.1005)  # of the lower body; it lies half a millimetre below the upper one [m]


def bodies(axes, length=1.0, pressure=1.0, ratio=1.3, swapped=False, kind="hex8"):
    """Two blocks of `ratio` in stiffness above each other, turned by axes [3, 3], in units of length and pressure."""

    def body(size, counts, at, young, speed, name):
        mesh = tc.box_mesh(size, counts, kind=kind).translated(at)
        turned = tc.Mesh(mesh.nodes @ axes.T * length, mesh.cells, mesh.kind)
        material = tc.LinearElastic(young * pressure, 0.3, 1000.0 * pressure / length**2)
        return tc.Body(turned, material, axes @ np.array(speed) * length, contact="auto", name=name)

    upper = body((0.1, 0.1, 0.1), (3, 3, 3), (0.0, 0.0, 0.0), 1e7, (0.3, 0.4, -3.0), "upper")
    lower = body((0.13, 0.12, 0.1), (4, 4, 4), LOW, 1e7 * ratio, (0.0, 0.0, 0.0), "lower")
    return [lower, upper] if swapped else [upper, lower]


def scene(*given, **options):
    return tc.Scene(bodies(*given, **options), duration=2e-3)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_contact_faces_and_removal_do_not_depend_on_the_axes(seed, kind):
    """Blocks turned in space have the contact nodes of blocks along the axes: those of the two faces that meet."""
    straight, turned = (plan(scene(axes, kind=kind)).bodies for axes in (np.eye(3), meshes.rotation(seed)))
    for one, other in zip(straight, turned, strict=True):
        assert np.array_equal(one.body.contact_nodes, other.body.contact_nodes)
        assert one.contact.removal == other.contact.removal == "normal"
    assert [len(one.body.contact_nodes) for one in straight] == [16, 25]


@pytest.mark.parametrize("ratio", [0.6, 0.8, 1.0, 1.3, 1.6])
def test_the_slave_does_not_depend_on_units_and_order(ratio):
    """Stiffness counts in powers of 2 over that of the softest body, then the size of the faces."""
    found = {
        made.label(made.body_pairs[0].slave)
        for pressure in (1.0, 1e-6, 1.45e-4, 0.7, 0.9)
        for swapped in (False, True)
        for made in [scene(np.eye(3), 1e3, pressure, ratio, swapped)]
    }
    assert found == {"lower" if ratio < 2.0**0.5 else "upper"}  # its faces are the smaller ones


def test_runs_of_turned_blocks_are_those_of_straight_ones():
    """Positions and force of the pair, turned back, to the tolerance of the static solve."""
    axes, scheme = meshes.rotation(5), tc.CentralDifference(dt=1e-4)
    straight, turned = (tc.simulate(scene(one), scheme) for one in (np.eye(3), axes))
    force = straight.pair_force["upper-lower"]
    assert np.abs(force).max() > 1e3
    assert np.abs(turned.pair_force["upper-lower"] @ axes - force).max() < 1e-6 * np.abs(force).max()
    assert np.abs(turned.position @ axes - straight.position).max() < 1e-9


def brute_force(corners, others, way, slack):
    """Return which faces may meet some face of the others, taken one by one."""
    normals, directions = unit(area_vectors(corners)), unit(area_vectors(others))
    found = np.zeros(len(corners), dtype=bool)
    for k, (face, n) in enumerate(zip(corners, normals, strict=True)):
        for other, d in zip(others, directions, strict=True):
            c, p = face.mean(axis=0), other.mean(axis=0)
            radii = sum(np.linalg.norm(one - one.mean(axis=0), axis=1).max() for one in (face, other))
            faces = n @ d < FACING and (n @ (other - c).T).max() > -slack and (d @ (c - other).T).max() > -slack
            found[k] |= faces and np.linalg.norm(p - c) <= way + slack + radii
    return found


@pytest.mark.parametrize("seed", range(6))
def test_no_face_that_may_meet_another_one_is_missed(seed):
    """Pairs of faces taken one by one; groups may find more faces, but none that look away or lie out of reach."""
    random = np.random.default_rng(seed)
    shapes = [tc.ball_mesh(0.05, 2), tc.box_mesh((0.1, 0.06, 0.04), (3, 2, 2)), tc.cylinder_mesh(0.03, 0.1, 4)]
    one, other = (shapes[k] for k in random.choice(3, 2))
    at = unit(random.normal(size=(1, 3)))[0] * random.uniform(0.05, 0.25)
    parts = []
    for mesh, place in ((one, np.zeros(3)), (other, at)):
        body = tc.Body(mesh, tc.LinearElastic(1e7, 0.3, 1e3), contact="auto")
        parts.append(body.initial_nodes[body.outer_faces] @ meshes.rotation(seed).T + place)
    way, slack = random.uniform(0.0, 0.1), 0.01
    found, wanted = facing_faces(*parts, way, slack), brute_force(*parts, way, 0.99 * slack)
    assert found[wanted].all()
    distance = np.linalg.norm(parts[0].mean(axis=1)[:, None] - parts[1].mean(axis=1)[None], axis=2).min(axis=1)
    assert (distance[found] <= way + slack + 0.12).all()
    assert not facing_faces(parts[0], parts[1] + 10.0, way, slack).any()


def test_bodies_without_faces_meet_nothing():
    faces = np.zeros((0, 4, 3))
    some = tc.box_mesh((1.0, 1.0, 1.0), (1, 1, 1)).nodes[[[0, 1, 3, 2]]]
    assert facing_faces(faces, some, 1.0, 0.1).shape == (0,)
    assert not facing_faces(some, faces, 1.0, 0.1).any()


@pytest.mark.parametrize(("floor", "meets"), [(-1.0, False), (0.5, True)])
def test_a_face_meets_what_lies_before_it(floor, meets):
    """A face that looks along x and a little down, above a floor that begins at `floor` and is half a metre long."""
    square = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    ground = square[None] * 0.5 + np.array([floor, -0.25, 0.0])
    down, aside = np.array([0.4, 0.0, 0.9]), np.array([0.0, 1.0, 0.0])
    face = (np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) - 0.5) @ np.array([aside, down]) * 0.1
    face = face[None] + np.array([0.0, 0.0, 0.1])
    n = unit(area_vectors(face))[0]
    assert n[0] > 0.9
    assert n[2] < FACING
    assert facing_faces(face, ground, 2.0, 0.01)[0] == facing_faces(ground, face, 2.0, 0.01)[0] == meets
