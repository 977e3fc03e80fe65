"""The ledger from measured rows alone: what the host makes of them, against sums by hand (METHOD 2)."""

import numpy as np
import pytest

from tcontact.history import History
from tcontact.measured import Layout


def rows_of(layout, count, seed=3):
    """Rows [count, width] of random numbers at uneven times, and what stands in them by name."""
    generator = np.random.default_rng(seed)
    rows = generator.normal(size=(count, layout.width))
    rows[:, layout.place["time"]] = np.cumsum(generator.uniform(0.5, 1.5, (count, 1)), axis=0)
    return rows, {name: rows[:, place].squeeze() for name, place in layout.place.items()}


def filled(rows, parts=(1, 4, 2), **options):
    """A history that got the rows in parts."""
    history, start = History(1, **options), 0
    for size in (*parts, len(rows) - sum(parts)):
        history.add(rows[start : start + size])
        start += size
    history.finish()
    return history


def trapezoid(time, values):
    return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(time))])


def test_external_work_is_that_of_loads_supports_and_moving_obstacles():
    layout = Layout(obstacles=("wall",))
    rows, by = rows_of(layout, 12)
    columns = filled(rows, layout=layout).columns()
    wanted = by["load_work"] - by["load_work"][0]
    wanted = wanted + trapezoid(by["time"], by["support_power"]) + trapezoid(by["time"], by["obstacle_power"])
    assert columns["external_work"] == pytest.approx(wanted, rel=1e-12, abs=1e-12)
    energy = by["kinetic"] + by["elastic"] + by["contact"] - wanted
    assert columns["energy"] == pytest.approx(energy, rel=1e-12, abs=1e-12)
    scale = (by["kinetic"] + by["elastic"]).max()
    assert columns["energy_error"] == pytest.approx(np.abs(energy - energy[0]) / scale, rel=1e-12, abs=1e-12)
    for axis in range(3):
        impulse = trapezoid(by["time"], by["contact_force"][:, axis])
        assert columns["impulse"][:, axis] == pytest.approx(impulse, rel=1e-12, abs=1e-12)


def test_friction_work_of_a_row_is_what_was_done_up_to_it():
    """Every kick does a part before its row and a part after it; before the first row nothing but its own was done."""
    layout = Layout(friction=True)
    rows, by = rows_of(layout, 12)
    columns = filled(rows, layout=layout).columns()
    before, after = by["friction_before"], by["friction_after"]
    wanted = np.cumsum(before) + np.concatenate([[0.0], np.cumsum(after)[:-1]])
    assert columns["friction_work"] == pytest.approx(wanted, rel=1e-12, abs=1e-12)
    stored = by["kinetic"] + by["elastic"] + by["contact"] - columns["external_work"]
    assert columns["energy"] == pytest.approx(stored + wanted, rel=1e-12, abs=1e-12)


def test_damping_and_viscosity_dissipate_what_their_powers_say():
    """2 rate times the kinetic energy, trapezoidal rule; the viscous power of a row is that of the step before it."""
    rows, by = rows_of(Layout(), 12)
    extra = ("damping_work", "damping_impulse", "viscous_work")
    columns = filled(rows, extra=extra, damping=3.0).columns()
    time, step = by["time"], np.diff(by["time"])
    damped = 2.0 * 3.0 * trapezoid(time, by["kinetic"])
    viscous = np.concatenate([[0.0], np.cumsum(step * by["viscous_power"][1:])])
    assert columns["damping_work"] == pytest.approx(damped, rel=1e-12, abs=1e-12)
    assert columns["viscous_work"] == pytest.approx(viscous, rel=1e-12, abs=1e-12)
    impulse = -3.0 * trapezoid(time, by["momentum"][:, 1])
    assert columns["damping_impulse"][:, 1] == pytest.approx(impulse, rel=1e-12, abs=1e-12)
    stored = by["kinetic"] + by["elastic"] + by["contact"] - columns["external_work"]
    assert columns["energy"] == pytest.approx(stored + damped + viscous, rel=1e-12, abs=1e-12)


def test_forces_of_a_mid_step_row_act_over_the_step_before_it():
    rows, by = rows_of(Layout(), 12)
    columns = filled(rows, mid_step=True).columns()
    wanted = np.concatenate([[0.0], np.cumsum(by["contact_force"][1:, 2] * np.diff(by["time"]))])
    assert columns["impulse"][:, 2] == pytest.approx(wanted, rel=1e-12, abs=1e-12)


def test_the_energy_that_a_run_may_hold_is_that_of_its_start_and_what_was_put_into_it():
    rows, by = rows_of(Layout(), 12)
    history = filled(rows)
    assert history.budget() == pytest.approx(
        by["kinetic"][0] + by["elastic"][0] + by["contact"][0] + np.abs(history.columns()["external_work"]).max(),
        rel=1e-12,
    )


def test_a_thinned_history_has_the_sums_of_every_row():
    layout = Layout(friction=True)
    rows, _ = rows_of(layout, 12)
    whole = filled(rows, layout=layout).columns()
    thin = History(5, layout=layout)
    thin.add(rows[:7])
    thin.add(rows[7:])
    thin.finish()
    for name in ("time", "impulse", "friction_work", "external_work", "energy"):
        assert np.array_equal(thin.columns()[name], whole[name][[0, 5, 10, 11]]), name
