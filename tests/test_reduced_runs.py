"""Runs with one-point hexes: balance of the contact nodes, the cases, the hourglass column, same bits."""

import dataclasses
import hashlib
import json

import numpy as np
import pytest
from one_point import twin
from oracle import meshes
from scenes import python, simulate, thrown

import tcontact as tc
from tcontact.cases import bar_impact, cube_impact
from tcontact.device import runtime
from tcontact.results import report


def reduced(scene):
    """Return the scene with reduced integration: hexes of one point."""
    return dataclasses.replace(
        scene, bodies=[dataclasses.replace(body, formulation="reduced") for body in scene.bodies]
    )


@pytest.mark.parametrize(("law", "removal", "walls"), [("neo", "full", 2), ("linear", "normal", 1)])
def test_balance_in_mid_contact(law, removal, walls):
    """f_K(x) = contact force, recomputed in numpy from the results alone; the ledger holds the hourglass energy."""
    contact = tc.MasslessContact(removal=removal, tolerance=1e-10)
    scene = reduced(thrown(law, walls=walls, duration=1.2, speed=0.04, contact=contact, gravity=False))
    result = simulate(scene)
    body, history = scene.bodies[0], result.history
    there, u = twin(body), result.position - body.mesh.nodes
    force = there.force(u)
    scale = np.abs(there.cell_force(u)).max()
    contact_plan = tc.plan(scene).bodies[0]
    nodes = contact_plan.node_order[contact_plan.contact.nodes]
    off = np.einsum("kic,ki->kc", contact_plan.contact.basis, (force - result.contact_node_force)[nodes])
    assert np.abs(result.contact_node_force).max() > 0.1 * scale
    assert np.abs(off).max() <= 1e-9 * scale
    assert history["elastic"][-1] == pytest.approx(there.energy(u), rel=1e-9)
    assert history["hourglass"][-1] == pytest.approx(there.hourglass_energy(u), rel=1e-9)
    assert history["hourglass"][-1] > 1e-3 * history["elastic"][-1]
    energy = history["kinetic"] + history["elastic"] + history["contact"] - history["external_work"]
    assert history["energy"] == pytest.approx(energy, rel=1e-14)


def test_bar_impact_with_one_point_hexes():
    """In one dimension both elements are the same: same force, no hourglass energy."""
    scene = bar_impact.scene(cells=40, formulation="reduced")
    result, full = tc.simulate(scene), tc.simulate(bar_impact.scene(cells=40))
    history = result.history
    assert not [check for check in bar_impact.checks(result) if not check.passed]
    assert history["energy_error"].max() <= 1e-2
    assert history["hourglass"].max() <= 1e-13 * history["kinetic"][0]
    wanted = bar_impact.exact_force(history["time"], result.dt, scene)
    assert np.linalg.norm(history["contact_force"][:, 2] - wanted) <= 0.08 * np.linalg.norm(wanted)
    assert "hourglass" not in full.history
    assert full.dt_limit == pytest.approx(result.dt_limit, rel=1e-3)
    assert "hourglass_share_max" not in report.run_attributes(full)


@pytest.mark.parametrize("removal", ["normal", "full"])
def test_cube_impact_with_one_point_hexes(removal):
    result = tc.simulate(cube_impact.scene(cells=8, formulation="reduced", removal=removal))
    history = result.history
    assert result.ok, result.message
    assert not [check for check in cube_impact.checks(result) if not check.passed]
    assert history["energy_error"].max() <= 1e-2
    share = report.run_attributes(result)["hourglass_share_max"]
    assert share == history["hourglass"].max() / (history["kinetic"] + history["elastic"]).max()
    assert 1e-4 < share < 0.02
    summary = report.summary(result, case="cube", parameters={}, checks=[])
    assert f"hourglass at most {share:.2e} of the" in "\n".join(report.lines(json.loads(json.dumps(summary))))
    assert np.all(history["hourglass"] <= history["elastic"] * (1 + 1e-12))


def test_an_impact_turned_in_space_is_the_same_impact():
    """Frame indifference of the whole: force, hourglass stiffness, static solve."""
    runs = []
    for turn in (np.eye(3), meshes.rotation(12)):
        mesh = tc.box_mesh((0.1,) * 3, (4, 4, 4)).rotated(turn)
        point = mesh.nodes[np.argmin(mesh.nodes @ turn[:, 2])]
        body = tc.Body(mesh, tc.NeoHookean(1e7, 0.3, 1000.0), -3.0 * turn[:, 2], contact="zmin", formulation="reduced")
        wall = tc.Plane(point - 1e-9 * turn[:, 2], turn[:, 2])
        scene = tc.Scene([body], [wall], 8e-4, contact=tc.MasslessContact("full", tolerance=1e-12))
        result = simulate(scene, dt=4e-5)
        runs.append((result.position @ turn, result.history["hourglass"]))
    assert runs[0][1].max() > 1e-4 * 1.0
    assert np.abs(runs[0][0] - runs[1][0]).max() <= 1e-9 * 0.1
    assert runs[0][1] == pytest.approx(runs[1][1], rel=1e-5, abs=1e-9)


def test_a_plan_names_its_element():
    scene = cube_impact.scene(cells=3, formulation="reduced", removal="full")
    text = tc.plan(scene).describe()
    assert "27 hex8-reduced cells" in text
    assert "(hex8-reduced-affine, neo_hookean" in text
    assert tc.plan(cube_impact.scene(cells=3)).columns == ()


def digest():
    """Steps and a hash over all that a run returns."""
    contact = tc.MasslessContact(removal="full")
    scene = reduced(thrown("neo", cells=21, duration=0.4, gap=0.001, contact=contact))
    assert not tc.plan(scene).domains[0].small  # small bodies run on one thread anyway
    result = simulate(scene)
    assert np.abs(result.history["contact_force"]).max() > 0.0
    found = hashlib.sha256(result.position.tobytes() + result.velocity.tobytes())
    for name in sorted(result.history):
        found.update(np.ascontiguousarray(result.history[name]).tobytes())
    return f"{result.steps} {found.hexdigest()}"


def test_one_and_two_threads_give_the_same_bits():
    assert runtime.threads() == 2
    code = (
        "from tcontact.device import runtime; runtime.start('cpu', 1); import test_reduced_runs as t; print(t.digest())"
    )
    done = python(code)
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.splitlines()[-1] == digest()
