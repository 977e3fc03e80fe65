"""Obstacles with a shape in pictures: where they are, which side is drawn, what hides the body, what is refused."""

import dataclasses
import json

import numpy as np
import pytest
import surfaces
from PIL import Image

import tcontact as tc
from tcontact.results.files.vtkhdf import ResultData, ResultFile
from tcontact.scene.obstacles.description import describe
from tcontact.scene.obstacles.isosurface import isosurface
from tcontact.scene.obstacles.surface import volume
from tcontact.show.render.camera import Eye
from tcontact.show.render.planes import Patch
from tcontact.show.render.solids import Pose, hides, outlined, read_solids, shaded
from tcontact.show.render.studio import Studio
from tcontact.show.render.triangles import Triangles

CENTRE, RADIUS = np.array([0.1, 0.2, 1.5]), 0.8
SHAPES = [
    tc.Sphere((0.2, 0.1, 0.0), 0.7),
    tc.Sphere((0.2, 0.1, 0.0), 300.0),
    tc.Sphere((0.0, 0.0, 0.0), 3.0, inside=True),
    tc.Cylinder((0.2, 0.1, 0.0), (1.0, 2.0, 0.5), 0.6),
    tc.Cylinder((0.2, 0.1, 0.0), (1.0, 2.0, 0.5), 100.0),
    tc.Cylinder((0.0, 0.0, 0.0), (1.0, 2.0, 0.5), 4.0, inside=True),
    tc.Box((0.2, 0.1, 0.0), (1.0, 2.0, 0.5), tc.Cylinder(axis=(1, 1, 1)).frame),
    tc.Sdf.from_surface(surfaces.torus(), cells=8),
]


def drawn(obstacle, times=()):
    """The obstacle as a picture gets it from a file."""
    return read_solids(json.loads(json.dumps(describe([obstacle], times))))[0]


def eye_from(position, target=(0.0, 0.0, 0.0)):
    back = np.asarray(position, float) - target
    back /= np.linalg.norm(back)
    right = np.cross((0.0, 1.0, 0.0) if abs(back[2]) > 0.9 else (0.0, 0.0, 1.0), back)
    right /= np.linalg.norm(right)
    axes = np.array([right, np.cross(back, right), back])
    return Eye(np.asarray(position, float), axes, 500.0, (200.0, 150.0), Triangles.plain(np.empty((0, 3, 3)), 0), None)


@pytest.mark.parametrize("obstacle", SHAPES[:-1])
def test_mesh_lies_on_the_surface_and_faces_the_bodies(obstacle):
    points, triangles = drawn(obstacle).mesh(0.0, CENTRE, RADIUS)
    size = np.linalg.norm(np.ptp(points, axis=0))
    np.testing.assert_allclose(obstacle.gap(points), 0.0, atol=1e-9 * max(size, 300.0))
    a, b, c = (points[triangles[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    wide = np.linalg.norm(normal, axis=1) > 1e-6 * size**2 / len(triangles)
    middle = (a + b + c)[wide] / 3.0
    assert (np.einsum("ni,ni->n", normal[wide], obstacle.normal_at(middle)) > 0.0).all()


def test_mesh_reaches_around_what_is_seen():
    """A large ball and an endless cylinder are drawn near the body alone, fine enough to look round."""
    for obstacle in (SHAPES[1], SHAPES[3], SHAPES[4]):
        points, _ = drawn(obstacle).mesh(0.0, CENTRE, RADIUS)
        foot = CENTRE - obstacle.gap(CENTRE[None])[0] * obstacle.normal_at(CENTRE[None])[0]
        away = np.linalg.norm(points - foot, axis=1)
        assert away.min() < 0.1 * RADIUS
        assert 1.9 * RADIUS < away.max() < 4.0 * RADIUS


def test_poses_of_the_frames_are_drawn():
    box = tc.Box((1.0, 0.0, 0.0), (1, 2, 3), velocity=(0, 0, 2.0), angular_velocity=(0, 0, np.pi / 2))
    solid = drawn(box, [0.0, 0.5, 1.0])
    assert solid.pose.moves
    extents = [np.ptp(solid.mesh(time, CENTRE, RADIUS)[0], axis=0) for time in (0.0, 1.0)]
    np.testing.assert_allclose(extents, [[1, 2, 3], [2, 1, 3]], atol=1e-9)
    np.testing.assert_allclose(solid.mesh(1.0, CENTRE, RADIUS)[0].mean(axis=0), [1.0, 0.0, 2.0], atol=1e-9)
    surface = tc.Sdf.from_surface(surfaces.box(), cells=8, velocity=lambda t: np.array([2 * t, 0.0, 0.0]))
    np.testing.assert_allclose(
        drawn(surface, [0.0, 3.0]).mesh(3.0, CENTRE, RADIUS)[0].mean(axis=0), [9, 0, 0], atol=1e-9
    )


def test_disc_of_a_plane_goes_with_it_and_stays_under_the_body():
    wall = tc.Plane(velocity=(40.0, 0.0, -1.0))
    disc = Patch.under(np.array([[-1.0, -1, 0], [1, 1, 1]]), wall.point, wall.normal, True)
    pose = Pose.read(describe([wall], [0.0, 0.5])[0], 0)
    there = disc.carried(pose, 0.5)
    assert abs(there.centre[2] + 0.5) < 1e-12
    assert np.abs(there.centre[:2] - disc.centre[:2]).max() <= 2 * disc.radius / 14 + 1e-12
    np.testing.assert_allclose(disc.carried(pose, 0.0).centre, disc.centre, atol=1e-12)


def test_only_faces_that_look_at_the_eye_are_drawn():
    ball, shell = drawn(tc.Sphere(radius=0.5)), drawn(tc.Sphere(radius=0.5, inside=True))
    eye = eye_from((0.0, 0.0, 5.0))
    near, far = (shaded(one.mesh(0.0, CENTRE, RADIUS), eye).screen[..., 2] for one in (ball, shell))
    assert near.min() > 1 / 5.0  # inverse depth: nearer than the middle
    assert far.max() < 1 / 4.9


def test_outline_of_a_ball_is_its_limb_and_of_a_block_its_edges():
    eye = eye_from((0.0, 0.0, 5.0))
    lines = outlined(drawn(tc.Sphere(radius=0.5)).mesh(0.0, CENTRE, RADIUS), eye, 1.0).screen[..., :2]
    away = np.linalg.norm(lines - eye.centre, axis=-1)
    assert np.abs(away - 500.0 * 0.5 / np.sqrt(25 - 0.25)).max() < 4.0
    lines = outlined(drawn(tc.Box()).mesh(0.0, CENTRE, RADIUS), eye, 1.0).screen[..., :2] - eye.centre
    assert len(lines) == 2 * 12 * 48
    assert np.isclose(np.abs(lines).max(axis=(1, 2)), 500.0 * 0.5 / 4.5, atol=1.0).any()


def test_what_stands_before_the_body_hides_it():
    body = np.random.default_rng(0).uniform(-0.3, 0.3, (50, 3)) + np.array([0.0, 0.0, 1.0])
    for obstacle, above, below in (
        (tc.Sphere(radius=0.6), False, True),
        (tc.Sphere(radius=4.0, inside=True), False, False),
    ):
        mesh = drawn(obstacle).mesh(0.0, CENTRE, RADIUS)
        assert hides(mesh, eye_from((0.0, 0.5, 6.0)), body) is above
        assert hides(mesh, eye_from((0.0, 0.5, -6.0)), body) is below


def test_the_contact_face_is_seen_from_the_obstacle_that_presses_it(tmp_path):
    """A ball presses the top of a block: the key picture looks down on it, through the outline of the ball."""
    mesh = tc.box_mesh((1.0, 1.0, 0.5), (6, 6, 3))
    ball = tc.Sphere((0.5, 0.5, 1.0), 0.5)
    path, down = tmp_path / "result.vtkhdf", np.zeros_like(mesh.nodes)
    down[:, 2] = np.where(np.linalg.norm(mesh.nodes - (0.5, 0.5, 0.5), axis=1) < 0.1, -3.0, 0.0)
    with ResultFile.create(path, mesh.nodes, [("hex8", mesh.cells)], {"obstacles": describe([ball], ())}) as file:
        nodal = {"displacement": 0 * down, "contact_force": down, "contact_pressure": -down[:, 2]}
        file.append(0.0, nodal, {"von_mises": np.zeros(mesh.cell_count)})
    (picture,) = Studio(ResultData.open(path), (320, 240), 1.0, None).contact_face(tmp_path / "face.png")
    image = np.asarray(Image.open(picture))[30:200, :250].astype(int)
    assert ((image[..., 0] > 150) & (image[..., 1] < 60) & (image[..., 2] < 80)).sum() > 20


def test_sampled_distance_is_drawn_where_it_is_zero():
    ball = tc.Sdf(
        lambda x: np.linalg.norm(x, axis=1) - 0.5, origin=(-0.7, -0.71, -0.72), spacing=0.05, nodes=(29, 29, 29)
    )
    points, triangles = isosurface(ball.grid[..., 0], ball.origin, ball.spacing)
    np.testing.assert_allclose(ball.gap(points), 0.0, atol=2e-3)
    assert abs(volume(points, triangles) / (np.pi / 6.0) - 1.0) < 0.01
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    assert len(drawn(ball).mesh(0.0, CENTRE, RADIUS)[1]) == len(triangles)


@pytest.mark.parametrize(
    ("wrong", "word"),
    [
        ({"kind": "torus"}, "torus"),
        ({"kind": "sphere", "point": [0, 0, 0]}, "2 finite"),
        ({"kind": "sphere", "parameters": [1.0, 1.0]}, "obstacles"),
        ({"kind": "sphere", "point": [0, 0], "parameters": [1.0, 1.0]}, "finite points"),
        ({"kind": "box", "point": [0, 0, 0], "parameters": [1.0, np.nan, 1.0]}, "finite"),
        ({"kind": "sdf", "point": [0, 0, 0]}, "cannot be read"),
        ({"kind": "sphere", "parameters": [1.0, 1.0], "motion": {"time": [0.0]}}, "motion"),
    ],
)
def test_obstacles_that_cannot_be_drawn_are_refused(wrong, word):
    with pytest.raises(tc.InputError, match=word):
        read_solids([wrong])


def named_scene(path, obstacles):
    """A cube before these obstacles."""
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
    with ResultFile.create(path, mesh.nodes, [("hex8", mesh.cells)], {"obstacles": describe(obstacles)}) as file:
        file.append(0.0, {"displacement": np.zeros_like(mesh.nodes)}, {"von_mises": np.zeros(mesh.cell_count)})
    return ResultData.open(path)


def test_names_stand_on_the_obstacles_beside_the_bodies(tmp_path):
    floor, ball = tc.Plane(name="floor"), tc.Sphere((-1.2, 0.5, 0.5), 0.6)
    data = named_scene(tmp_path / "two.vtkhdf", [floor, ball])
    studio = Studio(data, (480, 360), 1.0, None)
    eye = studio.camera("above")
    assert eye.signs.names == ("floor", "obstacle-1")
    named = np.asarray(studio.picture(data.frame(0), "von_mises", (0.0, 1.0), eye)).astype(int)
    plain = Studio(data, (480, 360), 1.0, None)
    image = plain.picture(data.frame(0), "von_mises", (0.0, 1.0), dataclasses.replace(eye, signs=None))
    rows, columns = np.nonzero((named != np.asarray(image).astype(int)).any(axis=2))
    for part in eye.signs.places:
        corner = part.screen[np.isfinite(part.screen).all(axis=(1, 2))]
        (left, top), (right, bottom) = corner[..., :2].min(axis=(0, 1)), corner[..., :2].max(axis=(0, 1))
        assert ((columns >= left) & (columns <= right) & (rows >= top) & (rows <= bottom)).sum() > 50
    (left, top), (right, bottom) = eye.signs.bodies[:, :2].min(axis=0), eye.signs.bodies[:, :2].max(axis=0)
    assert not ((columns > left) & (columns < right) & (rows > top) & (rows < bottom)).any()
    assert len(rows) < 2500  # two names and nothing else


def test_a_name_is_written_as_a_whole_or_not_at_all(tmp_path):
    """A body that moves before the name of its obstacle hides all of it; one beside it, and its shadow, nothing.

    Once the name ended where the rectangle began in which the body and its shadow are drawn.
    """
    data = named_scene(tmp_path / "one.vtkhdf", [tc.Plane(name="a long road")])
    studio = Studio(data, (480, 360), 1.0, None)
    eye, frame = studio.camera("above"), data.frame(0)
    start = written(studio, frame, eye)
    way = start.reshape(2, 2).mean(axis=1) - eye.project(np.full((1, 3), 0.5))[0, :2]  # from the cube to the name
    right, up = way * (1, -1) * eye.distance / eye.focal
    seen = []
    for share in np.linspace(0.0, 1.0, 13):
        frame.point_data["displacement"][:] = share * (right * eye.axes[0] + up * eye.axes[1])
        seen.append(written(studio, frame, eye))
    whole = [extent is not None and np.abs(extent - start).max() <= 2 for extent in seen]
    assert [extent is not None for extent in seen] == whole
    assert whole[0]
    assert not whole[-1]
    assert 2 <= sum(whole) <= 11


def written(studio, frame, eye):
    """First and last column, first and last row of what the names of obstacles change in a picture; None: nothing."""
    with_names, without = (
        np.asarray(studio.picture(frame, "von_mises", (0.0, 1.0), one)).astype(int)
        for one in (eye, dataclasses.replace(eye, signs=None, fixed=dataclasses.replace(eye.fixed)))
    )
    rows, columns = np.nonzero((with_names != without).any(axis=2))
    return np.array([columns.min(), columns.max(), rows.min(), rows.max()]) if len(rows) else None


def test_one_obstacle_without_a_name_has_none(tmp_path):
    for number, (obstacles, names) in enumerate(
        (([tc.Plane()], None), ([tc.Plane(name="floor")], ("floor",)), ([], None))
    ):
        eye = Studio(named_scene(tmp_path / f"{number}.vtkhdf", obstacles), (160, 120), 1.0, None).camera("above")
        assert (eye.signs and eye.signs.names) == names
