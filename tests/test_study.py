"""`tcontact study`: closed forms obey their equations, exact answers have no error, orders, files, failures by name."""

import csv
import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import THREADS

import tcontact as tc
from tcontact.commands.cli import main
from tcontact.lab.study import errors, figure, methods, pareto, problems, reference, runner, table
from tcontact.lab.study.problems import penalty_wall, smooth_contact
from tcontact.results.exact import LameMode, PenaltyWall, SmoothBump, SofteningBar, WallShock
from tcontact.scene.contact_models import ImpulseContact, MasslessContact, PenaltyContact

BAR = {"length": 0.1, "area": 1e-4, "young": 1e7, "density": 1000.0, "speed": 2.0}


@pytest.fixture(autouse=True)
def once(monkeypatch):
    """No run is repeated: no time is judged here."""
    monkeypatch.setattr(runner, "REPEATS", 1)


def wall(k):
    return PenaltyWall(**BAR, stiffness=k * BAR["young"] / BAR["length"])


# closed forms


@pytest.mark.parametrize("k", [2, 5, 200])
def test_penalty_wall_obeys_its_delay_equation(k):
    """p' + a p = D(t), D the wave that arrives: v first, then what left 2L/c before."""
    exact = wall(k)
    a, crossing, speed = exact.rate, exact.crossing, exact.speed
    t = np.linspace(0.01, exact.contact_time / crossing - 0.001, 4001) * crossing
    t = t[np.abs(t - crossing) > 0.01 * crossing]
    h = 1e-6 * crossing
    slope = (exact.overlap(t + h) - exact.overlap(t - h)) / (2 * h)
    since = np.maximum(t - crossing, 0.0)
    left = np.where(t > crossing, speed * (2.0 * np.exp(-a * since) - 1.0), speed)
    np.testing.assert_allclose(slope + a * exact.overlap(t), left, atol=1e-6 * speed)
    assert exact.overlap(exact.contact_time) == pytest.approx(0.0, abs=1e-12 * speed / a)
    grid = np.linspace(0.0, exact.contact_time, 200001)
    force = exact.stiffness * exact.area * exact.overlap(grid)
    assert float(exact.impulse(exact.contact_time)) == pytest.approx(
        (force[1:] + force[:-1]) @ np.diff(grid) / 2, rel=1e-8
    )
    assert exact.largest_overlap == pytest.approx(exact.overlap(grid).max(), rel=1e-8)


def test_a_stiff_penalty_wall_is_a_rigid_one():
    exact = wall(1e7)
    assert exact.rebound == pytest.approx(1.0, abs=1e-6)
    assert exact.contact_time == pytest.approx(exact.crossing, rel=1e-6)


def test_wall_shock_keeps_mass_and_momentum_and_tends_to_the_wave_speed():
    material = tc.NeoHookean(1e7, 0.3, 1000.0)
    law = (material.lame_lambda, material.lame_mu, 1000.0)
    for mach in (1e-6, 0.05, 0.2):
        shock = WallShock(*law, mach * material.wave_speed)
        assert shock.pressure == pytest.approx(-shock.stress(shock.stretch), rel=1e-9)
        assert shock.shock_speed >= material.wave_speed * (1.0 - 1e-9)
    assert WallShock(*law, 1e-6 * material.wave_speed).shock_speed == pytest.approx(material.wave_speed, rel=1e-5)


@pytest.mark.parametrize("mach", [1e-4, 0.1, 0.2, 0.265])
def test_softening_bar_is_the_sum_of_small_waves(mach):
    """v = integral of c over the stretch, by quadrature; rho c v for a weak wave; the limit where c vanishes."""
    bar = SofteningBar(young=1e7, density=1000.0, speed=100.0 * mach)
    q = np.linspace(bar.stretch, 1.0, 200001)
    wave = 100.0 * np.sqrt((3.0 * q**2 - 1.0) / 2.0)
    assert np.sum((wave[1:] + wave[:-1]) / 2.0 * np.diff(q)) == pytest.approx(bar.speed, rel=1e-6)
    if mach < 1e-3:
        assert bar.pressure == pytest.approx(1000.0 * 100.0 * bar.speed, rel=1e-3)
    assert bar.reached(1.0 / np.sqrt(3.0)) == pytest.approx(26.603, rel=1e-4)


def test_lame_mode_has_its_gradient_no_traction_and_the_right_frequency():
    mode = LameMode(edge=0.3, lame_mu=2e6, density=900.0, amplitude=1.0)
    x = np.random.default_rng(1).uniform(0.0, 0.3, (40, 3))
    h = 1e-6
    for j in range(3):
        step = h * np.eye(3)[j]
        np.testing.assert_allclose(
            mode.gradient(x)[:, :, j], (mode.shape(x + step) - mode.shape(x - step)) / (2 * h), atol=1e-6
        )
    x[:20, 2], x[20:, 1] = 0.0, 0.3
    strain = mode.gradient(x) + np.swapaxes(mode.gradient(x), 1, 2)
    np.testing.assert_allclose(np.trace(strain, axis1=1, axis2=2), 0.0, atol=1e-12)
    np.testing.assert_allclose(strain[:20, :, 2], 0.0, atol=1e-12)
    np.testing.assert_allclose(strain[20:, :, 1], 0.0, atol=1e-12)
    # rho omega^2 u = -mu laplace u for a motion without change of volume
    assert 900.0 * mode.frequency**2 == pytest.approx(2e6 * 2.0 * (np.pi / 0.3) ** 2)


def test_smooth_bump_is_the_slope_of_its_integral():
    wave = SmoothBump(prestrain=0.2, height=0.3, centre=0.45, half=0.3)
    z = np.linspace(0.0, 1.0, 301)
    np.testing.assert_allclose((wave.integral(z + 1e-6) - wave.integral(z - 1e-6)) / 2e-6, wave.bump(z), atol=1e-8)
    assert wave.integral(np.array(0.0)) == 0.0


# errors


def test_centred_mean_of_a_jump_is_its_share_of_the_step():
    time = np.array([0.0, 1.0, 2.0, 3.0])
    mean = errors.centred_mean(lambda t: 4.0 * np.maximum(0.0, t - 1.25), time)
    np.testing.assert_allclose(mean, [0.0, 1.0, 4.0, 4.0])
    ramp = errors.centred_mean(lambda t: 0.5 * t**2, time)  # half a step beyond the first and the last row too
    np.testing.assert_allclose(ramp, time, atol=1e-14)


def test_quadrature_is_exact_for_a_linear_displacement():
    mesh = tc.box_mesh(size=(1.0, 2.0, 3.0), cells=(2, 2, 3))
    turn = np.array([[0.1, 0.2, 0.0], [0.0, 0.3, 0.1], [0.4, 0.0, 0.2]])
    points, weights, values, gradients = errors.hex_quadrature(mesh, mesh.nodes @ turn.T)
    assert weights.sum() == pytest.approx(6.0)
    np.testing.assert_allclose(values, points @ turn.T, atol=1e-12)
    np.testing.assert_allclose(gradients, np.broadcast_to(turn, gradients.shape), atol=1e-12)


# methods and registry


def test_names_become_contact_models():
    unit = 2.0
    assert methods.method("massless-full").contact(unit) == MasslessContact(removal="full")
    assert methods.method("massless-depth-3").contact(unit) == MasslessContact(depth=3)
    assert methods.method("massless-penalty-1e3").contact(unit) == MasslessContact(penalty=2000.0)
    assert methods.method("penalty-0.5").contact(unit) == PenaltyContact(stiffness=1.0)
    assert methods.method("impulse@central-difference").contact(unit) == ImpulseContact()
    assert methods.method("impulse").scheme(0.3) == tc.CentralDifference(cfl=0.3)
    for wrong in ("penalty", "penalty-0", "massless", "impulse@nothing", "massless-depth-x"):
        with pytest.raises(tc.InputError):
            methods.method(wrong)


def test_a_scheme_that_is_added_becomes_a_method(monkeypatch):
    monkeypatch.setitem(methods.SCHEMES, "new-scheme", tc.CentralDifference)
    assert methods.method("massless-normal@new-scheme").scheme(0.5) == tc.CentralDifference(cfl=0.5)


def test_implicit_schemes_take_multiples_of_the_step():
    assert methods.standard(methods.STANDARD)[-1] == "massless-normal@discrete-gradient*2"
    assert methods.method("massless-normal@discrete-gradient*2").scheme(0.9) == tc.DiscreteGradient(cfl=1.8)
    assert methods.method("impulse@paper-implicit").scheme(0.9) == tc.PaperImplicit(cfl=0.9)
    for wrong in ("*0", "*x", "*-1", "*inf"):
        with pytest.raises(tc.InputError):
            methods.method("impulse@discrete-gradient" + wrong)


def test_a_step_of_all_methods_alike_counts_instead_of_their_own_stable_one():
    assert methods.method("penalty-10*0.5").scheme(0.9) == tc.CentralDifference(cfl=0.45)
    assert methods.method("penalty-10*0.5").scheme(0.9, 2.0) == tc.CentralDifference(dt=0.9)


@pytest.mark.parametrize("name", problems.names())
def test_every_problem_is_complete(name):
    problem = problems.load(name)
    scene = problem.scene(cells=4)
    assert problem.unit(scene) > 0.0
    assert len(problem.SIZES) >= 3
    for method in problem.METHODS:
        built = runner.build(study(name, methods=[method]), methods.method(method), 4)
        assert isinstance(built, tc.Scene)
    assert problem.ERRORS
    assert hasattr(problem, "REFERENCE") or hasattr(problem, "reference")


@pytest.mark.parametrize("name", problems.names())
def test_every_problem_measures_the_errors_it_names(name, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    report = runner.collect(study(name, methods=problems.load(name).METHODS[:1], sizes=[4]))
    (row,) = report["rows"]
    assert row["ok"], row["failure"]
    assert tuple(row["errors"]) == problems.load(name).ERRORS
    assert set(report["pareto"]) == set(row["errors"])
    assert report["error"] == problems.load(name).ERRORS[0]


# the grid


def study(name, **options):
    """A small study of a problem."""
    settings = {"methods": ["massless-normal"], "sizes": [8], "cfls": [0.9], "threads": THREADS} | options
    return runner.Study(name, problems.load(name), **settings)


def orders(name, method, sizes):
    """Observed order in h of every error."""
    rows = runner.collect(study(name, methods=[method], sizes=sizes))["rows"]
    ratio = np.log(sizes[-1] / sizes[-2])
    return {error: np.log(rows[-2]["errors"][error] / value) / ratio for error, value in rows[-1]["errors"].items()}


def test_smooth_contact_force_is_of_second_order_and_of_first_with_a_penalty_fixed_to_the_cell():
    assert orders("smooth-contact", "massless-normal", [20, 40])["force_error"] >= 1.9
    assert 0.8 <= orders("smooth-contact", "massless-penalty-1", [40, 80])["force_error"] <= 1.3


def test_redistributed_mass_keeps_the_orders_of_free_vibration():
    """Ordinary mass (impulse: nothing touches) beside it."""
    for method in ("massless-normal", "massless-full", "impulse"):
        found = orders("free-vibration", method, [8, 16])
        assert found["displacement_error"] >= 1.8
        assert found["energy_norm_error"] >= 0.9


def test_two_bars_without_contact_mass_are_ten_times_better_than_with_a_penalty_at_the_same_step():
    """Force variation and energy error, with 1 young/h of the slave; with 10 the run ends at the energy it gains."""
    rows = runner.collect(study("two-bars", methods=["massless-normal", "penalty-1", "penalty-10"], sizes=[20]))["rows"]
    ours, soft, stiff = rows
    assert ours["dt"] == soft["dt"] == stiff["dt"]
    assert ours["errors"]["touches"] == 1.0
    assert soft["errors"]["total_variation"] >= 10.0 * ours["errors"]["total_variation"]
    assert soft["energy_error"] >= 10.0 * ours["energy_error"]
    assert stiff["reason"] == "diverged"
    assert stiff["energy_error"] >= 10.0 * ours["energy_error"]


@pytest.mark.parametrize("k", [5, 80])
def test_penalty_on_massless_nodes_converges_to_the_wall_that_yields(k):
    rows = runner.collect(study("penalty-wall", methods=[f"massless-penalty-{k}"], sizes=[20, 80]))["rows"]
    coarse, fine = (row["errors"] for row in rows)
    for name in ("overlap_error", "contact_time_error", "impulse_error"):
        assert fine[name] <= 0.005, name
    assert fine["force_error"] < 0.5 * coarse["force_error"]
    rigid = tc.simulate(replace(penalty_wall.scene(cells=80), contact=MasslessContact()))
    time = penalty_wall.closed_time(rigid.history["time"], rigid.history["gap_min"] - 1e-12)
    yielding = penalty_wall.exact(runner.build(study("penalty-wall"), methods.method(f"massless-penalty-{k}"), 80))
    assert abs(time / yielding.contact_time - 1.0) > 1.5 * fine["contact_time_error"]  # and not to the rigid one


def test_a_prestressed_start_is_in_equilibrium_until_the_wave_comes():
    scene = smooth_contact.scene(cells=40)
    scene = replace(scene, duration=0.1)
    result = tc.simulate(smooth_contact.displaced(scene))
    force = result.history["contact_force"][:, 2] * 64.0
    np.testing.assert_allclose(force, smooth_contact.WAVE.prestrain, rtol=2e-3)


def test_failures_are_rows_with_what_they_did():
    report = runner.collect(study("bar-impact", methods=["penalty-10", "massless-full"], sizes=[20]))
    (failure,) = report["failures"]
    assert failure["method"] == "penalty-10"
    assert "gained" in failure["failure"]
    assert {row["method"] for row in report["pareto"]["force_error"]} == {
        "massless-full"
    }  # a failure is never the best
    refused = runner.collect(study("penalty-wall", methods=["impulse"], sizes=[8]))
    assert refused["failures"][0]["failure"].startswith("refused")
    assert "FAILED" in "\n".join(table.lines(refused))


def test_an_interrupted_study_keeps_what_it_has(monkeypatch):
    whole = tc.simulate

    def interrupted(*scene, **options):
        monkeypatch.setattr(tc, "simulate", lambda *s, **o: replace(whole(*s, **o), ok=False, reason="interrupted"))
        return whole(*scene, **options)

    monkeypatch.setattr(tc, "simulate", interrupted)
    report = runner.collect(study("bar-impact", sizes=[4, 6, 8]))
    assert report["interrupted"]
    assert [row.get("reason", "skipped") for row in report["rows"]] == ["finished", "interrupted", "skipped"]


def test_a_budget_leaves_runs_out_by_name(monkeypatch):
    clock = iter(np.arange(0.0, 1e4, 10.0))
    monkeypatch.setattr(runner, "perf_counter", lambda: float(next(clock)))
    report = runner.collect(study("bar-impact", sizes=[8, 16, 32], budget=25.0))
    assert [row["size"] for row in report["skipped"]] == [16, 32]
    assert "not run: over the budget" in "\n".join(table.lines(report))


@pytest.mark.parametrize(("dimensions", "times"), [(1, 4.0), (2, 8.0), (3, 16.0)])
def test_the_forecast_of_a_run_goes_with_cells_times_steps(dimensions, times):
    """Twice the cells along an edge: 2^d times the cells, twice the steps; half the cfl number: twice the steps."""
    row = {"size": 8, "cfl": 0.9, "steps": 100, "cell_updates": 100 * 8**dimensions}
    assert runner._forecast(3.0, row, 16, 0.9) == pytest.approx(3.0 * times)
    assert runner._forecast(3.0, row, 8, 0.45) == pytest.approx(6.0)


def test_a_measure_whose_exact_value_is_one_counts_by_its_distance_from_that():
    assert pareto.error_of("force_variation", 1.05) == pytest.approx(0.05)
    assert pareto.error_of("force_error", 1.05) == 1.05
    values = {"method": "good", "size": 1, "cfl": 0.9, "energy_error": 0.0, "ok": True, "failure": "", "wall_s": 1.0}
    best = pareto.best([values | {"errors": {"touches": 1.0, "force_error": 0.2}}], "touches")
    assert best[-1]["level"] == min(pareto.LEVELS)


def test_pareto_names_the_cheapest_run_of_each_level():
    def row(method, wall, error, failure=""):
        values = {"size": 1, "cfl": 0.9, "energy_error": 0.0, "ok": True, "failure": failure}
        return {"method": method, "wall_s": wall, "errors": {"x": error}} | values

    rows = [row("cheap", 1.0, 0.3), row("good", 2.0, 0.03), row("wild", 0.1, 0.01, "gained 80 %")]
    found = {best["level"]: best["method"] for best in pareto.best(rows, "x")}
    assert found == {1.0: "cheap", 0.5: "cheap", 0.2: "good", 0.1: "good", 0.05: "good"}


def test_a_reference_is_computed_once_and_dated(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    wanted = study("cube-impact", sizes=[2])
    first, about = reference.prepare(wanted, lambda text: None)
    assert about["made"][:2] == "20"
    assert "wall_s" in about
    monkeypatch.setattr(tc, "simulate", None)  # must not be needed
    again, kept = reference.prepare(wanted, lambda text: None)
    assert kept["made"] == about["made"]
    np.testing.assert_array_equal(first["impulse"], again["impulse"])
    (path,) = (tmp_path / "tcontact" / "references").iterdir()
    path.write_bytes(b"damaged")
    monkeypatch.undo()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    np.testing.assert_array_equal(reference.prepare(wanted, lambda text: None)[0]["impulse"], first["impulse"])


# the command


def test_the_command_leaves_its_files_and_keeps_those_of_others(tmp_path, capsys):
    out = tmp_path / "study"
    words = ["study", "bar-impact", "--methods", "massless-normal,penalty-10", "--sizes", "4,8", "--steps", "0.9,0.45"]
    words += ["--set", "speed=1.5", "--threads", str(THREADS), "--out", str(out)]
    assert main(words) == 0
    text = capsys.readouterr().out
    assert "cheapest for a force error" in text
    assert "failures" in text
    data = json.loads((out / "study.json").read_text(encoding="utf-8"))
    assert len(data["rows"]) == 8
    assert data["parameters"] == {"speed": 1.5}
    with (out / "study.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    wanted = {"method", "size", "dt", "wall_s", "cell_updates", "compile_s", "force_error", "energy_error", "failure"}
    assert wanted <= set(rows[0])
    assert (out / "study.png").stat().st_size > 10_000
    assert main(words) == 2  # holds a study
    (out / "notes.txt").write_text("mine")
    assert main([*words, "--force"]) == 0
    assert (out / "notes.txt").read_text() == "mine"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nothing"], "bar-impact"),
        (["bar-impact", "--methods", "nothing"], "massless-normal"),
        (["bar-impact", "--set", "cells=4"], "--sizes"),
        (["bar-impact", "--set", "cfl=0.5"], "--steps"),
        (["bar-impact", "--sizes", "x"], "whole numbers"),
        (["bar-impact", "--full"], "hard-cases"),
        (["bar-impact", "--error", "nothing"], "plateau_error"),
        (["hard-cases", "--sizes", "4"], "--full"),
        (["hard-cases", "--methods", "nothing"], "corner-first"),
    ],
)
def test_bad_usage_is_refused_before_a_file_is_touched(words, said, tmp_path, capsys):
    assert main(["study", *words, "--out", str(tmp_path / "new")]) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


def test_nothing_to_draw_is_no_figure(tmp_path):
    assert not figure.draw(tmp_path / "study.png", {"rows": [], "error": "error", "case": "x", "threads": 1})
    assert not (tmp_path / "study.png").exists()


def test_an_exact_answer_has_no_error():
    """The errors of the bar, fed with the exact history."""
    from tcontact.cases import bar_impact as case
    from tcontact.lab.study.problems import bar_impact

    scene = case.scene(cells=4)
    body = scene.bodies[0]
    touch, release, plateau = case.times_and_force(scene)
    time = np.linspace(0.0, 1.5 * release, 1201)
    impulse = plateau * np.clip(time - touch, 0.0, release - touch)
    force = errors.centred_mean(lambda t: plateau * np.clip(t - touch, 0.0, release - touch), time)
    start = plateau * (release - touch) / 2.0
    history = {
        "time": time,
        "contact_force": force[:, None] * [0, 0, 1],
        "impulse": impulse[:, None] * [0, 0, 1],
        "momentum": (impulse - start)[:, None] * [0, 0, 1],
    }
    moved = -body.velocity[2] * (time[-1] - release - touch)
    result = SimpleNamespace(
        scene=scene, history=history, time=time[-1], position=body.mesh.nodes + np.array((0, 0, moved))
    )
    found = bar_impact.errors(result)
    assert found.pop("force_variation") == pytest.approx(1.0)
    for name, value in found.items():
        assert value == pytest.approx(0.0, abs=1e-12), name


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_wall_shock_case_meets_its_checks_and_a_wrong_law_would_not(kind):
    from tcontact.cases import wall_shock as case

    result = tc.simulate(case.scene(cells=40, kind=kind, mach=0.2))
    for check in case.checks(result):
        assert check.passed, check
    shock, _, force = case.exact(result.scene)
    body = result.scene.bodies[0]
    linear = 1000.0 * body.material.wave_speed * shock.speed * (0.1 / 8) ** 2
    assert force > 1.03 * linear  # the plateau of the linear law would fail
