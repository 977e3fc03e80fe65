"""Friction between bodies: rigid blocks, Coulomb's law, holding without creep, and an independent solver."""

import dataclasses

import numpy as np
import pytest
from pair_scenes import oblique_cubes, soft, total
from test_resume import split

import tcontact as tc
from cases import block_on_block

FULL = tc.MasslessContact("full")


def share(force):
    """Return friction over pressure in every row, 0 where nothing presses; forces along z."""
    return np.linalg.norm(force[:, :2], axis=1) / np.where(force[:, 2] > 0.0, force[:, 2], np.inf)


@pytest.mark.parametrize(
    "parameters",
    [
        {"removal": "normal"},
        {"removal": "full"},
        {"removal": "normal", "stiffness": 0.1},  # the lower block, between floor and block, is the slave
        {"removal": "full", "stiffness": 0.1, "direction": 70.0},
        pytest.param({"removal": "full", "kind": "tet4"}, marks=pytest.mark.slow),
        pytest.param({"removal": "normal", "kind": "tet4", "stiffness": 10.0}, marks=pytest.mark.slow),
        pytest.param({"removal": "full", "friction": 0.8, "turn": 45.0, "cells": 3}, marks=pytest.mark.slow),
    ],
)
def test_a_block_slides_to_rest_on_a_free_block(parameters):
    """Momentum, common velocity, deceleration and work are those of rigid blocks (checks of the case)."""
    result = tc.simulate(block_on_block.scene(**({"cells": 2, "lower_cells": 3} | parameters)))
    assert [check.name for check in block_on_block.checks(result) if not check.passed] == []
    momentum = result.history["momentum"]
    assert np.abs(momentum[:, :2] - momentum[0, :2]).max() <= 1e-11 * np.abs(momentum[0]).max()
    force, mu = result.pair_force["upper-lower"], parameters.get("friction", 0.3)
    assert share(force).max() <= mu * (1.0 + 1e-4)  # the tolerance of the static solve
    slides = result.history["time"] < 0.5 * result.time
    along = np.cos(np.radians(parameters.get("direction", 20.0)))
    assert -force[slides, 0].sum() / force[slides, 2].sum() == pytest.approx(mu * along, rel=0.03)


@pytest.mark.parametrize("removal", ["normal", "full"])
def test_a_block_holds_on_a_held_incline_without_creep(removal):
    """Below the angle of friction nothing moves once it has settled, and friction is the weight along the incline."""
    angle, weight = np.radians(20.0), 10.0
    low = tc.box_mesh((3, 2, 0.5), (6, 4, 1), origin=(-1.0, -0.5, -0.5))
    up = tc.box_mesh((1.5, 1, 1), (3, 2, 2)).rotated(((0, 0, 1), 0.2))
    bodies = [
        tc.Body(up, soft(tc.LinearElastic, 1e6), contact="zmin", name="up"),
        tc.Body(low, soft(tc.LinearElastic, 1e6), supports=[tc.Support("zmin", "xyz")], contact="zmax", name="low"),
    ]
    scene = tc.Scene(
        bodies,
        duration=0.15,
        gravity=weight * np.array((np.sin(angle), 0, -np.cos(angle))),
        contact=tc.MasslessContact(removal),
        damping=tc.MassDamping(500.0),
        pairs=[tc.Pair("up", "low", friction=tc.Coulomb(0.38))],
    )
    result = tc.simulate(scene)
    assert result.ok, result.reason
    force = result.pair_force["up-low"][-1]
    assert -force[0] / force[2] == pytest.approx(np.tan(angle), rel=1e-9)
    assert force[2] == pytest.approx(1.5 * weight * np.cos(angle), rel=1e-9)
    assert np.abs(result.velocity).max() <= 1e-14


def rubbing(pair):
    """Return a block that slides along a floor with friction, with another one far above in a pair or without it."""
    law = soft(tc.LinearElastic)
    first = tc.Body(tc.box_mesh((1, 1, 1), (3, 3, 3)), law, (0.05, 0.02, -0.02), contact=("zmin", "zmax"), name="a")
    other = tc.Body(tc.box_mesh((1, 1, 1), (2, 2, 2), origin=(0, 0, 3)), law, contact="zmin", name="b")
    bodies, pairs = ([first, other], [tc.Pair("a", "b")]) if pair else ([first], None)
    return tc.Scene(bodies, [tc.Plane()], duration=6.0, contact=FULL, friction=tc.Coulomb(0.4), pairs=pairs)


def test_the_solver_of_pairs_agrees_with_the_sweeps():
    """Without a partner in reach a body has no rows of pairs; obstacle and friction are those of the sweeps."""
    alone, paired = (tc.simulate(rubbing(pair), tc.CentralDifference(dt=0.12)) for pair in (False, True))
    force = alone.history["contact_force"]
    assert alone.history["friction_work"][-1] > 1e-4
    assert np.abs(force - paired.history["contact_force"]).max() <= 1e-5 * np.abs(force).max()
    assert np.abs(alone.position - paired.position[: len(alone.position)]).max() <= 1e-6


def test_oblique_impact_with_friction_conserves_and_turns_with_its_axes():
    """Energy with the heat of friction, momentum, angular momentum; the same scene along other axes is the same."""
    axis = np.array((1.0, 2.0, -0.5)) / np.linalg.norm((1.0, 2.0, -0.5))
    skew = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    rotation = np.eye(3) + np.sin(1.1) * skew + (1.0 - np.cos(1.1)) * skew @ skew
    results = [
        tc.simulate(oblique_cubes(friction=tc.Coulomb(0.3), motion=motion), tc.CentralDifference(dt=0.14))
        for motion in (None, (rotation, np.array((3.0, 1.0, -2.0))))
    ]
    for result in results:
        assert np.abs(result.history["energy_error"]).max() <= 4e-3
        assert total(result, "momentum") <= 1e-11
        assert total(result, "angular_momentum") <= 2e-3
    force = results[0].pair_force["up-low"]
    turned = results[1].pair_force["up-low"] @ rotation
    assert np.abs(turned - force).max() <= 1e-3 * np.abs(force).max()
    impulse = force.sum(axis=0)
    assert np.linalg.norm(impulse[:2]) / impulse[2] == pytest.approx(0.25, abs=0.05)  # it slides at first, then sticks
    assert results[0].history["friction_work"][-1] > 0.03 * results[0].history["kinetic"][0]


def test_every_pair_and_obstacle_has_its_own_coefficient():
    """A pair overrides the scene: the blocks slide on each other and on the floor with different friction."""
    scene = block_on_block.scene(cells=2, lower_cells=3, removal="full", friction=0.2)
    assert scene.friction == tc.Coulomb(0.0)
    assert scene.largest_friction == 0.2
    scene = dataclasses.replace(scene, friction=tc.Coulomb(0.05), duration=0.2 * scene.duration)
    result = tc.simulate(scene)
    pair, floor = result.pair_force["upper-lower"], result.history["contact_force"]
    assert np.linalg.norm(pair[5:, :2].sum(axis=0)) / pair[5:, 2].sum() == pytest.approx(0.2, rel=1e-3)
    assert np.linalg.norm(floor[5:, :2].sum(axis=0)) / floor[5:, 2].sum() == pytest.approx(0.05, rel=2e-2)


def test_a_soft_slave_under_a_sudden_load_keeps_its_ledger():
    """Gravity is switched on at once, and the slave is ten times softer."""
    scene = block_on_block.scene(cells=2, lower_cells=3, removal="full", stiffness=0.1)
    bodies = [dataclasses.replace(body, displacement=None) for body in scene.bodies]
    result = tc.simulate(dataclasses.replace(scene, bodies=bodies, duration=0.5 * scene.duration))
    assert result.ok, result.reason
    assert np.abs(result.history["energy_error"]).max() <= 2e-2
    force = result.pair_force["upper-lower"]
    assert np.linalg.norm(force[:, :2].sum(axis=0)) / force[:, 2].sum() == pytest.approx(0.3, rel=0.02)


@pytest.mark.parametrize("removal", ["normal", "full"])
def test_a_resumed_run_with_friction_has_the_same_bits(tmp_path, monkeypatch, removal):
    scene = block_on_block.scene(cells=2, lower_cells=3, removal=removal)
    scene = dataclasses.replace(scene, duration=0.02 * scene.duration)
    split(monkeypatch, tmp_path, scene, 4, tc.CentralDifference(), 3)


def test_a_scene_file_keeps_the_friction_of_pairs(tmp_path):
    pairs = [tc.Pair("up", "low", friction=tc.RegularizedCoulomb(0.3, 1e-3))]
    scene = oblique_cubes(pairs=pairs)
    tc.save_scene(scene, tmp_path / "scene.toml")
    loaded, _ = tc.load_scene(tmp_path / "scene.toml")
    assert loaded.pairs == tuple(pairs)
    assert loaded.friction == tc.RegularizedCoulomb(0.0, 1e-3)
    assert loaded.body_pairs[0].coefficient == 0.3


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (
            {"pairs": [tc.Pair("up", "low", friction=tc.FrictionLayer(points=9))], "friction": tc.FrictionLayer()},
            "coefficient only",
        ),
        (
            {"pairs": [tc.Pair("up", "low", friction=tc.RegularizedCoulomb(0.3, 1.0))], "friction": tc.Coulomb(0.3)},
            "coefficient only",
        ),
    ],
)
def test_what_friction_between_bodies_does_not_do_is_refused(options, text):
    with pytest.raises(tc.InputError, match=text):
        oblique_cubes(**options)


def test_friction_of_a_pair_is_a_model():
    with pytest.raises(tc.InputError, match=r"tcontact.Coulomb\(0.3\)"):
        tc.Pair("up", "low", friction=0.3)


def test_the_first_row_of_friction_that_depends_on_speed_does_not_depend_on_a_common_velocity():
    """Bodies that press on each other from the start, with masters that supports hold, have friction in that row."""

    def found(boost):
        boost = np.array(boost)
        upper = tc.box_mesh((1.0, 1.0, 1.0), (3, 3, 2))
        lower = tc.box_mesh((1.6, 1.7, 0.4), (3, 4, 2), origin=(-0.3, -0.3, -0.4))
        speed = boost + np.array((0.01, 0.0, 0.0))
        sides = [tc.Support("ymax", "xyz", velocity=tuple(speed))]
        load = [tc.Load("xmax", traction=(0.0, 0.0, -0.02))]
        bodies = [
            tc.Body(upper, soft(), tuple(speed), contact="zmin", supports=sides, loads=load, name="up"),
            tc.Body(lower, soft(), tuple(boost), contact="zmax", name="low"),
        ]
        friction = tc.Coulomb(static=0.4, kinetic=0.2, decay=50.0)
        contact = tc.MasslessContact("full", tolerance=1e-10)
        scene = tc.Scene(bodies, duration=0.04, contact=contact, friction=friction)
        return tc.simulate(scene, tc.CentralDifference(dt=0.02)).pair_force["up-low"]

    known = found((0.0, 0.0, 0.0))
    assert np.abs(known[0]).max() > 1e-3
    for boost in ((0.3, 0.0, 0.0), (-0.2, 0.5, 0.1)):
        assert np.abs(found(boost) - known).max() <= 1e-10 * np.abs(known).max()
