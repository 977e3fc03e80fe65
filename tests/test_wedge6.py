"""Prisms (wedge6): what the tests of all kinds of cells do not see; those have their force, masses, files and runs."""

from collections import Counter

import numpy as np
import oracle
import pytest
from oracle import meshes
from scenes import block, material, twin
from test_stable_step import ratio

import tcontact as tc
from tcontact.base.warning_kinds import MeshWarning
from tcontact.cells.stress import VonMises
from tcontact.mesh.elements import ELEMENTS
from tcontact.mesh.geometry import shortest_heights, spanned_heights
from tcontact.planning.removal import choose_removal
from tcontact.show.render.surface import boundary_surface


@pytest.mark.parametrize("kind", ELEMENTS)
def test_integration_is_exact_for_affine_cells(kind):
    """The volume, the masses and products of shape functions of x -> A x, against the sums over the corners."""
    element = ELEMENTS[kind]
    values, gradients, weights = element.rule
    volume = {"hex8": 8.0, "tet4": 1.0 / 6.0, "wedge6": 1.0}[kind]
    assert weights.sum() == pytest.approx(volume, rel=1e-15)
    assert weights @ values == pytest.approx(np.full(element.corners, volume / element.corners), rel=1e-14)
    assert np.abs(np.einsum("qad,ac->qdc", gradients, element.reference) - np.eye(3)).max() < 1e-15
    assert np.abs(element.shape(element.reference)[0] - np.eye(element.corners)).max() < 1e-15
    values, _, weights = element.product_rule
    mass = np.einsum("q,qa,qb->ab", weights, values, values)
    line, triangle = (np.ones((2, 2)) + np.eye(2)) / 6.0, (np.ones((3, 3)) + np.eye(3)) / 24.0
    if kind == "tet4":
        exact = (np.ones((4, 4)) + np.eye(4)) / 120.0
    elif kind == "wedge6":
        exact = np.kron(2.0 * line, triangle)
    else:
        exact = 8.0 * np.prod([line[np.ix_(*2 * [(r > 0).astype(int)])] for r in element.reference.T], axis=0)
    assert np.abs(mass - exact).max() < 1e-15


@pytest.mark.parametrize("kind", ELEMENTS)
def test_faces_edges_and_the_cells_of_a_box_go_together(kind):
    """Every edge is a side of two faces, run through once in each direction; the mirror turns a cell inside out."""
    element = ELEMENTS[kind]
    sides = Counter((a, b) for face in element.faces for a, b in zip(face, face[1:] + face[:1], strict=True))
    assert set(sides.values()) == {1}
    assert {frozenset(edge) for edge in element.edges} == {frozenset(side) for side in sides}
    assert all((b, a) in sides for a, b in sides)
    flipped = element.reference[list(element.mirror)]
    jacobian = np.einsum("qad,ac->qdc", element.rule[1], flipped)
    assert (np.linalg.det(jacobian) < 0.0).all()


def test_heights_of_a_prism():
    """A triangle 3, 4, 5 of length 2: all four heights are seen, whatever corner stands first; and of a flat one."""
    bottom = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0]])
    for turn in range(3):
        for length, wanted in ((2.0, 2.0), (7.0, 2.4)):
            ends = [np.roll(bottom, turn, axis=0) + np.array([0.0, 0.0, z]) for z in (0.0, length)]
            corners = np.concatenate(ends)
            assert shortest_heights("wedge6", corners, np.arange(6)[None]) == pytest.approx([wanted], rel=1e-13)
            assert spanned_heights("wedge6", corners, np.arange(6)[None])[0] >= wanted * (1.0 - 1e-13)


ABAQUS = """*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 0., 1., 0.
4, 0., 0., 2.
5, 1., 0., 2.
6, 0., 1., 2.
*ELEMENT, TYPE=C3D6, ELSET=all
1, 1, 2, 3, 4, 5, 6
*SURFACE, NAME=below
1, S1
*SURFACE, NAME=above
1, S2
*SURFACE, NAME=front
1, S3
*SURFACE, NAME=slanted
1, S4
*SURFACE, NAME=left
1, S5
*SURFACE, NAME=ends
1, S1
1, S2
*SURFACE, NAME=corner
1, S1
1, S3
"""


def test_an_abaqus_prism_has_its_faces(tmp_path, recwarn):
    (tmp_path / "part.inp").write_text(ABAQUS)
    mesh = tc.read_mesh(tmp_path / "part.inp")
    assert not [warning for warning in recwarn if warning.category is MeshWarning]  # nothing had to be turned
    assert mesh.cell_volumes() == pytest.approx([1.0], rel=1e-15)
    wanted = {
        "below": {0, 1, 2}, "above": {3, 4, 5}, "front": {0, 1, 3, 4}, "slanted": {1, 2, 4, 5}, "left": {0, 2, 3, 5}
    }  # fmt: skip
    for name, nodes in wanted.items():
        (face,) = mesh.faces_of(name)
        assert set(face.tolist()) == nodes
    assert len(mesh.faces_of("ends")) == len(mesh.faces_of("corner")) == 2


def test_faces_are_taken_with_any_corner_twice_or_as_triangles():
    box = tc.box_mesh((1.0, 1.0, 1.0), (2, 1, 1), "wedge6")
    ends = box.face_sets["zmin"]
    forms = [ends[:, :3], ends, ends[:, ::-1], np.roll(ends, 1, axis=1), ends[:, [0, 0, 1, 2]]]
    for form in forms:
        again = box.with_sets(face_sets={"again": form})
        assert np.array_equal(again.faces_of("again"), box.faces_of("zmin"))
    with pytest.raises(tc.InputError, match="face of no cell"):
        box.with_sets(face_sets={"wrong": box.face_sets["xmin"][:, :3]})
    with pytest.raises(tc.InputError, match="3 or 4 corners"):
        box.with_sets(face_sets={"wrong": [[0, 1]]})


def test_mirrored_prisms_are_turned_and_tangled_ones_refused():
    box = tc.box_mesh((1.0, 1.0, 1.0), (1, 1, 1), "wedge6")
    with pytest.warns(MeshWarning, match="2 inverted wedge6"):
        mesh = tc.Mesh(box.nodes, box.cells[:, [0, 2, 1, 3, 5, 4]], "wedge6")  # the order of older VTK
    assert np.array_equal(mesh.cells, box.cells)
    nodes = box.nodes[box.cells[0]]
    nodes[3] -= [0.0, 0.0, 1.2]  # a corner of one end through the other
    with pytest.raises(tc.InputError, match=r"inverted .* corners 0 1 2 of a triangle counter-clockwise"):
        tc.Mesh(nodes, [[0, 1, 2, 3, 4, 5]], "wedge6")


def test_other_formulations_are_refused():
    box = tc.box_mesh((1.0, 1.0, 1.0), (1, 1, 1), "wedge6")
    for formulation in ("reduced", "mean-dilatation"):
        with pytest.raises(tc.InputError, match=r"wedge6 cells have 'full' alone.*hex8"):
            tc.Body(box, material(), formulation=formulation)


def test_the_surface_of_prisms_has_triangles_and_quadrilaterals():
    box = tc.box_mesh((1.0, 1.0, 1.0), (3, 2, 4), "wedge6")
    surface = boundary_surface([("wedge6", box.cells), ("hex8", tc.box_mesh((1, 1, 1), (1, 1, 1)).cells + 1000)])
    assert len(surface.triangles) == 2 * 2 * 3 * 2
    assert len(surface.quads) == 2 * (3 + 2) * 4 + 6


def test_removal_and_periodic_sides_take_either_kind_of_face():
    box = block("wedge6", (3, 3, 2), shake=0.0)
    for axis, side in enumerate(("xmin", "ymin", "zmin")):
        normal = np.eye(3)[axis]
        body = tc.Body(box, material(), contact=side)
        wall = tc.Plane(-1e-3 * normal, normal)
        assert choose_removal(tc.Scene([body], [wall], duration=1e-3), 0) == "normal"
        images = tc.Body(box, material(), contact=side, periodic="xyz".replace("xyz"[axis], "")).images
        assert images is not None
        assert len(np.unique(images.master)) == {0: 4 * 3 * 2, 1: 3 * 4 * 2, 2: 3 * 3 * 3}[axis]


def test_bodies_of_prisms_meet_at_triangles_and_at_quadrilaterals():
    """Two boxes that move towards each other meet when the gap is closed, on sides and on ends."""
    size, gap = np.array([0.2, 0.22, 0.18]), 1e-3
    for axis in (0, 2):
        normal = np.eye(3)[axis]
        low = block("wedge6", 1, shake=0.0)
        high = low.translated(normal * (size + gap))
        bodies = [tc.Body(low, material(), velocity=0.5 * normal), tc.Body(high, material(), velocity=-0.5 * normal)]
        result = tc.simulate(tc.Scene(bodies, duration=3.0 * gap))
        assert result.reason == "bodies-meet"
        reached = ((result.position[: low.node_count] - low.nodes) @ normal).max()
        assert reached == pytest.approx(0.5 * gap, abs=1.01 * 0.5 * result.dt)


@pytest.mark.parametrize("shape", [(3, 3, 3), (1, 1, 9), (5, 5, 1)])
def test_stable_step_against_the_dense_eigenvalue(shape):
    share, _ = ratio(tc.Body(block("wedge6", shape, shake=0.2, turn=meshes.rotation(2)), material()))
    assert 0.9 <= share <= 1.0


def test_stress_at_the_centre_is_that_of_the_oracle():
    mesh = block("wedge6", (3, 2, 2), shake=0.2)
    body = tc.Body(mesh, material())
    u = 0.01 * np.random.default_rng(1).uniform(-1.0, 1.0, mesh.nodes.shape)
    there = twin(body)
    exact = oracle.von_mises(there.nodes, there.cells, "wedge6", there.law, u)
    assert np.abs(VonMises(body)(u) - exact).max() <= 1e-12 * exact.max()


def test_vtk_finds_the_outside_of_the_prisms_where_we_do(tmp_path):
    """VTK's own faces of a cell, in the file that a run leaves, look outward: the order of the corners is VTK's."""
    hdf = pytest.importorskip("vtkmodules.vtkIOHDF", exc_type=ImportError)
    xml = pytest.importorskip("vtkmodules.vtkIOXML", exc_type=ImportError)
    from tcontact.results.files.vtkhdf import ResultData, ResultFile

    box = tc.box_mesh((1.0, 2.0, 3.0), (1, 2, 1), "wedge6")
    with ResultFile.create(tmp_path / "result.vtkhdf", box.nodes, [("wedge6", box.cells)]) as file:
        file.append(0.0, {"displacement": np.zeros_like(box.nodes)})
    data = ResultData.open(tmp_path / "result.vtkhdf")
    assert [kind for kind, _ in data.blocks] == ["wedge6"]
    assert np.array_equal(data.blocks[0][1], box.cells)
    reader = hdf.vtkHDFReader()
    reader.SetFileName(str(tmp_path / "result.vtkhdf"))
    reader.Update()
    grid = reader.GetOutput()
    for number, corners in enumerate(box.cells):
        cell, centre = grid.GetCell(number), box.nodes[corners].mean(axis=0)
        assert cell.GetCellType() == 13
        for face in range(5):
            points = cell.GetFace(face).GetPoints()
            x = np.array([points.GetPoint(k) for k in range(points.GetNumberOfPoints())])
            assert np.cross(x[1] - x[0], x[2] - x[1]) @ (x.mean(axis=0) - centre) > 0.0
    written = xml.vtkXMLUnstructuredGridWriter()
    written.SetFileName(str(tmp_path / "part.vtu"))
    written.SetInputData(grid)
    written.SetDataModeToAscii()
    written.Write()
    with pytest.warns(MeshWarning, match="reordered"):  # meshio takes them for prisms of older VTK
        again = tc.read_mesh(tmp_path / "part.vtu")
    assert np.array_equal(again.cells, box.cells)
