"""A run that starts from another one goes on with its friction layers: a run in two parts is the run in one."""

import dataclasses

import numpy as np
import pytest
from scenes import simulate
from test_friction_contact_layer import REMOVALS, sliding

import tcontact as tc
from tcontact.friction_layer import COPPER

DT, PART = 1.5e-9, 1.5e-7


@pytest.fixture(scope="module")
def parts():
    """By removal: the run of twice the duration, the first part and the second, which starts from the first."""
    found = {}
    for removal in REMOVALS:
        first = simulate(sliding(removal, PART), dt=DT)
        found[removal] = (
            simulate(sliding(removal, 2 * PART), dt=DT),
            first,
            simulate(sliding(removal, PART), dt=DT, initial=first),
        )
    return found


@pytest.mark.parametrize("removal", REMOVALS)
def test_layers_go_on_where_the_first_run_left_them(parts, removal):
    whole, first, second = parts[removal]
    before, after = first.history, second.history
    assert before["layer_temperature_max"][-1] > 330.0
    assert after["layer_temperature_max"][0] == pytest.approx(before["layer_temperature_max"][-1], rel=1e-12)
    assert after["layer_shear_min"][0] == pytest.approx(before["layer_shear_min"][-1], rel=1e-12)
    assert after["layer_heat"][0] == pytest.approx(0.0, abs=1e-9 * before["layer_heat"][-1])
    warm, strained = whole.layers[0], whole.layers[0].plastic_strain
    rise = np.abs(warm.temperature - 300.0).max()
    np.testing.assert_allclose(second.layers[0].temperature, warm.temperature, rtol=0, atol=2e-3 * rise)
    np.testing.assert_allclose(second.layers[0].plastic_strain, strained, rtol=0, atol=2e-2 * strained.max())
    np.testing.assert_allclose(second.layers[0].shear_stress, warm.shear_stress, rtol=1e-3)
    np.testing.assert_allclose(
        before["layer_heat"][-1] + after["layer_heat"][-1], whole.history["layer_heat"][-1], rtol=5e-3
    )


@pytest.mark.parametrize("removal", REMOVALS)
def test_heat_is_its_share_of_the_friction_work_of_the_second_part(parts, removal):
    history = parts[removal][2].history
    work = history["friction_work"]
    np.testing.assert_allclose(history["layer_heat"], 0.5 * work, rtol=0, atol=1e-12 * work.max())


def test_the_start_of_another_scene_may_differ_and_new_nodes_begin_cold(parts):
    """Another initial temperature and solver are for new layers alone; a face that was not there has no layers yet."""
    first = parts["normal"][1]
    scene = sliding("normal", PART, initial_temperature=500.0, tolerance=2e-2)
    wider = dataclasses.replace(scene.bodies[0], contact=["zmin", "xmin"])
    side = tc.Plane(point=(-1.0, 0.0, 0.0), normal=(1.0, 0.0, 0.0))
    scene = tc.Scene([wider], [tc.Plane(), side], 3 * DT, contact=scene.contact, friction=scene.friction)
    layers = simulate(scene, dt=DT, initial=first).layers[0]
    known = np.isin(layers.nodes, first.layers[0].nodes)
    assert 0 < known.sum() == len(first.layers[0].nodes) < len(layers.nodes)
    np.testing.assert_allclose(layers.temperature[~known], 500.0, rtol=1e-14)
    assert (np.abs(layers.temperature[known].max(axis=1) - first.layers[0].temperature.max()) < 60.0).all()
    assert (layers.temperature[known, -1] < 310.0).all()


@pytest.mark.parametrize("other", [{"points": 20}, {"grading": 10.0}, {"thickness": 5e-6}, {"material": COPPER}])
def test_layers_that_do_not_fit_are_refused(parts, other, tmp_path):
    out = tmp_path / "out"
    with pytest.raises(tc.InputError, match="FrictionLayer of that run"):
        tc.simulate(sliding("normal", PART, **other), initial=parts["normal"][1], out=out)
    assert not out.exists()


def test_scenes_without_layers_leave_none(parts):
    scene = sliding("normal", 3 * DT, friction=tc.Coulomb(0.1))
    result = simulate(scene, dt=DT, initial=parts["normal"][1])
    assert result.layers == (None,)
    assert simulate(sliding("normal", 3 * DT), dt=DT, initial=result).history["layer_temperature_max"][0] == 300.0
