"""Pictures of several bodies: each has a colour of its own and its name, on what is seen of it."""

import numpy as np
import pytest
from PIL import Image

from tcontact.base.errors import InputError
from tcontact.mesh.box import box_mesh
from tcontact.results.files.vtkhdf import ResultData, ResultFile
from tcontact.show import render
from tcontact.show.render.bodies import place_of
from tcontact.show.render.colours import BODY_COLOURS, NOTHING_COLOUR, colour_table
from tcontact.show.render.studio import Studio

SIDE = render.Camera((0.0, -1.0, 0.0))
SIZE = (480, 360)


def stored(path, starts, names=None):
    """A file with a unit cube for each start, and two frames."""
    mesh = box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
    points = np.concatenate([mesh.nodes + np.array(start) for start in starts])
    blocks = [("hex8", mesh.cells + number * mesh.node_count) for number in range(len(starts))]
    attributes = {"obstacles": []} | ({"bodies": names} if names else {})
    body = {"body": np.repeat(np.arange(len(starts)), mesh.cell_count)}
    with ResultFile.create(path, points, blocks, attributes, body) as file:
        for time in (0.0, 1.0):
            file.append(time, {"displacement": np.zeros_like(points)}, {"von_mises": np.zeros(len(body["body"]))})
    return ResultData.open(path)


def hue(colour):
    """A colour without its brightness."""
    return np.asarray(colour, dtype=float) / np.linalg.norm(colour)


def at(studio, eye, image, point):
    """The median colour around a point."""
    column, row = eye.project(np.array([point]))[0, :2].astype(int)
    return np.median(image[row - 6 : row + 6, column - 6 : column + 6].reshape(-1, 3), axis=0)


def test_each_body_has_its_colour_and_the_legend_shows_it(tmp_path):
    """More bodies than hues: all that the palette has are told apart."""
    count = len(BODY_COLOURS)
    data = stored(tmp_path / "r.vtkhdf", [(1.5 * (number % 9), 0.0, 1.5 * (number // 9)) for number in range(count)])
    studio = Studio(data, (960, 720), 1.0, None)
    eye, limits = studio.camera("above", SIDE), studio.limits("body")
    image = np.asarray(studio.picture(data.frame(0), "body", limits, eye)).astype(float)
    faces = np.array([at(studio, eye, image, (1.5 * (k % 9) + 0.25, 0.0, 1.5 * (k // 9) + 0.25)) for k in range(count)])
    away = np.linalg.norm(faces[:, None] - faces[None], axis=2) + 1e3 * np.eye(count)
    assert away.min() > 12.0
    for number, face in enumerate(faces):
        assert hue(face) @ hue(BODY_COLOURS[number]) > 0.999
    shown = {tuple(c) for c in np.round(BODY_COLOURS).astype(int)}
    right = image[:, 800:].reshape(-1, 3).astype(int)
    swatches = {tuple(c) for c, many in zip(*np.unique(right, axis=0, return_counts=True), strict=True) if many > 100}
    assert len(shown & swatches) >= (720 - 180) // 26 - 1  # those with room; the last row counts the rest


def test_colours_of_bodies_may_be_those_of_a_map_and_have_no_range(tmp_path):
    data = stored(tmp_path / "r.vtkhdf", [(0, 0, 0), (1.5, 0, 0), (3.0, 0, 0)])
    studio = Studio(data, SIZE, 1.0, None, colours="viridis")
    eye = studio.camera("above", SIDE)
    image = np.asarray(studio.picture(data.frame(0), "body", studio.limits("body"), eye)).astype(float)
    for number, entry in enumerate((0, 128, 255)):
        colour = at(studio, eye, image, (1.5 * number + 0.25, 0.0, 0.25))
        assert hue(colour) @ hue(colour_table("viridis")[entry]) > 0.999
    with pytest.raises(InputError, match="range"):
        render.render_frames(data, tmp_path / "out", "body", range=(0.0, 2.0))
    assert not (tmp_path / "out").exists()


def test_a_series_of_several_bodies_has_a_picture_of_them_and_keeps_their_colours_in_the_animation(tmp_path):
    data = stored(tmp_path / "r.vtkhdf", [(0, 0, 0), (1.5, 0, 0)], ["left", "right"])
    written = render.render_frames(data, tmp_path / "a", "von_mises", size=SIZE, video=False)
    assert [path.name for path in written[-2:]] == ["animation.gif", "bodies.png"]
    written = render.render_frames(data, tmp_path / "b", "body", size=SIZE, video=False, camera=SIDE)
    assert written[-1].name == "animation.gif"
    studio = Studio(data, SIZE, 1.0, None)
    eye = studio.camera("above", SIDE)
    with Image.open(written[-1]) as film:
        image = np.asarray(film.convert("RGB")).astype(float)
    for number in (0, 1):
        colour = at(studio, eye, image, (1.5 * number + 0.25, 0.0, 0.25))
        assert hue(colour) @ hue(BODY_COLOURS[number]) > 0.998


def test_the_names_are_those_of_the_file_and_stand_on_the_bodies_that_are_seen(tmp_path):
    """The third body hides behind the first one; the picture is that without names but for two of them."""
    starts = [(0, 0, 0), (1.5, 0, 0), (-0.1, 1.5, 0)]
    data = stored(tmp_path / "r.vtkhdf", starts, ["left", "right", "hidden"])
    studio = Studio(data, SIZE, 1.0, None)
    assert studio.names == ["left", "right", "hidden"]
    assert Studio(stored(tmp_path / "old.vtkhdf", starts), SIZE, 1.0, None).names == ["body-0", "body-1", "body-2"]
    eye = studio.camera("above", SIDE)
    named = np.asarray(studio.picture(data.frame(0), "von_mises", (0.0, 1.0), eye)).astype(int)
    studio.names = []
    plain = np.asarray(studio.picture(data.frame(0), "von_mises", (0.0, 1.0), eye)).astype(int)
    rows, columns = np.nonzero((named != plain).any(axis=2))
    for start, centre in (((0, 0, 0), 0.5), ((1.5, 0, 0), 2.0)):
        (left, bottom), (right, top) = eye.project(np.array([start, np.add(start, (1, 0, 1))]))[:, :2]
        here = (columns > left) & (columns < right) & (rows > top) & (rows < bottom)
        assert here.sum() > 50
        assert abs(columns[here].mean() - eye.project(np.array([[centre, 0.0, 0.5]]))[0, 0]) < 0.1 * (right - left)
        rows, columns = rows[~here], columns[~here]
    assert len(rows) == 0


def test_a_name_lies_wholly_on_a_body_as_near_to_the_middle_as_it_can():
    mask = np.zeros((40, 60), bool)
    mask[5:35, 10:50] = True
    assert place_of(mask, 10, 4) == (31.0, 19.0)  # the middle, one fortieth to the right
    mask[10:30, 15:45] = False  # a frame: the name is as wide as its sides are not
    column, row = place_of(mask, 10, 4)
    assert mask[int(row) - 2 : int(row) + 3, int(column) - 5 : int(column) + 6].all()
    assert place_of(mask, 20, 20)[0] > 30  # it fits nowhere: its middle lies on the frame
    assert mask[tuple(int(x) for x in place_of(mask, 20, 20)[::-1])]
    assert place_of(mask[:7, :12], 10, 4) is None  # too little is seen
    assert place_of(np.zeros((4, 4), bool), 1, 1) is None


def test_cells_without_a_value_are_not_drawn_as_zero(tmp_path):
    """Such as the plastic strain of rubber beside a metal."""
    mesh = box_mesh((1.0, 1.0, 1.0), (1, 1, 1))
    points = np.concatenate([mesh.nodes + np.array((start, 0.0, 0.0)) for start in (0.0, 1.5, 3.0)])
    blocks = [("hex8", mesh.cells + number * mesh.node_count) for number in range(3)]
    with ResultFile.create(tmp_path / "r.vtkhdf", points, blocks, {"obstacles": []}) as file:
        file.append(0.0, {"displacement": np.zeros_like(points)}, {"plastic_strain": np.array([0.0, np.nan, 2e-5])})
    data = ResultData.open(tmp_path / "r.vtkhdf")
    studio = Studio(data, SIZE, 1.0, None)
    eye, limits = studio.camera("above", SIDE), studio.limits("plastic_strain")
    image = np.asarray(studio.picture(data.frame(0), "plastic_strain", limits, eye)).astype(float)
    zero, nothing, most = (hue(at(studio, eye, image, (x, 0.0, 0.25))) for x in (0.25, 1.75, 3.25))
    assert np.abs(nothing - hue(NOTHING_COLOUR)).max() < 0.02
    assert min(np.abs(nothing - other).max() for other in (zero, most)) > 0.1


def test_of_one_body_the_field_of_several_is_refused_by_name(tmp_path):
    mesh = box_mesh((1.0, 1.0, 1.0), (1, 1, 1))
    with ResultFile.create(tmp_path / "r.vtkhdf", mesh.nodes, mesh.blocks) as file:
        file.append(0.0, {"displacement": np.zeros_like(mesh.nodes)}, {"von_mises": np.zeros(1)})
    with pytest.raises(InputError, match=r"only a run of several bodies has it; use one of .*'von_mises'"):
        render.render_picture(tmp_path / "r.vtkhdf", tmp_path / "p.png", field="body")
