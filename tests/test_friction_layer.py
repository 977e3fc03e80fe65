"""The friction layer: independent figures, the laws of its model, closed forms. Times are never judged."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from oracle import friction_layer as oracle

import tcontact as tc
from tcontact import friction_layer as layer
from tcontact.device import arrays
from tcontact.friction_layer import grid, study

STEEL = layer.STAINLESS_304
SQRT3 = math.sqrt(3.0)


def sum_of_7(run: layer.LayerResult, metal: layer.Metal = STEEL) -> np.ndarray:
    """H (sig - sig_0) + 3G integral of ep, over its first term's H sig_0; by the trapezoidal rule."""
    thickness = run.depth[-1]
    plastic = 3.0 * metal.shear_modulus * np.trapezoid(run.plastic_strain, run.depth)
    first = thickness * SQRT3 * run.shear_stress[0]
    return np.abs(thickness * SQRT3 * run.shear_stress[-1] - first + plastic) / first


def laws(run: layer.LayerResult, metal: layer.Metal = STEEL, share: float = 0.5) -> None:
    """What holds for every run from rest at constant velocity and pressure."""
    for name in ("surface_temperature", "shear_stress", "temperature", "plastic_strain", "yield_stress", "heat"):
        assert np.isfinite(getattr(run, name)).all(), name
    assert not run.failures.any()
    assert np.diff(run.shear_stress, axis=0).max() <= 0.0
    stress = SQRT3 * run.shear_stress[-1][:, None]
    room = metal.melting_temperature - run.temperature
    rounding = 3e-16 * metal.melting_temperature**2 * metal.sharpness / room**2  # of T, in what it does to Y
    assert (stress <= run.yield_stress * (1.0 + 1e-12 + rounding) + 1e-12).all()
    assert sum_of_7(run, metal).max() <= 1e-12
    wanted = share * run.slip_work
    assert np.abs(run.heat - wanted).max() <= 1e-12 * wanted.max()


def test_paper_case_has_the_independent_figures_at_all_times():
    """200 points, 1 ns: 0.2 % of the rise and of tau; start 202.03 MPa (METHOD 5)."""
    run = tc.friction_layer.solve()
    assert run.time.shape == (601,)
    assert run.time[-1] == pytest.approx(0.6e-6, rel=1e-12)
    assert run.shear_stress.shape == run.surface_temperature.shape == (601, 1)
    assert run.shear_stress[0, 0] == pytest.approx(202.03e6, rel=3e-5)
    temperature, stress, _ = study.errors(run, 34.0)
    assert temperature <= 2e-3
    assert stress <= 2e-3
    laws(run)


def test_paper_case_converges_to_the_figures():
    run = layer.solve(points=200, grading=30.0, dt=1e-10, history_every=10)
    assert run.surface_temperature[-1, 0] - 300.0 == pytest.approx(347.02, rel=1e-3)
    assert run.shear_stress[-1, 0] == pytest.approx(181.93e6, rel=1e-3)
    laws(run)


def test_melting_case_has_the_figures():
    run = layer.solve(velocity=340.0)
    assert run.surface_temperature[300, 0] == pytest.approx(1845.5, rel=3e-3)
    assert run.shear_stress[300, 0] == pytest.approx(97.0e6, rel=3e-3)
    assert run.shear_stress[-1, 0] == pytest.approx(59.4e6, rel=1e-2)
    assert run.surface_temperature.max() < 1900.0
    laws(run)


@pytest.mark.parametrize("velocity", [34.0, 340.0])
def test_agrees_with_the_method_of_lines(velocity):
    """Another discretisation in space, rates instead of steps, a stiff integrator: to the error of its 60 volumes."""
    times = np.array([1e-7, 2e-7, 3e-7])
    temperature, tau = oracle.layer(STEEL, velocity, 1.3e9, times, count=60, eta=1e-12, rtol=1e-5)
    run = layer.solve(velocity=velocity, points=150, grading=30.0, dt=2e-10, duration=3e-7)
    at = [500, 1000, 1500]
    np.testing.assert_allclose(run.surface_temperature[at, 0], temperature, rtol=1.5e-3)
    np.testing.assert_allclose(run.shear_stress[at, 0], tau, rtol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("velocity", "ratio"), [(34.0, 100.0), (340.0, 3000.0)])
def test_reference_of_the_study_is_that_of_the_method_of_lines(velocity, ratio):
    times = np.array(study.TIMES)
    coarse, fine = (
        np.array(oracle.layer(STEEL, velocity, 1.3e9, times, count=count, ratio=ratio, eta=1e-13, rtol=1e-7))
        for count in (80, 120)
    )
    temperature, tau = fine + (fine - coarse) / (1.5**2 - 1.0)
    np.testing.assert_allclose(study.REFERENCE[velocity][0], temperature, rtol=5e-5)
    np.testing.assert_allclose(study.REFERENCE[velocity][1], tau * 1e-6, rtol=3e-4)


def elastic(**changes: float) -> layer.Metal:
    """Steel so strong in shear, or of such softening, that a closed form holds; `changes` of its constants."""
    return dataclasses.replace(STEEL, **({"sharpness": 1e-12, "pressure_factor": 0.0} | changes))


def erfc_scaled(x: float) -> float:
    """exp(x^2) erfc(x)."""
    return math.exp(x * x) * math.erfc(x)


def test_constant_flux_into_a_half_space():
    """No softening: T_s - T_0 = 2 q sqrt(t/(pi k rho c)); within 0.5 %."""
    metal = elastic(thermal_softening=0.0, melting_temperature=1e9)
    run = layer.solve(metal, points=100, grading=30.0, duration=3e-7)
    q = 0.5 * 34.0 * STEEL.yield_stress / SQRT3
    exact = 2.0 * q * np.sqrt(run.time[30:] / np.pi) / STEEL.effusivity
    np.testing.assert_allclose(run.surface_temperature[30:, 0] - 300.0, exact, rtol=5e-3)
    assert np.ptp(run.shear_stress) <= 1e-12 * run.shear_stress[0, 0]


def test_orders_of_accuracy():
    """Second order in space, first in time, of the surface temperature under a constant flux at 0.1 us."""
    metal = elastic(thermal_softening=0.0, melting_temperature=1e9)

    def surface(points, dt):
        run = layer.solve(metal, points=points, dt=dt, duration=1e-7, history_every=round(1e-7 / dt))
        return run.surface_temperature[-1, 0]

    space = [surface(points, 1e-8) for points in (51, 101, 201)]
    assert np.log2((space[0] - space[1]) / (space[1] - space[2])) == pytest.approx(2.0, abs=0.15)
    time = [surface(101, dt) for dt in (1e-9, 5e-10, 2.5e-10)]
    assert np.log2((time[0] - time[1]) / (time[1] - time[2])) == pytest.approx(1.0, abs=0.1)


def test_orders_of_accuracy_with_plastic_flow():
    def last(points, dt):
        run = layer.solve(points=points, dt=dt, duration=2e-7, history_every=round(2e-7 / dt))
        return run.surface_temperature[-1, 0]

    time = [last(100, dt) for dt in (4e-9, 2e-9, 1e-9)]
    assert np.log2((time[0] - time[1]) / (time[1] - time[2])) == pytest.approx(1.0, abs=0.1)
    space = [last(points, 4e-9) for points in (101, 201, 401)]
    assert np.log2((space[0] - space[1]) / (space[1] - space[2])) == pytest.approx(2.0, abs=0.3)


def test_linear_softening_is_convective_heating():
    """Perfectly plastic (n = 1, beta_h = 1e-3, f -> 0): q = a (T* - T_s), the half-space solution with erfc; 0.5 %."""
    metal = elastic(hardening=1e-3, hardening_exponent=1.0, melting_temperature=1e9)
    speed = 1000.0
    run = layer.solve(metal, speed, points=200, grading=100.0, dt=1e-10, duration=1e-7, history_every=10)
    a = 0.5 * speed * STEEL.yield_stress / SQRT3 * STEEL.thermal_softening
    x = a * np.sqrt(run.time[10:]) / STEEL.effusivity
    exact = (1.0 - np.array([erfc_scaled(value) for value in x])) / STEEL.thermal_softening
    np.testing.assert_allclose(run.surface_temperature[10:, 0] - 300.0, exact, rtol=5e-3)
    tau = STEEL.yield_stress / SQRT3 * (1.0 - STEEL.thermal_softening * exact)
    np.testing.assert_allclose(run.shear_stress[10:, 0], tau, rtol=5e-3)


def test_sharp_melting():
    """f -> 0 without softening: constant stress until T_s = T_f at t_m, tau = tau_0 2/pi asin sqrt(t_m/t) from then."""
    metal = elastic(hardening=1e-3, hardening_exponent=1.0, thermal_softening=0.0, sharpness=1e-10)
    speed = 340.0
    run = layer.solve(metal, speed, points=300, grading=100.0, dt=1e-10, duration=3e-7, history_every=10)
    q = 0.5 * speed * STEEL.yield_stress / SQRT3
    melting = np.pi / 4.0 * ((1900.0 - 300.0) * STEEL.effusivity / q) ** 2
    later = run.time > 1.1 * melting
    assert 0.2 < later.mean() < 0.9
    wanted = 2.0 / np.pi * np.arcsin(np.sqrt(melting / run.time[later]))
    np.testing.assert_allclose(run.shear_stress[later, 0] / run.shear_stress[0, 0], wanted, rtol=5e-3)
    np.testing.assert_allclose(run.surface_temperature[later, 0], 1900.0, rtol=1e-5)


@pytest.mark.parametrize("other", [layer.STAINLESS_304, layer.ALUMINIUM_6061])
def test_two_bodies_share_the_heat_by_effusivity(other):
    run = layer.solve(other=other, duration=5e-8, points=100, grading=30.0)
    both = run.heat + run.other.heat
    np.testing.assert_allclose(both, run.slip_work, rtol=1e-12)
    share = STEEL.effusivity / (STEEL.effusivity + other.effusivity)
    np.testing.assert_allclose(run.heat / both, share, rtol=5e-3)
    np.testing.assert_allclose(run.temperature[0, 0], run.other.temperature[0, 0], rtol=1e-12)
    stress = SQRT3 * run.shear_stress[-1, 0] * (1.0 - 1e-12)
    assert stress <= min(run.yield_stress.min(), run.other.yield_stress.min())
    weaker = min(metal.yields_at(300.0, 1.3e9, 0.0) for metal in (STEEL, other))
    assert SQRT3 * run.shear_stress[0, 0] == pytest.approx(weaker, rel=1e-12)
    assert not run.failures.any()


def test_twins_are_one_layer_with_half_the_heat():
    one, two = layer.solve(duration=1e-7), layer.solve(duration=1e-7, other=STEEL)
    np.testing.assert_allclose(two.surface_temperature, one.surface_temperature, rtol=1e-12)
    np.testing.assert_allclose(two.shear_stress, one.shear_stress, rtol=1e-11)
    np.testing.assert_allclose(two.other.plastic_strain, one.plastic_strain, rtol=1e-8, atol=1e-14)


def test_contact_conductance_parts_the_surfaces():
    """Heat goes in equally and leaks over: q_A - q_B = 2 hc (T_B - T_A); nothing crosses at hc = 0."""
    split = layer.solve(other=layer.COPPER, conductance=0.0, duration=5e-8)
    np.testing.assert_allclose(split.heat, split.other.heat, rtol=1e-12)
    gaps = []
    for conductance in (1e6, 1e8, 1e10):
        run = layer.solve(other=layer.COPPER, conductance=conductance, duration=5e-8)
        gaps.append(run.temperature[0, 0] - run.other.temperature[0, 0])
        np.testing.assert_allclose(run.heat + run.other.heat, run.slip_work, rtol=1e-12)
    assert gaps[0] > gaps[1] > gaps[2] > 0.0
    assert gaps[2] < 0.01 * gaps[0]
    for conductance in (1e6, 1e8, 1e10):  # one step: the temperatures of its end drive the whole of it
        run = layer.solve(other=layer.COPPER, conductance=conductance, duration=1e-8, dt=1e-8)
        apart = run.other.temperature[0, 0] - run.temperature[0, 0]
        given = 2.0 * conductance * apart * 1e-8
        assert run.heat[0] - run.other.heat[0] == pytest.approx(given, rel=1e-9, abs=1e-12 * run.slip_work[0])


@pytest.mark.parametrize(("chi", "velocity"), [(0.9, 34.0), (1.0, 340.0), (1.0, 1000.0)])
def test_plastic_heat_is_conserved(chi, velocity):
    """Stored heat = b slip work + chi plastic work less what is carried; also next to melting (METHOD 5)."""
    run = layer.solve(velocity=velocity, plastic_heat=chi)
    wanted = 0.5 * run.slip_work + chi * run.plastic_work
    np.testing.assert_allclose(run.heat + run.carried_heat, wanted, rtol=1e-12)
    assert (run.plastic_work > 0.0).all()
    assert (run.carried_heat < 0.01 * run.plastic_work).all()
    assert run.temperature.max() < 1900.0
    assert sum_of_7(run).max() <= 1e-12


def test_layers_go_on_from_their_checkpoint():
    """Everything that a step needs is in it, the plastic heat that waits for the next step too: the same bits."""

    def heated():
        cells = layer.Layer((STEEL,), 2, points=40, plastic_heat=0.9, reload=True)
        wide = np.zeros(cells.padded)
        wide[:2] = 34.0, 340.0
        return cells, arrays.put(wide), arrays.put(np.where(wide > 0.0, 1.3e9, 0.0))

    def go(cells, velocity, pressure):
        for dt in (1e-9, 2e-9, 2e-9):
            cells.advance(velocity, pressure, dt)

    cells, velocity, pressure = heated()
    go(cells, velocity, pressure)
    saved = {name: np.array(value) for name, value in cells.checkpoint().items()}
    assert (cells.carried() > 0.0).all()
    go(cells, velocity, pressure)
    again, velocity, pressure = heated()
    again.restore(saved)
    go(again, velocity, pressure)
    for name in ("temperature", "plastic_strain", "carried", "heat"):
        np.testing.assert_array_equal(getattr(again, name)(), getattr(cells, name)(), err_msg=name)
    np.testing.assert_array_equal(again.cell("STRESS"), cells.cell("STRESS"))


def test_cells_do_not_know_of_each_other():
    speeds = np.linspace(1.0, 400.0, 21)
    batch = layer.solve(velocity=speeds, pressure=np.linspace(1e8, 5e9, 21), duration=5e-8)
    for cell in (0, 7, 8, 20):
        alone = layer.solve(velocity=speeds[cell], pressure=np.linspace(1e8, 5e9, 21)[cell], duration=5e-8)
        np.testing.assert_allclose(batch.shear_stress[:, cell], alone.shear_stress[:, 0], rtol=1e-9)
        np.testing.assert_allclose(batch.temperature[cell], alone.temperature[0], rtol=1e-11)


def test_layout_of_a_graphics_card_computes_the_same(monkeypatch):
    """One cell a thread, 32 side by side in memory, on the CPU here: the same states, also with two sides."""
    from tcontact.friction_layer import layer as module

    options = {"velocity": np.linspace(1.0, 400.0, 70), "duration": 2e-8, "points": 40, "plastic_heat": 0.9}
    wanted = layer.solve(**options), layer.solve(**options, other=layer.COPPER)
    monkeypatch.setitem(module.LAYOUTS, "cpu", (1, 32))
    found = layer.solve(**options), layer.solve(**options, other=layer.COPPER)
    for one, two in zip(wanted, found, strict=True):
        np.testing.assert_allclose(two.temperature, one.temperature, rtol=1e-11)
        np.testing.assert_allclose(two.shear_stress, one.shear_stress, rtol=1e-9)
        np.testing.assert_allclose(two.heat, one.heat, rtol=1e-9)
    np.testing.assert_allclose(found[1].other.heat, wanted[1].other.heat, rtol=1e-9)


def test_transmitted_traction_and_its_heat():
    """t = min(sig/sqrt3, cap), heat t (v - drag t): a capped contact heats by what it transmits (METHOD 5)."""
    cells = layer.Layer((STEEL,), 2, points=60)
    cap, drag = 1e7, 1e-7
    cells.limit_traction(np.array([cap, 1e300]), np.array([drag, 0.0]))
    velocity, pressure = np.zeros(cells.padded), np.zeros(cells.padded)
    velocity[:2], pressure[:2] = 34.0, 1.3e9
    for _ in range(50):
        cells.advance(velocity, pressure, 1e-9)
    wanted = 50e-9 * cap * (34.0 - drag * cap)
    np.testing.assert_allclose(cells.cell("WORK")[0], wanted, rtol=1e-12)
    np.testing.assert_allclose(cells.heat(), 0.5 * cells.cell("WORK"), rtol=1e-12)
    assert cells.temperature()[0, 0] < cells.temperature()[1, 0]


@pytest.mark.parametrize("dt", [1e-11, 1e-9, 1.0])
def test_column_is_the_inverse_of_the_heat_matrix(dt):
    """Bq, and one step of a random profile, against a dense solve; row sums conserve heat."""
    depth = grid.depths(30, 10.0, 1e-5)
    column = grid.column(STEEL, depth, dt)
    link = STEEL.conductivity / np.diff(depth)
    capacity = STEEL.volumetric_heat * column.weight / dt
    matrix = np.diag(capacity + np.append(link, 0.0) + np.append(0.0, link)) - np.diag(link, 1) - np.diag(link, -1)
    first = np.zeros(30)
    first[0] = 1.0
    np.testing.assert_allclose(column.warmth, np.linalg.solve(matrix, first), rtol=1e-6 if dt == 1.0 else 1e-10)
    assert capacity @ column.warmth == pytest.approx(1.0, rel=1e-13)
    assert depth[-1] == pytest.approx(1e-5, rel=1e-14)
    assert np.diff(depth)[-1] / np.diff(depth)[0] == pytest.approx(10.0, rel=1e-9)
