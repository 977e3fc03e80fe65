"""The figures that README.md and docs/NUMBERS.md state come out again."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import tcontact as tc
from tcontact import cases
from tcontact.base.errors import OutputError
from tcontact.commands import cli
from tcontact.commands.cli import main
from tcontact.lab.numbers import pages, register, rows, tables, times
from tcontact.lab.numbers.reports import Reports

ROOT = Path(__file__).resolve().parents[1]
QUICK = [row for row in (*register.RUNS, *register.IMPLICIT_RUNS) if row.quick]


@pytest.fixture(scope="module")
def reports(tmp_path_factory):
    return Reports(tmp_path_factory.mktemp("numbers"), main)


@pytest.fixture(scope="module")
def stated():
    return pages.tables(ROOT)


@pytest.mark.parametrize("row", QUICK, ids=lambda row: f"{row.command}: {row.quantity}"[4:60])
def test_the_stated_figures_come_out_again(row, reports, stated):
    """Rows that take a second; `tcontact numbers --check` has all of them."""
    present = f"| {row.quantity} | {row.figures(reports(row.command))} |"
    lines = [line for name in ("runs", "implicit", "short") for line in stated[name] if f"| {row.quantity} |" in line]
    assert lines, f"no table states {row.quantity}"
    of_row = [line[line.index(f"| {row.quantity} |") :] for line in lines if _command(line, stated) == row.command]
    assert of_row, f"no table states {row.quantity} of {row.command}"
    assert not [line for line in of_row if pages.differs(line, present)], present


def _command(line, stated):
    """The command of a line: in its first column, or in the nearest line above that has one."""
    table = next(lines for lines in stated.values() if line in lines)
    above = [other for other in table[: table.index(line) + 1] if "`tcontact " in other]
    return above[-1].split("`")[1].removeprefix("tcontact ")


def test_a_comparison_is_made_again_in_the_same_folder(tmp_path):
    """A report that is left from another time is not taken for that of a command that writes none."""
    command = "run cube-impact --set cells=3 --set duration=1e-4 --set compare=true"
    first, second = (Reports(tmp_path, main)(command) for _ in range(2))
    assert first["runs"] == second["runs"]
    with pytest.raises(OutputError, match="left no summary"):
        Reports(tmp_path, lambda words: 1)(command)


@pytest.mark.slow
def test_all_figures_that_do_not_depend_on_the_machine_come_out_again(tmp_path, capsys):
    assert cli.main(["numbers", "--check", "--docs", str(ROOT), "--out", str(tmp_path)]) == 0, capsys.readouterr().out


def test_the_documents_have_every_table_and_every_row_states_figures(stated):
    assert set(stated) == set(tables.TABLES)
    for name, chosen in (("runs", register.RUNS), ("implicit", register.IMPLICIT_RUNS)):
        assert len(stated[name]) == len(chosen) + len(tables.HEAD)
        for line, row in zip(stated[name][len(tables.HEAD) :], chosen, strict=True):
            assert row.quantity in line
            assert pages.NUMBER.findall(line.split("|")[-2])
    assert all(
        "`tcontact bench" in line or "`tcontact run" in line for line in stated["short"][2:] + stated["speed"][2:]
    )


@pytest.mark.parametrize(
    ("stated", "present", "changed"),
    [
        ("| a | 4.4e-2; 1.8e-5 |", "| a | 4.4e-2; 1.8e-5 |", False),
        ("| a | 4.4e-2; 1.8e-5 |", "| a | 4.5e-2; 1.8e-5 |", False),  # one unit of the last digit
        ("| a | 4.4e-2; 1.8e-5 |", "| a | 4.6e-2; 1.8e-5 |", True),
        ("| a | 0.794 |", "| a | 0.796 |", True),
        ("| a | 6e-15 |", "| a | 2e-14 |", False),  # both are rounding
        ("| a | 6e-15 |", "| a | 2e-9 |", True),
        ("| a | 1 |", "| b | 1 |", True),
        ("| a | 1 |", "| a | 1; 2 |", True),
        ("| a | 9.9e-3 |", "| a | 1.0e-2 |", False),
        ("| a | 12 |", "| a | stopped |", True),
    ],
)
def test_lines_are_compared_to_the_last_digit(stated, present, changed):
    assert pages.differs(stated, present) is changed


def test_tables_are_replaced_where_they_stand(tmp_path):
    (tmp_path / "docs").mkdir()
    text = "before\n<!-- tcontact numbers: {} -->\nold\n<!-- end -->\nafter\n"
    (tmp_path / "README.md").write_text(text.format("short"))
    (tmp_path / "docs" / "NUMBERS.md").write_text(text.format("runs"))
    assert pages.replace(tmp_path, {"runs": ["new", "lines"]}) == [tmp_path / "docs" / "NUMBERS.md"]
    assert pages.tables(tmp_path) == {"short": ["old"], "runs": ["new", "lines"]}
    assert (tmp_path / "docs" / "NUMBERS.md").read_text().startswith("before\n<!--")
    assert pages.different(["a 1", "b 2"], ["a 1", "b 3", "c"]) == [("", "c")]
    assert pages.different(["a 1"], ["a 3"]) == [("a 1", "a 3")]


def test_figures_are_taken_from_where_the_register_says():
    report = {"checks": [{"name": "rebound / speed", "value": 0.99}], "energy_error_max": "nan", "runs": {"a": 2e-15}}
    row = rows.Row(
        "run x", "three", "{:.2f}; {:.1e}; {:.0e}", ("checks > rebound / speed", "energy_error_max", "runs > a")
    )
    assert row.figures(report) == "0.99; nan; 2e-15"
    assert rows.short_exponents("4.40e-02 1e+03 e-05 1.8e+00") == "4.40e-2 1e3 e-5 1.8"
    with pytest.raises(ValueError, match="has no 'gone'"):
        rows.Row("run x", "none", "{}", ("checks > gone",)).figures(report)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--only", "nothing"], "use some of runs"),
        (["--check", "--write"], "give one of them"),
        (["--check", "--docs", "/nowhere"], "README.md and docs/"),
        (["--only", "short", "--docs", "/nowhere"], "README.md and docs/"),
    ],
)
def test_wrong_options_are_refused(words, says, capsys, monkeypatch):
    monkeypatch.setattr(Reports, "__call__", lambda *given: pytest.fail("it computes"))
    assert cli.main(["numbers", *words]) == 2
    assert says in capsys.readouterr().err


def test_times_of_the_cases_are_measured_written_and_said(tmp_path, monkeypatch, capsys):
    """The first run of a case has an empty kernel cache, the second one what the first left."""
    seen = []

    def run(name, folder, cache):
        seen.append((name, list(Path(cache).iterdir())))
        (Path(cache) / "kernel").touch()
        return 9.04 if len(seen) % 2 else 2.5

    monkeypatch.setattr(times, "_run", run)
    (tmp_path / "cases").mkdir()
    found = times.measure(tmp_path, lambda text: None)
    path = times.write(tmp_path, found)
    assert [name for name, _ in seen] == [name for name in cases.names() for _ in range(2)]
    assert all(bool(cache) == bool(number % 2) for number, (_, cache) in enumerate(seen))
    known = json.loads(path.read_text())
    assert known == found
    assert known["seconds"]["cube-impact"] == [9.0, 2.5]
    monkeypatch.setattr(cases, "TIMES", str(path))  # an absolute path takes the place of the folder
    assert main(["list", "-v", "cube-impact"]) == 0
    assert f"takes 2.5 s, the first time 9 s ({known['processor']}, {known['cores']} cores)" in capsys.readouterr().out


def test_a_case_that_cannot_run_has_no_time(tmp_path):
    with pytest.raises(tc.OutputError, match=r"`tcontact run no-such-case` ended with exit code 2: .*wall-shock"):
        times._run("no-such-case", tmp_path / "out", str(tmp_path))


def test_every_case_says_how_long_it_takes():
    assert not [name for name in cases.names() if not cases.took(name)]
