"""Two bodies that meet in mid-run stop it with their names and the time; bodies that pass each other do not."""

import dataclasses

import numpy as np
import pytest
from oracle import meshes
from scenes import material

import tcontact as tc

SOFT = material("linear")
GAP, SPEED = 0.01, 10.0


def box(size, cells=1, low=(0.0, 0.0, 0.0), kind="hex8", turn=None, **options):
    """A box from `low` on, turned about the origin."""
    count = (cells,) * 3 if isinstance(cells, int) else cells
    mesh = tc.box_mesh(np.broadcast_to(size, 3).tolist(), count, kind, low)
    return tc.Body(mesh if turn is None else mesh.rotated(turn), SOFT, **options)


def run(bodies, duration, scheme="central-difference", **options):
    """A run of bodies without contact with anything else."""
    return tc.simulate(tc.Scene(bodies, duration=duration, contact=None, **options), scheme)


def meets(result, time, names=("a", "b")):
    """It stopped as bodies-meet at the time, with both names, and kept everything before."""
    assert result.reason == "bodies-meet", result.message
    assert not result.ok
    for name in (*names, "pairs=None"):
        assert name in result.message
    assert result.history["time"][-1] == result.time
    assert len(result.history["time"]) == result.steps + 1
    said = float(result.message.split("t = ")[1].split(" s")[0])
    assert time <= said * (1.0 + 1e-9) + 1e-12
    assert said <= time + 0.01 * result.dt + 1e-5 * time
    assert result.time <= said + 1e-12
    return True


def thrown(kind="hex8", cells=4, factor=1.0, turn=None, **options):
    """A resting cube and another thrown at it from above, which meet at GAP/SPEED."""
    turn = np.eye(3) if turn is None else turn
    size = 0.1 * factor
    rest = box(size, 4, turn=turn, name="a")
    fall = box(
        size, cells, (0.3 * size, 0.2 * size, size + GAP * factor), kind, turn, velocity=-SPEED * turn[:, 2], name="b"
    )
    return run([rest, fall], 3.0 * GAP * factor / SPEED, **options)


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_a_thrown_cube_meets_a_resting_one(kind):
    assert meets(thrown(kind, 3, turn=meshes.rotation(4)), GAP / SPEED)
    assert meets(thrown(kind, 3, factor=1e-4), 1e-4 * GAP / SPEED)


def test_pairs_none_lets_bodies_pass_with_a_warning():
    with pytest.warns(tc.OverlapWarning, match="pass through each other"):
        result = thrown(pairs=None)
    assert result.ok
    assert result.position[result.nodes_of("b")][:, 2].min() < 0.1


def test_frames_and_history_up_to_the_meeting_are_kept(tmp_path):
    from tcontact.results.files.vtkhdf import ResultData

    rest, fall = box(0.1, 2, name="a"), box(0.1, 2, (0, 0, 0.11), velocity=(0, 0, -SPEED), name="b")
    scene = tc.Scene([rest, fall], duration=3e-3, contact=None)
    result = tc.simulate(scene, out=tmp_path / "out", frames=30)
    assert meets(result, GAP / SPEED)
    stored = ResultData.open(tmp_path / "out" / "result.vtkhdf")
    assert len(stored) > 3
    assert stored.times[-1] <= result.time
    assert stored.attributes["reason"] == "bodies-meet"


@pytest.mark.parametrize("dt", [1e-5, 7e-4])
def test_implicit_steps_longer_than_a_body_do_not_jump_over_it(dt):
    """A plate of 1 mm, thrown at 100 m/s: 70 mm in a step of 0.7 ms."""
    plate = box((0.1, 0.1, 1e-3), (2, 2, 1), (0, 0, 0.02), velocity=(0, 0, -100.0), name="b")
    result = run([box((0.1, 0.1, 1e-3), (2, 2, 1), name="a"), plate], 1.4e-3, tc.Trapezoidal(dt=dt))
    assert result.reason == "bodies-meet"
    said = float(result.message.split("t = ")[1].split(" s")[0])
    assert said == pytest.approx(0.019 / 100.0, abs=1e-5)


def test_crossed_bars_meet_though_no_node_of_one_comes_into_the_other():
    along, across = (1.0, 0.1, 0.1), (0.1, 1.0, 0.1)
    for low in ((0.45, -0.5, 0.2), (0.45, -0.499, 0.2)):
        bars = [box(along, name="a"), box(across, 1, low, velocity=(0, 0, -20.0), name="b")]
        assert meets(run(bars, 0.02), 0.1 / 20.0)


def test_two_corners_that_graze_meet_and_that_pass_do_not():
    for beside, met in ((0.0999, True), (0.1001, False)):
        bodies = [box(0.1, 1, name="a"), box(0.1, 1, (beside, 0.05, 0.12), velocity=(0, 0, -40.0), name="b")]
        result = run(bodies, 0.008)
        assert meets(result, 0.02 / 40.0) if met else result.ok


def angle_profile(**options):
    """Two boxes at a right angle as one L-shaped mesh."""
    parts = [tc.box_mesh((0.3, 0.1, 0.1), (3, 1, 1)), tc.box_mesh((0.1, 0.1, 0.2), (1, 1, 2), "hex8", (0, 0, 0.1))]
    nodes = np.concatenate([part.nodes for part in parts])
    unique, inverse = np.unique(np.round(nodes, 9), axis=0, return_inverse=True)
    inverse = inverse.reshape(-1)
    cells = np.concatenate([parts[0].cells, parts[1].cells + parts[0].node_count])
    return tc.Body(tc.Mesh(unique, inverse[cells], "hex8"), SOFT, **options)


@pytest.mark.filterwarnings("ignore::tcontact.OverlapWarning")
def test_bodies_whose_boxes_overlap_go_on_until_they_meet():
    """A cube in the angle of an L: at rest, moving along both legs, and into one of them."""
    corner = (0.15, 0.0, 0.15)
    assert run([angle_profile(name="a"), box(0.05, 1, corner, name="b")], 2e-3).ok
    assert run([angle_profile(name="a"), box(0.05, 1, corner, velocity=(5.0, 0, 5.0), name="b")], 0.02).ok
    result = run([angle_profile(name="a"), box(0.05, 1, corner, velocity=(-5.0, 0, 0), name="b")], 0.02)
    assert meets(result, 0.05 / 5.0)


def shell(inner, outer, count):
    """A closed cubic shell of hexes: a box without its middle."""
    mesh = tc.box_mesh((outer,) * 3, (count,) * 3, "hex8", (-outer / 2,) * 3)
    centre = mesh.nodes[mesh.cells].mean(axis=1)
    cells = mesh.cells[(np.abs(centre) > inner / 2).any(axis=1)]
    used = np.unique(cells)
    return tc.Mesh(mesh.nodes[used], np.searchsorted(used, cells), "hex8")


@pytest.mark.filterwarnings("ignore::tcontact.OverlapWarning")
def test_a_body_in_the_hollow_of_another_is_free_until_it_meets_the_wall():
    hollow = tc.Body(shell(0.6, 1.0, 5), SOFT, name="a")
    low = (-0.1, -0.1, -0.1)
    assert run([hollow, box(0.2, 1, low, name="b")], 5e-3).ok
    assert meets(run([hollow, box(0.2, 1, low, velocity=(0, 50.0, 0), name="b")], 0.02), 0.2 / 50.0)


@pytest.mark.filterwarnings("ignore::tcontact.OverlapWarning")
@pytest.mark.parametrize("low", [(0.0, 0.0, 0.1), (0.02, 0.03, 0.05), (0.0, 0.0, 0.0), (0.03, 0.03, 0.03)])
def test_bodies_that_touch_or_overlap_at_the_start_stop_there(low):
    """Stacked, pushed in, in the same place, and one within the other."""
    size = 0.04 if low[0] == 0.03 else 0.1
    result = run([box(0.1, 1, name="a"), box(size, 1, low, name="b")], 1e-3)
    assert result.reason == "bodies-meet"
    assert "at the start" in result.message
    assert result.steps == 0


def test_bodies_that_fly_together_or_apart_go_on():
    together = [box(0.1, 1, velocity=(300.0, 0, 0)), box(0.1, 1, (0, 0, 0.1001), velocity=(300.0, 0, 0))]
    assert run(together, 5e-3).ok
    apart = [box(0.1, 1), box(0.1, 1, (0, 0, 0.1001), velocity=(0, 0, 300.0))]
    assert run(apart, 5e-3).ok


def test_a_periodic_body_is_met_at_each_of_its_repetitions():
    """A slab that has moved on by several periods, and a cube above it that falls on one of its images."""
    slab = tc.Body(tc.box_mesh((0.2, 0.2, 0.1), (2, 2, 2)), SOFT, periodic="xy", velocity=(400.0, 0, 0), name="a")
    cube = box(0.05, 1, (0.7, 0.5, 0.15), velocity=(0, 0, -20.0), name="b")
    assert meets(run([slab, cube], 6e-3), 0.05 / 20.0)


def test_the_third_of_three_bodies_is_named():
    bodies = [box(0.1, 1, (k, 0, 0), name=f"body {k}") for k in range(2)]
    bodies.append(box(0.1, 1, (0.02, 0.2, 0.03), velocity=(0, -20.0, 0), name="thrown"))
    assert meets(run(bodies, 0.01), 0.1 / 20.0, ("body 0", "thrown"))


@pytest.mark.parametrize("pairs", ["none", "all", True, [("a", "b")], 0])
def test_other_pairs_are_refused(pairs):
    with pytest.raises(tc.InputError, match=r"Scene\.pairs"):
        tc.Scene([box(0.1)], duration=1.0, contact=None, pairs=pairs)


def test_one_body_takes_no_looks():
    from tcontact.run.watches.body_meeting import BodyMeeting

    class Alone:
        scene = tc.Scene([box(0.1)], duration=1.0, contact=None)

    assert BodyMeeting.of(Alone()) is None


@pytest.mark.filterwarnings("ignore::tcontact.OverlapWarning")
def test_scene_files_carry_pairs(tmp_path):
    scene = tc.Scene([box(0.1), box(0.1, 1, (0, 0, 0.3))], duration=1.0, contact=None)
    for one, text in ((scene, ""), (dataclasses.replace(scene, pairs=None), 'pairs = "none"')):
        tc.save_scene(one, tmp_path / "scene.toml")
        assert text in (tmp_path / "scene.toml").read_text()
        assert tc.load_scene(tmp_path / "scene.toml")[0].pairs == one.pairs
    (tmp_path / "scene.toml").write_text(
        (tmp_path / "scene.toml").read_text().replace('pairs = "none"', 'pairs = "all"')
    )
    with pytest.raises(tc.InputError, match="pairs"):
        tc.load_scene(tmp_path / "scene.toml")


def test_a_resumed_run_stops_at_the_same_meeting(monkeypatch, tmp_path):
    from stopped_runs import copied, same

    rest, fall = box(0.1, 2, name="a"), box(0.1, 2, (0, 0, 0.11), velocity=(0, 0, -SPEED), name="b")
    scene = tc.Scene([rest, fall], duration=3e-3, contact=None)
    scheme = tc.CentralDifference(dt=5e-6)
    whole, copies = copied(monkeypatch, tmp_path, scene, scheme, 6)
    assert meets(whole, GAP / SPEED)
    with pytest.warns(tc.OverlapWarning), pytest.raises(tc.InputError, match="pairs"):
        tc.resume(copies[min(copies)], dataclasses.replace(scene, pairs=None), scheme)
    assert len(copies) >= 3, copies.keys()
    for folder in copies.values():
        same(whole, tc.resume(folder, scene, scheme, checkpoint=1e9))


def slabs(speed, gap=GAP, aside=0.0, duration=3.0):
    """A slab that comes down on another one; neither has sides, since both repeat along x and y."""
    low = box((0.2, 0.2, 0.1), 2, name="a", periodic="xy")
    high = box((0.2, 0.2, 0.1), 2, (0.0, 0.0, 0.1 + gap), periodic="xy", velocity=(aside, 0.0, -speed), name="b")
    return run([low, high], duration * gap / max(speed, 0.1))


@pytest.mark.parametrize("speed", [0.5, SPEED, 200.0])
@pytest.mark.parametrize("aside", [0.0, 150.0])
def test_periodic_slabs_meet_though_no_sides_of_theirs_cross(speed, aside):
    """One passes wholly through the other between two places at which the surfaces are apart."""
    assert meets(slabs(speed, aside=aside), GAP / speed)


def test_periodic_slabs_slide_along_each_other():
    assert slabs(0.0, gap=1e-4, aside=20.0, duration=40.0).ok


def held_on_feet(low=0.0, **options):
    """A cube on held feet whose contact side has two of the held nodes."""
    options.setdefault("contact", "xmax" if low == 0.0 else "xmin")
    return box(1.0, 3, (low, 0, 0), supports=[tc.Support("zmin", "xyz")], **options)


def test_two_bodies_with_held_contact_nodes_are_told_to_leave_these_out():
    """Neither can be the slave: plan and stop say so, and none is offered the other one."""
    bodies = [held_on_feet(name="a", velocity=(50.0, 0, 0)), held_on_feet(1.0 + GAP, name="b")]
    scene, remedy = tc.Scene(bodies, duration=0.1), "leave the held nodes out of Body.contact"
    assert not scene.body_pairs
    for text in (tc.plan(scene).describe(), tc.simulate(scene).message):
        assert "supports hold contact nodes of both a and b" in text
        assert remedy in text
        assert "both names in Scene.pairs" not in text
    for slave in (None, "a", "b"):
        with pytest.raises(tc.InputError, match=remedy) as refused:
            tc.Scene(bodies, duration=0.1, pairs=[tc.Pair("a", "b", slave=slave)])
        assert "other body" not in str(refused.value)
    free = [held_on_feet(name="a"), box(1.0, 3, (1.0 + GAP, 0, 0), contact="xmin", name="b")]
    assert "no pair" not in tc.plan(tc.Scene(free, duration=0.1)).describe()
    with pytest.raises(tc.InputError, match="make the other body the slave"):
        tc.Scene(free, duration=0.1, pairs=[tc.Pair("a", "b", slave="a")])
