"""Meshes: exact volumes and areas, outward and conforming faces, sets, motions."""

from __future__ import annotations

import copy
import pickle
from collections import Counter
from itertools import combinations

import numpy as np
import pytest

from tcontact.mesh.box import box_mesh
from tcontact.mesh.elements import ELEMENTS
from tcontact.mesh.mesh import Mesh

KINDS = ("hex8", "tet4", "wedge6")
SIDES = ("xmin", "xmax", "ymin", "ymax", "zmin", "zmax")


def vector_areas(nodes, faces):
    """Area vector of each face [k, 3]: half the cross product of diagonals, or of two edges."""
    x = nodes[faces]
    if faces.shape[1] == 4:
        return 0.5 * np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1])
    return 0.5 * np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])


def bent(kind, cells=(4, 3, 5)):
    """A box mesh with its nodes moved by a smooth map, so that nothing is aligned with the axes."""
    box = box_mesh((1.0, 2.0, 3.0), cells, kind)
    turns = np.array([[0.3, 0.9, -0.7], [1.1, 0.5, 0.8], [-0.6, 0.7, 0.4]])
    nodes = box.nodes + 0.1 * np.sin(box.nodes @ turns)
    return Mesh(nodes, box.cells, kind, face_sets=box.face_sets)


@pytest.mark.parametrize("kind", KINDS)
def test_volumes_of_a_box_add_up_exactly_and_are_equal(kind):
    mesh = box_mesh((0.1, 0.2, 0.3), (3, 4, 5), kind, origin=(-1.0, 2.0, 7.0))
    cells = 60 * {"hex8": 1, "tet4": 6, "wedge6": 2}[kind]
    assert mesh.cell_volumes() == pytest.approx(np.full(cells, 0.006 / cells), rel=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_volume_equals_the_flux_of_x_over_the_boundary(kind):
    """Gauss: V = 1/3 integral x.n; exact for tets, where faces are flat, and judges the hex8 rule on bilinear faces."""
    mesh = bent(kind)
    faces = mesh.boundary_faces()
    if kind == "tet4":
        flux = np.einsum("fi,fi->", mesh.nodes[faces].mean(axis=1), vector_areas(mesh.nodes, faces)) / 3.0
    else:
        flux = 0.0
        x = mesh.nodes[faces]
        for a in (-(3**-0.5), 3**-0.5):
            for b in (-(3**-0.5), 3**-0.5):
                shape = 0.25 * np.array([(1 - a) * (1 - b), (1 + a) * (1 - b), (1 + a) * (1 + b), (1 - a) * (1 + b)])
                da = 0.25 * np.array([-(1 - b), 1 - b, 1 + b, -(1 + b)])
                db = 0.25 * np.array([-(1 - a), -(1 + a), 1 + a, 1 - a])
                normal = np.cross(np.einsum("a,fai->fi", da, x), np.einsum("a,fai->fi", db, x))
                flux += np.einsum("fi,fi->", np.einsum("a,fai->fi", shape, x), normal) / 3.0
    assert mesh.cell_volumes().sum() == pytest.approx(flux, rel=1e-13)


@pytest.mark.parametrize("kind", KINDS)
def test_boundary_is_closed_and_points_outward(kind):
    mesh = bent(kind)
    areas = vector_areas(mesh.nodes, mesh.boundary_faces())
    assert np.abs(areas.sum(axis=0)).max() < 1e-13
    cell_of = {
        frozenset(cell[list(face)].tolist()): mesh.nodes[cell].mean(axis=0)
        for cell in mesh.cells
        for face in ELEMENTS[kind].faces
    }
    for face, area in zip(mesh.boundary_faces(), areas, strict=True):
        assert area @ (mesh.nodes[face].mean(axis=0) - cell_of[frozenset(face.tolist())]) > 0.0


@pytest.mark.parametrize("kind", KINDS)
def test_side_sets_have_the_area_and_the_normal_of_the_side(kind):
    size = (1.0, 2.0, 4.0)
    mesh = box_mesh(size, (2, 3, 4), kind)
    for number, side in enumerate(SIDES):
        axis, sign = number // 2, (-1.0, 1.0)[number % 2]
        expected = np.zeros(3)
        expected[axis] = sign * 8.0 / size[axis]
        areas = vector_areas(mesh.nodes, mesh.faces_of(side))
        assert areas.sum(axis=0) == pytest.approx(expected, abs=1e-14)
        assert np.linalg.norm(areas, axis=1).sum() == pytest.approx(8.0 / size[axis], rel=1e-14)
        assert np.all(mesh.nodes[mesh.nodes_of(side), axis] == (0.0, size[axis])[number % 2])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("cells", [(1, 1, 1), (2, 1, 1), (2, 3, 2)])
def test_every_face_has_one_or_two_cells_and_euler_holds(kind, cells):
    """Brute force over sets of corners: conformity, the boundary, and V - E + F - C = 1 for a ball."""
    mesh = box_mesh((1.0, 1.0, 1.0), cells, kind)
    faces = Counter(frozenset(cell[list(face)].tolist()) for cell in mesh.cells for face in ELEMENTS[kind].faces)
    assert set(faces.values()) <= {1, 2}
    outer = {face for face, count in faces.items() if count == 1}
    assert outer == {frozenset(face.tolist()) for face in mesh.boundary_faces()}
    ends, sides = 2 * cells[0] * cells[1], 2 * (cells[0] + cells[1]) * cells[2]  # across z, and around it
    assert len(outer) == {"hex8": ends + sides, "tet4": 2 * (ends + sides), "wedge6": 2 * ends + sides}[kind]
    corners = [(face, face[1:] + face[:1]) for face in ELEMENTS[kind].faces]
    edges = {
        frozenset((cell[a], cell[b]))
        for cell in mesh.cells.tolist()
        for f, g in corners
        for a, b in zip(f, g, strict=True)
    }
    assert mesh.node_count - len(edges) + len(faces) - mesh.cell_count == 1
    assert sum(len(mesh.face_sets[side]) for side in SIDES) == len(outer)


def test_tetrahedra_meet_on_opposite_sides_of_a_box():
    """The division of one side is that of the opposite side shifted, as periodic boxes need."""
    mesh = box_mesh((1.0, 1.0, 1.0), (2, 3, 4), "tet4")
    for axis, letter in enumerate("xyz"):
        sides = []
        for side in ("min", "max"):
            flat = np.delete(mesh.nodes, axis, axis=1).round(9)
            sides.append({frozenset(map(tuple, flat[face].tolist())) for face in mesh.faces_of(letter + side)})
        assert sides[0] == sides[1]


def test_end_coordinates_are_exact_and_ids_run_along_x_first():
    mesh = box_mesh((0.1, 0.7, 0.3), (7, 3, 11), origin=(0.1, -0.7, 1.0))
    low, high = mesh.bounds
    assert low.tolist() == [0.1, -0.7, 1.0]
    assert high.tolist() == [0.1 + 0.1, 0.0, 1.0 + 0.3]
    assert mesh.size == pytest.approx(0.7)
    assert mesh.nodes[1, 0] > mesh.nodes[0, 0]
    assert mesh.nodes[8, 1] > mesh.nodes[0, 1]


@pytest.mark.parametrize("kind", KINDS)
def test_a_box_passes_every_check_of_the_constructor(kind):
    box = box_mesh((1.0, 1.0, 1.0), (3, 2, 4), kind)
    mesh = Mesh(box.nodes, box.cells, kind, box.node_sets, box.face_sets)
    assert np.array_equal(mesh.boundary_faces(), box.boundary_faces())


def test_arrays_are_read_only_copies_of_what_was_given():
    box = box_mesh((1.0, 1.0, 1.0), (1, 1, 1))
    nodes, cells, ids = box.nodes.astype(np.float32), box.cells.astype(np.int32), [0, 1]
    mesh = Mesh(nodes, cells.tolist(), "hex8", node_sets={"a": ids})
    nodes[0, 0] = 99.0
    assert mesh.nodes[0, 0] == 0.0
    assert mesh.nodes.dtype == np.float64
    assert mesh.cells.dtype == np.int64
    for array in (mesh.nodes, mesh.cells, mesh.node_sets["a"], mesh.boundary_faces(), mesh.cell_volumes()):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    with pytest.raises(TypeError):
        mesh.node_sets["b"] = np.array([1])


def test_faces_of_a_node_set_are_those_with_all_nodes_inside():
    box = box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
    mesh = box.with_sets(node_sets={"bottom": np.flatnonzero(box.nodes[:, 2] == 0.0)})
    assert sorted(map(sorted, mesh.faces_of("bottom").tolist())) == sorted(map(sorted, mesh.faces_of("zmin").tolist()))
    assert np.array_equal(mesh.nodes_of("bottom"), mesh.nodes_of("zmin"))


def test_union_of_sets_has_no_doubles():
    mesh = box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
    assert len(mesh.faces_of(["xmin", "zmin", "xmin"])) == 8
    assert len(mesh.nodes_of(["xmin", "zmin"])) == 9 + 9 - 3
    assert len(mesh.faces_of(SIDES)) == len(mesh.boundary_faces())


@pytest.mark.parametrize("kind", KINDS)
def test_faces_of_a_set_are_turned_outward_and_inner_faces_left_out(kind):
    box = box_mesh((1.0, 1.0, 1.0), (2, 2, 2), kind)
    outer = {frozenset(face) for face in box.boundary_faces().tolist()}
    table = np.array([face + face[2:] * (kind == "wedge6" and len(face) == 3) for face in ELEMENTS[kind].faces])
    all_faces = box.cells[:, table].reshape(-1, table.shape[1])
    inner = np.array([face for face in all_faces if frozenset(face.tolist()) not in outer])
    mesh = box.with_sets(face_sets={"mixed": np.concatenate([inner, box.face_sets["zmax"][:, ::-1]])})
    assert np.array_equal(mesh.faces_of("mixed"), box.faces_of("zmax"))


def test_a_name_may_be_both_a_node_set_and_a_face_set():
    box = box_mesh((1.0, 1.0, 1.0), (1, 1, 1))
    mesh = box.with_sets(node_sets={"zmin": [7]})
    assert len(mesh.faces_of("zmin")) == 1
    assert mesh.nodes_of("zmin").tolist() == [0, 1, 2, 3, 7]


def test_motions_keep_volumes_sets_and_boundary():
    mesh = bent("tet4")
    turned = mesh.rotated(((1.0, 2.0, 3.0), 0.7), about=(5.0, 0.0, 1.0)).translated((1.0, -2.0, 30.0))
    assert turned.cell_volumes() == pytest.approx(mesh.cell_volumes(), rel=1e-11)
    assert np.array_equal(turned.boundary_faces(), mesh.boundary_faces())
    assert np.array_equal(turned.faces_of("xmin"), mesh.faces_of("xmin"))
    assert mesh.scaled(1e-3).cell_volumes() == pytest.approx(1e-9 * mesh.cell_volumes(), rel=1e-12)


def test_rotation_is_right_handed_about_its_point():
    mesh = box_mesh((1.0, 1.0, 1.0), (1, 1, 1), origin=(2.0, 0.0, 0.0))
    quarter = mesh.rotated(((0.0, 0.0, 5.0), np.pi / 2), about=(2.0, 0.0, 0.0))
    assert quarter.nodes[1] == pytest.approx([2.0, 1.0, 0.0], abs=1e-15)
    matrix = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    assert mesh.rotated(matrix, about=(2.0, 0.0, 0.0)).nodes == pytest.approx(quarter.nodes, abs=1e-15)


def test_copies_and_pickles_are_the_same_mesh():
    mesh = box_mesh((1.0, 2.0, 1.0), (2, 1, 1), "tet4")
    for twin in (pickle.loads(pickle.dumps(mesh)), copy.deepcopy(mesh)):
        assert np.array_equal(twin.nodes, mesh.nodes)
        assert np.array_equal(twin.faces_of("ymax"), mesh.faces_of("ymax"))


def test_repr_is_short_and_names_the_sets():
    text = repr(box_mesh((1.0, 1.0, 1.0), (2, 2, 2)))
    assert text == "Mesh(8 hex8 cells, 27 nodes, sets: xmin, xmax, ymin, ymax, zmin, zmax)"


def test_a_hex_with_a_flat_corner_is_usable():
    """Wedge-like: corner 1 lies on the line from 0 to 2, so its Jacobian is zero; inside it is positive."""
    nodes = box_mesh((1.0, 1.0, 1.0), (1, 1, 1)).nodes.copy()
    nodes[1, :2] = nodes[5, :2] = 0.5
    cells = box_mesh((1.0, 1.0, 1.0), (1, 1, 1)).cells
    assert nodes[cells[0, 1]].tolist() == [0.5, 0.5, 0.0]
    assert Mesh(nodes, cells, "hex8").cell_volumes() == pytest.approx([0.5])


def test_face_keys_tell_all_faces_of_a_mesh_apart():
    """Brute force against the keys: equal keys if and only if equal corners."""
    from tcontact.mesh.geometry import face_keys

    faces = np.array(list(combinations(range(14), 4)))
    assert len(np.unique(face_keys(faces, 14))) == len(faces)
    assert np.array_equal(face_keys(faces, 14), face_keys(faces[:, ::-1], 14))
