"""Second-order cells of mesh files become those of first order between their corners, with their sets and a warning."""

from __future__ import annotations

import meshio
import numpy as np
import pytest
from mesh_files import NAMES, SECOND, WRITERS, box, gmsh_content, second_order

import tcontact as tc
from tcontact.mesh.elements import ELEMENTS

MESHIO = {"tet10": "tetra10", "hex20": "hexahedron20", "wedge15": "wedge15"}


def read(path, kind, points, blocks):
    """The mesh, whose warning must tell how many nodes were dropped."""
    count = sum(len(rows) for word, _, _, rows in blocks if word == SECOND[kind])
    volumes = [rows for word, _, _, rows in blocks if word == SECOND[kind]]
    corners = ELEMENTS[kind].corners
    dropped = len(np.unique(np.concatenate([rows[:, corners:] for rows in volumes])))
    text = rf"\({count} {MESHIO[SECOND[kind]]}\).*: {dropped} mid-side nodes were dropped"
    with pytest.warns(tc.MeshWarning, match=text) as caught:
        mesh = tc.read_mesh(path)
    assert [warning.filename for warning in caught] == [__file__]
    return mesh


def same(mesh, expected):
    assert np.array_equal(mesh.nodes, expected.nodes)
    assert np.array_equal(mesh.cells, expected.cells)
    for group in ("node_sets", "face_sets", "cell_sets"):
        given, wanted = getattr(mesh, group), getattr(expected, group)
        assert given.keys() == wanted.keys()
        assert all(np.array_equal(given[name], wanted[name]) for name in wanted)


@pytest.mark.parametrize("version", WRITERS)
@pytest.mark.parametrize("binary", [False, True])
@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
def test_a_gmsh_file_of_second_order_gives_the_mesh_of_first_order(tmp_path, kind, binary, version):
    points, blocks = gmsh_content(kind)
    write = WRITERS[version]
    write(tmp_path / "first.msh", points, list(range(1, len(points) + 1)), blocks, NAMES, binary)
    more, higher = second_order(points, blocks)
    write(tmp_path / "second.msh", more, list(range(1, len(more) + 1)), higher, NAMES, binary)
    same(read(tmp_path / "second.msh", kind, more, higher), tc.read_mesh(tmp_path / "first.msh"))


@pytest.mark.parametrize("kind", ["hex8", "tet4"])  # meshio writes no wedge15
def test_a_vtu_file_of_second_order_gives_the_mesh_of_first_order(tmp_path, kind):
    mesh = box(kind)
    points, blocks = second_order(mesh.nodes, [(kind, 1, [], mesh.cells)])
    region = np.arange(mesh.cell_count) % 2
    cells = [(MESHIO[SECOND[kind]], blocks[0][3])]
    meshio.Mesh(points, cells, cell_data={"region": [region]}).write(tmp_path / "part.vtu")
    regions = {f"region-{k}": np.flatnonzero(region == k) for k in (0, 1)}
    expected = tc.Mesh(mesh.nodes, mesh.cells, kind, cell_sets=regions)
    same(read(tmp_path / "part.vtu", kind, points, blocks), expected)


def test_a_set_of_mid_side_nodes_alone_is_left_out(tmp_path):
    points, blocks = second_order(box("tet4").nodes, [("tet4", 1, [], box("tet4").cells)])
    only = [("point", 1, [4], [[len(points) - 1]])]
    WRITERS["2.2"](tmp_path / "part.msh", points, list(range(1, len(points) + 1)), blocks + only, NAMES, False)
    with (
        pytest.warns(tc.MeshWarning, match="second-order"),
        pytest.warns(tc.MeshWarning, match="'corner' is left out: none of its nodes"),
    ):
        mesh = tc.read_mesh(tmp_path / "part.msh")
    assert "corner" not in mesh.node_sets
