"""Several bodies in one scene take one launch, and each does what it would do alone."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import block

import tcontact as tc
from tcontact.device.launch import Prepared

STEP = 2e-5


def body(kind="hex8", shift=0.0, law=tc.NeoHookean, **options):
    """A soft block above the wall, moved aside."""
    mesh = block(kind, 3, size=(0.1, 0.11, 0.09), shift=(shift, 0.0, 2e-4 + 1e-4 * shift))
    material = law(young=1e6, poisson=0.3, density=1000.0)
    return tc.Body(mesh, material, velocity=options.pop("velocity", (0.0, 0.0, -1.0)), contact="zmin", **options)


PAIRS = {
    "hexes of two sizes of gap": (body(), body(shift=0.3)),
    "hexes and tets": (body(), body("tet4", 0.3)),
    "two laws": (body(), body(shift=0.3, law=tc.LinearElastic)),
    "one that cannot touch": (body(), replace(body(shift=0.3), contact=None)),
}
SLIDING = (body(velocity=(0.8, 0.0, -1.0)), body("tet4", 0.3, velocity=(0.5, 0.2, -1.0)))


def scene_of(bodies, duration=6e-3, contact=None, **options):
    return tc.Scene(list(bodies), [tc.Plane()], duration, contact=contact or tc.MasslessContact(), **options)


def compared(scene):
    """Largest differences of both bodies together from each alone: positions over a size, contact force over itself."""
    scheme = tc.CentralDifference(dt=STEP)
    both = tc.simulate(scene, scheme=scheme)
    alone = [tc.simulate(replace(scene, bodies=[one]), scheme=scheme) for one in scene.bodies]
    assert both.ok
    assert all(result.ok for result in alone)
    position = np.concatenate([result.position for result in alone])
    force = sum(result.history["contact_force"] for result in alone)
    largest = np.abs(force).max()
    assert largest > 0.0
    return np.abs(both.position - position).max() / 0.1, np.abs(both.history["contact_force"] - force).max() / largest


@pytest.mark.parametrize("name", PAIRS)
def test_two_bodies_on_a_wall_do_what_each_does_alone(name):
    scene = scene_of(PAIRS[name])
    assert len(tc.plan(scene).domains) == 1
    position, force = compared(scene)
    assert position <= 1e-13
    assert force <= 1e-13 * 1e3  # a sum of two histories, of forces that the static solve leaves unbalanced


def test_with_friction_and_on_the_path_of_large_bodies_too(parallel_path):
    position, force = compared(scene_of(SLIDING, 4e-3, friction=tc.Coulomb(0.3)))
    assert position <= 1e-13
    assert force <= 1e-10


def test_bodies_of_one_removal_share_a_domain():
    """Bodies that have lost the same components of their mass stay together, with either removal."""
    near = scene_of([body(), body(shift=0.3)])
    kinds = [tc.MasslessContact("normal"), tc.MasslessContact("full")]
    assert [len(tc.plan(replace(near, contact=kind)).domains) for kind in kinds] == [1, 1]


def test_two_bodies_take_one_launch_for_many_steps(monkeypatch):
    """Both are small: the serial driver takes many steps of both in a launch."""
    launches = []
    call = Prepared.__call__
    monkeypatch.setattr(Prepared, "__call__", lambda self, *given: launches.append(1) or call(self, *given))
    scheme = tc.CentralDifference(dt=STEP)
    counts = []
    for bodies in ([body()], [body(), body(shift=0.3)]):
        launches.clear()
        result = tc.simulate(scene_of(bodies), scheme=scheme)
        counts.append(len(launches))
    assert result.steps >= 200
    assert counts[1] <= 1.3 * counts[0]  # the search for the stable step and the looks whether they meet may add some
    assert counts[1] < result.steps / 4
