"""Contact nodes that pass through a thin obstacle stop the run; those that are held, or go round an edge, do not."""

import re

import numpy as np
import pytest
from oracle import meshes
from scenes import material

import tcontact as tc
from tcontact.planning.body_plan import SMALL
from tcontact.run.watches.path_watch import Crossing, half_thickness
from tcontact.schemes.chosen_nodes import ChosenNodes

SOFT = material("linear")
EDGE = 0.1
PLATE = tc.Box((0.0, 0.0, -0.011), (1.0, 1.0, 0.002))
CONTACTS = {
    "massless, full": tc.MasslessContact(removal="full"),
    "massless, normal": tc.MasslessContact(removal="normal"),
    "massless penalty": tc.MasslessContact(removal="full", penalty=1e11),
    "penalty": tc.PenaltyContact(1e11),
    "impulse": tc.ImpulseContact(),
}


def cube(speed, cells=3, kind="hex8", contact="zmin", factor=1.0, **options):
    """A cube over the plane z = 0 that falls at that speed."""
    edge = EDGE * factor
    mesh = tc.box_mesh((edge,) * 3, (cells,) * 3, kind, (-edge / 2, -edge / 2, 0.0))
    options = {"velocity": (0.0, 0.0, -speed)} | options
    return tc.Body(mesh, SOFT, contact=contact, name="cube", **options)


def run(obstacle, speed=15.0, contact=None, scheme=None, body=None, duration=None, **options):
    """A cube thrown at an obstacle 10 mm below it."""
    contact = CONTACTS["massless, full"] if contact is None else contact
    duration = 0.02 / max(speed, 1.0) + 1e-3 if duration is None else duration
    scene = tc.Scene([body or cube(speed)], [obstacle], duration, contact=contact, **options)
    return tc.simulate(scene, scheme or tc.CentralDifference())


@pytest.fixture
def small(monkeypatch):
    for kind in SMALL:
        monkeypatch.setitem(SMALL, kind, 10**6)


def missed(result, shape):
    """It stopped at the miss, with the node, the obstacle and a remedy."""
    assert result.reason == "missed-contact", result.message
    assert re.search(rf"node \d+ of cube passed through {shape} obstacle-0 at t = ", result.message)
    assert len(result.history["time"]) == result.steps + 1
    return True


def advised(result):
    """The step that the message advises [s]."""
    return float(re.search(r"use dt=([-+.\de]+) or less", result.message)[1])


@pytest.mark.parametrize("name", CONTACTS)
def test_a_cube_does_not_fly_through_a_thin_plate_in_silence(name):
    """30 m/s and 2 mm: the nodes move further in a step than the plate is thick; with the advised step they are held.

    Held: the force on the cube stops it, so its momentum turns, as it does on a thick block.
    """
    result = run(PLATE, 30.0, CONTACTS[name])
    assert missed(result, "box")
    dt = min(advised(result), 0.9 * result.dt_limit)
    finer = run(PLATE, 30.0, CONTACTS[name], tc.CentralDifference(dt=dt))
    thick = run(tc.Box((0.0, 0.0, -0.51), (1.0, 1.0, 1.0)), 30.0, CONTACTS[name], tc.CentralDifference(dt=dt))
    assert finer.ok
    assert thick.ok
    pushed = finer.history["impulse"][-1, 2]
    assert pushed == pytest.approx(thick.history["impulse"][-1, 2], rel=1e-6)
    assert pushed > 0.8 * 30.0 * SOFT.density * EDGE**3


def test_small_bodies_that_take_many_steps_a_launch_are_followed_step_by_step(small):
    first = run(PLATE, 30.0)
    assert missed(first, "box")
    assert first.time < 0.012 / 30.0 + 2.0 * first.dt


@pytest.mark.parametrize(
    "obstacle",
    [
        tc.Box((0.0, 0.0, -0.03), (0.4, 0.4, 0.002), axes=meshes.rotation(5)),
        tc.Cylinder((0.0, 0.0, -0.012), (1.0, 0.0, 0.0), 0.001),
        tc.Sphere((0.0, 0.0, -0.0115), 0.0015),
        tc.Sdf(lambda x: np.abs(x[:, 2] + 0.02) - 0.01, origin=(-0.3, -0.3, -0.04), spacing=0.005, nodes=(121, 121, 9)),
    ],
    ids=["box", "cylinder", "sphere", "sdf"],
)
def test_every_shape_with_a_far_side(obstacle):
    speed = 400.0 if obstacle.shape == "sdf" else 60.0
    body = cube(speed, cells=2)  # a node over the axis
    assert missed(run(obstacle, speed, CONTACTS["penalty"], body=body), obstacle.shape)


def test_shapes_without_a_far_side_are_not_looked_at():
    from tcontact.run.watches.path_watch import PathWatch

    class Inside:
        scene = tc.Scene(
            [cube(1.0)],
            [tc.Plane((0, 0, -1.0)), tc.Sphere((0, 0, 0), 5.0, True), tc.Cylinder((0, 0, 0), (1, 0, 0), 5.0, True)],
            1.0,
        )

    assert PathWatch.of(Inside()) is None


@pytest.mark.parametrize(
    "velocity", [(0.0, 0.0, 30.0), lambda t: (0.0, 0.0, 2e4 * t)], ids=["constant", "function of time"]
)
def test_a_plate_that_flies_through_a_resting_cube(velocity, small):
    plate = tc.Box((0.0, 0.0, -0.05), (1.0, 1.0, 0.002), velocity=velocity)
    result = run(plate, 0.0, duration=5e-3)
    assert missed(result, "box")
    arrival = 0.049 / 30.0 if not callable(velocity) else np.sqrt(2 * 0.049 / 2e4)
    assert result.time == pytest.approx(arrival, abs=3.0 * result.dt)


def test_the_size_of_the_scene_does_not_matter():
    thin = tc.Box((0.0, 0.0, -0.011e-3), (1e-3, 1e-3, 0.002e-3))
    result = run(thin, 30.0, body=cube(30.0, factor=1e-3), duration=1e-6)
    assert missed(result, "box")


def test_a_soft_penalty_presses_nodes_through_slowly():
    """Through the middle they are pushed out on the far side; the advice is not a smaller step."""
    for scheme in (tc.CentralDifference(dt=1e-5), tc.DiscreteGradient(dt=5e-5)):
        result = run(PLATE, 15.0, tc.PenaltyContact(1e8), scheme, duration=3e-3)
        assert missed(result, "box")
        assert "larger contact stiffness" in result.message
        assert ("use dt" in result.message) == scheme.implicit  # which goes far in a step, too


def test_implicit_steps():
    result = run(PLATE, 60.0, tc.PenaltyContact(1e10), tc.DiscreteGradient(dt=1e-4))
    assert missed(result, "box")


def test_a_body_that_slides_over_an_edge_is_not_stopped():
    """It goes from one face of a thick box round the edge, with nodes on both faces and beyond."""
    mesh = tc.box_mesh((EDGE,) * 3, (4,) * 3, "hex8", (-0.05, -0.05, 1e-4))
    for contact in (CONTACTS["massless, full"], CONTACTS["penalty"]):
        body = tc.Body(mesh, SOFT, velocity=(20.0, 0.0, -5.0), contact=("zmin", "xmin"), name="cube")
        block = tc.Box((-0.06, 0.0, -0.05), (0.1, 1.0, 0.1))
        result = run(block, contact=contact, body=body, duration=0.01)
        assert result.ok, result.message
        assert np.abs(result.history["contact_force"]).max() > 0.0


class Held(ChosenNodes):
    """The state of a body whose nodes are put somewhere."""

    def __init__(self, nodes):
        self.nodes = np.array(nodes, dtype=float)
        self.plan = type("Plan", (), {})()
        self.plan.contact = type("Contact", (), {"nodes": np.arange(len(self.nodes))})()
        self.plan.reference = np.zeros_like(self.nodes)

    def latest(self):
        return self.nodes


def passes(obstacle, start, *ways):
    """Whether a node that goes from start to each of the ways is found to have passed through the obstacle."""
    state = Held([start])
    crossing = Crossing(state, obstacle, half_thickness(obstacle), 1.0)
    found = []
    for way in ways:
        state.nodes = np.array([way], dtype=float)
        found.append(crossing.follow(crossing.positions(state, 0.0))[0] is not None)
    return found[-1] if len(found) == 1 else found


def test_paths_of_single_nodes():
    """Through, past, onto and off a plate of thickness 0.2; into it as far as the middle, and beyond."""
    plate = tc.Box(size=(4.0, 4.0, 0.2))
    assert passes(plate, (0.3, 0.1, 1.0), (0.3, 0.1, -5.0))
    assert passes(plate, (-1.5, 0.0, 3.0), (1.5, 0.0, -3.0))
    assert passes(plate, (0.0, 0.0, 0.1), (0.0, 0.0, -0.1))  # from face to face
    assert not passes(plate, (5.0, 0.0, 1.0), (5.0, 0.0, -1.0))  # beside it
    assert not passes(plate, (0.0, 0.0, 0.1), (1.0, 0.0, 0.1))  # along the face
    assert not passes(plate, (0.0, 0.0, 0.1), (0.5, 0.0, 3.0))  # rebound
    assert not passes(plate, (1.9, 0.0, 0.1), (2.0, 0.0, 0.0))  # round the edge
    assert passes(plate, (0.0, 0.0, 0.5), (0.0, 0.0, 0.05), (0.0, 0.0, 0.01), (0.0, 0.0, -0.01)) == [False, False, True]
    assert passes(plate, (0.0, 0.0, 0.5), (0.0, 0.0, 0.05), (0.0, 0.0, 0.5), (0.0, 0.0, -0.5)) == [False, False, True]


def test_paths_against_a_sphere_agree_with_geometry():
    """A straight way through a sphere turns the normal by more than a right angle where it comes near the centre."""
    generator = np.random.default_rng(8)
    ball = tc.Sphere((0.2, -0.1, 0.4), 0.7)
    seen = set()
    for _ in range(200):
        start, end = ball.center + generator.normal(size=(2, 3)) * 2.0
        along = (end - start) / np.linalg.norm(end - start)
        if min(np.linalg.norm(start - ball.center), np.linalg.norm(end - ball.center)) < 0.75:
            continue
        middle = (ball.center - start) @ along
        offset = np.linalg.norm(start + middle * along - ball.center)
        hits = offset < 0.7 and 0.0 < middle < np.linalg.norm(end - start)
        turn = -np.cos(2.0 * np.arcsin(min(1.0, offset / 0.7)))  # cosine between the two normals
        if abs(turn + 0.1) < 1e-3:
            continue
        wanted = bool(hits and turn < -0.1)
        assert passes(ball, start, end) == wanted
        seen.add(wanted)
    assert seen == {True, False}


def sampled(distance, spacing=0.05, count=41):
    """A sampled solid about the origin."""
    origin = (-0.5 * spacing * (count - 1),) * 3
    return tc.Sdf(distance, origin=origin, spacing=spacing, nodes=(count,) * 3)


def block_distance(half):
    """Exact distance to a block of these half sizes."""
    shape = tc.Box(size=2.0 * np.array(half))
    return lambda x: shape.local(x)[0]


def test_how_thin_a_sampled_solid_is():
    """A plate and a ball by their exact distance, turned too; a half-space has no far side, a thick part hides none."""
    for half in ((0.6, 0.6, 0.1), (0.12, 0.7, 0.5), (0.4, 0.4, 0.4)):
        assert half_thickness(sampled(block_distance(half))) == pytest.approx(min(half), abs=0.05)
        turn = meshes.rotation(4)
        turned = sampled(lambda x, half=half, turn=turn: block_distance(half)(x @ turn.T))
        assert half_thickness(turned) == pytest.approx(min(half), abs=0.06)
    assert half_thickness(sampled(lambda x: np.linalg.norm(x, axis=1) - 0.7)) == pytest.approx(0.7, abs=0.1)
    assert half_thickness(sampled(lambda x: x @ np.array([0.6, 0.0, 0.8]))) == np.inf
    both = sampled(lambda x: np.minimum(block_distance((0.5, 0.5, 0.1))(x), np.linalg.norm(x, axis=1) - 0.4))
    assert half_thickness(both) == pytest.approx(0.1, abs=0.06)
    with_one_layer = sampled(block_distance((0.6, 0.6, 0.03)))
    assert 0.025 <= half_thickness(with_one_layer) <= 0.05


def test_thin_parts_of_a_sampled_obstacle_are_passed_through_and_thick_ones_not():
    plate = sampled(block_distance((0.8, 0.8, 0.1)))
    assert passes(plate, (0.3, 0.1, 0.7), (0.3, 0.1, -0.7))
    assert not passes(plate, (0.95, 0.0, 0.7), (0.95, 0.0, -0.7))
    assert not passes(plate, (0.3, 0.1, 0.7), (0.31, 0.1, 0.05))


@pytest.mark.parametrize("removal", ["full", "normal"])
def test_motions_are_not_asked_for_beyond_the_end(removal):
    """Looks ask ahead; a function that is known until the end and one step more is enough for the run."""
    asked = []

    def velocity(time):
        asked.append(time)
        return 0.0, 0.0, 0.1

    plate = tc.Box((0.0, 0.0, -0.1), (1.0, 1.0, 0.1), velocity=velocity)
    far = tc.Plane((9.0, 0.0, 0.0), (-1.0, 0.0, 0.0), velocity=velocity)
    body = cube(0.0, cells=2)
    obstacles = [plate, far] if removal == "normal" else [plate]
    scene = tc.Scene([body], obstacles, 5e-3, contact=CONTACTS[f"massless, {removal}"])
    result = tc.simulate(scene)
    assert result.reason == "finished", result.message
    assert max(asked) <= scene.duration + 2.0 * result.dt
