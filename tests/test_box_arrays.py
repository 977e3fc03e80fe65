"""A box mesh tells by its coordinates along the axes what its arrays would, and makes these when they are read."""

import copy
import dataclasses
import pickle

import numpy as np
import pytest

import tcontact as tc
from tcontact.cases import cube_impact
from tcontact.mesh.geometry import surface
from tcontact.mesh.late_rows import LateRows
from tcontact.mesh.mesh import Mesh
from tcontact.planning.planning import plan

KINDS = ("hex8", "tet4", "wedge6")


def made(mesh):
    """Names of the arrays of all nodes or cells that a mesh has."""
    return {"nodes", "cells", "blocks", "_volumes"} & vars(mesh).keys()


def box(kind="hex8"):
    """A box whose edges differ along all axes."""
    return tc.box_mesh((0.3, 0.2, 0.7), (4, 3, 5), kind, origin=(0.1, -0.3, 2.0))


def plain(mesh):
    """Return the same mesh made of its arrays, which it checks and measures."""
    return Mesh(mesh.nodes, mesh.cells, mesh.kind, mesh.node_sets, mesh.face_sets, mesh.cell_sets)


@pytest.mark.parametrize("kind", KINDS)
def test_a_box_is_planned_without_arrays_of_its_nodes_and_cells(kind):
    """Then its plan is that of the same nodes and cells in arrays, to the bit."""
    mesh, plans = box(kind), []
    for one in (mesh, plain(box(kind))):
        held = [tc.Support("zmax", "xy")]
        body = tc.Body(one, tc.NeoHookean(1e7, 0.3, 1e3), (0.0, 0.0, -1.0), contact="zmin", supports=held)
        scene = tc.Scene([body], [tc.Plane((0.0, 0.0, 1.99))], 1e-3, contact=tc.MasslessContact())
        plans.append(plan(scene).bodies[0])
    late, known = plans
    assert not made(mesh)
    assert isinstance(late.rows, LateRows)
    assert isinstance(late.places, LateRows)
    some = np.array([[5, 0], [7, 5]])
    assert np.array_equal(late.places[some], known.places[some])
    assert np.array_equal(late.rows[2:9:3], known.rows[2:9:3])
    assert np.array_equal(late.rows[some[0], :3], known.rows[some[0], :3])
    assert len(late.rows[:0]) == 0
    for few in (3, -2, [-1, 0], known.places[:, 2] > 2.3):
        assert np.array_equal(late.places[few], known.places[few])
    assert late.rows.late
    assert late.places.late
    for name in ("node_order", "cell_order", "reference", "cells", "lumped", "boundary", "tensors", "inverses"):
        one, other = getattr(late, name), getattr(known, name)
        assert np.array_equal(one, other)
        assert one.dtype == other.dtype
    assert late.blocks[0].variant == known.blocks[0].variant
    assert late.cells is late.rows.whole is late.blocks[0].cells  # one array
    assert np.array_equal(pickle.loads(pickle.dumps(late.rows)), known.cells)


@pytest.mark.parametrize("kind", KINDS)
def test_a_box_tells_without_arrays_what_its_arrays_tell(kind):
    for mesh in (box(kind), box(kind).translated((1.0, 0.1, -3.0)).scaled(1.7), pickle.loads(pickle.dumps(box(kind)))):
        chosen = np.array([[0, 7, 60], [119, 3, 8]])
        told = [mesh.nodes_at(chosen), *mesh.bounds, mesh.shortest_edge, mesh.size, mesh.node_count, mesh.cell_count]
        told += [mesh.cell_counts, repr(mesh), mesh.boundary_faces(), mesh.faces_of("ymax"), mesh.nodes_of("zmin")]
        portions = [np.concatenate(list(mesh.portions(name))) for name in ("nodes", "cells")]
        some = np.array([0, 1, 3, 57, mesh.cell_count - 1])
        (of_kind, cells), none = mesh.chosen_cells(some)[0], mesh.chosen_cells(some[:0])
        each = np.concatenate([rows for one, rows in mesh.cell_portions if one == kind])
        assert not made(mesh)
        assert (of_kind, none) == (kind, ())
        assert np.array_equal(cells, mesh.cells[some])
        assert np.array_equal(each, mesh.cells)
        assert np.array_equal(mesh.chosen_cells(some)[0][1], cells)
        one = plain(mesh)
        known = [one.nodes[chosen], *one.bounds, one.shortest_edge, one.size, one.node_count, one.cell_count]
        known += [one.cell_counts, repr(one), one.boundary_faces(), one.faces_of("ymax"), one.nodes_of("zmin")]
        for a, b in zip([*told, *portions], [*known, one.nodes, one.cells], strict=True):
            assert np.array_equal(a, b)


@pytest.mark.parametrize("kind", KINDS)
def test_the_surface_of_a_box_is_that_of_its_cells(kind):
    mesh = box(kind)
    known = surface(mesh.blocks, mesh.node_count)
    assert {tuple(sorted(face)) for face in known.faces.tolist()} == {
        tuple(sorted(face)) for face in mesh.boundary_faces().tolist()
    }
    assert np.array_equal(known.keys, mesh._surface.keys)


def test_arrays_of_a_box_are_kept_until_they_are_released_and_made_again():
    mesh = box()
    before = mesh.cells
    assert mesh.cells is before
    assert not before.flags.writeable
    mesh.release()
    assert not made(mesh)
    assert np.array_equal(mesh.cells, before)


def test_a_plan_keeps_no_cells_in_the_numbering_of_the_user():
    mesh = box()
    body = tc.Body(mesh, tc.NeoHookean(1e7, 0.3, 1000.0), velocity=(0.0, 0.0, -1.0), contact="zmin")
    scene = tc.Scene([body], [tc.Plane((0.0, 0.0, mesh.bounds[0][2] - 1e-3))], 1e-3, contact=tc.MasslessContact())
    assert len(tc.plan(scene).bodies[0].cells) == mesh.cell_count
    assert "cells" not in vars(mesh)


def test_sets_and_copies_of_a_box_make_no_arrays_and_other_nodes_make_a_mesh():
    mesh = box().with_sets(node_sets={"two": [1, 2]}, cell_sets={"one": [3]})
    same = copy.deepcopy(mesh)
    assert not made(mesh)
    assert not made(same)
    assert same.node_sets["two"].tolist() == [1, 2]
    bent = dataclasses.replace(mesh, nodes=mesh.nodes + 0.01 * np.sin(9.0 * mesh.nodes))
    assert type(bent) is Mesh
    assert bent.cell_sets["one"].tolist() == [3]


def test_a_box_turned_by_nothing_makes_no_arrays_and_else_it_is_turned_as_any_mesh_is():
    mesh = box()
    assert mesh.rotated(np.eye(3), about=(1.0, 2.0, 3.0)) is mesh
    assert mesh.rotated(((0.0, 0.0, 1.0), 0.0)) is mesh
    assert not made(mesh)
    turn = ((0.0, 0.0, 1.0), np.pi / 2.0)
    assert np.array_equal(mesh.rotated(turn).nodes, plain(mesh).rotated(turn).nodes)
    with pytest.raises(tc.InputError, match="about"):
        mesh.rotated(np.eye(3), about=(1.0, 2.0))


def test_the_flat_cube_of_the_main_case_makes_no_arrays():
    mesh = cube_impact.scene(cells=3).bodies[0].mesh
    assert not made(mesh)
    assert type(cube_impact.scene(cells=3, pitch=45.0).bodies[0].mesh) is Mesh


def test_a_box_that_rounding_would_damage_is_refused_as_any_mesh_is():
    for mesh in (box(), plain(box())):
        with pytest.raises(tc.InputError, match="lose their shape in rounding"):
            mesh.translated((1e16, 0.0, 0.0))
    assert np.array_equal(box().translated((1e6, 0.0, 0.0)).nodes, plain(box()).translated((1e6, 0.0, 0.0)).nodes)


def test_a_body_of_a_box_under_a_plane_makes_no_arrays():
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (3, 3, 3))
    body = tc.Body(mesh, tc.NeoHookean(1e7, 0.3, 1000.0), velocity=(0.0, 0.0, -1.0), contact="zmin")
    tc.Scene([body], [tc.Plane()], 1e-3, contact=tc.MasslessContact())
    assert not made(mesh)


def test_a_body_inside_a_plane_is_refused_with_its_lowest_node():
    body = tc.Body(box().translated((0.0, 0.0, -2.1)), tc.NeoHookean(1e7, 0.3, 1000.0), contact="zmin")
    with pytest.raises(tc.InputError, match=r"node 0 starts 0\.1 inside obstacle"):
        tc.Scene([body], [tc.Plane()], 1e-3, contact=tc.MasslessContact())


@pytest.mark.parametrize("wrong", [-1, 120, 0.5, ["a"], [[0, 120]], None])
def test_numbers_of_no_nodes_are_refused_by_name(wrong):
    assert box().node_count == 120
    for mesh in (box(), plain(box())):
        assert mesh.nodes_at([]).shape == (0, 3)
        with pytest.raises(tc.InputError, match=r"numbers = .*from 0 to 119"):
            mesh.nodes_at(wrong)
