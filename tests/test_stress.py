"""Von Mises stress of cells: the oracle's numbers, no stress from a rotation, only where frames hold it."""

from __future__ import annotations

import hashlib

import numpy as np
import oracle
import pytest
from one_point import distorted, moved
from one_point import twin as one_point
from oracle import meshes
from scenes import LAWS, block, material, python, thrown, twin

import tcontact as tc
from tcontact.cells.cell_stress import CellStress, pressure_of
from tcontact.cells.stress import VonMises
from tcontact.device import runtime
from tcontact.results.files.vtkhdf import ResultData
from tcontact.run import recorder


def mesh_of(kind):
    return distorted() if kind == "hex8" else block("tet4", (3, 2, 3))


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_every_law_has_the_stress_of_the_oracle(kind, law):
    mesh = mesh_of(kind)
    body, u = tc.Body(mesh, material(law)), moved(mesh)
    there = twin(body)
    exact = oracle.von_mises(there.nodes, there.cells, kind, there.law, u)
    np.testing.assert_allclose(VonMises(body)(u), exact, rtol=0, atol=1e-12 * exact.max())


@pytest.mark.parametrize("law", LAWS)
def test_one_point_hexes_have_that_of_the_mean_gradient(law):
    body = tc.Body(distorted(), material(law), formulation="reduced")
    u = moved(body.mesh)
    exact = one_point(body).von_mises(u)
    np.testing.assert_allclose(VonMises(body)(u), exact, rtol=0, atol=1e-12 * exact.max())
    full = VonMises(tc.Body(body.mesh, body.material))(u)
    assert np.abs(full - exact).max() > 1e-3 * exact.max()


@pytest.mark.parametrize("law", LAWS)
def test_tiny_stretches_keep_their_digits(law):
    """Uniaxial strain e: 2 mu e to first order, of any law; J - 1 and F - I have lost it in rounding."""
    mesh, mat, e = mesh_of("hex8"), material(law), 1e-10
    u = mesh.nodes * (0.0, 0.0, e)
    np.testing.assert_allclose(VonMises(tc.Body(mesh, mat))(u), 2.0 * mat.lame_mu * e, rtol=1e-9)


@pytest.mark.parametrize("law", [law for law in LAWS if law != "linear"])
def test_a_rotation_makes_no_stress_and_turns_none(law):
    mesh = mesh_of("hex8")
    of, turn, u = VonMises(tc.Body(mesh, material(law))), meshes.rotation(5), moved(mesh_of("hex8"))
    before = of(u).copy()
    after = of((mesh.nodes + u) @ turn.T - mesh.nodes)
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-12 * before.max())
    assert of(mesh.nodes @ turn.T - mesh.nodes).max() < 1e-14 * material(law).young


@pytest.mark.parametrize("law", ["neo", "linear"])
def test_cells_with_a_volume_change_of_their_own_have_its_pressure(law):
    """p less that of a fully integrated cell = lambda (J - 1 there less the mean over the cell, or over its nodes)."""
    for kind, formulation in (("hex8", "mean-dilatation"), ("tet4", "node-averaged")):
        mesh, mat = tc.box_mesh((1.0, 0.8, 0.6), (2, 2, 2), kind), material(law)
        u = 0.01 * np.random.default_rng(3).standard_normal((2, *mesh.nodes.shape))
        bodies = [tc.Body(mesh, mat, formulation=name) for name in ("full", formulation)]
        full, own = (CellStress(body, 2)(u) for body in bodies)
        for row in range(2):
            corners, moved = mesh.nodes[mesh.cells], u[row][mesh.cells]
            sides = np.array([x - x.mean(axis=0) for x in corners])
            slopes = np.array([np.linalg.lstsq(x, y, rcond=None)[0].T for x, y in zip(sides, moved, strict=True)])
            volumes = mesh.cell_volumes()
            if law == "linear":
                here = np.trace(slopes, axis1=1, axis2=2)
                mean = here
            else:
                here = np.linalg.det(np.eye(3) + slopes) - 1.0
                mean = tc.Mesh(mesh.nodes + u[row], mesh.cells, kind).cell_volumes() / volumes - 1.0
            if kind == "tet4":
                total, change = np.zeros(mesh.node_count), np.zeros(mesh.node_count)
                np.add.at(total, mesh.cells, np.repeat(volumes[:, None], 4, axis=1))
                np.add.at(change, mesh.cells, np.repeat((volumes * here)[:, None], 4, axis=1))
                mean = (change / total)[mesh.cells].mean(axis=1)
            expected = mat.lame_lambda * (here - mean)
            found = pressure_of(own[row]) - pressure_of(full[row])
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * mat.lame_lambda)
            assert np.array_equal(own[row, :, 6], VonMises(bodies[1])(u[row]))
        if law != "linear" or kind == "tet4":
            assert np.abs(pressure_of(own) - pressure_of(full)).max() > 1e-5 * mat.lame_lambda


def digest():
    """Hash of the stress of a body with enough packs of cells for two threads."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (21, 21, 21))
    u = 0.01 * np.sin(40.0 * mesh.nodes @ np.array([[3, 1, 2], [1, 2, 3], [2, 2, 1]]))
    return hashlib.sha256(VonMises(tc.Body(mesh, material()))(u).tobytes()).hexdigest()


def test_one_and_two_threads_give_the_same_bits():
    assert runtime.threads() == 2
    done = python(
        "from tcontact.device import runtime; runtime.start('cpu', 1); import test_stress; print(test_stress.digest())"
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.split() == [digest()]


@pytest.mark.parametrize("how", [{}, {"frames": 0}, {"frames": 3, "fields": ["displacement"]}])
def test_nothing_is_compiled_or_computed_for_frames_without_it(how, monkeypatch, tmp_path):

    def refuse(*_):
        raise AssertionError("nobody wants it")

    monkeypatch.setattr(recorder, "VonMises", refuse)
    scene = thrown(contact=tc.MasslessContact(), duration=0.2)
    assert tc.simulate(scene, out=tmp_path / "run", **how).ok
    assert ResultData.open(tmp_path / "run" / "result.vtkhdf").cell_fields == ()
    with pytest.raises(AssertionError, match="nobody"):
        tc.simulate(scene, out=tmp_path / "other", frames=2, fields=["von_mises"])


def test_a_law_without_kernels_is_named():
    class Cork(tc.NeoHookean):
        law = "cork"

    body = tc.Body(mesh_of("tet4"), Cork(1e7, 0.3, 1000.0))
    with pytest.raises(tc.InputError, match=r"law = 'cork': .*neo_hookean"):
        VonMises(body)
