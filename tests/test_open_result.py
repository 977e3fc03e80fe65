"""A run read back from its files has what its `Result` has; curves, pictures and tables of both."""

from __future__ import annotations

import ast
import json
import shutil
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest

import tcontact as tc
from tcontact.commands.cli import main

mpl.use("Agg")
CASES = sorted((Path(__file__).parent.parent / "cases").glob("[a-z]*.py"))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A block that slides on a plane, pressed by another one, with its folder."""
    law = tc.NeoHookean(1e6, 0.3, 1000.0)
    low = tc.Body(tc.box_mesh((0.2, 0.1, 0.1), (4, 2, 2)), law, (0.4, 0.0, -0.1), contact=["zmin", "zmax"], name="low")
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (3, 3, 3), origin=(0.0, 0.0, 0.1))
    top = tc.Body(mesh, law, (0.0, 0.0, -0.5), contact="zmin", name="top")
    scene = tc.Scene(
        [low, top],
        [tc.Plane(name="floor")],
        duration=0.01,
        contact=tc.MasslessContact("full"),
        friction=tc.Coulomb(0.3),
        pairs=[tc.Pair("top", "low")],
    )
    folder = tmp_path_factory.mktemp("open") / "run"
    return tc.simulate(scene, out=folder, frames=4), folder


SAME = (
    "ok", "reason", "message", "steps", "time", "dt", "dt_limit", "wall_s", "compile_s", "cell_updates_per_s",
    "memory", "terms", "warnings", "maxima", "peaks", "precision", "file",
)  # fmt: skip


def test_it_has_what_the_result_has(run):
    result, folder = run
    for place in (folder, str(folder / "result.vtkhdf")):
        stored = tc.open_result(place, scene=result.scene, scheme=result.scheme)
        assert {name: getattr(stored, name) for name in SAME} == {name: getattr(result, name) for name in SAME}
        assert stored.scene is result.scene
        assert stored.scheme is result.scheme
    assert stored.history.keys() == result.history.keys()
    for name, column in result.history.items():
        np.testing.assert_array_equal(stored.history[name], column, err_msg=name)
    for name in ("pair_force", "pair_moment", "obstacle_force", "probes"):
        found, known = getattr(stored, name), getattr(result, name)
        assert found.keys() == known.keys()
        assert all(np.array_equal(found[key], known[key]) for key in known)
    assert len(result.pair_force) == 1
    for name in ("position", "velocity", "contact_node_force"):
        known = getattr(result, name)
        np.testing.assert_allclose(getattr(stored, name), known, rtol=1e-5, atol=1e-6 * np.abs(known).max())
    assert stored.nodes_of("low") == result.nodes_of("low")
    assert stored.nodes_of("top") == result.nodes_of("top")
    assert "finished" in repr(stored)


def test_names_with_a_slash_and_the_name_of_a_single_body_come_back(tmp_path):
    """In the result file "/" would make a folder of a column."""
    law = tc.NeoHookean(1e6, 0.3, 1000.0)
    low = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2)).with_sets(node_sets={"in/ner": np.array([0, 1, 3, 4])})
    high = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2), origin=(0.0, 0.0, 0.1001))
    bodies = [
        tc.Body(low, law, contact="zmax", name="rig/lower", rigid_parts=[tc.RigidPart("in/ner", mass=0.1)]),
        tc.Body(high, law, (0.0, 0.0, -1.0), contact="zmin", name="rig/upper"),
    ]
    result = tc.simulate(tc.Scene(bodies, duration=1e-3), out=tmp_path / "two", frames=2)
    stored = tc.open_result(tmp_path / "two")
    assert stored.history.keys() == result.history.keys()
    assert list(stored.pair_force) == ["rig-lower-rig-upper"]
    assert "part_position:rig-lower-in-ner" in stored.history
    assert stored.nodes_of("rig/upper") == result.nodes_of("rig/upper")
    alone = tc.simulate(tc.Scene(bodies[1:], duration=1e-4), out=tmp_path / "one", frames=2)
    assert tc.open_result(tmp_path / "one").nodes_of("rig/upper") == alone.nodes_of("rig/upper") == slice(0, 27)


def test_two_rigid_parts_of_one_name_are_refused():
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2)).with_sets(node_sets={"c": [0, 1, 3], "b-c": [0, 1, 3]})
    law = tc.NeoHookean(1e6, 0.3, 1000.0)
    bodies = [
        tc.Body(mesh.translated((shift, 0.0, 0.0)), law, name=name, rigid_parts=[tc.RigidPart(part, mass=0.1)])
        for shift, name, part in ((0.0, "a", "b-c"), (1.0, "a-b", "c"))
    ]
    with pytest.raises(tc.InputError, match="so is a rigid part of 'a' called"):
        tc.Scene(bodies, duration=1.0)


def test_frames_are_read_when_asked_for(run):
    result, folder = run
    shutil.copy(folder / "result.vtkhdf", folder.parent / "copy.vtkhdf")
    stored = tc.open_result(folder.parent / "copy.vtkhdf")
    assert stored.steps == result.steps
    (folder.parent / "copy.vtkhdf").unlink()
    with pytest.raises(tc.InputError, match="copy"):
        stored.position
    assert len(tc.open_result(folder).frames) == len(result.frames) == 4


def test_an_opened_result_is_no_start_of_a_run_and_says_what_is(run, tmp_path):
    result, folder = run
    with pytest.raises(tc.InputError) as caught:
        tc.simulate(result.scene, initial=tc.open_result(folder), out=tmp_path / "on")
    assert caught.value.field == "initial"
    for text in ("holds no states of points and nodes", "that simulate returned in this program", "`tcontact resume`"):
        assert text in caught.value.remedy
    assert not (tmp_path / "on").exists()
    with pytest.raises(tc.InputError, match="give the Result of another run"):
        tc.simulate(result.scene, initial="run")


def test_what_is_not_in_the_files_is_refused_by_name(run, tmp_path):
    result, folder = run
    stored = tc.open_result(folder)
    for name in ("layers", "points", "contact_pressures", "scene", "scheme"):
        with pytest.raises(tc.InputError, match=name):
            getattr(stored, name)
    with pytest.raises(tc.InputError, match=r"scene=\.\.\."):
        stored.scene
    assert not hasattr(stored, "layers")
    with pytest.raises(AttributeError):
        stored.nonsense
    with pytest.raises(tc.InputError, match="'low'"):
        stored.nodes_of("lower")
    bare = tc.simulate(result.scene, out=tmp_path / "bare")
    assert bare.file == tmp_path / "bare" / "result.vtkhdf"
    with pytest.raises(tc.InputError, match="frames > 0"):
        tc.open_result(tmp_path / "bare").position
    assert len(bare.frames) == 1  # its end


@pytest.mark.parametrize("wrong", ["absent", "empty", "other", 7, ""])
def test_what_holds_no_run_is_refused(wrong, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "other").write_text("no result")
    place = tmp_path / wrong if isinstance(wrong, str) and wrong else wrong
    with pytest.raises(tc.InputError):
        tc.open_result(place)


def test_a_run_of_the_command_line_knows_its_scene(tmp_path):
    main(["run", "cube-impact", "--set", "cells=2", "--frames", "1", "--quiet", "--out", str(tmp_path / "run")])
    stored = tc.open_result(tmp_path / "run")
    assert stored.scene.bodies[0].mesh.cell_count == 8
    assert stored.scheme.name == "central-difference"
    assert stored.summary["case"] == "cube-impact"
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    summary["origin"]["case"] = "cube-inpact"
    (tmp_path / "run" / "summary.json").write_text(json.dumps(summary))
    with pytest.raises(tc.InputError, match="cube-inpact"):
        tc.open_result(tmp_path / "run").scene


@pytest.mark.parametrize(
    "case", sorted((Path(__file__).parent.parent / "cases").glob("[a-z]*.py")), ids=lambda p: p.stem
)
def test_a_case_asks_for_nothing_that_its_files_do_not_have(case, run):
    """Its curves are drawn again from them."""
    _, folder = run
    stored = tc.open_result(folder)
    functions = {node.name: node for node in ast.parse(case.read_text()).body if isinstance(node, ast.FunctionDef)}
    waiting, asked = [name for name in ("curves", "draw", "compared") if name in functions], set()
    for name in waiting:  # and what these call, and so on
        for node in ast.walk(functions[name]):
            if isinstance(node, ast.Attribute) and getattr(node.value, "id", "") == "result":
                asked.add(node.attr)
            called = getattr(node.func, "id", "") if isinstance(node, ast.Call) else ""
            if called in functions and called not in waiting:
                waiting.append(called)
    assert asked <= {*dir(stored)} - {"layers", "points", "contact_pressures"}


@pytest.mark.parametrize("end", ["memory", "file"])
def test_a_quantity_is_plotted(end, run):
    result, folder = run
    outcome = result if end == "memory" else tc.open_result(folder)
    axes = outcome.plot()
    names = [text.get_text() for text in axes.get_legend().get_texts()]
    assert names == ["obstacles", "top-low", "friction on the obstacles"]
    assert len({line.get_color() for line in axes.lines}) == 3
    np.testing.assert_allclose(axes.lines[1].get_xdata(), 1e3 * result.history["time"], rtol=1e-15)
    assert axes.get_xlabel() == "time [ms]"
    assert {text.get_text() for text in outcome.plot("energy").texts} >= {"kinetic", "elastic", "sum"}
    assert outcome.plot("gap").get_ylabel().startswith("smallest gap")
    drawn = outcome.plot("momentum")
    assert drawn.get_ylabel() == "momentum [kg m/s]"
    np.testing.assert_array_equal([line.get_ydata() for line in drawn.lines], result.history["momentum"].T)
    assert outcome.plot("contact_nodes", drawn) is drawn
    assert len(drawn.lines) == 4
    with pytest.raises(tc.InputError, match="quantity"):
        outcome.plot("forse")
    with pytest.raises(tc.InputError, match="axes = 3: give axes of matplotlib"):
        outcome.plot("contact_force", axes=3)
    mpl.pyplot.close("all")


def test_a_picture_is_drawn_of_any_frame(run, tmp_path):
    from PIL import Image

    result, folder = run
    stored = tc.open_result(folder)
    first, last = (stored.render(time=time, size=(320, 240)) for time in (0.0, None))
    assert first.shape == (240, 320, 3)
    assert (first != last).any()
    again = stored.render(tmp_path / "a" / "last.png", size=(320, 240), view="above")
    np.testing.assert_array_equal(again, last)
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "a" / "last.png")), last)
    alone = tc.simulate(result.scene)
    assert alone.render(size=(320, 240)).std() > 1.0  # without a file: the end
    for time in (0.0, 5.0):
        with pytest.raises(tc.InputError, match="there is one frame alone, at 0"):
            alone.render(time=time)
    for wrong in (
        {"field": "stress"},
        {"filed": 1},
        {"time": "late"},
        {"time": 5.0},
        {"size": (3, 3)},
        {"path": "a.xyz"},
    ):
        with pytest.raises(tc.InputError, match=next(iter(wrong))):
            stored.render(**wrong)


@pytest.mark.parametrize("end", ["memory", "file"])
def test_the_history_is_a_table_of_pandas(end, run):
    pytest.importorskip("pandas", reason="pandas is not installed")
    result, folder = run
    table = (result if end == "memory" else tc.open_result(folder)).to_pandas()
    np.testing.assert_array_equal(table.index, result.history["time"])
    assert table.index.name == "time"
    np.testing.assert_array_equal(table["momentum_y"], result.history["momentum"][:, 1])
    header = (folder / "history.csv").read_text().partition("\n")[0]
    assert ["time", *table.columns] == header.split(",")


def test_a_frame_is_a_grid_of_pyvista(run):
    pytest.importorskip("pyvista", reason="pyvista is not installed")
    result, folder = run
    stored = tc.open_result(folder)
    frame = stored.frames.frame(2)
    grid = stored.to_pyvista(frame.time)
    np.testing.assert_array_equal(grid.points, stored.frames.points + frame.point_data["displacement"])
    np.testing.assert_array_equal(grid.point_data["velocity"], frame.point_data["velocity"])
    np.testing.assert_array_equal(grid.cell_data["von_mises"], frame.cell_data["von_mises"])
    assert grid.field_data["time"][0] == frame.time
    volume = grid.compute_cell_sizes(length=False, area=False)["Volume"].sum()
    assert volume == pytest.approx(0.2 * 0.01 + 0.1**3, rel=0.05)
    some = result.to_pyvista(fields=["velocity"])
    assert (set(some.point_data), set(some.cell_data)) == ({"velocity"}, set())
    with pytest.raises(tc.InputError, match="the frames are from 0"):
        stored.to_pyvista(5.0)
    with pytest.raises(tc.InputError, match="fields"):
        stored.to_pyvista(fields=["spin"])


def test_wedges_and_tetrahedra_reach_pyvista_whole(tmp_path):
    pytest.importorskip("pyvista", reason="pyvista is not installed")
    mesh = tc.cylinder_mesh(0.1, 0.2, 3)
    result = tc.simulate(tc.Scene([tc.Body(mesh, tc.NeoHookean(1e6, 0.3, 1000.0))], duration=1e-4))
    grid = result.to_pyvista()
    assert grid.n_cells == mesh.cell_count
    sizes = grid.compute_cell_sizes(length=False, area=False)["Volume"]
    np.testing.assert_allclose(sizes, mesh.cell_volumes(), rtol=1e-9)


@pytest.mark.parametrize("package", ["pandas", "pyvista"])
def test_a_package_that_is_missing_is_named(package, run, monkeypatch):
    result, _ = run
    monkeypatch.setitem(__import__("sys").modules, package, None)
    with pytest.raises(tc.InputError, match=f"pip install {package}"):
        getattr(result, f"to_{package}")()
