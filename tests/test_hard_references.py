"""The figures that the hard cases are compared with are those that the oracle computes."""

import hard_references
import numpy as np
import pytest

from tcontact.study import hard_register
from tcontact.study.hard import references

ROUNDED = 1e-3  # of the figures, which are kept with four or five digits


def recompute(name):
    cells, runs = hard_references.runs(name)
    found = [hard_references.measure(run, references.UNTIL.get(name)) for run in runs]
    np.testing.assert_allclose(found, references.IMPULSES[name][cells], rtol=ROUNDED)


@pytest.mark.parametrize("name", ["two-cells", "step-above-limit"])
def test_quick_figures_are_those_of_the_oracle(name):
    recompute(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", references.IMPULSES)
def test_figures_are_those_of_the_oracle(name):
    recompute(name)


def test_stable_steps_are_those_of_the_oracle():
    for name, case in (("step", "step-1.3"), ("sliver-tets-extreme", "sliver-tets-extreme")):
        scene = hard_register.register()[case].runs(False)[0].scene
        cells = scene.bodies[0].mesh.cell_count
        assert references.STABLE_STEPS[name][cells] == pytest.approx(hard_references.stable_step(scene), rel=ROUNDED)


def test_figures_of_a_known_pulse():
    """A rectangle of 3 N from 1 s to 3 s against one wall, 1 N from 5 s to 6 s against the opposite one."""
    time = np.linspace(0.0, 8.0, 8001)
    force = np.zeros((8001, 3))
    force[:, 2] = 3.0 * ((time > 1.0) & (time < 3.0)) - 1.0 * ((time > 5.0) & (time < 6.0))
    up = np.array([0.0, 0.0, 1.0])
    found = references.figures(time, force, [up, -up], 8.0)
    np.testing.assert_allclose(found[0], (6.0, 2.0, 2.0 / np.sqrt(12.0)), rtol=2e-3)
    np.testing.assert_allclose(found[1], (1.0, 5.5, 1.0 / np.sqrt(12.0)), rtol=2e-3)
    assert references.figures(time, force, [up], 2.0)[0, 0] == pytest.approx(3.0, rel=2e-3)
    assert np.isnan(references.figures(time, 0.0 * force, [up], 8.0)).all()


def test_every_reference_is_of_a_case_at_both_sizes():
    known = hard_register.register()
    assert set(references.IMPULSES) <= set(known)
    for name, sizes in references.IMPULSES.items():
        assert {hard_references.runs(name, full)[0] for full in (False, True)} == set(sizes), name
