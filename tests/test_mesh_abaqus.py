"""Abaqus input files: sets in all the ways a file may give them."""

from __future__ import annotations

import numpy as np
import pytest
from mesh_files import second_order

from tcontact.base.errors import InputError
from tcontact.base.warning_kinds import MeshWarning
from tcontact.mesh.box import box_mesh
from tcontact.mesh.elements import ELEMENTS
from tcontact.mesh.files.reading import read_mesh

pytestmark = pytest.mark.filterwarnings("ignore:element set 'lump' is left out")
HEXES = """*Heading
 two hexes on top of each other, a shell without a set first
** a comment, with, commas
*Part, name=PART-1
*Node, nset=everything
 10, 0., 0., 0.
 20, 1., 0., 0.
 30, 1., 1., 0.
 40, 0., 1.
*NODE
 50, 0., 0., 1.
 60, 1., 0., 1.
 70, 1., 1., 1.
 80, 0., 1., 1.
 999, 7., 7., 7.
 11, 0., 0., 2.
 21, 1., 0., 2.
 31, 1., 1., 2.
 41, 0., 1., 2.
*Element, type=S4R
 7, 10, 20, 30, 40
*Element, type=MASS, elset=lump
 8, 10
*Element, type=C3D8R, elset=Lower
 1, 10, 20, 30, 40,
    50, 60, 70, 80
*ELEMENT,
TYPE=c3d8, ELSET=upper
 2, 50, 60, 70, 80, 11, 21, 31, 41
*Elset, elset=Both
 lower, UPPER
*Elset, elset=_inner_S2, internal, generate
 2, 2, 1
*Elset, elset=shell
 7,
*Nset, nset=Top, generate
 11, 41, 10
*Nset, nset=Some
 10, 20,
 Top
*Nset, nset=of-lower, elset=Lower
*Surface, type=ELEMENT, name=top
 _inner_S2, S2
*Surface, type=ELEMENT, name=Walls
 both, S3
 2, S4
*Surface, type=NODE, name=points
 Top
 10,
*End Part
"""


def read(tmp_path, text):
    (tmp_path / "part.inp").write_text(text)
    return read_mesh(tmp_path / "part.inp")


def test_hexes_and_all_their_sets(tmp_path):
    mesh = read(tmp_path, HEXES)
    assert mesh.kind == "hex8"
    assert mesh.cell_volumes() == pytest.approx([1.0, 1.0], rel=1e-14)
    assert mesh.bounds[1].tolist() == [1.0, 1.0, 2.0]
    position = {name: mesh.nodes[mesh.nodes_of(name)] for name in [*mesh.node_sets, *mesh.face_sets]}
    assert set(mesh.node_sets) == {"everything", "Top", "Some", "of-lower", "Lower", "upper", "Both", "points"}
    assert set(mesh.face_sets) == {"shell", "top", "Walls"}
    assert (position["everything"][:, 2] == 0.0).all()
    assert len(position["everything"]) == 4
    assert (position["Top"][:, 2] == 2.0).all()
    assert len(position["Some"]) == 6
    assert len(position["points"]) == 5
    assert position["Lower"][:, 2].max() == position["of-lower"][:, 2].max() == 1.0
    assert position["upper"][:, 2].min() == 1.0
    assert len(mesh.nodes_of("Both")) == 12
    assert (mesh.nodes[mesh.faces_of("shell")][:, :, 2] == 0.0).all()
    assert (mesh.nodes[mesh.faces_of("top")][:, :, 2] == 2.0).all()
    walls = mesh.nodes[mesh.faces_of("Walls")]
    assert sorted(walls.mean(axis=1).tolist()) == [[0.5, 0.0, 0.5], [0.5, 0.0, 1.5], [1.0, 0.5, 1.5]]


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_every_face_label_names_the_face_of_the_manual(tmp_path, kind):
    """Corner ids as the Abaqus manual lists them for S1 .. S6 of C3D8 and S1 .. S4 of C3D4."""
    labels = {
        "hex8": ["1234", "5876", "1562", "2673", "3784", "4851"],
        "tet4": ["123", "142", "243", "341"],
    }[kind]
    if kind == "hex8":
        cell = box_mesh((1.0, 1.0, 1.0), (1, 1, 1))
        points = cell.nodes[cell.cells[0]]
    else:
        points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    text = "*NODE\n" + "".join(f"{i}, {x}, {y}, {z}\n" for i, (x, y, z) in enumerate(points, 1))
    text += f"*ELEMENT, TYPE=C3D{len(points)}\n1, " + ", ".join(str(i + 1) for i in range(len(points))) + "\n"
    text += "".join(f"*SURFACE, NAME=F{k}\n1, S{k}\n" for k in range(1, len(labels) + 1))
    mesh = read(tmp_path, text)
    for k, label in enumerate(labels, 1):
        assert sorted(mesh.nodes_of(f"F{k}").tolist()) == sorted(int(c) - 1 for c in label)


def test_a_set_given_twice_grows(tmp_path):
    mesh = read(tmp_path, HEXES + "*NSET, NSET=TOP\n10\n")
    assert len(mesh.nodes_of("Top")) == 5


def test_parts_of_surfaces_without_a_face_are_left_out_with_a_warning(tmp_path):
    with pytest.warns(MeshWarning, match="'odd'"):
        mesh = read(tmp_path, HEXES + "*SURFACE, NAME=odd\n1, S1\n2, END1\n")
    assert len(mesh.faces_of("odd")) == 1


BAD = {
    "no elements": ("*NODE\n1, 0., 0., 0.\n", "*ELEMENT"),
    "no keywords": ("hello\n", "*NODE"),
    "include": ("*INCLUDE, INPUT=other.inp\n", "INCLUDE"),
    "generated nodes": (HEXES + "*NGEN\n1, 9\n", "written out"),
    "cylindrical": ("*NODE, SYSTEM=C\n1, 0., 0., 0.\n", "rectangular"),
    "second order": (HEXES.replace("type=C3D8R", "type=C3D20R"), "other than 20 nodes"),
    "pyramid": ("*NODE\n1, 0.\n*ELEMENT, TYPE=C3D5\n1, 1, 1, 1, 1, 1\n", "C3D5"),
    "unknown solid": (HEXES.replace("C3D8R", "COH3D8"), "C3D8"),
    "continuum shell": (HEXES.replace("C3D8R", "SC8R"), "C3D8"),
    "mixed": (HEXES + "*ELEMENT, TYPE=C3D4\n100, 10, 20, 40, 50\n", "mixed"),
    "cut": (HEXES.replace("    50, 60, 70, 80\n", "    50, 60\n"), "cut or damaged"),
    "unknown node": (HEXES.replace("7, 10, 20, 30, 40", "7, 10, 20, 30, 45"), "node 45"),
    "two parts": (HEXES + HEXES, "given twice"),
    "unknown set": (HEXES + "*NSET, NSET=a\nnowhere\n", "'nowhere'"),
    "surface inside nothing": (HEXES.replace("7, 10, 20, 30, 40", "7, 10, 20, 31, 41"), "face of no cell"),
    "surface elsewhere": (HEXES.replace("7, 10, 20, 30, 40", "7, 10, 20, 30, 999"), "'shell'"),
    "not a number": (HEXES.replace("10, 0., 0., 0.", "10, zero, 0., 0."), "cannot be read"),
    "nodes of another file": (HEXES.replace("*NODE\n", "*NODE, INPUT=other.inp\n"), "INPUT=other.inp"),
    "coordinate system": ("*SYSTEM\n1., 0., 0.\n" + HEXES, "*SYSTEM"),
    "no node number": (HEXES.replace(" 999, 7.", " -9, 7."), "number -9"),
    "inverted": (HEXES.replace("10, 20, 30, 40,\n", "10, 20, 40, 30,\n"), "inverted"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_file_is_refused_naming_the_file(tmp_path, name):
    text, words = BAD[name]
    with pytest.raises(InputError) as caught:
        read(tmp_path, text)
    assert caught.value.field == "path"
    assert caught.value.remedy.startswith("part.inp: ")
    assert words in caught.value.remedy


@pytest.mark.parametrize(
    ("kind", "word"),
    [("tet4", "C3D10"), ("hex8", "C3D20R"), ("wedge6", "C3D15"), ("tet4", "C3D10M"), ("hex8", "C3D27")],
)
def test_second_order_elements_keep_sets_and_face_labels(tmp_path, kind, word):
    """A cell with a node on every edge (C3D27: seven more) is that of first order, and labels name the same faces."""
    element = ELEMENTS[kind]
    points, blocks = second_order(element.reference, [(kind, 1, [], [range(element.corners)])])
    row = [*blocks[0][3][0], *range(len(points), len(points) + 7)] if word == "C3D27" else blocks[0][3][0]
    points = np.concatenate([points, np.full((7, 3), 0.1)])[: len(row)]

    def text(word, row):
        lines = "".join(f"{i}, {x}, {y}, {z}\n" for i, (x, y, z) in enumerate(points, 1))
        found = f"*NODE\n{lines}*ELEMENT, TYPE={word}, ELSET=all\n1, " + ",".join(str(i + 1) for i in row) + "\n"
        return found + "".join(f"*SURFACE, NAME=F{k}\nall, S{k}\n" for k in range(1, len(element.faces) + 1))

    first = read(tmp_path, text(f"C3D{element.corners}", range(element.corners)))
    dropped = len(row) - element.corners
    with pytest.warns(MeshWarning, match=f"{dropped} mid-side nodes were dropped"):
        second = read(tmp_path, text(word, row))
    assert np.array_equal(second.nodes, first.nodes)
    assert np.array_equal(second.cells, first.cells)
    assert second.cell_sets["all"].tolist() == [0]
    assert set(second.face_sets) == set(first.face_sets) == {f"F{k}" for k in range(1, len(element.faces) + 1)}
    for name, faces in first.face_sets.items():
        assert np.array_equal(second.face_sets[name], faces)


def test_line_endings_blanks_and_letters_do_not_matter(tmp_path):
    plain = read(tmp_path, HEXES)
    for text in (HEXES.replace("\n", "\r\n"), HEXES.replace("\n*", "\n\n  *"), HEXES.replace("*Node", "*nOdE")):
        (tmp_path / "part.inp").write_bytes(text.encode())
        mesh = read_mesh(tmp_path / "part.inp")
        assert np.array_equal(mesh.nodes, plain.nodes)
        assert np.array_equal(mesh.cells, plain.cells)
        assert mesh.face_sets.keys() == plain.face_sets.keys()
        assert mesh.node_sets.keys() == plain.node_sets.keys()


def test_quoted_names_byte_order_marks_and_fortran_numbers(tmp_path):
    """A comma within quotation marks belongs to a name; 1.0D0 is a number; a file may begin with a byte order mark."""
    text = HEXES[HEXES.index("*Part") :].replace("20, 1., 0., 0.", "20, 1.0D0, 0., 0.d0")
    text = text.replace("nset=Top, generate", 'nset="Set-1, top", generate').replace(
        "nset=Some\n", 'nset="Set-1, some"\n'
    )
    path = tmp_path / "mesh.inp"
    path.write_text(text.replace("\n Top\n", '\n "Set-1, top"\n'), encoding="utf-8-sig")
    mesh = read_mesh(path)
    plain = tmp_path / "plain.inp"
    plain.write_text(HEXES)
    known = read_mesh(plain)
    assert np.array_equal(mesh.nodes, known.nodes)
    assert np.array_equal(mesh.node_sets["Set-1, top"], known.node_sets["Top"])
    assert np.array_equal(mesh.node_sets["Set-1, some"], known.node_sets["Some"])


def test_surfaces_made_of_others_are_refused_by_name(tmp_path):
    path = tmp_path / "mesh.inp"
    path.write_text(HEXES + "*Surface, name=Sum, combine=union\n top, Walls\n")
    with pytest.raises(InputError, match=r"surface 'Sum' combines others"):
        read_mesh(path)
