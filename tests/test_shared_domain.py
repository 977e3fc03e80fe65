"""Bodies that step together keep what is theirs alone: solver settings, limits of their law, layers, troubles."""

from types import SimpleNamespace

import numpy as np
import pytest

import tcontact as tc
from tcontact.contact.layered_friction import LayeredFriction
from tcontact.device import arrays
from tcontact.planning.packing import MAXIMUM_BOUNDARY, pack_cells

PLANE = tc.Plane()


def cube(x=0.0, cells=2, poisson=0.3, law=tc.NeoHookean, **options):
    """Return a body of 0.1 m above the plane z = 0."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (cells,) * 3, origin=(x, 0.0, 0.0))
    return tc.Body(mesh, law(young=1e6, poisson=poisson, density=1000.0), **options)


def held(**options):
    """Return a body whose contact nodes are all supported."""
    return cube(contact="zmin", supports=[tc.Support("zmin", "xyz")], **options)


def falling(x=1.0, speed=1.0, **options):
    return cube(x, contact="zmin", velocity=(0.0, 0.0, -speed), **options)


def test_a_plan_is_described_whose_first_body_has_no_contact():
    scene = tc.Scene([cube(), falling(poisson=0.49)], [PLANE], 1e-4, contact=tc.MasslessContact("full"))
    assert "static solve by" in tc.plan(scene).describe()
    assert tc.simulate(scene).ok


@pytest.mark.filterwarnings("ignore::tcontact.LockingWarning")
def test_a_body_with_all_contact_nodes_held_does_not_choose_the_solver_of_others():
    soft = falling(cells=4, poisson=0.48)
    results = [
        tc.simulate(tc.Scene(bodies, [PLANE], 1e-3, contact=tc.MasslessContact("full")), tc.CentralDifference(dt=2e-5))
        for bodies in ([held(), soft], [soft])
    ]
    assert all(result.ok for result in results)
    count = soft.mesh.node_count
    both, alone = (result.position[-count:] - soft.mesh.nodes for result in results)
    assert np.abs(both - alone).max() <= 1e-12 * np.abs(alone).max()


def test_projected_gradients_leave_alone_a_body_that_is_held_while_another_slides():
    slides = cube(1.0, 3, contact="zmin", velocity=(1.0, 0.0, -1.0))
    model = tc.MasslessContact("normal", solver="projected-gradient")
    result = tc.simulate(tc.Scene([held(), slides], [PLANE], 1e-3, contact=model, friction=tc.Coulomb(0.3)))
    assert result.ok
    assert result.history["friction_work"][-1] > 0.0


@pytest.mark.parametrize("scheme", [tc.CentralDifference(), tc.DiscreteGradient(dt=1e-4)])
def test_a_linear_body_beside_a_nonlinear_one_may_turn_inside_out(scheme):
    clamps = [tc.Support("zmin", "xyz"), tc.Support("zmax", "xyz", velocity=(0.0, 0.0, -100.0))]
    crushed = cube(law=tc.LinearElastic, supports=clamps)
    result = tc.simulate(tc.Scene([crushed, cube(1.0)], [], 1.5e-3, contact=None), scheme)
    assert result.ok


def test_a_nonlinear_body_that_is_crushed_stops_the_run_beside_a_linear_one():
    clamps = [tc.Support("zmin", "xyz"), tc.Support("zmax", "xyz", velocity=(0.0, 0.0, -100.0))]
    result = tc.simulate(tc.Scene([cube(1.0, law=tc.LinearElastic), cube(supports=clamps)], [], 1.5e-3, contact=None))
    assert result.reason == "inverted-cell"
    assert "body-1" in result.message


@pytest.mark.filterwarnings("ignore::tcontact.LockingWarning")
def test_the_body_whose_static_solve_fails_is_named():
    stiff = falling(cells=5, speed=100.0, poisson=0.49999)
    model = tc.MasslessContact("full", solver="gauss-seidel", tolerance=1e-12)
    result = tc.simulate(tc.Scene([falling(0.0), stiff], [PLANE], 2e-3, contact=model))
    assert result.reason == "not-converged"
    assert "body-1" in result.message


def test_layers_of_one_body_do_not_hide_that_another_starts_to_slide():
    bodies = [cube() for _ in range(3)]
    scene = SimpleNamespace(friction=tc.FrictionLayer(), bodies=bodies, obstacles=[PLANE], body_pairs=())
    scene.pairs_at = [()] * 3
    contact = SimpleNamespace(areas=np.full(5, 1e-4))
    domain = SimpleNamespace(contact=contact, contact_start=np.array([0, 2, 2, 5]), numbers=(0, 1, 2), pairs=())
    domain.records_friction = False
    layers = LayeredFriction(scene, domain, False)
    data = arrays.get(layers.data).copy()
    rows = data[layers.names.FIRST :].reshape(-1, layers.names.NODE)
    rows[:, layers.names.WORK] = [1.0, 0.0, 0.0, 1e-9, 0.0]  # [J]; the second body has no contact nodes
    rows[:, layers.names.SPEED] = 1.0
    arrays.set_values(layers.data, data)
    layers._note_onset(1e-6)
    assert layers._slid.tolist() == [True, False, False, True, False]


def test_boundary_nodes_beyond_the_bits_of_their_number_are_refused():
    count = MAXIMUM_BOUNDARY + 3
    cells = np.arange(count // 4 * 4).reshape(-1, 4)
    packs = pack_cells(cells, count // 4 * 4, 8)
    assert packs.with_boundary(np.arange(5))[4] >> 10 == 5
    with pytest.raises(tc.InputError, match="coarser"):
        packs.with_boundary(np.arange(MAXIMUM_BOUNDARY))
