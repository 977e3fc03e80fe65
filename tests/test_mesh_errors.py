"""Bad meshes are refused, naming field, value and remedy."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import tcontact as tc
from tcontact.base.errors import InputError
from tcontact.base.warning_kinds import MeshWarning
from tcontact.mesh.box import box_mesh
from tcontact.mesh.mesh import Mesh

HEX = box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
TET = box_mesh((1.0, 1.0, 1.0), (1, 1, 1), "tet4")
NAN_NODES = HEX.nodes.copy()
NAN_NODES[[5, 7], 1] = np.nan, np.inf


def with_cell(number, corners, mesh=HEX):
    cells = mesh.cells.copy()
    cells[number] = corners
    return cells


def with_node(number, position, mesh=HEX):
    nodes = mesh.nodes.copy()
    nodes[number] = position
    return nodes


BAD = {
    "kind unknown": (lambda: Mesh(HEX.nodes, HEX.cells, "hex20"), "kind", "hex8"),
    "kind no string": (lambda: Mesh(HEX.nodes, HEX.cells, ["hex8"]), "kind", "hex8"),
    "nodes in the plane": (lambda: Mesh(HEX.nodes[:, :2], HEX.cells, "hex8"), "nodes", "[n, 3]"),
    "nodes flat": (lambda: Mesh(HEX.nodes.ravel(), HEX.cells, "hex8"), "nodes", "[n, 3]"),
    "nodes missing": (lambda: Mesh(None, HEX.cells, "hex8"), "nodes", "[n, 3]"),
    "nodes words": (lambda: Mesh([["a", "b", "c"]], HEX.cells, "hex8"), "nodes", "[n, 3]"),
    "nodes ragged": (lambda: Mesh([[0.0, 1.0, 2.0], [1.0]], HEX.cells, "hex8"), "nodes", "[n, 3]"),
    "nodes complex": (lambda: Mesh(HEX.nodes + 1j, HEX.cells, "hex8"), "nodes", "[n, 3]"),
    "nodes empty": (lambda: Mesh(np.zeros((0, 3)), HEX.cells, "hex8"), "nodes", "at least one cell"),
    "nodes NaN": (lambda: Mesh(NAN_NODES, HEX.cells, "hex8"), "nodes", "node 5 (2 of 27 such)"),
    "nodes huge": (lambda: Mesh(HEX.nodes * 1e200, HEX.cells, "hex8"), "nodes", "near the origin"),
    "cells empty": (lambda: Mesh(HEX.nodes, np.zeros((0, 8), int), "hex8"), "cells", "at least one cell"),
    "cells of other kind": (lambda: Mesh(HEX.nodes, HEX.cells, "tet4"), "cells", "4 corners"),
    "cells fractional": (lambda: Mesh(HEX.nodes, HEX.cells + 0.5, "hex8"), "cells", "whole numbers"),
    "cells NaN": (lambda: Mesh(HEX.nodes, HEX.cells * np.nan, "hex8"), "cells", "whole numbers"),
    "cells mask": (lambda: Mesh(HEX.nodes, HEX.cells > 3, "hex8"), "cells", "integer array"),
    "cells from 1": (lambda: Mesh(HEX.nodes, HEX.cells + 1, "hex8"), "cells", "from 0 to 26"),
    "cells negative": (lambda: Mesh(HEX.nodes, HEX.cells - 1, "hex8"), "cells", "cell 0 [-1"),
    "node twice": (lambda: Mesh(HEX.nodes, with_cell(3, [0, 1, 2, 2, 4, 5, 6, 7]), "hex8"), "cells", "twice"),
    "cell twice": (
        lambda: Mesh(HEX.nodes, np.r_[HEX.cells, HEX.cells[2:3, ::-1]], "hex8"),
        "cells",
        "remove the double",
    ),
    "orphan node": (lambda: Mesh(np.r_[HEX.nodes, [[9.0, 9.0, 9.0]]], HEX.cells, "hex8"), "nodes", "node 27"),
    "hex tangled among mirrored": (
        lambda: Mesh(HEX.nodes * [1, 1, -1], with_cell(6, HEX.cells[6][[0, 1, 3, 2, 4, 5, 7, 6]]), "hex8"),
        "cells",
        "cell 6 [12, 13, 15, 16",
    ),
    "hex flat at a point, mirrored": (
        lambda: Mesh(with_node(0, [0.3, 0.3, 0.3]) * [1, 1, -1], HEX.cells, "hex8"),
        "cells",
        "VTK order",
    ),
    "hex wrong order": (
        lambda: Mesh(HEX.nodes, HEX.cells[:, [0, 1, 3, 2, 4, 5, 7, 6]], "hex8"),
        "cells",
        "inverted",
    ),
    "hex corner inverted": (lambda: Mesh(with_node(0, [0.2, 0.2, 0.2]), HEX.cells, "hex8"), "cells", "inverted"),
    "hex flat": (lambda: Mesh(HEX.nodes * [1, 1, 0], HEX.cells, "hex8"), "cells", "no volume"),
    "tet flat": (lambda: Mesh(np.c_[np.eye(4)[:, :2], np.zeros(4)], [[0, 1, 2, 3]], "tet4"), "cells", "no volume"),
    "tet flat but for rounding": (
        lambda: Mesh([[0, 0, 0], [0.1, 0.2, 0.3], [0.3, 0.1, 0.2], [0.4, 0.3, 0.5 + 1e-15]], [[0, 1, 2, 3]], "tet4"),
        "cells",
        "no volume",
    ),
    "three cells on a face": (
        lambda: Mesh(
            [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.1, 0.1, 2], [0.2, 0.2, 3]],
            [[0, 1, 2, 3], [0, 1, 2, 4], [0, 1, 2, 5]],
            "tet4",
        ),
        "cells",
        "more than two cells",
    ),
    "node_sets no dict": (lambda: Mesh(HEX.nodes, HEX.cells, "hex8", [1, 2]), "node_sets", "dict"),
    "set name no string": (lambda: HEX.with_sets({3: [1]}), "node_sets", "strings"),
    "set name empty": (lambda: HEX.with_sets(face_sets={"": [[0, 1, 4, 3]]}), "face_sets", "strings"),
    "node set too high": (lambda: HEX.with_sets({"a": [1, 27, 30]}), "node_sets['a']", "2 ids are no nodes"),
    "node set negative": (lambda: HEX.with_sets({"a": [-1]}), "node_sets['a']", "from 0 to 26"),
    "node set empty": (lambda: HEX.with_sets({"a": []}), "node_sets['a']", "at least one"),
    "node set mask": (lambda: HEX.with_sets({"a": HEX.nodes[:, 2] == 0}), "node_sets['a']", "flatnonzero"),
    "node set table": (lambda: HEX.with_sets({"a": [[1, 2]]}), "node_sets['a']", "[k]"),
    "face set of triangles": (lambda: HEX.with_sets(face_sets={"a": [[0, 1, 3]]}), "face_sets['a']", "4 corners"),
    "face set of no cell": (
        lambda: HEX.with_sets(face_sets={"a": [[0, 1, 4, 3], [0, 1, 5, 7]]}),
        "face_sets['a']",
        "face 1 [0, 1, 5, 7]",
    ),
    "face set too high": (lambda: HEX.with_sets(face_sets={"a": [[0, 1, 4, 99]]}), "face_sets['a']", "from 0 to 26"),
    "face set fractional": (lambda: HEX.with_sets(face_sets={"a": [[0.5, 1, 4, 3]]}), "face_sets['a']", "whole"),
    "unknown set of faces": (lambda: HEX.faces_of("top"), "set", "xmin, xmax, ymin"),
    "unknown set of nodes": (lambda: HEX.nodes_of(["xmin", "top"]), "set", "zmax"),
    "set of a mesh without sets": (
        lambda: Mesh(HEX.nodes, HEX.cells, "hex8").nodes_of("top"),
        "set",
        "mesh.with_sets(",
    ),
    "set number": (lambda: HEX.faces_of(3), "set", "xmin"),
    "no set named": (lambda: HEX.faces_of([]), "set", "xmin"),
    "set inside": (lambda: HEX.with_sets({"middle": [13]}).faces_of("middle"), "set", "on the surface"),
    "face set inside": (
        lambda: HEX.with_sets(face_sets={"cut": [[4, 5, 14, 13]]}).faces_of("cut"),
        "set",
        "on the surface",
    ),
    "moved by NaN": (lambda: HEX.translated((0.0, np.nan, 0.0)), "offset", "finite"),
    "moved in the plane": (lambda: HEX.translated((0.0, 1.0)), "offset", "finite"),
    "moved too far": (lambda: HEX.translated((1e30, 0.0, 0.0)), "offset", "nearer the origin"),
    "scaled by zero": (lambda: HEX.scaled(0.0), "factor", "greater than 0"),
    "scaled by a mirror": (lambda: HEX.scaled(-1.0), "factor", "greater than 0"),
    "scaled away": (lambda: HEX.scaled(1e-200), "factor", "nearer"),
    "turned about nothing": (lambda: HEX.rotated(((0.0, 0.0, 0.0), 1.0)), "rotation axis", "not zero"),
    "turned by NaN": (lambda: HEX.rotated(((0.0, 0.0, 1.0), np.nan)), "rotation angle", "finite"),
    "turned by a mirror": (lambda: HEX.rotated(np.diag([1.0, 1.0, -1.0])), "rotation", "determinant"),
    "turned by a stretch": (lambda: HEX.rotated(2.0 * np.eye(3)), "rotation", "orthonormal"),
    "turned by a number": (lambda: HEX.rotated(0.3), "rotation", "shape [3, 3]"),
    "box size zero": (lambda: box_mesh((1.0, 0.0, 1.0), (1, 1, 1)), "size", "positive"),
    "box size NaN": (lambda: box_mesh((1.0, np.nan, 1.0), (1, 1, 1)), "size", "finite"),
    "box size number": (lambda: box_mesh(1.0, (1, 1, 1)), "size", "shape [3]"),
    "box cells zero": (lambda: box_mesh((1.0, 1.0, 1.0), (1, 0, 1)), "cells", "at least 1"),
    "box cells fractional": (lambda: box_mesh((1.0, 1.0, 1.0), (1, 2.5, 1)), "cells", "whole"),
    "box cells number": (lambda: box_mesh((1.0, 1.0, 1.0), 4), "cells", "three whole numbers"),
    "box cells huge": (lambda: box_mesh((1.0, 1.0, 1.0), (1, 1, 99999999999)), "cells", "use fewer cells"),
    "box cells two": (lambda: box_mesh((1.0, 1.0, 1.0), (4, 4)), "cells", "three whole numbers"),
    "box cells countless": (lambda: box_mesh((1.0, 1.0, 1.0), (10**6,) * 3), "cells", "fewer cells"),
    "box kind": (lambda: box_mesh((1.0, 1.0, 1.0), (1, 1, 1), "pyramid5"), "kind", "tet4"),
    "box origin": (lambda: box_mesh((1.0, 1.0, 1.0), (1, 1, 1), origin=(0.0, np.inf, 0.0)), "origin", "finite"),
    "box too far away": (
        lambda: box_mesh((1.0, 1.0, 1.0), (9, 9, 9), origin=(1e16, 0.0, 0.0)),
        "size, origin",
        "near the origin",
    ),
    "box too small": (lambda: box_mesh((1e-120,) * 3, (1, 1, 1)), "size, origin", "metres"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_mesh_is_refused_with_field_and_remedy(name):
    make, field, words = BAD[name]
    with pytest.raises(InputError) as caught:
        make()
    assert caught.value.field == field
    assert words in f"{caught.value.value} {caught.value.remedy}"
    assert len(caught.value.remedy) > 10


def test_mirrored_cells_are_turned_with_a_warning_at_the_line_of_the_user():
    """All or one of the cells of every kind; sets, numbering and nodes stay, volumes and the skin are those before."""
    for kind in ("hex8", "tet4", "wedge6"):
        mesh = box_mesh((1.0, 2.0, 3.0), (2, 2, 2), kind)
        mirror = list(mesh.element.mirror)
        one = mesh.cells.copy()
        one[3] = one[3][mirror]
        for nodes, cells, count in ((mesh.nodes * [1, 1, -1], mesh.cells, mesh.cell_count), (mesh.nodes, one, 1)):
            with pytest.warns(MeshWarning, match=f"^corners of {count} inverted {kind} cells") as caught:
                turned = Mesh(nodes, cells, kind, face_sets=mesh.face_sets, cell_sets={"a": [3]})
            assert caught[0].filename == __file__
            assert turned.cell_volumes() == pytest.approx(mesh.cell_volumes(), rel=1e-12)
            assert np.array_equal(turned.nodes, nodes)
            assert np.array_equal(np.sort(turned.cells), np.sort(cells))
            for name in mesh.face_sets:
                assert np.array_equal(turned.nodes_of(name), mesh.nodes_of(name))
        assert np.array_equal(turned.cells, mesh.cells)  # turned back


def test_a_motion_turns_no_cell():
    """Cells that lose their shape in rounding are refused by the motion that did it, never turned."""
    with pytest.raises(InputError, match="nearer the origin"):
        TET.translated((0.3e17, 0.0, 0.0))


def test_nodes_in_one_place_that_join_no_cells_are_warned_of_and_the_remedy_joins_them():
    """As a mesh arrives that was written cell by cell."""
    box = tc.box_mesh(size=(2.0, 1.0, 1.0), cells=(2, 1, 1))
    nodes, cells = box.nodes[box.cells].reshape(-1, 3), np.arange(16).reshape(2, 8)
    with pytest.warns(tc.MeshWarning, match="4 nodes have the place of another one"):
        tc.Mesh(nodes, cells, "hex8")
    nodes, number = np.unique(nodes, axis=0, return_inverse=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        joined = tc.Mesh(nodes, number.reshape(-1)[cells], "hex8")
    assert joined.node_count == box.node_count


def test_a_cell_with_two_nodes_in_one_place_is_refused_by_name_where_its_size_counts():
    box = tc.box_mesh(size=(1.0, 1.0, 2.0), cells=(1, 1, 2))
    nodes = box.nodes.copy()
    nodes[11] = nodes[10]
    with pytest.warns(tc.MeshWarning, match="1 node has the place of another one \\(11 that of 10\\)"):
        mesh = tc.Mesh(nodes, box.cells, "hex8", face_sets={"zmin": box.face_sets["zmin"]})
    with pytest.raises(tc.InputError, match="two nodes of a cell are in one place"):
        _ = mesh.shortest_edge
    body = tc.Body(mesh, tc.NeoHookean(young=1e6, poisson=0.3, density=1e3), velocity=(0.0, 0.0, -1.0), contact="zmin")
    with pytest.raises(tc.InputError, match="two nodes of a cell are in one place"):
        tc.simulate(tc.Scene([body], duration=1e-3, obstacles=[tc.Plane((0.0, 0.0, -0.1))]))
