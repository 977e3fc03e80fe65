"""One-point hexes: stiffness of the contact nodes, bending, stable step."""

import numpy as np
import oracle
import pytest
from contact_stiffness import contact_stiffness, spread_of
from one_point import Force, body_of, distorted, moved, twin
from oracle import meshes
from scenes import LAWS, stable_steps

import tcontact as tc


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("removal", ["full", "normal"])
def test_contact_stiffness_is_the_slope_of_the_force_and_positive_definite(law, removal):
    """Against central differences of the force; without the hourglass part it would be singular."""
    body = body_of(distorted((3, 3, 2), 0.2, inner_only=True), law, contact="zmin")
    u = moved(body.mesh, 0.1)
    found, nodes, basis = contact_stiffness(body, removal, u)
    dofs, spread = spread_of(nodes, basis)
    slope = spread.T @ Force(body).stiffness(u, 1e-6 * 0.06, dofs)[dofs] @ spread
    assert np.abs(found - slope).max() <= 1e-7 * np.abs(slope).max()
    assert np.abs(found - found.T).max() <= 1e-12 * np.abs(found).max()
    there = twin(body)
    exact = there.tangent(u)[np.ix_(dofs, dofs)]
    assert np.abs(found - spread.T @ exact @ spread).max() <= 1e-12 * np.abs(found).max()
    values = np.linalg.eigvalsh(found)
    assert values[0] > 0.005 * values[-1]
    there.kappa[:] = 0.0
    bare = np.linalg.eigvalsh(spread.T @ there.tangent(np.zeros_like(u))[np.ix_(dofs, dofs)] @ spread)
    assert bare[0] < 1e-3 * bare[-1]


def tip_stiffness(formulation, cells=2, length=8.0):
    """Tip force over tip deflection of a cantilever of unit thickness, by the stiffness of the force pass."""
    mesh = tc.box_mesh((length, 1.0, 1.0), (round(length) * cells, cells, cells))
    body = tc.Body(mesh, tc.LinearElastic(1.0, 0.3, 1.0), formulation=formulation)
    free = np.flatnonzero(np.repeat(mesh.nodes[:, 0] > 1e-9, 3))
    stiffness = Force(body).stiffness(np.zeros_like(mesh.nodes), 1e-3, free)[free]
    share = np.zeros(mesh.node_count)
    tip = mesh.nodes_of("xmax")
    sides = np.sum(np.isin(mesh.nodes[tip][:, 1:], (0.0, 1.0)), axis=1)
    share[tip] = 0.5**sides / cells**2
    load = np.zeros_like(mesh.nodes)
    load[:, 2] = share
    deflection = np.linalg.solve(stiffness, load.ravel()[free])
    return 1.0 / (load.ravel()[free] @ deflection)


def test_bending_of_a_cantilever_of_two_cells_in_thickness():
    """Timoshenko's beam, k = 5/6: one-point hexes are within a tenth, full ones lock by more."""
    exact = 1.0 / (8.0**3 / 3 * 12 + 8.0 / (5 / 6) * 2.6)
    reduced, full = tip_stiffness("reduced") / exact - 1.0, tip_stiffness("full") / exact - 1.0
    assert abs(reduced) <= 0.1
    assert full > 0.12


STEPS = {
    "shaken": lambda: distorted((3, 3, 4), 0.2),
    "even": lambda: tc.box_mesh((1, 1, 1), (3, 3, 3)),
    "thin": lambda: tc.box_mesh((1.0, 0.05, 0.4), (3, 3, 3)),
    "needle": lambda: tc.box_mesh((0.1, 0.1, 3.0), (1, 1, 12)),
    "one cell": lambda: distorted((1, 1, 1), 0.2),
}


@pytest.mark.parametrize("shape", STEPS)
@pytest.mark.parametrize("deformed", [False, True])
def test_stable_step_against_the_dense_eigenvalue(shape, deformed):
    """90 to 100 % of 2/omega_max, and nowhere shorter than full hexes have it."""
    body = body_of(STEPS[shape]())
    mesh, force = body.mesh, Force(body)
    stretch = np.diag([1.1, 0.95, 0.75]) + np.array([[0, 0.2, 0], [0, 0, 0], [0.1, 0, 0]])
    u = mesh.nodes @ (meshes.rotation(1) @ stretch).T - mesh.nodes if deformed else np.zeros_like(mesh.nodes)
    estimate = stable_steps(force.plan, force.term).estimate(u[force.plan.node_order].reshape(-1))
    there = twin(body)
    quad = oracle.quadrature(np.array(mesh.nodes), np.array(mesh.cells), "hex8")
    mass = oracle.assemble(quad.cells, oracle.lumped_cell_mass(quad, body.material.density), mesh.node_count)
    root = np.repeat(mass, 3) ** -0.5
    limits = [
        2.0 / np.sqrt(np.linalg.eigvalsh(root[:, None] * tangent * root)[-1])
        for tangent in (there.tangent(u), oracle.tangent(quad, there.law, u).toarray())
    ]
    assert 0.9 <= estimate / limits[0] <= 1.0
    assert limits[0] >= 0.999 * limits[1]
