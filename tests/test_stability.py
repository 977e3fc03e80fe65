"""The hard cases: every one gives the right answer, or refuses with the remedy. Fast sizes here, full ones if slow."""

import csv
import json

import numpy as np
import pytest
import sabotage
from conftest import THREADS

import tcontact as tc
from tcontact.cases import bar_impact
from tcontact.commands.cli import main
from tcontact.lab.study import hard_cases, hard_register, hard_table
from tcontact.results import checks as ck

CASES = hard_register.register()


@pytest.mark.parametrize("name", CASES)
def test_hard_case(name):
    outcome = hard_cases.evaluate(CASES[name], threads=THREADS)
    assert outcome.as_expected, f"{outcome.verdict}: {outcome.detail}"


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_hard_case_at_full_size(name):
    outcome = hard_cases.evaluate(CASES[name], full=True, threads=THREADS)
    assert outcome.as_expected, f"{outcome.verdict}: {outcome.detail}"


# the evidence can fail: with the computation spoilt, every case comes out wrong that does not say why it cannot

QUICK = (  # hundredths of a second each, one of every kind
    "nu-0.49-full",
    "shock-0.05",
    "svk-beyond-its-limit",
    "thin-surface-layer",
    "sliver-tets-extreme",
    "two-cells",
    "edge-first",
    "spinning-cube",
    "start-touching",
    "grazing-flight",
    "step-0.99",
    "step-1.3",
    "random-rotation",
)


def verdict(name, change, monkeypatch):
    """Whether a case still comes out as expected with one change, and whether there was anything to change."""
    spoilt = sabotage.Spoilt(change)
    monkeypatch.setattr(tc, "simulate", spoilt)
    return hard_cases.evaluate(CASES[name], threads=THREADS).as_expected, spoilt.altered


@pytest.mark.parametrize("change", ["wall", "method", "modulus"])
@pytest.mark.parametrize("name", QUICK)
def test_a_quick_hard_case_notices_a_spoilt_computation(name, change, monkeypatch):
    passes, altered = verdict(name, change, monkeypatch)
    assert altered
    assert passes == (change in CASES[name].cannot_feel)


@pytest.mark.slow
@pytest.mark.parametrize("change", hard_cases.CHANGES)
@pytest.mark.parametrize("name", CASES)
def test_every_hard_case_notices_a_spoilt_computation(name, change, monkeypatch):
    """What it declares that it cannot feel it must not feel: no declaration is idle."""
    passes, altered = verdict(name, change, monkeypatch)
    assert passes == (change in CASES[name].cannot_feel or not altered)


def test_few_cases_declare_that_they_cannot_feel_something():
    """At most the refusals, the free flight, and what ends before the contact matters."""
    for change, most in {"wall": 4, "method": 4, "modulus": 4, "density": 4}.items():
        blind = [name for name, case in CASES.items() if change in case.cannot_feel]
        assert len(blind) <= most, blind
    for case in CASES.values():
        assert set(case.cannot_feel) <= set(hard_cases.CHANGES)
        assert all(reason for reason in case.cannot_feel.values())


# verdicts are computed: each can go wrong


def case(**changes):
    """A case that comes out right, with changes."""
    values = {
        "name": "x",
        "hard": "nothing",
        "runs": lambda full: [hard_cases.Run(bar_impact.scene(cells=8))],
        "judge": lambda results: [ck.finished(results[0])],
    }
    return hard_cases.HardCase(**values | changes)


def refusing(full):
    raise tc.InputError("field", 1, "use the remedy")


def crashing(full):
    raise ZeroDivisionError("oh")


def blowing_up(full):
    return [hard_cases.Run(bar_impact.scene(cells=8, duration=0.1), tc.CentralDifference(cfl=1.5))]


@pytest.mark.parametrize(
    ("changes", "verdict", "as_expected"),
    [
        ({}, "right", True),
        ({"judge": lambda results: [ck.at_most("x", np.nan, 1.0)]}, "wrong", False),
        ({"runs": refusing}, "refused", False),
        ({"runs": refusing, "expected": ("refused",), "says": "the remedy"}, "refused", True),
        ({"runs": refusing, "expected": ("refused",), "says": "another remedy"}, "refused", False),
        ({"runs": refusing, "expected": ("refused",)}, "refused", False),
        ({"runs": blowing_up, "expected": ("stopped",), "says": "cfl < 1"}, "stopped", True),
        ({"runs": blowing_up}, "stopped", False),
        ({"expected": ("stopped",), "says": "x"}, "right", False),
        ({"runs": crashing}, "crashed", False),
    ],
)
def test_a_verdict_is_what_happened(changes, verdict, as_expected):
    outcome = hard_cases.evaluate(case(**changes), threads=THREADS)
    assert (outcome.verdict, outcome.as_expected) == (verdict, as_expected)


def test_the_table_names_what_is_not_as_it_should_be(tmp_path):
    report = hard_table.collect([case(name="fine"), case(name="bad", runs=crashing)], threads=THREADS)
    assert not report["passed"]
    text = "\n".join(hard_table.lines(report))
    assert "bad: crashed instead of right: ZeroDivisionError: oh" in text
    assert "fine: " not in text
    hard_table.write_csv(tmp_path / "x.csv", report["rows"])
    with (tmp_path / "x.csv").open(encoding="utf-8", newline="") as file:
        assert [row["verdict"] for row in csv.DictReader(file)] == ["right", "crashed"]
    left_out = hard_table.collect([case()], budget=-1.0, threads=THREADS)
    assert left_out["rows"][0]["verdict"] == "not run"


def test_the_command_prints_the_table(tmp_path, capsys):
    words = ["study", "hard-cases", "--methods", "start-deep-inside,grazing-flight", "--threads", str(THREADS)]
    assert main([*words, "--out", str(tmp_path / "x")]) == 0
    text = capsys.readouterr().out
    assert "grazing-flight" in text
    assert "move the body or the obstacle apart" in text
    rows = json.loads((tmp_path / "x" / "study.json").read_text(encoding="utf-8"))["rows"]
    assert [row["verdict"] for row in rows] == ["refused", "right"]
