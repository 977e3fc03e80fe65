"""Scenes in which a part has nothing to do: no obstacle, no node that contact can push, a body beside that flies on."""

import numpy as np
import pytest

import tcontact as tc
from tcontact.results import checks

RUBBER = tc.NeoHookean(young=1e7, poisson=0.3, density=1000.0)
SCHEMES = [tc.CentralDifference(), tc.DiscreteGradient(dt=2e-4), tc.HilberHughesTaylor(dt=2e-4)]
HELD = (tc.Support("zmin", "z"),)


def block(place=0.0, **options):
    mesh = tc.box_mesh(size=(0.1, 0.1, 0.1), cells=(1, 1, 2), origin=(place, 0, 0))
    return tc.Body(mesh, RUBBER, contact="zmin", **options)


SCENES = {
    "contact set held on its wall": ([block(supports=HELD)], [tc.Plane()]),
    "held over two obstacles": ([block(supports=HELD)], [tc.Plane(), tc.Plane(point=(0, 0, -1), name="below")]),
    "no obstacle": ([block(velocity=(0, 0, -1))], []),
    "one held, one lands": ([block(supports=HELD), block(1.0, velocity=(0, 0, -1))], [tc.Plane()]),
}


@pytest.mark.parametrize("scheme", SCHEMES, ids=[scheme.name for scheme in SCHEMES])
@pytest.mark.parametrize("name", SCENES)
def test_momentum_is_what_the_impulses_left(name, scheme):
    bodies, obstacles = SCENES[name]
    contact = tc.MasslessContact(removal="normal")
    scene = tc.Scene(bodies, obstacles, duration=2e-3, gravity=(0, 0, -100.0), contact=contact)
    result = tc.simulate(scene, scheme)
    assert result.reason == "finished"
    assert checks.momentum_balance(result, 1e-9).passed
    wanted = 0.0 if obstacles else np.inf
    assert result.history["gap_min"][-1] == pytest.approx(wanted, abs=1e-12)
