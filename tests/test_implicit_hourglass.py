"""Hourglass stiffness of one-point hexes in implicit steps: where between its levels each scheme takes it."""

import numpy as np
import pytest
from oracle.reduced import HOURGLASS_MODES

import tcontact as tc

pytestmark = pytest.mark.filterwarnings("ignore::tcontact.HourglassWarning")  # these motions are in hourglass modes

SCHEMES = {  # share of the hourglass energy of a step from rest that is lost
    "discrete gradient": (tc.DiscreteGradient(dt=1e-3), 0.0),
    "midpoint": (tc.Midpoint(dt=1e-3), 0.0),
    "dissipative": (tc.Dissipative(dt=1e-3, chi=0.3), 0.3),
    "dissipative, strongly": (tc.Dissipative(dt=1e-3, chi=1.0), 1.0),
    "paper": (tc.PaperImplicit(dt=1e-3), 1.0),
}


@pytest.mark.parametrize("name", SCHEMES)
def test_energy_that_an_hourglass_motion_loses_in_a_step(name):
    """Force k (q0 + level (q1 - q0)) against q1 - q0: with q0 = 0 the energy falls by (2 level - 1) k q1^2 / 2."""
    scheme, share = SCHEMES[name]
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (1, 1, 1))
    corners = np.empty((8, 3))
    corners[mesh.cells[0]] = 2.0 * np.outer(HOURGLASS_MODES[0], (1.0, -0.5, 0.3))
    body = tc.Body(mesh, tc.NeoHookean(2e7, 0.3, 1000.0), velocity=corners, formulation="reduced")
    history = tc.simulate(tc.Scene([body], duration=1e-3, contact=None), scheme=scheme).history
    energy, hourglass = history["energy"], history["hourglass"]
    assert hourglass[-1] > 0.1 * energy[0]
    assert history["elastic"][-1] == pytest.approx(hourglass[-1], rel=1e-9)  # the pattern strains no cell in its middle
    assert energy[0] - energy[-1] == pytest.approx(share * hourglass[-1], rel=1e-7, abs=1e-9 * energy[0])


@pytest.mark.parametrize(
    ("scheme", "formulation", "kept"),
    [(tc.Dissipative(dt=1e-4), "reduced", False), (tc.Dissipative(dt=1e-4), "full", True),
     (tc.DiscreteGradient(dt=1e-4), "reduced", True)],
)  # fmt: skip
def test_what_a_scheme_is_said_to_conserve_it_conserves(scheme, formulation, kept):
    """A body that spins and deforms: hourglass forces beyond the middle of a step have a moment."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (3, 3, 3))
    waves = 20.0 * np.sin(60.0 * (mesh.nodes[:, [1, 2, 0]] + mesh.nodes[:, [0, 0, 1]]))
    velocity = 40.0 * np.cross((0.0, 1.0, 2.0), mesh.nodes) + waves
    body = tc.Body(mesh, tc.NeoHookean(2e7, 0.3, 1000.0), velocity=velocity, formulation=formulation)
    scene = tc.Scene([body], duration=3e-3, contact=None)
    assert ("angular momentum" in tc.plan(scene).describe(scheme)) == kept
    momentum = tc.simulate(scene, scheme=scheme).history["angular_momentum"]
    lost = np.abs(momentum - momentum[0]).max() / np.linalg.norm(momentum[0])
    assert lost < 1e-9 if kept else lost > 1e-5
