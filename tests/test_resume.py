"""A run that stopped and was resumed has the bits of one that never stopped: results, history, frames."""

import dataclasses
import json
import random
import shutil
import signal

import numpy as np
import pytest
from scenes import python
from stopped_runs import MORE_SCENES, SCENES, copied, quietly, same, same_files, scene, signalled

import tcontact as tc
from tcontact.commands.cli import main
from tcontact.results import checks as ck
from tcontact.results.files.vtkhdf import ResultData, ResultFile
from tcontact.run.checkpoint import store
from tcontact.schemes import SCHEMES

FINE = tc.CentralDifference(cfl=0.3)


def split(monkeypatch, folder, physics, points, scheme=FINE, every=7, seed=1, **options):
    """Compare a run with runs that were split at random checkpoints."""
    options = {"frames": 5, "pressures": True} | options
    whole, copies = copied(monkeypatch, folder, physics, scheme, every, **options)
    assert whole.ok
    assert len(copies) >= points
    for row in random.Random(seed).sample(sorted(copies), points):
        same(quietly(tc.resume, copies[row], physics, scheme), whole)
        same_files(copies[row], folder / "whole")
    return whole


FELT = (
    "applied_impulse", "spring_work", "support_force", "pair_force:upper-lower", "rigid_force", "friction_work",
    "obstacle_velocity:ball", "part_angular_velocity:upper-zmax", "probe_upper_xmax_acceleration", "von_mises_max",
)  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
def test_a_split_run_has_the_same_bits(name, monkeypatch, tmp_path):
    whole = split(monkeypatch, tmp_path, SCENES[name](), 2)
    assert np.abs(whole.history["contact_force"]).max() > 0.0
    if "layer" in name:
        assert whole.history["layer_heat"][-1] > 0.0
    if "viscosity" in name:
        assert whole.history["viscous_work"][-1] > 0.0
    if "loads" in name:
        assert ck.momentum_balance(whole, 1e-12).passed
        assert ck.energy(whole, 5e-2).passed
        assert all(np.abs(whole.history[column]).max() > 0.0 for column in FELT)


IMPLICIT = {
    "discrete-gradient": tc.MasslessContact(removal="full"),
    "midpoint": tc.MasslessContact(removal="normal"),
    "hilber-hughes-taylor": tc.MasslessContact(removal="full"),
}


@pytest.mark.parametrize(
    "name", ["discrete-gradient", *(pytest.param(n, marks=pytest.mark.slow) for n in list(IMPLICIT)[1:])]
)
def test_a_split_implicit_run_has_the_same_bits(name, monkeypatch, tmp_path):
    scheme = SCHEMES[name](dt=2e-5)
    split(monkeypatch, tmp_path, scene(duration=6e-4, contact=IMPLICIT[name]), 2, scheme, every=5)


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES | MORE_SCENES)
def test_split_at_twenty_random_points(name, monkeypatch, tmp_path):
    split(monkeypatch, tmp_path, (SCENES | MORE_SCENES)[name](), 20, tc.CentralDifference(cfl=0.15), every=3)


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES | MORE_SCENES)
def test_bodies_that_do_one_step_at_once(name, monkeypatch, tmp_path, parallel_path):
    split(monkeypatch, tmp_path, (SCENES | MORE_SCENES)[name](), 3, tc.CentralDifference(cfl=0.02), frames=9)


def test_the_step_goes_on_shrinking_where_it_did(monkeypatch, tmp_path):
    """The stable step is estimated again as a nonlinear body deforms, from the mode that was found before."""
    fast = scene(velocity=(0.0, 0.0, -60.0), duration=2e-3)
    whole = split(monkeypatch, tmp_path, fast, 6, tc.CentralDifference(), every=2, frames=3)
    steps = np.diff(whole.history["time"])
    assert steps[1:-1].min() < 0.99 * steps[0]


def test_thinned_history_and_a_start_from_another_run(monkeypatch, tmp_path):
    physics = scene(duration=6e-4)
    first = tc.simulate(physics, FINE)
    split(monkeypatch, tmp_path, physics, 2, history_every=4, initial=first.reversed(), frames=0)


def test_the_largest_force_and_energy_error_of_all_steps_go_on(monkeypatch, tmp_path):
    """A split run that keeps few rows has the largest values of the run that keeps all, to the bit."""
    thin = split(monkeypatch, tmp_path, scene(duration=6e-4), 3, every=2, history_every=50, frames=0)
    assert thin.peaks == tc.simulate(scene(duration=6e-4), FINE).peaks
    assert np.linalg.norm(thin.history["contact_force"], axis=1).max() < thin.peaks["contact_force"]


def test_a_history_that_thins_itself(monkeypatch, tmp_path):
    whole = split(monkeypatch, tmp_path, scene(), 3, history_rows=6, pressures=True, frames=0)
    assert len(whole.history["time"]) <= 7 < whole.steps


def test_friction_layers_of_another_run(monkeypatch, tmp_path):
    """What the other run left is in the checkpoint, also of nodes that have not touched since."""
    physics = SCENES["friction layers on masses"]()
    first = tc.simulate(physics, FINE)
    assert first.layers[0].temperature.max() > 301.0
    whole = split(monkeypatch, tmp_path, physics, 2, initial=first, frames=2)
    assert whole.history["layer_temperature_max"][0] > 301.0


def test_resumed_twice(monkeypatch, tmp_path):
    physics = SCENES["full removal"]()
    whole, copies = copied(monkeypatch, tmp_path, physics, FINE, 9, frames=4)
    first = min(copies)
    _, again = copied_resume(monkeypatch, copies[first], tmp_path / "again", physics)
    same(tc.resume(again[max(again)], physics, FINE), whole)
    same_files(again[max(again)], tmp_path / "whole")


def copied_resume(monkeypatch, folder, copies_in, physics):
    """Resume and copy the folder at every checkpoint that the resumed run leaves."""
    from tcontact.run.checkpoint.keeper import Keeper

    copies, save = {}, Keeper.save

    def save_and_copy(self, run, row):
        save(self, run, row)
        copies[row] = shutil.copytree(self.folder, copies_in / str(row))

    with monkeypatch.context() as patch:
        patch.setattr(Keeper, "save", save_and_copy)
        return tc.resume(folder, physics, FINE, checkpoint={"every_steps": 9}), copies


ON_ONE_THREAD = """
import sys, tcontact as tc
from tcontact.planning.body_plan import SMALL
from stopped_runs import SCENES, quietly
SMALL.update(dict.fromkeys(SMALL, 0))
quietly(tc.resume, sys.argv[1], SCENES[sys.argv[2]](), tc.CentralDifference(cfl=0.3), threads=1)
"""


def test_resumed_on_another_number_of_threads(monkeypatch, tmp_path, parallel_path):
    """On the path that uses the threads, which few cells do not take."""
    name = "friction in massless components"
    _, copies = copied(monkeypatch, tmp_path, SCENES[name](), FINE, 15, frames=4)
    row = sorted(copies)[1]
    done = python(ON_ONE_THREAD, copies[row], name)
    assert done.returncode == 0, done.stderr
    same_files(copies[row], tmp_path / "whole")


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    """A run that stopped, not to be written to, and its scene."""
    folder, physics = tmp_path_factory.mktemp("stopped"), SCENES["full removal"]()
    with pytest.MonkeyPatch.context() as patch:
        _, copies = copied(patch, folder, physics, FINE, 9, frames=4)
    return copies[sorted(copies)[2]], physics


@pytest.mark.parametrize(
    ("field", "change"),
    [
        ("bodies[0].material.young", lambda s: _body(s, material=tc.NeoHookean(2.1e7, 0.3, 1200.0))),
        ("bodies[0].material", lambda s: _body(s, material=tc.LinearElastic(2e7, 0.3, 1200.0))),
        ("bodies[0].velocity", lambda s: _body(s, velocity=(1.0, 0.5, -4.5))),
        ("bodies[0].mesh.nodes", lambda s: _body(s, mesh=tc.box_mesh((0.06, 0.06, 0.05), (3, 3, 2)))),
        ("obstacles[0].point", lambda s: dataclasses.replace(s, obstacles=[tc.Plane((0, 0, -1e-3))])),
        ("duration", lambda s: dataclasses.replace(s, duration=2e-3)),
        ("gravity", lambda s: dataclasses.replace(s, gravity=None)),
        ("friction", lambda s: dataclasses.replace(s, friction=tc.Coulomb(0.1))),
        ("contact.removal", lambda s: dataclasses.replace(s, contact=tc.MasslessContact(removal="normal"))),
    ],
)
def test_changed_physics_is_refused_by_name(stopped, field, change):
    folder, physics = stopped
    before = {path: path.read_bytes() for path in folder.iterdir()}
    with pytest.raises(tc.InputError, match="the run that is to go on had") as caught:
        tc.resume(folder, change(physics), FINE)
    assert caught.value.field == field
    assert {path: path.read_bytes() for path in folder.iterdir() if path.name != ".running"} == {
        path: data for path, data in before.items() if path.name != ".running"
    }


def _body(physics, **changes):
    return dataclasses.replace(physics, bodies=[dataclasses.replace(physics.bodies[0], **changes)])


def test_another_scheme_is_refused_by_name(stopped):
    folder, physics = stopped
    with pytest.raises(tc.InputError, match=r"had 0\.3") as caught:
        tc.resume(folder, physics, tc.CentralDifference(cfl=0.31))
    assert caught.value.field == "scheme.cfl"


def test_two_checkpoints_are_kept_and_a_damaged_one_is_passed_over(stopped, tmp_path):
    folder, physics = stopped
    whole = tc.resume(shutil.copytree(folder, tmp_path / "good"), physics, FINE)
    good, bad = store.read_all(folder)
    assert len(good) == 2
    assert good[0].row > good[1].row
    assert not bad
    data = good[0].path.read_bytes()
    generator = random.Random(5)
    for number in range(6):
        place = shutil.copytree(folder, tmp_path / str(number))
        damaged = bytearray(data)
        if number == 0:
            damaged = damaged[: len(data) // 2]
        elif number == 1:
            damaged = bytearray()
        else:
            for _ in range(40):
                damaged[generator.randrange(len(data))] ^= 1 << generator.randrange(8)
        (place / good[0].path.name).write_bytes(bytes(damaged))
        left, broken = store.read_all(place)
        assert [stored.row for stored in left] == [good[1].row]
        assert broken == [place / good[0].path.name]
    with pytest.warns(RuntimeWarning, match="damaged and passed over"):
        same(tc.resume(place, physics, FINE), whole)
    same_files(place, tmp_path / "good")


def test_a_checkpoint_of_another_format_is_refused_by_its_name(stopped, tmp_path, monkeypatch):
    """It is not called damaged, and nothing in the folder changes; beside a readable one it is passed over."""
    folder, physics = stopped
    place = shutil.copytree(folder, tmp_path / "old")
    good, _ = store.read_all(place)
    head = good[0].head | {"versions": {"tcontact": "0.0.9"}}
    with monkeypatch.context() as patch:
        patch.setattr(store, "FORMAT", 3)
        store.write(place, head, good[0].values, good[0].found)  # replaces the older one
    left, damaged = store.read_all(place)
    assert len(left) == 1
    assert not damaged
    left[0].path.unlink()
    with pytest.raises(tc.InputError, match=r"format 3, written by version 0\.0\.9, and this one reads 4") as caught:
        tc.resume(place, physics, FINE)
    assert caught.value.field == "folder"


@pytest.mark.parametrize("path", ["domains.0.unheard", "unheard/count"])
def test_a_checkpoint_with_a_value_that_the_run_does_not_have_is_refused_by_its_name(stopped, tmp_path, path):
    folder, physics = stopped
    place = shutil.copytree(folder, tmp_path / "other")
    stored = store.read_all(place)[0][0]
    stored.path.unlink()
    store.write(place, stored.head, stored.values | {path: 1.0}, stored.found)
    with pytest.raises(tc.InputError, match=f"holds {path}, .*; resume it with that one, or run it again") as caught:
        tc.resume(place, physics, FINE)
    assert caught.value.field == "folder"


def test_without_anything_to_go_on_from(stopped, tmp_path):
    folder, physics = stopped
    for data in (b"", b"nonsense" * 100):
        place = shutil.copytree(folder, tmp_path / str(len(data)))
        for name in store.FILES:
            (place / name).write_bytes(data)
        with pytest.warns(RuntimeWarning), pytest.raises(tc.InputError, match="damaged; run again"):
            tc.resume(place, physics, FINE)
    for name in store.FILES:
        (place / name).unlink()
    with pytest.raises(tc.InputError, match="no checkpoint"):
        tc.resume(place, physics, FINE)
    (tmp_path / "empty").mkdir()
    with pytest.raises(tc.InputError, match="holds no run"):
        tc.resume(tmp_path / "empty", physics, FINE)
    with pytest.raises(tc.InputError, match="no such folder"):
        tc.resume(tmp_path / "absent", physics, FINE)
    tc.simulate(physics, FINE, out=tmp_path / "ended", frames=2, checkpoint={"every_steps": 20})
    with pytest.raises(tc.InputError, match="has ended"):
        tc.resume(tmp_path / "ended", physics, FINE)
    data = ResultFile.reopen(tmp_path / "ended" / "result.vtkhdf", 2, {})
    data.write_attributes({"reason": "interrupted"})
    data.close()
    with pytest.raises(tc.InputError, match="interrupted and left no checkpoint"):
        tc.resume(tmp_path / "ended", physics, FINE)


def test_a_result_file_with_too_few_frames_is_refused(stopped, tmp_path):
    folder, physics = stopped
    place = shutil.copytree(folder, tmp_path / "short")
    ResultFile.reopen(place / "result.vtkhdf", 0).close()
    assert len(ResultData.open(place / "result.vtkhdf")) == 0
    with pytest.raises(tc.InputError, match="fewer than its checkpoints"):
        tc.resume(place, physics, FINE)


def stop(monkeypatch, command):
    """Run a command in which Ctrl-C is pressed when its fourth frame is written."""
    with monkeypatch.context() as patch:
        signalled(patch, signal.SIGINT, when=3)
        assert main(command) == 1


@pytest.mark.parametrize("what", ["case", "scene file"])
def test_the_command_line_goes_on_where_ctrl_c_stopped(what, monkeypatch, tmp_path, capsys):
    command = ["run", "cube-impact", "--set", "cells=4", "--set", "yaw=10", "--set", "cfl=0.5", "--frames", "5"]
    if what == "scene file":
        tc.save_scene(SCENES["full removal"](), tmp_path / "drop.toml")
        monkeypatch.chdir(tmp_path)
        command = ["run", "drop.toml", "--set", "cfl=0.4", "--frames", "5"]
    assert main([*command, "--out", str(tmp_path / "straight"), "--quiet"]) == 0
    place = tmp_path / "stopped"
    stop(monkeypatch, [*command, "--out", str(place)])
    assert f"tcontact resume {place}" in capsys.readouterr().out
    assert main(["resume", str(place), "--quiet"]) == 0
    same_files(place, tmp_path / "straight")
    mine, theirs = (json.loads((folder / "summary.json").read_text()) for folder in (place, tmp_path / "straight"))
    for name in ("case", "parameters", "checks", "steps", "reason", "last_row", "passed", "smoothness"):
        assert mine[name] == theirs[name], name
    frames = [sorted(path.name for path in (folder / "frames").iterdir()) for folder in (place, tmp_path / "straight")]
    assert frames[0] == frames[1]
    assert main(["resume", str(place)]) == 2
    assert "has ended" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("run", "resume", "expected"),
    [
        ({"threads": 2}, [], (2, "cpu")),
        ({"threads": 2}, ["--threads", "3", "--arch", "cuda"], (3, "cuda")),
        ({"threads": 2, "arch": "cuda"}, [], (2, "cpu")),
        ({}, [], (None, "cpu")),
    ],
    ids=["file", "command line", "stored", "neither"],
)
def test_a_resumed_run_takes_the_options_of_its_scene_file(run, resume, expected, monkeypatch, tmp_path):
    """As `tcontact run` does: the command line goes first; where the run computed, it goes on."""
    file, place = tmp_path / "drop.toml", tmp_path / "stopped"
    tc.save_scene(SCENES["full removal"](), file, **run)
    stop(monkeypatch, ["run", str(file), "--arch", "cpu", "--frames", "5", "--out", str(place), "--quiet"])
    taken = []

    def note(*_given, threads, arch, **_options):
        taken.append((threads, arch))
        raise tc.InputError("resume", place, "noted")

    with monkeypatch.context() as patch:
        patch.setattr(tc, "resume", note)
        assert main(["resume", str(place), *resume, "--quiet"]) == 2
    assert taken == [expected]


def test_a_run_of_a_program_is_resumed_by_a_program(stopped, capsys):
    assert main(["resume", str(stopped[0])]) == 2
    assert "tcontact.resume(folder, scene)" in capsys.readouterr().err


@pytest.mark.parametrize(
    "value", [0.0, -1.0, np.nan, "often", {"every": 3}, {"every_steps": 0}, {}, {"every_steps": 1.5}]
)
def test_bad_options_are_refused(value, tmp_path):
    with pytest.raises(tc.InputError, match="checkpoint"):
        tc.simulate(SCENES["full removal"](), out=tmp_path / "out", checkpoint=value)
    assert not (tmp_path / "out").exists()


def test_a_checkpoint_needs_a_folder():
    with pytest.raises(tc.InputError, match="give out too"):
        tc.simulate(SCENES["full removal"](), checkpoint=1.0)
