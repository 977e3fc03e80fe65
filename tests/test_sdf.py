"""Obstacles from sampled distances and from closed surfaces, against brute force over the triangles."""

import re
import struct

import numpy as np
import pytest
import surfaces

import tcontact as tc
from tcontact.scene.obstacles.motion import rotations
from tcontact.scene.obstacles.winding import winding_numbers

TURN = rotations(np.array([[0.4, 0.2, -0.9]]))[0]


def ball(points):
    return np.linalg.norm(points, axis=1) - 0.5


def outward(points):
    return points / np.maximum(np.linalg.norm(points, axis=1), 1e-300)[:, None]


def shell_points(count, low, high, seed=0):
    """Random positions with radii from low to high."""
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(count, 3))
    return x * (rng.uniform(low, high, count) / np.linalg.norm(x, axis=1))[:, None]


# sampled


def test_linear_distances_are_exact_within_the_grid_and_beyond():
    normal = np.array([2.0, 3.0, 6.0]) / 7.0
    wall = tc.Sdf(lambda x: x @ normal - 0.1, origin=(-1, -1, -1), spacing=0.25, nodes=(9, 8, 7))
    x = np.random.default_rng(0).uniform(-4, 4, (500, 3))
    np.testing.assert_allclose(wall.gap(x), x @ normal - 0.1, atol=1e-13)
    np.testing.assert_allclose(wall.normal_at(x), np.tile(normal, (500, 1)), atol=1e-13)


@pytest.mark.parametrize("gradient", [None, outward], ids=["differences", "given"])
def test_error_falls_with_the_square_of_the_spacing(gradient):
    x = shell_points(2000, 0.4, 0.6)
    errors, turns = [], []
    for n in (21, 41):
        sdf = tc.Sdf(ball, gradient, origin=(-1, -1, -1), spacing=2 / (n - 1), nodes=(n, n, n))
        errors.append(np.abs(sdf.gap(x) - ball(x)).max())
        turns.append(np.abs(sdf.normal_at(x) - outward(x)).max())
    assert 3.2 < errors[0] / errors[1] < 4.8
    assert turns[0] / turns[1] > 3.0
    assert errors[1] < 2e-3


def test_arrays_and_callables_are_the_same_obstacle():
    made = tc.Sdf(ball, outward, origin=(-1, -0.9, -0.8), spacing=0.2, nodes=(11, 10, 9))
    given = tc.Sdf(made.grid[..., 0], made.grid[..., 1:], origin=(-1, -0.9, -0.8), spacing=0.2)
    assert (given.grid == made.grid).all()
    assert given.parameters == made.parameters
    assert made.parameters[3:] == (0.2, 11.0, 10.0, 9.0)
    np.testing.assert_allclose(made.reference + made.parameters[:3], made.origin, atol=1e-15)  # node 0
    assert made.grid.shape == (11, 10, 9, 4)


def test_gap_grows_beyond_the_grid_and_never_exceeds_the_distance():
    sdf = tc.Sdf(ball, outward, origin=(-0.7, -0.7, -0.7), spacing=0.05, nodes=(29, 29, 29))
    way = np.array([0.8, 0.5, 0.1])
    gap = sdf.gap(np.outer(np.linspace(0.8, 8.0, 50), way))
    assert (np.diff(gap) > 0.0).all()
    x = shell_points(2000, 1.3, 5.0)
    assert (sdf.gap(x) > 0.0).all()
    assert (sdf.gap(x) < ball(x) + 1e-3).all()
    assert (np.einsum("ni,ni->n", sdf.normal_at(x), x) > 0.0).all()


@pytest.mark.parametrize(
    ("field", "options"),
    [
        ("Sdf.distance", {"distance": np.zeros((3, 9, 9))}),
        ("Sdf.distance", {"distance": np.full((4, 4, 4), np.nan)}),
        ("Sdf.distance", {"distance": lambda x: np.zeros(3), "nodes": (4, 4, 4)}),
        ("Sdf.distance", {"distance": lambda x: 1 / 0, "nodes": (4, 4, 4)}),
        ("Sdf.distance", {"distance": None}),
        ("Sdf.nodes", {"distance": ball}),
        ("Sdf.nodes", {"distance": ball, "nodes": (4, 4, 3)}),
        ("Sdf.nodes", {"distance": np.zeros((4, 4, 4)), "nodes": (4, 4, 5)}),
        ("Sdf.gradient", {"distance": np.zeros((4, 4, 4)), "gradient": np.zeros((4, 4, 4))}),
        ("Sdf.gradient", {"distance": np.zeros((4, 4, 4)), "gradient": ball}),
        ("Sdf.spacing", {"distance": np.zeros((4, 4, 4)), "spacing": 0.0}),
        ("Sdf.origin", {"distance": np.zeros((4, 4, 4)), "origin": (0, 0)}),
        ("Sdf.center", {"distance": np.zeros((4, 4, 4)), "center": 1.0}),
    ],
)
def test_bad_input_names_the_field(field, options):
    with pytest.raises(tc.InputError) as caught:
        tc.Sdf(**{"spacing": 0.1, **options})
    assert caught.value.field == field


# from surfaces


def turned(surface):
    return surface[0] @ TURN.T, surface[1]


BODIES = {
    "box": (surfaces.box(), 24),
    "turned box": (turned(surfaces.box()), 24),
    "torus": (turned(surfaces.torus()), 24),
    "cavity": (surfaces.joined(surfaces.sphere(), (0.4 * surfaces.box()[0], surfaces.box()[1][:, ::-1])), 24),
    "two": (
        surfaces.joined(surfaces.box((0.3, 0.3, 0.3)), (surfaces.sphere(8, 8, 0.2)[0] + 0.5, surfaces.sphere(8, 8)[1])),
        24,
    ),
}


@pytest.mark.parametrize("name", BODIES)
def test_nodes_hold_the_signed_distance(name):
    """Exact at nodes: nearest triangle, and inside where the solid angle is 4 pi."""
    surface, cells = BODIES[name]
    sdf = tc.Sdf.from_surface(surface, cells=cells)
    rng = np.random.default_rng(1)
    ids = np.stack([rng.integers(n, size=500) for n in sdf.nodes], axis=1)
    wanted = surfaces.signed_distance(surface, sdf.origin + sdf.spacing * ids)
    found = sdf.grid[tuple(ids.T)]
    near = np.abs(wanted) < 3 * sdf.spacing
    assert near.sum() > 30
    assert (wanted < 0).sum() > 10
    np.testing.assert_allclose(found[near, 0], wanted[near], atol=1e-12)
    np.testing.assert_allclose(found[:, 0], wanted, atol=0.01 * sdf.spacing)
    np.testing.assert_allclose(np.linalg.norm(found[:, 1:], axis=1), 1.0, atol=1e-12)


def test_gradient_points_from_the_nearest_point():
    sdf = tc.Sdf.from_surface(surfaces.box(), cells=16)
    block = tc.Box(size=(1.0, 0.6, 0.4))
    assert sdf.spacing == 1.0 / 16
    ids = np.stack(np.meshgrid(*(np.arange(n) for n in sdf.nodes), indexing="ij"), axis=-1).reshape(-1, 3)
    x = sdf.origin + sdf.spacing * ids
    outside = block.gap(x) > 1e-9
    np.testing.assert_allclose(sdf.grid.reshape(-1, 4)[outside, 1:], block.normal_at(x)[outside], atol=1e-9)
    # nodes in the faces: the normal of a face that they lie in
    flat = np.abs(block.gap(x)) <= 1e-9
    assert flat.sum() > 100
    half = np.array([0.5, 0.3, 0.2])
    normal = sdf.grid.reshape(-1, 4)[flat, 1:]
    np.testing.assert_allclose(np.abs(normal).max(axis=1), 1.0, atol=1e-12)
    axis = np.abs(normal).argmax(axis=1)
    np.testing.assert_allclose((normal * x[flat])[np.arange(len(axis)), axis], half[axis], atol=1e-12)


def test_winding_numbers_are_those_of_the_solid_angle():
    """Slivers, a grid that lies on faces, edges and corners, and a shell within a shell."""
    star = surfaces.sphere(9, 7)
    star = star[0] * (0.3 + np.random.default_rng(5).random(len(star[0])))[:, None], star[1]
    for surface in (
        surfaces.box((1.0, 0.5, 0.5)),
        star,
        surfaces.joined(surfaces.sphere(), surfaces.box((0.2, 0.2, 0.2))),
    ):
        found = winding_numbers(*surface, np.array([-0.75, -0.5, -0.75]), 0.125, (13, 9, 13))
        for i, j, k in np.random.default_rng(0).integers((13, 9, 13), size=(300, 3)):
            x = np.array([-0.75, -0.5, -0.75]) + 0.125 * np.array([i, j, k])
            if surfaces.distance(*surface, x) > 1e-9:
                assert found[i, j, k] == round(surfaces.winding_number(*surface, x))


def test_ten_thousand_triangles_are_right_within_a_thousandth_of_the_size():
    surface = surfaces.sphere(71, 72)
    assert len(surface[1]) > 10_000
    sdf = tc.Sdf.from_surface(surface, cells=32)
    x = shell_points(150, 0.4, 0.6, seed=4)
    assert np.abs(sdf.gap(x) - surfaces.signed_distance(surface, x)).max() < 1e-3
    assert np.einsum("ni,ni->n", sdf.normal_at(x), outward(x)).min() > 0.998


@pytest.mark.slow
@pytest.mark.parametrize(
    "surface", [surfaces.sphere(71, 72), turned(surfaces.torus(sectors=(90, 56)))], ids=["sphere", "torus"]
)
def test_a_fine_grid_of_ten_thousand_triangles(surface):
    sdf = tc.Sdf.from_surface(surface)
    low, high = sdf.origin, sdf.origin + sdf.spacing * (np.array(sdf.nodes) - 1)
    x = np.random.default_rng(2).uniform(low, high, (600, 3))
    error = np.abs(sdf.gap(x) - surfaces.signed_distance(surface, x))
    # further inside, normals of opposite sides meet: a crease of the distance itself
    assert error[sdf.gap(x) > -0.1].max() < 1e-3


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".ply"])
@pytest.mark.parametrize("binary", [False, True], ids=["text", "binary"])
def test_files_give_the_surface_back(tmp_path, suffix, binary):
    import meshio

    if suffix == ".obj" and binary:
        pytest.skip("OBJ is text")
    points, triangles = surfaces.torus(sectors=(12, 8))
    path = tmp_path / f"ring{suffix}"
    options = {} if suffix == ".obj" else {"binary": binary}
    meshio.write(path, meshio.Mesh(1000.0 * points, [("triangle", triangles)]), **options)
    found = tc.Sdf.from_surface(path, cells=12, scale=1e-3, name="ring", velocity=(0, 0, 1))
    wanted = tc.Sdf.from_surface((points, triangles), cells=12)
    assert found.name == "ring"
    assert found.moves
    assert found.nodes == wanted.nodes
    assert found.surface[1].shape == triangles.shape  # corners of the facets of an STL are joined again
    np.testing.assert_allclose(found.grid[..., 0], wanted.grid[..., 0], atol=1e-6)


def test_quads_by_hand(tmp_path):
    points, _ = surfaces.box()
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    lines = [f"v {x} {y} {z}" for x, y, z in points] + ["f " + " ".join(str(i + 1) for i in quad) for quad in quads]
    path = tmp_path / "box.obj"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    sdf = tc.Sdf.from_surface(str(path), cells=12)
    np.testing.assert_allclose(sdf.gap(np.array([[0.0, 0.0, 0.25], [0.0, 0.0, 0.1]])), [0.05, -0.1], atol=1e-12)


@pytest.mark.parametrize("backwards", [False, True])
def test_a_wavefront_file_with_normals_texture_and_colours_of_its_own(tmp_path, backwards):
    """As programs write them: fewer normals than points, ids with slashes, quads beside triangles, groups."""
    points, triangles = surfaces.box()
    lines = ["# made by hand", "mtllib box.mtl", "o box"]
    lines += [f"v {x} {y} {z} 1.0 0.5 0.25" for x, y, z in points] + ["vn 0 0 1", "vt 0 0", "vt 1 0", "s off"]
    for number, corners in enumerate(triangles):
        ids = corners - len(points) if backwards else corners + 1
        lines += [f"g part{number}", "f " + " ".join(f"{i}//1" if number % 2 else f"{i}/2/1" for i in ids)]
    path = tmp_path / "box.obj"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    wanted = tc.Sdf.from_surface((points, triangles), cells=12).grid
    np.testing.assert_allclose(tc.Sdf.from_surface(path, cells=12).grid, wanted, atol=1e-12)
    path.write_text("\n".join(lines).replace("f 1/", "f one/").replace("f -8/", "f one/"), encoding="utf-8")
    with pytest.raises(tc.InputError, match=r"line .*one/"):
        tc.Sdf.from_surface(path, cells=12)


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("corners", ["vertex_indices", "vertex_index"])
def test_a_ply_file_with_more_in_it_than_points_and_corners(tmp_path, order, corners):
    """Triangles beside quads, numbers and lists beside the corners, edges, and numbers beside the coordinates."""
    points, _ = surfaces.box()
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    faces = quads[:4] + [part for quad in quads[4:] for part in (quad[:3], [quad[0], quad[2], quad[3]])]
    head = ["ply", f"format {order} 1.0", "comment by hand", "element vertex 8"]
    head += [f"property double {axis}" for axis in "xyz"] + ["property ushort flags", f"element face {len(faces)}"]
    head += [f"property list uchar uint {corners}", "property int flags", "property list uchar float texcoord"]
    head += ["element edge 1", "property int vertex1", "property int vertex2", "end_header", ""]
    rows = [("dddH", [*point, 9]) for point in points]
    rows += [(f"B{len(f)}IiB{i % 3}f", [len(f), *f, 3, i % 3] + [0.5] * (i % 3)) for i, f in enumerate(faces)]
    rows += [("ii", [0, 1])]
    if order == "ascii":
        body = "\n".join(" ".join(map(repr, map(float, values))).replace(".0", "") for _, values in rows).encode()
    else:
        body = b"".join(struct.pack(("<" if "little" in order else ">") + kinds, *values) for kinds, values in rows)
    path = tmp_path / "box.ply"
    path.write_bytes("\n".join(head).encode() + body)
    wanted = tc.Sdf.from_surface(surfaces.box(), cells=12).grid
    np.testing.assert_allclose(tc.Sdf.from_surface(path, cells=12).grid[..., 0], wanted[..., 0], atol=1e-12)
    path.write_bytes("\n".join(head).encode() + body[:-80])
    with pytest.raises(tc.InputError, match="ends too early"):
        tc.Sdf.from_surface(path, cells=12)


def test_orientation_and_torn_corners_do_not_matter():
    """Turned inside out, cut into single triangles, corners off by rounding: the same solid."""
    points, triangles = surfaces.torus(sectors=(12, 8))
    wanted = tc.Sdf.from_surface((points, triangles), cells=12).grid
    rng = np.random.default_rng(0)
    loose = points[triangles].reshape(-1, 3)
    loose = loose + 1e-8 * rng.uniform(-1, 1, loose.shape)
    alone = np.arange(len(loose)).reshape(-1, 3)
    flat = np.concatenate([triangles, triangles[:4, [0, 0, 1]]])
    for surface in ((points, triangles[:, ::-1]), (loose, alone), (loose, alone[:, ::-1]), (points, flat)):
        np.testing.assert_allclose(tc.Sdf.from_surface(surface, cells=12).grid[..., 0], wanted[..., 0], atol=1e-6)


def test_margin_and_center():
    sdf = tc.Sdf.from_surface(surfaces.box(), cells=10, margin=0.35, center=(0.5, 0, 0))
    assert (sdf.origin <= -np.array([0.5, 0.3, 0.2]) - 0.35 + 1e-12).all()
    assert (sdf.reference == (0.5, 0, 0)).all()
    assert abs(sdf.gap(np.array([[0.0, 0.0, 0.3]]))[0] - 0.1) < 1e-12


BOX = surfaces.box()
ONE_TURNED = BOX[1].copy()
ONE_TURNED[3] = ONE_TURNED[3, ::-1]


@pytest.mark.parametrize(
    ("surface", "remedy"),
    [
        ((BOX[0], BOX[1][1:]), "close the holes"),
        ((BOX[0], ONE_TURNED), "orient all triangles outward"),
        ((BOX[0], np.concatenate([BOX[1], BOX[1][:1]])), "more than two triangles"),
        ((BOX[0], np.zeros((0, 3), dtype=int)), "no triangles"),
        ((BOX[0], BOX[1] + 1), "ids run from 0 to 7"),
        ((BOX[0], 1.0 * BOX[1]), "whole numbers"),
        ((np.full((8, 3), np.nan), BOX[1]), "finite numbers"),
        (surfaces.joined(BOX, (BOX[0] * 0.3 + (2, 0, 0), BOX[1][:, ::-1])), "turn it around"),
        (surfaces.joined(BOX, (BOX[0] * 0.5, BOX[1])), "cavity"),
        (surfaces.joined(BOX, (BOX[0] * 0.9 + 0.15, BOX[1])), "unite the shells"),
        ("nowhere.stl", "no such file"),
        (3.0, "give the path"),
    ],
)
def test_surfaces_that_bound_no_solid_are_refused(surface, remedy):
    with pytest.raises(tc.InputError, match=remedy):
        tc.Sdf.from_surface(surface, cells=12)


def test_errors_of_surfaces_from_arrays_stand_in_one_line():
    """They count points and triangles instead of printing the arrays over several lines before the reason."""
    with pytest.raises(tc.InputError) as caught:
        tc.Sdf.from_surface((BOX[0], BOX[1][1:]), cells=12)
    assert str(caught.value).startswith("surface = 8 points, 11 triangles: it is open at 3 edges")
    for surface in ((BOX[0], BOX[1] + 1), (BOX[0][:, :2], BOX[1]), [*BOX, BOX[1]]):
        with pytest.raises(tc.InputError) as caught:
            tc.Sdf.from_surface(surface, cells=12)
        assert "\n" not in str(caught.value)


EMPTY_ROWS = "ply\nformat ascii 1.0\nelement vertex 99999999999999\nend_header\n"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("part.stl", "no surface"),
        ("part.ply", ""),
        ("part.step", "solid"),
        pytest.param("part.ply", EMPTY_ROWS, id="rows"),
    ],
)
def test_broken_files_are_refused(tmp_path, name, text):
    (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(tc.InputError, match=name):
        tc.Sdf.from_surface(tmp_path / name)


# too thin for the grid


def hollow(thickness, radius=0.5):
    """A ball with a skin of triangles that do not face each other."""
    inner = surfaces.sphere(13, 20, radius - thickness)
    return surfaces.joined(surfaces.sphere(16, 16, radius), (inner[0], inner[1][:, ::-1]))


CELL = 1.0 / 24


@pytest.mark.parametrize(
    ("surface", "thickness"),
    [
        (surfaces.box((1.0, 1.0, 0.3 * CELL)), 0.3 * CELL),
        (surfaces.box((1e-4, 1.0, 0.5)), 1e-4),
        (turned(surfaces.box((1.0, 0.01, 0.6))), 0.01),
        ((turned(surfaces.box((1.0, 1.0, 0.02)))[0] * 1e-4 + (3.0, -7.0, 1.0), surfaces.box()[1]), 2e-6),
        (hollow(0.3 * CELL), None),
        (surfaces.finned(0.4 * CELL, 5 * CELL), 0.4 * CELL),
        (surfaces.wedge(3.0), None),
        (surfaces.joined(surfaces.box((0.4, 0.4, 0.4)), (surfaces.box((1, 1, 0.01))[0] + (0, 0, 0.4), BOX[1])), 0.01),
    ],
    ids=["plate", "foil", "turned plate", "small and far", "hollow ball", "fin", "blade", "plate beside a block"],
)
def test_a_part_that_is_lost_between_the_nodes_is_refused(surface, thickness):
    with pytest.raises(tc.InputError, match="bodies would pass through it") as caught:
        tc.Sdf.from_surface(surface, cells=24)
    assert caught.value.field == "cells"
    if thickness is not None:
        assert float(re.search(r"is (\S+) m thick", str(caught.value))[1]) == pytest.approx(thickness, rel=0.01)


@pytest.mark.parametrize(
    "surface",
    [
        surfaces.box((1.0, 1.0, 1.1 * CELL)),
        turned(surfaces.box((1.0, 1.0, 1.5 * CELL))),
        surfaces.box((1.0, 1.0, 1.0)),
        turned(surfaces.wedge(10.0)),
        surfaces.wedge(15.0),
        turned(surfaces.wedge(60.0)),
        (
            np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]),
            np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
        ),
        surfaces.finned(0.4 * CELL, CELL),
        surfaces.finned(2 * CELL, 5 * CELL),
        hollow(2.5 * CELL),
    ],
    ids=["plate", "turned plate", "cube", "knife", "axe", "ridge", "tetrahedron", "seam", "fin", "hollow ball"],
)
def test_edges_and_parts_that_the_grid_resolves_are_not_refused(surface):
    tc.Sdf.from_surface(surface, cells=24)


def test_the_cells_that_a_refusal_names_resolve_the_part():
    surface = turned(surfaces.box((0.4, 0.4, 0.03)))
    with pytest.raises(tc.InputError, match="take cells=") as caught:
        tc.Sdf.from_surface(surface, cells=8)
    sdf = tc.Sdf.from_surface(surface, cells=int(re.search(r"cells=(\d+)", str(caught.value.remedy))[1]))
    middle = np.random.default_rng(0).uniform(-0.18, 0.18, (500, 3)) * (1, 1, 0)
    gap = sdf.gap(middle @ TURN.T)
    assert gap.max() < -0.0075  # half of the depth: the middle is a crease of the distance
    with pytest.raises(tc.InputError, match="or use a Box") as caught:
        tc.Sdf.from_surface(surfaces.box((0.4, 0.4, 1e-4)), cells=8)
    assert "take cells" not in str(caught.value)
