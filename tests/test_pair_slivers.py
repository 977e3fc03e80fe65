"""Rows of slave faces of which only a far sliver is covered: what does not touch is not pressed."""

import numpy as np
import pytest
from pair_scenes import soft

import tcontact as tc
from tcontact.contact.pairs.coupling import couple
from tcontact.contact.pairs.search import close_faces
from tcontact.contact.pairs.surfaces import facings_of, surfaces_of


def over_a_slope(kind="hex8"):
    """Return a block that stands .01 above the edge of a slope of 50 degrees, which lies under .02 of its last faces.

    The slope would be half a block high under the middle nodes of the upper block if it went on there.
    """
    up = tc.box_mesh((1, 1, 1), (2, 2, 2), kind, origin=(-0.5, -0.5, 0.0))
    low = tc.box_mesh((1, 2, 1), (2, 4, 2), kind, origin=(0.0, -1.0, -1.0)).rotated(((0, 1, 0), np.radians(50.0)))
    low = low.translated((0.48, 0.0, -0.01))
    bodies = [tc.Body(up, soft(), contact="zmin", name="up"), tc.Body(low, soft(), contact="zmax", name="low")]
    pairs = [tc.Pair("up", "low", slave="up")]
    return tc.Scene(bodies, duration=2.0, pairs=pairs, contact=tc.MasslessContact("full"))


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_nodes_far_from_the_part_that_is_covered_have_no_row(kind, taichi):
    domain = tc.plan(over_a_slope(kind=kind)).domains[0]
    facing, positions = facings_of(domain, surfaces_of(domain))[0], domain.reference
    rows = couple(facing, positions, close_faces(facing, positions))
    assert len(rows.slaves) == 3  # those of the edge over the slope
    assert rows.gaps(positions).min() > 0.0


def test_bodies_at_rest_that_do_not_touch_stay_where_they_are():
    """The middle nodes had rows half a block deep, whose force threw the bodies apart."""
    result = tc.simulate(over_a_slope())
    assert result.ok
    assert not result.pair_force["up-low"].any()
    assert np.abs(result.velocity).max() == 0.0


def test_the_tip_of_a_coarse_ball_on_another_keeps_its_row():
    """The tip is itself a corner of what is covered; the inner points lie more than the reach above it."""
    low, up = (tc.ball_mesh(0.05, 4, center=(0.0, 0.0, z)) for z in (0.0, 0.1 + 2e-6))
    rubber = tc.NeoHookean(young=1e7, poisson=0.3, density=1000.0)
    bodies = [
        tc.Body(low, rubber, (0, 0, 0.25), contact="high", name="low"),
        tc.Body(up, rubber, (0, 0, -0.25), contact="low", name="up"),
    ]
    result = tc.simulate(tc.Scene(bodies, duration=3.2e-3))
    history = result.history
    assert result.ok
    assert history["pair_rows:low-up"][0] == 9
    first = history["time"][np.flatnonzero(history["pair_pressed:low-up"])[0]]
    assert first <= 2e-6 / 0.5 + 2.0 * result.dt
    assert history["energy_error"].max() <= 3e-3
