"""One-point hexes: force against numpy, rigid motion, patches, hourglass modes, fields, bad input."""

import numpy as np
import oracle
import pytest
from one_point import SIZE, Force, body_of, distorted, moved, twin
from oracle import meshes
from oracle.cells import displacement_gradient
from oracle.reduced import HOURGLASS_MODES
from scenes import LAWS, material

import tcontact as tc
from tcontact.cells.stress import VonMises
from tcontact.run.worst_cell import worst_cell_of


@pytest.mark.parametrize("law", LAWS)
def test_force_and_energy_match_numpy_and_each_other(law):
    body = body_of(distorted(), law)
    there, force, u = twin(body), Force(body), moved(body.mesh, 0.2)
    found = force(u)
    exact = there.force(u)
    assert np.abs(found - exact).max() <= 1e-13 * np.abs(exact).max()
    assert force.energy == pytest.approx(there.energy(u), rel=1e-13)
    assert force.hourglass == pytest.approx(there.hourglass_energy(u), rel=1e-13)
    assert force.hourglass > 0.01 * force.energy
    wanted = 1.0 + oracle.laws.volume_change(displacement_gradient(there.point, u)).min()
    assert force.jacobian == pytest.approx(wanted, rel=1e-13)
    way, step = np.random.default_rng(3).uniform(-1, 1, u.shape), 1e-6
    ends = []
    for sign in (1.0, -1.0):
        force(u + sign * step * way)
        ends.append(force.energy)
    assert (ends[0] - ends[1]) / (2 * step) == pytest.approx(np.sum(found * way), rel=1e-7)


@pytest.mark.parametrize("law", LAWS)
def test_rigid_motion_gives_no_force(law):
    body = body_of(distorted(), law)
    force, scale = Force(body), body.material.young * 0.06**2
    assert not force(np.zeros_like(body.mesh.nodes) + np.array([1024.0, -512.0, 2048.0])).any()
    assert force.energy == force.hourglass == 0.0
    turn = meshes.rotation(5)
    found = force(body.mesh.nodes @ turn.T - body.mesh.nodes)
    assert force.hourglass <= 1e-26 * scale  # a square; a rotation strains the linear law, but gives no hourglass
    if law != "linear":
        assert np.abs(found).max() <= 1e-13 * scale
        assert force.jacobian == pytest.approx(1.0, abs=1e-13)


@pytest.mark.parametrize("law", LAWS)
def test_patch_of_distorted_cells_carries_a_uniform_strain(law):
    """A linear field: the stress of the law everywhere, no hourglass energy, balance at inner nodes."""
    mesh = distorted((3, 3, 3), inner_only=True)
    body = body_of(mesh, law)
    slope = 0.2 * np.random.default_rng(6).uniform(-1, 1, (3, 3))
    force, u = Force(body), mesh.nodes @ slope.T
    found = force(u)
    scale = np.abs(found).max()
    inner = np.all((mesh.nodes > 1e-9) & (mesh.nodes < np.array(SIZE) - 1e-9), axis=1)
    assert inner.sum() == 8
    assert np.abs(found[inner]).max() <= 1e-13 * scale
    there = twin(body).law
    assert force.energy == pytest.approx(np.prod(SIZE) * there.energy_density(slope), rel=1e-13)
    assert force.hourglass <= 1e-28 * force.energy
    total = found[mesh.nodes_of("xmax")].sum(axis=0)  # traction of the uniform stress on a flat face
    assert total == pytest.approx(there.stress(slope)[:, 0] * SIZE[1] * SIZE[2], rel=1e-12)
    stress = VonMises(body)(u)
    exact = there.cauchy(slope)
    exact = np.sqrt(1.5 * np.sum((exact - np.trace(exact) / 3 * np.eye(3)) ** 2))
    assert stress == pytest.approx(np.full(27, exact), rel=1e-12)


@pytest.mark.parametrize("mode", range(4))
def test_hourglass_modes_are_resisted_with_the_documented_stiffness(mode):
    """A cube in one mode, no mean strain: f = 8 kappa u, kappa = 0.05 (lam + 2 mu) (b:b)/(8 V) with b:b = 1.5 h^4."""
    h = 0.3
    mesh = tc.box_mesh((h,) * 3, (1, 1, 1))
    body = body_of(mesh)
    signs = np.prod(2.0 * (mesh.nodes / h)[:, [(0, 1), (0, 2), (1, 2), (0, 1, 2)][mode]] - 1.0, axis=1)
    way = np.array([0.3, -0.5, 0.8])
    u = 1e-3 * np.outer(signs, way)
    kappa = 0.05 * (body.material.lame_lambda + 2 * body.material.lame_mu) * 1.5 * h / 8
    force = Force(body)
    assert force(u) == pytest.approx(8 * kappa * u, rel=1e-10, abs=1e-12 * kappa)
    assert force.hourglass == pytest.approx(32 * kappa * 1e-6 * (way @ way), rel=1e-12)
    assert force.energy == pytest.approx(force.hourglass, rel=1e-10)


def test_hourglass_energy_is_objective():
    """A large rotation on top of a large deformation: same energies, turned forces."""
    body = body_of(distorted())
    force, u, turn = Force(body), moved(body.mesh, 0.3), meshes.rotation(9)
    before = force(u)
    energies = force.energy, force.hourglass
    after = force((body.mesh.nodes + u) @ turn.T - body.mesh.nodes)
    assert (force.energy, force.hourglass) == pytest.approx(energies, rel=1e-12)
    assert np.abs(after - before @ turn.T).max() <= 1e-12 * np.abs(before).max()
    assert energies[1] > 0.01 * energies[0]


def test_worst_cell_is_judged_by_the_mean_gradient():
    """An hourglass pattern turns corners inside out but keeps the volume; squeezing the cell does not."""
    mesh = tc.box_mesh((2.0, 1.0, 1.0), (2, 1, 1))
    u = np.zeros_like(mesh.nodes)
    u[mesh.cells[0]] = 1.2 * np.outer(HOURGLASS_MODES[0], (1.0, 0, 0))
    full, reduced = (tc.Body(mesh, material(), formulation=name) for name in ("full", "reduced"))
    assert worst_cell_of(full, u)[1] < 0.0 < worst_cell_of(reduced, u)[1]
    u = np.zeros_like(mesh.nodes)
    u[:, 0] = -1.1 * np.maximum(mesh.nodes[:, 0] - 1.0, 0.0)
    assert worst_cell_of(reduced, u) == (1, pytest.approx(-0.1))


@pytest.mark.parametrize(("kind", "formulation"), [("tet4", "reduced"), ("hex8", "Reduced"), ("hex8", "mean")])
def test_formulations_that_make_no_sense_are_refused(kind, formulation):
    with pytest.raises(tc.InputError, match=r"Body\.formulation"):
        tc.Body(tc.box_mesh((1, 1, 1), (2, 2, 2), kind), material(), formulation=formulation)
