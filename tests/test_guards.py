"""Runs that cannot go on stop with cell, time and remedy; Ctrl-C keeps everything."""

import json
import re
import signal
import subprocess
import sys

import numpy as np
import pytest
from scenes import ROOT, bar_speed, block, material, thrown, wall

import tcontact as tc
from tcontact.results.files.vtkhdf import ResultData

PLACE = re.compile(r"cell (\d+) of body-0 \(reference centre ([-.\d e]+), ([-.\d e]+), ([-.\d e]+)\) has det F = ")
TIME = re.compile(r"t = ([-+.\de]+) s")


def explained(result):
    """The message names a cell of the mesh by its centre and the time of the last row."""
    place = PLACE.search(result.message)
    assert place, result.message
    mesh = result.scene.bodies[0].mesh
    centre = mesh.nodes[mesh.cells[int(place[1])]].mean(axis=0)
    assert np.allclose(centre, [float(place[k]) for k in (2, 3, 4)], rtol=1e-3, atol=1e-3)
    assert float(TIME.search(result.message)[1]) == pytest.approx(result.time, rel=1e-5)
    assert not result.ok
    assert len(result.history["time"]) == result.steps + 1


@pytest.mark.parametrize(("law", "kind"), [("linear", "hex8"), ("neo", "hex8"), ("svk", "tet4"), ("linear", "tet4")])
def test_a_step_above_the_limit_warns_and_ends_as_diverged(law, kind):
    mesh, mat = block(kind, 3), material(law)
    generator = np.random.default_rng(3)
    c = bar_speed(mat)
    body = tc.Body(mesh, mat, velocity=1e-3 * c * generator.normal(size=mesh.nodes.shape))
    scene = tc.Scene(bodies=[body], duration=200 * 0.2 / c)
    with pytest.warns(RuntimeWarning, match="above the stable step"):
        result = tc.simulate(scene, scheme=tc.CentralDifference(cfl=1.3))
    assert result.reason == "diverged"
    assert result.dt == pytest.approx(1.3 * result.dt_limit)
    assert result.warnings
    assert "smaller dt or cfl < 1" in result.message
    explained(result)
    if law == "linear":  # stopped by its energy, long before it overflows (it grows 20-fold a step)
        assert "the energy grew" in result.message
        assert result.history["energy"][-1] < 1e4 * result.history["energy"][0]


def test_a_contact_step_above_the_limit_ends_as_diverged():
    """A dt that is given stays as given, also for a law whose stable step is looked at again."""
    scene = thrown("neo", "hex8", contact=tc.MasslessContact(removal="full"), duration=60.0)
    limit = tc.simulate(thrown("neo", "hex8", contact=tc.MasslessContact(removal="full"), duration=0.1)).dt_limit
    with pytest.warns(RuntimeWarning, match="above the stable step"):
        result = tc.simulate(scene, scheme=tc.CentralDifference(dt=1.3 * limit))
    assert result.reason == "diverged"
    assert np.allclose(np.diff(result.history["time"]), 1.3 * limit)
    explained(result)


def test_the_same_runs_at_nine_tenths_of_the_limit_are_sound():
    mesh, mat = block("hex8", 3), material("linear")
    c = bar_speed(mat)
    velocity = 1e-3 * c * np.random.default_rng(3).normal(size=mesh.nodes.shape)
    scene = tc.Scene(bodies=[tc.Body(mesh, mat, velocity=velocity)], duration=200 * 0.2 / c)
    result = tc.simulate(scene)
    assert result.ok
    assert result.message == ""
    # nodes shaken one by one: the energy of the fastest vibrations swings by the square of step times frequency
    assert all("energy error" in text for text in result.warnings)


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_a_crushed_body_stops_as_inverted_cell(kind, tmp_path):
    """Two halves of a block thrown at each other far above the wave speed. The last frame is the state at the stop."""
    mesh, mat = block(kind, 4), material("neo")
    c = bar_speed(mat)

    def velocity(nodes):
        speeds = np.zeros_like(nodes)
        speeds[:, 2] = -6.0 * c * np.sign(nodes[:, 2] - 0.09)
        return speeds

    scene = tc.Scene(bodies=[tc.Body(mesh, mat, velocity=velocity)], duration=1.0)
    result = tc.simulate(scene, out=tmp_path / "run", frames=2)
    assert result.reason == "inverted-cell"
    explained(result)
    assert "refine" in result.message
    assert result.steps >= 1
    stored = tc.open_result(tmp_path / "run")
    assert stored.frames.times[-1] == stored.time == result.time
    assert np.array_equal(stored.position, result.position)


def test_a_value_that_is_not_finite_stops_as_diverged():
    """A velocity whose square overflows: the kinetic energy is infinite in the first row."""
    mesh, mat = block("hex8", 2), material("linear")
    scene = tc.Scene(bodies=[tc.Body(mesh, mat, velocity=(1e200, 0.0, 0.0))], duration=1.0)
    result = tc.simulate(scene)
    assert result.reason == "diverged"
    assert "not finite" in result.message
    assert "units of velocities" in result.message
    explained(result)


def crash(law, share, kind="hex8", removal="auto"):
    """A square bar thrown end on at that share of its wave speed."""
    mesh, mat = block(kind, (2, 2, 8), (0.05, 0.05, 0.2), shake=0.0), material(law, poisson=0.0)
    c = bar_speed(mat)
    body = tc.Body(mesh, mat, velocity=(0.0, 0.0, -share * c), contact="zmin")
    scene = tc.Scene(
        bodies=[body],
        obstacles=[wall(mesh, (0, 0, 1.0), 1e-3)],
        duration=0.25 / c + 1e-3 / (share * c),
        contact=tc.MasslessContact(removal=removal),
    )
    return tc.simulate(scene, scheme=tc.CentralDifference(cfl=0.7))


def test_st_venant_kirchhoff_has_a_limit_that_neo_hookean_does_not_have():
    """Beyond v0/c = 0.266 there is no solution (METHOD 2): the run stops and points to NeoHookean."""
    assert crash("svk", 0.1).ok
    assert crash("neo", 0.5).ok
    for share in (0.28, 0.5):
        hard = crash("svk", share)
        assert hard.reason in ("not-converged", "inverted-cell")
        assert "NeoHookean" in hard.message


def test_st_venant_kirchhoff_beyond_its_limit_stops_and_names_the_law():
    message = crash("svk", 0.5).message
    assert "StVenantKirchhoff" in message or "st_venant_kirchhoff" in message


def test_a_blow_up_between_two_rows_still_ends_as_a_result():
    """The static solve may lose the contact nodes after a sound row: the next look must be a stop, not an exception."""
    result = crash("svk", 0.7, "tet4", "full")
    assert result.reason in ("not-converged", "inverted-cell", "diverged")
    assert TIME.search(result.message)
    assert "NeoHookean" in result.message


def test_a_static_solve_without_hope_stops_as_not_converged():
    """Nearly incompressible under full removal: thousands of sweeps would be needed (METHOD 2)."""
    mesh, mat = block("tet4", 4), material("linear", poisson=0.49999)
    body = tc.Body(mesh, mat, velocity=(0.0, 0.0, -5.0), contact="zmin", formulation="full")
    contact = tc.MasslessContact(removal="full", tolerance=1e-12, solver="gauss-seidel")
    scene = tc.Scene(bodies=[body], obstacles=[wall(mesh, (0, 0, 1.0), 0.0)], duration=1e-2, contact=contact)
    result = tc.simulate(scene)
    assert result.reason == "not-converged"
    assert "removal='normal'" in result.message
    assert "residual" in result.message
    assert TIME.search(result.message)


INTERRUPTED = """
import json, sys
import numpy as np
import scenes, tcontact as tc
from tcontact.run.guards import Guards
scene = scenes.thrown("linear", "hex8", contact=tc.MasslessContact(), duration=1e6)
check, rows = Guards.check, [0]
def watched(self, row, *rest):
    rows[0] += 1
    if rows[0] == 30:
        print("running", flush=True)  # well under way: compiled, frames written
    return check(self, row, *rest)
Guards.check = watched
result = tc.simulate(scene, out=sys.argv[1], frames=int(1e6), threads=2)
data = {k: getattr(result, k) for k in ("ok", "reason", "message", "steps", "time")}
print(json.dumps({**data, "rows": len(result.history["time"]), "finite": bool(np.isfinite(result.position).all())}))
"""


def test_ctrl_c_ends_as_interrupted_with_frames_history_and_summary(tmp_path):
    """A real SIGINT to a process in the middle of a run that would take hours."""
    out = tmp_path / "out"
    head = f"import sys; sys.path[:0] = [{str(ROOT)!r}, {str(ROOT / 'tests')!r}]\n"
    command = [sys.executable, "-W", "ignore", "-c", head + INTERRUPTED, str(out)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline().strip() == "running"
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors[-2000:]
    told = json.loads(output.splitlines()[-1])
    assert told["reason"] == "interrupted"
    assert not told["ok"]
    assert told["finite"]
    assert told["steps"] >= 29
    assert told["rows"] == told["steps"] + 1
    assert "kept" in told["message"]
    summary = json.loads((out / "summary.json").read_text())
    assert summary["reason"] == "interrupted"
    lines = (out / "history.csv").read_text().splitlines()
    assert len(lines) == told["rows"] + 1
    data = ResultData.open(out / "result.vtkhdf")
    assert len(data) >= 1
    assert data.times[-1] == pytest.approx(told["time"])
    assert len(data.history["time"]) == told["rows"]
    assert np.isfinite(data.frame(-1).point_data["displacement"]).all()
