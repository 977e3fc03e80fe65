"""Mesh files: what is written is what is read, with its sets, in every format."""

from __future__ import annotations

import subprocess
import sys
import warnings

import meshio
import numpy as np
import pytest
from mesh_files import NAMES, WRITERS, box, gmsh_content, write_gmsh22, write_gmsh41

from tcontact.base.warning_kinds import MeshWarning
from tcontact.mesh.files.content import FileMesh, mesh_from_file
from tcontact.mesh.files.reading import read_mesh


def same_faces(a, b):
    return sorted(sorted(set(face)) for face in a.tolist()) == sorted(sorted(set(face)) for face in b.tolist())


@pytest.mark.parametrize("version", ["2.2", "4.1"])
@pytest.mark.parametrize("binary", [False, True])
@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
def test_gmsh_file_gives_the_mesh_and_its_groups(tmp_path, kind, version, binary):
    """Orphans go, numbering closes up, groups follow: the mesh is the box that was written."""
    points, blocks = gmsh_content(kind)
    sparse = not binary or version == "4.1"  # binary 2.2 must count 1, 2, 3 ...
    tags = [7 * i + 3 for i in range(len(points))] if sparse else list(range(1, len(points) + 1))
    WRITERS[version](tmp_path / "part.msh", points, tags, blocks, NAMES, binary)
    mesh, expected = read_mesh(tmp_path / "part.msh", scale=0.5), box(kind)
    assert mesh.kind == kind
    assert np.array_equal(mesh.nodes, 0.5 * expected.nodes)
    assert np.array_equal(mesh.cells, expected.cells)
    assert set(mesh.face_sets) == {"left", "both ends", "body", "PhysicalSurface9"}
    assert set(mesh.node_sets) == {"corner", "edge", "body", "all"}
    assert same_faces(mesh.faces_of("left"), expected.faces_of("xmin"))
    assert same_faces(mesh.faces_of("both ends"), expected.faces_of(["xmin", "xmax"]))
    assert same_faces(mesh.faces_of("PhysicalSurface9"), expected.faces_of("ymin"))
    assert same_faces(mesh.faces_of("body"), expected.faces_of("zmax"))
    assert mesh.node_sets["corner"].tolist() == [7]
    assert mesh.node_sets["edge"].tolist() == [0, 1, 2]
    assert len(mesh.node_sets["body"]) == mesh.node_count


@pytest.mark.parametrize("binary", [False, True])
def test_gmsh_41_with_entities_outside_all_groups_keeps_the_named_groups(tmp_path, binary):
    points, blocks = gmsh_content("hex8", ungrouped=True)
    write_gmsh41(tmp_path / "part.msh", points, list(range(1, len(points) + 1)), blocks, NAMES, binary)
    mesh = read_mesh(tmp_path / "part.msh")
    assert same_faces(mesh.faces_of("left"), box("hex8").faces_of("xmin"))
    assert mesh.cell_count == 12


@pytest.mark.parametrize("version", ["2.2", "4.1"])
@pytest.mark.parametrize("binary", [False, True])
def test_gmsh_file_without_groups_gives_all_cells_and_no_sets(tmp_path, version, binary):
    mesh = box("tet4")
    blocks = [("triangle", 1, [], mesh.boundary_faces()), ("tet4", 1, [], mesh.cells)]
    WRITERS[version](tmp_path / "part.MSH", mesh.nodes, list(range(1, mesh.node_count + 1)), blocks, {}, binary)
    read = read_mesh(str(tmp_path / "part.MSH"), kind="tet4")
    assert np.array_equal(read.cells, mesh.cells)
    assert not read.node_sets
    assert not read.face_sets


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
def test_mirrored_cells_are_turned_and_reported(tmp_path, kind):
    mesh = box(kind)
    mirrored = mesh.nodes * [1.0, 1.0, -1.0]
    blocks = [(kind, 1, [], mesh.cells)]
    write_gmsh22(tmp_path / "part.msh", mirrored, list(range(1, mesh.node_count + 1)), blocks, {}, False)
    with pytest.warns(MeshWarning, match=f"{mesh.cell_count} inverted {kind} cells"):
        read = read_mesh(tmp_path / "part.msh")
    assert read.cell_volumes() == pytest.approx(mesh.cell_volumes(), rel=1e-12)


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
@pytest.mark.parametrize("binary", [False, True])
def test_vtu_file_gives_the_mesh_and_no_sets(tmp_path, kind, binary):
    mesh = box(kind)
    word, face = {"hex8": ("hexahedron", "quad"), "tet4": ("tetra", "triangle"), "wedge6": ("wedge", "quad")}[kind]
    content = meshio.Mesh(
        np.r_[[[5.0, 5.0, 5.0]], mesh.nodes],
        [(face, mesh.face_sets["xmin"] + 1), (word, mesh.cells + 1)],
        cell_data={"material": [np.ones(len(mesh.face_sets["xmin"]), int), np.ones(mesh.cell_count, int)]},
    )
    content.write(tmp_path / "part.vtu", binary=binary)
    read = read_mesh(tmp_path / "part.vtu")
    assert read.nodes == pytest.approx(mesh.nodes, rel=1e-10)
    assert np.array_equal(read.cells, mesh.cells)
    assert not read.node_sets
    assert not read.face_sets


def test_vtu_cells_out_of_reach_of_the_points_are_refused(tmp_path):
    from tcontact.base.errors import InputError

    mesh = box("tet4")
    meshio.Mesh(mesh.nodes[:-1], [("tetra", mesh.cells)]).write(tmp_path / "part.vtu", binary=False)
    with pytest.raises(InputError, match=r"part\.vtu: .*nodes that the file does not hold"):
        read_mesh(tmp_path / "part.vtu")


def test_reading_prints_nothing(tmp_path, capfd):
    """meshio talks to the terminal about broken files; here errors speak for themselves."""
    from tcontact.base.errors import InputError

    (tmp_path / "part.msh").write_text("nothing\n")
    with pytest.raises(InputError):
        read_mesh(tmp_path / "part.msh")
    printed = capfd.readouterr()
    assert printed.out == printed.err == ""


def test_importing_the_reader_imports_no_meshio():
    code = "import sys, tcontact.mesh.files.reading; sys.exit('meshio' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def star():
    """A hex with a prism at each of its four upright sides, and their upper faces: 1 quad and 4 triangles.

    The corners of the quad all belong to prisms.
    """
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, -1], [2, 0.5], [0.5, 2], [-1, 0.5]])
    points = np.array([[*corner, z] for z in (0.0, 1.0) for corner in corners])
    triangles = np.array([[0, 4, 1], [1, 5, 2], [2, 6, 3], [3, 7, 0]])
    square = np.array([[0, 1, 2, 3]])
    cells = [
        ("hex8", 1, [7], np.hstack([square, square + 8])),
        ("wedge6", 2, [7], np.hstack([triangles, triangles + 8])),
    ]
    tops = [("quad", 1, [1], square + 8), ("quad", 1, [2], square + 8), ("triangle", 2, [1], triangles + 8)]
    return points, [*tops, *cells]


@pytest.mark.parametrize("kind", ["hex8", "wedge6"])
def test_faces_of_the_other_cells_in_a_file_are_left_out(kind, tmp_path):
    points, blocks = star()
    names = {(2, 1): "top", (2, 2): "square", (3, 7): "all"}
    tags = list(range(1, len(points) + 1))
    write_gmsh22(tmp_path / "part.msh", points, tags, blocks, names, False)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        mesh = read_mesh(tmp_path / "part.msh", kind=kind)
    said = [str(warning.message) for warning in caught if warning.category is MeshWarning]
    if kind == "wedge6":
        assert mesh.cell_count == len(mesh.faces_of("top")) == 4
        assert "square" not in mesh.face_sets
        assert any("'square' is left out: none of its faces belongs to a wedge6 cell" in text for text in said)
    else:
        assert len(mesh.faces_of("top")) == len(mesh.faces_of("square")) == 1
        assert not said


def test_a_triangle_among_quadrilaterals_that_is_written_in_two_ways_is_one_face():
    mesh = box("wedge6")
    a, b, c = mesh.cells[0][:3]
    faces = [np.array([[a, b, c, c], [b, c, a, a], [c, c, b, a]]), np.array([[c, b, a]])]
    content = FileMesh(mesh.nodes, [("wedge", mesh.cells)], face_sets={"one": faces})
    assert len(mesh_from_file(content, 1.0, None).face_sets["one"]) == 1
