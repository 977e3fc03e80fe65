"""Unusable mesh files end in an `InputError` that names the file and the remedy, however they are broken."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
from mesh_files import NAMES, WRITERS, box, gmsh_content, write_gmsh22, write_gmsh41

from tcontact.base.errors import InputError
from tcontact.mesh.files.reading import read_mesh
from tcontact.mesh.mesh import Mesh


def refused(path, *words, **options):
    """Message of the refusal; it must name the file."""
    with pytest.raises(InputError) as caught:
        read_mesh(path, **options)
    assert caught.value.field == "path"
    assert Path(path).name in caught.value.remedy
    for word in words:
        assert word in caught.value.remedy
    return caught.value.remedy


def write(path, cells, points=None):
    """A VTU file of (type, rows) blocks."""
    points = np.random.default_rng(0).random((40, 3)) if points is None else points
    meshio.Mesh(points, cells).write(path)
    return path


def test_missing_empty_unknown(tmp_path):
    refused(tmp_path / "none.msh", "no such file")
    refused(tmp_path, "directory")
    assert refused(".", "directory").startswith(".: ")
    (tmp_path / "empty.msh").touch()
    refused(tmp_path / "empty.msh", "empty")
    (tmp_path / "part.stl").write_text("solid\n")
    refused(tmp_path / "part.stl", "unknown extension", ".inp")
    (tmp_path / "part").write_text("solid\n")
    refused(tmp_path / "part", "unknown extension")


@pytest.mark.parametrize("extension", [".msh", ".vtu", ".inp"])
@pytest.mark.parametrize(
    "content", [b"\x00\xff\xfe" * 100, b"<html></html>", b"$MeshFormat\n9.9 0 8\n$EndMeshFormat\n", b"\n"]
)
def test_garbage_of_every_extension(tmp_path, extension, content):
    (tmp_path / f"part{extension}").write_bytes(content)
    refused(tmp_path / f"part{extension}")


@pytest.mark.parametrize("version", ["2.2", "4.1"])
@pytest.mark.parametrize("binary", [False, True])
def test_truncated_gmsh_file_never_gives_a_mesh(tmp_path, version, binary):
    """Cut anywhere before the end of the last section; a lost tail of digits must not pass as another node."""
    points, blocks = gmsh_content("hex8")
    file = tmp_path / "part.msh"
    WRITERS[version](file, points, list(range(1, len(points) + 1)), blocks, NAMES, binary)
    data = file.read_bytes()
    for keep in [*np.linspace(1, len(data) - 15, 60).astype(int), *range(len(data) - 25, len(data) - 2)]:
        file.write_bytes(data[:keep])
        refused(file)


def test_truncated_vtu_file(tmp_path):
    mesh = box("hex8")
    data = write(tmp_path / "part.vtu", [("hexahedron", mesh.cells)], mesh.nodes).read_bytes()
    for keep in np.linspace(1, len(data) - 12, 30).astype(int):
        (tmp_path / "part.vtu").write_bytes(data[:keep])
        refused(tmp_path / "part.vtu")


@pytest.mark.parametrize(
    ("blocks", "word"),
    [
        ([("triangle", [[0, 1, 2]])], "no volume cells, only triangle"),
        ([("tetra", [[0, 1, 2, 3]]), ("hexahedron", [[4, 5, 6, 7, 8, 9, 10, 11]])], "mixed"),
        ([("wedge", [[0, 1, 2, 3, 4, 5]]), ("tetra", [[0, 1, 2, 3]])], "prisms"),
        ([("tetra", [[0, 1, 2, 3]]), ("pyramid", [[0, 1, 2, 3, 4]])], "pyramid"),
    ],
)
def test_cells_of_the_wrong_kind(tmp_path, blocks, word):
    refused(write(tmp_path / "part.vtu", [(name, np.array(rows)) for name, rows in blocks]), word)


def test_cells_of_third_order(tmp_path):
    blocks = [("tet20", 1, [], [list(range(20))])]
    points = np.random.default_rng(0).random((20, 3))
    for version, write_gmsh in WRITERS.items():
        write_gmsh(tmp_path / f"{version}.msh", points, list(range(1, 21)), blocks, {}, False)
        refused(tmp_path / f"{version}.msh", "tetra20", "first order")


def test_refusals_of_the_mesh_name_the_file_too(tmp_path):
    mesh = box("hex8")
    path = write(tmp_path / "part.vtu", [("hexahedron", np.r_[mesh.cells, mesh.cells[:1]])], mesh.nodes)
    refused(path, "double")
    nodes = mesh.nodes.copy()
    nodes[4, 0] = np.nan
    refused(write(path, [("hexahedron", mesh.cells)], nodes), "NaN")


def test_surface_groups_that_do_not_fit_the_cells(tmp_path):
    points, blocks = gmsh_content("hex8")
    tags = list(range(1, len(points) + 1))
    file = tmp_path / "part.msh"
    write_gmsh22(file, points, tags, [*blocks, ("triangle", 9, [1], [[0, 1, 2]])], NAMES, False)
    refused(file, "'left'", "mesh it with the volume")
    write_gmsh41(file, points, tags, [*blocks, ("quad", 9, [2], [[0, 1, 2, 3]])], NAMES, False)
    refused(file, "'both ends'", "belong to no cell")


def test_wrong_options_are_refused_before_the_file_is_looked_at(tmp_path):
    for scale in (0.0, -1.0, np.nan, np.inf, "mm", None, True):
        with pytest.raises(InputError) as caught:
            read_mesh(tmp_path / "none.msh", scale=scale)
        assert caught.value.field == "scale"
    with pytest.raises(InputError, match=r"^kind = 'tet'"):
        read_mesh(tmp_path / "none.msh", kind="tet")
    with pytest.raises(InputError, match=r"^path = 3"):
        read_mesh(3)


def test_the_kind_that_is_asked_for_must_be_in_the_file(tmp_path):
    mesh = box("hex8")
    path = write(tmp_path / "part.vtu", [("hexahedron", mesh.cells)], mesh.nodes)
    assert isinstance(read_mesh(path, kind="hex8"), Mesh)
    with pytest.raises(InputError, match=r"^kind = 'tet4': the file holds hex8"):
        read_mesh(path, kind="tet4")


def test_cells_of_a_vtu_file_that_are_not_read_are_named(tmp_path):
    """They would be left out without a word, beside others too."""
    header = '<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">'
    points = " ".join(f"{x} {y} {z}" for z in (0, 1) for y in (0, 1) for x in (0, 1))

    def write(kind, nodes):
        connectivity = " ".join(map(str, [0, 1, 2, 4, *nodes]))
        text = (
            f'{header}<UnstructuredGrid><Piece NumberOfPoints="8" NumberOfCells="2"><Points>'
            f'<DataArray type="Float64" NumberOfComponents="3" format="ascii">{points}</DataArray></Points><Cells>'
            f'<DataArray type="Int64" Name="connectivity" format="ascii">{connectivity}</DataArray>'
            f'<DataArray type="Int64" Name="offsets" format="ascii">4 {4 + len(nodes)}</DataArray>'
            f'<DataArray type="UInt8" Name="types" format="ascii">10 {kind}</DataArray></Cells></Piece>'
            "</UnstructuredGrid></VTKFile>"
        )
        (tmp_path / "mesh.vtu").write_text(text)
        return tmp_path / "mesh.vtu"

    with pytest.raises(InputError, match=r"cells of the VTK type 11, which are not read"):
        read_mesh(write(11, range(8)))
    assert read_mesh(write(2, range(4))).cell_count == 1
