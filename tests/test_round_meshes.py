"""Rings, cylinders and balls: volumes of polygons, closed skins, sets, every axis and scale, refusals, scene files."""

from __future__ import annotations

import numpy as np
import pytest

import tcontact as tc

AXES = ("x", "y", "z")
KINDS = ("hex8", "tet4", "wedge6")


def polygon(radius, sides):
    return 0.5 * sides * np.sin(2.0 * np.pi / sides) * radius**2


def areas(mesh, name):
    """Area vectors [f, 3] of the faces of a set, of triangles too that have a corner twice."""
    x = mesh.nodes[mesh.faces_of(name)]
    last = x[:, 3] if x.shape[1] == 4 else x[:, 2]
    return 0.5 * np.cross(x[:, 2] - x[:, 0], last - x[:, 1])


def split(mesh, axis, center):
    """Coordinates along the axis and distances from it, about the center."""
    x = mesh.nodes - center
    along = AXES.index(axis)
    return x[:, along], np.linalg.norm(np.delete(x, along, axis=1), axis=1)


def check_ends(mesh, axis, center, length, area):
    """Both ends lie in their planes and look outward; the sets cover the whole skin, each face once."""
    along, _ = split(mesh, axis, center)
    for name, sign in ((f"{axis}min", -1.0), (f"{axis}max", 1.0)):
        assert along[mesh.nodes_of(name)] == pytest.approx(sign * length / 2.0, rel=1e-9)
        expected = sign * area * np.eye(3)[AXES.index(axis)]
        assert areas(mesh, name).sum(axis=0) == pytest.approx(expected, abs=1e-9 * area)
    assert sum(len(faces) for faces in mesh.face_sets.values()) == len(mesh.boundary_faces())


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e4])
def test_a_cylinder_is_one(kind, axis, scale):
    radius, length, center = 0.3 * scale, 0.2 * scale, np.array([1.0, -2.0, 0.5]) * scale
    mesh = tc.cylinder_mesh(radius, length, 3, kind, axis, center, layers=2)
    area = polygon(radius, 12)
    assert mesh.kind == kind
    assert mesh.cell_count == 2 * (9 + 4 * 3 * 2) * {"hex8": 1, "tet4": 12, "wedge6": 2}[kind]
    assert mesh.cell_volumes().sum() == pytest.approx(area * length, rel=1e-9)
    assert mesh.cell_volumes().min() > 0.0
    assert set(mesh.face_sets) == {"rim", f"{axis}min", f"{axis}max"}
    check_ends(mesh, axis, center, length, area)
    _, distance = split(mesh, axis, center)
    assert distance[mesh.nodes_of("rim")] == pytest.approx(radius, rel=1e-9)
    core, shell = mesh.cell_sets["core"], mesh.cell_sets["shell"]
    assert np.array_equal(np.sort(np.concatenate([core, shell])), np.arange(mesh.cell_count))
    far = [
        np.abs(np.delete(mesh.cell_centres()[cells] - center, AXES.index(axis), axis=1)).max()
        for cells in (core, shell)
    ]
    assert far[0] < 0.6 * radius < far[1]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e4])
def test_a_ring_is_one(kind, axis, scale):
    inner, outer, length, center = 0.2 * scale, 0.3 * scale, 0.1 * scale, np.array([-1.0, 0.0, 3.0]) * scale
    mesh = tc.ring_mesh(inner, outer, length, 10, kind, axis, center, across=2, layers=3, start=0.4)
    area = polygon(outer, 10) - polygon(inner, 10)
    assert mesh.cell_count == 10 * 2 * 3 * {"hex8": 1, "tet4": 6, "wedge6": 2}[kind]
    assert mesh.cell_volumes().sum() == pytest.approx(area * length, rel=1e-9)
    assert set(mesh.face_sets) == {"inner", "outer", f"{axis}min", f"{axis}max"}
    check_ends(mesh, axis, center, length, area)
    _, distance = split(mesh, axis, center)
    for name, radius in (("inner", inner), ("outer", outer)):
        assert distance[mesh.nodes_of(name)] == pytest.approx(radius, rel=1e-9)
    along = AXES.index(axis)  # a corner stands at the angle 0.4, right-handed about the axis
    first, second = (mesh.nodes[:, (along + k) % 3] - center[(along + k) % 3] for k in (1, 2))
    turns = np.arctan2(second, first)[mesh.nodes_of("outer")]
    assert np.abs(turns - 0.4).min() < 1e-9


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e4])
def test_a_ball_is_one(kind, scale):
    center = np.array([1.0, 2.0, -3.0]) * scale
    mesh = tc.ball_mesh(0.5 * scale, 6, kind, center)
    assert mesh.cell_volumes().sum() == pytest.approx(np.pi / 6.0 * scale**3, rel=5e-2)
    assert np.array_equal(np.unique(mesh.boundary_faces()), mesh.nodes_of("surface"))
    assert len(mesh.faces_of("surface")) == len(mesh.boundary_faces())
    distance = np.linalg.norm(mesh.nodes[mesh.nodes_of("surface")] - center, axis=1)
    assert distance == pytest.approx(0.5 * scale, rel=1e-9)
    for name, sign in (("low", -1.0), ("high", 1.0)):
        x = mesh.nodes[mesh.faces_of(name)].mean(axis=1) - center
        reach = np.radians(40.0 if kind == "hex8" else 45.0)  # halves of a face may reach on a little
        assert (sign * x[:, 2] > np.cos(reach) * np.linalg.norm(x, axis=1)).all()
    assert np.array_equal(np.sort(np.concatenate([*mesh.cell_sets.values()])), np.arange(mesh.cell_count))


@pytest.mark.parametrize("cells", [1, 2, 5, 16, 32])
def test_no_number_of_cells_leaves_a_crack(cells):
    """Where blocks meet their points become one: the skin of a cylinder and a ball has no face inside."""
    cylinder = tc.cylinder_mesh(0.7, 0.1, cells, layers=1)
    steps = max(2, cells // 2)
    assert len(cylinder.boundary_faces()) == 4 * cells + 2 * (cells**2 + 4 * cells * steps)
    ball = tc.ball_mesh(0.7, min(cells, 16))
    assert len(ball.boundary_faces()) == 6 * min(cells, 16) ** 2


def test_cells_are_about_as_long_as_wide_unless_told():
    ring = tc.ring_mesh(0.9, 1.1, 0.5, 24)
    assert ring.cell_count == 24 * 3 * round(0.5 / (2.0 * np.pi / 24))
    cylinder = tc.cylinder_mesh(1.0, 4.0, 4)
    assert cylinder.cell_count == (16 + 32) * round(4.0 / (np.pi / 8.0))
    tube, needle = tc.ring_mesh(1.0, 1.1, 1e5, 8, layers=3), tc.cylinder_mesh(1.0, 1e7, 2, layers=3)
    for mesh in (tube, needle):  # long ones keep their cross-section
        assert (mesh.cell_volumes() > 0.0).all()


@pytest.mark.parametrize(
    ("field", "wrong"),
    [
        ("inner", lambda: tc.ring_mesh(0.0, 1.0, 1.0, 8)),
        ("inner", lambda: tc.ring_mesh("a", 1.0, 1.0, 8)),
        ("outer", lambda: tc.ring_mesh(1.0, 1.0, 1.0, 8)),
        ("outer", lambda: tc.ring_mesh(1.0, np.nan, 1.0, 8)),
        ("length", lambda: tc.ring_mesh(1.0, 2.0, -1.0, 8)),
        ("cells", lambda: tc.ring_mesh(1.0, 2.0, 1.0, 2)),
        ("cells", lambda: tc.ring_mesh(1.0, 2.0, 1.0, 10**8)),
        ("cells", lambda: tc.ring_mesh(1.0, 1.0 + 1e-7, 1.0, 8)),
        ("across", lambda: tc.ring_mesh(1.0, 2.0, 1.0, 8, across=0)),
        ("layers", lambda: tc.ring_mesh(1.0, 2.0, 1.0, 8, layers=1.5)),
        ("axis", lambda: tc.ring_mesh(1.0, 2.0, 1.0, 8, axis="w")),
        ("start", lambda: tc.ring_mesh(1.0, 2.0, 1.0, 8, start=np.inf)),
        ("kind", lambda: tc.ring_mesh(1.0, 2.0, 1.0, 8, "hex20")),
        ("center", lambda: tc.ring_mesh(1.0, 2.0, 1.0, 8, center=(0.0, 0.0))),
        ("radius", lambda: tc.cylinder_mesh(-1.0, 1.0, 8)),
        ("length", lambda: tc.cylinder_mesh(1.0, 0.0, 8)),
        ("cells", lambda: tc.cylinder_mesh(1.0, 1.0, 0)),
        ("cells", lambda: tc.cylinder_mesh(1.0, 1e-8, 4)),
        ("cells", lambda: tc.cylinder_mesh(1e-8, 1.0, 10**6)),
        ("center", lambda: tc.cylinder_mesh(1.0, 1.0, 8, center=(1e30, 0.0, 0.0))),
        ("radius", lambda: tc.ball_mesh(True, 8)),
        ("cells", lambda: tc.ball_mesh(1.0, 8.0)),
        ("cells", lambda: tc.ball_mesh(1.0, 10**4)),
        ("kind", lambda: tc.ball_mesh(1.0, 8, "wedge6")),
    ],
)
def test_bad_arguments_are_named(field, wrong):
    with pytest.raises(tc.InputError) as caught:
        wrong()
    assert caught.value.field == field


def scene_text(mesh):
    return f"""duration = 1e-3
[[bodies]]
mesh = {mesh}
material = {{ type = "LinearElastic", young = 1e7, poisson = 0.3, density = 1000.0 }}
"""


def test_scene_files_name_round_meshes_by_their_arguments(tmp_path):
    file = tmp_path / "scene.toml"
    tables = {
        "{ ring = { inner = 0.1, outer = 0.2, length = 0.1, cells = 9, axis = 'x' } }": tc.ring_mesh(
            0.1, 0.2, 0.1, 9, axis="x"
        ),
        "{ cylinder = { radius = 0.1, length = 0.2, cells = 2, kind = 'wedge6' } }": tc.cylinder_mesh(
            0.1, 0.2, 2, "wedge6"
        ),
        "{ ball = { radius = 0.1, cells = 2, center = [0, 0, 1] } }": tc.ball_mesh(0.1, 2, center=(0, 0, 1)),
    }
    for text, expected in tables.items():
        file.write_text(scene_text(text))
        scene, _ = tc.load_scene(file)
        tc.save_scene(scene, tmp_path / "again.toml")
        for mesh in (scene.bodies[0].mesh, tc.load_scene(tmp_path / "again.toml")[0].bodies[0].mesh):
            assert np.array_equal(mesh.nodes, expected.nodes)
            assert np.array_equal(mesh.cells, expected.cells)
            for group in ("face_sets", "cell_sets"):
                given, wanted = getattr(mesh, group), getattr(expected, group)
                assert given.keys() == wanted.keys()
                assert all(np.array_equal(given[name], wanted[name]) for name in wanted)
    wrong = {
        "{ ball = { radius = 0.1, cells = 2, axis = 'x' } }": r"mesh\.ball\.axis.*unknown key",
        "{ ball = { radius = 0.1 } }": r"mesh\.ball.*missing",
        "{ ring = 3 }": r"mesh\.ring.*table",
        "{ ball = { radius = -0.1, cells = 2 } }": r"mesh\.ball: radius",
        "{ ball = { radius = 0.1, cells = 2 }, kind = 'tet4' }": r"mesh\.kind.*unknown key",
    }
    for text, words in wrong.items():
        file.write_text(scene_text(text))
        with pytest.raises(tc.InputError, match=words):
            tc.load_scene(file)
