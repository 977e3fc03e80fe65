"""`tcontact study friction-layer`: files, table, budget, failures by name."""

import csv
import json

import pytest
from conftest import THREADS

from tcontact.commands.cli import main
from tcontact.friction_layer import METHODS
from tcontact.friction_layer import study as layer


@pytest.fixture
def quick(monkeypatch):
    """Few grids and conditions; the secants at 4 ns, where one of them fails."""
    monkeypatch.setattr(layer, "GRIDS", ((20, 30.0), (200, 1.0)))
    monkeypatch.setattr(layer, "STEPS", (4e-9,))
    monkeypatch.setattr(layer, "SWEEP_BATCHES", 4)


def words(out, *more):
    return ["study", "friction-layer", "--threads", str(THREADS), "--out", str(out), *more]


def test_it_leaves_its_files_and_names_the_failures(tmp_path, capsys, quick):
    out = tmp_path / "study"
    assert main(words(out)) == 0
    text = capsys.readouterr().out
    data = json.loads((out / "study.json").read_text(encoding="utf-8"))
    rows = data["rows"]
    assert len(rows) == len(METHODS) + 2 * (2 + len(METHODS) - 1)
    assert "34 m/s, cheapest for" in text
    failed = {row["method"]: row["failed_conditions"] for row in rows if row["kind"] == "failures"}
    assert failed["bracketed-newton"] == 0 < failed["stress-secant"]
    for method, count in failed.items():
        assert f"{method}: {count} of 200 random conditions" in text
    broken = [row for row in rows if row["kind"] == "accuracy" and row["failures"]]
    assert broken
    assert all(f"{row['method']}: 1 of 2 runs of the case; {row['velocity']:g} m/s" in text for row in broken)
    names = {(best["method"], best["dt"]) for levels in data["pareto"].values() for best in levels}
    assert names == {("bracketed-newton", 4e-9)}
    with (out / "study.csv").open(encoding="utf-8", newline="") as file:
        table = list(csv.DictReader(file))
    assert len(table) == len(rows)
    assert "failed" not in table[0]
    wanted = {"kind", "method", "points", "dt", "wall_s", "compile_s", "temperature_error", "energy_error", "failures"}
    assert wanted <= set(table[0])
    assert (out / "study.png").stat().st_size > 5000
    assert main(words(out)) == 2


def test_a_budget_leaves_rows_out_and_says_so(tmp_path, capsys, quick, monkeypatch):
    """Time stands still until the first row is done."""
    clock = iter([0.0, 0.0, *[9.0] * 1000])
    monkeypatch.setattr(layer, "perf_counter", lambda: next(clock))
    assert main(words(tmp_path / "new", "--methods", "bracketed-newton", "--budget", "5")) == 0
    data = json.loads((tmp_path / "new" / "study.json").read_text(encoding="utf-8"))
    assert len(data["rows"]) == 1
    assert data["skipped"] == 4
    assert not data["interrupted"]
    text = capsys.readouterr().out
    assert "not run: 4 rows" in text
    assert "no figure" in text


def test_an_interrupted_study_keeps_what_it_has(tmp_path, quick, monkeypatch):
    def stop(*_arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(layer, "accuracy", stop)
    assert main(words(tmp_path / "new")) == 1
    data = json.loads((tmp_path / "new" / "study.json").read_text(encoding="utf-8"))
    assert data["interrupted"]
    assert [row["kind"] for row in data["rows"]] == ["failures"] * len(METHODS)


@pytest.mark.parametrize(
    ("more", "said"),
    [(["--methods", "nothing"], "bracketed-newton"), (["--sizes", "4"], "its own grids"), (["--full"], "its own")],
)
def test_bad_usage_is_refused_before_a_file_is_touched(more, said, tmp_path, capsys):
    assert main(words(tmp_path / "new", *more)) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "new").exists()
