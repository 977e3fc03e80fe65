"""Bodies at rest that something sets going meet at the right time, for any duration; idle ones cost few looks."""

import dataclasses

import numpy as np
import pytest

import tcontact as tc
from tcontact.run.watches.body_meeting import RARELY, BodyMeeting

MATERIAL = tc.LinearElastic(young=1e7, poisson=0.0, density=1000.0)
GAP = 0.01


def cube(x=0.0, cells=3, **options):
    """A cube of edge 1 m from x on, with the node set "every"."""
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (cells,) * 3, origin=(x, 0.0, 0.0))
    return tc.Body(mesh.with_sets(node_sets={"every": np.arange(mesh.node_count)}), MATERIAL, **options)


def first_overlap(bodies, obstacles=(), duration=0.1, **options):
    """Return times [s] between which the right side of body 0 first is beyond the left side of body 1 in a free run."""
    with pytest.warns(tc.OverlapWarning):
        scene = tc.Scene(bodies, obstacles, duration, pairs=None, **options)
    probes = tc.simulate(scene).history
    right, left = (probes[name][:, 0] for name in ("probe_b_xmax_displacement", "probe_c_xmin_displacement"))
    gaps = bodies[1].mesh.nodes[:, 0].min() - bodies[0].mesh.nodes[:, 0].max() + left - right
    row = int(np.argmax(gaps < 0.0))
    assert row > 1
    times = probes["time"][row - 1 : row + 1]
    return float(times[0]), float(times[1])


def said(result):
    """Return the time in the message."""
    assert result.reason == "bodies-meet", result.message
    return float(result.message.split("meet at t = ")[1].split(" s")[0])


def probed(force=None, contact=None):
    """Two cubes at rest beside each other with probes on the sides that meet; force: on every node of the first one."""
    loads = () if force is None else [tc.Load("every", force=force)]
    first = cube(name="b", loads=loads, contact=contact, probes=[tc.Probe("xmax", "displacement")])
    return [first, cube(1.0 + GAP, name="c", probes=[tc.Probe("xmin", "displacement")])]


def pulse(t):
    """A force that begins late, pushes a cube by 35 mm and pulls it back again."""
    size = 4e5
    begin, part = 0.02, 0.01
    sign = np.select(
        [t < begin, t < begin + part, t < begin + 3 * part, t < begin + 4 * part], [0.0, 1.0, -1.0, 1.0], 0.0
    )
    return float(sign) * size, 0.0, 0.0


@pytest.mark.parametrize("duration", [0.05, 0.075, 0.2])
def test_a_load_that_begins_late_pushes_a_resting_body_into_another(duration):
    before, after = first_overlap(probed(pulse), contact=None)
    result = tc.simulate(tc.Scene(probed(pulse), duration=duration, contact=None))
    assert before - 0.5 * result.dt <= said(result) <= after
    assert result.time <= said(result)


def test_an_own_force_that_begins_late_is_no_surprise():
    def own(x, v, t):
        return np.full(x.shape, np.array(pulse(t)) / len(x))

    before, after = first_overlap(probed(own), contact=None)
    result = tc.simulate(tc.Scene(probed(own), duration=0.1, contact=None))
    assert before - 0.5 * result.dt <= said(result) <= after


def starts(t):
    """A velocity that begins late."""
    return 10.0 if t > 0.03 else 0.0


@pytest.mark.parametrize("duration", [0.1, 0.3])
@pytest.mark.parametrize("velocity", [(10.0, 0.0, 0.0), lambda t: (starts(t), 0.0, 0.0)], ids=["constant", "function"])
def test_a_moving_plane_strikes_a_resting_body_into_another(duration, velocity):
    plane = tc.Plane((-0.05, 0.0, 0.0), (1.0, 0.0, 0.0), velocity=velocity)
    before, after = first_overlap(probed(contact="xmin"), [plane])
    result = tc.simulate(tc.Scene(probed(contact="xmin"), [plane], duration))
    assert before - 0.5 * result.dt <= said(result) <= after
    assert result.time <= said(result)


def test_a_driven_support_starts_late():
    drive = [tc.Support("xmin", "x", velocity=starts)]
    body = cube(name="b", supports=drive, probes=[tc.Probe("xmax", "displacement")])
    bodies = [body, probed()[1]]
    before, after = first_overlap(bodies, contact=None)
    result = tc.simulate(tc.Scene(bodies, duration=0.1, contact=None))
    assert before - 0.5 * result.dt <= said(result) <= after


def test_a_body_that_another_one_strikes_flies_into_a_third():
    """Contact joins the first two; the third has no contact faces."""
    first = cube(-1.0 - 5.0 * GAP, name="a", velocity=(10.0, 0.0, 0.0), contact="xmax")
    second = cube(name="b", contact="xmin", probes=[tc.Probe("xmax", "displacement")])
    third = cube(1.0 + GAP, name="c", probes=[tc.Probe("xmin", "displacement")])
    for duration in (0.05, 0.2):
        result = tc.simulate(tc.Scene([first, second, third], duration=duration))
        wave = 5.0 * GAP / 10.0 + 1.0 / MATERIAL.wave_speed  # comes through the second one, which moves at 10 m/s then
        assert said(result) == pytest.approx(wave + GAP / 10.0, abs=2.0 * result.dt)


def looks_of(monkeypatch, bodies, **options):
    """Return the looks and the rows of a run."""
    looks, look = [], BodyMeeting.look
    monkeypatch.setattr(BodyMeeting, "look", lambda self, *given: looks.append(1) or look(self, *given))
    result = tc.simulate(tc.Scene(bodies, contact=None, **options))
    assert result.ok, result.message
    return len(looks), result.steps


def test_bodies_that_nothing_can_set_going_take_few_looks(monkeypatch):
    """Beside each other at rest, flying together, and far apart with loads that vary."""
    bodies = probed()
    looks, rows = looks_of(monkeypatch, bodies, duration=1.0)
    assert looks <= rows / RARELY + 10
    together = [cube(velocity=(300.0, 0.0, 0.0)), cube(1.0 + GAP, velocity=(300.0, 0.0, 0.0))]
    looks, rows = looks_of(monkeypatch, together, duration=1.0)
    assert looks <= rows / RARELY + 10
    apart = [probed(lambda t: (1e3 * np.sin(100.0 * t), 0.0, 0.0))[0], cube(50.0)]
    looks, rows = looks_of(monkeypatch, apart, duration=1.0)
    assert looks <= rows / RARELY + 10


def thrown(size, begin=0.02, part=0.01):
    """A force along x that begins late, throws a body on and brings it back."""

    def force(t):
        steps = [t < begin, t < begin + part, t < begin + 3 * part, t < begin + 4 * part]
        return float(np.select(steps, [0.0, size, -size, size], 0.0)), 0.0, 0.0

    return force


@pytest.mark.parametrize("duration", [0.1, 0.4])
def test_a_body_at_rest_that_is_thrown_through_a_thin_wall_and_back_is_seen(duration):
    """A penalty far too soft lets it through a wall of 40 mm, which it enters at about 0.022 s."""
    body = cube(contact="xmax", loads=[tc.Load("every", force=thrown(2e6))])
    wall = tc.Box((1.05, 0.5, 0.5), (0.04, 3.0, 3.0))
    result = tc.simulate(tc.Scene([body], [wall], duration, contact=tc.PenaltyContact(1e5)))
    assert result.reason == "missed-contact", result.message
    assert "passed through box" in result.message
    assert 0.02 < result.time < 0.03


@pytest.mark.parametrize("duration", [0.08, 0.2])
@pytest.mark.parametrize("size", [1.6e6, 3e6])
def test_a_pair_at_rest_that_meets_with_other_faces_for_a_moment_is_told_of(size, duration):
    """It overlaps by 0.4 and 0.9 of an edge, from about 0.028 s to 0.05 s."""
    force = thrown(-size)
    pushed = cube(0.3, 4, name="c", contact="xmin", loads=[tc.Load("every", force=lambda t: (0.0, 0.0, force(t)[0]))])
    pushed = dataclasses.replace(pushed, mesh=pushed.mesh.translated((0.0, 0.0, 1.02)))
    scene = tc.Scene([cube(0.0, 4, name="b", contact="xmax"), pushed], duration=duration, pairs=[tc.Pair("b", "c")])
    with pytest.warns(RuntimeWarning, match="where no contact holds it") as told:
        tc.simulate(scene)
    text = next(str(one.message) for one in told if "where no" in str(one.message))
    assert 0.02 < float(text.split("at t = ")[1].split(" s")[0]) < 0.05
