"""Rows of pairs of bodies: weights against exact linear fields, areas, numpy quadrature; search against brute force."""

from dataclasses import replace

import numpy as np
import pytest
from oracle import meshes
from pair_scenes import soft

import tcontact as tc
from tcontact.contact.pairs import coupling
from tcontact.contact.pairs.coupling import DROPPED, _dual, couple, integrals
from tcontact.contact.pairs.search import close_faces
from tcontact.contact.pairs.surfaces import area_vectors, facings_of, surfaces_of
from tcontact.kernels import pair_places as at


def facing_of(kind, other, turn, shift, motion):
    """Return the facing of two blocks, and the positions of their nodes; the upper one is the slave."""
    above = tc.box_mesh((1, 1, 1), (4, 4, 4), kind, origin=(-0.5, -0.5, 0.0)).rotated(((0, 0, 1), np.radians(turn)))
    above = above.translated((*shift, 0.0))
    below = tc.box_mesh((2, 2, 1), (5, 5, 5), other, origin=(-1.0, -1.0, -1.0))
    above, below = (mesh.rotated(motion).translated((3.0, -2.0, 1.0)) for mesh in (above, below))
    bodies = [tc.Body(above, soft(), contact="zmin", name="up"), tc.Body(below, soft(), contact="zmax", name="low")]
    scene = tc.Scene(bodies, duration=1.0, pairs=[tc.Pair("up", "low", slave="up")])
    domain = tc.plan(scene).domains[0]
    return facings_of(domain, surfaces_of(domain))[0], domain.reference


def rows_of(facing, positions):
    return couple(facing, positions, close_faces(facing, positions))


def summed(rows, values):
    """Return sum of P times values of the masters for every row."""
    weights = rows.weights if values.ndim == 1 else rows.weights[:, None]
    return np.add.reduceat(weights * values[rows.masters], rows.first[:-1])


KINDS = [("hex8", "hex8"), ("tet4", "tet4"), ("hex8", "tet4"), ("wedge6", "hex8")]


@pytest.mark.parametrize(("kind", "other"), KINDS)
@pytest.mark.parametrize("turn", [0.0, 17.0, 41.0])
def test_rows_reproduce_linear_fields_where_the_slave_is_covered(kind, other, turn, taichi):
    facing, positions = facing_of(kind, other, turn, (0.0, 0.0), meshes.rotation(5))
    rows = rows_of(facing, positions)
    assert len(rows.slaves) == 25
    assert np.abs(summed(rows, np.ones(len(positions))) - 1.0).max() <= 1e-13
    field = positions @ np.array([1.3, -0.7, 0.2]) + 0.4
    assert np.abs(summed(rows, field) - field[rows.slaves]).max() <= 1e-12
    assert abs(rows.area.sum() - 1.0) <= 1e-13


@pytest.mark.parametrize(("kind", "other"), KINDS[:2])
def test_rows_reproduce_linear_fields_where_the_slave_is_partly_covered(kind, other, taichi):
    random = np.random.default_rng(3)
    for _ in range(8):
        shift = random.uniform(0.6, 1.3, 2)
        facing, positions = facing_of(kind, other, random.uniform(0.0, 90.0), shift, meshes.rotation(5))
        rows = rows_of(facing, positions)
        if len(rows.slaves):
            assert np.abs(summed(rows, np.ones(len(positions))) - 1.0).max() <= 1e-9
            field = positions @ np.array([1.3, -0.7, 0.2]) + 0.4
            assert np.abs(summed(rows, field) - field[rows.slaves]).max() <= 1e-8


def test_rows_reproduce_linear_fields_on_distorted_faces(taichi):
    """The shape functions at a point of a face that is no parallelogram come from Newton's method."""
    facing, positions = facing_of("hex8", "hex8", 17.0, (0.0, 0.0), np.eye(3))
    random = np.random.default_rng(4)
    shaken = positions + random.uniform(-0.06, 0.06, positions.shape) * (1.0, 1.0, 0.0)
    rows = rows_of(facing, shaken)
    assert len(rows.slaves) == 25
    field = shaken @ np.array([1.3, -0.7, 0.2]) + 0.4
    assert np.abs(summed(rows, field) - field[rows.slaves]).max() <= 1e-12
    covered = np.linalg.norm(area_vectors(shaken, facing.slave.faces), axis=1).sum()
    assert abs(rows.area.sum() - covered) <= 1e-12


def test_nodes_with_hardly_any_cover_have_no_row(taichi):
    """A strip of 1e-4 of the upper block is over the lower one: the nodes at its far side would get 1e-8 of a face."""
    facing, positions = facing_of("hex8", "hex8", 0.0, (1.4999, 0.0), np.eye(3))
    rows = rows_of(facing, positions)
    assert len(rows.slaves) == 5
    whole = np.array([0.5, 1.0, 1.0, 1.0, 0.5]) * 0.25 * 0.125
    assert (np.sort(rows.area) >= DROPPED * np.sort(whole)).all()


def stack_of(gap, layers=5, beside=None):
    """Return the facing of a block above one of so many layers, with this gap; beside: lower by that under x > .1."""
    above = tc.box_mesh((1, 1, 1), (4, 4, 4), origin=(-0.5, -0.5, gap))
    parts = [(above, "zmin", "up"), (tc.box_mesh((2, 2, 1), (5, 5, layers), origin=(-1.9, -1.0, -1.0)), "zmax", "low")]
    if beside is not None:
        parts.append((tc.box_mesh((2, 2, 1), (5, 5, layers), origin=(0.1, -1.0, -1.0 - beside)), "zmax", "beside"))
    bodies = [tc.Body(mesh, soft(), contact=side, name=name) for mesh, side, name in parts]
    pairs = [tc.Pair("up", name, slave="up") for _, _, name in parts[1:]]
    domain = tc.plan(tc.Scene(bodies, duration=1.0, pairs=pairs)).domains[0]
    return facings_of(domain, surfaces_of(domain))[0], domain.reference


@pytest.mark.parametrize(("layers", "reach"), [(5, 0.0625), (10, 0.04)])
def test_rows_reach_a_quarter_of_a_face_and_less_above_thin_cells(layers, reach, taichi):
    for gap, there in ((0.95 * reach, True), (1.05 * reach, False)):
        rows = rows_of(*stack_of(gap, layers))
        assert (len(rows.slaves) > 0) == there


def test_a_face_is_not_coupled_with_one_far_below_beside_a_near_one(taichi):
    """The faces over the edge of the near block cover the far one too, which the search finds."""
    facing, positions = stack_of(0.02, 10, beside=0.12)
    pairs = close_faces(facing, positions)
    assert (positions[facing.master_faces[pairs[:, 1]], 2] < -0.1).any()
    rows = couple(facing, positions, pairs)
    assert len(rows.slaves) == 20  # those of the faces over x < .1
    assert np.abs(positions[rows.masters, 2]).max() <= 1e-12


def test_beyond_the_largest_weight_a_face_has_ordinary_shape_functions(monkeypatch, taichi):
    monkeypatch.setattr(coupling, "LARGEST_WEIGHT", 0.0)
    facing, positions = facing_of("hex8", "hex8", 17.0, (0.0, 0.0), np.eye(3))
    rows = rows_of(facing, positions)
    assert rows.weights.min() > -1e-15
    assert np.abs(summed(rows, np.ones(len(positions))) - 1.0).max() <= 1e-13


def test_the_normal_of_a_row_weighs_the_faces_by_their_area(taichi):
    facing, positions = facing_of("tet4", "hex8", 17.0, (0.0, 0.0), meshes.rotation(2))
    random = np.random.default_rng(1)
    positions = positions + 0.02 * random.uniform(-1.0, 1.0, positions.shape)
    rows = rows_of(facing, positions)
    assert np.abs(rows.face_weights + np.linalg.norm(area_vectors(positions, rows.faces), axis=1)).max() <= 1e-15


def test_a_part_of_a_face_with_three_corners_has_independent_shape_functions(taichi):
    """Three points would leave the integrals of N N^t of a quadrilateral singular."""
    slave = np.array([[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]], dtype=float)
    master = np.array([[[-0.1, 0.9, 0.1], [0.9, -0.1, 0.1], [-0.1, -0.1, 0.1], [-0.1, -0.1, 0.1]]])
    found = integrals(slave, master, np.array([[0, 0]]))
    products = np.linalg.eigvalsh(found[0, :16].reshape(4, 4))
    assert abs(found[0, at.COMMON_AREA] - 0.5 * 0.8**2) <= 1e-14
    assert products[0] > 1e-4 * products[-1]


def numpy_integrals(slave, master, count=400):
    """Integrate by brute force: midpoints of a fine grid in the plane z = 0 that lie in both faces."""
    ticks = (np.arange(count) + 0.5) / count
    a, b = np.meshgrid(ticks, ticks, indexing="ij")
    low, high = slave.min(axis=0), slave.max(axis=0)
    points = np.stack([low[0] + a * (high[0] - low[0]), low[1] + b * (high[1] - low[1])], axis=-1).reshape(-1, 2)
    inside = np.ones(len(points), dtype=bool)
    for face, sign in ((slave, 1.0), (master, -1.0)):
        for i in range(4):
            p, q = face[i, :2], face[(i + 1) % 4, :2]
            inside &= sign * ((q[0] - p[0]) * (points[:, 1] - p[1]) - (q[1] - p[1]) * (points[:, 0] - p[0])) >= 0.0
    points = points[inside]
    cell = (high[0] - low[0]) * (high[1] - low[1]) / count**2
    shapes = []
    for face in (slave, master):
        origin, one, two = face[0, :2], face[1, :2] - face[0, :2], face[3, :2] - face[0, :2]  # parallelograms
        local = np.linalg.solve(np.stack([one, two], axis=1), (points - origin).T)
        r, s = local
        shapes.append(np.stack([(1 - r) * (1 - s), r * (1 - s), r * s, (1 - r) * s], axis=1))
    return shapes[0].T @ shapes[0] * cell, shapes[0].T @ shapes[1] * cell, len(points) * cell


def test_integrals_match_brute_force(taichi):
    slave = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    turn = np.array([[0.9, -0.4], [0.4, 0.9]])
    corners = np.array([[-0.4, -0.3], [0.5, -0.3], [0.5, 0.6], [-0.4, 0.6]]) @ turn.T + (0.7, 0.4)
    master = np.concatenate([corners[::-1], np.full((4, 1), 0.05)], axis=1)
    found = integrals(slave[None], master[None], np.array([[0, 0]]))[0]
    own, mixed, area = numpy_integrals(slave, master)
    assert abs(found[at.COMMON_AREA] - area) <= 1e-2 * area
    assert np.abs(found[:16].reshape(4, 4) - own).max() <= 1e-2 * own.max()
    assert np.abs(found[16:32].reshape(4, 4) - mixed).max() <= 1e-2 * own.max()
    assert abs(found[at.DISTANCE] - 0.05) <= 1e-14


def test_the_search_finds_every_pair_of_faces_that_overlaps(taichi):
    """Brute force over all pairs of faces finds no covered area outside the list."""
    facing, positions = facing_of("hex8", "tet4", 29.0, (0.3, 0.7), meshes.rotation(8))
    found = close_faces(facing, positions)
    every = np.stack(
        np.meshgrid(np.arange(len(facing.slave.faces)), np.arange(len(facing.master_faces)), indexing="ij"), axis=-1
    ).reshape(-1, 2)
    areas = integrals(positions[facing.slave.faces], positions[facing.master_faces], every)[:, at.COMMON_AREA]
    wanted = {tuple(pair) for pair in every[areas > 0.0]}
    assert wanted
    assert wanted <= {tuple(pair) for pair in found}
    assert len(found) < 0.5 * len(every)


def test_faces_with_parallel_normals_are_no_candidates(taichi):
    facing, positions = facing_of("hex8", "hex8", 0.0, (0.0, 0.0), np.eye(3))
    turned = replace(facing, master_faces=facing.master_faces[:, ::-1])
    assert len(close_faces(facing, positions))
    assert not len(close_faces(turned, positions))


def test_a_sharp_slave_node_takes_the_normal_of_a_flat_master(taichi):
    """The normal of an edge of the slave is that of the master it presses on, that of a flat node its own."""
    bodies = [
        tc.Body(tc.box_mesh((1, 1, 1), (3, 3, 3)).rotated(((1, 0, 0), np.radians(20.0))), soft(),
                contact=("zmin", "ymin"), name="up"),
        tc.Body(tc.box_mesh((3, 3, 1), (5, 5, 2), origin=(-1, -1.5, -1.001)), soft(), contact="zmax", name="low"),
    ]  # fmt: skip
    scene = tc.Scene(bodies, duration=1.0, pairs=[tc.Pair("up", "low", slave="up")])
    domain = tc.plan(scene).domains[0]
    facing, positions = facings_of(domain, surfaces_of(domain))[0], domain.reference
    rows = rows_of(facing, positions)
    lowest = positions[rows.slaves, 2] < 1e-9
    assert lowest.any()
    assert np.abs(normals_of(rows, positions)[lowest] - (0, 0, 1)).max() <= 1e-12


def normals_of(rows, positions):
    """Return the unit normals of the rows."""
    vectors = area_vectors(positions, rows.faces)
    vectors *= (rows.face_weights / np.linalg.norm(vectors, axis=1))[:, None]
    normals = np.add.reduceat(vectors, rows.first_face[:-1])
    return normals / np.linalg.norm(normals, axis=1)[:, None]


def test_edges_that_lie_flush_press_along_the_faces_that_touch(taichi):
    """The sides of two blocks, which touch nothing, do not tilt the normals of the edges that they share with them."""
    sides = ("xmin", "xmax", "ymin", "ymax")
    bodies = [
        tc.Body(tc.box_mesh((1, 1, 1), (3, 3, 3), origin=(0, 0, 0.001)), soft(), contact=("zmin", *sides), name="up"),
        tc.Body(tc.box_mesh((1, 1, 1), (4, 4, 3), origin=(0, 0, -1)), soft(), contact=("zmax", *sides), name="low"),
    ]
    scene = tc.Scene(bodies, duration=1.0, pairs=[tc.Pair("up", "low", slave="up")])
    domain = tc.plan(scene).domains[0]
    rows = rows_of(facings_of(domain, surfaces_of(domain))[0], domain.reference)
    assert len(rows.slaves) == 16
    assert np.abs(normals_of(rows, domain.reference) - (0, 0, 1)).max() <= 1e-12


def test_a_face_whose_cover_is_singular_to_rounding_has_ordinary_shape_functions():
    """All points of integration in one place leave int N N^t with one eigenvalue that is not 0."""
    n = np.array([0.1, 0.2, 0.3, 0.4])
    products = np.stack([np.outer(n, n), np.diag(n)])
    dual, areas = _dual(products)
    assert np.array_equal(dual[0], np.eye(4))
    assert np.abs(dual[1] @ products[1] - np.diag(areas[1])).max() <= 1e-15
