"""Laws with state: the step pass alone commits, checkpoints carry the state, other laws have not a byte of it."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest
from scenes import block, state_of
from test_resume import split

import tcontact as tc
from tcontact.cells.stress import VonMises
from tcontact.device import arrays, runtime
from tcontact.kernels.elements import FUNCTIONS
from tcontact.planning.packing import WIDTH


@dataclass(frozen=True)
class Hardening(tc.NeoHookean):
    """Neo-Hookean with mu (1 + largest energy density so far/mu): path dependent, so a wrong commit changes the run."""

    law: ClassVar[str] = "test_hardening"
    word: ClassVar[str] = "test-hardening"


@pytest.fixture(scope="module", autouse=True)
def _only_here():
    """Take the law out of the table behind the tests of this file: other tests go over all laws."""
    from tcontact.kernels.materials import LAWS

    before = {*LAWS}
    yield
    LAWS.pop("test_hardening", None)
    assert {*LAWS} == before


@pytest.fixture(autouse=True)
def _law():
    """Register the law; a point keeps how often it was committed and its largest energy density over mu."""
    runtime.start("cpu")
    import taichi as ti

    from tcontact.kernels.materials import LAWS, neo_hookean

    if "test_hardening" in LAWS:
        return

    @ti.func
    def update(h, parameters, old):
        mu = parameters[1] * (1.0 + old[1])
        answer = neo_hookean.update(h, [parameters[0], mu])
        return [answer[0], answer[1], answer[2], [old[0] + 1.0, ti.max(old[1], answer[1] / parameters[1])]]

    @ti.func
    def point(f, parameters, pressure, old):
        return neo_hookean.tangent(f, [parameters[0], parameters[1] * (1.0 + old[1])], pressure)

    tangents = (neo_hookean.LAW.tangents[0]._replace(point=point),)
    LAWS["test_hardening"] = neo_hookean.LAW._replace(update=update, tangents=tangents, state=("commits", "most"))


def falling(kind="hex8", cells=2, formulation="full", removal="normal", duration=4e-3, speed=4.0):
    """A soft block that hits a wall with massless nodes."""
    mesh = block(kind, cells, size=(0.1, 0.1, 0.1), shift=(0.0, 0.0, 1e-4))
    body = tc.Body(mesh, Hardening(1e6, 0.3, 1000.0), (0.0, 0.0, -speed), contact="zmin", formulation=formulation)
    return tc.Scene([body], [tc.Plane()], duration, contact=tc.MasslessContact(removal=removal))


def without_state(scene):
    """Return the scene with neo-Hookean, the law before any hardening."""
    return replace(scene, bodies=[replace(body, material=tc.NeoHookean(1e6, 0.3, 1000.0)) for body in scene.bodies])


def numbers_of(state):
    """Return the numbers that the points keep [cells, points, 2]."""
    points = FUNCTIONS[state.views[0].plan.element].points
    kept = np.array(arrays.get(state.internal_force.memory)).reshape(-1, points, 2, WIDTH)
    return kept.transpose(0, 3, 1, 2).reshape(-1, points, 2)[: len(state.views[0].plan.cells)]


CASES = [
    ("hex8", "full", 2),
    ("tet4", "full", 2),
    ("hex8", "reduced", 3),
    ("hex8", "mean-dilatation", 2),
    ("wedge6", "full", 2),
]


@pytest.mark.parametrize(
    ("kind", "formulation", "cells", "path"),
    [(*case, "serial") for case in CASES]
    + [pytest.param(*case, "parallel", marks=[pytest.mark.slow] * (case not in CASES[:2])) for case in CASES],
)
def test_only_the_step_pass_commits(kind, formulation, cells, path, request):
    if path == "parallel":
        request.getfixturevalue("parallel_path")
    scene = falling(kind, cells, formulation)
    plan = tc.plan(scene).bodies[0]
    start = np.array(scene.bodies[0].mesh.nodes) * np.array([0.0, 0.0, -0.05])
    state = state_of(scene, plan, start)
    assert not numbers_of(state).any()
    state.begin_contact(1e-6)  # measures and solves
    out = arrays.zeros(start.size)
    state.internal_force.without_boundary().minus_force(state.u, out)  # a Lanczos product
    assert np.abs(arrays.get(out)).max() > 0.0
    assert not numbers_of(state).any()
    for step in range(3):
        rows = state.advance(5e-7, 5e-7, 1e-6, step * 1e-6, (1e-6, 1e-6))
        assert rows == 1
    kept = numbers_of(state)
    assert (kept[:, :, 0] == 3.0).all()  # of every cell and point, the massless ones of the contact too
    assert (kept[:, :, 1] > 0.0).all()


def test_several_rows_a_launch_commit_once_each_and_stiffen_the_impact():
    scene = falling("tet4", duration=3e-3)
    hard = tc.simulate(scene)
    soft = tc.simulate(without_state(scene))
    assert hard.reason == soft.reason == "finished"
    assert hard.history["static_residual"].max() <= 1e-4
    assert hard.history["contact_force"][:, 2].max() > 1.001 * soft.history["contact_force"][:, 2].max()


@pytest.mark.parametrize("path", ["serial", "parallel"])
def test_a_checkpoint_carries_the_state_and_resume_has_the_same_bits(tmp_path, path, request, monkeypatch):
    if path == "parallel":
        request.getfixturevalue("parallel_path")
    scheme = tc.CentralDifference(cfl=0.05)
    whole = split(monkeypatch, tmp_path, falling("tet4", duration=1.5e-3), 2, scheme, fields=())
    assert whole.history["contact_force"][:, 2].max() > 0.0


def test_a_law_without_state_has_no_byte_of_it():
    scene = falling()
    sizes = []
    for one in (scene, without_state(scene)):
        plan = tc.plan(one).bodies[0]
        state = state_of(one, plan)
        sizes.append(state.memory()["internal-force"])
    force = state.internal_force
    assert force.memory is None
    assert force.bundle().memory is None
    packs, points = 2, 8  # a pack of ordinary cells, one of contact cells
    assert sizes[0] - sizes[1] == packs * 8 * 2 * points * WIDTH


def test_what_cannot_have_state_refuses_it():
    with pytest.raises(tc.InputError, match=r"implicit schemes have .* takes test_hardening: CentralDifference$"):
        tc.simulate(falling(), tc.Midpoint(dt=1e-5))  # although the law has the functions of neo-Hookean's steps


def test_the_stress_of_its_cells_is_that_of_their_state():
    body = falling("tet4").bodies[0]
    u = 0.01 * np.random.default_rng(3).normal(size=body.mesh.nodes.shape) * body.mesh.shortest_edge
    state = np.zeros((body.mesh.cell_count, 1, 2))  # cells, points, numbers
    stress = VonMises(body)
    fresh = np.array(stress(u, [state]))
    state[:, 0, 1] = 0.5  # mu is half as large again, with the same lambda
    assert np.array(stress(u, [state])) == pytest.approx(1.5 * fresh, rel=1e-9)
    assert np.array(stress(u)) == pytest.approx(1.5 * fresh, rel=1e-9)  # the last state given stays
