"""The friction layer in the program: bad input is named; its case, its study and its benchmark."""

from __future__ import annotations

import dataclasses

import pytest
from conftest import THREADS
from test_friction_layer import STEEL

import tcontact as tc
from tcontact import cases
from tcontact import friction_layer as layer
from tcontact.friction_layer import study


@pytest.mark.parametrize(
    "wrong",
    [
        {"velocity": float("nan")},
        {"velocity": [[34.0], [34.0]]},
        {"velocity": [1.0, 2.0], "pressure": [1e9, 1e9, 1e9]},
        {"pressure": "high"},
        {"pressure": []},
        {"duration": 0.0},
        {"dt": -1e-9},
        {"points": 2},
        {"points": 10.5},
        {"grading": 0.0},
        {"grading": 1e300},
        {"thickness": 0.0},
        {"heat_share": 1.5},
        {"plastic_heat": -0.1},
        {"initial_temperature": -1.0},
        {"method": "bisection"},
        {"material": "steel"},
        {"other": "copper"},
        {"conductance": 1e6},
        {"conductance": -1.0, "other": layer.COPPER},
        {"other": layer.COPPER, "method": "stress-secant"},
        {"history_every": 0},
        {"reload": "sometimes"},
    ],
)
def test_bad_input_is_named(wrong):
    with pytest.raises(tc.InputError):
        layer.solve(**wrong)


@pytest.mark.parametrize(
    "wrong",
    [
        {"hardening": 0.0},
        {"hardening_exponent": 0.0},
        {"hardening_exponent": 1.1},
        {"yield_stress": -1.0},
        {"thermal_softening": -1.0},
        {"sharpness": float("nan")},
        {"density": 0.0},
    ],
)
def test_bad_metals_are_named(wrong):
    with pytest.raises(tc.InputError, match=next(iter(wrong))):
        dataclasses.replace(STEEL, **wrong)


def test_case_meets_its_checks_and_writes_its_files(tmp_path, capsys):
    from tcontact.commands.cli import main

    assert main(["run", "friction-layer", "--out", str(tmp_path / "run"), "--threads", "2"]) == 0
    found = {path.name for path in (tmp_path / "run").iterdir()}
    assert found == {"summary.json", "history.csv", "profile.csv", "yield-limit.png", "surface.png"}
    assert "34 m/s: tau error" in capsys.readouterr().out
    assert main(["run", "friction-layer", "--out", str(tmp_path / "run"), "--threads", "2"]) == 2  # never overwrites
    assert main(["run", "friction-layer", "--set", "cfl=0.5", "--out", str(tmp_path / "other")]) == 2
    case = cases.load("friction-layer")
    wrong = case.solve(points=20)
    assert any(not check.passed for check in case.checks(wrong))


def test_study_rows_and_figure(tmp_path):
    row = study.accuracy("bracketed-newton", 34.0, 40, 30.0, 2e-9)
    assert 0.0 < row["stress_error"] < 0.01 > row["temperature_error"] > 0.0
    assert row["failures"] == 0
    assert row["cell_updates"] == row["cells"] * row["steps"]
    study.draw(tmp_path / "study.png", [row])
    assert (tmp_path / "study.png").stat().st_size > 5000
    assert study.study(budget_s=0.0) == []


def test_bench_rows_carry_their_errors(monkeypatch):
    from tcontact.lab.bench import layer as bench

    monkeypatch.setattr(bench, "CELLS", 16)
    monkeypatch.setattr(bench, "RUNS", 2)
    row = {"threads": THREADS, "ok": True, **bench.layer("cpu", THREADS)}
    assert [grid["points"] for grid in row["grids"]] == [40, 200]
    for found in row["grids"]:
        assert 0.0 < found["temperature_error"] < 4e-3
        assert 0.0 < found["stress_error"] < 4e-3
        assert found["energy_error"] <= 1e-12
        assert found["failures"] == 0
        assert 0.0 < found["rate"]["low"] <= found["rate"]["median"]
    text = bench.lines([row, {"threads": 1, "ok": False, "reason": "because"}])
    assert "(temperature)" in text[0]
    assert text[-1].endswith("FAILED: because")
