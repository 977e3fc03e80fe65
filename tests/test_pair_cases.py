"""Cases of bodies that touch each other: their checks hold at small size, and fail where the physics does."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from pair_scenes import touches

import tcontact as tc
from tcontact.cases import clamped_plate, ring_in_ring, stack, two_spheres
from tcontact.mesh.mapped import tetrahedra
from tcontact.results import checks as ck


def failed(case, result):
    """The checks that fail."""
    return {check.name for check in case.checks(result) if not check.passed}


def spoilt(result, **columns):
    """A result with other columns: functions of what is there."""
    return replace(
        result, history=result.history | {name: made(result.history[name].copy()) for name, made in columns.items()}
    )


def drawn_again(case, result, folder):
    """What a case draws from its stored history alone."""
    case.draw(SimpleNamespace(history=result.history, scene=result.scene, time=result.time), folder, "again")
    return [path.name for path in folder.iterdir()]


def changed(row, value):
    """A function that puts a value into a row of a column."""

    def made(column):
        column[row] = value
        return column

    return made


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_the_ball_is_one(kind):
    mesh = tc.ball_mesh(2.0, 8, kind)
    assert ck.volume(mesh) == pytest.approx(4.0 / 3.0 * np.pi * 8.0, rel=2e-2)
    assert np.linalg.norm(mesh.nodes, axis=1).max() == pytest.approx(2.0, rel=1e-12)
    skin = mesh.nodes[np.unique(mesh.boundary_faces())]
    np.testing.assert_allclose(np.linalg.norm(skin, axis=1), 2.0, rtol=1e-12)
    assert (mesh.nodes[mesh.nodes_of("low")][:, 2] < 0).all()
    assert (mesh.nodes[mesh.nodes_of("high")][:, 2] > 0).all()


def test_cut_hexahedra_fill_what_they_were():
    """The diagonals on both sides of a face agree: nothing but faces of the skin lies bare."""
    whole = tc.ball_mesh(1.0, 4)
    cut = tetrahedra(whole)
    assert len(cut.boundary_faces()) == 2 * len(whole.boundary_faces())
    assert cut.cell_volumes().sum() == pytest.approx(whole.cell_volumes().sum(), rel=2e-2)  # flat for curved faces
    assert (cut.cell_volumes() > 0).all()


@pytest.fixture(scope="module")
def balls():
    return tc.simulate(two_spheres.scene())


def test_two_balls_follow_hertz(balls):
    """Eight faces along a quarter of the rim, meshes turned by 30 degrees, linear law."""
    assert not failed(two_spheres, balls)
    most, _, duration = two_spheres.theory(balls.scene)
    force, time = balls.pair_force["upper-lower"][:, 2], balls.history["time"]
    assert 1.05 <= force.max() / most <= 1.2
    assert 0.9 <= np.ptp(time[force > 1e-3 * most]) / duration <= 1.05
    assert np.abs(balls.history["energy_error"]).max() <= 4e-3
    assert touches(force) == 1


def test_balls_that_do_not_follow_hertz_fail(balls):
    force = balls.history["pair_force:upper-lower"]
    for columns, name in (
        ({"pair_force:upper-lower": lambda f: 1.1 * f}, "largest force / Hertz"),
        ({"time": lambda t: 1.2 * t}, "duration of the contact / Hertz"),
        ({"pair_force:upper-lower": changed(120, 0.0)}, "touches"),
        ({"pair_force:upper-lower": changed(120, -1e-6 * force.max(axis=0))}, "pull / largest push"),
        ({"pair_gap_min:upper-lower": changed(100, -1e-7)}, "overlap / face"),
        ({"energy_error": changed(-1, 0.1)}, "energy error"),
        ({"momentum": lambda p: p + np.linspace(0.0, 1e-6, len(p))[:, None]}, "momentum = impulses"),
    ):
        assert name in failed(two_spheres, spoilt(balls, **columns)), name
    assert "finished" in failed(two_spheres, replace(balls, ok=False, reason="diverged"))


def test_a_ring_turns_in_a_press_fit(tmp_path):
    result = tc.simulate(ring_in_ring.scene(cells=12, outer_cells=24))
    assert not failed(ring_in_ring, result)
    assert drawn_again(ring_in_ring, result, tmp_path) == ["spin.png"]
    force, pair = result.contact_node_force, "inner-outer"
    one = force.copy()
    one[result.scene.bodies[0].contact_nodes[0]] *= 1.1
    for other, name in (
        (replace(result, contact_node_force=1.5 * force), "pressure at the end / Lame"),
        (replace(result, contact_node_force=one), "spread of the pressure / mean"),
        (spoilt(result, **{f"pair_pressed:{pair}": changed(5, 3.0)}), "rows without pressure"),
        (spoilt(result, **{f"pair_moment:{pair}": lambda m: m + 1e-3}),
         "angular momentum that the slave takes / start"),
        (spoilt(result, angular_momentum=lambda a: a * np.linspace(1.0, 1.1, len(a))[:, None]),
         "angular momentum gained / (lag x pressing force x time)"),
    ):  # fmt: skip
        assert name in failed(ring_in_ring, other), name


def test_the_press_fit_is_that_of_lame():
    """The stresses of both rings from their displacements, at the fit and at the free rims."""
    law, other = tc.NeoHookean(2e7, 0.3, 1e3), tc.NeoHookean(1e7, 0.2, 1e3)
    pressure, *fields = ring_in_ring.press_fit([law, other], 1e-3, 0.1)
    for one, (a, b, axial), free in ((law, fields[0], 0.05), (other, fields[1], 0.15)):
        for radius, wanted in ((0.1, -pressure), (free, 0.0)):
            radial, hoop = a - b / radius**2, a + b / radius**2
            stress = one.lame_lambda * (radial + hoop + axial) + 2.0 * one.lame_mu * np.array([radial, axial])
            np.testing.assert_allclose(stress, (wanted, 0.0), atol=1e-9 * pressure)
    inward, outward = (ring_in_ring.change(0.1, field) for field in fields)
    assert outward - inward == pytest.approx(1e-3)


def test_a_stack_comes_to_rest_under_its_weight():
    result = tc.simulate(stack.scene(cells=2, blocks=3))
    assert not failed(stack, result)
    for columns, name in (
        ({"contact_force": changed(-1, 0.0)}, "force / weight, floor: error"),
        ({"pair_force:block-2-block-3": lambda f: 1.01 * f}, "force / weight, block-2-block-3: error"),
        ({"gap_min": changed(30, -1e-3)}, "overlap / cell"),
        ({"momentum": changed(-2, 10.0)}, "way in the last tenth / cell"),
    ):
        assert name in failed(stack, spoilt(result, **columns)), name
    moving = replace(result, velocity=result.velocity + 0.01)
    assert "fastest node at the end x duration / cell" in failed(stack, moving)


def test_a_ball_falls_on_a_plate_out_of_a_file(tmp_path):
    """A file of one's own takes the place of the one that the case writes."""
    small = {"cells": 6, "layers": 2, "ball_cells": 6, "plate_radius": 2.0}
    scene = clamped_plate.scene(**small)
    result = tc.simulate(scene)
    assert not failed(clamped_plate, result)
    assert drawn_again(clamped_plate, result, tmp_path) == ["deflection.png"]
    clamped_plate.write_plate(tmp_path / "own.msh", 0.1, 0.02, 6, 2)
    own = clamped_plate.scene(mesh=str(tmp_path / "own.msh"), ball_cells=6)
    for one, other in zip(scene.bodies, own.bodies, strict=True):
        np.testing.assert_allclose(one.mesh.nodes, other.mesh.nodes, atol=1e-15)
        np.testing.assert_array_equal(one.mesh.cells, other.mesh.cells)
    assert own.duration == pytest.approx(scene.duration)
    for columns, name in (
        ({"pair_force:ball-plate": lambda f: 1.4 * f}, "largest force / thin plate"),
        ({"time": lambda t: 1.3 * t}, "first to last touch / thin plate"),
        ({"momentum": lambda p: 1.2 * p}, "largest mean deflection / thin plate"),
        ({"pair_force:ball-plate": lambda f: 0.7 * f}, "rebound - thin plate / speed"),
        ({"support_impulse": lambda p: 0.9 * p}, "momentum = impulses"),
    ):
        assert name in failed(clamped_plate, spoilt(result, **columns)), name


def test_a_thin_plate_alone_swings_in_its_modes_and_keeps_the_energy():
    """Without a spring to speak of the plate stays and the ball goes on; with it the ball's momentum is conserved."""
    scene = clamped_plate.scene(cells=4, layers=2, ball_cells=4)
    motion = clamped_plate.thin_plate(scene.bodies)
    ball = scene.bodies[0]
    given = np.sum(motion.force) * (motion.time[1] - motion.time[0]) / ball.mass
    assert motion.speed == pytest.approx(given + ball.initial_velocity[0, 2], rel=1e-9)
    assert 0.0 < motion.speed < -ball.initial_velocity[0, 2]


@pytest.mark.parametrize(
    ("case", "wrong", "field"),
    [
        (two_spheres, {"cells": 2}, "cells"),
        (two_spheres, {"contact_radius": 0.5}, "contact_radius"),
        (ring_in_ring, {"outer_cells": 2.5}, "outer_cells"),
        (ring_in_ring, {"misfit": 0.0}, "misfit"),
        (stack, {"blocks": 1}, "blocks"),
        (stack, {"drop": -1.0}, "drop"),
        (clamped_plate, {"layers": 1}, "layers"),
        (clamped_plate, {"plate_radius": 1.0}, "plate_radius"),
        (clamped_plate, {"mesh": "nowhere.msh"}, "nowhere"),
    ],
)
def test_parameters_that_cannot_be_are_refused_by_name(case, wrong, field):
    with pytest.raises(tc.InputError, match=field):
        case.scene(**wrong)
