"""Supports that functions of time drive (METHOD 1): exact positions, reactions with inertia, waves, failures."""

import numpy as np
import pytest
from scenes import simulate
from stopped_runs import copied, quietly, same, same_files

import tcontact as tc
from tcontact.planning.body_plan import SMALL
from tcontact.results import checks as ck
from tcontact.results.files.vtkhdf import ResultData

PERIOD, WAY = 4e-3, 2e-4
FINE = tc.CentralDifference(cfl=0.25)


def way(time):
    """Displacement along x and y [m]."""
    return [WAY * (1.0 - np.cos(2.0 * np.pi * time / PERIOD)), 0.5 * WAY * np.sin(2.0 * np.pi * time / PERIOD)]


def rate(time):
    """Its rate [m/s]."""
    turn = 2.0 * np.pi / PERIOD
    return [WAY * turn * np.sin(turn * time), 0.5 * WAY * turn * np.cos(turn * time)]


DRIVEN = {"displacement": way, "velocity": rate}


def dropped(support, duration=PERIOD, velocity=(0.0, 0.0, -1.0), obstacles=None, **options):
    """A block of rubber that meets a wall while its top is driven."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (3, 3, 3))
    law = tc.NeoHookean(young=1e7, poisson=0.3, density=1000.0)
    body = tc.Body(mesh, law, velocity, contact="zmin", supports=[support])
    wall = tc.Plane(point=(0.0, 0.0, -1e-4)) if obstacles is None else obstacles
    return tc.Scene([body], wall, duration=duration, **options)


def driven_bar(cells, support, young=1e7, density=1e3, duration=8e-3):
    """A bar along x with c = 100 m/s, driven at x = 0 and free at x = 1."""
    mesh = tc.box_mesh((1.0, 0.05, 0.05), (cells, 1, 1))
    body = tc.Body(mesh, tc.LinearElastic(young, 0.0, density), supports=[support])
    return tc.Scene([body], duration=duration)


@pytest.mark.parametrize("size", ["small", "large"])
def test_driven_nodes_are_where_the_function_says_at_every_row(size, tmp_path, monkeypatch):
    """Positions to rounding in every row and the momentum balance, with many rows in a launch or one."""
    for element in SMALL if size == "large" else ():
        monkeypatch.setitem(SMALL, element, 0)
    for kind in DRIVEN:
        scene = dropped(tc.Support("zmax", "xy", **{kind: DRIVEN[kind]}))
        result = simulate(scene, cfl=0.5, out=tmp_path / kind, frames=10**5)
        frames = ResultData.open(tmp_path / kind / "result.vtkhdf")
        top = scene.bodies[0].mesh.nodes_of("zmax")
        assert len(frames) == len(result.history["time"])
        for number, time in enumerate(frames.times):
            moved = frames.frame(number).point_data["displacement"][top][:, :2]
            assert np.ptp(moved, axis=0).max() == 0.0
            assert np.abs(moved - way(time)).max() <= (1e-14 if kind == "displacement" else 1e-6) * WAY
        assert np.abs(result.history["contact_force"]).max() > 0.0
        check = ck.momentum_balance(result, 1e-12)
        assert check.passed, check


def test_a_velocity_is_integrated_to_sixth_order():
    """Three Gauss points a step: twice as many steps leave 2^-6 of the error at the end."""
    errors = []
    for dt in (2e-4, 1e-4):
        support = tc.Support("zmax", "x", velocity=lambda time: np.cos(2.0 * np.pi * time / PERIOD))
        scene = dropped(support, 1.6e-3, (1.0, 0.0, 0.0), [])
        result = quietly(tc.simulate, scene, tc.CentralDifference(dt=dt))
        there = (result.position - scene.bodies[0].mesh.nodes)[scene.bodies[0].mesh.nodes_of("zmax"), 0]
        exact = PERIOD / (2.0 * np.pi) * np.sin(2.0 * np.pi * result.time / PERIOD)
        errors.append(np.abs(there - exact).max())
    assert 55.0 < errors[0] / errors[1] < 75.0


def test_a_pulse_travels_along_a_bar_as_d_alembert_says():
    """u(x, t) = D(t - x/c), second order in the cells; the work of the support is the energy of the pulse."""
    span = 8e-3

    def pulse(time):
        return WAY * np.sin(np.pi * np.clip(time, 0.0, span) / span) ** 4

    energy = 1e7 * 0.05**2 / 100.0 * WAY**2 * np.pi**2 * 5.0 / (8.0 * span)  # E A/c int D'^2 dt
    errors, works = [], []
    for cells in (100, 200):
        result = simulate(driven_bar(cells, tc.Support("xmin", "x", displacement=pulse), duration=9e-3))
        history, x = result.history, result.scene.bodies[0].mesh.nodes[:, 0]
        errors.append(np.abs(result.position[:, 0] - x - pulse(result.time - x / 100.0)).max() / WAY)
        works.append(history["external_work"][-1] / energy - 1.0)
        assert ck.momentum_balance(result, 1e-12).passed
    assert errors[1] <= errors[0] / 3.5
    assert errors[1] <= 2e-4
    assert abs(works[1]) <= abs(works[0]) / 3.5
    assert abs(works[1]) <= 1e-3
    assert history["energy_error"].max() <= 1e-3


def test_the_reaction_includes_the_inertia_of_the_driven_nodes():
    """A stiff block pushed as a whole: the reaction is its mass times the acceleration, at every row."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2))
    push = tc.Support("xmin", "xyz", displacement=lambda time: [time**4, 0.0, 0.0])
    scene = tc.Scene([tc.Body(mesh, tc.LinearElastic(1e10, 0.3, 1000.0), supports=[push])], duration=0.02)
    history = simulate(scene).history
    time = history["time"]
    exact = 12.0 * time**2  # of 1 kg
    assert np.abs(history["support_force"][:, 0] - exact).max() <= 1e-3 * exact.max()


def test_free_components_feel_the_inertia_of_driven_ones_by_their_mass_tensor():
    """A plate on an oblique wall: its upper nodes have oblique mass tensors and are driven along x alone."""
    turn = np.array([[1.0, 0.0, 1.0], [0.0, 2.0**0.5, 0.0], [-1.0, 0.0, 1.0]]) / 2.0**0.5
    flat = tc.box_mesh((0.1, 0.1, 0.03), (3, 3, 1))
    mesh = tc.Mesh(flat.nodes @ turn.T, flat.cells, flat.kind, face_sets=flat.face_sets)
    support = tc.Support("zmax", "x", displacement=lambda time: way(time)[0])
    body = tc.Body(mesh, tc.NeoHookean(1e7, 0.3, 1000.0), contact="zmin", supports=[support])
    wall = tc.Plane(tuple(-1e-5 * turn[:, 2]), tuple(turn[:, 2]))
    scene = tc.Scene([body], [wall], PERIOD, contact=tc.MasslessContact(removal="normal"))
    tensors = tc.plan(scene).bodies[0].tensors
    assert np.abs(tensors[:, 0, 2]).max() > 0.1 * np.abs(tensors).max()
    result = simulate(scene, cfl=0.3)
    assert np.abs(result.history["contact_force"]).max() > 0.0
    assert ck.momentum_balance(result, 1e-12).passed


@pytest.mark.parametrize("kind", DRIVEN)
def test_a_split_run_has_the_same_bits(kind, monkeypatch, tmp_path):
    physics = dropped(tc.Support("zmax", "xy", **{kind: DRIVEN[kind]}))
    whole, copies = copied(monkeypatch, tmp_path, physics, FINE, 7, frames=5)
    for row in sorted(copies)[2:8:5]:
        same(quietly(tc.resume, copies[row], physics, FINE), whole)
        same_files(copies[row], tmp_path / "whole")
    other = dropped(tc.Support("zmax", "xy", **{kind: lambda time: [1.1 * part for part in DRIVEN[kind](time)]}))
    with pytest.raises(tc.InputError, match="supports"):
        quietly(tc.resume, copies[sorted(copies)[3]], other, FINE)


@pytest.mark.parametrize("kind", DRIVEN)
def test_a_function_that_fails_stops_the_run_with_its_rows(kind):
    """The last row is that of the step before; momentum and rows up to there hold."""

    def failing(time):
        if time > 0.5 * PERIOD:
            raise ValueError("no more")
        return DRIVEN[kind](time)

    result = quietly(tc.simulate, dropped(tc.Support("zmax", "xy", **{kind: failing})), FINE)
    assert result.reason == "function-failed"
    assert "no more" in result.message
    assert f"Support.{kind} of 'zmax'" in result.message
    assert 0.5 * PERIOD - 2.0 * result.dt <= result.time <= 0.5 * PERIOD
    assert len(result.history["time"]) == result.steps + 1
    assert ck.momentum_balance(result, 1e-12).passed


def test_supports_that_cannot_be_are_refused():
    mesh, law = tc.box_mesh((1.0, 1.0, 1.0), (1, 1, 1)), tc.NeoHookean(1e7, 0.3, 1e3)
    wrong = [
        (lambda: tc.Support("zmax", "x", velocity=1.0, displacement=np.sin), "displacement is given too"),
        (lambda: tc.Support("zmax", "xy", velocity=lambda time: [1.0, 2.0, 3.0]), "two finite numbers"),
        (lambda: tc.Support("zmax", "xy", displacement=lambda time: np.nan), "finite"),
        (lambda: tc.Support("zmax", "x", displacement="up"), "Support.displacement"),
        (
            lambda: tc.Body(mesh, law, supports=[tc.Support("zmax", "x", np.sin), tc.Support("xmax", "x", np.cos)]),
            "another velocity",
        ),
    ]
    for make, text in wrong:
        with pytest.raises(tc.InputError, match=text):
            make()
    shared = [tc.Support("zmax", "xy", velocity=np.sin), tc.Support("xmax", "x", velocity=np.sin)]
    body = tc.Body(mesh, law, supports=shared)
    with pytest.raises(tc.InputError, match="no functions of time"):
        tc.simulate(tc.Scene([body], duration=1.0), tc.Midpoint(dt=0.1))


def test_a_constant_displacement_holds_nodes_where_it_says():
    support = tc.Support("zmax", "z", displacement=1e-3)
    result = simulate(dropped(support, duration=5e-4, velocity=(0.0, 0.0, 0.0), obstacles=[]))
    body = result.scene.bodies[0]
    top = body.mesh.nodes_of("zmax")
    assert np.array_equal((result.position - body.mesh.nodes)[top, 2] > 0.0, np.ones(len(top), dtype=bool))
    assert np.abs((result.position - body.mesh.nodes)[top, 2] - 1e-3).max() <= 1e-16
    assert "driven supports" not in tc.plan(result.scene).describe()


def test_a_run_goes_on_from_the_end_of_another_only_where_its_displacement_starts():
    first = simulate(dropped(tc.Support("zmax", "xy", velocity=rate), duration=1e-3))
    with pytest.raises(tc.InputError, match="displacement of a support"):
        tc.simulate(dropped(tc.Support("zmax", "xy", displacement=way), 1e-3), initial=first)
    end = (first.position - first.scene.bodies[0].mesh.nodes)[first.scene.bodies[0].mesh.nodes_of("zmax")][0]
    on = tc.Support("zmax", "xy", displacement=lambda time: [end[0] + 0.1 * time, end[1]])
    second = tc.simulate(dropped(on, 1e-3), initial=first)
    assert second.ok


def test_a_driven_body_reaches_what_it_will_meet():
    """Contact faces are found by the largest speed of the function, not by that of the start."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2))
    law = tc.NeoHookean(1e7, 0.3, 1e3)
    counts = []
    for height in (0.0, 1.0):
        support = tc.Support("zmax", "z", displacement=lambda time, height=height: -height * time**2)
        body = tc.Body(mesh, law, contact="auto", supports=[support])
        scene = tc.Scene([body], [tc.Plane(point=(0.0, 0.0, -0.3))], duration=0.5)
        counts.append(len(scene.bodies[0].contact_faces))
    assert counts == [0, 4]
