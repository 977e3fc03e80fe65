"""The cases of loads: their exact solutions in known limits, and that their checks hold."""

import numpy as np
import pytest

import tcontact as tc
from tcontact.cases import inflated_ring, pressed_seal


def test_the_exact_ring_is_that_of_lame_for_small_pressures():
    """Plane strain, (b^2 - a^2) E u: p a (1 + nu) [(1 - 2 nu) a^2 + b^2] inside, 2 p a^2 b (1 - nu^2) outside."""
    law, a, b, stretch = tc.NeoHookean(2e6, 0.35, 1000.0), 0.3, 0.5, 1.0 + 1e-6
    pressure, outer, energy = inflated_ring.equilibrium(law, a, b, stretch)
    nu, young = law.poisson, law.young
    widened = pressure * a * (1.0 + nu) / young * ((1.0 - 2.0 * nu) * a**2 + b**2) / (b**2 - a**2)
    assert widened == pytest.approx(1e-6 * a, rel=1e-5)
    assert outer - b == pytest.approx(2.0 * pressure * a**2 * b * (1.0 - nu**2) / young / (b**2 - a**2), rel=1e-5)
    assert energy == pytest.approx(0.5 * pressure * 2.0 * np.pi * a * widened, rel=1e-3)


def test_the_exact_ring_is_that_of_rubber_of_constant_volume():
    """p = mu [ln(l_a/l_b) + (l_b^-2 - l_a^-2)/2] (Green and Zerna), which poisson .49999 comes near."""
    a, b, stretch = 0.1, 0.15, 1.6
    law = tc.NeoHookean(1e6, 0.49999, 1000.0)
    pressure, outer, _ = inflated_ring.equilibrium(law, a, b, stretch)
    wide = np.sqrt(b**2 + a**2 * (stretch**2 - 1.0))
    assert outer == pytest.approx(wide, rel=1e-4)
    ends = np.log(stretch * b / wide) + 0.5 * ((b / wide) ** 2 - 1.0 / stretch**2)
    assert pressure == pytest.approx(law.lame_mu * ends, rel=1e-3)


@pytest.mark.parametrize(
    ("case", "cells"), [(inflated_ring, 12), pytest.param(pressed_seal, 2, marks=pytest.mark.slow)]
)
def test_the_checks_of_the_cases_hold(case, cells):
    found = case.checks(tc.simulate(case.scene(cells=cells)))
    assert len(found) > 5
    assert [check for check in found if not check.passed] == []


def test_a_seal_that_is_free_to_widen_is_exact():
    """Without a fluid: the stress across is 0."""
    scene = pressed_seal.scene(press=1e-4, pressure=1e-6, poisson=0.3)
    height, (floor, lid, wall) = pressed_seal.exact(scene)
    law = scene.bodies[0].material
    assert height == pytest.approx(0.01 * (1.0 - 1e-4), rel=1e-6)
    assert floor == lid == pytest.approx(law.young / (1.0 - 0.3**2) * 1e-4 * 0.01 * 0.0025, rel=1e-3)
    assert wall == pytest.approx(0.0, abs=1e-10)
