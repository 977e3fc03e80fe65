"""The linear solvers of implicit schemes where BiCGStab cannot go on; what a run says of lost energy and of failure.

The matrices are made for it: BiCGStab breaks down in its first product, or has no preconditioner.
"""

import numpy as np
import pytest
from implicit_parts import body, cells_of, dense
from test_implicit_runs import RUBBER, STIFF, cube, energy_error, run, scene

import tcontact as tc
from tcontact.schemes.implicit.solution.linear_solver import Krylov
from tcontact.schemes.implicit.solution.newton import NotConverged, Settings, newton

X = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])


def off_diagonal(sparsity, row):
    """Place of a block beside the diagonal in a row of blocks, and its column."""
    places = range(sparsity.starts[row], sparsity.starts[row + 1])
    return next((place, sparsity.columns[place]) for place in places if sparsity.columns[place] != row)


def breaking_down():
    """BiCGStab divides by the product of the right side with its image, which is exactly 0."""
    sparsity = cells_of(body()).sparsity
    blocks = np.zeros((len(sparsity.columns), 3, 3))
    blocks[sparsity.diagonal] = np.eye(3)
    place, other = off_diagonal(sparsity, 0)
    blocks[place] = -2.0 * X
    right = np.zeros((len(sparsity.diagonal), 3))
    right[[0, other], 0] = 1.0
    return sparsity, blocks, right


def without_diagonal():
    """A diagonal block is 0, so that it has no inverse; the matrix has one."""
    sparsity, blocks, right = breaking_down()
    place, other = off_diagonal(sparsity, 0)
    back = next(p for p in range(sparsity.starts[other], sparsity.starts[other + 1]) if sparsity.columns[p] == 0)
    blocks[sparsity.diagonal[0]] = 0.0
    blocks[place] = blocks[back] = np.eye(3)
    blocks[sparsity.diagonal[other]] = 4.0 * np.eye(3)
    return sparsity, blocks, right


@pytest.mark.parametrize("made", [breaking_down, without_diagonal])
def test_factors_solve_what_stops_bicgstab(made):
    sparsity, blocks, right = made()
    solver = Krylov(sparsity)
    found = solver.solve(blocks, right, 1e-10)
    assert solver.spare is not None  # BiCGStab did not get there
    exact = np.linalg.solve(dense(blocks, sparsity), right.reshape(-1))
    assert np.abs(found.reshape(-1) - exact).max() < 1e-12 * np.abs(exact).max()


def test_what_an_iterate_far_from_the_solution_raises_is_a_failed_step():
    """A smaller step may have a solution, as after any other failure of Newton's method."""

    class Absurd:
        def evaluate(self, d):
            raise np.linalg.LinAlgError("SVD did not converge")

    with pytest.raises(NotConverged, match="SVD"):
        newton(Absurd(), np.zeros((1, 3)), None, Settings())


@pytest.mark.parametrize("iterations", [2, 3, 5])
def test_a_residual_of_rounding_is_a_solution_with_any_number_of_iterations(iterations):
    class Rounded:
        def evaluate(self, d):
            return np.where(d == 1.0, 3e-12, d - 1.0), 1.0

        def tangent(self, d):
            return np.eye(3)[None]

    class Divides:
        def solve(self, blocks, right, forcing):
            return np.where(np.abs(right) < 1e-6, 0.0, right)

    found = newton(Rounded(), np.zeros((1, 3)), Divides(), Settings(1e-12, iterations))
    assert (found.d == 1.0).all()
    assert found.residual == 3e-12


def test_few_iterations_are_named_where_a_step_has_no_solution():
    assert "or more than 4 iterations" in tc.Gonzalez(dt=1e-3, iterations=4).remedy
    assert "iterations" not in tc.Gonzalez(dt=1e-3).remedy


def test_a_slender_bar_under_a_load_ends_its_run():
    """Its steps are so long that BiCGStab stagnates; 1107 unknowns are solved by it unless asked otherwise."""
    mesh = tc.box_mesh((1.0, 0.02, 0.02), (40, 2, 2))
    bar = tc.Body(
        mesh,
        tc.NeoHookean(2.1e11, 0.3, 7800.0),
        supports=[tc.Support("xmin", "xyz")],
        loads=[tc.Load("xmax", force=(0.0, 0.0, -100.0))],
    )
    own = tc.Scene(bodies=[bar], gravity=(0.0, 0.0, -9.81), duration=0.01)
    ends = [run(own, tc.DiscreteGradient(dt=1e-3, solver=solver)) for solver in ("auto", "direct")]
    assert np.abs(ends[0].position - ends[1].position).max() < 1e-9 * np.abs(ends[1].position - mesh.nodes).max()
    assert max(end.history["energy_error"].max() for end in ends) < 1e-10


@pytest.mark.parametrize("options", [{}, {"reproject": False}, {"penalty": STIFF}])
def test_contact_that_takes_energy_is_named_before_and_after_the_run(options):
    """Exact contact, and nodes brought to equilibrium, lose energy, the less the smaller the step."""
    contact = tc.MasslessContact(penalty=options.get("penalty"))
    own = scene(cube(3, speed=3.0), tc.Plane(), contact, 5e-3)
    steps = (5e-4, 2.5e-4)
    schemes = [tc.DiscreteGradient(dt=dt, reproject=options.get("reproject")) for dt in steps]
    with pytest.warns(tc.EnergyWarning) as warned:
        ends = [tc.simulate(own, scheme=scheme) for scheme in schemes]
    text = str(warned[0].message)
    assert "takes energy" in text
    assert "MasslessContact(penalty=) and reproject=False" in text
    assert "rtol" not in text
    assert energy_error(ends[1]) < 0.5 * energy_error(ends[0])
    said = tc.plan(own).describe(schemes[0])
    assert "conserves linear momentum, angular momentum\n" in said
    assert "takes energy" in said


def test_contact_by_a_penalty_without_reprojection_is_said_to_keep_energy():
    own = scene(cube(2), tc.Plane(), tc.MasslessContact(penalty=STIFF), 1e-3)
    said = tc.plan(own).describe(tc.DiscreteGradient(dt=1e-4, reproject=False))
    assert "conserves energy, linear momentum, angular momentum" in said
    assert "takes energy" not in said


def test_a_step_without_a_solution_names_the_most_compressed_cell():
    """A block is crushed to nothing by a support; the remedy is not the scheme that it has."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2))
    pressed = [tc.Support("zmin", "xyz"), tc.Support("zmax", "xyz", velocity=(0.0, 0.0, -100.0))]
    own = tc.Scene(bodies=[tc.Body(mesh, RUBBER, supports=pressed)], duration=2e-3)
    end = tc.simulate(own, scheme=tc.DiscreteGradient(dt=2e-4))
    assert end.reason == "not-converged"
    assert "det F = " in end.message
    assert "use a smaller dt; where a load or support crushes the body" in end.message
    assert "gonzalez" not in end.message
