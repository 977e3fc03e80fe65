"""Groups of a mesh file with one name are one set: all of them, whatever the format."""

from __future__ import annotations

import warnings

import meshio
import numpy as np
import pytest
from mesh_files import WRITERS, box, faces

import tcontact as tc

NAMES = {
    (2, 3): "ends",
    (2, 7): "ends",
    (2, 9): "side",
    (3, 1): "core",
    (3, 2): "core",
    (1, 8): "side",
    (0, 4): "corner",
    (0, 5): "corner",
}


def written(path, version, binary, first):
    """Write a box with two groups of one name in three dimensions; first: groups of one end before the shared one."""
    mesh = box("hex8")
    half = mesh.cell_count // 2
    blocks = [
        ("point", 1, [4], [[0]]),
        ("point", 2, [5], [[7]]),
        ("line", 1, [8], [[0, 1]]),
        faces(1, [*first, 3], mesh.face_sets["xmin"]),
        faces(2, [7], mesh.face_sets["xmax"]),
        ("hex8", 1, [1], mesh.cells[:half]),
        ("hex8", 2, [2], mesh.cells[half:]),
    ]
    WRITERS[version](path, mesh.nodes, list(range(1, mesh.node_count + 1)), blocks, NAMES, binary)
    return mesh


@pytest.mark.parametrize("first", [[], [9]])
@pytest.mark.parametrize("binary", [False, True])
@pytest.mark.parametrize("version", ["2.2", "4.1"])
def test_gmsh_groups_of_one_name_are_one_set(tmp_path, version, binary, first):
    """A block holds the elements of both groups (2.2), or an entity has the shared name second (4.1)."""
    mesh = written(tmp_path / "part.msh", version, binary, first)
    read = tc.read_mesh(tmp_path / "part.msh")
    ends = np.sort(mesh.faces_of(["xmin", "xmax"]), axis=1).tolist()
    assert sorted(np.sort(read.face_sets["ends"], axis=1).tolist()) == sorted(ends)
    assert read.cell_sets["core"].tolist() == list(range(mesh.cell_count))
    assert len(read.node_sets["core"]) == mesh.node_count
    assert read.node_sets["corner"].tolist() == [0, 7]
    assert len(read.face_sets.get("side", ())) == (len(mesh.face_sets["xmin"]) if first else 0)
    assert read.node_sets["side"].tolist() == [0, 1]


def test_a_load_on_two_groups_of_one_name_acts_on_both(tmp_path):
    """The applied force is the traction times the area of both ends, 2 x (2 x 3) m^2."""
    written(tmp_path / "part.msh", "2.2", False, [])
    rubber = tc.NeoHookean(young=1e6, poisson=0.3, density=1000.0)
    body = tc.Body(tc.read_mesh(tmp_path / "part.msh"), rubber, loads=[tc.Load("ends", traction=(0.0, 0.0, 1.0))])
    force = tc.simulate(tc.Scene([body], duration=1e-4)).history["applied_force"][0]
    assert np.allclose(force, [0.0, 0.0, 12.0], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("version", ["2.2", "4.1"])
def test_names_of_gmsh_groups_without_quotes_are_read(tmp_path, version):
    file = tmp_path / "part.msh"
    mesh = written(file, version, False, [])
    file.write_bytes(file.read_bytes().replace(b'"', b""))
    assert len(tc.read_mesh(file).face_sets["ends"]) == len(mesh.faces_of(["xmin", "xmax"]))


def test_node_surfaces_of_one_name_in_an_abaqus_file_are_one_set(tmp_path):
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (1, 1, 1))
    lines = ["*Node", *(f"{i}, {x}, {y}, {z}" for i, (x, y, z) in enumerate(mesh.nodes.tolist(), 1))]
    lines += ["*Element, type=C3D8", ", ".join(str(number) for number in [1, *(mesh.cells[0] + 1)])]
    lines += ["*Surface, type=NODE, name=tip", "1,", "*Surface, type=NODE, name=tip", "8,", ""]
    (tmp_path / "part.inp").write_text("\n".join(lines))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert tc.read_mesh(tmp_path / "part.inp").node_sets["tip"].tolist() == [0, 7]


def test_a_cell_set_keeps_its_name_from_the_numbers_of_the_cells():
    """The cells of a set and those with a number of a cell array are not mixed."""
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 1, 1))
    blocks = [("hexahedron", mesh.cells[:1]), ("hexahedron", mesh.cells[1:])]
    other = meshio.Mesh(mesh.nodes, blocks, cell_data={"region": [np.array([1]), np.array([2])]})
    other.cell_sets = {"region-1": [[], [0]]}
    sets = tc.Mesh.from_meshio(other).cell_sets
    assert {name: cells.tolist() for name, cells in sets.items()} == {"region-1": [1], "region-2": [1]}
