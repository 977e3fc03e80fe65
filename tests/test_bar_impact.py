"""A bar of Poisson's ratio 0 against a wall: the exact one-dimensional impact (METHOD 2)."""

from functools import cache

import numpy as np
import oracle
import pytest
from oracle import meshes
from scenes import simulate

import tcontact as tc

LENGTH, YOUNG, DENSITY, SPEED = 0.43, 7e9, 2700.0, 3.0


def bar_scene(kind, count, gap_steps, contact, axis=0, cross=1, shift=(0.1, -0.4, 1.3)):
    """A slanted bar of `cross` x `cross` cells, `gap_steps` steps of flight from the wall; the exact solution."""
    turn, h = meshes.rotation(3), LENGTH / count
    size, cells = [cross * h] * 3, [cross] * 3
    size[axis], cells[axis] = LENGTH, count
    box = tc.box_mesh(size, cells, kind)
    mesh = box.rotated(turn).translated(shift)
    mat = tc.LinearElastic(young=YOUNG, poisson=0.0, density=DENSITY)
    normal = turn[:, axis]
    gap = gap_steps * SPEED * 0.9 * h / np.sqrt(YOUNG / DENSITY)
    body = tc.Body(mesh, mat, velocity=-SPEED * normal, contact="xyz"[axis] + "min")
    exact = oracle.BarImpact(LENGTH, (cross * h) ** 2, YOUNG, DENSITY, SPEED, gap)
    point = ((mesh.nodes @ normal).min() - gap) * normal
    duration = exact.release + 4 * h / exact.wave_speed
    scene = tc.Scene(bodies=[body], obstacles=[tc.Plane(point, normal)], duration=duration, contact=contact)
    return scene, exact, normal


@cache
def figures(kind, count, gap_steps, contact, **how):
    """Figures of the table, the contact force along the axis and the result."""
    scene, exact, normal = bar_scene(kind, count, gap_steps, contact, **how)
    result = simulate(scene, cfl=0.9)
    history = result.history
    force = history["contact_force"] @ normal
    found = oracle.bar_metrics(exact, history["time"], force, result.dt, history["momentum"][-1] @ normal)
    found["energy"] = history["energy_error"].max()
    found["side"] = np.abs(history["contact_force"] - np.outer(force, normal)).max() / exact.force
    return found, force, result


def check(found, kind):
    assert found["plateau"] <= (2e-4 if kind == "hex8" else 2e-3)
    assert found["variation"] <= 1.5
    assert found["releases"] == 1
    assert found["energy"] <= 2e-3
    assert 0.99 <= found["rebound"] <= 1.001
    assert found["side"] <= 1e-9


@pytest.mark.parametrize(("removal", "axis"), [("auto", 0), ("full", 1)])
@pytest.mark.parametrize("gap_steps", [0.0, 0.5, 3.31, 11.9])
def test_160_hexes_against_the_exact_solution(removal, axis, gap_steps):
    found, _, _ = figures("hex8", 160, gap_steps, tc.MasslessContact(removal=removal), axis=axis)
    assert found["force_error"] <= 0.05
    assert found["impulse_error"] <= 4e-3
    check(found, "hex8")


@pytest.mark.parametrize(("kind", "axis", "cross", "removal"), [("tet4", 2, 1, "auto"), ("hex8", 1, 2, "full")])
@pytest.mark.parametrize("gap_steps", [0.0, 0.77])
def test_100_cells_keep_the_plateau_the_energy_and_the_rebound(kind, axis, cross, removal, gap_steps):
    found, _, _ = figures(kind, 100, gap_steps, tc.MasslessContact(removal=removal), axis=axis, cross=cross)
    check(found, kind)


@pytest.mark.parametrize(("kind", "removal", "axis"), [("hex8", "auto", 0), ("tet4", "full", 2)])
def test_massless_penalty_keeps_the_step_and_tends_to_the_exact_constraint(kind, removal, axis):
    """1 .. 1e6 E/h at the same dt; the difference to the exact constraint falls 100-fold per 100-fold stiffness."""
    count, h = 60, LENGTH / 60

    def run(penalty):
        contact = tc.MasslessContact(removal=removal, penalty=penalty and penalty * YOUNG / h, tolerance=1e-11)
        return figures(kind, count, 0.4, contact, axis=axis)

    _, exact, rigid = run(None)
    differences = []
    for penalty in (1.0, 1e2, 1e4, 1e6):
        found, force, result = run(penalty)
        assert result.dt == pytest.approx(rigid.dt, rel=1e-12)
        assert result.steps == rigid.steps
        assert found["energy"] <= 3e-3 * 160 / count
        differences.append(np.linalg.norm(force - exact) / np.linalg.norm(exact))
    assert differences[1] <= 2e-3
    assert 80 < differences[1] / differences[2] < 125
    assert 50 < differences[2] / differences[3] < 125  # full removal: near what the rounding of gaps allows


def test_depth_trades_the_overshoot_for_the_plateau():
    """METHOD 1: 31 % at depth 1, less the deeper the mass goes."""
    over, plateau = [], []
    for depth in (1, 2, 5):
        found, _, _ = figures("hex8", 160, 0.0, tc.MasslessContact(depth=depth))
        over.append(found["overshoot"])
        plateau.append(found["plateau"])
        assert found["impulse_error"] <= 0.02
    assert over[0] == pytest.approx(0.31, abs=0.03)
    assert over[1] == pytest.approx(0.21, abs=0.03)
    assert over[2] == pytest.approx(0.125, abs=0.03)
    assert max(plateau) <= 1e-3


def test_baselines_on_ordinary_mass_push_with_the_right_impulse():
    """Penalty and impulse contact: right impulse, rebound and energy only to O(h) (METHOD 2, end)."""
    h = LENGTH / 100
    for contact, energy in ((tc.PenaltyContact(YOUNG / h), 0.03), (tc.ImpulseContact(), 0.05)):
        scene, exact, normal = bar_scene("hex8", 100, 0.5, contact)
        history = simulate(scene, cfl=0.5).history
        given = history["impulse"][-1] @ normal
        assert given == pytest.approx(exact.impulse(np.inf), rel=0.03)
        assert history["energy_error"].max() <= energy
        lost = history["energy"][-1] / history["energy"][0] - 1.0
        assert lost <= 1e-3 if isinstance(contact, tc.PenaltyContact) else lost < -1e-3


def test_impulse_contact_loses_energy_like_the_cell_size():
    lost = []
    for count in (40, 80):
        scene, _, _ = bar_scene("hex8", count, 0.5, tc.ImpulseContact())
        history = simulate(scene, cfl=0.5).history
        lost.append(1.0 - history["energy"][-1] / history["energy"][0])
    assert lost[0] > 0.0
    assert lost[0] / lost[1] == pytest.approx(2.0, rel=0.2)
