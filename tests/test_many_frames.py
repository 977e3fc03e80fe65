"""Times of frames, sets of a mesh and probes are looked at in proportion to their number."""

import numpy as np
import pytest
from counted import Name, Time
from stopped_runs import copied, quietly, same, same_files, scene

import tcontact as tc
from tcontact.run.checkpoint import contents
from tcontact.run.loop import Run

RUBBER = tc.NeoHookean(young=1e6, poisson=0.3, density=1000.0)


def looks(monkeypatch, folder, frames):
    """Return how often a run of so many frames looks at the times of its frames."""
    begin = Run._begin

    def counted(run, *given):
        begin(run, *given)
        run.course.due = [Time(when) for when in run.course.due]

    Time.uses = 0
    with monkeypatch.context() as patch:
        patch.setattr(Run, "_begin", counted)
        body = tc.Body(tc.box_mesh((0.1,) * 3, (1, 1, 1)), RUBBER, velocity=(0, 0, 0.1))
        made = tc.Scene([body], duration=(frames - 1) * 1e-4)
        result = tc.simulate(made, scheme=tc.CentralDifference(dt=1e-4), frames=frames, out=folder)
    assert len(result.frames.times) == frames
    return Time.uses


def test_a_frame_does_not_look_at_the_times_of_all_others(monkeypatch, tmp_path):
    """Twice as many frames, twice as many looks."""
    few, many = (looks(monkeypatch, tmp_path / str(frames), frames) for frames in (20, 40))
    assert 0 < many <= 2.2 * few


def test_checkpoints_of_earlier_versions_hold_the_times_that_are_left(monkeypatch, tmp_path):
    """They name no number of times that have passed; a run that goes on from one writes the frames of the whole one."""
    collect = contents.collect

    def earlier(run, new):
        found, values = collect(run, new)
        passed = values.pop("course.passed")
        values["course.due"] = values["course.due"][passed:]
        return found, values

    monkeypatch.setattr(contents, "collect", earlier)
    whole, copies = copied(monkeypatch, tmp_path, scene(), tc.CentralDifference(cfl=0.3), 20, frames=7)
    assert whole.ok
    row = sorted(copies)[len(copies) // 2]
    same(quietly(tc.resume, copies[row], scene(), tc.CentralDifference(cfl=0.3)), whole)
    same_files(copies[row], tmp_path / "whole")


def test_the_last_row_of_the_history_stands_beside_the_largest_number_of_rows():
    """A history of two rows has two that were kept and the last one."""
    body = tc.Body(tc.box_mesh((0.1,) * 3, (1, 1, 1)), RUBBER, velocity=(0, 0, 0.1))
    made = tc.Scene([body], duration=11e-4)
    time = quietly(tc.simulate, made, tc.CentralDifference(dt=1e-4), history_rows=2).history["time"]
    assert len(time) == 3
    assert time[-1] == pytest.approx(11e-4)
    assert "beside the last one, which is always kept" in tc.simulate.__doc__


@pytest.mark.parametrize("read", [tc.Mesh.nodes_of, tc.Mesh.faces_of])
def test_reading_a_set_does_not_go_through_all_sets(read):
    """Four times as many sets of a mesh are found with four times as many looks at names."""
    uses = []
    for count in (8, 32):
        mesh = tc.box_mesh((0.1,) * 3, (2, 2, 2))
        names = [Name(f"s{i}") for i in range(count)]
        mesh = mesh.with_sets(face_sets=dict.fromkeys(names, mesh.face_sets["zmax"]))
        Name.uses = 0
        for name in names:
            assert len(read(mesh, name))
        uses.append(Name.uses)
    assert uses[1] <= 4 * uses[0]
    with pytest.raises(tc.InputError, match="use one of the sets of this mesh: xmin, xmax, "):
        read(mesh, "S31")


def test_a_probe_is_not_compared_with_each_other_one():
    """Four times as many probes of a body are checked with four times as many looks at their names."""
    uses = []
    for count in (8, 32):
        mesh = tc.box_mesh((0.1,) * 3, (3, 3, 3))
        names = [Name(f"s{i}") for i in range(count)]
        mesh = mesh.with_sets(node_sets={name: np.array([i]) for i, name in enumerate(names)})
        probes = [tc.Probe(name, "velocity") for name in names]
        Name.uses = 0
        tc.Body(mesh, RUBBER, probes=probes)
        uses.append(Name.uses)
    assert uses[1] <= 4.2 * uses[0]
    with pytest.raises(tc.InputError, match="is there twice; name it once"):
        tc.Body(mesh, RUBBER, probes=[*probes, probes[3]])
