"""The stable step with viscous contact cells is that of the body at every angle at which its contact leans."""

from types import SimpleNamespace

import numpy as np
import pytest
from conftest import THREADS
from scenes import material, simulate, stable_steps, state_of, wall
from test_cell_viscosity import limit

import tcontact as tc
from tcontact.mesh.rotation import rotation_matrix
from tcontact.schemes.explicit.damped_step import limit_of
from tcontact.schemes.explicit.lanczos_matrix import top_mode
from tcontact.schemes.explicit.stable_step import SAFETY, least

BETA = 1.0
ANGLES = [0.0, 5.0, 18.8014, 22.8, 30.0, 45.0]


def leaning(angle):
    """Return a block that is held from behind over a plane with friction, both turned by an angle in degrees."""
    turn = rotation_matrix(((0.3, 1.0, 0.2), np.radians(angle)))
    mesh = tc.box_mesh((0.2, 0.15, 0.1), (3, 2, 2)).rotated(turn)
    body = tc.Body(mesh, material("linear"), contact="zmin", supports=[tc.Support("zmax", "xyz")])
    contact = tc.MasslessContact("normal", cell_viscosity=BETA)
    return tc.Scene([body], [wall(mesh, turn[:, 2], 0.001)], 1e-3, contact=contact, friction=tc.Coulomb(0.4))


@pytest.mark.parametrize("angle", ANGLES)
def test_the_step_is_that_of_the_dense_eigenvalue_at_every_angle(angle):
    """The step of the third search begins with the momenta of those before; once these grew on massless normals until
    the step was two thirds too long, negative or no number at all. Held nodes make the true step longer."""
    share, _ = limit(leaning(angle), BETA, searches=3)
    assert share == pytest.approx(SAFETY, rel=1e-3)


@pytest.mark.parametrize("angle", ANGLES)
def test_momenta_that_move_nothing_are_no_part_of_a_mode(angle):
    """The mode of unit energy has momenta of the size of root mass, and none that M^-1 does not see."""
    scene = leaning(angle)
    planned = tc.plan(scene).bodies[0]
    state = state_of(scene, planned)
    search = stable_steps(planned, state.internal_force, scene.obstacles, None, state.serial.viscous_force)
    for _ in range(3):
        search.estimate(np.zeros(3 * planned.node_count))
    mode = search.bodies[0].damping.start.reshape(-1, 3)
    energy = (mode.reshape(-1) * search.bodies[0].damping._moved(mode.reshape(-1))).sum()
    assert energy == pytest.approx(1.0, rel=1e-6)
    assert np.abs(mode).max() <= np.sqrt(np.abs(planned.tensors).max())
    normal = scene.obstacles[0].normal_at(np.zeros((1, 3)))[0]
    assert np.abs(mode[planned.contact.nodes] @ normal).max() <= 1e-12 * np.abs(mode).max()
    assert np.abs(mode[planned.boundary[planned.support_rows]]).max() == 0.0


def test_a_block_on_a_leaning_ramp_runs_to_its_end():
    """Once the search of the ramp ended in numpy at other angles, and at this one with a step below 0."""
    turn = ((0.0, 1.0, 0.0), np.radians(30.0))
    block, ramp = tc.box_mesh((0.1, 0.1, 0.04), (4, 4, 2)), tc.box_mesh((0.3, 0.2, 0.04), (12, 8, 2))
    soft, hard = (tc.NeoHookean(young, 0.3, 1000.0) for young in (2e5, 1e7))
    upper = tc.Body(block.rotated(turn), soft, contact="zmin", name="block")
    mesh = ramp.translated((-0.05, -0.05, -0.04)).rotated(turn)
    lower = tc.Body(mesh, hard, contact="zmax", supports=[tc.Support("zmin", "xyz")], name="ramp")
    scene = tc.Scene([lower, upper], duration=4e-3, gravity=(0, 0, -9.81), friction=tc.Coulomb(0.4))
    result = simulate(scene, threads=THREADS)
    assert result.dt_limit == pytest.approx(1.664e-4, rel=2e-3)  # of the ramp lying flat
    assert np.diff(result.history["time"]).min() > 0.0


def test_a_mode_without_stiffness_leaves_the_step():
    """Where neither k nor c is above 0, no step is a limit of the mode."""
    assert limit_of(4.0, 0.0, 7.0) == 1.0
    assert limit_of(0.0, 2.0, 7.0) == 1.0
    assert limit_of(-3.0, 0.0, 7.0) == 7.0
    assert limit_of(-3.0, -1.0, 7.0) == 7.0


@pytest.mark.parametrize("step", [-2e-3, 0.0, np.nan])
def test_what_is_no_step_is_refused_with_the_body(step):
    """A step that would not let time go forward ends the run, whatever search has found it."""
    body = tc.Body(tc.box_mesh((1.0, 1.0, 1.0), (1, 1, 1)), material("linear"))
    found = SimpleNamespace(elastic=1e-3, damped=step, plan=SimpleNamespace(label="ramp", body=body))
    with pytest.raises(tc.InputError, match=r"material of ramp = .*no stable step is found"):
        least([found], 0.0)
    assert least([SimpleNamespace(elastic=1e-3, damped=5e-4)], 0.0) == pytest.approx(5e-4)


def test_a_lanczos_matrix_of_no_numbers_is_refused_with_the_body():
    """NumPy would end the run with an error of its own."""
    body = tc.Body(tc.box_mesh((1.0, 1.0, 1.0), (1, 1, 1)), material("linear"))
    with pytest.raises(tc.InputError, match=r"material of ramp = .*forces overflow"):
        top_mode([1.0, np.nan], [1.0, 1.0], SimpleNamespace(label="ramp", body=body))
