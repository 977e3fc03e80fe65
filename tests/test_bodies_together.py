"""Several bodies in one scene take one launch, and each does what it would do alone."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import block

import tcontact as tc
from tcontact.device.launch import Prepared
from tcontact.planning.static_solver import static_solver

STEP = 2e-5


def body(kind="hex8", shift=0.0, law=tc.NeoHookean, poisson=0.3, **options):
    """A soft block above the wall, moved aside."""
    mesh = block(kind, 3, size=(0.1, 0.11, 0.09), shift=(shift, 0.0, 2e-4 + 1e-4 * shift))
    material = law(young=1e6, poisson=poisson, density=1000.0)
    return tc.Body(mesh, material, velocity=options.pop("velocity", (0.0, 0.0, -1.0)), contact="zmin", **options)


PAIRS = {
    "hexes of two sizes of gap": (body(), body(shift=0.3)),
    "hexes and tets": (body(), body("tet4", 0.3)),
    "two laws": (body(), body(shift=0.3, law=tc.LinearElastic)),
    "one that cannot touch": (body(), replace(body(shift=0.3), contact=None)),
}
SLIDING = (body(velocity=(0.8, 0.0, -1.0)), body("tet4", 0.3, velocity=(0.5, 0.2, -1.0)))


FULL = tc.MasslessContact(removal="full")


def scene_of(bodies, duration=6e-3, contact=None, **options):
    return tc.Scene(list(bodies), [tc.Plane()], duration, contact=contact or tc.MasslessContact(), **options)


def solved(scene):
    """Return the result of a scene of two bodies and those of each body alone, all at one step."""
    scheme = tc.CentralDifference(dt=STEP)
    both = tc.simulate(scene, scheme=scheme)
    alone = [tc.simulate(replace(scene, bodies=[one]), scheme=scheme) for one in scene.bodies]
    assert both.ok
    assert all(result.ok for result in alone)
    return both, alone


def compared(scene):
    """Largest differences of both bodies together from each alone: positions over a size, contact force over itself."""
    both, alone = solved(scene)
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
    assert force <= 1e-10  # a sum of two histories, of forces that the static solve leaves unbalanced


def solvers(planned):
    """Return for every body of a plan whether MPRGP solves for its contact nodes."""
    return [static_solver(planned.scene, one).projected for one in planned.bodies]


@pytest.mark.filterwarnings("ignore:body-. has poisson")
def test_two_bodies_that_mprgp_solves_do_what_each_does_alone():
    """Both are nearly incompressible, so that one domain holds them and MPRGP solves both islands."""
    scene = scene_of([body(poisson=0.49), body(shift=0.3, poisson=0.49)], contact=FULL)
    planned = tc.plan(scene)
    assert len(planned.domains) == 1
    assert solvers(planned) == [True, True]
    position, force = compared(scene)
    assert position <= 1e-13
    assert force <= 1e-13


@pytest.mark.filterwarnings("ignore:body-. has poisson")
def test_bodies_of_two_solvers_take_a_domain_each_and_have_the_bits_of_each_alone():
    scene = scene_of([body(), body(shift=0.3, poisson=0.49)], contact=FULL)
    planned = tc.plan(scene)
    assert len(planned.domains) == 2
    assert solvers(planned) == [False, True]
    both, alone = solved(scene)
    for number, one in enumerate(alone):
        rows = both.nodes_of(both.scene.label(number))
        for name in ("position", "velocity", "contact_node_force"):
            assert np.array_equal(getattr(both, name)[rows], getattr(one, name)), name
        assert one.history["contact_force"][:, 2].max() > 0.0
    force = sum(one.history["contact_force"] for one in alone)
    assert np.array_equal(both.history["contact_force"], force)


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
