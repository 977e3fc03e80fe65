"""Scenes of many bodies ask each of them once, and get the pairs, groups and domains of all pairs taken in turn."""

import itertools

import numpy as np
import pytest
from counted import Name, Passes

import tcontact as tc
from tcontact.planning.removal import choose_removal
from tcontact.scene import meeting
from tcontact.scene.body import Body
from tcontact.scene.connections import connected
from tcontact.scene.meeting import facing_faces
from tcontact.scene.pairs import BodyPair, _check_order, _check_pair_names, slave_order
from tcontact.scene.reach import speed_by_loads

RUBBER = tc.NeoHookean(young=1e6, poisson=0.3, density=1000.0)


def cube(origin, name, contact="auto", cells=(1, 1, 1), **options):
    """Return a cube of 10 mm at an origin."""
    return tc.Body(tc.box_mesh((0.01,) * 3, cells, origin=origin), RUBBER, name=name, contact=contact, **options)


def column(count):
    """Return a scene with cubes of which each stands on the one below, in contact with it."""
    bodies = [cube((0, 0, 0.01 * i), f"b{i}", ("zmin", "zmax"), (2, 2, 2)) for i in range(count)]
    return tc.Scene(bodies, duration=2e-5)


def by_closure(count, links):
    """Return the groups of bodies by adding links to each body until nothing is added."""
    found = []
    for number in range(count):
        group = {number}
        while more := set().union(*(set(link) for link in links if set(link) & group)) - group:
            group |= more
        found.append(tuple(sorted(group)))
    return tuple(found)


@pytest.mark.parametrize("seed", range(20))
def test_connected_bodies_are_those_that_links_lead_to(seed):
    """Random links of one to three bodies, against the closure of each body by itself."""
    random = np.random.default_rng(seed)
    count = int(random.integers(1, 30))
    links = [random.integers(count, size=random.integers(1, 4)).tolist() for _ in range(random.integers(0, 25))]
    assert connected(count, links) == by_closure(count, links)


def test_a_plan_goes_through_the_pairs_as_often_for_many_bodies_as_for_few():
    """Bodies in a chain of pairs find their common removal and their domain together, not each by itself."""
    counts = []
    for count in (3, 9):
        scene = column(count)
        pairs = Passes(scene.body_pairs)
        object.__setattr__(scene, "body_pairs", pairs)
        domains = tc.plan(scene).domains
        assert [domain.numbers for domain in domains] == [tuple(range(count))]
        assert domains[0].pairs == tuple(pairs)
        assert {choose_removal(scene, number) for number in range(count)} == {"normal"}
        counts.append(pairs.count)
    assert counts[0] == counts[1]


def test_bodies_far_from_each_other_are_compared_by_their_boxes_alone(monkeypatch):
    """Faces are put into groups for bodies that are near; speeds and loads are found a few times for every body.

    Bodies that meet are looked at once more where they are closest, for the bend that decides which one is the slave.
    """
    calls = {"groups": 0, "driven": 0}
    groups_of, driven_speed = meeting.groups_of, Body.driven_speed

    def grouped(directions):
        calls["groups"] += 1
        return groups_of(directions)

    def driven(body, duration):
        calls["driven"] += 1
        return driven_speed(body, duration)

    monkeypatch.setattr(meeting, "groups_of", grouped)
    monkeypatch.setattr(Body, "driven_speed", driven)
    count = 8
    scene = tc.Scene([cube((0.05 * i, 0, 0), f"b{i}") for i in range(count)], [tc.Plane()], duration=2e-4)
    assert scene.body_pairs == ()
    assert calls["groups"] == 0
    assert calls["driven"] <= 2 * count
    scene = tc.Scene([cube((0.0101 * i, 0, 0), f"b{i}") for i in range(count)], duration=2e-4)
    assert 0 < calls["groups"] <= 2 * count + 2 * len(scene.body_pairs)


def one_by_one(scene, bodies):
    """Return contact faces and pairs of bodies with contact="auto", every body with every other one."""

    def asked(one, other, faces):
        speed = np.linalg.norm(one.initial_velocity - one.initial_velocity.mean(axis=0), axis=1).max()
        speed += np.linalg.norm(other.initial_velocity - one.initial_velocity.mean(axis=0), axis=1).max()
        fall = scene.largest_gravity * scene.duration
        fall += sum(speed_by_loads(body, scene.duration) for body in (one, other))
        slack = one.mesh.shortest_edge + other.mesh.shortest_edge
        corners = [body.initial_nodes[part] for body, part in zip((one, other), faces, strict=True)]
        if not all(map(len, corners)):
            return np.zeros(len(corners[0]), dtype=bool)
        return facing_faces(*corners, 1.5 * (speed + fall) * scene.duration, slack)

    numbers, faces = range(len(bodies)), []
    for i in numbers:
        found = np.zeros(len(bodies[i].outer_faces), dtype=bool)
        for k in numbers:
            if k != i:
                found |= asked(bodies[i], bodies[k], [bodies[i].outer_faces, bodies[k].outer_faces])
        faces.append(bodies[i].outer_faces[found])
    pairs = [
        (i, k) for i, k in itertools.combinations(numbers, 2) if asked(bodies[i], bodies[k], [faces[i], faces[k]]).any()
    ]
    return faces, pairs


@pytest.mark.parametrize("seed", range(12))
def test_contact_faces_and_pairs_are_those_of_every_body_with_every_other_one(seed):
    """Random bodies that rest, fly and spin, near and far from each other."""
    random = np.random.default_rng(seed)
    shapes = [tc.ball_mesh(0.05, 2), tc.box_mesh((0.1, 0.06, 0.04), (3, 2, 2)), tc.cylinder_mesh(0.03, 0.1, 4)]
    bodies = []
    for number in range(6):
        mesh = shapes[random.integers(3)].translated(random.uniform(-0.3, 0.3, 3))
        drift, spin = random.normal(size=3) * random.choice([0.0, 1.0, 20.0]), random.choice([0.0, 30.0])
        speed = drift + spin * np.cross((0.0, 0.0, 1.0), mesh.nodes)
        bodies.append(tc.Body(mesh, RUBBER, speed, contact="auto", name=f"b{number}"))
    scene = tc.Scene(bodies, duration=float(10.0 ** random.uniform(-4, -2)), gravity=(0, 0, -9.81))
    faces, pairs = one_by_one(scene, bodies)
    assert [(pair.first, pair.second) for pair in scene.body_pairs] == pairs
    for body, wanted in zip(scene.bodies, faces, strict=True):
        assert np.array_equal(body.contact_faces, wanted)


def test_names_are_compared_in_proportion_to_their_number():
    """Names of bodies and of pairs of bodies are counted, not each looked for among all."""
    uses = []
    for count in (10, 40):
        names = [Name(f"b{i}") for i in range(count)]
        bodies = [cube((0.05 * i, 0, 0), name, None) for i, name in enumerate(names)]
        Name.uses = 0
        scene = tc.Scene(bodies, duration=1e-4)
        _check_pair_names([BodyPair(name, 0, 1, 0) for name in names])
        uses.append(Name.uses)
        assert scene.bodies[1].name == "b1"
    assert uses[1] <= 4 * uses[0]
    with pytest.raises(tc.InputError, match="'b': used by several bodies"):
        tc.Scene([cube((0, 0, 0), "a"), cube((1, 0, 0), "b"), cube((2, 0, 0), "b")], duration=1e-4)


def test_the_order_of_slaves_goes_through_the_pairs_a_few_times():
    """A chain of bodies of which each is slave of the next one; a circle behind it is named by its first body."""
    chain = Passes(BodyPair(f"p{i}", i, i + 1, i) for i in range(20))
    labels = [f"b{i}" for i in range(24)]
    _check_order(chain, labels)
    assert chain.count == 1
    assert slave_order(chain, 24) == [*range(21), 0, 0, 0]
    assert chain.count == 3
    circle = [*chain, BodyPair("q", 21, 22, 21), BodyPair("r", 22, 23, 22), BodyPair("s", 21, 23, 23)]
    with pytest.raises(tc.InputError, match=r"'b21'.* circle"):
        _check_order(circle, labels)
