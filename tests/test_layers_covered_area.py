"""Friction layers of slaves whose covered area changes: heat [J] that was made stays, whatever area is covered."""

import numpy as np
from scenes import simulate
from test_resume import split

import tcontact as tc

DT = 2e-8


def overhanging(plastic_heat=1.0, steps=100):
    """A block that is pressed on a shorter one and slides off its edge, so that its slaves lose covered area."""
    law = tc.NeoHookean(200e9, 0.3, 7900.0)
    upper, lower = (
        tc.box_mesh((2e-3, 1e-3, 1e-3), cells, origin=origin)
        for cells, origin in (((4, 1, 1), (-1e-3, 0.0, 1e-6)), ((2, 1, 1), (-1.1e-3, 0.0, -1e-3)))
    )
    driven, held = tc.Support("zmax", "xz", (300.0, -20.0)), tc.Support("zmin", "xyz")
    up = tc.Body(upper, law, (300.0, 0.0, -20.0), "zmin", [driven], name="up")
    low = tc.Body(lower, law, contact="zmax", supports=[held], name="low")
    friction = tc.FrictionLayer(thickness=1e-5, plastic_heat=plastic_heat)
    pairs, contact = [tc.Pair("up", "low", slave="up")], tc.MasslessContact("normal")
    return tc.Scene([up, low], [], (steps - 0.5) * DT, friction=friction, pairs=pairs, contact=contact)


def test_plastic_heat_that_was_made_stays_where_the_covered_area_changes():
    """Heat beyond the friction work is of plastic flow: no row takes back what an earlier one had.

    It is the share plastic_heat of one flow: half of it leaves half the heat, to the little that this changes the flow.
    """
    found = {}
    for share in (0.0, 0.5, 1.0):
        history = simulate(overhanging(share), dt=DT).history
        found[share] = history["layer_heat"] - history["friction_work"]
        work = history["friction_work"][-1]
        assert work > 1e-2
    assert np.abs(found[0.0]).max() < 1e-14 * work
    assert found[1.0][-1] > 5e-6
    for share in (0.5, 1.0):
        assert np.diff(found[share]).min() >= -1e-14 * work
    np.testing.assert_allclose(found[0.5][-1], 0.5 * found[1.0][-1], rtol=1e-2)


def test_checkpoints_hold_the_plastic_heat_of_areas_that_are_left(monkeypatch, tmp_path):
    """A run that is resumed after its areas have changed has the same bits."""
    whole = split(monkeypatch, tmp_path, overhanging(steps=60), 2, tc.CentralDifference(dt=DT), frames=2)
    assert whole.history["layer_heat"][-1] > whole.history["friction_work"][-1]
