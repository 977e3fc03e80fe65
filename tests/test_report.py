"""summary.json, history.csv, the table and the plots say what the run said: no digit lost, nothing smoothed."""

from __future__ import annotations

import csv
import json
import math

import numpy as np
import pytest

from tcontact.results import report
from tcontact.results.checks import at_least, at_most, between, equals
from tcontact.show import plots


def history(rows: int = 50) -> dict[str, np.ndarray]:
    """A made-up history with every column a plot reads."""
    time = np.linspace(0.0, 3e-3, rows)
    force = np.zeros((rows, 3))
    force[10:30, 2] = 1234.5678901234567
    flat = np.full(rows, 0.1)
    return {
        "time": time,
        "kinetic": flat,
        "elastic": flat / 3,
        "contact": np.zeros(rows),
        "external_work": np.zeros(rows),
        "energy": flat * 4 / 3,
        "energy_error": np.zeros(rows),
        "contact_force": force,
        "gap_min": np.linspace(1e-3, -1e-4, rows),
        "contact_nodes": np.arange(rows),
    }


def test_csv_keeps_every_digit_and_splits_vectors(tmp_path):
    made = history()
    report.write_history(tmp_path / "history.csv", made)
    with (tmp_path / "history.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 50
    np.testing.assert_array_equal([float(row["elastic"]) for row in rows], made["elastic"])
    np.testing.assert_array_equal([float(row["contact_force_z"]) for row in rows], made["contact_force"][:, 2])
    np.testing.assert_array_equal([float(row["time"]) for row in rows], made["time"])
    assert "contact_force" not in rows[0]


def test_json_is_strict_even_for_values_that_are_not_finite(tmp_path):
    data = {"a": np.float64("nan"), "b": np.array([1.0, np.inf]), "c": (np.int64(3), np.bool_(True)), "d": None}
    report.write_json(tmp_path / "x.json", data)

    def refuse(word):
        raise AssertionError(f"{word} is not JSON")

    back = json.loads((tmp_path / "x.json").read_text(encoding="utf-8"), parse_constant=refuse)
    assert back == {"a": "nan", "b": [1.0, "inf"], "c": [3, True], "d": None}


@pytest.mark.parametrize(
    ("value", "text"),
    [(2.5e-6, "2.5 us"), (1e-3, "1 ms"), (0.0, "0 s"), (1500.0, "1.5 ks"), (-3e-9, "-3 ns"), (1.0, "1 s")],
)
def test_si_prefixes(value, text):
    assert report.si(value, "s") == text


def test_bounds_are_inclusive_and_nan_never_passes():
    assert at_most("x", 1.0, 1.0).passed
    assert at_least("x", 1.0, 1.0).passed
    assert between("x", 1.0, 1.0, 2.0).passed
    assert equals("x", 4, 4).passed
    assert not at_most("x", 1.1, 1.0).passed
    assert not equals("x", 3, 4).passed
    for check in (at_most("x", math.nan, 1.0), at_least("x", math.nan, 1.0), between("x", math.nan, 0.0, 1.0)):
        assert not check.passed


def summary(**changes) -> dict:
    """The summary of a made-up run."""
    data = {"case": "some-case", "reason": "finished", "ok": True, "message": "", "steps": 10, "time": 3e-3}
    data |= {"dt": 9e-6, "dt_limit": 1e-5, "wall_s": 1.5, "compile_s": 0.5, "cell_updates_per_s": 1.25e7}
    data |= {"energy_error_max": 1.5e-3, "memory_bytes": {"mesh": 1000000}, "terms": ["internal-force"], "warnings": []}
    data |= {"cells": 64, "nodes": 125, "arch": "cpu", "threads": 2, "checks": [at_most("energy", 2.0, 1.0).to_dict()]}
    return data | changes


def test_speed_is_never_shown_without_the_energy_error():
    found = [line for line in report.lines(summary()) if "Mcell/s" in line]
    assert len(found) == 1
    assert "12.5 Mcell/s" in found[0]
    assert "1.50e-03" in found[0]


def test_table_shows_failed_checks_warnings_and_the_remedy():
    text = "\n".join(
        report.lines(summary(ok=False, reason="diverged", message="lower cfl", warnings=["dt above the limit"]))
    )
    assert "diverged" in text
    assert "remedy    lower cfl" in text
    assert "dt above the limit" in text
    assert "FAIL  energy" in text
    assert "0.90 of the limit 10 us" in text


def test_the_temperature_shown_is_the_highest_of_the_run():
    """It falls again where a pressed metal expands; files of earlier versions have that of the last row alone."""
    last = {"plastic_work": 2.0, "plastic_strain_max": 0.1, "temperature_max": 336.1}
    for data, expected in ((summary(last_row=last, temperature_max=371.6), "371.6"), (summary(last_row=last), "336.1")):
        assert any(f"temperature at most {expected} K" in line for line in report.lines(data))


def test_table_survives_values_that_are_not_finite():
    data = json.loads(json.dumps(report.plain(summary(dt=math.nan, time=math.inf, energy_error_max=math.nan))))
    assert "nan" in "\n".join(report.lines(data))


@pytest.fixture
def drawn(monkeypatch):
    """Every curve handed to matplotlib, as (label, x, y)."""
    from matplotlib.axes import Axes

    seen = []
    original = Axes.plot

    def plot(self, *data, **options):
        if len(data) == 2:
            seen.append((options.get("label"), np.asarray(data[0]), np.asarray(data[1])))
        return original(self, *data, **options)

    monkeypatch.setattr(Axes, "plot", plot)
    return seen


def test_force_is_drawn_unfiltered_in_a_readable_unit(tmp_path, drawn):
    made = history()
    exact = {"exact": (np.array([0.0, 3e-3]), np.array([1000.0, 1000.0]))}
    plots.contact_force(tmp_path / "force.png", made, [np.array([0.0, 0.0, 1.0])], exact)
    curves = {label: (x, y) for label, x, y in drawn}
    np.testing.assert_array_equal(curves["computed"][1], made["contact_force"][:, 2] / 1e3)  # kN, every row
    np.testing.assert_allclose(curves["computed"][0], made["time"] * 1e3, rtol=1e-15)  # ms
    np.testing.assert_array_equal(curves["exact"][1], [1.0, 1.0])
    assert (tmp_path / "force.png").stat().st_size > 5000


def test_force_on_several_normals_is_a_magnitude():
    made = history()
    made["contact_force"][:, 0] = 3.0
    made["contact_force"][:, 2] = 4.0
    walls = [np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])]
    np.testing.assert_allclose(plots.force_component(made, walls), 5.0)
    np.testing.assert_allclose(plots.force_component(made, walls[:1]), 4.0)


def test_energy_plot_leaves_out_what_never_was(tmp_path, drawn):
    plots.energy(tmp_path / "energy.png", history())
    labels = {label for label, _, _ in drawn}
    assert {"kinetic", "elastic", "sum"} <= labels
    assert not {"contact", "friction work", "external work"} & labels


def test_plots_survive_a_run_that_went_nowhere(tmp_path):
    made = {name: column[:1] for name, column in history().items()}
    normals = [np.array([0.0, 0.0, 1.0])]
    plots.contact_force(tmp_path / "force.png", made, normals)
    plots.gap(tmp_path / "gap.png", made)
    plots.energy(tmp_path / "energy.png", made)
    plots.comparison(tmp_path / "comparison.png", {"one": made, "two": made}, normals)
    assert len(list(tmp_path.glob("*.png"))) == 4


def test_plots_survive_a_run_that_blew_up(tmp_path):
    made = history()
    made["energy_error"][-1] = made["energy"][-1] = made["elastic"][-1] = np.nan
    made["contact_force"][-1] = np.inf
    plots.contact_force(tmp_path / "force.png", made, [np.array([0.0, 0.0, 1.0])])
    plots.energy(tmp_path / "energy.png", made)
