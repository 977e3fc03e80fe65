"""`tcontact bench`: other ways to the internal force agree with ours, what is missing keeps a row. No times judged."""

import importlib.util
import sys

import numpy as np
import pytest
from conftest import THREADS

from tcontact.lab.bench import alternatives, blocks, others, reference, table, waiting
from tcontact.planning.planning import plan


def missing(name):
    return importlib.util.find_spec(name) is None


def force_of(make, kind, law):
    """Return force [3n] of a method at a shaken cube of 3^3, and that of NumPy."""
    scene, displacement = blocks.shaken(kind, law, 3)
    body = plan(scene).bodies[0]
    u = displacement[body.node_order]
    found = make(body, u.ravel(), THREADS)()
    exact, _ = reference.force(kind, law, body.body.material.parameters, body.reference, body.cells, u)
    return np.asarray(found.todense() if hasattr(found, "todense") else found).ravel(), exact.ravel()


@pytest.mark.parametrize("kind", alternatives.KINDS)
@pytest.mark.parametrize(
    ("make", "law"),
    [
        pytest.param(
            others.felupe,
            "neo-hookean",
            marks=pytest.mark.skipif(missing("felupe"), reason="felupe is not installed: pip install felupe"),
        ),
        pytest.param(
            others.scipy,
            "linear",
            marks=pytest.mark.skipif(missing("scipy"), reason="scipy is not installed: pip install scipy"),
        ),
        (others.ours, "linear"),
        (others.plain, "linear"),
    ],
    ids=["felupe", "scipy", "ours", "plain"],
)
def test_every_method_computes_the_same_force(make, law, kind):
    found, exact = force_of(make, kind, law)
    assert np.abs(found - exact).max() <= 1e-10 * np.abs(exact).max()


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
def test_the_stiffness_of_a_cell_is_the_slope_of_its_linear_force(kind):
    mesh, lame = blocks.shaken(kind, "linear", 2)[0].bodies[0].mesh, (0.7, 0.4)
    (tangent,) = reference.stiffness(kind, lame, mesh.nodes, mesh.cells[:1])
    assert tangent == pytest.approx(tangent.T, abs=1e-14)
    corners = mesh.nodes[mesh.cells[0]]
    for place, unit in enumerate(np.eye(corners.size)):
        cell = np.arange(len(corners))[None]
        force, _ = reference.force(kind, "linear", lame, corners, cell, unit.reshape(-1, 3))
        assert tangent[:, place] == pytest.approx(force.ravel(), abs=1e-14)


@pytest.fixture
def brief(monkeypatch):
    monkeypatch.setattr(alternatives, "ROUNDS", 2)
    monkeypatch.setattr(alternatives, "BATCH_SECONDS", 1e-3)


def test_what_is_not_installed_keeps_a_row_that_says_how(brief, monkeypatch):
    """None in sys.modules makes the import fail as it does where there is no such package."""
    monkeypatch.setitem(sys.modules, "felupe", None)
    monkeypatch.setitem(sys.modules, "scipy", None)
    found = alternatives.alternatives("cpu", THREADS, 2, kinds=("hex8-distorted",))
    rows = {(row["law"], row["method"]): row for row in found["rows"]}
    assert len(rows) == 6
    assert all(row["ok"] for row in rows.values())
    for key, package in ((("neo-hookean", "FElupe"), "felupe"), (("linear", "SciPy CSR"), "scipy")):
        gone = rows.pop(key)
        assert not gone["installed"]
        assert "rate" not in gone
        assert f"pip install {package}" in gone["reason"]
    for row in rows.values():
        assert row["force_error"] <= 1e-10
        assert 0.0 < row["rate"]["low"] <= row["rate"]["high"]
        assert row["peak_bytes"] >= row["held_bytes"] > 0
    assert rows["linear", alternatives.OURS]["times_ours"]["low"] == 1.0
    text = "\n".join(alternatives.lines([found | {"ok": True, "threads": THREADS}]))
    assert "pip install felupe" in text
    assert "not installed" in text
    assert "FAILED" not in text


def test_a_package_that_fails_keeps_a_row_with_its_reason(brief, monkeypatch):
    def broken(body, u, threads):
        raise AttributeError("no SolidBody")

    monkeypatch.setitem(alternatives.METHODS, "FElupe", (broken, "felupe", ""))
    monkeypatch.setattr(alternatives, "OF_A_LAW", {"linear": (alternatives.OURS, "FElupe")})
    found = alternatives.alternatives("cpu", THREADS, 2, kinds=("hex8-distorted",))
    ours, other = found["rows"]
    assert ours["ok"]
    assert (other["ok"], other["reason"]) == (False, "AttributeError: no SolidBody")
    parts = [found | {"ok": True, "threads": THREADS}, {"ok": False, "threads": 1, "reason": "why"}]
    text = "\n".join(alternatives.lines(parts))
    assert "FElupe, hex8-distorted: FAILED: AttributeError: no SolidBody" in text
    assert "1 threads: FAILED: why" in text


def test_set_up_and_frames_are_measured_with_the_errors_of_their_runs(monkeypatch):
    monkeypatch.setattr(waiting, "LAW", "linear")  # kernels that other tests compile too
    for name, value in {"SETUP_SIZE": 3, "FRAMES_SIZE": 3, "FRAMES": 4, "STEPS": 12, "ROUNDS": 2}.items():
        monkeypatch.setattr(waiting, name, value)
    setup, frames = waiting.setup("cpu", THREADS), waiting.frames("cpu", THREADS)
    assert setup["cells"] == 27
    assert setup["cpu_s"] > 0.0
    assert setup["array_bytes"] > 27 * 8
    assert frames["steps"] == 12
    assert frames["share"]["low"] > -1.0
    for row in (setup, frames):
        assert 0.0 < row["energy_error"] < 0.5
    gone = {"ok": False, "threads": 1, "reason": "why"}
    report = {"setup": [setup | {"ok": True, "threads": 1}], "frames": [frames | {"ok": True, "threads": 1}, gone]}
    text = waiting.lines(report)
    assert len(text) == 3
    assert text[0].startswith("set-up of a large body, 1 threads: 27 hexes")
    assert text[1].startswith("frames of a run, 1 threads: 4 frames of 3^3 hexes")
    assert text[2].endswith("FAILED: why")
    assert waiting.resident("VmHWM") >= waiting.resident("VmRSS") or not np.isfinite(waiting.resident("VmRSS"))
    assert np.isnan(waiting.resident("VmNothing"))
    machine = {"processor": "one", "cores": 1, "versions": {}}
    assert table.lines({"machine": machine, "rows": []} | report)[:1] == ["one, 1 cores; "]
