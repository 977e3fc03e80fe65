"""Meshes of several kinds of cells, cell sets, materials by set: checks, files, scenes, frames, resume, pictures."""

import pickle

import meshio
import numpy as np
import pytest
from mesh_files import write_gmsh22, write_gmsh41
from mixed_meshes import OTHERS, SIZE, STEEL, beside, corner, cut, halves, volume_by_points
from stopped_runs import copied, quietly, same, same_files

import tcontact as tc
from tcontact.commands.cli import main
from tcontact.mesh.elements import ELEMENTS
from tcontact.results import frame_fields
from tcontact.results.files.vtkhdf import ResultData
from tcontact.show.render import render_frames

HEXES = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
MATERIALS = {"low": STEEL, "high": OTHERS["stiff"]}


def refusal(field, *words):
    """Context in which an InputError with this field and these words is raised."""
    return pytest.raises(tc.InputError, match=r"(?s)^" + field + ".*" + ".*".join(words))


def same_mesh(one, other):
    """Assert that two meshes have the same arrays."""
    assert one.kind == other.kind
    assert np.array_equal(one.nodes, other.nodes)
    assert [kind for kind, _ in one.blocks] == [kind for kind, _ in other.blocks]
    for (_, mine), (_, theirs) in zip(one.blocks, other.blocks, strict=True):
        assert np.array_equal(mine, theirs)
    for group in ("node_sets", "face_sets", "cell_sets"):
        mine, theirs = getattr(one, group), getattr(other, group)
        assert mine.keys() == theirs.keys()
        assert all(np.array_equal(mine[name], theirs[name]) for name in mine), group


def test_a_mixed_mesh_numbers_its_cells_block_after_block():
    mesh = corner((4, 2, 4))
    kinds, counts = zip(*[(kind, len(cells)) for kind, cells in mesh.blocks], strict=True)
    assert (mesh.kind, kinds, counts) == ("mixed", ("hex8", "tet4", "wedge6"), (8, 48, 16))
    assert mesh.cell_count == 72
    assert mesh.cells.shape == (72, 8)
    first = 0
    for _, cells in mesh.blocks:
        rows = mesh.cells[first : first + len(cells)]
        assert np.array_equal(rows[:, : cells.shape[1]], cells)
        assert (rows[:, cells.shape[1] :] == cells[:, -1:]).all()
        assert mesh.cell_centres()[first] == pytest.approx(mesh.nodes[cells[0]].mean(axis=0))
        first += len(cells)
    assert mesh.cell_volumes().sum() == pytest.approx(0.75 * np.prod(SIZE), rel=1e-13)
    assert volume_by_points(mesh) == pytest.approx(0.75 * np.prod(SIZE), rel=1e-13)
    assert mesh.shortest_edge == pytest.approx(0.015)


@pytest.mark.parametrize("make", [beside, corner])
def test_the_surface_of_a_mixed_mesh_is_closed(make):
    mesh = make()
    faces, nodes = mesh.boundary_faces(), mesh.nodes
    flat = faces[:, 2] == faces[:, 3]
    assert flat.any()
    assert not flat.all()
    parts = np.concatenate([faces[:, :3], faces[~flat][:, [0, 2, 3]]])
    corners = nodes[parts]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2.0
    assert np.abs(areas.sum(axis=0)).max() <= 1e-15
    enclosed = np.einsum("ni,ni->", areas, corners.mean(axis=1)) / 3.0
    assert enclosed == pytest.approx(mesh.cell_volumes().sum(), rel=1e-12)
    below = mesh.faces_of("zmin")
    assert (nodes[below][:, :, 2] == 0.0).all()


def test_a_dict_of_one_kind_is_a_mesh_of_that_kind():
    one = tc.Mesh(HEXES.nodes, {"hex8": HEXES.cells}, face_sets=HEXES.face_sets)
    same_mesh(one, tc.Mesh(HEXES.nodes, HEXES.cells, "hex8", face_sets=HEXES.face_sets))
    assert one.repeated is None
    assert one.blocks == (("hex8", one.cells),)


def test_moved_and_pickled_meshes_keep_kinds_and_cell_sets():
    mesh = halves(corner())
    same_mesh(pickle.loads(pickle.dumps(mesh)), mesh)
    for moved in (mesh.translated((1.0, 0.0, 0.0)), mesh.rotated(((0, 0, 1), 0.3)), mesh.scaled(2.0)):
        assert moved.blocks[1][0] == "tet4"
        assert moved.cell_sets.keys() == {"low", "high"}
        assert np.array_equal(moved.cell_sets["low"], mesh.cell_sets["low"])
    again = mesh.with_sets(cell_sets={"low": [3, 1]})
    assert again.cell_sets["low"].tolist() == [1, 3]
    assert "low" in repr(mesh)
    assert "hex8" in repr(mesh)


def upright_wedges_on_hexes():
    """Hexahedra with prisms on top whose triangles lie on the quadrilaterals below."""
    return cut(tc.box_mesh((1, 1, 1), (2, 2, 2)), lambda centre: "hex8" if centre[2] < 0.5 else "wedge6")


def tets_on_hexes():
    """Hexahedra with tetrahedra on top."""
    return cut(tc.box_mesh((1, 1, 1), (2, 2, 2)), lambda centre: "hex8" if centre[2] < 0.5 else "tet4")


@pytest.mark.parametrize("make", [upright_wedges_on_hexes, tets_on_hexes])
def test_quadrilaterals_on_triangles_are_refused(make):
    with refusal("cells = 'face", "4 such", "quadrilateral", "wedge6"):
        make()


def test_wrong_cells_and_sets_are_refused():
    nodes, cells = HEXES.nodes, HEXES.cells
    prism = np.array([[0, 1, 3, 9, 10, 12]])
    with refusal("kind", "mixed", "dict"):
        tc.Mesh(nodes, cells)
    with refusal("kind", "leave kind out"):
        tc.Mesh(nodes, {"hex8": cells}, "tet4")
    with refusal("cells = 'pyramid5'", "wedge6"):
        tc.Mesh(nodes, {"pyramid5": cells})
    with refusal("cells = 'empty dict'"):
        tc.Mesh(nodes, {})
    with refusal(r"cells\['wedge6'\]", "6 corners"):
        tc.Mesh(nodes, {"hex8": cells, "wedge6": cells})
    with refusal(r"cells\['wedge6'\]", "cell 0", "inverted"):
        tc.Mesh(nodes, {"hex8": cells, "wedge6": prism[:, [0, 1, 2, 4, 3, 5]]})
    with refusal("nodes", "belongs to no cell"):
        tc.Mesh(np.concatenate([nodes, [[5.0, 5.0, 5.0]]]), {"hex8": cells, "wedge6": prism})
    for given, words in (
        ([8], "0 to 7"), ([-1], "0 to 7"), ([], "at least one"), ([1, 1], "twice"), ([0.5], "cell numbers"), ("x", ""),
    ):  # fmt: skip
        with refusal(r"cell_sets\['a'\]", words):
            HEXES.with_sets(cell_sets={"a": given})
    with refusal("Mesh.kind", "Mesh.blocks"):
        _ = beside().element


def test_materials_that_do_not_cover_the_cells_once_are_refused():
    mesh = HEXES.with_sets(cell_sets={"low": [0, 1, 2, 3], "most": [3, 4, 5, 6], "last": [7]})
    with refusal("Body.material", "1 of 8 cells", "first one 7", "'last'"):
        tc.Body(mesh.with_sets(cell_sets={"most": [4, 5, 6]}), {"low": STEEL, "most": STEEL})
    with refusal(r"Body.material\['most'\]", "1 of its cells, the first one 3", "'low'"):
        tc.Body(mesh, {"low": STEEL, "most": STEEL, "last": STEEL})
    with refusal("Body.material", "'core'", "'low', 'most', 'last'"):
        tc.Body(mesh, {"core": STEEL})
    with refusal(r"Body.material\['low'\]", "NeoHookean"):
        tc.Body(mesh, {"low": "steel"})
    with refusal("Body.material", "NeoHookean"):
        tc.Body(mesh, {})
    with refusal("Body.material", "NeoHookean"):
        tc.Body(mesh, [STEEL])
    with refusal("Body.formulation", "StVenantKirchhoff", "NeoHookean"):
        svk = tc.StVenantKirchhoff(1e7, 0.3, 1000.0)
        tc.Body(halves(HEXES), {"low": STEEL, "high": svk}, formulation="mean-dilatation")
    with refusal("Body.formulation", "tet4 and wedge6"):
        box = tc.box_mesh((1, 1, 1), (2, 1, 2))
        tc.Body(cut(box, lambda centre: "wedge6" if centre[2] < 0.5 else "tet4"), STEEL, formulation="reduced")


# files


def regions(mesh):
    """Cells of every kind by region: (kind, region, rows)."""
    high, found, first = mesh.cell_centres()[:, 1] >= SIZE[1] / 2, [], 0
    for kind, cells in mesh.blocks:
        mask = high[first : first + len(cells)]
        found += [(kind, "core", cells[~mask]), (kind, "skin", cells[mask])]
        first += len(cells)
    return found


def check_regions(mesh, original):
    """Assert that a mesh that was read has the cells and the regions of the one that was written."""
    assert [kind for kind, _ in mesh.blocks] == [kind for kind, _ in original.blocks]
    assert mesh.cell_volumes().sum() == pytest.approx(original.cell_volumes().sum(), rel=1e-12)
    count = 0
    for name, above in (("core", False), ("skin", True)):
        numbers = mesh.cell_sets[name]
        assert ((mesh.cell_centres()[numbers, 1] >= SIZE[1] / 2) == above).all()
        count += len(numbers)
    assert count == mesh.cell_count == original.cell_count
    tc.Body(mesh, {"core": STEEL, "skin": OTHERS["stiff"]})


@pytest.mark.parametrize("binary", [False, True])
@pytest.mark.parametrize("write", [write_gmsh22, write_gmsh41])
def test_physical_volumes_of_a_gmsh_file_are_cell_sets(write, binary, tmp_path):
    original = corner()
    tags = {"core": 1, "skin": 2}
    blocks = [
        (kind, number, [tags[region], 3], rows) for number, (kind, region, rows) in enumerate(regions(original), 1)
    ]
    names = {(3, 1): "core", (3, 2): "skin", (3, 3): "whole", (2, 4): "floor"}
    floor = original.faces_of("zmin")
    flat = floor[:, 2] == floor[:, 3]
    blocks += [("triangle", 1, [4], floor[flat][:, :3]), ("quad", 2, [4], floor[~flat])]
    write(tmp_path / "part.msh", original.nodes, np.arange(1, len(original.nodes) + 1), blocks, names, binary)
    mesh = tc.read_mesh(tmp_path / "part.msh")
    check_regions(mesh, original)
    assert len(mesh.cell_sets["whole"]) == mesh.cell_count
    assert len(mesh.faces_of("floor")) == len(floor)
    hexes = tc.read_mesh(tmp_path / "part.msh", kind="hex8")
    assert hexes.kind == "hex8"
    assert len(hexes.cell_sets["core"]) == len(hexes.cell_sets["skin"]) == hexes.cell_count // 2


def test_elsets_of_an_abaqus_file_are_cell_sets(tmp_path):
    original, lines, number, members = corner(), ["*Node"], 1, {"core": [], "skin": []}
    lines += [f"{i}, {x!r}, {y!r}, {z!r}" for i, (x, y, z) in enumerate(original.nodes.tolist(), 1)]
    for kind, region, rows in regions(original):
        lines.append(f"*Element, type={ELEMENTS[kind].abaqus}")
        for row in rows + 1:
            lines.append(", ".join(map(str, [number, *row])))
            members[region].append(number)
            number += 1
    for name, ids in members.items():
        lines += [f"*Elset, elset={name}", *map(str, ids)]
    (tmp_path / "part.inp").write_text("\n".join([*lines, ""]))
    mesh = tc.read_mesh(tmp_path / "part.inp")
    check_regions(mesh, original)
    assert mesh.node_sets.keys() == {"core", "skin"}


def test_whole_numbers_of_the_cells_of_a_vtu_file_are_cell_sets(tmp_path):
    original = corner()
    parts = regions(original)
    cells = [(ELEMENTS[kind].meshio, rows) for kind, _, rows in parts]
    data = {
        "region": [np.full(len(rows), 1 if region == "core" else 2) for _, region, rows in parts],
        "stress": [np.zeros(len(rows)) for _, _, rows in parts],
        "GlobalIds": [np.arange(len(rows)) for _, _, rows in parts],
    }
    meshio.write(tmp_path / "part.vtu", meshio.Mesh(original.nodes, cells, cell_data=data))
    mesh = tc.read_mesh(tmp_path / "part.vtu")
    assert mesh.cell_sets.keys() == {"region-1", "region-2"}
    sets = {"core": mesh.cell_sets["region-1"], "skin": mesh.cell_sets["region-2"]}
    check_regions(mesh.with_sets(cell_sets=sets), original)


def test_a_file_whose_kinds_do_not_fit_is_refused_with_what_to_do(tmp_path):
    box = tc.box_mesh((1, 1, 1), (1, 1, 2))
    tets = box.cells[1][np.array(ELEMENTS["tet4"].in_box)]
    path = tmp_path / "part.vtu"
    meshio.write(path, meshio.Mesh(box.nodes, [("hexahedron", box.cells[:1]), ("tetra", tets)]))
    with refusal("path", "hexahedra mixed with tetrahedra", "quadrilateral", "kind="):
        tc.read_mesh(path)
    assert tc.read_mesh(path, kind="tet4").cell_count == 6


# scenes


def scene(mesh=None, materials=MATERIALS, **options):
    """A body of all kinds and two materials that hits a wall."""
    mesh = halves(corner()) if mesh is None else mesh
    body = tc.Body(mesh, materials, (0.4, 0.2, -3.0), "zmin", name="part")
    plane = tc.Plane((0.0, 0.0, -1e-4))
    return tc.Scene([body], plane, 6e-4, contact=tc.MasslessContact("full"), **options)


@pytest.mark.parametrize("mesh", ["mixed", "box", "arrays"])
def test_a_scene_file_keeps_kinds_cell_sets_and_materials(mesh, tmp_path):
    box = halves(tc.box_mesh(SIZE, (3, 3, 4)))
    meshes = {"mixed": halves(corner()), "box": box, "arrays": box.with_sets({"some": [1, 2]})}
    one = scene(meshes[mesh])
    tc.save_scene(one, tmp_path / "scene.toml")
    other, _ = tc.load_scene(tmp_path / "scene.toml")
    same_mesh(other.bodies[0].mesh, one.bodies[0].mesh)
    assert other.bodies[0].material == one.bodies[0].material
    results = [tc.simulate(given, tc.CentralDifference(dt=2e-6)) for given in (one, other)]
    assert np.array_equal(results[0].position, results[1].position)


def test_a_scene_file_names_sets_of_cells_and_their_materials(tmp_path):
    text = """
duration = 1e-4
contact = "none"
[[bodies]]
mesh = { box = [1, 1, 1], cells = [2, 1, 1], cell_sets = { left = [0], right = [1] } }
[bodies.material.left]
type = "NeoHookean"
young = 1e7
poisson = 0.3
density = 1000
[bodies.material.right]
type = "LinearElastic"
young = 2e7
poisson = 0.2
density = 1100
"""
    (tmp_path / "scene.toml").write_text(text)
    body = tc.load_scene(tmp_path / "scene.toml")[0].bodies[0]
    assert body.material == {"left": tc.NeoHookean(1e7, 0.3, 1000), "right": tc.LinearElastic(2e7, 0.2, 1100)}
    (tmp_path / "scene.toml").write_text(text.replace("right = [1]", "right = [7]"))
    with refusal(r"bodies\[0\].mesh: cell_sets", "0 to 1"):
        tc.load_scene(tmp_path / "scene.toml")
    (tmp_path / "scene.toml").write_text(text.replace("young = 2e7", "young = -2e7"))
    with refusal(r"bodies\[0\].material.right: young"):
        tc.load_scene(tmp_path / "scene.toml")


def test_frames_hold_all_kinds_and_their_size_is_known(tmp_path, capsys):
    given = scene()
    result = tc.simulate(given, out=tmp_path / "run", frames=3)
    assert result.ok
    data = ResultData.open(tmp_path / "run" / "result.vtkhdf")
    mesh = given.bodies[0].mesh
    assert [kind for kind, _ in data.blocks] == [kind for kind, _ in mesh.blocks]
    assert all(np.array_equal(a, b) for (_, a), (_, b) in zip(data.blocks, mesh.blocks, strict=True))
    frame = data.frame(-1)
    assert frame.point_data["displacement"] == pytest.approx(result.position - mesh.nodes, abs=1e-15)
    assert len(frame.cell_data["von_mises"]) == mesh.cell_count
    nodes, cells, corners = mesh.node_count, 8 + 48 + 16, 8 * 8 + 48 * 4 + 16 * 6
    numbers = 10 * nodes + cells  # three vectors and a number a node, a number a cell
    assert frame_fields.size(given, 3) == frame_fields.FIXED + 24 * nodes + 8 * corners + 9 * cells + 8 * 3 * numbers
    assert main(["info", str(tmp_path / "run")]) == 0
    assert "hex8" in capsys.readouterr().out
    assert main(["export", str(tmp_path / "run"), "--to", "vtu"]) == 0
    written = sorted((tmp_path / "run").rglob("*.vtu"))
    again = meshio.read(written[-1])
    assert {block.type for block in again.cells} == {"hexahedron", "tetra", "wedge"}
    assert sum(len(block.data) for block in again.cells) == mesh.cell_count


def test_a_body_of_blocks_is_drawn(tmp_path):
    result = tc.simulate(scene())
    assert result._repr_png_()[:4] == b"\x89PNG"
    tc.simulate(scene(), out=tmp_path / "run", frames=2)
    render_frames(tmp_path / "run" / "result.vtkhdf", tmp_path / "pictures")
    assert list((tmp_path / "pictures").rglob("*.png"))


def test_a_stopped_run_goes_on_with_the_same_bits(monkeypatch, tmp_path):
    given = scene(friction=tc.Coulomb(0.3), viscosity=tc.BulkViscosity())
    options = {"frames": 4, "pressures": True}
    whole, copies = copied(monkeypatch, tmp_path, given, tc.CentralDifference(cfl=0.3), 9, **options)
    assert whole.ok
    row = sorted(copies)[len(copies) // 2]
    same(quietly(tc.resume, copies[row], given, tc.CentralDifference(cfl=0.3)), whole)
    same_files(copies[row], tmp_path / "whole")
    mesh = given.bodies[0].mesh
    others = {
        "material.low": scene(mesh, MATERIALS | {"low": OTHERS["rubber"]}),
        "cell_sets": scene(halves(mesh, axis=0)),
    }
    for word, other in others.items():
        with pytest.raises(tc.InputError, match=word):
            quietly(tc.resume, copies[sorted(copies)[0]], other, tc.CentralDifference(cfl=0.3))


def test_a_run_starts_from_the_end_of_another():
    given = scene()
    first = tc.simulate(given)
    there = tc.simulate(given, initial=first)
    assert there.history["momentum"][0] == pytest.approx(first.history["momentum"][-1], rel=1e-9)
    with pytest.raises(tc.InputError, match="other meshes"):
        tc.simulate(scene(halves(beside())), initial=first)
