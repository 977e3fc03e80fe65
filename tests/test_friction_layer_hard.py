"""The friction layer under hard input: always finite numbers, whatever slides, opens, melts or cools."""

from __future__ import annotations

import numpy as np
import pytest
from test_friction_layer import SQRT3, STEEL, laws

from tcontact import friction_layer as layer
from tcontact.device import arrays
from tcontact.friction_layer import study


def test_random_sweep_never_fails():
    """v 0.01..1000 m/s, P 0..10 GPa, dt 1e-11..1e-6 s, T_init 300..1890 K: 1000 conditions, 25 steps (METHOD 5)."""
    for velocity, pressure, dt, initial in study.conditions():
        run = layer.solve(
            velocity=velocity, pressure=pressure, dt=dt, duration=25 * dt, initial_temperature=initial, points=60
        )
        laws(run)
        assert run.temperature.max() < 1900.0
        assert run.steps == 25


def test_secants_fail_where_the_bracket_does_not():
    rows = {method: study.sweep(method, points=40) for method in layer.METHODS}
    assert rows["bracketed-newton"]["failures"] == 0
    for method in ("thermal-softening-secant", "stress-secant"):
        row = rows[method]
        assert 0 < row["failed_conditions"] < 400, method
        assert row["failures"] == sum(condition["failed_steps"] for condition in row["failed"])


@pytest.mark.parametrize("method", layer.METHODS[1:])
def test_secants_agree_where_they_work(method):
    secant, bracketed = layer.solve(method=method), layer.solve()
    assert not secant.failures.any()
    np.testing.assert_allclose(secant.surface_temperature, bracketed.surface_temperature, rtol=1e-6)
    np.testing.assert_allclose(secant.shear_stress, bracketed.shear_stress, rtol=1e-6)


def test_rest_leaves_everything_alone():
    run = layer.solve(velocity=0.0, duration=1e-7)
    assert (run.surface_temperature == 300.0).all()
    np.testing.assert_allclose(run.shear_stress, run.shear_stress[0, 0], rtol=1e-15)
    assert run.heat[0] == run.slip_work[0] == 0.0


def test_reversal_changes_nothing_but_the_direction():
    table = np.where(np.arange(200) < 100, 34.0, -34.0)[:, None]
    run, steady = layer.solve(velocity=table, duration=2e-7), layer.solve(duration=2e-7)
    np.testing.assert_array_equal(run.shear_stress, steady.shear_stress)


@pytest.mark.parametrize("open_pressure", [0.0, -1e9])
def test_open_contact_transmits_nothing_and_closes_at_the_yield_limit(open_pressure):
    pressure = np.full((300, 1), 1.3e9)
    pressure[100:200] = open_pressure
    run = layer.solve(pressure=pressure, duration=3e-7)
    tau, surface = run.shear_stress[:, 0], run.surface_temperature[:, 0]
    assert (tau[101:201] == 0.0).all()
    assert (np.diff(surface[101:201]) < 0.0).all()  # heat spreads
    assert surface[200] > 300.0
    limit = STEEL.yields_at(surface[200], 1.3e9, 0.0) / SQRT3
    assert limit < tau[201] < 1.2 * limit  # hardened since
    assert tau[201] > tau[100]  # and cooler
    np.testing.assert_allclose(run.heat, 0.5 * run.slip_work, rtol=1e-12)


def test_contact_that_never_closes_stays_as_it_is():
    run = layer.solve(pressure=np.array([-1.0, 0.0, 1.3e9]), duration=5e-8)
    assert (run.shear_stress[:, :2] == 0.0).all()
    assert (run.temperature[:2] == 300.0).all()
    assert (run.evaluations[:2] == 0).all()
    assert run.temperature[2, 0] > 300.0


def test_cooling_reloads_on_request_only():
    table = np.where(np.arange(300) < 100, 340.0, 0.0)[:, None]
    lost, back = (layer.solve(velocity=table, duration=3e-7, reload=reload) for reload in (False, True))
    assert np.diff(lost.shear_stress[:, 0]).max() <= 0.0
    assert back.shear_stress[-1, 0] > 1.1 * lost.shear_stress[-1, 0]
    np.testing.assert_allclose(SQRT3 * back.shear_stress[-1, 0], back.yield_stress.min(), rtol=1e-3)
    steady = layer.solve(duration=1e-7, reload=True)
    np.testing.assert_allclose(steady.shear_stress, layer.solve(duration=1e-7).shear_stress, rtol=1e-11)


@pytest.mark.parametrize("initial", [1899.9, 1900.0, 2500.0])
def test_molten_metal_has_no_strength(initial):
    run = layer.solve(initial_temperature=initial, duration=1e-7)
    assert np.isfinite(run.temperature).all()
    assert (run.shear_stress <= 10.0).all()
    np.testing.assert_allclose(run.temperature, initial, atol=1e-5)
    assert not run.failures.any()


@pytest.mark.parametrize("velocity", [0.0, 1e-3, 34.0, 1000.0])
def test_a_step_of_a_second_is_finite_and_solid(velocity):
    run = layer.solve(velocity=velocity, dt=1.0, duration=10.0)
    assert np.isfinite(run.temperature).all()
    assert run.temperature.max() < 1900.0
    assert (run.shear_stress >= 0.0).all()
    assert not run.failures.any()
    np.testing.assert_allclose(run.heat, 0.5 * run.slip_work, rtol=1e-12)


def test_a_sudden_longer_step():
    """dt from 1e-11 to 1e-6 s; also the layer driven step by step, as a contact drives it."""
    cells = layer.Layer((STEEL,), 2, points=100)
    wide = np.zeros(cells.padded)
    wide[:2] = 34.0, 340.0
    velocity, pressure = arrays.put(wide), arrays.put(np.where(wide > 0.0, 1.3e9, 0.0))
    before = np.full(2, np.inf)
    for dt in [1e-11] * 20 + [1e-6] * 10:
        cells.advance(velocity, pressure, dt)
        stress = cells.cell("STRESS")
        assert (stress < before).all()
        before = stress
    assert not cells.cell("FAILURES").any()
    assert 300.0 < cells.temperature().min() <= cells.temperature().max() < 1900.0
    np.testing.assert_allclose(cells.heat(), 0.5 * cells.cell("WORK"), rtol=1e-12)
