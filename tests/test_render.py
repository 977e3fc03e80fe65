"""Pictures: each pixel covered once, by what is nearer; colours, surface, files and errors as promised."""

import itertools
from pathlib import Path

import numpy as np
import pytest
from oracle.meshes import HEX_TO_TETS
from PIL import Image

import tcontact as tc
from tcontact.base.errors import InputError
from tcontact.commands.cli import main
from tcontact.mesh.elements import ELEMENTS
from tcontact.results.files.vtkhdf import ResultData, ResultFile
from tcontact.show import render
from tcontact.show.render.animation import can_film
from tcontact.show.render.labels import _places_of, _power_of, _scale_of, round_up, ticks
from tcontact.show.render.studio import Studio
from tcontact.show.render.surface import Clip, boundary_surface, clipped_surface

PLANE = {"kind": "plane", "point": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]}


def _box(n, origin=(0.0, 0.0, 0.0)):
    points = np.stack(np.meshgrid(*[np.linspace(0, 1, n + 1)] * 3, indexing="ij"), -1).reshape(-1, 3) + origin
    ids = np.arange((n + 1) ** 3).reshape((n + 1,) * 3)
    a, b = slice(None, -1), slice(1, None)
    corners = [
        ids[a, a, a],
        ids[b, a, a],
        ids[b, b, a],
        ids[a, b, a],
        ids[a, a, b],
        ids[b, a, b],
        ids[b, b, b],
        ids[a, b, b],
    ]
    return points, np.stack(corners, -1).reshape(-1, 8)


@pytest.fixture(scope="module")
def result(tmp_path_factory) -> ResultData:
    """A cube that comes down on a plane and is pressed most in frame 3 of 5."""
    points, cells = _box(4)
    path = tmp_path_factory.mktemp("result") / "result.vtkhdf"
    with ResultFile.create(path, points, [("hex8", cells)], {"title": "a cube", "obstacles": [PLANE]}) as file:
        for index, (drop, press) in enumerate([(0.3, 0.0), (0.1, 0.0), (0.0, 0.5), (0.0, 1.0), (0.1, 0.0)]):
            down = np.zeros_like(points)
            down[:, 2] = drop - 0.2 * press * points[:, 2]
            pressure = np.where(points[:, 2] == 0, 2e6 * press, 0.0)
            nodal = {
                "displacement": down,
                "contact_pressure": pressure,
                "contact_force": pressure[:, None] * [0, 0, 0.04],
            }
            file.append(1e-3 * index, nodal, {"von_mises": np.arange(len(cells)) * press})
    return ResultData.open(path)


def test_limits_are_round_and_hold_the_series(result):
    studio = Studio(result, (320, 240), 1.0, None)
    assert studio.limits("contact_pressure") == (0.0, 2e6)
    low, high = studio.limits("von_mises")
    assert low == 0.0
    assert 0.95 * 63 <= high <= 80
    assert round_up(0.0) == 1.0
    for value in (1e-9, 0.99, 1.0, 1.01, 7.3e6):
        assert value * (1 - 1e-9) <= round_up(value) <= 1.34 * value


def test_the_surface_is_what_one_cell_alone_has():
    n = 3
    _, cells = _box(n)
    surface = boundary_surface([("hex8", cells)])
    assert len(surface.quads) == 6 * n * n
    assert len(surface.triangles) == 0
    assert len(surface.nodes) == (n + 1) ** 3 - (n - 1) ** 3
    tets = cells[:, HEX_TO_TETS].reshape(-1, 4)
    surface = boundary_surface([("tet4", tets)])
    assert len(surface.triangles) == 12 * n * n
    assert len(surface.quads) == 0
    assert (
        np.bincount(np.sort(surface.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)) @ [10000, 1]).max() == 2
    )  # closed
    two = boundary_surface([("hex8", cells), ("tet4", tets + (n + 1) ** 3)])
    assert len(two.quads) == 6 * n * n
    assert len(two.triangles) == 12 * n * n
    assert two.owner[: len(two.quads)].max() < len(cells) <= two.owner[len(two.quads) :].min()


@pytest.mark.parametrize("kind", ["hex8", "wedge6"])
def test_faces_cut_in_two_have_the_edges_and_the_area_of_those_around_their_centres(kind):
    mesh = tc.box_mesh((1.0, 2.0, 3.0), (2, 3, 2), kind=kind)
    surface = boundary_surface(mesh.blocks)
    points = surface.spread(mesh.nodes[surface.nodes])
    found = []
    for corners, face, edges in ((surface.corners, surface.face, surface.edges), surface.halved):
        lines = []
        for bit, (one, other) in enumerate(((1, 2), (2, 0), (0, 1))):  # the edge opposite a corner
            drawn = (edges >> bit & 1).astype(bool)
            lines.append(np.column_stack([face[drawn], np.sort(corners[drawn][:, [one, other]], axis=1)]))
        first, second, third = points[corners].transpose(1, 0, 2)
        area = np.zeros((len(surface.owner), 3))
        np.add.at(area, face, 0.5 * np.cross(second - first, third - first))
        every = np.concatenate(lines)
        found.append((every[np.lexsort(every.T)], area))
    np.testing.assert_array_equal(found[1][0], found[0][0])
    np.testing.assert_allclose(found[1][1], found[0][1], atol=1e-15)
    assert len(found[0][0]) == 4 * len(surface.quads) + 3 * len(surface.triangles)


def test_faces_look_outward():
    points, cells = _box(1)
    for kind, mesh in (("hex8", cells), ("tet4", cells[:, HEX_TO_TETS].reshape(-1, 4))):
        for cell in mesh:
            for face in ELEMENTS[kind].faces:
                a, b, c = points[cell[list(face[:3])]]
                assert np.cross(b - a, c - b) @ (a - points[cell].mean(axis=0)) > 0


@pytest.mark.parametrize("view", ["above", "below"])
@pytest.mark.parametrize("normal", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (1, 2, -3)])
def test_the_body_is_in_the_picture_at_all_times(result, view, normal):
    plane = {"kind": "plane", "point": [0, 0, 0], "normal": normal}
    studio = Studio(result, (480, 360), 1.0, [plane])
    eye = studio.camera(view)
    for index in range(len(result)):
        x, y, inverse = eye.project(studio.positions(result.frame(index))).T
        assert (inverse > 0).all()
        assert x.min() >= 0
        assert x.max() <= 480 * 0.9
        assert y.min() >= 30
        assert y.max() <= 360
    normal = np.array(normal) / np.linalg.norm(normal)
    assert (normal @ eye.axes[2] > 0) == (view == "above")
    assert normal @ eye.axes[1] > 0


def test_a_series_gives_pictures_animation_and_contact_face(result, tmp_path):
    stale = tmp_path / "pictures/frames/frame-0007.png"
    stale.parent.mkdir(parents=True)
    stale.write_bytes(b"of an earlier, longer series")
    written = render.render_frames(result.path, tmp_path / "pictures", size=(320, 240))
    assert not stale.exists()
    names = [str(path.relative_to(tmp_path / "pictures")) for path in written]
    assert names == [
        *(str(Path("frames") / f"frame-{i:04d}.png") for i in range(5)),
        "animation.gif",
        *(["animation.mp4"] if can_film() else []),
        "contact-face.png",
    ]
    images = [np.asarray(Image.open(path)) for path in written[:5]]
    assert all(image.shape == (240, 320, 3) for image in images)
    assert all((a != b).any() for a, b in itertools.pairwise(images))
    with Image.open(tmp_path / "pictures/animation.gif") as animation:
        assert animation.n_frames == 5
        assert animation.size == (320, 240)
    assert _palettes(tmp_path / "pictures/animation.gif") == (1, 0)


def test_the_contact_face_shows_the_pressure(result, tmp_path):
    """Seen from below at the largest force, the whole face carries the same 2 MPa: the last colour of the table."""
    (path,) = Studio(result, (320, 240), 1.0, None).contact_face(tmp_path / "face.png")
    image = np.asarray(Image.open(path)).astype(int)
    red = (image[..., 0] > 80) & (image[..., 1] < 40) & (image[..., 2] < 60)
    assert red[:, :260].mean() > 0.1
    above = np.asarray(Studio(result, (320, 240), 1.0, None).picture(
        result.frame(0), "contact_pressure", (0.0, 2e6), Studio(result, (320, 240), 1.0, None).camera("above")
    )).astype(int)  # fmt: skip
    assert not ((above[..., 0] > 80) & (above[..., 1] < 40) & (above[..., 2] < 60))[:, :260].any()


def test_the_faces_beside_the_contact_carry_no_pressure(result):
    """The lowest nodes are pressed, and belong to the sides too; seen from above, only the sides are there to see."""
    studio = Studio(result, (320, 240), 1.0, None)
    image = np.asarray(studio.picture(result.frame(3), "contact_pressure", (0.0, 2e6), studio.camera("above")))
    colour = np.ptp(image[40:200, :250].astype(int), axis=2)  # without labels
    yellow = (image[40:200, :250, 0] > 200) & (image[40:200, :250, 2] < 150) & (colour > 60)
    assert not yellow.any()


@pytest.mark.parametrize("rotated", [[0, 1, 2], [2, 0, 1], [1, 2, 0]])
def test_a_thin_plate_is_not_seen_edge_on(rotated, tmp_path):
    points, cells = _box(6)
    points = (points * [1.0, 0.8, 0.03])[:, rotated]
    path = tmp_path / "plate.vtkhdf"
    with ResultFile.create(path, points, [("hex8", cells)], {"obstacles": [PLANE]}) as file:
        file.append(0.0, {"displacement": 0 * points}, {"von_mises": np.zeros(len(cells))})
    back = Studio(ResultData.open(path), (320, 240), 1.0, None).camera("above").axes[2]
    assert abs(back[rotated.index(2)]) >= 0.55


def test_the_scale_bar_is_as_long_as_it_says(result):
    """Its ends are found in the picture: the cube of 1 m is as much wider than the bar as its length in metres says."""
    from tcontact.show.render.camera import Camera
    from tcontact.show.render.colours import FAINT_TEXT

    studio = Studio(result, (960, 720), 1.0, [])
    eye = studio.camera("above", Camera((1.0, 0.0, 0.0)))
    image = np.asarray(studio.picture(result.frame(2), "von_mises", (0.0, 60.0), eye))
    row = (image[684] == FAINT_TEXT).all(axis=1)[110:400]
    bar = row.sum() - 1
    middle = np.array([[0.5, 0.0, 0.5], [0.5, 1.0, 0.5]])  # of the cube, at half its depth
    metre = abs(np.diff(eye.project(middle)[:, 0])[0])
    assert bar / metre == pytest.approx(0.2, abs=0.01)


def test_pictures_are_the_same_every_time(result):
    pictures = []
    for _ in range(2):
        studio = Studio(result, (320, 240), 1.0, None)
        pictures.append(np.asarray(studio.picture(result.frame(3), "von_mises", (0.0, 60.0), studio.camera("above"))))
    np.testing.assert_array_equal(*pictures)


def test_deformation_is_magnified_about_the_mean_motion(result):
    frame = result.frame(3)
    one, three = (Studio(result, (320, 240), scale, None).positions(frame) for scale in (1.0, 3.0))
    start = result.points[Studio(result, (320, 240), 1.0, None).surface.nodes]
    np.testing.assert_allclose(three.mean(axis=0), one.mean(axis=0), atol=1e-12)
    np.testing.assert_allclose(np.ptp(three - start, axis=0), 3 * np.ptp(one - start, axis=0), atol=1e-12)


@pytest.mark.parametrize("reason", [None, "finished", "inverted-cell"])
def test_a_cell_that_inverted_is_drawn_from_both_sides(tmp_path, reason):
    """All faces of a body that is turned inside out look away from the eye."""
    points, cells = _box(2)
    with ResultFile.create(tmp_path / "r.vtkhdf", points, [("hex8", cells)]) as file:
        file.append(0.0, {"displacement": points[:, [1, 0, 2]] - points}, {"von_mises": np.ones(8)})
        file.write_attributes({} if reason is None else {"reason": reason})
    studio = Studio(ResultData.open(tmp_path / "r.vtkhdf"), (200, 160), 1.0, None)
    drawn, draw_into = [], studio._draw
    studio._draw = lambda scene, *rest: (drawn.append(len(scene.screen)), draw_into(scene, *rest))
    studio.picture(studio.data.frame(0), "von_mises", (0.0, 2.0), studio.camera("above"))
    looking, everything = drawn[-1], 6 * 4 * 4
    assert (looking == everything) == (reason == "inverted-cell")


def test_a_broken_last_frame_is_still_drawn(tmp_path):
    points, cells = _box(2)
    with ResultFile.create(tmp_path / "r.vtkhdf", points, [("hex8", cells)]) as file:
        for index, jump in enumerate([0.0, 1e9, np.nan]):
            moved = np.zeros_like(points)
            moved[5] = jump
            file.append(index, {"displacement": moved}, {"von_mises": np.full(8, jump)})
    written = render.render_frames(tmp_path / "r.vtkhdf", tmp_path, "von_mises", size=(200, 160), video=False)
    assert len(written) == 4


def test_wrong_wishes_are_refused_before_anything_is_written(result, tmp_path):
    out = tmp_path / "pictures"
    wrong = [
        ({"field": "temperature"}, "von_mises"),
        ({"field": "temperature", "range": (0.0, 1.0)}, "von_mises"),
        ({"size": (10, 10)}, "size"),
        ({"size": (640.5, 480)}, "size"),
        ({"fps": 0}, "fps"),
        ({"range": (1.0, 1.0)}, "range"),
        ({"range": (0.0, np.nan)}, "range"),
        ({"view": "left"}, "view"),
        ({"deformation_scale": np.inf}, "deformation_scale"),
        ({"obstacles": [{"kind": "torus"}]}, "torus"),
        ({"obstacles": [{"kind": "plane", "point": [0, 0, 0], "normal": [0, 0, 0]}]}, "normal"),
        ({"colours": "no-such-map"}, "coolwarm"),
        ({"clip": ["x>0"]}, "Clip"),
        ({"clip": [render.Clip((-1, 0, 0), (1, 0, 0))]}, "nothing is left"),
    ]
    for wish, word in wrong:
        with pytest.raises(InputError, match=word):
            render.render_frames(result, out, **wish)
    for up in ((0, 0, 2), (0, 0, 1)):
        with pytest.raises(InputError, match="parallel"):
            render.Camera((0, 0, 1), up)
    points, cells = _box(1)
    ResultFile.create(tmp_path / "none.vtkhdf", points, [("hex8", cells)]).close()
    with pytest.raises(InputError, match="no frames"):
        render.render_frames(tmp_path / "none.vtkhdf", out)
    assert not out.exists()


def test_a_clip_leaves_whole_cells_and_what_is_not_beyond_all_planes():
    n = 4
    points, cells = _box(n)
    half = clipped_surface(points, [("hex8", cells)], [Clip((0.5, 0, 0), (1, 0, 0))])
    assert len(half.quads) == 2 * n * n + 4 * n * n // 2
    assert points[half.nodes][:, 0].max() == 0.5
    assert (points[cells[half.owner]].mean(axis=1)[:, 0] < 0.5).all()
    quarter = clipped_surface(points, [("hex8", cells)], [Clip((0.5, 0, 0), (1, 0, 0)), Clip((0, 0.5, 0), (0, 2, 0))])
    assert len(quarter.quads) == 6 * n * n - 2 * (n // 2) ** 2, "as many faces inside as outside, less on two sides"
    for point, normal in (((0, 0, np.nan), (1, 0, 0)), ((0, 0, 0), (0, 0, 0)), ((0, 0), (1, 0, 0))):
        with pytest.raises(InputError, match="Clip"):
            Clip(point, normal)


def test_a_cut_face_shows_the_values_inside(result, tmp_path):
    """Cells of the last layer alone are coloured: only a cut through the middle of it shows them from there."""
    points, cells = _box(4)
    inside = (np.abs(points[cells].mean(axis=1) - 0.5) < 0.3).all(axis=1)
    with ResultFile.create(tmp_path / "r.vtkhdf", points, [("hex8", cells)]) as file:
        file.append(0.0, {"displacement": np.zeros_like(points)}, {"heat": inside.astype(float)})
    found = []
    for clip in ((), (Clip((0, 0.5, 0), (0, -1, 0)),)):
        path = render.render_picture(
            tmp_path / "r.vtkhdf",
            tmp_path / f"{len(clip)}.png",
            field="heat",
            size=(320, 240),
            colours="gray",
            camera=render.Camera((0.1, -1.0, 0.1)),
            clip=clip,
        )
        image = np.asarray(Image.open(path)).astype(int)[60:220, 60:200]
        found.append((image > 190).all(axis=2).mean())
    assert found[0] < 0.05 < 0.1 < found[1]


def test_pictures_of_frames_without_stress_and_pressure_need_no_field(tmp_path, capsys):
    """What `simulate(fields=...)` left out is asked for by no default."""
    body = tc.Body(tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2)), tc.LinearElastic(1e6, 0.3, 1000.0), (0.0, 0.0, 1.0))
    result = tc.simulate(tc.Scene([body], duration=1e-3), out=tmp_path / "run", frames=2, fields=["velocity"])
    assert result.render().shape == tc.open_result(tmp_path / "run").render().shape == (720, 960, 3)
    assert main(["render", str(tmp_path / "run"), "--time", "0", "--out", str(tmp_path)]) == 0
    assert main(["render", str(tmp_path / "run"), "--out", str(tmp_path / "film")]) == 0
    (picture,) = tmp_path.glob("picture-*-0s.png")
    assert picture.name in ("picture-displacement-0s.png", "picture-velocity-0s.png")
    assert (tmp_path / "film" / "animation.gif").exists()
    assert main(["render", str(tmp_path / "run"), "--field", "von_mises"]) == 2
    assert "velocity" in capsys.readouterr().err


def test_one_picture_is_the_nearest_frame_with_the_colours_of_the_series(result, tmp_path):
    render.render_frames(result, tmp_path, size=(320, 240), animation=False)
    path = render.render_picture(result, tmp_path / "deep" / "one.png", time=2.2e-3, size=(320, 240))
    np.testing.assert_array_equal(Image.open(path), Image.open(tmp_path / "frames" / "frame-0002.png"))
    last = render.render_picture(result, tmp_path / "last.png", size=(320, 240))
    np.testing.assert_array_equal(Image.open(last), Image.open(tmp_path / "frames" / "frame-0004.png"))
    with pytest.raises(InputError, match="time"):
        render.render_picture(result, tmp_path / "none.png", time=np.nan)


def test_a_time_outside_of_the_frames_is_refused(result, tmp_path, capsys):
    """Frames are 1 ms apart and end at 4 ms: a run that has ended a little early still has its last frame."""
    late, end = (
        render.render_picture(result, tmp_path / f"{time}.png", time, size=(320, 240)) for time in (4.4e-3, None)
    )
    np.testing.assert_array_equal(Image.open(late), Image.open(end))
    for time in (5.0, 4.6e-3, -0.6e-3):
        with pytest.raises(InputError, match=r"time.* the frames are from 0 to 0\.004 s"):
            render.render_picture(result, tmp_path / "none.png", time)
    assert main(["render", str(result.path), "--time", "5", "--out", str(tmp_path / "none")]) == 2
    assert "the frames are from 0 to 0.004 s" in capsys.readouterr().err
    assert not (tmp_path / "none").exists()
    assert not (tmp_path / "none.png").exists()


@pytest.mark.parametrize("offset", [0.0, 1e-9])
def test_of_two_bodies_that_touch_each_keeps_its_side(offset, tmp_path):
    """Two cubes face to face: along the seam no colour of the one lies on the side of the other."""
    points, cells = _box(3)
    both = np.concatenate([points, points + np.array([1.0 + offset, 0.0, 0.0])])
    blocks = [("hex8", cells), ("hex8", cells + len(points))]
    body = {"body": np.repeat([0, 1], len(cells))}
    with ResultFile.create(tmp_path / "r.vtkhdf", both, blocks, static_cell_data=body) as file:
        file.append(0.0, {"displacement": np.zeros_like(both)}, {})
    data = ResultData.open(tmp_path / "r.vtkhdf")
    studio = Studio(data, (480, 360), 1.0, None, colours="gray")
    eye = studio.camera("above", render.Camera((0.3, -1.0, 0.2)))
    image = np.asarray(studio.picture(data.frame(0), "body", (0.0, 1.0), eye)).astype(int).sum(axis=2)
    a, b = (eye.project(np.array([[1.0, 0.0, z]]))[0, :2] for z in (0.05, 0.95))
    for share in np.linspace(0.05, 0.95, 30):
        x, y = a + share * (b - a)
        row, column = int(y), int(x)
        assert (image[row, column - 12 : column - 2] < 30).all()
        assert (image[row, column + 3 : column + 12] > 150).all()


def test_colours_of_a_temperature_start_at_what_is_there(tmp_path):
    points, cells = _box(1)
    with ResultFile.create(tmp_path / "r.vtkhdf", points, [("hex8", cells)]) as file:
        for index in range(3):
            heat = np.where(points[:, 2] == 0, 293.0 + 400.0 * index, 0.0)
            file.append(index, {"layer_temperature": heat, "layer_shear": heat})
    studio = Studio(ResultData.open(tmp_path / "r.vtkhdf"), (320, 240), 1.0, None)
    assert studio.limits("layer_temperature") == (290.0, 1290.0)
    assert studio.limits("layer_shear") == (0.0, 1200.0)


def _palettes(path):
    """Colour tables in a GIF: (global, local)."""
    data = path.read_bytes()
    assert data[:6] == b"GIF89a"
    shared, local, at = data[10] >> 7, 0, 13
    at += 3 * 2 ** ((data[10] & 7) + 1) if shared else 0
    while data[at] != 0x3B:
        if data[at] == 0x21:
            at += 2
        else:
            flags = data[at + 9]
            local += flags >> 7
            at += 11 + (3 * 2 ** ((flags & 7) + 1) if flags >> 7 else 0)
        while data[at]:
            at += 1 + data[at]
        at += 1
    return shared, local


@pytest.mark.parametrize(
    "limits", [(0.0, 2.5e-5), (0.0, 5e-5), (300.0, 300.002), (0.0, 3.0), (-4e4, 7.7e5), (0.0, 250.0)]
)
def test_marks_of_the_colour_bar_say_where_they_are(limits):
    marks = ticks(*limits)
    places = _places_of(marks)
    assert [float(f"{mark:.{places}f}") for mark in marks] == pytest.approx(
        list(marks), abs=0.01 * (marks[1] - marks[0])
    )
    assert places == 0 or len({f"{mark:.{places - 1}f}" for mark in marks}) < len(marks) or limits[1] - limits[0] < 4.0


def test_small_numbers_without_a_unit_have_a_power_of_ten():
    assert _power_of(2.5e-5) == (pytest.approx(1e-6), "1e\N{MINUS SIGN}6")
    assert _power_of(0.02) == _power_of(0.0) == (1.0, "")


@pytest.mark.parametrize("largest", [5e-16, 8e-31, 1e-12, 5e-7, 2e5, 3e-305])
def test_marks_of_the_colour_bar_are_short_however_small_the_values_are(largest):
    """Also those of a field of rounding noise, far below the smallest prefix."""
    factor, prefix = _scale_of((0.0, largest), "Pa")
    marks = ticks(0.0, largest / factor)
    assert len({f"{mark:.{_places_of(marks)}f}" for mark in marks}) == len(marks)
    assert _places_of(marks) <= 6
    if largest == 5e-16:
        assert (factor, prefix) == (pytest.approx(1e-18), "1e\N{MINUS SIGN}18 ")
