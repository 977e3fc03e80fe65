"""The ledger from measured rows alone: what the host makes of them, against sums by hand (METHOD 2)."""

import csv
import re
from pathlib import Path

import numpy as np
import pytest

import tcontact as tc
from tcontact.kernels.columns import (
    APPLIES,
    COLUMNS,
    DAMPED,
    FREE_OBSTACLES,
    FRICTION,
    HEATED,
    HOURGLASS,
    LAYERS,
    LOADS,
    MISES_MAXIMUM,
    PAIRED,
    PLASTIC,
    PLASTIC_HOURGLASS,
    PRESSURE_MAXIMUM,
    PULLED,
    RIGID_BODIES,
    RIGID_PARTS,
    SPRINGS,
    VISCOUS,
    group_columns,
)
from tcontact.planning.measured import Layout, RawRows, combined
from tcontact.results.report import write_history
from tcontact.run.history import History


def rows_of(layout, count, seed=3):
    """Rows [count, width] of random numbers at uneven times, and what stands in them by name."""
    generator = np.random.default_rng(seed)
    rows = generator.normal(size=(count, layout.width))
    rows[:, layout.place["time"]] = np.cumsum(generator.uniform(0.5, 1.5, (count, 1)), axis=0)
    return rows, {c.name: rows[:, layout.place[c.name]].squeeze() for c in layout.measured}


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
    layout = Layout([LOADS], ("wall",))
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
    layout = Layout([FRICTION])
    rows, by = rows_of(layout, 12)
    columns = filled(rows, layout=layout).columns()
    before, after = by["friction_before"], by["friction_after"]
    wanted = np.cumsum(before) + np.concatenate([[0.0], np.cumsum(after)[:-1]])
    assert columns["friction_work"] == pytest.approx(wanted, rel=1e-12, abs=1e-12)
    stored = by["kinetic"] + by["elastic"] + by["contact"] - columns["external_work"]
    assert columns["energy"] == pytest.approx(stored + wanted, rel=1e-12, abs=1e-12)


def test_damping_and_viscosity_dissipate_what_their_powers_say():
    """2 rate times the kinetic energy, trapezoidal rule; the viscous power of a row is that of the step before it."""
    layout = Layout([DAMPED, VISCOUS])
    rows, by = rows_of(layout, 12)
    columns = filled(rows, layout=layout, factors=tc.MassDamping(3.0).factors).columns()
    time, step = by["time"], np.diff(by["time"])
    damped = 2.0 * 3.0 * trapezoid(time, by["kinetic"])
    viscous = np.concatenate([[0.0], np.cumsum(step * by["viscous_power"][1:])])
    assert columns["damping_work"] == pytest.approx(damped, rel=1e-12, abs=1e-12)
    assert columns["viscous_work"] == pytest.approx(viscous, rel=1e-12, abs=1e-12)
    impulse = -3.0 * trapezoid(time, by["momentum"][:, 1])
    assert columns["damping_impulse"][:, 1] == pytest.approx(impulse, rel=1e-12, abs=1e-12)
    stored = by["kinetic"] + by["elastic"] + by["contact"] - columns["external_work"]
    assert columns["energy"] == pytest.approx(stored + damped + viscous, rel=1e-12, abs=1e-12)


def test_free_motion_that_mass_damping_slows_down_keeps_its_balances():
    """v = v0 exp(-rate t): the work is the energy that is lost, the impulse the momentum that is lost."""
    layout, rate, mass, start = Layout([DAMPED]), 3.0, 0.7, np.array([2.0, -1.0, 0.5])
    time = np.linspace(0.0, 0.8, 1601)
    velocity = np.exp(-rate * time)[:, None] * start
    rows = np.zeros((len(time), layout.width))
    rows[:, layout.place["time"]] = time[:, None]
    rows[:, layout.place["kinetic"]] = 0.5 * mass * (velocity**2).sum(axis=1, keepdims=True)
    rows[:, layout.place["momentum"]] = mass * velocity
    columns = filled(rows, layout=layout, factors=tc.MassDamping(rate).factors).columns()
    lost, bound = columns["kinetic"][0] - columns["kinetic"], (rate * time[1]) ** 2  # of the trapezoidal rule
    assert lost[-1] > 0.98 * columns["kinetic"][0]
    assert np.abs(columns["damping_work"] - lost).max() <= bound * lost[-1]
    assert np.abs(columns["energy"] - columns["energy"][0]).max() <= bound * lost[-1]
    assert np.abs(columns["damping_impulse"] - mass * (velocity - start)).max() <= bound * mass


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
    layout = Layout([FRICTION])
    rows, _ = rows_of(layout, 12)
    whole = filled(rows, layout=layout).columns()
    thin = History(5, layout=layout)
    thin.add(rows[:7])
    thin.add(rows[7:])
    thin.finish()
    for name in ("time", "impulse", "friction_work", "external_work", "energy"):
        assert np.array_equal(thin.columns()[name], whole[name][[0, 5, 10, 11]]), name


TERMS = [
    APPLIES,
    DAMPED,
    FREE_OBSTACLES,
    FRICTION,
    HEATED,
    HOURGLASS,
    LAYERS,
    LOADS,
    MISES_MAXIMUM,
    PAIRED,
    PLASTIC,
    PLASTIC_HOURGLASS,
    PRESSURE_MAXIMUM,
    PULLED,
    RIGID_BODIES,
    RIGID_PARTS,
    SPRINGS,
    VISCOUS,
]


def test_every_column_stands_in_the_file_and_in_the_documentation_with_its_unit(tmp_path):
    rigid = {"free": ("die",), "part": ("ring-rim",)}
    layout = Layout(TERMS, ("die", "wall"), ("upper-lower",), rigid=rigid)
    rows, _ = rows_of(layout, 3)
    columns = filled(rows, (1,), layout=layout).columns()
    write_history(tmp_path / "history.csv", columns)
    with open(tmp_path / "history.csv", encoding="utf-8") as file:
        written = {re.sub("_[xyz]$", "", name).partition(":")[0] for name in next(csv.reader(file))}
    page = (Path(__file__).resolve().parents[1] / "docs" / "COLUMNS.md").read_text(encoding="utf-8")
    described = re.findall(r"^\| `(\w+)(?::NAME)?` \| (\d) \| ([^|]+) \| (.+) \|$", page, flags=re.M)
    shown = [column for column in COLUMNS if column.shown]
    assert described == [(c.name, str(c.size), c.unit, c.text + (f" ({c.term})" if c.term else "")) for c in shown]
    assert written == {column.name for column in shown}
    assert all(columns[c.name].shape == (3, 3)[: 2 if c.size == 3 else 1] for c in shown if c.name in columns)
    assert not set(Layout().place) & {"viscous_power", "friction_before", "layer_heat", "hourglass"}


GROUPS = ("nodes", "cells", "viscous", "boundary", "support", "contact", "gaps", "friction", "loads", "obstacle")


def raw_of(groups, seed):
    """Raw rows [4, ...] of random numbers, and what stands in them by group and name."""
    generator, by, parts = np.random.default_rng(seed), {}, []
    for group in groups:
        for column in group_columns(group):
            by[group, column.name] = generator.normal(size=(4, column.size))
            parts.append(by[group, column.name])
    return np.concatenate(parts, axis=1), by


def test_a_measured_row_adds_up_what_nodes_and_boundary_nodes_measure():
    layout, gravity = Layout([FRICTION, HOURGLASS, LOADS, VISCOUS], ("die",)), np.array([0.3, -0.1, -9.81])
    times = np.array([0.0, 0.1, 0.2, 0.3])
    raw, by = raw_of(GROUPS, 5)
    rows = RawRows(GROUPS, layout).measured(raw, times, gravity)
    for name in ("kinetic", "momentum", "angular_momentum"):
        assert np.array_equal(rows[:, layout.place[name]], by["nodes", name] + by["boundary", name]), name
    weight = by["nodes", "mass_displacement"] @ gravity
    assert rows[:, layout.place["load_work"]][:, 0] == pytest.approx(weight + by["boundary", "load_work"][:, 0])
    single = ("contact_force", "sweeps", "jacobian_min", "friction_after", "viscous_rate", "support_power")
    for group, name in ((group, name) for group, name in by if name in single):
        assert np.array_equal(rows[:, layout.place[name]], by[group, name]), name
    assert np.array_equal(rows[:, layout.place["obstacle_moment:die"]], by["obstacle", "obstacle_moment"])
    assert np.array_equal(rows[:, layout.place["time"]][:, 0], times)


def test_a_gap_to_nothing_is_infinite_and_one_that_is_no_number_stays_so():
    groups = ("nodes", "cells", "boundary", "support", "contact", "gaps")
    raw, place = raw_of(groups, 7)[0][:3].copy(), sum(column.size for column in group_columns(*groups[:-1]))
    raw[:, place] = 1e300, np.nan, -2.0
    rows = RawRows(groups, Layout()).measured(raw, np.arange(3.0), np.zeros(3))
    np.testing.assert_array_equal(rows[:, Layout().place["gap_min"].start], [np.inf, np.nan, -2.0])


def test_bodies_together_have_the_sum_and_the_worst_of_them():
    """A body without contact has no gap and no shear stress, and leaves those of the others as they are."""
    layout, times = Layout([LAYERS]), np.zeros(4)
    touching, by = raw_of(GROUPS[:2] + GROUPS[3:7], 1)
    free, other = raw_of(GROUPS[:2], 2)
    rows = [RawRows(GROUPS[:2] + GROUPS[3:7], layout).measured(touching, times, np.zeros(3))]
    rows += [RawRows(GROUPS[:2], layout).measured(free, times, np.zeros(3))]
    rows[0][:, layout.place["layer_shear_min"]] = 3.0
    total = combined(rows, layout)
    assert np.array_equal(total[:, layout.place["elastic"]], by["cells", "elastic"] + other["cells", "elastic"])
    least = np.minimum(by["cells", "jacobian_min"], other["cells", "jacobian_min"])
    assert np.array_equal(total[:, layout.place["jacobian_min"]], least)
    assert np.array_equal(total[:, layout.place["gap_min"]], by["gaps", "gap_min"])
    assert (total[:, layout.place["layer_shear_min"]] == 3.0).all()
    assert (rows[1][:, layout.place["gap_min"]] == np.inf).all()
