"""Each case: its scene is what its docstring says, its exact solution is exact, its checks pass and can fail."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import tcontact as tc
from tcontact import cases
from tcontact.cases import bar_impact, bouncing_bar, cube_impact, two_bars, two_cubes

ROOT = Path(__file__).resolve().parent.parent


def wave_force(scene: tc.Scene, cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Contact force on a bar by its own means: the wave equation stepped from node to node at c dt = h, where the
    central difference has no error (a constant body force included), with a rigid floor under the lowest node.

    Returns times [s] and the running impulse [N s].
    """
    body = scene.bodies[0]
    size, c = np.ptp(body.mesh.nodes, axis=0), np.sqrt(body.material.young / body.material.density)
    h = size[2] / cells
    dt = h / c
    pull = 0.0 if scene.gravity is None else -scene.gravity[2]
    speed = -body.velocity[2]
    gap = body.mesh.nodes[:, 2].min()
    now = np.full(cells + 1, gap)  # displacement + gap: the lowest node touches at 0
    before = now + speed * dt - 0.5 * pull * dt**2
    end_mass = body.material.density * h * size[0] * size[1] / 2
    steps = int(scene.duration / dt)
    impulse = np.zeros(steps + 1)
    for step in range(1, steps + 1):
        after = np.empty_like(now)
        after[1:-1] = now[2:] + now[:-2] - before[1:-1] - pull * dt**2
        after[-1] = 2 * now[-2] - before[-1] - pull * dt**2
        free = 2 * now[1] - before[0] - pull * dt**2
        after[0] = max(free, 0.0)
        impulse[step] = impulse[step - 1] + end_mass * (after[0] - free) / dt
        before, now = now, after
    return dt * np.arange(steps + 1), impulse


@pytest.mark.parametrize("name", cases.names())
def test_every_case_explains_itself(name):
    case = cases.load(name)
    assert cases.title(name) == (case.__doc__ or "").splitlines()[0]
    assert cases.title(name).endswith(".")
    assert callable(case.checks)
    assert cases.parameters(name)
    assert (
        Path(case.__file__).read_text(encoding="utf-8").endswith(f'sys.exit(main(["run", "{name}", *sys.argv[1:]]))\n')
    )
    if hasattr(case, "scene"):
        assert "cells" in cases.parameters(name)
        assert isinstance(case.scene(cells=3), tc.Scene)
    else:
        assert callable(case.solve)
        assert callable(case.summary)
        assert callable(case.write)


def test_unknown_case_names_the_known_ones():
    with pytest.raises(tc.InputError, match=", ".join(cases.names())):
        cases.load("cube")


@pytest.mark.parametrize(
    ("case", "wrong"),
    [
        (cube_impact, {"density": -1.0}),
        (cube_impact, {"poisson": 0.5}),
        (cube_impact, {"young": 0.0}),
        (cube_impact, {"cells": 0}),
        (cube_impact, {"size": -0.1}),
        (cube_impact, {"speed": 0.0}),
        (cube_impact, {"speed": float("nan")}),
        (cube_impact, {"gap": -0.01}),
        (cube_impact, {"yaw": float("inf")}),
        (cube_impact, {"kind": "hex20"}),
        (cube_impact, {"law": "fung"}),
        (cube_impact, {"contact": "glue"}),
        (cube_impact, {"removal": "some"}),
        (cube_impact, {"depth": 0}),
        (cube_impact, {"duration": 0.0}),
        (bar_impact, {"length": 0.0}),
        (bar_impact, {"width": -1.0}),
        (bar_impact, {"penalty": -1.0}),
        (bar_impact, {"cells": -3}),
        (bouncing_bar, {"flight": 2}),
        (bouncing_bar, {"contacts": 0}),
        (bouncing_bar, {"gravity": 0.0}),
        (bouncing_bar, {"cells": 2.5}),
    ],
)
def test_wrong_parameters_are_refused_by_name(case, wrong):
    with pytest.raises(tc.InputError) as caught:
        case.scene(**wrong)
    assert next(iter(wrong)) in str(caught.value)


@pytest.mark.parametrize("gap", [0.0, 1e-4, 3.3e-4])
def test_bar_impact_exact_force_is_that_of_the_wave_equation(gap):
    scene = bar_impact.scene(cells=5, gap=gap, speed=1.7, length=0.3, width=0.06, young=2e6, density=800.0)
    time, impulse = wave_force(scene, 1000)
    exact = np.cumsum(bar_impact.exact_force(time, time[1], scene)) * time[1]
    np.testing.assert_allclose(impulse, exact, atol=3e-3 * impulse[-1])
    _, release, _ = bar_impact.times_and_force(scene)
    assert release < scene.duration
    assert impulse[-1] == pytest.approx(2 * 800.0 * 0.3 * 0.06**2 * 1.7, rel=1e-3)


def test_bar_impact_average_keeps_the_impulse_whatever_the_step():
    scene = bar_impact.scene(cells=5, gap=1.3e-4)
    _, _, force = bar_impact.times_and_force(scene)
    for dt in (1e-6, 3.7e-5):
        times = np.arange(-2 * dt, scene.duration + 2 * dt, dt)
        total = bar_impact.exact_force(times, dt, scene).sum() * dt
        assert total == pytest.approx(force * 2 * 0.1 / 100.0, rel=1e-9)


@pytest.mark.parametrize(("flight", "contacts"), [(3, 4), (4, 3), (7, 2)])
def test_bouncing_bar_exact_force_is_that_of_the_wave_equation(flight, contacts):
    scene = bouncing_bar.scene(cells=5, flight=flight, contacts=contacts)
    errors = []
    for cells in (250, 1000):
        time, impulse = wave_force(scene, cells)
        exact = bouncing_bar.exact_impulse(time, scene)
        errors.append(np.abs(impulse - exact).max() / exact[-1] * contacts)
    assert errors[1] < 6e-3  # of one bounce; what is left is the time of touch, known to a step
    assert errors[1] < 0.4 * errors[0]
    *_, begins = bouncing_bar.timing(scene)
    assert len(begins) == contacts


def test_bouncing_bar_gives_back_all_the_momentum_gravity_takes():
    scene = bouncing_bar.scene(contacts=2)
    speed, gravity, _, begins = bouncing_bar.timing(scene)
    period_pair = 2 * (begins[1] - begins[0])
    taken = 1.0 * 10.0 * 1.0**2 * gravity * period_pair
    assert bouncing_bar.exact_impulse(np.array([scene.duration]), scene)[0] == pytest.approx(taken, rel=1e-12)
    assert speed == pytest.approx(10.0)  # the benchmark: dropped from 5 at g = 10


@pytest.mark.parametrize(
    ("turn", "lowest", "contact"),
    [
        ({}, 25, {"zmin"}),
        ({"yaw": 33.0}, 25, {"zmin"}),
        ({"pitch": 45.0}, 5, {"zmin", "xmax"}),
        ({"yaw": 45.0, "pitch": np.degrees(np.arctan(np.sqrt(2)))}, 1, {"zmin", "xmax", "ymin"}),
        ({"pitch": 180.0}, 25, {"zmax"}),
        ({"pitch": 90.0}, 25, {"xmax"}),
    ],
)
def test_cube_is_turned_lifted_and_given_the_faces_that_can_touch(turn, lowest, contact):
    scene = cube_impact.scene(cells=4, gap=2e-3, **turn)
    body = scene.bodies[0]
    gap = scene.obstacles[0].gap(body.mesh.nodes)
    assert gap.min() == pytest.approx(2e-3, rel=1e-9)
    assert np.sum(gap < 2e-3 + 1e-9) == lowest
    assert set(body.contact) == contact
    edges = np.ptp(body.mesh.nodes @ cube_impact.rotation(turn.get("yaw", 0.0), turn.get("pitch", 0.0)), axis=0)
    np.testing.assert_allclose(edges, 0.1, rtol=1e-12)


def test_cube_penalty_counts_in_young_over_cell_size():
    assert cube_impact.scene(cells=8, contact="penalty").contact.stiffness == pytest.approx(10 * 1e7 / 0.0125)
    assert cube_impact.scene(cells=8, contact="penalty", penalty=3.0).contact.stiffness == pytest.approx(3e7 / 0.0125)
    assert cube_impact.scene(cells=8, penalty=2.0).contact.penalty == pytest.approx(2e7 / 0.0125)
    assert cube_impact.scene(cells=8).contact.penalty is None


def test_comparison_differs_in_the_contact_only():
    pair = cube_impact.comparison(cells=4, speed=2.0, penalty=5.0)
    massless, soft, ordinary = pair.values()
    assert isinstance(massless.contact, tc.MasslessContact)
    assert massless.contact.penalty is None
    assert soft.contact == tc.MasslessContact(penalty=ordinary.contact.stiffness)
    assert isinstance(ordinary.contact, tc.PenaltyContact)
    assert massless.duration == ordinary.duration
    np.testing.assert_array_equal(massless.bodies[0].mesh.nodes, ordinary.bodies[0].mesh.nodes)


@pytest.mark.parametrize(("case", "cells"), [(two_bars, 12), (two_cubes, 6)])
def test_two_bodies_are_compared_with_penalties_in_young_over_the_cell_of_the_slave(case, cells):
    """1 and 10 of the softer body, or of the one with the finer faces, on ordinary mass; the one asked for, if any."""
    ours, soft, stiff = case.comparison(cells=cells, stiffness=1.0).values()
    assert isinstance(ours.contact, tc.MasslessContact)
    low = ours.bodies[1]
    assert ours.body_pairs[0].slave == 1
    unit = low.material.young / low.mesh.shortest_edge
    assert [one.contact.stiffness for one in (soft, stiff)] == pytest.approx([unit, 10.0 * unit])
    assert all(one.body_pairs and one.duration == ours.duration for one in (soft, stiff))
    assert list(case.comparison(cells=cells, contact="penalty", penalty=3.0)) == ["massless", "penalty 3 E/h"]
    softer = case.scene(cells=cells, contact="penalty", stiffness=0.1 if case is two_cubes else 10.0)
    up = softer.bodies[0]
    assert softer.contact.stiffness == pytest.approx(10.0 * up.material.young / up.mesh.shortest_edge)
    for options in ({"penalty": 2.0}, {"contact": "impulse"}):
        with pytest.raises(tc.InputError):
            case.scene(cells=cells, **options)
    assert not failed(case, tc.simulate(soft))


def failed(case, result) -> list[str]:
    """What fails, in words."""
    return [f"{check.name}: {check.value} {check.bound}" for check in case.checks(result) if not check.passed]


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
@pytest.mark.parametrize("cells", [20, 100])
def test_bar_impact_meets_its_checks(kind, cells):
    assert not failed(bar_impact, tc.simulate(bar_impact.scene(cells=cells, kind=kind)))


@pytest.mark.parametrize("options", [{"cfl": 0.9}, {"cfl": 0.5}])
def test_bouncing_bar_meets_its_checks(options):
    result = tc.simulate(bouncing_bar.scene(cells=40), scheme=tc.CentralDifference(**options))
    assert not failed(bouncing_bar, result)


@pytest.mark.parametrize(
    "parameters",
    [
        {},
        {"law": "linear"},
        {"law": "st-venant-kirchhoff"},
        {"kind": "tet4"},
        {"removal": "full"},
        {"depth": 2},
        {"penalty": 100.0},
        {"contact": "penalty"},
        {"contact": "impulse"},
        {"pitch": 45.0},
        {"yaw": 45.0, "pitch": 54.7356},
        {"yaw": 20.0, "pitch": 10.0},
        {"poisson": 0.0},
        {"speed": 0.5, "size": 10.0, "young": 2e11, "density": 7800.0},
    ],
)
def test_cube_impact_meets_its_checks(parameters):
    result = tc.simulate(cube_impact.scene(cells=6, **parameters))
    assert result.history["contact_force"][:, 2].max() > 0.0
    assert not failed(cube_impact, result)


def test_cube_impact_linear_meets_the_pinned_figures():
    result = tc.simulate(cube_impact.scene(law="linear"), scheme=tc.CentralDifference(cfl=0.8))
    names = {check.name for check in cube_impact.checks(result)}
    assert "mean force / (rho c v A)" in names
    assert not failed(cube_impact, result)


def spoiled(result, **columns):
    """Return a copy of a result with some columns of its history replaced."""
    return dataclasses.replace(result, history=result.history | columns)


def test_checks_fail_when_the_physics_does():
    result = tc.simulate(bar_impact.scene(cells=20))
    history = result.history
    pulling, growing, overlapping = (history[n].copy() for n in ("contact_force", "energy_error", "gap_min"))
    pulling[5] = (0.0, 0.0, -1e-3 * pulling.max())
    growing[-1] = 0.1
    overlapping[7] = -1e-9
    lost = history["momentum"] * 0.999
    for columns, name in (
        ({"contact_force": pulling}, "contact pushes"),
        ({"energy_error": growing}, "energy error"),
        ({"gap_min": overlapping}, "overlap / size"),
        ({"momentum": lost}, "momentum = impulses"),
    ):
        assert any(text.startswith(name) for text in failed(bar_impact, spoiled(result, **columns))), name
    node = result.contact_node_force.copy()
    node[0] = (0.0, 0.0, -1e-3 * pulling.max())
    one_pulls = dataclasses.replace(result, contact_node_force=node)
    assert any(text.startswith("contact pushes") for text in failed(bar_impact, one_pulls))
    for spoilt, name in (
        (spoiled(result, contact_force=0.0 * history["contact_force"]), "rows with contact"),
        (spoiled(result, impulse=1.1 * history["impulse"]), "impulse, error"),
        (spoiled(result, time=1.1 * history["time"]), "mean time of the force"),
        (dataclasses.replace(result, time=0.99 * result.scene.duration), "finished"),
    ):
        assert any(text.startswith(name) for text in failed(bar_impact, spoilt)), name
    stopped = dataclasses.replace(result, reason="diverged", ok=False)
    assert any(text.startswith("finished") for text in failed(bar_impact, stopped))


@pytest.mark.parametrize("case", [bar_impact, bouncing_bar, cube_impact])
@pytest.mark.filterwarnings("ignore:invalid value")
def test_checks_of_a_run_that_blew_up_fail_without_crashing(case):
    result = tc.simulate(case.scene(cells=4))
    broken = {name: np.where(np.arange(len(column)).reshape(-1, *[1] * (column.ndim - 1)) > 3, np.nan, column)
              for name, column in result.history.items()}  # fmt: skip
    found = case.checks(dataclasses.replace(result, ok=False, reason="diverged", history=broken))
    assert len(found) >= 4
    assert not any(check.passed for check in found), [check for check in found if check.passed]


def test_a_case_runs_as_a_file(tmp_path):
    command = [
        sys.executable,
        ROOT / "cases" / "bar_impact.py",
        "--set",
        "cells=8",
        "--frames",
        "0",
        "--out",
        tmp_path / "run",
    ]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "bar-impact: finished" in done.stdout
    assert (tmp_path / "run" / "summary.json").is_file()
