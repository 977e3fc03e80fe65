"""The Mooney-Rivlin law: its energy by definition, moduli at small strains, stretching, static solve, impacts."""

import dataclasses

import numpy as np
import oracle
import pytest
from force_pass import Step
from oracle import meshes
from scenes import block, material, simulate, thrown, wall
from test_static_solve import pressed, problem, solved

import tcontact as tc
from tcontact.cases import bar_impact, cube_impact
from tcontact.cells.stress import VonMises

C1, C2, BULK = 1.7e6, 0.6e6, 2.9e7
RUBBER = tc.MooneyRivlin(C1, C2, BULK, 1100.0)
pytestmark = pytest.mark.usefixtures("parallel_path")  # one law in every element; both paths: test_periodic.py


def energy_density(f):
    """W(F) word for word as in the docstring of the material."""
    c, j = f.T @ f, np.linalg.det(f)
    first, second = np.trace(c), (np.trace(c) ** 2 - np.trace(c @ c)) / 2
    return C1 * (first - 3) + C2 * (second - 3) - 2 * (C1 + 2 * C2) * np.log(j) + BULK / 2 * (j - 1) ** 2


def test_the_oracle_has_the_energy_of_the_definition():
    law = oracle.MooneyRivlin(RUBBER.young, RUBBER.poisson, C2 / (C1 + C2))
    assert (law.c1, law.c2, law.bulk) == pytest.approx((C1, C2, BULK), rel=1e-12)
    for seed in range(5):
        h = 0.3 * np.random.default_rng(seed).uniform(-1, 1, (3, 3))
        assert law.energy_density(h) == pytest.approx(energy_density(np.eye(3) + h), rel=1e-12)


def test_free_of_stress_at_rest_and_its_small_strain_moduli():
    """Differences of W at F = I: no slope, and the Hessian of linear elasticity with lame_lambda, lame_mu."""
    lam, mu, step = RUBBER.lame_lambda, RUBBER.lame_mu, 1e-4
    basis = np.eye(9).reshape(9, 3, 3)
    for one in basis:
        slope = (energy_density(np.eye(3) + step * one) - energy_density(np.eye(3) - step * one)) / (2 * step)
        assert abs(slope) <= 10 * BULK * step**2
    for one in basis:
        for other in basis:
            found = sum(
                a * b * energy_density(np.eye(3) + step * (a * one + b * other)) for a in (1, -1) for b in (1, -1)
            ) / (4 * step**2)
            linear = mu * np.sum((one + one.T) * (other + other.T)) / 2 + lam * np.trace(one) * np.trace(other)
            assert found == pytest.approx(linear, abs=1e-5 * (lam + 2 * mu))
    assert RUBBER.wave_speed == pytest.approx(np.sqrt((lam + 2 * mu) / 1100.0))
    hooke = tc.NeoHookean(RUBBER.young, RUBBER.poisson, 1100.0)
    assert (hooke.lame_lambda, hooke.lame_mu) == pytest.approx((lam, mu), rel=1e-12)


def test_given_by_young_and_poisson():
    found = tc.MooneyRivlin.of(1e7, 0.3, 1000.0, second=0.25)
    assert (found.young, found.poisson) == pytest.approx((1e7, 0.3), rel=1e-12)
    assert found.c2 == pytest.approx(0.25 * (found.c1 + found.c2), rel=1e-12)
    plain, neo = tc.MooneyRivlin.of(1e7, 0.3, 1000.0, second=0.0), tc.NeoHookean(1e7, 0.3, 1000.0)
    assert plain.parameters == pytest.approx((neo.lame_lambda, neo.lame_mu, 0.0))


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_without_c2_it_is_neo_hookean_and_it_is_objective(kind):
    nodes = np.array(block(kind, 2, size=(2, 2, 2)).nodes)
    cells = block(kind, 2).cells
    u = 0.1 * np.random.default_rng(2).uniform(-1, 1, nodes.shape)
    neo, rubber = Step(kind, "neo_hookean", nodes, cells), Step(kind, "mooney_rivlin", nodes, cells)
    before, energy, _ = rubber.force(u)
    turn = meshes.rotation(3)
    after, same, _ = rubber.force((nodes + u) @ turn.T - nodes)
    assert same == pytest.approx(energy, rel=1e-12)
    assert np.abs(after - before @ turn.T).max() <= 1e-12 * np.abs(before).max()
    rubber.moduli = (*neo.moduli, 0.0)
    assert np.abs(rubber.force(u)[0] - neo.force(u)[0]).max() <= 1e-15


def test_stretched_bar_has_the_nominal_stress_of_the_law():
    """Stretch along x with the free lateral stretch, against dW/d(stretch) by differences of the energy; von Mises."""
    mesh = tc.box_mesh((0.2, 0.1, 0.1), (2, 1, 1))
    for stretch in (0.7, 1.8):
        low, high = 0.5, 1.6  # the lateral stretch where W is least: its slope rises through zero
        for _ in range(60):
            side = 0.5 * (low + high)
            up, down = (energy_density(np.diag([stretch, side + d, side + d])) for d in (1e-6, -1e-6))
            low, high = (low, side) if up > down else (side, high)
        up, down = (energy_density(np.diag([stretch + d, side, side])) for d in (1e-6, -1e-6))
        pull = (up - down) / 2e-6
        u = mesh.nodes * (np.array([stretch, side, side]) - 1.0)
        step = Step("hex8", "mooney_rivlin", np.array(mesh.nodes), mesh.cells)
        step.moduli = RUBBER.parameters
        force = step.force(u)[0]
        assert force[mesh.nodes_of("xmax"), 0].sum() == pytest.approx(pull * 0.01, rel=1e-6)
        assert np.abs(force[:, 1:]).max() <= 1e-6 * abs(pull) * 0.01
        cauchy = pull / side**2
        assert VonMises(tc.Body(mesh, RUBBER))(u) == pytest.approx(np.full(2, abs(cauchy)), rel=1e-6)


@pytest.mark.parametrize(("kind", "removal"), [("hex8", "full"), ("tet4", "normal")])
def test_same_equilibrium_as_the_oracle(kind, removal):
    turn = meshes.rotation(4)
    mesh, normal = block(kind, 3, turn=turn), turn[:, 2]
    scene = tc.Scene(
        [tc.Body(mesh, material("mooney"), contact="zmin")],
        [wall(mesh, normal, 1e-4)],
        1.0,
        gravity=(30.0, -20.0, 10.0),
        contact=tc.MasslessContact(removal=removal, tolerance=1e-12, sweeps=20),
    )
    start = pressed(mesh, normal, 3e-3)
    found, state = solved(scene, start)
    assert state.contact.trouble is None
    assert float(state.contact.static_solve.stats[2]) < 400  # an inexact tangent would need many more
    static, points, loads = problem(scene)
    wanted, table, _, _ = static.solve(np.array(mesh.nodes), start, points, loads)
    assert (table > 0).any()
    assert np.abs(found - wanted).max() <= 1e-10 * 0.2
    assert np.abs(wanted - start).max() >= 1e-4


def test_balance_in_mid_contact():
    scene = thrown("mooney", duration=1.2, speed=0.04, gravity=False,
                   contact=tc.MasslessContact(removal="full", tolerance=1e-10))  # fmt: skip
    result = simulate(scene)
    static, _, _ = problem(scene)
    force, scale = static.force(result.position - scene.bodies[0].mesh.nodes)
    off = np.einsum("kic,ki->kc", static.basis, force - result.contact_node_force[static.contact])
    assert np.abs(result.contact_node_force).max() > 0.1 * scale
    assert np.abs(off).max() <= 1e-8 * scale


def test_bar_impact():
    """A bar of one cell in width, free to bulge: the checks of the case, and its energy error."""
    scene = bar_impact.scene(cells=40)
    bar = dataclasses.replace(scene.bodies[0], material=tc.MooneyRivlin.of(1e7, 0.3, 1000.0))
    result = tc.simulate(dataclasses.replace(scene, bodies=[bar]))
    assert not [check for check in bar_impact.checks(result) if not check.passed]
    assert result.history["energy_error"].max() <= 1e-2
    assert result.history["momentum"][-1, 2] > 0.0


@pytest.mark.parametrize("options", [{"kind": "tet4"}, {"removal": "full"}])
def test_cube_impact(options):
    result = tc.simulate(cube_impact.scene(cells=6, law="mooney-rivlin", **options))
    assert result.history["contact_force"][:, 2].max() > 0.0
    assert not [check for check in cube_impact.checks(result) if not check.passed]
