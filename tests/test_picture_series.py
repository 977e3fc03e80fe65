"""A series of pictures drawn in one go shows what pictures drawn one by one from the file show."""

import numpy as np
import pytest
from PIL import Image, ImageSequence

import tcontact as tc
from tcontact.device import runtime
from tcontact.results.files.vtkhdf import ResultData, ResultFile
from tcontact.show.render import render_frames, series, shots
from tcontact.show.render.png import write_png
from tcontact.show.render.studio import Studio
from tcontact.show.render.triangles import Triangles, drawable, window

FLOOR = {"kind": "plane", "point": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]}
BALL = {"kind": "sphere", "parameters": [0.4, 1.0], "point": [1.6, 0.5, 0.5], "frame": np.eye(3).tolist()}
TIMES = 1e-3 * np.arange(11)
RISING = FLOOR | {
    "motion": {
        "time": TIMES.tolist(),
        "point": [[0.0, 0.0, 20.0 * time] for time in TIMES],
        "frame": [np.eye(3).tolist()] * len(TIMES),
    }
}
SIZE = (320, 240)


def written(path, obstacles, frames=11):
    """A cube that falls, turns and gets out of shape."""
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (4, 4, 4))
    rng = np.random.default_rng(3)
    with ResultFile.create(path, mesh.nodes, mesh.blocks, {"obstacles": obstacles}) as file:
        for index in range(frames):
            moved = 0.02 * rng.normal(size=mesh.nodes.shape) + [0.03 * index, 0.0, 0.5 - 0.05 * index]
            fields = {"displacement": moved, "contact_force": np.zeros_like(moved), "velocity": moved}
            file.append(TIMES[index], fields, {"von_mises": rng.random(mesh.cell_count)})
    return ResultData.open(path)


@pytest.mark.parametrize("obstacles", [[FLOOR], [FLOOR, BALL], [RISING]], ids=["floor", "ball", "moving floor"])
@pytest.mark.parametrize("field", ["von_mises", "velocity"])
def test_pictures_of_a_series_are_those_of_a_fresh_studio(tmp_path, obstacles, field):
    """What is kept from frame to frame, scenery and buffers, leaves no trace."""
    data = written(tmp_path / "result.vtkhdf", obstacles)
    render_frames(data, tmp_path, field, SIZE, video=False)
    for index in (0, 4, 10):
        studio = Studio(data, SIZE, 1.0, None)
        runtime.start()
        alone = studio.picture(data.frame(index), field, studio.limits(field), studio.camera("above"))
        with Image.open(tmp_path / f"frames/frame-{index:04d}.png") as stored:
            np.testing.assert_array_equal(np.asarray(stored), np.asarray(alone))


def test_the_animation_has_the_pictures_in_order(tmp_path):
    data = written(tmp_path / "result.vtkhdf", [FLOOR])
    render_frames(data, tmp_path, "von_mises", SIZE, video=False)
    with Image.open(tmp_path / "animation.gif") as gif:
        shown = [np.asarray(frame.convert("RGB")).astype(int) for frame in ImageSequence.Iterator(gif)]
    drawn = [np.asarray(Image.open(path)).astype(int) for path in sorted((tmp_path / "frames").iterdir())]
    away = np.array([[np.abs(one - other).mean() for other in drawn] for one in shown])
    assert np.array_equal(away.argmin(axis=1), np.arange(len(data)))


def test_every_frame_is_read_once(tmp_path, monkeypatch):
    data = written(tmp_path / "result.vtkhdf", [FLOOR])
    read, frame = [], ResultData.frame
    monkeypatch.setattr(ResultData, "frame", lambda self, index: (read.append(index), frame(self, index))[1])
    render_frames(data, tmp_path, "von_mises", SIZE, video=False)
    assert sorted(read) == list(range(len(data)))


def test_a_picture_that_cannot_be_stored_is_an_error_of_the_series(tmp_path, monkeypatch):
    """The second thread raises in the first one, and no picture after it is taken for written."""
    data = written(tmp_path / "result.vtkhdf", [FLOOR])

    def full(path, image):
        if path.name == "frame-0002.png":
            raise OSError(28, "No space left on device")
        write_png(path, image)

    monkeypatch.setattr(shots, "write_png", full)
    with pytest.raises(tc.InputError, match="No space left on device"):
        series.render_frames(data, tmp_path, "von_mises", SIZE, animation=False)
    assert not (tmp_path / "frames/frame-0010.png").exists()


@pytest.mark.parametrize("size", [(1, 1), (7, 3), (160, 161)])
def test_a_png_holds_every_pixel(tmp_path, size):
    image = np.random.default_rng(0).integers(0, 256, (*size, 3), dtype=np.uint8)
    write_png(tmp_path / "picture.png", image)
    with Image.open(tmp_path / "picture.png") as stored:
        stored.verify()
    with Image.open(tmp_path / "picture.png") as stored:
        assert stored.mode == "RGB"
        np.testing.assert_array_equal(np.asarray(stored), image)


def test_a_window_holds_the_points_and_stays_in_the_picture():
    points = np.array([[10.2, 20.7, 1.0], [30.1, 40.2, 1.0], [np.nan, 5.0, np.nan]])
    assert window([points], [0], 100, 80) == (slice(19, 42), slice(9, 32))
    assert window([points, points[:1] + np.array([0, 50, 0])], [0, 3], 100, 72) == (slice(19, 72), slice(6, 32))
    empty = window([points - np.array([500, 0, 0])], [0], 100, 80)
    assert empty[1].stop - empty[1].start == 0
    assert window([np.empty((0, 3))], [4], 100, 80) == (slice(80, 80), slice(100, 100))


def test_far_and_broken_triangles_are_not_drawn():
    screen = np.random.default_rng(0).random((5, 3, 3))
    assert drawable(screen) == slice(None)
    screen[1, 2, 0], screen[3, 0, 2] = 3e5, np.nan
    assert np.array_equal(drawable(screen), [True, False, True, False, True])


def test_faces_towards_the_eye_come_first_and_in_their_order():
    turned = np.array([[(0.0, 0.0, 1.0), (0.0, 1.0, 1.0), (1.0, 0.0, 1.0)]] * 4)
    turned[[1, 2]] = turned[[1, 2]][:, [0, 2, 1]]
    turned[..., 2] = np.arange(4)[:, None]
    assert Triangles.plain(turned, 0).front_first().screen[:, 0, 2].tolist() == [0.0, 3.0, 1.0, 2.0]
    assert Triangles.plain(turned, 0).front_first(cull=True).screen[:, 0, 2].tolist() == [0.0, 3.0]
