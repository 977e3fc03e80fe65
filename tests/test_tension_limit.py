"""Neo-Hookean bodies with a negative Poisson's ratio: their largest tension, and what a run that passes it says."""

import re

import numpy as np
import pytest

import tcontact as tc
from tcontact.scene.tension_limit import largest_tension, tension_advice

MESH = tc.box_mesh((0.1, 0.08, 0.06), (2, 2, 2), "hex8")
FIGURES = {-0.1: (1.253, 0.112), -0.3: (1.091, 0.0294), -0.5: (1.0433, 0.0110), -0.7: (1.0195, 0.00410)}


def pulled(poisson, law=tc.NeoHookean):
    """A block on three rollers that a traction of 0.3 of Young's modulus pulls."""
    supports = [tc.Support(axis + "min", axis) for axis in "xyz"]
    load = tc.Load("xmax", traction=(3e5, 0.0, 0.0))
    return tc.Scene([tc.Body(MESH, law(1e6, poisson, 1000.0), supports=supports, loads=[load])], duration=0.05)


@pytest.mark.parametrize("poisson", FIGURES)
def test_the_largest_tension_under_equal_stretches(poisson):
    """The figures of the docs, and the slope of the energy per reference volume among many stretches."""
    material = tc.NeoHookean(1.0, poisson, 1.0)
    stretch, stress = largest_tension(material)
    assert (stretch, stress) == pytest.approx(FIGURES[poisson], rel=5e-3)
    lam, mu = material.lame_lambda, material.lame_mu
    l = np.linspace(1.0, 2.0, 100001)  # noqa: E741
    energy = 1.5 * mu * (l**2 - 1.0) - 3.0 * mu * np.log(l) + 0.5 * lam * (l**3 - 1.0) ** 2
    slope = np.gradient(energy, l) / 3.0
    assert stress == pytest.approx(slope[1:-1].max(), rel=1e-6)
    assert stretch == pytest.approx(l[1:-1][slope[1:-1].argmax()], abs=1e-3)


def test_other_laws_and_ratios_have_none():
    materials = [
        tc.NeoHookean(1e6, 0.0, 1e3), tc.NeoHookean(1e6, 0.3, 1e3), tc.StVenantKirchhoff(1e6, -0.3, 1e3),
        tc.LinearElastic(1e6, -0.3, 1e3), tc.MooneyRivlin(1e5, 0.0, 1.0, 1e3), tc.Ogden((4e5,), (2.0,), 0.0, 1e3),
    ]  # fmt: skip
    assert [largest_tension(one) for one in materials] == [None] * len(materials)
    assert tension_advice([tc.Body(MESH, one) for one in materials]) == ""


def test_a_run_beyond_it_names_the_law_first():
    """Explicit steps diverge: a lower cfl is no remedy. With a positive ratio the same pull is held."""
    result = tc.simulate(pulled(-0.3))
    assert result.reason == "diverged"
    law = (
        "NeoHookean with poisson -0.3 carries no more than 2.94e+04 Pa of tension along all axes, at stretches of 1.091"
    )
    assert law in result.message
    assert result.message.index(law) < result.message.index("lower cfl")
    assert tc.simulate(pulled(0.3)).ok
    assert tc.simulate(pulled(-0.3, tc.StVenantKirchhoff)).ok


def test_an_implicit_step_that_fails_in_a_part_names_that_part():
    """When the part began that did not converge, and det F there: it named those of the start of the step."""
    result = tc.simulate(pulled(-0.7), scheme=tc.PaperImplicit(dt=0.05))
    assert result.reason == "not-converged"
    assert result.steps == 0
    later = re.search(
        r"at t = 0 s: .* the step from there: ([\d.e-]+) s later, also with a step of ([\d.e-]+) s", result.message
    )
    assert later, result.message
    assert float(later[2]) == pytest.approx(0.05 / 1024, rel=1e-2)
    assert float(later[2]) <= float(later[1]) < 0.05
    assert float(re.search(r"det F = (\S+) there", result.message)[1]) != 1.0
    assert "carries no more than" in result.message


@pytest.mark.filterwarnings("ignore::tcontact.EnergyWarning")
def test_a_start_of_negative_energy_is_no_growth():
    """Beyond the limit the stored energy is negative; the run was stopped at its start, as above ten times itself."""
    body = tc.Body(MESH, tc.NeoHookean(1e6, -0.5, 1000.0), displacement=lambda x: 0.2 * x)
    result = tc.simulate(tc.Scene([body], duration=0.02), scheme=tc.CentralDifference(cfl=0.1))
    start = result.history["elastic"][0]
    assert start < -1.0
    assert result.steps > 10
    assert result.reason == "diverged"
    assert f"from the {start:.3g} J that the run started with or was given, by over 9 times as much" in result.message
    assert tc.simulate(tc.Scene([body], duration=1e-3), scheme=tc.CentralDifference(cfl=0.1)).ok
