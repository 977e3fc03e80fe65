"""The warning about energy in hourglass modes: one-point hexahedra that bend in one layer are named, others are not."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import thrown
from test_named_warnings import warned

import tcontact as tc
from tcontact.run.end_checks import hourglass_warning


def strip(layers, formulation="reduced"):
    """Return a strip of cubes, held at one end, that swings in its first bending motion for a quarter of its period."""
    mesh = tc.box_mesh((0.1, 0.01, 0.01), (10 * layers, layers, layers))
    quarter = 0.25 * 2.0 * np.pi / (1.8751**2 * 0.01 / 0.1**2 * np.sqrt(1e7 / 1000.0 / 12.0))

    def velocity(nodes):
        return 0.01 * (nodes[:, :1] / 0.1) ** 2 * np.array([0.0, 0.0, 1.0])

    body = tc.Body(
        mesh,
        tc.LinearElastic(young=1e7, poisson=0.3, density=1000.0),
        supports=tc.Support("xmin", "xyz"),
        velocity=velocity,
        formulation=formulation,
    )
    return tc.Scene([body], duration=quarter)


@pytest.mark.parametrize(("layers", "named"), [(1, True), (4, False)])
def test_a_strip_that_bends_by_its_hourglass_stiffness_is_named(layers, named):
    """One layer of one-point hexahedra has no strain in its middle as it bends; four layers have."""
    result, kinds = warned(strip(layers))
    assert kinds == [tc.HourglassWarning] * named
    share = result.history["hourglass"].max() / result.history["elastic"].max()
    assert share > 0.9 if named else share < 0.1
    if named:
        assert f"reached {share:.2g} of the largest energy of deformation" in result.warnings[0]
        for remedy in ("finer cells", "several layers", "formulation='full' or 'mean-dilatation'"):
            assert remedy in result.warnings[0]
        assert not warned(strip(layers, "full"))[1]


def test_a_block_that_strikes_a_wall_is_not_named():
    """A block that is pressed flat strains its cells in their middles, though its sides bulge."""
    scene = thrown("linear", gravity=False, contact=tc.MasslessContact())
    result, kinds = warned(replace(scene, bodies=[replace(scene.bodies[0], formulation="reduced")]))
    assert result.ok
    assert result.history["hourglass"].max() > 0.0
    assert not kinds


def test_flow_counts_as_deformation_and_rounding_as_none():
    """The share of a metal counts what its modes and its flow dissipated; energies of rounding have none."""
    time = np.array([0.0, 1.0, 2.0])
    rows = {"time": time, "kinetic": np.ones(3), "elastic": np.array([0.0, 1.0, 0.5]), "hourglass": time * 0.1}
    assert "reached 0.2 of the largest energy of deformation (at t = 2 s)" in hourglass_warning(rows, 0.0)
    assert hourglass_warning(rows, 0.2) is None
    assert hourglass_warning(rows | {"hourglass": time * 0.05}, 0.0) is None
    assert hourglass_warning(rows | {"plastic_work": time}, 0.0) is None
    assert "reached 0.44" in hourglass_warning(rows | {"plastic_work": time, "hourglass_work": time * 0.8}, 0.0)
    assert hourglass_warning({name: rows[name] for name in ("time", "kinetic", "elastic")}, 0.0) is None
