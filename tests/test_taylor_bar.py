"""The cases taylor-bar and ball-drop: what they check holds, and can fail."""

from dataclasses import replace

import numpy as np
import pytest

import tcontact as tc
from tcontact.cases import ball_drop, taylor_bar
from tcontact.results.checks import Check


def failed(checks: list[Check]) -> list[str]:
    return [check.name for check in checks if not check.passed]


def test_the_bar_has_its_size_and_the_mass_of_a_quarter():
    for name, bar in taylor_bar.BARS.items():
        scene = taylor_bar.scene(cells=5, bar=name)
        body = scene.bodies[0]
        polygon = 3.0 * np.sin(np.pi / 12.0) * bar.radius**2  # six edges on the rim
        assert body.mass == pytest.approx(polygon * bar.length * bar.density, rel=1e-9)
        assert taylor_bar.size_of_cells(scene) <= 1.02 * bar.radius / 5  # layers of whole cells
        assert body.formulation == "mean-dilatation"
        assert tc.plan(scene).bodies[0].contact.removal == "normal"


@pytest.mark.parametrize("formulation", ["mean-dilatation", pytest.param("reduced", marks=pytest.mark.slow)])
def test_the_front_of_the_impact_keeps_energy_and_converges(formulation):
    """The first 5 us, the hardest ones for the static solve, on a coarse mesh."""
    result = tc.simulate(taylor_bar.scene(cells=3, formulation=formulation, duration=5e-6))
    assert failed(taylor_bar.checks(result)) == []
    history = result.history
    assert history["plastic_strain_max"][-1] > 0.5
    assert history["plastic_work"][-1] > 0.05 * history["kinetic"][0]
    assert result.warnings == []


@pytest.mark.slow
@pytest.mark.parametrize("formulation", ["mean-dilatation", "reduced"])
@pytest.mark.parametrize("bar", ["copper", "ofhc"])
def test_bars_have_the_length_and_the_foot_that_are_known(bar, formulation):
    result = tc.simulate(taylor_bar.scene(bar=bar, formulation=formulation))
    assert failed(taylor_bar.checks(result)) == []
    if bar == "copper":
        wrong = replace(result, position=result.position * np.array([1.0, 1.0, 1.005]))
        assert failed(taylor_bar.checks(wrong)) == ["length [mm]"]
        assert failed(taylor_bar.checks(replace(result, position=result.position * 0.95)))[-1] == "foot radius [mm]"


@pytest.mark.slow
def test_balls_keep_less_of_their_speed_the_faster_they_are():
    result = tc.simulate(ball_drop.scene(cells=2))
    assert failed(ball_drop.checks(result)) == []
    assert "restitution, elastic" in failed(ball_drop.checks(result.reversed()))


def test_johnson_and_the_balls_are_those_of_the_figures_known():
    scene = ball_drop.scene(cells=2)
    assert ball_drop.johnson(scene) == pytest.approx([0.370, 0.311, 0.281], abs=1e-3)
    assert [-body.velocity[2] for body in scene.bodies] == [5.0, 10.0, 20.0, 30.0]


@pytest.mark.parametrize(
    ("case", "wrong"),
    [
        (taylor_bar, {"cells": 1}),
        (taylor_bar, {"bar": "steel"}),
        (taylor_bar, {"law": "hollomon"}),
        (taylor_bar, {"speed": 0.0}),
        (ball_drop, {"cells": 2.5}),
        (ball_drop, {"balls": 0}),
        (ball_drop, {"speed": 1e3}),
    ],
)
def test_wrong_parameters_are_refused_by_name(case, wrong):
    with pytest.raises(tc.InputError, match=next(iter(wrong))):
        case.scene(**wrong)
