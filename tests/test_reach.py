"""`contact="auto"`: the faces that may meet an obstacle are found; the run is that of the named set."""

import dataclasses

import numpy as np
import pytest
from scenes import material

import tcontact as tc

FLOOR = tc.Plane(point=(0.0, 0.0, -1e-3))


def scene(mesh=None, velocity=(0.0, 0.0, -3.0), obstacles=(FLOOR,), duration=2e-3, **options):
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (3, 3, 3)) if mesh is None else mesh
    contact = options.pop("contact_set", "auto")
    keys = {key: options.pop(key) for key in ("periodic", "displacement") if key in options}
    body = tc.Body(mesh, material(), velocity=velocity, contact=contact, **keys)
    return tc.Scene(bodies=[body], obstacles=obstacles, duration=duration, **options)


def found(of):
    return {frozenset(face) for face in of.bodies[0].contact_faces.tolist()}


def named(of, *names):
    return {frozenset(face) for face in of.bodies[0].mesh.faces_of(names).tolist()}


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_a_falling_cube_has_its_lower_face(kind):
    falling = scene(tc.box_mesh((0.1, 0.1, 0.1), (3, 2, 3), kind))
    assert found(falling) == named(falling, "zmin")


def test_the_run_is_that_of_the_named_set_bit_for_bit():
    runs = [tc.simulate(scene(contact_set=name)) for name in ("auto", "zmin")]
    assert runs[0].history["contact_nodes"].max() > 0
    assert np.array_equal(runs[0].position, runs[1].position)


@pytest.mark.parametrize(
    ("changes", "reached"),
    [
        ({"velocity": (0, 0, -0.1)}, True),  # within the shortest edge
        ({"obstacles": [tc.Plane(point=(0, 0, -1.0))]}, False),
        ({"obstacles": [tc.Plane(point=(0, 0, -1.0))], "duration": 0.3}, True),
        ({"obstacles": [tc.Plane(point=(0, 0, -1.0))], "velocity": (0, 0, 0), "duration": 0.5}, False),
        (
            {
                "obstacles": [tc.Plane(point=(0, 0, -1.0))],
                "velocity": (0, 0, 0),
                "duration": 0.5,
                "gravity": (0, 0, -9),
            },
            True,
        ),
        ({"obstacles": [tc.Plane(point=(0, 0, -1.0), velocity=(0, 0, 600.0))]}, True),
        ({"obstacles": [tc.Plane(point=(0, 0, -1.0), velocity=lambda t: (0, 0, 6e5 * t))]}, True),
        ({"obstacles": [tc.Box((0.05, 0.05, -1.0), (0.1, 0.1, 1.0))]}, False),
        ({"obstacles": [tc.Box((0.05, 0.05, -1.0), (0.1, 0.1, 1.0), angular_velocity=(0, 300.0, 0))]}, True),
        ({"obstacles": [tc.Plane(point=(0, 0, -0.09))]}, False),
        ({"obstacles": [tc.Plane(point=(0, 0, -0.09))], "displacement": (0, 0.03, 0)}, True),  # it may swing back
        ({"obstacles": [tc.Sphere(center=(0.05, 0.05, -0.02), radius=0.015)]}, True),
        ({"obstacles": []}, False),
        ({"contact": None, "obstacles": []}, False),
    ],
)
def test_what_can_be_reached_in_time_counts(changes, reached):
    thrown = scene(**changes)
    assert found(thrown) == (named(thrown, "zmin") if reached else set())
    assert tc.plan(thrown).bodies[0].contact is not None or not reached


def test_a_shell_around_a_body_is_reached_by_all_sides():
    inside = scene(obstacles=[tc.Sphere(center=(0.05, 0.05, 0.05), radius=0.1, inside=True)])
    sides = ("xmin", "xmax", "ymin", "ymax", "zmin", "zmax")
    assert found(inside) == named(inside, *sides)


def test_a_changed_scene_finds_them_anew():
    short = scene(obstacles=[tc.Plane(point=(0, 0, -1.0))])
    longer = dataclasses.replace(short, duration=0.3)
    assert not found(short)
    assert found(longer) == named(longer, "zmin")
    assert found(dataclasses.replace(longer, obstacles=[])) == set()


def test_sides_that_repeat_are_left_out():
    column = scene(periodic="xy", obstacles=[FLOOR])
    assert found(column) == named(column, "zmin")


def test_a_set_called_auto_goes_first():
    box = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2))
    own = scene(box.with_sets(face_sets={"auto": box.face_sets["zmax"]}))
    assert found(own) == named(own, "zmax")


def test_a_body_that_starts_inside_is_refused():
    with pytest.raises(tc.InputError, match="inside obstacle"):
        scene(obstacles=[tc.Plane(point=(0, 0, 0.01))])


def test_a_round_body_on_a_plane_has_its_lower_half():
    """Faces that look up cannot meet the floor; those that look down and are near can."""
    box = tc.box_mesh((2.0, 2.0, 2.0), (4, 4, 4), origin=(-1, -1, -1))
    nodes = np.array(box.nodes)
    largest = np.abs(nodes).max(axis=1, keepdims=True)
    length = np.linalg.norm(nodes, axis=1, keepdims=True).clip(1e-9)
    ball = tc.Mesh(nodes * (0.6 + 0.4 * largest / length), box.cells, "hex8")
    dropped = scene(ball, obstacles=[tc.Plane(point=(0, 0, -1.001))], duration=1e-3)
    nodes = ball.nodes[np.unique(dropped.bodies[0].contact_faces)]
    assert len(nodes) > 9
    assert nodes[:, 2].max() < 0.0
    assert tc.simulate(scene(ball, obstacles=[tc.Plane(point=(0, 0, -1.001))], duration=1e-3)).ok
