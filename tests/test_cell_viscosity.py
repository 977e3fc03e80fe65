"""Viscous contact cells: force against numpy, rigid motion, the stable step, sliding, the ledger, nothing elsewhere."""

import dataclasses

import numpy as np
import oracle
import pytest
from oracle.central_difference import free_inverse, heights
from scenes import block, material, simulate, stable_steps, state_of, thrown, twin, twin_planes, wall

import tcontact as tc
from tcontact.cases import pressure_shear, sliding_block
from tcontact.planning.body_plan import SMALL

MU = 0.35
NORMAL = tc.MasslessContact(removal="normal")
KINDS = [("hex8", "full"), ("tet4", "full"), ("hex8", "reduced"), ("hex8", "mean-dilatation")]


def rubbing(law="neo", kind="hex8", formulation="full", contact=NORMAL, cells=3, **options):
    """A shaken block above a plane with friction."""
    scene = thrown(law, kind, contact=contact, cells=cells, **options)
    body = dataclasses.replace(scene.bodies[0], formulation=formulation)
    return dataclasses.replace(scene, bodies=[body], friction=tc.Coulomb(MU))


def force(scene, u, step):
    """The program's viscous force [n, 3] times the time of a step [n, 3] that ends at the displacement u [n, 3]."""
    planned = tc.plan(scene).bodies[0]
    state = state_of(scene, planned)
    order = planned.node_order
    found = state.serial.viscous_force(u[order].reshape(-1), step[order].reshape(-1))
    return planned.to_user(found.reshape(-1, 3))


def contact_cells(body):
    return np.isin(body.mesh.cells, body.contact_nodes).any(axis=1)


def moduli(scene, beta=0.2):
    """eta lambda and eta mu of every contact cell, as laws of numpy, with the cells."""
    body = scene.bodies[0]
    cells = body.mesh.cells[contact_cells(body)]
    eta = beta * heights(body.mesh.nodes, cells) / body.material.wave_speed
    return cells, eta, twin(body).law


def displaced(mesh, share, seed=4):
    size = np.ptp(mesh.nodes, axis=0).max()
    return share * size * np.random.default_rng(seed).uniform(-1.0, 1.0, mesh.nodes.shape)


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
def test_force_is_the_stress_of_the_rate_of_greens_strain(kind, parallel_path):
    """sigma = eta C : F^-t (E - E_before) F^-1 with steps as large as the cells deform, on present positions."""
    scene = rubbing(kind=kind)
    mesh = scene.bodies[0].mesh
    u, step = displaced(mesh, 0.01), displaced(mesh, 0.02, 5)
    cells, eta, law = moduli(scene)
    rest = oracle.quadrature(mesh.nodes, cells, kind)
    now, before = (np.eye(3) + oracle.cells.displacement_gradient(rest, field) for field in (u, u - step))
    change = np.swapaxes(now, -1, -2) @ now - np.swapaxes(before, -1, -2) @ before
    inverse = np.linalg.inv(now)
    rate = 0.5 * np.swapaxes(inverse, -1, -2) @ change @ inverse
    stress = eta[:, None, None, None] * (
        2.0 * law.mu * rate + law.lam * np.trace(rate, axis1=2, axis2=3)[..., None, None] * np.eye(3)
    )
    here = oracle.quadrature(mesh.nodes + u, cells, kind)
    corner = np.einsum("mqij,mqaj,mq->mai", stress, here.gradient, here.weight)
    wanted = oracle.assemble(cells, corner, len(u))
    assert np.abs(force(scene, u, step) - wanted).max() <= 1e-12 * np.abs(wanted).max()


@pytest.mark.parametrize("formulation", ["reduced", "mean-dilatation"])
def test_formulations_damp_what_they_stiffen(formulation, parallel_path):
    """A small step: eta times the linear stiffness of the deformed cells, hourglass stiffness and mean pressure too."""
    scene = rubbing(formulation=formulation)
    mesh = scene.bodies[0].mesh
    u, step = displaced(mesh, 0.01), displaced(mesh, 1e-8, 5)
    cells, eta, law = moduli(scene)
    element = oracle.ReducedHex if formulation == "reduced" else oracle.MeanDilatation
    corner = eta[:, None, None] * element(
        mesh.nodes + u, cells, oracle.LinearElastic(law.young, law.poisson)
    ).cell_force(step)
    wanted = oracle.assemble(cells, corner, len(u))
    assert np.abs(force(scene, u, step) - wanted).max() <= 1e-5 * np.abs(wanted).max()


@pytest.mark.parametrize(("kind", "formulation"), KINDS)
def test_a_rigid_motion_has_no_viscous_force(kind, formulation, parallel_path):
    """From a strained state through a finite turn: an angle of 40 degrees in one step leaves rounding."""
    scene = rubbing(kind=kind, formulation=formulation)
    mesh = scene.bodies[0].mesh
    strained = mesh.nodes + displaced(mesh, 0.01)
    axis = np.array([1.0, 2.0, -0.5]) / np.linalg.norm([1.0, 2.0, -0.5])
    cross = np.cross(np.eye(3), axis)
    turn = np.eye(3) + np.sin(0.7) * cross + (1.0 - np.cos(0.7)) * cross @ cross
    now = strained @ turn.T + 0.3
    rigid = force(scene, now - mesh.nodes, now - strained)
    other = force(scene, now - mesh.nodes, displaced(mesh, 0.1))
    assert np.abs(other).max() > 0.0
    assert np.abs(rigid).max() <= 1e-12 * np.abs(other).max()


def test_the_linear_law_has_linear_viscosity(parallel_path):
    """On the reference state, eta K step; a small turn is free of force."""
    scene = rubbing("linear")
    mesh = scene.bodies[0].mesh
    u, step = displaced(mesh, 0.05), displaced(mesh, 0.03, 5)
    cells, eta, law = moduli(scene)
    wanted = oracle.assemble(cells, eta[:, None, None] * oracle.cells.cell_force(
        oracle.quadrature(mesh.nodes, cells, "hex8"), law, step), len(u))  # fmt: skip
    assert np.abs(force(scene, u, step) - wanted).max() <= 1e-12 * np.abs(wanted).max()
    spin = np.cross([3.0, -1.0, 2.0], mesh.nodes) + 0.1
    assert np.abs(force(scene, u, spin)).max() <= 1e-12 * np.abs(wanted).max() * np.abs(spin).max() / np.abs(step).max()


def limit(scene, beta, searches=1):
    """The stable step by dense matrices: 4 M - dt^2 K - 2 dt C on what has mass, in units of the program's estimate.

    searches: number of searches, of which the last one counts.
    """
    planned = tc.plan(scene).bodies[0]
    zero = np.zeros_like(planned.reference)
    state = state_of(scene, planned)
    estimator = stable_steps(planned, state.internal_force, scene.obstacles, None, state.serial.viscous_force)
    found = [estimator.estimate(zero.reshape(-1)) for _ in range(searches)][-1]
    body = scene.bodies[0]
    there, mesh = twin(body), body.mesh
    quad = oracle.quadrature(mesh.nodes, mesh.cells, mesh.kind)
    masses = oracle.lumped_cell_mass(quad, there.density)
    normals = [plane.unit for plane in twin_planes(scene)]
    free = np.isnan(body.prescribed)
    spread = oracle.redistribute(
        mesh.nodes, mesh.cells, masses, body.contact_nodes, "normal", np.array(normals), 1, free
    )
    inverse = np.zeros((mesh.nodes.size,) * 2)
    for node, part in enumerate(free_inverse(spread.tensor, free)):
        inverse[3 * node : 3 * node + 3, 3 * node : 3 * node + 3] = part
    eta = np.where(contact_cells(body), beta * heights(mesh.nodes, mesh.cells) / body.material.wave_speed, 0.0)
    viscous = dataclasses.replace(quad, weight=quad.weight * eta[:, None])
    stiff, resist = (oracle.tangent(part, there.law, 0.0 * mesh.nodes).toarray() for part in (quad, viscous))
    values, vectors = np.linalg.eigh(inverse)
    root = (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T
    low, high = 0.0, estimator.elastic * 2.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        largest = np.linalg.eigvalsh(root @ (middle**2 * stiff + 2.0 * middle * resist) @ root)[-1]
        low, high = (middle, high) if largest <= 4.0 else (low, middle)
    return found / low, found / estimator.elastic


@pytest.mark.parametrize(("kind", "beta"), [("hex8", 1.0), ("tet4", 1.0), ("hex8", 0.4)])
def test_the_stable_step_is_that_of_the_damped_body(kind, beta):
    scene = rubbing("linear", kind, contact=tc.MasslessContact("normal", cell_viscosity=beta))
    share, of_elastic = limit(scene, beta)
    assert 0.9 <= share <= 1.0
    assert of_elastic < 1.0


def noise(beta, gap):
    """A block with noise in every mode at `gap` over a plane."""
    mesh, mat = block("hex8", 3), material("linear")
    velocity = 1e-3 * mat.wave_speed * np.random.default_rng(1).uniform(-1.0, 1.0, mesh.nodes.shape)
    body = tc.Body(mesh, mat, velocity=velocity, contact="zmin")
    contact = tc.MasslessContact("normal", cell_viscosity=beta)
    span = 20.0 * 0.2 / mat.wave_speed
    return tc.Scene([body], [wall(mesh, (0.0, 0.0, 1.0), gap)], span, contact=contact, friction=tc.Coulomb(MU))


@pytest.mark.parametrize(("beta", "cfl"), [(0.2, 0.95), (0.2, 0.1), (2.0, 0.95), (2.0, 0.1)])
def test_energy_falls_at_any_step_below_the_stable_one(beta, cfl):
    """Also at small ones, where eta/dt is large and a rate of massless nodes that is only predicted would blow up."""
    history = simulate(noise(beta, 1.0), cfl=cfl, history_every=10).history
    energy = history["kinetic"] + history["elastic"]
    assert energy.max() <= 1.1 * energy[0]
    assert energy[-1] <= 0.9 * energy[0]
    assert np.diff(history["viscous_work"]).min() >= 0.0


def test_the_undamped_limit_is_too_long_for_much_viscosity():
    scene = noise(2.0, 1e-3)
    undamped = simulate(dataclasses.replace(noise(0.0, 1e-3), duration=1e-6)).dt_limit
    assert simulate(dataclasses.replace(scene, duration=1e-6)).dt_limit < 0.7 * undamped
    with pytest.warns(RuntimeWarning, match="above the stable step"):
        assert tc.simulate(scene, scheme=tc.CentralDifference(dt=undamped)).reason == "diverged"


def inclined(angle, friction, cells, kind="hex8", beta=None, transits=300.0, removal="normal", formulation="full"):
    """A block 1.4 x 1.1 x .8 that slides down from rest: friction over mu x normal impulse, acceleration over that of a
    rigid block, both of the second half, and the result."""
    height = 0.8
    scene = sliding_block.scene(motion="slide", cells=cells, angle=angle, friction=friction, kind=kind,
                                height=height, removal=removal, cell_viscosity=beta)  # fmt: skip
    body = scene.bodies[0]
    counts = (round(1.75 * cells), round(1.375 * cells), cells)
    mesh = tc.box_mesh((1.4, 1.1, height), counts, kind)
    body = dataclasses.replace(body, mesh=mesh, formulation=formulation)
    duration = transits * height / body.material.wave_speed
    result = simulate(dataclasses.replace(scene, bodies=[body], duration=duration), history_every=10)
    time, half = result.history["time"], len(result.history["time"]) // 2
    pushed = result.history["impulse"][-1] - result.history["impulse"][half]
    mass = body.material.density * 1.4 * 1.1 * height
    gained = (result.history["momentum"][-1, 0] - result.history["momentum"][half, 0]) / (time[-1] - time[half]) / mass
    return -pushed[0] / (friction * pushed[2]), gained / sliding_block.rigid(scene)[0], result


@pytest.fixture
def small_sizes(monkeypatch):
    """Bodies of up to 10^5 cells do many steps a launch, as small ones do outside the tests."""
    for kind in SMALL:
        monkeypatch.setitem(SMALL, kind, 10**5)


def test_what_slides_keeps_its_friction(small_sizes):
    """21.6 degrees, mu .321: without viscosity 5 % of the friction are lost and a fifth too much acceleration."""
    friction, _, undamped = inclined(21.6, 0.321, 8, beta=0.0, transits=200.0)
    assert friction < 0.98
    friction, acceleration, result = inclined(21.6, 0.321, 8, transits=200.0)
    assert abs(friction - 1.0) <= 3e-3
    assert abs(acceleration - 1.0) <= 0.08
    assert result.history["energy_error"].max() <= 1e-2
    assert result.history["viscous_work"][-1] > 0.0
    assert result.dt_limit > 0.85 * undamped.dt_limit


TABLE = [(7.0, 0.8 * np.tan(np.radians(7.0)), cells, kind) for cells in (8, 12, 16) for kind in ("hex8", "tet4")]
TABLE += [(21.6, 0.321, cells, kind) for cells in (4, 8, 12) for kind in ("hex8", "tet4")]


@pytest.mark.slow
@pytest.mark.parametrize(("angle", "friction", "cells", "kind"), TABLE)
def test_sliding_does_not_get_worse_with_the_cells(angle, friction, cells, kind, small_sizes):
    share, acceleration, result = inclined(angle, friction, cells, kind)
    gentle = angle < 10.0
    assert abs(share - 1.0) <= (1e-3 if gentle else 3e-3)
    assert abs(acceleration - 1.0) <= (5e-3 if gentle else 0.08)
    assert result.history["energy_error"].max() <= 1e-2


@pytest.mark.slow
@pytest.mark.parametrize("formulation", ["reduced", "mean-dilatation"])
def test_sliding_with_other_formulations(formulation, small_sizes):
    share, acceleration, _ = inclined(7.0, 0.8 * np.tan(np.radians(7.0)), 12, formulation=formulation)
    assert abs(share - 1.0) <= 1e-3
    assert abs(acceleration - 1.0) <= 5e-3


def test_the_ledger_of_an_oblique_impact_closes():
    """The work of the wall over the gap of the first touch is left: it falls with the step."""
    scene = dataclasses.replace(rubbing("linear"), gravity=None)
    errors = []
    for cfl in (0.4, 0.1):
        result = simulate(scene, cfl=cfl)
        history = result.history
        errors.append(history["energy_error"].max())
        assert np.diff(history["viscous_work"]).min() >= -1e-9 * history["viscous_work"][-1]
        total = history["kinetic"] + history["elastic"] + history["friction_work"] + history["viscous_work"]
        assert history["energy"] == pytest.approx(total - history["external_work"], rel=1e-13)
        given = history["momentum"] - history["momentum"][0] - history["impulse"]
        assert np.abs(given).max() <= 1e-12 * np.abs(history["momentum"]).max()
    assert errors[0] <= 1e-2
    assert errors[1] <= 0.5 * errors[0]


@pytest.mark.parametrize(
    ("law", "kind", "formulation"),
    [
        ("neo", "tet4", "full"),
        pytest.param("linear", "hex8", "full", marks=pytest.mark.slow),
        pytest.param("neo", "hex8", "mean-dilatation", marks=pytest.mark.slow),
    ],
)
def test_one_kernel_two_kernels_and_many_steps_a_launch_give_the_same(law, kind, formulation, monkeypatch):
    """The force in a pass of its own, in the launch of the contact cells, and in that of a small body."""
    scene = rubbing(law, kind, formulation, cells=4)
    cells = len(scene.bodies[0].mesh.cells)
    results = []
    for most in (0, cells - 1, cells):
        for name in SMALL:
            monkeypatch.setitem(SMALL, name, most)
        results.append(simulate(scene))
    for other in results[1:]:
        assert np.abs(other.position - results[0].position).max() <= 1e-9 * 0.2
        for column in ("viscous_work", "friction_work", "impulse", "energy"):
            scale = np.abs(results[0].history[column]).max()
            assert np.abs(other.history[column] - results[0].history[column]).max() <= 1e-7 * scale, column
    assert results[0].history["static_residual"].max() <= 1e-4


def test_both_viscosities_may_be_on():
    """They act in different cells: what both dissipate closes the ledger, and the step fits both."""
    scene = rubbing("linear")
    both = dataclasses.replace(scene, viscosity=tc.BulkViscosity())
    alone, result = simulate(scene), simulate(both)
    assert result.dt_limit < alone.dt_limit
    assert result.history["viscous_work"][-1] > alone.history["viscous_work"][-1]
    assert result.history["energy_error"].max() <= 0.02
    planned = tc.plan(both)
    assert planned.columns == ("viscous_work",)
    assert {"bulk-viscosity", "cell-viscosity"} <= set(planned.terms)


def test_a_column_that_sticks_or_slides_keeps_its_waves():
    """Pressure and shear on the plateau, work of friction and energy lost in sticking, with and without viscosity."""
    for friction in (0.2, 1.0):
        plain, damped = (
            simulate(pressure_shear.scene(cells=40, friction=friction, cell_viscosity=beta)) for beta in (0.0, None)
        )
        waves = pressure_shear.exact(damped.scene)
        flat = damped.history["time"] - waves.touch
        flat = (flat > 0.3 * (waves.release - waves.touch)) & (flat < 0.9 * (waves.release - waves.touch))
        tractions = [part[flat].mean() for part in pressure_shear.tractions(damped)]
        assert tractions == pytest.approx([waves.pressure, waves.shear], rel=1e-3)
        works = [result.history["friction_work"][-1] / result.history["kinetic"][0] for result in (plain, damped)]
        assert works[1] == pytest.approx(works[0], rel=0.02, abs=1e-3)
        assert damped.history["viscous_work"][-1] <= 0.02 * damped.history["kinetic"][0]


@pytest.mark.parametrize(
    ("contact", "friction"),
    [
        (NORMAL, None),
        (NORMAL, tc.Coulomb(0.0)),
        (tc.MasslessContact("normal", cell_viscosity=0.0), tc.Coulomb(MU)),
        (tc.MasslessContact("full"), tc.Coulomb(MU)),
        (tc.PenaltyContact(1e9), tc.Coulomb(MU)),
    ],
    ids=["frictionless", "coefficient 0", "turned off", "full removal", "penalty"],
)
def test_absent_it_leaves_nothing_behind(contact, friction):
    scene = dataclasses.replace(rubbing("linear", contact=contact, duration=0.2), friction=friction)
    planned = tc.plan(scene)
    state = state_of(scene, planned.bodies[0])
    assert "visco" not in planned.describe()
    assert planned.columns == ()
    assert not state.contact.options.viscous
    assert state.serial.cells is None
    assert "viscous_work" not in simulate(scene).history


@pytest.mark.parametrize("friction", [None, tc.Coulomb(MU), tc.FrictionLayer(), tc.RegularizedCoulomb(MU, 0.1)])
def test_it_is_there_by_default_where_friction_meets_normal_removal(friction):
    scene = dataclasses.replace(rubbing(), friction=friction)
    assert ("cell-viscosity" in tc.plan(scene).terms) is (friction is not None)
    assert ("viscosity of the contact cells" in tc.plan(scene).describe()) is (friction is not None)


@pytest.mark.parametrize(("removal", "friction"), [("full", tc.Coulomb(MU)), ("normal", None)])
def test_a_number_where_there_is_none_is_refused(removal, friction):
    scene = dataclasses.replace(rubbing(contact=tc.MasslessContact(removal, cell_viscosity=0.3)), friction=friction)
    with pytest.raises(tc.InputError, match=r"MasslessContact\.cell_viscosity = 0\.3: .*removal='normal'"):
        tc.plan(scene)


@pytest.mark.parametrize("value", [-0.1, np.nan, np.inf, "a", True])
def test_wrong_numbers_are_refused(value):
    with pytest.raises(tc.InputError, match="cell_viscosity"):
        tc.MasslessContact(cell_viscosity=value)


@pytest.mark.parametrize(("friction", "warns"), [(0.59, False), (0.6, True)])
def test_sliding_with_much_friction_is_warned_about(friction, warns):
    """Thrown along the plane; what sticks at once is not meant."""
    scene = pressure_shear.scene(cells=10, friction=friction, sideways=4.0)
    result = tc.simulate(scene)
    assert any("flutter" in text for text in result.warnings) is warns
    assert not tc.simulate(pressure_shear.scene(cells=20, friction=1.0)).warnings


def test_it_stands_in_scene_files(tmp_path):
    """A number and 0 are written and read; the default is left out."""
    for value in (None, 0.0, 0.3):
        scene = rubbing(contact=tc.MasslessContact("normal", cell_viscosity=value))
        tc.save_scene(scene, tmp_path / "scene.toml")
        assert ("cell_viscosity" in (tmp_path / "scene.toml").read_text(encoding="utf-8")) is (value is not None)
        back, _ = tc.load_scene(tmp_path / "scene.toml")
        assert back.contact == scene.contact
        assert tc.plan(back).bodies[0].contact.viscosity == (0.2 if value is None else value)


@pytest.mark.parametrize("removal", ["normal", "full"])
@pytest.mark.parametrize(
    ("poisson", "friction", "warns"), [(0.49, 0.24, 0), (0.49, 0.3, 1), (0.45, 0.3, 0), (0.4, 0.4, 1)]
)
def test_sliding_near_poisson_one_half_is_warned_about(removal, poisson, friction, warns):
    """Where METHOD 3 has measured that every contact model flutters; a block thrown along a plane."""
    mesh = tc.box_mesh((0.2, 0.2, 0.05), (3, 3, 1))
    law = tc.NeoHookean(1e6, poisson, 1000.0)
    body = tc.Body(mesh, law, (1.0, 0.0, 0.0), contact="zmin", formulation="mean-dilatation")
    scene = tc.Scene([body], [tc.Plane()], 0.05, contact=tc.MasslessContact(removal), gravity=(0.0, 0.0, -10.0))
    result = tc.simulate(dataclasses.replace(scene, friction=tc.Coulomb(friction)))
    told = [text for text in result.warnings if "flutter" in text]
    assert len(told) == warns
    assert all(f"coefficient of {friction:g} and poisson {poisson:g}" in text for text in told)
