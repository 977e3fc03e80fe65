"""Bodies that come towards each other from beyond the reach of the rows get their rows before their gap closes."""

import numpy as np
import pytest
from pair_scenes import soft, total, touches

import tcontact as tc
from tcontact.cases import two_spheres


@pytest.mark.parametrize("gap", [0.05, 0.07, 0.11])
def test_blocks_with_cells_much_thinner_than_wide_touch_when_they_meet(gap):
    """The reach is a share of the thin edge: on the way to the next search of faces it could be passed unseen."""
    above = tc.box_mesh((1, 1, 0.1), (2, 2, 4), origin=(0, 0, gap))
    below = tc.box_mesh((1, 1, 0.1), (3, 3, 4), origin=(0, 0, -0.1))
    bodies = [
        tc.Body(above, soft(tc.LinearElastic), (0, 0, -0.02), contact="zmin", name="up"),
        tc.Body(below, soft(tc.LinearElastic), contact="zmax", name="low"),
    ]
    result = tc.simulate(tc.Scene(bodies, duration=gap / 0.02 + 0.4, pairs=[tc.Pair("up", "low")]))
    assert result.ok
    force = result.pair_force["up-low"][:, 2]
    touched = result.history["time"][np.argmax(force > 0.0)]
    assert abs(touched - gap / 0.02) <= 2.0 * result.dt
    assert touches(force) == 1
    assert np.abs(result.history["energy_error"]).max() <= 5e-2
    assert total(result, "momentum") <= 1e-11


def test_coarse_balls_touch_at_their_poles_before_the_middles_of_their_faces_are_near():
    """A face is within reach by its nearest corner: with inner points alone the first rows would overlap by 17 %."""
    result = tc.simulate(two_spheres.scene(cells=4))
    assert result.ok
    assert np.abs(result.history["energy_error"]).max() <= 2e-2
