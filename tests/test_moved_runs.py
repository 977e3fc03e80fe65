"""A run finds its scene file after both were moved, and after it was killed, or says what can be done."""

import json
import shutil
import signal

import numpy as np
import pytest
from stopped_runs import same_files, signalled

import tcontact as tc
from tcontact.commands.cli import main
from tcontact.results.stored import NotStored
from tcontact.run.checkpoint import store
from tcontact.run.checkpoint.keeper import Keeper

STL = """solid die
{}
endsolid die
"""


def triangle(corners):
    """Return a triangle of an STL file."""
    points = "\n".join("vertex {} {} {}".format(*corner) for corner in corners)
    return f"facet normal 0 0 0\nouter loop\n{points}\nendloop\nendfacet"


def project(place):
    """Write a scene file whose mesh and obstacle stand in files beside it; return the scene file."""
    place.mkdir()
    mesh = tc.box_mesh((0.06, 0.06, 0.04), (3, 3, 2), origin=(0.0, 0.0, 2e-4))
    np.savez(place / "block.npz", nodes=mesh.nodes, cells=mesh.cells, kind=np.array("hex8"))
    low, high = (-20.0, -20.0, -50.0), (80.0, 80.0, 0.0)
    corners = [[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)]
    sides = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    faces = [triangle([corners[k] for k in side]) for a, b, c, d in sides for side in ((a, b, c), (a, c, d))]
    (place / "die.stl").write_text(STL.format("\n".join(faces)))
    (place / "scene.toml").write_text(
        'duration = 1.2e-3\n[[bodies]]\nmesh = { file = "block.npz" }\nvelocity = [0.0, 0.0, -4.0]\n'
        'material = { type = "NeoHookean", young = 2e7, poisson = 0.3, density = 1200.0 }\n'
        'contact = "auto"\n'
        '[[obstacles]]\ntype = "Sdf"\nname = "die"\nsurface = "die.stl"\nscale = 1e-3\ncells = 20\n'
    )
    return place / "scene.toml"


@pytest.fixture
def stopped(tmp_path, monkeypatch):
    """The folder of a run that a signal has stopped in a project that was moved then, and one that was not stopped."""
    monkeypatch.setattr("tcontact.show.render.render_frames", lambda *_, **__: [])
    file = project(tmp_path / "first")
    command = ["run", str(file), "--set", "cfl=0.3", "--frames", "8", "--quiet", "--out"]
    assert main([*command, str(tmp_path / "straight")]) == 0
    with monkeypatch.context() as patch:
        signalled(patch, signal.SIGTERM, when=2)
        assert main([*command, str(file.parent / "runs" / "a")]) == 1
    (tmp_path / "elsewhere").mkdir()
    file.parent.rename(tmp_path / "elsewhere" / "moved é")
    return tmp_path / "elsewhere" / "moved é" / "runs" / "a", tmp_path / "straight"


def without_relative(folder):
    """Make the origin of a run that of an earlier version."""
    path = folder / "summary.json"
    summary = json.loads(path.read_text())
    del summary["origin"]["relative"]
    path.write_text(json.dumps(summary))


def test_a_moved_project_goes_on_and_knows_its_scene(stopped, monkeypatch):
    folder, straight = stopped
    monkeypatch.chdir(folder.parent)
    assert tc.open_result("a").scene.obstacles[0].name == "die"
    assert main(["resume", "a", "--quiet"]) == 0
    same_files(folder, straight)
    assert tc.open_result("a").scene.bodies[0].mesh.node_count == 48
    edited = folder.parent.parent / "scene.toml"
    edited.write_text(edited.read_text().replace("2e7", "3e7"))
    with pytest.raises(NotStored, match="makes another scene") as caught:
        tc.open_result(folder).scene
    assert str(edited) in str(caught.value)


def test_where_the_scene_file_is_at_neither_place_the_message_says_what_works(stopped, capsys):
    folder, straight = stopped
    file = folder.parent.parent / "scene.toml"
    away = file.rename(file.parent.parent / "scene.toml").parent
    for name in ("block.npz", "die.stl"):
        shutil.move(file.parent / name, away / name)
    assert main(["resume", str(folder), "--quiet"]) == 2
    said = capsys.readouterr().err
    assert str(file) in said
    assert "no such file" not in said
    for text in ("tcontact.load_scene(FILE)", "tcontact.resume(folder, scene)", "open_result(folder, scene=...)"):
        assert text in said
    with pytest.raises(tc.InputError, match=r"open_result\(folder, scene"):
        tc.open_result(folder).scene
    without_relative(folder)  # as earlier versions left it
    with pytest.raises(tc.InputError, match="is not there; put it back"):
        tc.open_result(folder).scene
    scene, _ = tc.load_scene(away / "scene.toml")  # what the message says
    assert tc.open_result(folder, scene=scene).scene is scene
    assert tc.resume(folder, scene, tc.CentralDifference(cfl=0.3)).ok
    assert (folder / "history.csv").read_bytes() == (straight / "history.csv").read_bytes()


def test_the_origin_of_an_earlier_version_is_read_where_its_scene_file_is(tmp_path, monkeypatch):
    monkeypatch.setattr("tcontact.show.render.render_frames", lambda *_, **__: [])
    file = project(tmp_path / "first")
    assert main(["run", str(file), "--frames", "1", "--quiet", "--out", str(tmp_path / "run")]) == 0
    without_relative(tmp_path / "run")
    assert tc.open_result(tmp_path / "run").scene.obstacles[0].name == "die"


def test_a_run_that_was_killed_knows_its_scene_by_its_checkpoint(tmp_path, monkeypatch):
    monkeypatch.setattr("tcontact.show.render.render_frames", lambda *_, **__: [])
    file, save = project(tmp_path / "first"), Keeper.save

    def copied(self, run, row):
        save(self, run, row)
        if not (tmp_path / "killed").exists():
            shutil.copytree(self.folder, tmp_path / "killed")

    monkeypatch.setattr(Keeper, "save", copied)
    command = ["run", str(file), "--frames", "6", "--quiet", "--checkpoint", "1e-6", "--out", str(tmp_path / "run")]
    assert main(command) == 0
    stored = tc.open_result(tmp_path / "killed")
    assert (stored.reason, stored.summary) == ("running", {})
    assert stored.scene.obstacles[0].name == "die"
    assert stored.scheme.name == "central-difference"
    file.write_text(file.read_text().replace("2e7", "3e7"))
    with pytest.raises(NotStored, match=r"another scene.*young"):
        tc.open_result(tmp_path / "killed").scene
    store.remove(tmp_path / "killed")
    with pytest.raises(NotStored) as caught:
        tc.open_result(tmp_path / "killed").scene
    assert "a program made it" not in str(caught.value)
    assert "was killed before it wrote summary.json" in str(caught.value)
    assert "open_result(folder, scene=...)" in str(caught.value)
