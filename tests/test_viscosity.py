"""Bulk viscosity: its force against numpy, shocks without ringing, momenta, ledger, step, nothing when absent."""

import dataclasses

import numpy as np
import pytest
from scenes import block, force_of, material, simulate, thrown

import tcontact as tc
from tcontact.cases import wall_shock
from tcontact.planning.lumped_mass import corner_masses, shape_functions
from tcontact.schemes.explicit.stable_step import largest_rate, with_viscosity

USUAL = tc.BulkViscosity(0.06, 1.2)


def viscous(scene, viscosity=USUAL):
    return dataclasses.replace(scene, viscosity=viscosity)


def volumes(mesh, nodes):
    """Volume of each cell and its shortest height: volume over the largest mean area between opposite faces."""
    _values, gradients, weights = shape_functions(mesh.kind)
    corners = nodes[mesh.cells]
    volume, areas = np.zeros(len(corners)), np.zeros((len(corners), 3, 3))
    for gradient, weight in zip(gradients, weights, strict=True):
        jacobian = np.einsum("mac,ad->mcd", corners, gradient)
        volume += weight * np.linalg.det(jacobian)
        areas += 0.5 * weight * np.linalg.det(jacobian)[:, None, None] * np.linalg.inv(jacobian)  # rows: area vectors
    if mesh.kind == "hex8":
        return volume, volume / np.linalg.norm(areas, axis=2).max(axis=1)
    if (
        mesh.kind == "wedge6"
    ):  # of the mean triangle, whose sides turn about the direction from end to end; and of the ends
        sides = [2.0 * areas[:, 0], 2.0 * areas[:, 1], 2.0 * (areas[:, 0] + areas[:, 1]), areas[:, 2]]
        return volume, 2.0 * volume / np.max([np.linalg.norm(2.0 * area, axis=1) for area in sides], axis=0)
    edges = corners[:, 1:] - corners[:, :1]
    faces = [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]
    size = [np.cross(corners[:, b] - corners[:, a], corners[:, c] - corners[:, a]) for a, b, c in faces]
    volume = np.linalg.det(edges) / 6.0
    return volume, 6.0 * volume / np.max([np.linalg.norm(area, axis=1) for area in size], axis=0)


def force(mesh, mat, velocity, viscosity):
    """q dV/dx_k summed over the cells, and -q V' in all, by differences of the volumes."""
    volume, height = volumes(mesh, mesh.nodes)
    slopes = np.zeros((*mesh.cells.shape, 3))
    step = 1e-6 * height.min()
    for corner in range(mesh.cells.shape[1]):
        for axis in range(3):
            for sign in (1.0, -1.0):
                corners = mesh.nodes[mesh.cells]
                corners[:, corner, axis] += sign * step
                alone = tc.Mesh(corners.reshape(-1, 3), np.arange(mesh.cells.size).reshape(mesh.cells.shape), mesh.kind)
                slopes[:, corner, axis] += sign * volumes(alone, alone.nodes)[0] / (2.0 * step)
    change = np.einsum("mkc,mkc->m", slopes, velocity[mesh.cells])
    rate, c = change / volume, mat.wave_speed
    down = np.maximum(-rate, 0.0)
    q = -mat.density * height * (viscosity.linear * c + viscosity.quadratic**2 * height * down) * rate
    result = np.zeros_like(mesh.nodes)
    np.add.at(result, mesh.cells, q[:, None, None] * slopes)
    return result, -(q * change).sum()


@pytest.mark.parametrize(("kind", "formulation"), [
    ("hex8", "full"), ("tet4", "full"), ("wedge6", "full"), ("hex8", "reduced"), ("hex8", "mean-dilatation"),
    ("tet4", "node-averaged"),
])  # fmt: skip
def test_force_and_power_of_one_short_step(kind, formulation):
    """From a velocity field without strain: M dv/dt = q dV/dx, in compressed and in expanding cells."""
    mesh, mat = block(kind, 2, shake=0.25), material("neo")
    velocity = 0.05 * mat.wave_speed * np.random.default_rng(3).uniform(-1.0, 1.0, mesh.nodes.shape)
    body = tc.Body(mesh, mat, velocity=velocity, formulation=formulation)
    dt = 1e-9
    result = simulate(tc.Scene([body], duration=dt, viscosity=USUAL), dt=dt)
    wanted, power = force(mesh, mat, velocity, USUAL)
    mass = np.zeros(mesh.node_count)
    np.add.at(mass, mesh.cells, corner_masses(kind, mesh.nodes, mesh.cells, mat.density))
    found = mass[:, None] * (result.velocity - velocity) / dt
    assert np.abs(found - wanted).max() <= 2e-3 * np.abs(wanted).max()  # elastic force of half a step
    assert result.history["viscous_work"][-1] == pytest.approx(power * dt, rel=2e-3)


def shock(viscosity, **options):
    """Force on the plateau over the exact one, stretches behind the front over the exact compression, the result."""
    scene = viscous(wall_shock.scene(cells=80, mach=0.2), viscosity)
    result = simulate(scene, **options)
    exact, touch, plateau = wall_shock.exact(scene)
    time = result.history["time"] - touch
    flat = (time > 0.2 * time[-1]) & (time < 0.95 * time[-1])
    heights, stretch = wall_shock.stretches(result)
    behind = (heights > 0.1 * heights[-1]) & (heights < 0.55 * heights[-1])
    return result.history["contact_force"][flat, 2] / plateau, (1.0 - stretch[behind]) / (1.0 - exact.stretch), result


def variation(values):
    return np.abs(np.diff(values)).sum()


def test_a_shock_leaves_no_ringing():
    """Neo-Hookean block at 0.2 of its wave speed: plateau, compression and energy right, ringing gone.

    The start of the contact is left out: its overshoot lies in the contact cells, which have no viscosity.
    """
    force_plain, stretch_plain, plain = shock(None)
    force, stretch, result = shock(USUAL, cfl=0.9)
    assert variation(force) <= 0.5 * variation(force_plain)
    assert variation(stretch) <= 0.05 * variation(stretch_plain)
    assert force == pytest.approx(1.0, abs=0.01)
    assert stretch == pytest.approx(1.0, abs=0.01)
    assert result.history["energy_error"].max() <= 1e-2
    assert result.history["viscous_work"][-1] > 0.03 * result.history["kinetic"][0]
    assert np.diff(result.history["viscous_work"]).min() >= 0.0
    assert result.dt < 0.95 * plain.dt
    h = result.history
    total = h["kinetic"] + h["elastic"] + h["contact"] + h["viscous_work"] - h["external_work"]
    assert h["energy"] == pytest.approx(total, rel=1e-13)
    gone = result.history["momentum"] - result.history["momentum"][0]
    given = result.history["impulse"] + result.history["support_impulse"]
    assert np.abs(gone - given).max() <= 1e-12 * np.abs(result.history["momentum"]).max()


def test_the_ledger_closes_with_the_step():
    errors = [shock(USUAL, cfl=cfl)[2].history["energy_error"].max() for cfl in (0.8, 0.4)]
    assert errors[1] <= 0.6 * errors[0]


@pytest.mark.parametrize(("kind", "removal", "walls"), [("hex8", "full", 2), ("tet4", "normal", 1)])
def test_momentum_in_an_impact(kind, removal, walls):
    """Contact cells have none, so the static solve balances elastic forces alone; linear momentum stays exact."""
    contact = tc.MasslessContact(removal=removal, tolerance=1e-13)
    scene = viscous(thrown("neo", kind, walls=walls, contact=contact, cells=4, duration=2.0))
    result = simulate(scene)
    history = result.history
    mass = tc.plan(scene).bodies[0].lumped.sum()
    given = history["impulse"] + mass * np.outer(history["time"], scene.gravity)
    change = history["momentum"] - history["momentum"][0]
    assert np.abs(history["contact_force"]).max() > 0.0
    assert history["viscous_work"][-1] > 1e-3 * history["kinetic"][0]
    assert np.abs(change - given).max() <= 1e-12 * np.abs(history["momentum"]).max()
    assert history["static_residual"].max() <= 1e-10
    assert history["energy_error"].max() <= 0.02


def test_rigid_motion_feels_nothing():
    """A body that flies and turns dissipates nothing but its own vibration, and keeps its angular momentum."""
    mesh, mat = block("hex8", 3), material("neo")
    c = mat.wave_speed
    velocity = np.cross([0.0, 0.1 * c, 0.0], mesh.nodes) + 0.5 * c
    scene = tc.Scene([tc.Body(mesh, mat, velocity=velocity)], duration=0.4 / c)
    history = simulate(viscous(scene)).history
    assert history["viscous_work"][-1] <= 1e-5 * history["kinetic"][0]
    spun = history["angular_momentum"]
    assert np.abs(spun - spun[0]).max() <= 1e-10 * np.abs(spun).max()


@pytest.mark.parametrize("linear", [0.06, 0.5])
def test_a_run_at_cfl_0_9_is_stable_and_the_step_without_viscosity_is_not(linear):
    """Noise in every mode of a free block: energy only falls at 0.9 of the limit; the elastic limit is too long."""
    mesh, mat = block("hex8", 4), material("neo")
    velocity = 1e-3 * mat.wave_speed * np.random.default_rng(1).uniform(-1.0, 1.0, mesh.nodes.shape)
    plain = tc.Scene([tc.Body(mesh, mat, velocity=velocity)], duration=100 * 0.05 / mat.wave_speed)
    scene = viscous(plain, tc.BulkViscosity(linear, 0.0))
    result = simulate(scene, cfl=0.9)
    energy = result.history["kinetic"] + result.history["elastic"]
    assert energy.max() <= 1.2 * energy[0]
    assert energy[-1] <= 0.8 * energy[0]  # motion at constant volume stays
    elastic = simulate(dataclasses.replace(plain, duration=1e-6)).dt_limit
    assert result.dt_limit < (1.0 - 0.8 * min(linear, 0.3)) * elastic
    if linear == 0.5:
        with pytest.warns(RuntimeWarning, match="above the stable step"):
            beyond = tc.simulate(scene, scheme=tc.CentralDifference(dt=elastic))
        assert beyond.reason == "diverged"


def test_a_strong_quadratic_part_shortens_the_step():
    """At first contact the rate jumps in one step: the run must survive it, here with 9 times the usual pressure."""
    scene = viscous(wall_shock.scene(cells=40, mach=0.4), tc.BulkViscosity(0.06, 3.0))
    result = simulate(scene, cfl=0.95)
    assert np.diff(result.history["time"])[-2] < 0.6 * result.dt
    assert result.history["kinetic"].max() <= 1.01 * result.history["kinetic"][0]


def test_the_step_with_viscosity_is_that_of_the_damped_oscillator():
    """dt omega = 2 (sqrt(1 + xi^2) - xi), and its inverse."""
    omega = 3.0
    for xi in (0.0, 0.06, 0.5, 2.0):
        dt = with_viscosity(2.0 / omega, 2.0 * xi * omega)
        assert dt == pytest.approx(2.0 / omega * (np.sqrt(1.0 + xi**2) - xi), rel=1e-12)
        assert largest_rate(2.0 / omega, dt) == pytest.approx(2.0 * xi * omega, rel=1e-9, abs=1e-12)


def test_absent_it_leaves_nothing_behind():
    """No column, no option of a kernel, no parameter, no sums, no term."""
    from tcontact.kernels.columns import CELL_SUMS
    from tcontact.kernels.lanes import CHUNKS, MATERIALS
    from tcontact.planning.describe import memory

    scene = thrown(duration=0.1, contact=tc.MasslessContact())
    without, with_it = tc.plan(scene), tc.plan(viscous(scene))
    assert without.columns == ()
    assert without.bodies[0].options == {}
    force = force_of(without.bodies[0])
    assert len(force.cell_sums) == 2 * CHUNKS * CELL_SUMS
    assert len(force.parameters) == MATERIALS + 2  # lambda and mu
    assert "visco" not in without.describe()
    assert "viscous_work" not in simulate(scene).history
    assert with_it.columns == ("viscous_work",)
    assert "bulk-viscosity" in with_it.terms
    assert "viscous" in with_it.describe()
    foreseen = memory(with_it, with_it.domains[0])["internal-force"]
    assert foreseen == pytest.approx(simulate(viscous(scene)).memory["internal-force"], rel=0.05)


@pytest.mark.parametrize(("linear", "quadratic"), [(-0.1, 1.0), (0.1, -1.0), (0.0, 0.0), (np.nan, 1.0), ("a", 1.0),
                                                   (0.1, None), (True, 1.0)])  # fmt: skip
def test_wrong_numbers_are_refused(linear, quadratic):
    with pytest.raises(tc.InputError, match="BulkViscosity"):
        tc.BulkViscosity(linear, quadratic)


@pytest.mark.parametrize("viscosity", [0.1, (0.06, 1.2), tc.MassDamping(1.0)])
def test_wrong_viscosity_is_refused(viscosity):
    with pytest.raises(tc.InputError, match=r"Scene\.viscosity"):
        tc.Scene([tc.Body(block(), material())], duration=1.0, viscosity=viscosity)
