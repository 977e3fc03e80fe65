"""HHT-alpha: v1 - v0 mixes the forces of two steps, and so does the impulse of the history, from the first step on."""

import numpy as np
import pytest

import tcontact as tc

RUBBER = tc.NeoHookean(young=7e5, poisson=0.42, density=950.0)
GRAVITY = np.array([1.0, 2.0, -30.0])
ALPHAS = [0.0, -1.0 / 3.0]


def block(**options):
    mesh = tc.box_mesh(size=(0.08, 0.05, 0.06), cells=(3, 2, 2), origin=(0.0, 0.0, 2e-4))
    return tc.Body(mesh, RUBBER, **options)


def unexplained(result):
    """Change of momentum without an impulse, over the largest momentum."""
    h = result.history
    weight = RUBBER.density * 0.08 * 0.05 * 0.06 * np.outer(h["time"] - h["time"][0], GRAVITY)
    change = h["momentum"] - h["momentum"][0] - h["impulse"] - h["support_impulse"] - weight
    return np.abs(change).max() / np.linalg.norm(h["momentum"], axis=1).max()


@pytest.mark.parametrize("alpha", ALPHAS)
@pytest.mark.parametrize("removal", ["normal", "full"])
@pytest.mark.parametrize("reproject", [True, False])
def test_a_run_that_starts_pressed_on_a_wall_knows_the_force_it_starts_with(alpha, removal, reproject):
    body = block(velocity=(0.0, 0.4, -0.6), contact="zmin")
    scene = tc.Scene(
        bodies=[body], obstacles=[tc.Plane()], duration=2e-3, gravity=GRAVITY, contact=tc.MasslessContact(removal)
    )
    scheme = tc.HilberHughesTaylor(dt=1e-4, alpha=alpha, reproject=reproject)
    first = tc.simulate(scene, scheme=scheme)
    assert first.history["contact_force"][-1, 2] > 10.0
    second = tc.simulate(scene, scheme=scheme, initial=first)
    assert unexplained(first) < 1e-10
    assert unexplained(second) < 1e-10


@pytest.mark.parametrize("mass", ["lumped", "consistent"])
@pytest.mark.parametrize("alpha", ALPHAS)
def test_supports_carry_the_weight_from_the_start(alpha, mass):
    supports = [tc.Support("xmin", "xyz"), tc.Support("xmax", "y", velocity=0.7)]
    body = block(velocity=(0.0, 0.7, 0.0), supports=supports)
    scene = tc.Scene(bodies=[body], obstacles=[], duration=3e-3, gravity=GRAVITY)
    assert unexplained(tc.simulate(scene, scheme=tc.HilberHughesTaylor(dt=1e-4, alpha=alpha, mass=mass))) < 1e-10


def test_halved_steps_keep_the_impulse(monkeypatch):
    from tcontact.schemes.implicit.solution import body as stepped

    tried = []
    take = stepped.ImplicitBody.take
    monkeypatch.setattr(stepped.ImplicitBody, "take", lambda self, level, dt: tried.append(dt) or take(self, level, dt))
    body = block(velocity=(0.0, 0.4, -3.0), contact="zmin")
    contact = tc.PenaltyContact(5e9)
    scene = tc.Scene(bodies=[body], obstacles=[tc.Plane()], duration=6e-3, gravity=GRAVITY, contact=contact)
    result = tc.simulate(scene, scheme=tc.HilberHughesTaylor(dt=1e-3, iterations=2))
    assert result.ok, result.message
    assert min(tried) < 0.6e-3
    assert unexplained(result) < 1e-9
