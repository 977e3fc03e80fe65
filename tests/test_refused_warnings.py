"""Warnings that a user has turned into errors stop a run whole, name the line of the script; results without an end."""

import errno
import warnings

import numpy as np
import pytest
from stopped_runs import SCENES, quietly, same

import tcontact as tc
from tcontact.commands.cli import main
from tcontact.results.files.vtkhdf import ResultFile
from tcontact.run.loop import Run

FINE = tc.CentralDifference(cfl=0.3)


def energetic():
    """Return a block on a penalty that gains energy: a warning at the end of its run."""
    cube = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2))
    body = tc.Body(cube, tc.NeoHookean(1e6, 0.3, 1e3), velocity=(0.0, 0.0, -20.0), contact="zmin")
    return tc.Scene([body], [tc.Plane()], 2e-3, contact=tc.PenaltyContact(stiffness=2e10))


@pytest.mark.parametrize("out", ["run", None])
def test_a_warning_at_the_end_that_is_an_error_costs_no_file_and_no_result(out, tmp_path):
    place = out and tmp_path / out
    with warnings.catch_warnings():
        warnings.simplefilter("error", tc.EnergyWarning)
        with pytest.raises(tc.EnergyWarning) as caught:
            tc.simulate(energetic(), out=place, frames=3)
    result = caught.value.result
    assert (result.ok, result.warnings) == (True, [str(caught.value)])
    if place is not None:
        stored = tc.open_result(place, energetic())
        assert (stored.reason, len(stored.frames)) == ("finished", 3)
        assert np.array_equal(stored.history["time"], result.history["time"])
        assert (place / "history.csv").is_file()
        assert stored.summary["warnings"] == result.warnings


def test_a_warning_amid_a_run_that_is_an_error_stops_it_whole(monkeypatch, tmp_path):
    """The run goes on from there."""
    watch = Run._watch

    def warned(run, row, number):
        if number == 20:
            run.warn("too odd", tc.RotationWarning)
        watch(run, row, number)

    monkeypatch.setattr(Run, "_watch", warned)
    monkeypatch.setattr(Run, "_rows_until", lambda *_: 1)
    place, scene = tmp_path / "run", SCENES["full removal"]()
    with warnings.catch_warnings():
        warnings.simplefilter("error", tc.RotationWarning)
        with pytest.raises(tc.RotationWarning, match="too odd") as caught:
            tc.simulate(scene, FINE, out=place, frames=5, checkpoint=tc.Checkpoint(every_steps=5))
    result = caught.value.result
    assert (result.reason, result.steps) == ("interrupted", 21)
    assert "stopped by RotationWarning, which is an error here (too odd), at t = " in result.message
    assert tc.open_result(place).message == result.message
    monkeypatch.undo()
    same(quietly(tc.resume, place, scene, FINE), quietly(tc.simulate, scene, FINE))


def test_a_warning_before_the_run_that_is_an_error_leaves_nothing(tmp_path):
    stiff = tc.NeoHookean(1e6, 0.49, 1e3)
    scene = tc.Scene([tc.Body(tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2)), stiff, formulation="full")], duration=1e-5)
    with warnings.catch_warnings():
        warnings.simplefilter("error", tc.LockingWarning)
        with pytest.raises(tc.LockingWarning):
            tc.simulate(scene, out=tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_warnings_name_the_line_of_the_script():
    """Those at the end of a run and those before it."""
    code = """
import warnings
import tcontact as tc
mesh = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2))
body = tc.Body(mesh, tc.NeoHookean(1e6, 0.3, 1e3), velocity=(0, 0, -20), contact="zmin")
scene = tc.Scene([body], [tc.Plane()], 2e-3, contact=tc.PenaltyContact(stiffness=2e10))
with warnings.catch_warnings(record=True) as seen:
    warnings.simplefilter("always")
    tc.simulate(scene)
assert seen
assert all(one.filename == "script.py" and one.lineno == 9 for one in seen), [str(one) for one in seen]
"""
    exec(compile(code, "script.py", "exec"), {"__name__": "script"})


def test_a_run_that_could_not_write_its_first_frame_is_read_back_as_such(monkeypatch, tmp_path, capsys):
    """Its result file says nothing of its end."""

    def full(*_given):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(ResultFile, "append", full)
    place = tmp_path / "run"
    with pytest.raises(tc.OutputError) as caught:
        quietly(tc.simulate, SCENES["full removal"](), FINE, out=place, frames=3)
    stored = tc.open_result(place)
    assert (stored.ok, stored.reason) == (False, "not-written")
    assert stored.message == caught.value.result.message
    assert main(["info", str(place)]) == 0
    said = capsys.readouterr().out
    assert "not-written" in said
    assert "the run has not ended" not in said
