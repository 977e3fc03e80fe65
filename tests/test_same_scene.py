"""A result opened from its folder gives the scene that was run, or says that its file makes another one by now."""

import dataclasses
import json

import numpy as np
import pytest

import tcontact as tc
from tcontact.commands import same_scene
from tcontact.commands.cli import main
from tcontact.results.stored import NotStored
from tcontact.run.checkpoint.fingerprint import fingerprint


def scene(cells=2, young=1e7, pressure=1e3):
    """A block under a pressure."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (cells, cells, cells))
    load = tc.Load("zmax", pressure=pressure)
    law = tc.NeoHookean(young=young, poisson=0.3, density=1e3)
    body = tc.Body(mesh, law, velocity=(0.0, 0.0, -1.0), contact="zmin", loads=[load])
    return tc.Scene([body], [tc.Plane(point=(0.0, 0.0, -0.01))], duration=1e-4)


@pytest.fixture
def run(tmp_path):
    """A scene file and the folder of its run."""
    tc.save_scene(scene(), tmp_path / "block.toml")
    assert main(["run", str(tmp_path / "block.toml"), "--frames", "1", "--quiet", "--out", str(tmp_path / "run")]) == 0
    return tmp_path / "block.toml", tmp_path / "run"


def summary_of(folder, change):
    """Change the summary of a run."""
    path = folder / "summary.json"
    found = json.loads(path.read_text())
    change(found)
    path.write_text(json.dumps(found))


def test_a_file_that_says_the_same_gives_the_scene(run):
    file, folder = run
    file.write_text("# a remark\n" + file.read_text())
    stored = tc.open_result(folder)
    assert stored.scene.bodies[0].mesh.node_count == len(stored.position) == 27
    assert stored.scheme.name == "central-difference"


EDITS = {
    "bodies[0].material.young": {"young": 5e8},
    "bodies[0].mesh.nodes": {"cells": 3},
    "bodies[0].loads[0].pressure": {"pressure": 2e3},
}


@pytest.mark.parametrize("name", EDITS)
def test_an_edit_is_named(name, run):
    """What the files hold is read as before."""
    file, folder = run
    tc.save_scene(scene(**EDITS[name]), file)
    stored = tc.open_result(folder)
    for ask in ("scene", "scheme"):
        with pytest.raises(NotStored) as caught:
            getattr(stored, ask)
        assert name in str(caught.value)
        assert "where the run had" in caught.value.remedy
        assert "open_result(folder, scene=...)" in caught.value.remedy
        assert file.name in caught.value.remedy
    assert len(stored.position) == 27
    assert stored.case is not None
    assert main(["render", str(folder), "--plots"]) == 0
    assert tc.open_result(folder, scene=scene()).scene.bodies[0].mesh.node_count == 27


def test_runs_without_a_fingerprint_are_compared_by_their_nodes(run):
    file, folder = run
    summary_of(folder, lambda found: found.pop("fingerprint"))
    tc.save_scene(scene(young=2e7), file)
    assert tc.open_result(folder).scene.bodies[0].material.young == 2e7, "the nodes do not tell"
    tc.save_scene(scene(cells=3), file)
    with pytest.raises(NotStored, match="it has 64 nodes, where the run had 27"):
        tc.open_result(folder).scene
    moved = scene()
    body = dataclasses.replace(moved.bodies[0], mesh=moved.bodies[0].mesh.translated((1e-3, 0.0, 0.0)))
    tc.save_scene(dataclasses.replace(moved, bodies=[body]), file)
    with pytest.raises(NotStored, match=r"nodes lie up to 0\.001 m away"):
        tc.open_result(folder).scene


def test_options_that_another_version_has_are_no_difference(run):
    _, folder = run

    def older(found):
        found["versions"]["tcontact"] = "0.0.1"
        found["fingerprint"].pop("gravity")
        found["fingerprint"]["old_option"] = "None"

    summary_of(folder, older)
    assert tc.open_result(folder).scene.duration == 1e-4
    summary_of(folder, lambda found: found["fingerprint"].update({"duration": "1.0"}))
    with pytest.raises(NotStored, match=r"duration is 0\.0001, where the run had 1\.0"):
        tc.open_result(folder).scene


def test_an_edit_of_a_function_of_time_is_a_difference():
    def held(rate):
        return dataclasses.replace(scene(), gravity=lambda time: (0.0, 0.0, -rate * time))

    one, same, other = (same_scene.kept(held(rate), tc.CentralDifference()) for rate in (9.0, 9.0, 9.00001))
    assert one == same
    assert one != other
    generator = np.random.default_rng(0)
    noisy = dataclasses.replace(scene(), gravity=lambda time: generator.random(3))
    assert same_scene.kept(noisy, tc.CentralDifference()) == {}, "there is nothing to compare"


@pytest.mark.parametrize("words", [("compare=true",), ("scheme=gonzalez", "dt=0.002")], ids=str)
def test_runs_of_cases_under_every_scheme_give_their_scene(words, tmp_path):
    chosen = [part for word in words for part in ("--set", word)]
    main(["run", "tumbling-block", "--set", "cells=2", *chosen, "--frames", "0", "--quiet", "--out", str(tmp_path)])
    folders = [path.parent for path in tmp_path.rglob("result.vtkhdf")]
    assert len(folders) == (5 if words[0] == "compare=true" else 1)
    for folder in folders:
        stored = tc.open_result(folder)
        assert stored.scene.bodies[0].mesh.node_count == stored.summary["nodes"]


def test_last_digits_are_no_difference_and_the_tenth_one_is_below_notice():
    """Processors differ in the last digits of sines and roots."""
    one, scheme = scene(), tc.CentralDifference()
    mesh = one.bodies[0].mesh
    words = {}
    for shift in (0.0, 1e-16, 1e-6):
        nodes = mesh.nodes * (1.0 + shift) + 1e-17 * (shift > 0.0)
        law = dataclasses.replace(one.bodies[0].material, young=1e7 * (1.0 + 4.0 * shift))
        changed = tc.Mesh(nodes, mesh.cells, "hex8", face_sets=mesh.face_sets)
        other = dataclasses.replace(one, bodies=[dataclasses.replace(one.bodies[0], mesh=changed, material=law)])
        words[shift] = [fingerprint(other, scheme, rounded=rounded) for rounded in (False, True)]
    assert words[1e-16][0] != words[0.0][0]
    assert words[1e-16][1] == words[0.0][1]
    for name in ("bodies[0].mesh.nodes", "bodies[0].material.young"):
        assert words[1e-6][1][name] != words[0.0][1][name]
    assert not np.array_equal(mesh.nodes, nodes)
