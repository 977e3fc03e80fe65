"""Sets of a `meshio.Mesh`: numbers of nodes and cells, checked before they become sets of a mesh."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

import tcontact as tc

BOX = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
EDGES = np.array([[0, 1], [1, 2]])


def made(cells=(), **sets):
    other = meshio.Mesh(BOX.nodes, [("hexahedron", BOX.cells), *cells])
    for name, given in sets.items():  # as a program sets them: meshio looks at them in its constructor alone
        setattr(other, name, given)
    return tc.Mesh.from_meshio(other)


@pytest.mark.parametrize(
    ("ids", "value", "words"),
    [
        (BOX.nodes[:, 2] > 0.9, "array([False", "for a mask use numpy.flatnonzero(mask)"),
        ([0, -1], "-1", "1 numbers are no nodes; nodes count from 0 to 26"),
        ([0, 1000, 27], "1000", "2 numbers are no nodes"),
        ([0.0, 1.5], "[0.0, 1.5]", "numbers of nodes are whole numbers; give numbers of nodes"),
        ([0.0, np.nan], "nan", "whole numbers"),
        ([[0, 1], [2, 3]], "array of shape (2, 2)", "shape [k]"),
        ([[0, 1], [2]], "[[0, 1], [2]]", "shape [k]"),
        (np.ma.array([0, 1], mask=[False, True]), "masked_array", "give numbers of nodes"),
        (3, "array of shape ()", "shape [k]"),
        (None, "None", "give numbers of nodes"),
        (["a"], "['a']", "give numbers of nodes"),
    ],
)
def test_wrong_point_sets_are_refused(ids, value, words):
    with pytest.raises(tc.InputError) as caught:
        made(point_sets={"good": [0], "s": ids})
    assert caught.value.field == "point_sets['s']"
    assert str(caught.value).startswith("point_sets['s'] = ")
    assert value in str(caught.value)
    assert words in caught.value.remedy


@pytest.mark.parametrize(
    ("members", "field", "words"),
    [
        ([np.arange(8) >= 4, None], "cell_sets['s'][0]", "for a mask use numpy.flatnonzero(mask)"),
        ([[0, 8], None], "cell_sets['s'][0]", "cells of this block (hexahedron) count from 0 to 7"),
        ([[0], [-1]], "cell_sets['s'][1]", "cells of this block (line) count from 0 to 1"),
        ([[0.5], None], "cell_sets['s'][0]", "whole numbers"),
        ([[[0, 1]], None], "cell_sets['s'][0]", "shape [k]"),
        ([3, None], "cell_sets['s'][0]", "shape [k]"),
        ([[0, 1]], "cell_sets['s']", "the cells of each of the 2 blocks, None for a block without any"),
        ([[0, 1], None, None], "cell_sets['s']", "each of the 2 blocks"),
        ({"hexahedron": [0], "line": []}, "cell_sets['s']", "each of the 2 blocks"),
        (None, "cell_sets['s']", "each of the 2 blocks"),
    ],
)
def test_wrong_cell_sets_are_refused(members, field, words):
    with pytest.raises(tc.InputError) as caught:
        made([("line", EDGES)], cell_sets={"s": members})
    assert caught.value.field == field
    assert words in caught.value.remedy


def test_good_sets_of_all_forms_are_taken():
    """Whole floats, unsigned numbers, doubles, lists and None stand for what they say."""
    points = {"a": np.array([2.0, 0.0]), "b": np.array([5, 5, 1], dtype=np.uint64), "c": [3]}
    mesh = made(
        [("line", EDGES)], point_sets=points, cell_sets={"half": [np.array([3, 0, 3]), None], "edge": [[], [1]]}
    )
    assert {name: sorted(ids.tolist()) for name, ids in mesh.node_sets.items()} == {
        "a": [0, 2], "b": [1, 5], "c": [3], "edge": [1, 2],
    }  # fmt: skip
    assert {name: ids.tolist() for name, ids in mesh.cell_sets.items()} == {"half": [0, 3]}


def test_a_point_set_keeps_its_name_from_the_nodes_of_cells():
    mesh = made([("line", EDGES)], point_sets={"fix": [8]}, cell_sets={"fix": [[1], [0, 1]]})
    assert mesh.node_sets["fix"].tolist() == [8]
    assert mesh.cell_sets["fix"].tolist() == [1]


def test_empty_sets_are_left_out_with_a_warning():
    with pytest.warns(tc.MeshWarning, match=r"set '(none|empty)' is left out") as caught:
        mesh = made(point_sets={"empty": []}, cell_sets={"none": [None]})
    assert len(caught) == 2
    assert not {*mesh.node_sets, *mesh.cell_sets}


def test_what_meshio_keeps_of_gmsh_is_no_set():
    """Numbers of entities with a sign, which are no cells."""
    assert not made(cell_sets={"gmsh:bounding_entities": [np.array([-40, 12])]}).cell_sets


def test_masked_sets_of_a_mesh_are_refused():
    with pytest.raises(tc.InputError, match=r"node_sets\['s'\]"):
        BOX.with_sets(node_sets={"s": np.ma.array([0, 1], mask=[False, True])})
