"""Obstacles: gaps and normals against brute force, prescribed motion against closed forms, refusals."""

import numpy as np
import pytest

import tcontact as tc
from tcontact.scene.obstacles import Obstacle
from tcontact.scene.obstacles.motion import Motion, rotations

TURN = rotations(np.array([[0.3, -0.7, 0.4]]))[0]
PLACE = np.array([0.2, -0.1, 0.3])
SHAPES = [
    tc.Plane(PLACE, TURN[2]),
    tc.Sphere(PLACE, 0.6),
    tc.Sphere(PLACE, 0.6, inside=True),
    tc.Cylinder(PLACE, 3.0 * TURN[2], 0.6),
    tc.Cylinder(PLACE, TURN[2], 0.6, inside=True),
    tc.Box(PLACE, (1.2, 0.8, 0.5), TURN),
]
NAMES = ["plane", "sphere", "shell", "cylinder", "tube", "box"]


def cloud(count, seed=0):
    return np.random.default_rng(seed).uniform(-1.5, 1.5, (count, 3))


def surface_points(obstacle, count=40000):
    """Many points of the surface, in the world."""
    rng = np.random.default_rng(2)
    local = rng.uniform(-4.0, 4.0, (count, 3))
    if obstacle.shape == "plane":
        local[:, 2] = 0.0
    elif obstacle.shape == "box":
        half = np.array(obstacle.parameters)
        local = rng.uniform(-half, half, (count, 3))
        axis = rng.integers(3, size=count)
        local[np.arange(count), axis] = np.where(rng.random(count) < 0.5, -1, 1) * half[axis]
    else:
        part = local if obstacle.shape == "sphere" else local[:, :2]
        part *= obstacle.radius / np.linalg.norm(part, axis=1)[:, None]
    return obstacle.reference + local @ obstacle.frame


def contains(obstacle, points):
    """Whether points [n, 3] lie in the rigid material, by its definition."""
    y = (points - obstacle.reference) @ obstacle.frame.T
    if obstacle.shape == "plane":
        return y[:, 2] < 0.0
    if obstacle.shape == "box":
        return (np.abs(y) < np.array(obstacle.size) / 2).all(axis=1)
    far = np.linalg.norm(y if obstacle.shape == "sphere" else y[:, :2], axis=1) > obstacle.radius
    return far if obstacle.inside else ~far


@pytest.mark.parametrize("obstacle", SHAPES, ids=NAMES)
def test_gap_is_the_distance_to_the_surface_with_the_sign_of_the_side(obstacle):
    positions, surface = cloud(300), surface_points(obstacle)
    nearest = np.array([np.linalg.norm(surface - x, axis=1).min() for x in positions])
    gap = obstacle.gap(positions)
    assert ((gap < 0.0) == contains(obstacle, positions)).all()
    assert (nearest >= np.abs(gap) - 1e-12).all()
    # a random point of the surface lies this near to any other one, or nearer
    assert (nearest**2 <= gap**2 + 0.15**2).all()


@pytest.mark.parametrize("obstacle", SHAPES, ids=NAMES)
def test_normal_leads_to_the_surface(obstacle):
    """x - gap normal lies on the surface: the eikonal equation's characteristics are straight."""
    positions = cloud(500)
    gap, normal = obstacle.gap(positions), obstacle.normal_at(positions)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, atol=1e-14)
    np.testing.assert_allclose(obstacle.gap(positions - gap[:, None] * normal), 0.0, atol=2e-15)


@pytest.mark.parametrize("obstacle", SHAPES, ids=NAMES)
def test_record_is_complete(obstacle):
    """Gap in local coordinates from frame and reference alone; frames are rotations."""
    np.testing.assert_allclose(obstacle.frame @ obstacle.frame.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(obstacle.frame) > 0.0
    positions = cloud(100)
    local = (positions - obstacle.reference) @ obstacle.frame.T
    np.testing.assert_allclose(obstacle.local(local)[0], obstacle.gap(positions), atol=1e-14)
    assert len(obstacle.parameters) <= 8
    assert obstacle.grid is None
    assert isinstance(obstacle, Obstacle)
    assert not obstacle.moves


def test_normals_at_the_edges_of_a_box():
    box = tc.Box(size=(2.0, 2.0, 2.0))
    positions = np.array([[2.0, 2.0, 0.0], [1.0, 1.0, 1.0], [3.0, 0.5, 0.5], [0.9, 0.2, -0.95], [1.5, 1.5, 1.5]])
    half = np.sqrt(0.5)
    wanted = [[half, half, 0.0], None, [1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [np.sqrt(1 / 3)] * 3]
    for found, normal in zip(box.normal_at(positions), wanted, strict=True):
        if normal is None:
            assert np.linalg.norm(found) == 1.0  # on the corner itself: one of the faces
        else:
            np.testing.assert_allclose(found, normal, atol=1e-15)


def test_middle_of_round_shapes_has_a_normal():
    middle = np.zeros((1, 3))
    for obstacle in (tc.Sphere(radius=2.0), tc.Cylinder(radius=2.0)):
        assert obstacle.gap(middle)[0] == -2.0
        assert np.linalg.norm(obstacle.normal_at(middle)[0]) == 1.0


# motion


def poses(obstacle, times, **options):
    return Motion(obstacle, **options).poses(times)


def test_zero_rates_are_rest_as_none_is():
    """Such a plane neither turns nor moves: normal removal, no history of its load."""
    for options in ({}, {"velocity": (0, 0, 0), "angular_velocity": (0.0, 0.0, 0.0)}):
        mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
        body = tc.Body(mesh, tc.NeoHookean(1e6, 0.3, 1000.0), contact="zmin")
        planned = tc.plan(tc.Scene(body, tc.Plane(**options), duration=1e-4))
        assert planned.bodies[0].contact.removal == "normal"
        assert not planned.scene.tracked


def test_obstacle_at_rest_stays():
    points, frames, velocities, spins = poses(SHAPES[-1], [0.0, 1.0])
    assert (points == PLACE).all()
    assert (frames == SHAPES[-1].frame).all()
    assert not velocities.any()
    assert not spins.any()
    assert not tc.Sphere(velocity=(0, 0, 0)).moves


def test_constant_rates_turn_about_the_moving_point():
    """Half a turn and a full one about an axis, exactly; the point moves on a straight line."""
    box = tc.Box(PLACE, (1, 1, 1), TURN, velocity=(1.0, 2.0, 3.0), angular_velocity=(0.0, 0.0, np.pi))
    assert box.moves
    points, frames, velocities, spins = poses(box, [0.0, 0.5, 1.0, 2.0])
    np.testing.assert_allclose(points, PLACE + np.outer([0.0, 0.5, 1.0, 2.0], [1, 2, 3]), atol=1e-15)
    np.testing.assert_allclose(frames[1], TURN @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]), atol=1e-15)
    np.testing.assert_allclose(frames[2], TURN @ np.diag([-1, -1, 1]), atol=1e-15)
    np.testing.assert_allclose(frames[3], TURN, atol=1e-15)
    assert (velocities == (1.0, 2.0, 3.0)).all()
    assert (spins == (0.0, 0.0, np.pi)).all()


def test_rotations_are_exponentials_down_to_small_angles():
    """exp(2 w) = exp(w)^2, and exp(w) = 1 + [w] + ... for small w."""
    vectors = np.random.default_rng(3).normal(size=(20, 3))
    once = rotations(vectors)
    np.testing.assert_allclose(once @ once, rotations(2.0 * vectors), atol=1e-14)
    np.testing.assert_allclose(once @ np.swapaxes(once, 1, 2), np.tile(np.eye(3), (20, 1, 1)), atol=1e-14)
    small = rotations(np.array([[1e-9, 2e-9, -3e-9]]))[0]
    small = 0.5 * (small - small.T)
    np.testing.assert_allclose([small[2, 1], small[0, 2], small[1, 0]], [1e-9, 2e-9, -3e-9], rtol=1e-15)


def test_function_of_time_gives_its_integral():
    """v of degree 5 in t is integrated exactly; spin about a fixed axis turns by the integral of its rate."""
    ball = tc.Sphere(
        velocity=lambda t: np.array([6 * t**5, 1.0, -2 * t]), angular_velocity=lambda t: np.array([0.0, 0.0, 3 * t**2])
    )
    times = np.array([0.0, 0.3, 0.5, 1.1])
    points, frames, velocities, spins = poses(ball, times)
    np.testing.assert_allclose(points, np.stack([times**6, times, -(times**2)], axis=1), atol=1e-14)
    wanted = np.swapaxes(rotations(np.outer(times**3, [0.0, 0.0, 1.0])), 1, 2)
    np.testing.assert_allclose(frames, wanted, atol=1e-14)
    np.testing.assert_allclose(velocities[:, 0], 6 * times**5)
    np.testing.assert_allclose(spins[:, 2], 3 * times**2)


def test_spin_whose_axis_turns_is_of_fourth_order():
    """R(t) = exp(a t [z]) exp(b t [x]) has the spin a z + b exp(a t [z]) x."""
    a, b, end = 2.0, 3.0, 1.0
    ball = tc.Sphere(angular_velocity=lambda t: np.array([b * np.cos(a * t), b * np.sin(a * t), a]))
    exact = rotations(np.array([[0.0, 0.0, a * end]]))[0] @ rotations(np.array([[b * end, 0.0, 0.0]]))[0]
    errors = [np.abs(poses(ball, np.linspace(0, end, n + 1))[1][-1] - exact.T).max() for n in (8, 16, 32)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (np.abs(orders - 4.0) < 0.1).all()
    assert errors[-1] < 1e-6


def test_later_calls_go_on_and_earlier_times_start_anew():
    calls = []

    def velocity(t):
        calls.append(t)
        return np.array([np.cos(t), 0.0, 0.0])

    times = np.linspace(0.0, 1.0, 11)
    motion = Motion(tc.Sphere(velocity=velocity))
    whole = Motion(tc.Sphere(velocity=velocity)).poses(times)
    parts = [motion.poses(times[:4]), motion.poses(times[3:8]), motion.poses(times[7]), motion.poses(times[8:])]
    np.testing.assert_array_equal(parts[1][0], whole[0][3:8])
    np.testing.assert_array_equal(parts[2][0][0], whole[0][7])
    np.testing.assert_array_equal(parts[3][0], whole[0][8:])
    before = len(calls)
    motion.poses(times[-1])
    assert len(calls) == before + 1  # the velocity there; the path is known
    np.testing.assert_array_equal(motion.poses(times)[0], whole[0])
    np.testing.assert_allclose(
        Motion(tc.Sphere(velocity=velocity), step=0.1).poses(1.0)[0][0, 0], np.sin(1.0), rtol=1e-9
    )


def test_going_back_a_few_steps_is_as_exact_as_going_on():
    """A run that stops within a launch asks again for times it has asked for, and for others between."""
    ball = tc.Sphere(velocity=lambda t: np.array([np.cos(40 * t), 0.0, 0.0]), angular_velocity=(0, 0, 1.0))
    times = np.linspace(0.0, 1.0, 201)
    motion = Motion(ball)
    whole = motion.poses(times)[0]
    np.testing.assert_array_equal(motion.poses(times[150:])[0], whole[150:])
    between = motion.poses([0.50251])[0][0, 0]
    assert abs(between - np.sin(40 * 0.50251) / 40) < 1e-8
    np.testing.assert_allclose(motion.poses(times[101:])[0], whole[101:], atol=1e-8)
    far = Motion(ball)
    far.poses(np.linspace(0.0, 30.0, 6001))  # the first places are given up
    assert abs(far.poses([0.7])[0][0, 0] - np.sin(28.0) / 40) < 1e-8


@pytest.mark.parametrize(
    "wrong",
    [lambda t: [1.0, 2.0], lambda t: [0.0, np.nan, 0.0] if t > 0.5 else [0.0] * 3, lambda t: 1 / 0, lambda t: "x"],
)
def test_function_that_gives_no_vector_is_named_with_the_time(wrong):
    for field in ("velocity", "angular_velocity"):
        motion = Motion(tc.Sphere(name="ram", **{field: wrong}))
        with pytest.raises(tc.InputError, match=rf"Sphere.{field} of 'ram'.* t = "):
            motion.poses([0.25, 0.75])


# refusals


@pytest.mark.parametrize(
    ("field", "make"),
    [
        ("Sphere.radius", lambda: tc.Sphere(radius=0.0)),
        ("Sphere.radius", lambda: tc.Sphere(radius=np.inf)),
        ("Sphere.center", lambda: tc.Sphere(center=(0, 0))),
        ("Sphere.inside", lambda: tc.Sphere(inside="yes")),
        ("Sphere.name", lambda: tc.Sphere(name=3)),
        ("Sphere.velocity", lambda: tc.Sphere(velocity=(1.0, 2.0))),
        ("Box.angular_velocity", lambda: tc.Box(angular_velocity=(1.0, np.nan, 0.0))),
        ("Cylinder.axis", lambda: tc.Cylinder(axis=(0, 0, 0))),
        ("Cylinder.point", lambda: tc.Cylinder(point="here")),
        ("Cylinder.radius", lambda: tc.Cylinder(radius=-1.0)),
        ("Box.size", lambda: tc.Box(size=(1.0, 0.0, 1.0))),
        ("Box.axes", lambda: tc.Box(axes=np.ones((3, 3)))),
        ("Box.axes", lambda: tc.Box(axes=np.diag([1.0, 1.0, -1.0]))),
        ("Plane.velocity", lambda: tc.Plane(velocity="fast")),
        ("Plane.name", lambda: tc.Plane(name="")),
        ("Sphere.name", lambda: tc.Sphere(name="die/upper")),
        ("Box.name", lambda: tc.Box(name="two\nlines")),
    ],
)
def test_bad_input_names_the_field(field, make):
    with pytest.raises(tc.InputError) as caught:
        make()
    assert caught.value.field == field


def scene(obstacles):
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (1, 1, 1))
    body = tc.Body(mesh, tc.NeoHookean(1e6, 0.3, 1000.0), contact="zmin")
    return tc.Scene(body, obstacles, duration=1e-4)


def test_scene_takes_any_obstacle_alone_or_in_a_list():
    ball = tc.Sphere((0.5, 0.5, -1.0), 1.0)
    assert scene(ball).obstacles == (ball,)
    assert (
        len(scene([ball, tc.Plane(), tc.Box((0.5, 0.5, -0.5)), tc.Cylinder((0, 0, -2.0), (1, 0, 0), 2.0)]).obstacles)
        == 4
    )


def test_scene_refuses_a_body_inside_and_names_used_twice():
    with pytest.raises(tc.InputError, match="inside obstacle ball"):
        scene(tc.Sphere((0.5, 0.5, 0.5), 1.0, name="ball"))
    with pytest.raises(tc.InputError, match="several obstacles"):
        scene([tc.Plane(name="wall"), tc.Plane((0, 0, -1), name="wall")])
    with pytest.raises(tc.InputError, match="which has no name"):
        scene([tc.Plane(name="obstacle-1"), tc.Plane((0, 0, -1))])
    assert len(scene([tc.Plane(), tc.Plane((0, 0, -1))]).obstacles) == 2
    assert len(scene([tc.Plane(name="obstacle-0"), tc.Plane((0, 0, -1))]).obstacles) == 2
