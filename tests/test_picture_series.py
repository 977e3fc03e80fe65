"""A series of pictures drawn in one go shows what pictures drawn one by one from the file show."""

import numpy as np
import pytest
from PIL import Image, ImageSequence

import tcontact as tc
from tcontact.device import runtime
from tcontact.results.files.vtkhdf import ResultData, ResultFile
from tcontact.results.files.vtkhdf_reader import FrameReader
from tcontact.show.render import render_frames, series, shots
from tcontact.show.render import studio as studio_module
from tcontact.show.render.animation import animate, changed
from tcontact.show.render.png import write_png
from tcontact.show.render.studio import Studio
from tcontact.show.render.triangles import drawable, fronts, union, window

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
    read, frame = [], FrameReader.read
    monkeypatch.setattr(FrameReader, "read", lambda self, index: (read.append(index), frame(self, index))[1])
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
    points, corners = turned.reshape(-1, 3), np.arange(12).reshape(4, 3)
    assert fronts(points, corners).tolist() == [0, 3, 1, 2]
    assert fronts(points, corners, cull=True).tolist() == [0, 3]
    points[9] = np.nan
    assert fronts(points, corners).tolist() == [0, 1, 2, 3], "what cannot be placed stands behind"


def test_a_place_that_holds_two_forgets_empty_ones():
    one, other = (slice(2, 5), slice(7, 9)), (slice(1, 3), slice(8, 12))
    assert union(one, other) == (slice(1, 5), slice(7, 12))
    for empty in ((slice(0, 0), slice(0, 0)), (slice(0, 9), slice(4, 4))):
        assert union(one, empty) == union(empty, one) == one


def test_frames_of_an_animation_replace_the_box_that_changed(tmp_path):
    """Each frame shows its picture in the colours of the palette, also where it equals the one before."""
    rng = np.random.default_rng(1)
    palette = Image.new("P", (1, 1))
    colours = 85 * np.stack(np.unravel_index(np.arange(64), (4, 4, 4)), axis=1)
    palette.putpalette(np.tile(colours, (4, 1)).ravel().tolist())
    first = colours[rng.integers(0, 64, (30, 41))].astype(np.uint8)
    second = first.copy()
    second[7:9, 5:30] = 255 - second[7:9, 5:30]
    pictures = [first, second, second, first]
    assert changed(first[..., 0], second[..., 0]) == (7, 9, 5, 30)
    animate(iter(pictures), palette, tmp_path / "a.gif", 10.0)
    with Image.open(tmp_path / "a.gif") as gif:
        assert gif.n_frames == 4
        assert gif.info["loop"] == 0
        for index, picture in enumerate(pictures):
            gif.seek(index)
            assert gif.info["duration"] == 100
            np.testing.assert_array_equal(np.asarray(gif.convert("RGB")), picture)


def test_labels_of_a_series_are_written_once(tmp_path, monkeypatch):
    """Title and colour bar stay where no body stands; what changes is written into every picture."""
    data = written(tmp_path / "result.vtkhdf", [FLOOR])
    count: list[str] = []
    for name in ("decorate", "write_figures"):
        plain = getattr(studio_module, name)
        monkeypatch.setattr(studio_module, name, lambda *a, plain=plain, name=name: (count.append(name), plain(*a)))
    render_frames(data, tmp_path, "von_mises", (640, 480), animation=False)
    assert count.count("write_figures") == len(data)
    assert count.count("decorate") <= 2
