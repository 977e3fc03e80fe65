"""The figures that README.md and docs/NUMBERS.md state come out again."""

from __future__ import annotations

from pathlib import Path

import pytest

from tcontact import cli
from tcontact.cli import main
from tcontact.numbers import pages, register, rows, tables
from tcontact.numbers.reports import Reports

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
    ],
)
def test_wrong_options_are_refused(words, says, capsys):
    assert cli.main(["numbers", *words]) == 2
    assert says in capsys.readouterr().err
