"""Scenes with pairs of bodies in checkpoints, frames, pictures and scene files; what is refused."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from pair_scenes import oblique_cubes, soft
from test_pair_runs import rings
from test_resume import split

import tcontact as tc
from tcontact.contact.pairs.pair_contact import PairContact
from tcontact.run.watches.pair_overlap import _deep_node


@pytest.mark.parametrize("path", ["serial", "parallel"])
def test_a_resumed_run_has_the_same_bits(tmp_path, monkeypatch, path, request):
    """Rows, candidates of the search and the length of the projected step are in the checkpoint."""
    if path == "parallel":
        request.getfixturevalue("parallel_path")
    whole = split(monkeypatch, tmp_path, oblique_cubes(), 4, tc.CentralDifference(), 3)
    assert whole.history["pair_pressed:up-low"].max() > 0


def test_a_resumed_run_keeps_the_gaps_that_count_as_closed(tmp_path, monkeypatch):
    whole = split(monkeypatch, tmp_path, rings("closed"), 1, tc.CentralDifference(), 10)
    assert whole.history["pair_rebuilds"][-1] > 2


def test_many_rows_a_launch_and_one_row_a_launch_are_the_same_run(request):
    """The large path measures in a parallel pass, the small one in the launch that solves."""
    scheme = tc.CentralDifference(dt=0.14)
    one = tc.simulate(oblique_cubes(), scheme)
    request.getfixturevalue("parallel_path")
    other = tc.simulate(oblique_cubes(), scheme)
    assert np.abs(one.position - other.position).max() <= 1e-9


@pytest.mark.parametrize("slave", ["up", "low"])
def test_frames_hold_the_contact_force_of_both_bodies(tmp_path, slave):
    """Force and moment of the pair are those of the nodes of its first body, slave or master."""
    scene = oblique_cubes(duration=1.0, pairs=[tc.Pair("up", "low", slave=slave)])
    result = tc.simulate(scene, out=tmp_path / "run", frames=3)
    force = result.contact_node_force
    up = scene.bodies[0].mesh.node_count
    assert np.abs(force[:up].sum(axis=0) - result.pair_force["up-low"][-1]).max() <= 1e-15
    assert np.abs(force.sum(axis=0)).max() <= 1e-15
    moment = np.cross(result.position[:up], force[:up]).sum(axis=0)
    assert np.abs(moment - result.pair_moment["up-low"][-1]).max() <= 1e-15
    assert (tmp_path / "run" / "result.vtkhdf").is_file()


@pytest.mark.parametrize("contact", [tc.MasslessContact("full"), tc.PenaltyContact(10.0)])
def test_bodies_that_are_apart_have_frames_without_pressure(tmp_path, contact):
    """No row exists at the first frame nor at the last one: nothing is pressed, and nothing fails."""
    scene = oblique_cubes(contact=contact)
    apart = replace(scene.bodies[0], mesh=scene.bodies[0].mesh.translated((0, 0, 0.9)))
    scene = replace(scene, bodies=[apart, scene.bodies[1]], pairs=[tc.Pair("up", "low")], duration=1.0)
    result = tc.simulate(scene, out=tmp_path / "run", frames=3)
    assert result.ok, result.reason
    assert result.history["pair_rows:up-low"].max() == 0
    assert np.abs(result.contact_node_force).max() == 0.0


def test_a_scene_file_keeps_the_pairs(tmp_path):
    pairs = [tc.Pair("up", "low", slave="up")]
    tc.save_scene(oblique_cubes(pairs=pairs), tmp_path / "scene.toml")
    scene, _ = tc.load_scene(tmp_path / "scene.toml")
    assert scene.pairs == tuple(pairs)
    assert scene.body_pairs[0].slave == 0


CUBES = oblique_cubes()


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"pairs": [tc.Pair("up", "side")]}, "side.*use one of the bodies: up, low"),
        ({"pairs": [tc.Pair("up", "low"), tc.Pair("low", "up")]}, "name each pair once"),
        ({"pairs": "all"}, "list of tcontact.Pair"),
        ({"pairs": [tc.Pair("up", "low")], "contact": tc.ImpulseContact()}, "MasslessContact"),
        ({"pairs": [tc.Pair("up", "low")], "contact": tc.MasslessContact(penalty=1e3)}, "no penalty"),
        (
            {"pairs": [tc.Pair("up", "low")], "contact": tc.MasslessContact(solver="gauss-seidel")},
            "projected gradients",
        ),
    ],
)
def test_scenes_that_cannot_be_are_refused(options, text):
    with pytest.raises(tc.InputError, match=text):
        replace(CUBES, **options)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: tc.Pair("a", "a"), "contact of a body with itself"),
        (lambda: tc.Pair("a", "b", slave="c"), "give 'a', 'b' or None"),
        (lambda: tc.Pair("a", ""), "name of a body"),
        (lambda: tc.Pair("a", "b", slave=np.array(["a", "b"])), "give 'a', 'b' or None"),
        (lambda: tc.Pair("a", "b", initial_gap="open"), "as-meshed"),
    ],
)
def test_pairs_that_cannot_be_are_refused(make, text):
    with pytest.raises(tc.InputError, match=text):
        make()


def test_slaves_in_a_circle_are_refused():
    bodies = [
        tc.Body(tc.box_mesh((1, 1, 1), (2, 2, 2), origin=(2.0 * i, 0, 0)), soft(), contact=("xmin", "xmax"), name=name)
        for i, name in enumerate("abc")
    ]
    pairs = [tc.Pair("a", "b", slave="a"), tc.Pair("b", "c", slave="b"), tc.Pair("c", "a", slave="c")]
    with pytest.raises(tc.InputError, match="circle"):
        tc.Scene(bodies, duration=1.0, pairs=pairs)


def test_bodies_that_overlap_at_the_start_are_refused_with_names_and_depth(tmp_path):
    low = CUBES.bodies[1]
    into = replace(CUBES, bodies=[CUBES.bodies[0], replace(low, mesh=low.mesh.translated((0, 0, 0.05)))])
    with pytest.raises(tc.InputError, match=r"low.*0\.048 m inside up near"):
        tc.simulate(into, out=tmp_path / "run")
    assert not (tmp_path / "run" / "result.vtkhdf").exists()


@pytest.mark.parametrize("scheme", [tc.Midpoint(dt=1e-2), tc.DiscreteGradient(dt=1e-2)])
def test_implicit_schemes_refuse_pairs_by_name(scheme):
    with pytest.raises(tc.InputError, match="pair"):
        tc.simulate(replace(CUBES, pairs=[tc.Pair("up", "low")]), scheme)


def test_with_another_solver_bodies_stop_where_they_meet():
    """Nothing is silently wrong where contact between bodies is not available."""
    contact = tc.MasslessContact("full", solver="gauss-seidel")
    scene = replace(CUBES, contact=contact, obstacles=[tc.Plane((0, 0, -5.0))])
    assert scene.body_pairs == ()
    assert tc.simulate(scene).reason == "bodies-meet"


def test_normal_removal_needs_one_direction():
    scene = replace(CUBES, contact=tc.MasslessContact("normal"))
    tc.plan(scene)
    turned = [replace(body, mesh=body.mesh.rotated(((1, 0, 0), 0.8 * i))) for i, body in enumerate(CUBES.bodies)]
    with pytest.raises(tc.InputError, match="15 degrees of one direction"):
        tc.plan(replace(scene, bodies=turned, pairs=[tc.Pair("up", "low")]))


def test_a_body_and_a_wall_press_the_same_nodes_from_two_sides():
    """The side of the lower cube is in its contact set, and a wall moves into it beneath the upper one."""
    scene = oblique_cubes(duration=6.0)
    low = replace(scene.bodies[1], contact=("zmax", "xmin"))
    up = replace(scene.bodies[0], mesh=scene.bodies[0].mesh.translated((-0.25, 0.0, 0.0)), velocity=(0.0, 0.0, -0.05))
    wall = tc.Plane((-0.13, 0.0, 0.0), (1.0, 0.0, 0.0), velocity=(0.1, 0.0, 0.0))
    pairs = [tc.Pair("up", "low", slave="low")]
    result = tc.simulate(replace(scene, bodies=[replace(up, contact="zmin"), low], obstacles=[wall], pairs=pairs))
    assert result.ok
    assert result.history["static_residual"].max() <= 1e-4
    assert result.history["gap_min"].min() >= -1e-6
    assert np.abs(result.history["energy_error"]).max() <= 1e-2
    assert result.pair_force["up-low"][:, 2].max() > 0.01
    assert result.obstacle_force["obstacle-0"][:, 0].min() < -0.01


@pytest.mark.parametrize("slave", ["low", "up"])
def test_a_node_that_is_squeezed_between_a_body_and_an_obstacle_stops_the_run_by_name(slave):
    """A plane rises through a thin plate, whose contact nodes it meets from below where a cube presses from above."""
    plate = tc.Body(tc.box_mesh((1, 1, 0.3), (4, 4, 2), origin=(0, 0, -0.3)), soft(), contact="zmax", name="low")
    cube = tc.box_mesh((1, 1, 1), (3, 3, 3), origin=(0.1, 0.1, 0.002))
    bodies = [tc.Body(cube, soft(), (0.0, 0.0, -0.05), contact="zmin", name="up"), plate]
    lift = tc.Plane((0.0, 0.0, -0.32), velocity=(0.0, 0.0, 0.1), name="lift")
    pairs = [tc.Pair("up", "low", slave=slave)]
    result = tc.simulate(tc.Scene(bodies, [lift], 5.0, pairs=pairs, contact=tc.MasslessContact("full")))
    assert result.reason == "not-converged"
    assert "squeezed" in result.message
    assert "obstacle lift" in result.message
    assert f"body {'low' if slave == 'up' else 'up'}" in result.message


def test_two_pairs_of_one_name_are_refused():
    bodies = [replace(CUBES.bodies[0], name=name) for name in ("a", "b-c", "a-b", "c")]
    with pytest.raises(tc.InputError, match="two pairs have this name"):
        tc.Scene(bodies, duration=1.0, pairs=[tc.Pair("a", "b-c"), tc.Pair("a-b", "c")])


def test_faces_outside_the_contact_sets_that_meet_stop_the_run():
    """The upper cube comes from the side; the contact faces of the pair do not face each other."""
    low, up = CUBES.bodies[1], CUBES.bodies[0]
    beside = replace(up, mesh=tc.box_mesh((1, 1, 1), (4, 4, 4), origin=(1.05, 0.05, -0.95)), velocity=(-0.3, 0.0, 0.0))
    result = tc.simulate(replace(CUBES, bodies=[beside, low], duration=6.0, pairs=[tc.Pair("up", "low")]))
    assert result.reason == "missed-contact"
    assert "up" in result.message
    assert "low" in result.message
    assert result.time < 4.0


def test_bodies_that_pass_the_faces_of_each_other_in_one_step_stop_the_run():
    scene = replace(CUBES, bodies=[replace(CUBES.bodies[0], velocity=(0.0, 0.0, -6.0)), CUBES.bodies[1]], duration=1.0)
    result = tc.simulate(scene, tc.CentralDifference(dt=0.1))
    assert not result.ok


def test_a_node_in_the_hole_of_a_body_is_not_deep_in_it():
    """It is far from the surface and within the hull; one in the middle of the material is deep."""
    mesh = tc.ring_mesh(0.5, 1.5, 1.2, 24, layers=1)
    faces = mesh.boundary_faces()
    closed = np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])
    hole, inside, outside = np.array([[0.0, 0.1, 0.0], [0.97, 0.1, 0.03], [2.0, 0.0, 0.0]])
    assert _deep_node(np.stack([hole, outside]), mesh.nodes, closed, 0.3) is None
    assert (_deep_node(np.stack([hole, inside]), mesh.nodes, closed, 0.3) == inside).all()
    assert _deep_node(np.stack([hole, inside]), mesh.nodes, closed, 0.6) is None


def test_rows_are_not_built_where_the_run_has_diverged():
    term = PairContact(tc.plan(CUBES).domains[0])
    term.rebuild(np.full((len(term._reference), 3), np.nan))
    assert term.rebuilds == 0


@pytest.mark.parametrize("slave", ["up", "low"])
def test_a_slave_too_coarse_for_the_curvature_of_its_master_is_told(slave):
    """Two faces along each side of a block under a ball of its size: as a slave they press though 2e-4 m are free."""
    ball = tc.ball_mesh(0.02, 4, center=(0.0, 0.0, 0.02 + 2e-4))
    box = tc.box_mesh((0.04, 0.04, 0.02), (2, 2, 2), origin=(-0.02, -0.02, -0.02))
    bodies = [tc.Body(box, soft(), contact="zmax", name="low"), tc.Body(ball, soft(), contact="low", name="up")]
    scene = tc.Scene(bodies, duration=1e-9, pairs=[tc.Pair("low", "up", slave=slave)])
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        tc.simulate(scene)
    told = [str(one.message) for one in said if issubclass(one.category, tc.SlaveWarning)]
    assert len(told) == (slave == "low")
    assert all("make up the slave" in text for text in told)
