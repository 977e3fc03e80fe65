"""The evidence can fail: with the computation spoilt, every case comes out wrong that does not say why it cannot."""

import pytest
import sabotage
from conftest import THREADS

import tcontact as tc
from tcontact.study import hard_cases

CASES = hard_cases.register()
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
