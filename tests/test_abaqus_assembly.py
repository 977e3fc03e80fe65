"""Abaqus assemblies: instances of parts moved and turned, sets within instances and across them, parts of the mesh."""

from __future__ import annotations

import numpy as np
import pytest

import tcontact as tc
from tcontact.mesh.rotation import rotation_matrix

BLOCK = tc.box_mesh((2.0, 1.0, 1.0), (2, 1, 1))
PEG = tc.box_mesh((0.5, 0.5, 0.5), (1, 1, 1), "tet4")
TURN = 30.0  # degrees, about the axis from (1, 0, 0) to (1, 1, 1)


def part(name, mesh, word, extra=""):
    """The section of a part; its numbers begin at 1 as in every part."""
    lines = [f"*Part, name={name}", "*Node"]
    lines += [f"{i}, {x!r}, {y!r}, {z!r}" for i, (x, y, z) in enumerate(mesh.nodes.tolist(), 1)]
    lines += [f"*Element, type={word}"]
    lines += [f"{i}, " + ", ".join(str(n + 1) for n in cell) for i, cell in enumerate(mesh.cells.tolist(), 1)]
    return "\n".join([*lines, extra.strip(), "*End Part", ""])


PARTS = part(
    "Block",
    BLOCK,
    "C3D8R",
    """
*Elset, elset=first
 1,
*Nset, nset=ends, generate
 1, 10, 3
*Surface, type=ELEMENT, name=Side
 first, S6
** of one part alone
*Elset, elset=_inner, internal
 2
""",
) + part("peg", PEG, "C3D4", "*Elset, elset=body, generate\n1, 6\n*Nset, nset=Ends\n 1\n*Nset, nset=tip\n 8")
ASSEMBLY = f"""** the assembly
*Assembly, name=Assembly
*Instance, name=Left, part=BLOCK
*End Instance
*Instance, name=Right, part=block
 10., 0., -1.
 1., 0., 0., 1., 1., 1., {TURN}
*End Instance
*Instance, name=Peg-1, part=peg
 0., 5., 0.
*End Instance
*Node
 1, 99., 99., 99.
*Nset, nset=reference
 1
*Nset, nset=Both, instance=Left
 1, 2
*Nset, nset=Both, instance=Right
 3
*Nset, nset=named
 Left.5, right.ENDS, Both
*Elset, elset=_Top_S2, internal, instance=Left, generate
 1, 2, 1
*Elset, elset=_Top_S2, internal, instance=Right
 2
*Surface, type=ELEMENT, name=Top
 _Top_S2, S2
 Right.1, S1
 Left.first, S1
*Elset, elset=middle, instance=Right
 first
*Surface, type=NODE, name=points
 Peg-1.tip
*End Assembly
*Material, name=steel
"""


def read(tmp_path, text):
    (tmp_path / "assembly.inp").write_text(text)
    return tc.read_mesh(tmp_path / "assembly.inp")


@pytest.fixture
def mesh(tmp_path):
    """Left and Right of hexahedra beside tetrahedra; the order of the kinds is that of read_mesh."""
    with pytest.warns(
        tc.MeshWarning, match=r"'Left' and 'Right' and 'Peg-1' become one mesh.*mesh\.part\(name\)"
    ) as caught:
        mesh = read(tmp_path, PARTS + ASSEMBLY)
    assert caught[0].filename == __file__
    return mesh


def placed():
    """The nodes of Right: moved first, then turned."""
    first = np.array([1.0, 0.0, 0.0])
    turn = rotation_matrix(((0.0, 1.0, 1.0), np.radians(TURN)))
    return (BLOCK.nodes + np.array([10.0, 0.0, -1.0]) - first) @ turn.T + first


def test_instances_stand_where_they_are_put(mesh):
    """Translation before rotation, right-handed about the axis; the angle in degrees."""
    assert mesh.cell_count == 2 + 2 + 6
    assert mesh.nodes[:12] == pytest.approx(BLOCK.nodes, abs=1e-15)
    assert mesh.nodes[12:24] == pytest.approx(placed(), abs=1e-14)
    assert mesh.nodes[24:] == pytest.approx(PEG.nodes + np.array([0.0, 5.0, 0.0]), abs=1e-14)
    hexes, tets = (dict(mesh.blocks)[kind] for kind in ("hex8", "tet4"))
    assert np.array_equal(hexes, np.concatenate([BLOCK.cells, BLOCK.cells + 12]))
    assert np.array_equal(tets, PEG.cells + 24)


def test_every_instance_and_part_is_a_cell_set(mesh):
    expected = {"Left": [0, 1], "Right": [2, 3], "Peg-1": range(4, 10), "Block": range(4), "peg": range(4, 10)}
    expected |= {"Left.first": [0], "Right.first": [2], "middle": [2], "body": range(4, 10)}
    assert {name: list(ids) for name, ids in mesh.cell_sets.items()} == {k: list(v) for k, v in expected.items()}


def test_sets_of_instances_carry_their_name_where_it_is_needed(mesh):
    """Plain where one instance has the set, INSTANCE.SET where several do, and those of the assembly plain."""
    assert set(mesh.node_sets) - set(mesh.cell_sets) == {
        "Left.ends", "Right.ends", "Peg-1.Ends", "tip", "Both", "named", "points",
    }  # fmt: skip
    ends = np.array([0, 3, 6, 9])
    assert mesh.node_sets["Left.ends"].tolist() == ends.tolist()
    assert mesh.node_sets["Right.ends"].tolist() == (12 + ends).tolist()
    assert mesh.node_sets["Peg-1.Ends"].tolist() == [24]
    assert mesh.node_sets["tip"].tolist() == mesh.node_sets["points"].tolist() == [31]
    assert mesh.node_sets["Both"].tolist() == [0, 1, 14]
    assert mesh.node_sets["named"].tolist() == sorted({0, 1, 4, 14, *(12 + ends)})
    assert set(mesh.face_sets) == {"Left.Side", "Right.Side", "Top"}


def test_surfaces_of_the_assembly_take_faces_of_several_instances(mesh):
    top = {frozenset(face) for face in mesh.face_sets["Top"].tolist()}
    sides = BLOCK.element.abaqus_faces
    expected = {frozenset(BLOCK.cells[cell][list(sides[1])].tolist()) for cell in (0, 1)}
    expected |= {frozenset((BLOCK.cells[cell][list(sides[side])] + 12).tolist()) for cell, side in ((1, 1), (0, 0))}
    assert top == expected | {frozenset(BLOCK.cells[0][list(sides[0])].tolist())}
    assert sorted(mesh.nodes_of("Right.Side")) == sorted(BLOCK.cells[0][list(sides[5])] + 12)


def test_a_part_of_the_mesh_is_the_instance_by_itself(mesh):
    right = mesh.part("Right")
    assert right.kind == "hex8"
    assert right.nodes == pytest.approx(placed(), abs=1e-14)
    assert np.array_equal(right.cells, BLOCK.cells)
    assert set(right.face_sets) == {"Right.Side", "Top"}
    assert len(right.face_sets["Top"]) == 2
    assert {name: list(ids) for name, ids in right.cell_sets.items()} == {
        "Right": [0, 1], "Block": [0, 1], "Right.first": [0], "middle": [0],
    }  # fmt: skip
    assert right.node_sets["Both"].tolist() == [2]
    assert "Peg-1.Ends" not in right.node_sets
    assert mesh.part("peg").kind == "tet4"
    whole = mesh.part(["Block", "peg"])
    assert np.array_equal(whole.nodes, mesh.nodes)
    assert np.array_equal(whole.cells, mesh.cells)
    assert all(np.array_equal(whole.face_sets[name], faces) for name, faces in mesh.face_sets.items())
    for wrong in ("nowhere", "Top", [], 3):
        with pytest.raises(tc.InputError, match="cell sets of this mesh: Left"):
            mesh.part(wrong)


def test_the_instances_are_bodies_of_materials_of_their_own(mesh):
    steel, rubber = tc.LinearElastic(2e11, 0.3, 7800.0), tc.NeoHookean(1e7, 0.4, 1000.0)
    body = tc.Body(mesh, {"Left": steel, "Right": rubber, "peg": steel}, name="all")
    assert body.mass == pytest.approx(2.0 * 7800.0 + 2.0 * 1000.0 + 0.125 * 7800.0, rel=1e-12)
    apart = [tc.Body(mesh.part(name), steel, name=name) for name in ("Left", "Right", "Peg-1")]
    assert [body.mesh.cell_count for body in apart] == [2, 2, 6]


def test_one_instance_needs_no_warning_and_no_long_names(tmp_path):
    one = "*Assembly, name=a\n*Instance, name=Block, part=Block\n*End Instance\n*End Assembly\n"
    mesh = read(tmp_path, PARTS + one)
    assert mesh.cell_count == 2
    assert set(mesh.cell_sets) == {"Block", "first"}
    assert set(mesh.face_sets) == {"Side"}


def test_an_instance_may_hold_its_mesh_itself(tmp_path):
    """As the files of independent instances have it; the part is empty there."""
    inside = part("x", BLOCK, "C3D8").split("\n", 1)[1].replace("*End Part", "*Nset, nset=a\n 12\n*End Instance")
    text = "*Part, name=Block\n*End Part\n*Assembly, name=a\n*Instance, name=I, part=Block\n1., 0., 0.\n" + inside
    mesh = read(tmp_path, text + "*Nset, nset=b, instance=I\n 12\n*End Assembly\n")
    assert np.array_equal(mesh.nodes, BLOCK.nodes + np.array([1.0, 0.0, 0.0]))
    assert mesh.node_sets["a"].tolist() == mesh.node_sets["b"].tolist() == [11]


def test_a_set_of_the_file_keeps_the_name_of_an_instance(tmp_path):
    one = "*Instance, name=first, part=Block\n*End Instance\n"
    assert read(tmp_path, PARTS + one).cell_sets["first"].tolist() == [0]


@pytest.mark.filterwarnings("ignore:the instances")
@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("part=peg\n", "part=pin\n", "instance 'Peg-1' is of part 'pin', which is not in the file"),
        ("name=Right", "name=LEFT", "instance 'LEFT' is given twice"),
        ("*Part, name=peg", "*Part, name=BLOCK", "part 'BLOCK' is given twice"),
        (" 10., 0., -1.", " 10., 0., -1., 3.", "a line of 4 numbers"),
        ("1., 0., 0., 1., 1., 1.,", "1., 0., 0., 1., 0., 0.,", "instance 'Right' turns about no axis"),
        ("instance=Left\n 1, 2", "instance=Middle\n 1, 2", "instance 'Middle' is used but not given"),
        ("instance=Left\n 1, 2", "instance=Left\n 1, 77", "node 77 of instance 'Left' is used but not given"),
        (" Left.5,", " Left.up,", "set 'Left.up' is used before it is given"),
        (" Left.5,", " Left.-5,", "set 'Left.-5' is used before it is given"),
        (" Peg-1.tip", " Peg-1.top", "set 'Peg-1.top'"),
        ("name=Peg-1, part=peg", "library=old, instance=Peg-1", "of another analysis"),
        (" 1, 10, 3", " 1, 5000000000, 3", "more ids than a mesh has"),
        (" 1, 10, 3", " -4, 10, 3", "more ids than a mesh has"),
        ("1, 99., 99., 99.", "1, 99., 99., 99.\n1, 99., 9., 99.", "node 1 is given twice"),
    ],
)
def test_broken_assemblies_are_refused(tmp_path, old, new, words):
    text = PARTS + ASSEMBLY
    assert old in text
    with pytest.raises(tc.InputError) as caught:
        read(tmp_path, text.replace(old, new))
    assert caught.value.field == "path"
    assert words in caught.value.remedy
