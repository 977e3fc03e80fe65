"""Runs with one volume change per hex: balance of the contact nodes, the cases, nearly incompressible impacts."""

import dataclasses

import numpy as np
import pytest
from one_point import twin
from oracle import meshes
from scenes import simulate, thrown

import tcontact as tc
from tcontact.cases import bar_impact, cube_impact
from tcontact.contact.solve_settings import TOLERANCE

MEAN = "mean-dilatation"
pytestmark = pytest.mark.usefixtures("parallel_path")  # both paths: test_periodic.py


def with_mean(scene, **changes):
    """Return the scene with mean dilatation: one volume change per hex."""
    return dataclasses.replace(
        scene, bodies=[dataclasses.replace(body, formulation=MEAN, **changes) for body in scene.bodies]
    )


@pytest.mark.parametrize(("law", "removal", "walls"), [("neo", "full", 1), ("linear", "normal", 1)])
def test_balance_in_mid_contact(law, removal, walls):
    """f_K(x) = contact force, recomputed in numpy from the results alone; the ledger holds the energy."""
    contact = tc.MasslessContact(removal=removal, tolerance=1e-10)
    scene = with_mean(thrown(law, walls=walls, duration=1.2, speed=0.04, contact=contact, gravity=False))
    result = simulate(scene)
    body = scene.bodies[0]
    there, u = twin(body), result.position - body.mesh.nodes
    scale = np.abs(there.cell_force(u)).max()
    plan = tc.plan(scene).bodies[0]
    nodes = plan.node_order[plan.contact.nodes]
    off = np.einsum("kic,ki->kc", plan.contact.basis, (there.force(u) - result.contact_node_force)[nodes])
    assert np.abs(result.contact_node_force).max() > 0.1 * scale
    assert np.abs(off).max() <= 1e-9 * scale
    assert result.history["elastic"][-1] == pytest.approx(there.energy(u), rel=1e-9)


@pytest.mark.parametrize("removal", ["normal", "full"])
def test_static_solve_meets_its_residual_with_an_exact_tangent(removal):
    """Few linearisations: many sweeps to a tight tolerance, near poisson 1/2, and no stop."""
    scene = cube_impact.scene(cells=4, poisson=0.49, formulation=MEAN, removal=removal, tolerance=1e-9, duration=6e-4)
    result = simulate(scene)
    assert result.history["contact_force"][:, 2].max() > 0.0
    assert result.history["static_residual"].max() <= 1e-9


def test_bar_impact():
    """Poisson 0 and one dimension: both formulations are the same there."""
    scene = bar_impact.scene(cells=40, formulation=MEAN)
    result, full = tc.simulate(scene), tc.simulate(bar_impact.scene(cells=40))
    assert not [check for check in bar_impact.checks(result) if not check.passed]
    assert np.abs(result.position - full.position).max() <= 1e-10 * 0.1
    assert result.dt_limit == pytest.approx(full.dt_limit, rel=1e-6)


def test_bar_impact_of_a_bar_that_bulges():
    """Poisson 0.3: the checks that do not compare with the one-dimensional solution, and the energy."""
    scene = bar_impact.scene(cells=40, law="neo-hookean", formulation=MEAN)
    material = tc.NeoHookean(1e7, 0.3, 1000.0)
    result = tc.simulate(with_mean(scene, material=material))
    assert not [check for check in bar_impact.checks(result) if not check.passed]
    assert result.history["energy_error"].max() <= 1e-2
    assert result.history["momentum"][-1, 2] > 0.0


@pytest.mark.parametrize(
    "options",
    [
        {"poisson": 0.3, "removal": "full"},
        {"poisson": 0.499, "removal": "normal"},
        {"poisson": 0.499, "removal": "full"},
        {"poisson": 0.499, "law": "mooney-rivlin"},
        {"poisson": 0.499, "law": "linear"},
        {"poisson": 0.45, "pitch": 10.0, "yaw": 20.0},
    ],
    ids=str,
)
def test_cube_impact_meets_its_checks(options):
    result = tc.simulate(cube_impact.scene(cells=6, formulation=MEAN, **options))
    assert result.ok, result.message
    assert result.history["contact_force"][:, 2].max() > 0.0
    assert not [check for check in cube_impact.checks(result) if not check.passed]
    assert result.history["energy_error"].max() <= 0.05


@pytest.mark.parametrize("poisson", [0.4999, 0.49999])
def test_closer_to_one_half_full_removal_converges(poisson):
    """K_KK of lambda/mu = 5000 and 50000: few products with it are enough."""
    scene = cube_impact.scene(cells=6, poisson=poisson, formulation=MEAN, removal="full", duration=1.2e-3)
    result = tc.simulate(scene)
    assert result.ok, result.message
    assert result.history["contact_force"][:, 2].max() > 0.0
    assert not [check for check in cube_impact.checks(result) if not check.passed]
    assert result.history["sweeps"].max() <= 120
    assert result.history["energy_error"].max() <= 1e-3
    rounding = 1.0 if poisson < 0.49999 else 2.0  # at lambda/mu = 50000 it alone is larger than the tolerance
    assert 0.0 < result.history["static_residual"].max() <= rounding * TOLERANCE


@pytest.mark.parametrize(("poisson", "tolerance"), [(0.499999, TOLERANCE), (0.49999, 1e-9)])
def test_too_close_to_one_half_stops_with_a_remedy(poisson, tolerance):
    """Sweeps with lambda/mu = 500000, or to a tight tolerance, stop at the first row that is not in equilibrium."""
    scene = cube_impact.scene(cells=6, poisson=poisson, formulation=MEAN, removal="normal", duration=6e-4)
    scene = dataclasses.replace(scene, contact=tc.MasslessContact("normal", solver="gauss-seidel", tolerance=tolerance))
    result = tc.simulate(scene)
    assert result.reason == "not-converged"
    assert "poisson" in result.message
    assert "implicit" in result.message
    assert result.history["contact_force"][:-1, 2].max() > 0.0
    assert 0.0 < result.history["static_residual"][:-1].max() <= tolerance


def test_an_impact_turned_in_space_is_the_same_impact():
    runs = []
    for turn in (np.eye(3), meshes.rotation(12)):
        mesh = tc.box_mesh((0.1,) * 3, (4, 4, 4)).rotated(turn)
        point = mesh.nodes[np.argmin(mesh.nodes @ turn[:, 2])]
        body = tc.Body(mesh, tc.NeoHookean(1e7, 0.45, 1000.0), -3.0 * turn[:, 2], contact="zmin", formulation=MEAN)
        wall = tc.Plane(point - 1e-9 * turn[:, 2], turn[:, 2])
        scene = tc.Scene([body], [wall], 8e-4, contact=tc.MasslessContact("full", tolerance=1e-12))
        runs.append(simulate(scene, dt=4e-5).position @ turn)
    assert np.abs(runs[0] - runs[1]).max() <= 1e-9 * 0.1


def test_a_nearly_incompressible_impact_is_softer_than_locking_hexes_make_it():
    """Poisson 0.499, long after the shock: the cube of locking hexes gives back the momentum too early."""
    runs = {}
    for formulation in ("full", MEAN):
        scene = cube_impact.scene(cells=4, poisson=0.499, formulation=formulation, removal="full", duration=1.5e-3)
        result = simulate(scene)
        bulge = np.abs(result.position[:, :2]).max() - 0.05
        runs[formulation] = bulge
    assert runs[MEAN] > 1.1 * runs["full"] > 0.0
