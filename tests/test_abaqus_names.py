"""Abaqus input files: names of node sets, element sets and surfaces are apart; sets name what the file has."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import tcontact as tc

BOX = tc.box_mesh((1.0, 1.0, 2.0), (2, 2, 4))
BOTTOM = np.flatnonzero(BOX.nodes[:, 2] == 0.0).tolist()
LOWEST = np.flatnonzero((BOX.nodes[BOX.cells][:, :, 2] == 0.0).any(axis=1)).tolist()
OF_LOWEST = np.unique(BOX.cells[LOWEST]).tolist()
ONE = "*Instance, name=A, part=P\n*End Instance\n"
TWO = ONE + "*Instance, name=B, part=P\n5., 0., 0.\n*End Instance\n"


def numbers(ids):
    return "".join(f"{i + 1},\n" for i in ids)


NODES = "*Node\n" + "".join(f"{i}, {x!r}, {y!r}, {z!r}\n" for i, (x, y, z) in enumerate(BOX.nodes.tolist(), 1))
CELLS = "*Element, type=C3D8R\n" + "".join(
    f"{i}, " + ", ".join(str(n + 1) for n in cell) + "\n" for i, cell in enumerate(BOX.cells.tolist(), 1)
)
NSET = "*Nset, nset=Fix\n" + numbers(BOTTOM)
ELSET = "*Elset, elset=Fix\n" + numbers(LOWEST)
MASSES = "*Element, type=MASS, elset=lumps\n901, 1\n902, 2\n"


def read(tmp_path, *sections):
    (tmp_path / "names.inp").write_text("".join(sections))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return tc.read_mesh(tmp_path / "names.inp")


def read_with_warning(tmp_path, match, *sections):
    (tmp_path / "names.inp").write_text("".join(sections))
    with pytest.warns(tc.MeshWarning, match=match) as caught:
        mesh = tc.read_mesh(tmp_path / "names.inp")
    assert len(caught) == 1
    return mesh


def refused(tmp_path, words, *sections):
    with pytest.raises(tc.InputError) as caught:
        read(tmp_path, *sections)
    assert words in caught.value.remedy


@pytest.mark.parametrize(
    "sets",
    [
        NSET + ELSET,
        ELSET + NSET,
        ELSET.replace("elset=Fix", "elset=FIX") + NSET,
        "*Nset, nset=Fix, generate\n1, 5\n" + ELSET + "*NSET, NSET=FIX\n" + numbers(BOTTOM[5:]),
        ELSET + "*Nset, nset=base\n" + numbers(BOTTOM) + "*Surface, type=NODE, name=Fix\nbase,\n",
    ],
    ids=["nset first", "elset first", "other letters", "blocks", "node surface"],
)
def test_a_node_set_is_that_of_its_nset_alone(tmp_path, sets):
    """As Abaqus/CAE writes a set of faces: NSET and ELSET of one name."""
    mesh = read(tmp_path, NODES, CELLS, sets)
    name = next(name for name in mesh.cell_sets if name.upper() == "FIX")
    assert sorted(mesh.node_sets[name].tolist()) == BOTTOM
    assert mesh.nodes_of(name).tolist() == BOTTOM
    assert mesh.cell_sets[name].tolist() == LOWEST


def test_an_elset_whose_name_no_nset_has_is_a_set_of_nodes_too(tmp_path):
    mesh = read(tmp_path, NODES, CELLS, ELSET)
    assert mesh.node_sets["Fix"].tolist() == OF_LOWEST
    assert mesh.cell_sets["Fix"].tolist() == LOWEST


@pytest.mark.filterwarnings("ignore:the instances")
@pytest.mark.parametrize("sets", [NSET + ELSET, ELSET + NSET])
def test_names_are_apart_in_parts_and_in_assemblies(tmp_path, sets):
    part = f"*Part, name=P\n{NODES}{CELLS}"
    one = read(tmp_path, part, sets, "*End Part\n", ONE)
    assert one.node_sets["Fix"].tolist() == BOTTOM
    assert one.cell_sets["Fix"].tolist() == LOWEST
    (tmp_path / "names.inp").write_text(part + sets + "*End Part\n" + TWO)
    two = tc.read_mesh(tmp_path / "names.inp")
    assert two.node_sets["B.Fix"].tolist() == [BOX.node_count + i for i in BOTTOM]
    assert two.cell_sets["B.Fix"].tolist() == [BOX.cell_count + i for i in LOWEST]
    outside = "".join(sets.replace("set=Fix", f"set=Fix, instance={name}") for name in "AB")
    (tmp_path / "names.inp").write_text(part + "*End Part\n" + TWO + outside)
    across = tc.read_mesh(tmp_path / "names.inp")
    assert across.node_sets["Fix"].tolist() == [first + i for first in (0, BOX.node_count) for i in BOTTOM]
    assert across.cell_sets["Fix"].tolist() == [first + i for first in (0, BOX.cell_count) for i in LOWEST]


def test_an_nset_of_a_node_surface_keeps_its_name(tmp_path):
    surface = "*Nset, nset=other\n40\n*Surface, type=NODE, name=Fix\nother,\n"
    mesh = read_with_warning(
        tmp_path, "surface 'Fix' is left out: a node set has its name", NODES, CELLS, NSET, surface
    )
    assert mesh.node_sets["Fix"].tolist() == BOTTOM
    same = read(tmp_path, NODES, CELLS, NSET, "*Surface, type=NODE, name=Fix\nFix,\n")
    assert same.node_sets["Fix"].tolist() == BOTTOM


@pytest.mark.parametrize(
    ("sets", "words"),
    [
        ("*Nset, nset=x\n1, 999\n", "node set 'x': node 999 is used but not given"),
        ("*Surface, type=NODE, name=s\n999,\n", "surface 's': node 999"),
    ],
)
def test_numbers_that_the_file_does_not_give_are_refused_by_the_name_of_their_set(tmp_path, sets, words):
    refused(tmp_path, words, NODES, CELLS, sets)


@pytest.mark.parametrize(
    ("sets", "first", "left"),
    [("*Elset, elset=x\n1, 77\n", 77, [0]), ("*Elset, elset=x, generate\n1, 17\n", 17, list(range(16)))],
)
def test_elements_that_the_file_does_not_give_are_left_out_with_a_warning(tmp_path, sets, first, left):
    """A range may have gaps: no program that reads such files refuses them."""
    words = f"element set 'x' names 1 elements that the file does not give, first element {first}"
    assert read_with_warning(tmp_path, words, NODES, CELLS, sets).cell_sets["x"].tolist() == left


def test_faces_of_elements_that_the_file_does_not_give_are_left_out_with_a_warning(tmp_path):
    (tmp_path / "names.inp").write_text(NODES + CELLS + "*Surface, name=s\n77, S1\n1, S1\n")
    with pytest.warns(tc.MeshWarning, match="surface 's' names 1 elements"):
        assert len(tc.read_mesh(tmp_path / "names.inp").face_sets["s"]) == 1


def test_an_nset_of_elements_that_are_not_read_is_left_out_with_a_warning(tmp_path):
    (tmp_path / "names.inp").write_text(NODES + CELLS + MASSES + "*Nset, nset=x, elset=lumps\n")
    with pytest.warns(tc.MeshWarning, match="'lumps', none of whose elements is read"):
        assert "x" not in tc.read_mesh(tmp_path / "names.inp").node_sets


def test_a_mass_with_the_number_of_a_cell_is_told(tmp_path):
    """The set of the masses holds this cell then."""
    words = "element 3 is given twice, as a cell and as MASS"
    mesh = read_with_warning(tmp_path, words, NODES, CELLS, MASSES.replace("901", "3"))
    assert mesh.cell_sets["lumps"].tolist() == [2]


def test_sets_whose_elements_are_not_read_are_left_out_with_a_warning(tmp_path):
    lost = r"element set 'lumps' is left out: its elements \(MASS\) are no cells that are read"
    mesh = read_with_warning(tmp_path, lost, NODES, CELLS, MASSES)
    assert not mesh.cell_sets
    unnamed = MASSES.replace(", elset=lumps", "")
    read_with_warning(tmp_path, "'x' is left out: its elements", NODES, CELLS, unnamed, "*Elset, elset=x\n902\n")
    mixed = read(tmp_path, NODES, CELLS, unnamed, "*Elset, elset=x\n902, 1\n")
    assert mixed.cell_sets["x"].tolist() == [0]
    inside = MASSES.replace("lumps", "_lumps")
    named = read(tmp_path, NODES, CELLS, inside, "*Elset, elset=x\n_lumps, 2\n")
    assert named.cell_sets["x"].tolist() == [1]
    part = r"part of surface 's' is left out: its elements \(MASS\)"
    assert not read_with_warning(
        tmp_path, part, NODES, CELLS, inside, "*Surface, name=s\n_lumps, S1\n1, S1\n"
    ).node_sets
    placed = ("*Part, name=P\n", NODES, CELLS, MASSES, "*End Part\n", ONE, "*Elset, elset=_x, instance=A\n902\n")
    assert read_with_warning(tmp_path, lost, *placed).cell_sets.keys() == {"A", "P"}


@pytest.mark.parametrize(
    ("lines", "found"),
    [
        ("901, 1\n902, 2\n", {901, 902}),
        ("901, 1,\n902, 2,\n", {901, 902}),
        ("901, , 2\n902, 3,\n903, 3, 4\n", {901, 902, 903}),
        ("901, 1, 2, 3, 4, 5,\n6, 7\n902, 1, 2, 3, 4, 5,\n6, 7\n", {901, 902}),
        ("901, 1, 2, 3, 4,\n902, 1, 2, 3, 4,\n", {901, 902}),
    ],
)
def test_numbers_of_elements_that_are_no_cells(tmp_path, lines, found):
    """A spring may lack a node; a long line goes on after its comma, unless every line has one."""
    sections = (NODES, CELLS, f"*Element, type=U1, elset=_u\n{lines}*Elset, elset=x\n1, ")
    for number in found:
        assert read(tmp_path, *sections, f"{number}\n").cell_sets["x"].tolist() == [0]
    assert read(tmp_path, *sections, "_u\n*Elset, elset=x\n7\n").cell_sets["x"].tolist() == [0, 6]
    (tmp_path / "names.inp").write_text("".join([*sections, "999\n"]))
    with pytest.warns(tc.MeshWarning, match="element 999"):
        tc.read_mesh(tmp_path / "names.inp")


def test_empty_sets_are_left_out_with_a_warning(tmp_path):
    read_with_warning(tmp_path, "node set 'none' is left out: it is empty", NODES, CELLS, "*Nset, nset=none\n")
    read_with_warning(tmp_path, "element set 'none' is left out: it is empty", NODES, CELLS, "*Elset, elset=none\n")


def test_ranges_that_run_down_have_their_last_number(tmp_path):
    mesh = read(tmp_path, NODES, CELLS, "*Nset, nset=down, generate\n9, 1, -2\n*Nset, nset=up, generate\n1, 9, 2\n")
    assert mesh.node_sets["down"].tolist() == mesh.node_sets["up"].tolist() == [0, 2, 4, 6, 8]


def test_quoted_names_of_instances_and_sets(tmp_path):
    part = f'*Part, name="a part"\n{NODES}{CELLS}*Nset, nset="Fix it"\n1, 2\n*End Part\n'
    instance = '*Instance, name="a part-1", part="A part"\n*End Instance\n'
    mesh = read(tmp_path, part, instance, '*Nset, nset=both\n"a part-1"."Fix it", "a part-1".3\n')
    assert mesh.node_sets["both"].tolist() == [0, 1, 2]
