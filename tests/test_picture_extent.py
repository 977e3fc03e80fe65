"""Pictures hold what they show: bodies that stretch or fly apart whole, and of a body blown up what is left of it."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

import tcontact as tc
from tcontact.results.files.vtkhdf import ResultData, ResultFile
from tcontact.show import render
from tcontact.show.notebook import EndState
from tcontact.show.render.extent import extent, most_sizes
from tcontact.show.render.studio import Studio

SIZE = (320, 240)
MESH = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2))


def stored(path, moves, reason, count=1):
    """A file of `count` unit cubes side by side; each entry of `moves` maps their nodes to displacements of a frame."""
    points = np.concatenate([MESH.nodes + np.array([1.5 * number, 0.0, 0.0]) for number in range(count)])
    blocks = [("hex8", MESH.cells + number * MESH.node_count) for number in range(count)]
    body = {"body": np.repeat(np.arange(count), MESH.cell_count)}
    with ResultFile.create(path, points, blocks, {"obstacles": []}, body) as file:
        for time, move in enumerate(moves):
            file.append(float(time), {"displacement": move(points)}, {"von_mises": np.ones(len(body["body"]))})
        file.write_attributes({} if reason is None else {"reason": reason})
    return ResultData.open(path)


def rest(points):
    """No displacement."""
    return np.zeros_like(points)


def stretched(points):
    """The first axis eight times as long."""
    return points * [7.0, 0.0, 0.0]


def apart(points):
    """The second cube ten metres away from the first."""
    return np.where(points[:, :1] > 1.2, [[10.0, 0.0, 0.0]], 0.0)


def burst(points):
    """One corner at 1e9 m."""
    moved = np.zeros_like(points)
    moved[0] = 1e9
    return moved


def places(data, index, frames=None):
    """Where on the picture the nodes of a frame are, columns and rows."""
    studio = Studio(data, SIZE, 1.0, None)
    eye = studio.camera("above", frames=frames)
    return eye.project(studio.positions(data.frame(index)))[:, :2]


def inside(spots):
    """Tell of each place whether it lies on the picture, beside the colour bar."""
    return (spots > [0, 20]).all(axis=1) & (spots < [0.9 * SIZE[0], SIZE[1]]).all(axis=1)


@pytest.mark.parametrize(("move", "count"), [(stretched, 1), (apart, 2)])
@pytest.mark.parametrize("alone", [False, True])
def test_a_run_that_ended_well_is_seen_whole_in_every_frame(move, count, alone, tmp_path):
    """One camera holds all frames, however far the bodies have stretched or parted."""
    data = stored(tmp_path / "r.vtkhdf", [move] if alone else [rest, move], "finished", count)
    for index in range(len(data)):
        assert inside(places(data, index)).all()


@pytest.mark.parametrize("reason", [None, "diverged"])
def test_of_a_body_blown_up_the_distance_to_others_does_not_count(reason, tmp_path):
    data = stored(tmp_path / "r.vtkhdf", [rest, apart, burst], reason, 2)
    for index in range(2):
        assert inside(places(data, index)).all()
    assert np.ptp(places(data, 0), axis=0).max() > 25.0


def test_the_start_is_where_the_first_frame_shows_it(tmp_path):
    """A body that starts stretched has not blown up."""
    data = stored(tmp_path / "r.vtkhdf", [stretched, lambda points: 1.5 * stretched(points), burst], "diverged")
    for index in range(2):
        assert inside(places(data, index)).all()


@pytest.mark.parametrize("jump", [1e9, np.nan])
def test_where_all_frames_are_blown_up_the_camera_looks_at_what_is_left(jump, tmp_path):
    """The body has moved 50 m away, and one of its corners has gone to nowhere."""

    def gone(points):
        moved = np.full_like(points, 50.0)
        moved[0] = jump
        return moved

    data = stored(tmp_path / "r.vtkhdf", [rest, gone], "diverged")
    spots = places(data, 1, frames=[data.frame(1)])
    assert inside(spots[1:]).all()
    assert np.ptp(spots[1:], axis=0).max() > 100.0


def test_nothing_finite_leaves_no_points():
    bodies = [np.arange(len(MESH.nodes))]
    most = most_sizes(MESH.nodes, bodies, "finished", 1.0)
    assert most == [np.inf]
    assert extent([np.full_like(MESH.nodes, np.nan)], bodies, most).shape == (0, 3)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_the_end_of_a_run_in_memory_shows_cubes_that_have_parted(tmp_path):
    """The series of one frame that is drawn knows why the run ended."""
    law, mesh = tc.NeoHookean(1e6, 0.45, 1000.0), tc.box_mesh((0.1, 0.1, 0.1), (1, 1, 1))
    left = tc.Body(mesh.translated((-0.101, 0.0, 0.0)), law, velocity=(-50.0, 0.0, 0.0))
    right = tc.Body(mesh, law, velocity=(50.0, 0.0, 0.0))
    result = tc.simulate(tc.Scene([left, right], duration=0.01))
    result.render(tmp_path / "end.png", size=SIZE)
    image = np.asarray(Image.open(tmp_path / "end.png").convert("RGB")).astype(int)[40:200, :250]
    drawn = (np.ptp(image, axis=2) > 60).any(axis=0)
    assert drawn[:60].any()
    assert drawn[190:].any()
    assert EndState(replace(result, reason="diverged")).attributes["reason"] == "diverged"


def test_a_film_of_a_body_that_stretches_has_it_whole_at_the_end(tmp_path):
    """Both ends of the strip are seen in the last picture of the series."""
    data = stored(tmp_path / "r.vtkhdf", [rest, stretched], "finished")
    written = render.render_frames(data, tmp_path / "out", "von_mises", size=SIZE, video=False)
    image = np.asarray(Image.open(written[1]).convert("RGB")).astype(int)[40:190, :284]
    columns = np.flatnonzero((np.ptp(image, axis=2) > 60).any(axis=0))
    assert columns[-1] - columns[0] > 150
    assert columns[-1] < 281
