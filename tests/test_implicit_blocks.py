"""Implicit schemes on bodies of several kinds of cells and materials: tangents, invariants, impacts."""

import numpy as np
import pytest
from mixed_meshes import OTHERS, STEEL, beside, corner, halves, shaken
from oracle import meshes

import tcontact as tc
from tcontact import checks as ck
from tcontact.schemes.implicit.solution.several_cells import SeveralCells, cells_of


def body_of(mesh, other="stiff", **options):
    """A body whose halves along y are of two materials."""
    return tc.Body(halves(mesh), {"low": STEEL, "high": OTHERS[other]}, **options)


def dense(cells, blocks):
    """The matrix [3n, 3n] of blocks in the sparsity of cells."""
    count = len(cells.sparsity.diagonal)
    result = np.zeros((count, 3, count, 3))
    result[cells.sparsity.rows, :, cells.sparsity.columns, :] = blocks
    return result.reshape(3 * count, 3 * count)


@pytest.mark.parametrize(("other", "formulation"), [("linear", "full"), ("stiff", "reduced")])
def test_the_tangent_is_the_derivative_of_the_force(other, formulation):
    body = body_of(shaken(beside((2, 2, 2))), other, formulation=formulation)
    cells = cells_of([(block, block.cells) for block in body.blocks], np.array(body.mesh.nodes))
    assert isinstance(cells, SeveralCells)
    n = body.mesh.node_count
    rng = np.random.default_rng(2)
    u, h = 0.05 * body.mesh.shortest_edge * rng.normal(size=(n, 3)), 1e-6 * body.mesh.shortest_edge

    def force(there):
        cells.evaluate("end", there, np.zeros_like(there))
        return cells.force(1.0)

    cells.evaluate("end", u, np.zeros_like(u), True)
    tangent = dense(cells, cells.tangent_blocks(1.0, 1.0))
    for _ in range(3):
        way = rng.normal(size=(n, 3))
        wanted = (force(u + h * way) - force(u - h * way)) / (2.0 * h)
        assert np.abs((tangent @ way.reshape(-1)).reshape(-1, 3) - wanted).max() <= 1e-6 * np.abs(wanted).max()


def test_free_flight_keeps_energy_and_momenta():
    mesh = corner((2, 2, 2))
    arm = mesh.nodes - mesh.nodes.mean(axis=0)
    spin = np.cross((30.0, -20.0, 10.0), arm)
    body = body_of(mesh, velocity=spin @ meshes.rotation(3).T + (1.0, 2.0, 3.0))
    result = tc.simulate(tc.Scene([body], [], 2e-3, contact=None), tc.Gonzalez(dt=1e-4))
    assert result.ok
    assert ck.energy(result, 1e-8).passed
    assert ck.momentum_balance(result, 1e-10).passed
    angular = result.history["angular_momentum"]
    assert np.abs(angular - angular[0]).max() <= 1e-8 * np.abs(angular).max()
    assert "neo_hookean" in tc.plan(result.scene).describe(tc.Gonzalez(dt=1e-4))


@pytest.mark.parametrize("removal", ["normal", "full"])
def test_an_impact_is_that_of_the_explicit_scheme(removal):
    body = body_of(beside((2, 2, 2)), velocity=(0.2, 0.0, -1.0), contact="zmin")
    scene = tc.Scene([body], [tc.Plane((0.0, 0.0, -1e-5))], 6e-4, contact=tc.MasslessContact(removal))
    explicit = tc.simulate(scene, tc.CentralDifference(dt=1e-6))
    implicit = tc.simulate(scene, tc.DiscreteGradient(dt=4e-6))
    assert implicit.ok
    assert ck.momentum_balance(implicit, 1e-9).passed
    assert ck.energy(implicit, 1e-2).passed
    impulses = [result.history["impulse"][-1, 2] for result in (explicit, implicit)]
    assert impulses[0] > 0.0
    assert impulses[1] == pytest.approx(impulses[0], rel=0.02)


def test_the_consistent_mass_refuses_several_blocks_by_name(tmp_path):
    for body in (tc.Body(beside((2, 2, 2)), STEEL), body_of(tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2)))):
        scene = tc.Scene([body], [], 1e-3, contact=None)
        with pytest.raises(tc.InputError, match=r"mass.*lumped"):
            tc.simulate(scene, tc.Gonzalez(dt=1e-4, mass="consistent"), out=tmp_path / "run", frames=2)
    assert not (tmp_path / "run").exists()
