"""A run that starts from another one's end keeps the removal of its contact nodes, or says what jumps."""

import pickle
import warnings
from dataclasses import replace

import numpy as np
import pytest
from conftest import THREADS

import tcontact as tc
from tcontact.run.handover import handover
from tcontact.run.initial_faces import scene_of_start
from tcontact.run.initial_state import start_from

MESH = tc.box_mesh((0.1, 0.08, 0.06), (3, 3, 2), origin=(0.0, 0.0, 0.0012))
RUBBER = tc.LinearElastic(1e6, 0.35, 1000.0)
KEPT = ("momentum", "kinetic", "elastic")
EXPLICIT, IMPLICIT = tc.CentralDifference(dt=4e-5), tc.DiscreteGradient(dt=1e-4)


def tumbling(nodes):
    """Velocities of a block that falls and turns about y by 0.05 rad in 0.83 ms."""
    return np.array([0.0, 0.0, -2.0]) + np.cross([0.0, 60.0, 0.0], nodes - MESH.nodes.mean(axis=0))


def scene(duration, velocity=tumbling, removal="auto", obstacles=(), law=RUBBER, **options):
    body = tc.Body(MESH, law, velocity, contact="zmin", name="block")
    return tc.Scene([body], obstacles or [tc.Plane()], duration, contact=tc.MasslessContact(removal), **options)


def removal(known):
    return tc.plan(known).bodies[0].contact.removal


def run(known, scheme=EXPLICIT, initial=None, **options):
    """The result of a run, its warnings without those of rotations."""
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        result = tc.simulate(known, scheme, threads=THREADS, initial=initial, **options)
    assert result.ok, result.message
    return result, [one.category for one in seen if issubclass(one.category, tc.RemovalWarning)]


def goes_on(known, first, implicit=False):
    """The scene of a run from the end of a first one, as that run takes it."""
    return scene_of_start(known, start_from(known, first), first, implicit)[0]


@pytest.mark.parametrize("scheme", [EXPLICIT, IMPLICIT])
@pytest.mark.parametrize(
    ("first", "second", "kind"),
    [((1.2e-3,), (4e-4,), "full"), ((1.2e-3,), (1.2e-3, (0.0, 0.0, 0.0)), "full"), ((6e-4,), (2e-3,), "normal")],
)
def test_momentum_and_energy_go_on_whatever_the_second_scene_names(scheme, first, second, kind):
    """Its duration and its velocity alone would give the other removal."""
    before, _ = run(scene(*first), scheme)
    assert removal(before.scene) == kind != removal(scene(*second))
    after, told = run(scene(*second), scheme, before)
    assert not told
    assert removal(after.scene) == kind
    assert f"({kind} removal" in tc.plan(after.scene).describe()
    for name in KEPT:
        last, row = before.history[name][-1], after.history[name][0]
        assert np.abs(row - last).max() < 1e-7 * np.abs(before.history[name]).max(), name
    turns = [text for text in after.warnings if "starts to turn by" in text]
    assert len(turns) == (kind == "normal")  # what keeps its normals though it spins is named


def test_a_third_run_and_a_result_out_of_a_pickle_know_the_removal():
    first, _ = run(scene(1.2e-3))
    second, _ = run(scene(4e-4), initial=first)
    stored = pickle.loads(pickle.dumps(second))
    assert removal(goes_on(scene(4e-4, (0.0, 0.0, 0.0)), stored)) == "full"
    assert removal(second.scene) == "full"
    fresh, _ = run(second.scene)  # the scene of a result, from its own start
    assert removal(fresh.scene) == "normal"


def test_another_removal_is_named_with_what_jumps(tmp_path):
    first, _ = run(scene(1.2e-3))
    second, told = run(scene(4e-4, removal="normal"), initial=first, out=tmp_path / "run")
    assert told == [tc.RemovalWarning]
    (text,) = (text for text in second.warnings if "removal='normal' instead of 'full'" in text)
    jump = f"{first.history['kinetic'][-1]:.4g} -> {second.history['kinetic'][0]:.4g} J"
    assert "block has" in text
    assert jump in text
    assert "name the same MasslessContact(removal=)" in text
    assert second.history["kinetic"][0] > 1.05 * first.history["kinetic"][-1]
    assert text in tc.open_result(tmp_path / "run").warnings


def test_what_calls_for_another_removal_changes_it():
    """Walls that turn or lie across each other, not one out of reach of the motion at the end of the first run."""
    first, _ = run(scene(6e-4))
    turning = tc.Plane(angular_velocity=(0.0, 1.0, 0.0))
    across = [tc.Plane(), tc.Plane(point=(0.13, 0.0, 0.0), normal=(-1.0, 0.0, 0.0))]
    for obstacles, wanted in (([turning], "full"), (across, "full"), ([tc.Plane()], "normal")):
        later = goes_on(scene(6e-4, obstacles=obstacles), first)
        assert removal(later) == wanted
        assert (handover(later, first) is not None) == (wanted == "full")
    far = [tc.Plane(), tc.Plane(point=(2.0, 0.0, 0.0), normal=(-1.0, 0.0, 0.0))]
    fast = scene(6e-4, (500.0, 0.0, 0.0), obstacles=far)
    assert removal(fast) == "full"
    assert removal(goes_on(fast, first)) == "normal"


def test_other_directions_of_normal_removal_are_named():
    tilted = tc.Plane(normal=(0.1, 0.0, 1.0), point=(0.0, 0.0, -0.1))
    first, _ = run(scene(6e-4))
    known = handover(goes_on(scene(6e-4, obstacles=[tilted]), first), first)
    assert known.changes == ["block has removal='normal' along other directions"]


def test_a_body_without_massless_contact_before_is_taken_by_its_motion():
    """It spins at the end of the first run, whatever the second scene names."""
    free = tc.Scene([tc.Body(MESH, RUBBER, tumbling)], duration=1e-4)
    first, _ = run(free)
    still = scene(1.2e-3, (0.0, 0.0, 0.0))
    assert removal(still) == "normal"
    later = goes_on(still, first)
    assert removal(later) == "full"
    assert handover(later, first) is None


def end_of(known):
    """A result of that scene in the state of its start."""
    free, _ = run(tc.Scene([tc.Body(MESH, RUBBER)], duration=1e-9))
    starts = [(body.initial_nodes, body.initial_velocity) for body in known.bodies]
    position, velocity = (np.concatenate(values) for values in zip(*starts, strict=True))
    return replace(free, scene=known, position=position, velocity=velocity)


def test_bodies_that_touch_keep_their_removal_together():
    """Two blocks of which one spins: one direction would serve both by the velocities that the second scene names."""

    def two(velocity):
        upper = tc.Body(MESH.translated((0.0, 0.0, 0.061)), RUBBER, velocity, contact="zmin", name="upper")
        return tc.Scene([upper, tc.Body(MESH, RUBBER, contact="zmax", name="lower")], duration=2e-3)

    def spinning(nodes):
        return tumbling(nodes - [0.0, 0.0, 0.061])

    still = two((0.0, 0.0, -2.0))
    for first, second, kind in ((two(spinning), still, "full"), (still, two(spinning), "normal")):
        assert removal(first) == kind != removal(second)
        later = goes_on(second, end_of(first))
        assert [body.contact.removal for body in tc.plan(later).bodies] == [kind, kind]
        assert handover(later, end_of(first)) is None


def test_a_metal_keeps_its_normals_when_it_has_become_slow():
    """A fast impact on a ball took normal removal; at the end of the run it would be full."""
    ball = tc.Sphere((0.05, 0.04, -0.5), 0.5)

    def thrown(speed):
        return scene(2e-6, (0.0, 0.0, -speed), obstacles=[ball], law=tc.metal("copper-ofhc"))

    assert (removal(thrown(200.0)), removal(thrown(0.2))) == ("normal", "full")
    slow = replace(end_of(thrown(200.0)), velocity=np.zeros((MESH.node_count, 3)))
    later = goes_on(thrown(200.0), slow)
    assert removal(later) == "normal"
    assert handover(later, slow) is None
    fast = goes_on(thrown(0.2), replace(end_of(thrown(0.2)), velocity=end_of(thrown(200.0)).velocity))
    assert removal(fast) == "normal"  # which has no other, whatever it had
    assert handover(fast, end_of(thrown(0.2))).changes == ["block has removal='normal' instead of 'full'"]


def test_a_run_that_is_resumed_has_the_removal_that_it_had(tmp_path):
    """Its scene alone gives another one: the removal of the run before is in the checkpoint."""
    first, _ = run(scene(1.2e-3))
    options = tc.Checkpoint(every_seconds=None, every_steps=4, keep=True)
    second, _ = run(scene(4e-4), initial=first, out=tmp_path / "run", checkpoint=options)
    again = tc.resume(tmp_path / "run", scene(4e-4), EXPLICIT, threads=THREADS)
    assert removal(again.scene) == removal(second.scene) == "full"
    assert np.array_equal(again.position, second.position)
