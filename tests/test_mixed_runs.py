"""Runs in mixed precision against runs in float64: spin, drop with contact, plastic flow; files, refusals, resume."""

import json

import numpy as np
import pytest
from conftest import THREADS
from stopped_runs import copied, quietly, same

import tcontact as tc
from tcontact.commands.cli import main
from tcontact.kernels.cells import cell_phase
from tcontact.lab.bench.configuration import Configuration
from tcontact.lab.bench.measure import measure
from tcontact.results import checks as ck
from tcontact.run.scene_files import load_scene, save_scene

RUBBER = {"young": 1e7, "poisson": 0.3, "density": 1000.0}


def cube(kind="hex8", cells=3, law=tc.NeoHookean, **options):
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (cells,) * 3, kind=kind)
    return tc.Body(mesh, law(**RUBBER), **({"contact": None} | options))


def drop(kind="hex8", cells=4, contact=None, duration=6e-3, **options):
    """A cube that falls on a wall at 2 m/s and bounces."""
    body = cube(kind, cells, velocity=(0.0, 0.0, -2.0), contact="zmin")
    wall = tc.Plane(point=(0.0, 0.0, -1e-3))
    contact = contact or tc.MasslessContact(tolerance=1e-10)
    return tc.Scene(body, wall, contact=contact, duration=duration, **options)


def both(scene, **options):
    return [tc.simulate(scene, precision=precision, **options) for precision in ("f64", "mixed")]


def difference(results, name):
    """Largest difference of a column over its largest value."""
    exact, rough = (result.history[name] for result in results)
    assert len(exact) == len(rough)
    return float(np.abs(exact - rough).max() / np.abs(exact).max())


@pytest.mark.parametrize("path", ["one launch", "parallel"])
@pytest.mark.parametrize("contact", [tc.MasslessContact(tolerance=1e-10), tc.PenaltyContact(1e9)])
def test_a_drop_has_the_force_and_impulse_of_float64(contact, path, request):
    """Contact cells are float64, so the static solve reaches its tolerance; the error is that of the other cells."""
    if path == "parallel":
        request.getfixturevalue("parallel_path")
    results = both(drop(contact=contact))
    assert all(result.ok for result in results)
    assert results[0].dt == results[1].dt  # products of the stable step are float64
    for name in ("contact_force", "impulse", "energy", "momentum"):
        assert 0.0 < difference(results, name) < 1e-6, name
    assert np.abs(results[1].position - results[0].position).max() < 1e-7 * 0.1
    assert ck.momentum_balance(results[1], 1e-13).passed
    assert results[1].history["static_residual"].max() < 1e-10
    errors = [result.history["energy_error"] for result in results]
    assert np.abs(errors[1] - errors[0]).max() < 1e-6
    assert [result.precision for result in results] == ["f64", "mixed"]


def test_a_thousand_turning_steps_keep_energy_and_momentum():
    """A free cube turns by more than a full turn: strains err by 1e-7 there, stresses by 1e-7 of the moduli.

    Forces of symmetric stresses have no torque all the same, and the energy errs by strain times these.
    """
    body = cube()
    centre = body.mesh.nodes.mean(axis=0)
    turning = np.cross((20.0, 10.0, 5.0), body.mesh.nodes - centre) + np.array([3.0, 0.0, 0.0])
    scene = tc.Scene(cube(velocity=turning), duration=0.3)
    results = both(scene)
    assert results[0].steps > 1000
    assert ck.momentum_balance(results[1], 1e-13).passed
    energies = [result.history["energy"] / result.history["energy"][0] for result in results]
    assert np.abs(energies[1] - energies[0]).max() < 2e-7
    turned = [result.history["angular_momentum"] for result in results]
    assert np.abs(turned[1] - turned[0]).max() < 1e-8 * np.abs(turned[0]).max()


def test_far_from_where_it_was_meshed_a_body_deforms_as_at_home():
    """The body has moved by a million lengths: differences of displacements in float64 lose 1e-10 of a length."""
    near, far = (
        tc.simulate(
            tc.Scene(cube(velocity=stretching(), displacement=np.tile(shift, (64, 1))), duration=2e-3),
            tc.CentralDifference(dt=2e-4),
            precision="mixed",
        )
        for shift in ((0.0, 0.0, 0.0), (1e5, -5e4, 1e5))
    )
    assert np.abs(near.history["elastic"]).max() > 0.0
    assert near.history["elastic"] == pytest.approx(far.history["elastic"], rel=1e-6)


def stretching():
    """Velocity [64, 3] that stretches the cube."""
    nodes = cube().mesh.nodes
    return 20.0 * (nodes - nodes.mean(axis=0)) * np.array([1.0, -0.3, -0.3])


def test_float64_builds_nothing_of_mixed_precision(monkeypatch):
    def refuse(*arguments):
        raise AssertionError("a run in float64 asked for cells in float32")

    monkeypatch.setattr(cell_phase, "single_force", refuse)
    cell_phase.make_cell_phase.cache_clear()
    scene = tc.Scene(cube(), duration=1e-4)
    assert tc.simulate(scene).ok
    assert tc.simulate(scene, precision="f64").precision == "f64"
    assert all(not domain.mixed and "mixed" not in domain.options for domain in tc.plan(scene).domains)


@pytest.mark.parametrize("value", ["f32", "", None, 64, True])
def test_an_unknown_precision_is_refused(value):
    with pytest.raises(tc.InputError, match="precision") as caught:
        tc.simulate(drop(), precision=value)
    assert caught.value.field == "precision"


@pytest.mark.parametrize("scheme", [tc.DiscreteGradient(dt=1e-4), tc.PaperImplicit(dt=1e-4)])
def test_implicit_schemes_refuse_mixed_precision_before_anything_is_written(scheme, tmp_path):
    with pytest.raises(tc.InputError, match=r"precision.*float64"):
        tc.simulate(drop(), scheme, out=tmp_path / "run", precision="mixed")
    assert not (tmp_path / "run").exists()


def test_cuda_refuses_mixed_precision_before_anything_is_written(tmp_path):
    with pytest.raises(tc.InputError, match=r"precision.*CUDA"):
        tc.simulate(drop(), out=tmp_path / "run", precision="mixed", arch="cuda")
    assert not (tmp_path / "run").exists()


def test_a_mixed_run_is_resumed_bit_for_bit_and_only_in_its_precision(tmp_path, monkeypatch):
    scene = drop()
    whole, copies = copied(monkeypatch, tmp_path, scene, tc.CentralDifference(), 9, precision="mixed")
    rows = sorted(copies)
    with pytest.raises(tc.InputError, match=r"precision.*'mixed'"):
        tc.resume(copies[rows[0]], scene, tc.CentralDifference(), precision="f64")
    continued = quietly(tc.resume, copies[rows[0]], scene, tc.CentralDifference())
    same(continued, whole)
    assert continued.precision == "mixed"
    same(quietly(tc.resume, copies[rows[-1]], scene, tc.CentralDifference(), precision="mixed"), whole)


def test_command_scene_file_summary_and_info_name_the_precision(tmp_path, capsys):
    file = tmp_path / "drop.toml"
    save_scene(drop(cells=2, duration=1e-3), file, precision="mixed", frames=0)
    assert load_scene(file)[1]["precision"] == "mixed"
    for options, wanted in (([], "mixed"), (["--precision", "f64"], "f64")):
        out = tmp_path / wanted
        assert main(["run", str(file), "--out", str(out), "--quiet", *options]) == 0
        assert json.loads((out / "summary.json").read_text())["precision"] == wanted
        capsys.readouterr()
        assert main(["info", str(out)]) == 0
        assert ("mixed precision" in capsys.readouterr().out) == (wanted == "mixed")


def test_a_case_without_cells_refuses_it(capsys, tmp_path):
    assert main(["run", "friction-layer", "--precision", "mixed", "--out", str(tmp_path / "run")]) == 2
    assert "--precision" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_the_bench_measures_mixed_precision_beside_its_errors():
    configuration = Configuration("tet4", "linear", 3, THREADS, precision="mixed", steps=4, seconds=0.01, batches=3)
    (row,) = measure(configuration)["rows"]
    assert row["ok"]
    assert row["precision"] == "mixed"
    assert 1e-10 < row["force_error"] < 1e-6
    assert 0.0 <= row["energy_error"] < 1e-2
