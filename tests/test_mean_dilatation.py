"""One volume change per hex: force against numpy, invariants, patches, locking, contact stiffness, bad input."""

from dataclasses import replace

import numpy as np
import oracle
import pytest
from contact_stiffness import contact_stiffness, spread_of
from one_point import SIZE, Force, body_of, check_turning, distorted, moved, twin
from oracle import meshes
from scenes import LAWS, block, stable_steps

import tcontact as tc
from tcontact.cells.stress import VonMises

SPLIT = [law for law in LAWS if law != "svk"]
MEAN = "mean-dilatation"


def sheared():
    box = tc.box_mesh(SIZE, (3, 2, 3))
    return tc.Mesh(box.nodes @ (np.eye(3) + 0.2 * np.eye(3, k=1)), box.cells, "hex8")


def mean_body(mesh, law="neo", **how):
    return body_of(mesh, law, MEAN, **how)


@pytest.mark.parametrize("law", SPLIT)
@pytest.mark.parametrize(
    "mesh", [distorted(), sheared(), tc.box_mesh(SIZE, (3, 2, 3))], ids=["shaken", "affine", "box"]
)
def test_force_and_energy_match_numpy_and_each_other(law, mesh):
    """Force = numpy's = the exact slope of the energy, near poisson 1/2 too."""
    for poisson in (0.27, 0.499):  # closer to 1/2 the oracle loses digits of Mooney-Rivlin's constants
        body = mean_body(mesh, law, poisson=poisson)
        there, force, u = twin(body), Force(body), moved(mesh, 0.2)
        found, exact = force(u), there.force(u)
        assert np.abs(found - exact).max() <= 1e-13 * np.abs(exact).max()
        assert force.energy == pytest.approx(there.energy(u), rel=1e-13)
        assert force.hourglass == 0.0
        gradients = oracle.cells.displacement_gradient(there.quad, u)
        assert force.jacobian == pytest.approx(1 + oracle.laws.volume_change(gradients).min(), rel=1e-13)
        way, step = np.random.default_rng(3).uniform(-1, 1, u.shape), 1e-6
        ends = []
        for sign in (1.0, -1.0):
            force(u + sign * step * way)
            ends.append(force.energy)
        assert (ends[0] - ends[1]) / (2 * step) == pytest.approx(np.sum(found * way), rel=1e-6)


@pytest.mark.parametrize("law", SPLIT)
def test_rigid_motion_gives_no_force(law):
    body = mean_body(distorted(), law, poisson=0.499)
    nodes, force = body.mesh.nodes, Force(body)
    scale = (body.material.lame_lambda + 2 * body.material.lame_mu) * 0.06**2
    assert not force(np.zeros_like(nodes) + np.array([1024.0, -512.0, 2048.0])).any()
    assert force.energy == 0.0
    if law != "linear":
        found = force(nodes @ meshes.rotation(5).T - nodes)
        assert np.abs(found).max() <= 1e-13 * scale
        assert abs(force.energy) <= 1e-13 * scale * 0.06
        check_turning(body, force, 0.3)


@pytest.mark.parametrize("law", SPLIT)
def test_patch_of_distorted_cells_carries_a_uniform_strain(law):
    """A linear field: what full integration has, force and energy, and balance at inner nodes."""
    mesh = distorted((3, 3, 3), inner_only=True)
    body, full = mean_body(mesh, law), body_of(mesh, law, "full")
    slope = 0.2 * np.random.default_rng(6).uniform(-1, 1, (3, 3))
    u = mesh.nodes @ slope.T
    mean, usual = Force(body), Force(full)
    found, wanted = mean(u), usual(u)
    assert np.abs(found - wanted).max() <= 1e-13 * np.abs(wanted).max()
    assert mean.energy == pytest.approx(usual.energy, rel=1e-13)
    inner = np.all((mesh.nodes > 1e-9) & (mesh.nodes < np.array(SIZE) - 1e-9), axis=1)
    assert np.abs(found[inner]).max() <= 1e-13 * np.abs(found).max()
    exact = twin(body).law.cauchy(slope)
    exact = np.sqrt(1.5 * np.sum((exact - np.trace(exact) / 3 * np.eye(3)) ** 2))
    assert VonMises(body)(u) == pytest.approx(np.full(27, exact), rel=1e-12)


def test_tiny_strain_keeps_its_digits():
    """At strain 1e-9 and poisson 0.499 neo-Hookean is linear elasticity to 1e-8."""
    mesh = distorted()
    u = 1e-9 * moved(mesh, 1.0)
    linear, force = (Force(mean_body(mesh, law, poisson=0.499)) for law in ("linear", "neo"))
    wanted = linear(u)
    assert np.abs(force(u) - wanted).max() <= 1e-8 * np.abs(wanted).max()
    assert force.energy == pytest.approx(linear.energy, rel=1e-8)


def stiffness_of(body):
    """K [3n, 3n] at rest by the oracle, to which the force pass is compared elsewhere."""
    u = np.zeros_like(body.mesh.nodes)
    if body.formulation == MEAN:
        return twin(body).tangent(u)
    there = oracle.quadrature(np.array(body.mesh.nodes), np.array(body.mesh.cells), "hex8")
    law = oracle.LinearElastic(body.material.young, body.material.poisson)
    return oracle.tangent(there, law, u).toarray()


def tip_deflection(formulation, poisson, cells=2, length=6.0, young=1.0):
    """Return the tip deflection of a plane strain cantilever under a shear load, over that of Timoshenko."""
    mesh = tc.box_mesh((length, 1.0 / cells, 1.0), (round(length) * cells, 1, cells))
    body = tc.Body(mesh, tc.LinearElastic(young, poisson, 1.0), formulation=formulation)
    x, z = mesh.nodes[:, 0], mesh.nodes[:, 2]
    free = np.ones_like(mesh.nodes, dtype=bool)
    free[x < 1e-9] = False
    free[:, 1] = False
    load = np.zeros_like(mesh.nodes)
    tip = np.flatnonzero(x > length - 1e-9)
    load[tip, 2] = np.where((z[tip] < 1e-9) | (z[tip] > 1 - 1e-9), 0.5, 1.0) / cells / 2
    free = free.ravel()
    deflection = np.linalg.solve(stiffness_of(body)[np.ix_(free, free)], load.ravel()[free])
    depth, plane, shear = 1.0 / cells, young / (1 - poisson**2), young / (2 * (1 + poisson))
    exact = length**3 / (3 * plane * depth / 12) + length / (5 / 6 * shear * depth)
    return (load.ravel()[free] @ deflection) / exact


def test_bending_of_a_nearly_incompressible_cantilever_does_not_lock():
    """Plane strain, poisson 0.4999: full hexes lock by a factor, a mean dilatation stays what it is at 0.3."""
    usual = tip_deflection(MEAN, 0.3, 4)
    found = tip_deflection(MEAN, 0.4999, 4)
    assert 0.9 < found < 1.02
    assert abs(found - usual) <= 0.05
    assert tip_deflection("full", 0.4999, 4) < 0.6 * found
    assert tip_deflection("full", 0.3, 4) < usual


@pytest.mark.parametrize("law", [pytest.param(law, marks=pytest.mark.slow if law == "mooney" else ()) for law in SPLIT])
@pytest.mark.parametrize("removal", ["full", "normal"])
def test_contact_stiffness_is_the_slope_of_the_force_and_positive_definite(law, removal):
    """Against central differences of the force and against numpy; with a support: its component is not massless."""
    supports = [tc.Support("xmin", "x")] if removal == "full" and law == "neo" else []
    body = mean_body(distorted((3, 3, 2), 0.2, inner_only=True), law, poisson=0.45, contact="zmin", supports=supports)
    u = moved(body.mesh, 0.1)
    found, nodes, basis = contact_stiffness(body, removal, u)
    dofs, spread = spread_of(nodes, basis)
    slope = spread.T @ Force(replace(body, supports=())).stiffness(u, 1e-6 * 0.06, dofs)[dofs] @ spread
    assert np.abs(found - slope).max() <= 1e-7 * np.abs(slope).max()
    exact = spread.T @ twin(body).tangent(u)[np.ix_(dofs, dofs)] @ spread
    assert np.abs(found - exact).max() <= 1e-12 * np.abs(found).max()
    massless = np.linalg.norm(spread, axis=0) > 0
    rest = contact_stiffness(body, removal, np.zeros_like(u))[0][np.ix_(massless, massless)]
    assert np.linalg.eigvalsh(rest)[0] > 0.001 * np.abs(rest).max()


@pytest.mark.parametrize("removal", ["full", "normal"])
@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_contact_stiffness_of_mooney_rivlin(kind, removal):
    """The sum of two laws, with full integration."""
    body = body_of(block(kind, (2, 2, 3)), "mooney", "full", contact="zmin")
    u = moved(body.mesh, 0.1)
    found, nodes, basis = contact_stiffness(body, removal, u)
    dofs, spread = spread_of(nodes, basis)
    slope = spread.T @ Force(body).stiffness(u, 1e-6 * 0.06, dofs)[dofs] @ spread
    assert np.abs(found - slope).max() <= 1e-7 * np.abs(slope).max()


@pytest.mark.parametrize("poisson", [0.3, 0.499])
def test_stable_step_against_the_dense_eigenvalue(poisson):
    """90 to 100 % of 2/omega_max, and not shorter than full hexes have it."""
    body = mean_body(distorted((3, 3, 4), 0.2), poisson=poisson)
    mesh, force = body.mesh, Force(body)
    stretch = np.diag([1.1, 0.95, 0.75]) + np.array([[0, 0.2, 0], [0, 0, 0], [0.1, 0, 0]])
    for u in (np.zeros_like(mesh.nodes), mesh.nodes @ stretch.T - mesh.nodes):
        estimate = stable_steps(force.plan, force.term).estimate(u[force.plan.node_order].reshape(-1))
        there = twin(body)
        mass = oracle.assemble(
            there.quad.cells, oracle.lumped_cell_mass(there.quad, body.material.density), mesh.node_count
        )
        root = np.repeat(mass, 3) ** -0.5
        tangents = there.tangent(u), oracle.tangent(there.quad, there.law, u).toarray()
        limits = [2.0 / np.sqrt(np.linalg.eigvalsh(root[:, None] * tangent * root)[-1]) for tangent in tangents]
        assert 0.9 <= estimate / limits[0] <= 1.0
        assert limits[0] >= 0.999 * limits[1]


def test_a_plan_names_its_element():
    scene = tc.Scene([mean_body(distorted())], duration=1.0)
    text = tc.plan(scene).describe()
    assert "18 hex8-mean-dilatation cells" in text
    assert "(hex8-mean-dilatation, neo_hookean" in text
    assert tc.plan(tc.Scene([mean_body(tc.box_mesh((1, 1, 1), (2, 2, 2)))], duration=1.0)).bodies[0].variant == (
        "hex8-mean-dilatation-box"
    )


def test_formulations_that_make_no_sense_are_refused():
    with pytest.raises(tc.InputError, match=r"Body\.formulation.*tet4 cells have 'full', 'node-averaged' alone.*hex8"):
        mean_body(block("tet4", 2))
    with pytest.raises(tc.InputError, match=r"Body\.formulation.*StVenantKirchhoff.*NeoHookean"):
        mean_body(block("hex8", 2), "svk")
