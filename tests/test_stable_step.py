"""The stable step: 90 to 100 % of 2/omega_max of the free body with its standard lumped mass (METHOD 2)."""

import warnings

import numpy as np
import oracle
import pytest
from conftest import THREADS
from oracle import meshes
from scenes import LAWS, block, force_of, material, simulate, stable_steps, thrown, twin, wall

import tcontact as tc
from tcontact.cases import wall_shock
from tcontact.planning.planning import plan
from tcontact.run import loop
from tcontact.schemes.explicit.stable_step import StableSteps
from tcontact.schemes.explicit.start_vectors import random_rows, random_vector


def ratio(body, displacement=None, planes=(), penalty=None, **options):
    """Estimate over the true limit of a body, by a dense eigenvalue."""
    scene = tc.Scene(bodies=[body], obstacles=planes, duration=1.0, contact=penalty and tc.PenaltyContact(penalty))
    planned = plan(scene).bodies[0]
    normals = np.array([plane.normal for plane in planes])
    estimator = stable_steps(planned, force_of(planned), planes, penalty)
    u = np.zeros((body.mesh.node_count, 3)) if displacement is None else displacement
    estimate = estimator.estimate(u[planned.node_order].reshape(-1), **options)
    there = twin(body)
    if displacement is None:
        return estimate / oracle.stable_step(there, penalty, normals), estimator
    quad = oracle.quadrature(there.nodes, there.cells, there.kind)
    stiffness = oracle.tangent(quad, there.law, displacement).toarray()
    mass = oracle.assemble(there.cells, oracle.lumped_cell_mass(quad, there.density), len(there.nodes))
    root = np.repeat(mass, 3) ** -0.5
    largest = np.linalg.eigvalsh(root[:, None] * stiffness * root)[-1]
    return estimate / (2.0 / np.sqrt(largest)), estimator


def graded(kind, count=4, power=2.0, stretch=(1.0, 1.0, 1.0)):
    """Cells that shrink towards one corner, stretched along the axes."""
    box = tc.box_mesh((1.0, 1.0, 1.0), (count,) * 3, kind)
    return tc.Mesh(box.nodes**power * stretch, box.cells, kind, face_sets=box.face_sets)


SHAPES = {
    "shaken": lambda kind: block(kind, 4, shake=0.25, turn=meshes.rotation(2)),
    "even": lambda kind: block(kind, 4, shake=0.0),
    "graded": graded,
    "thin": lambda kind: graded(kind, 4, 1.0, (1.0, 0.05, 0.4)),
    "needle": lambda kind: block(kind, (1, 1, 12), (0.1, 0.1, 3.0), shake=0.0),
    "one cell": lambda kind: block(kind, 1, shake=0.0, turn=meshes.rotation(4)),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_ratio_to_the_dense_eigenvalue_for_many_meshes(kind, shape):
    share, _ = ratio(tc.Body(SHAPES[shape](kind), material("neo")))
    assert 0.9 <= share <= 1.0


@pytest.mark.parametrize(
    ("law", "poisson"),
    [(law, poisson) for law in LAWS for poisson in (-0.5, 0.0, 0.3, 0.49) if law != "mooney" or poisson > 0.2],
)
def test_ratio_for_every_law_and_poisson_ratio(law, poisson):
    kind = "hex8" if poisson < 0.1 else "tet4"
    share, _ = ratio(tc.Body(block(kind, 3), material(law, poisson=poisson), formulation="full"))
    assert 0.9 <= share <= 1.0


@pytest.mark.parametrize("seed", range(4))
def test_ratio_for_random_jitter(seed):
    kind = ["hex8", "tet4"][seed % 2]
    share, _ = ratio(tc.Body(block(kind, (3, 4, 5), shake=0.3, seed=seed), material("linear")))
    assert 0.9 <= share <= 1.0


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_a_search_that_is_cut_short_stays_on_the_safe_side(kind):
    """After four products the Ritz value is 5 to 20 % too small; its residual makes up for what is missing."""
    for name, shape in SHAPES.items():
        share, _ = ratio(tc.Body(shape(kind), material("neo")), products=4)
        assert 0.8 <= share <= 1.0, name


@pytest.mark.parametrize("factor", [0.1, 1.0, 10.0, 1000.0])
def test_penalty_on_ordinary_mass_is_part_of_the_limit(factor):
    """kappa = factor E/h on every contact node, along two slanted walls at once."""
    turn = meshes.rotation(7)
    mesh, mat = block("hex8", 3, turn=turn), material("neo")
    body = tc.Body(mesh, mat, contact=["zmin", "xmin"])
    planes = [wall(mesh, turn[:, 2], 0.01), wall(mesh, turn @ (0.6, 0.0, 0.8), 0.01)]
    share, _ = ratio(body, planes=planes, penalty=factor * mat.young / 0.06)
    assert 0.9 <= share <= 1.0
    free, _ = ratio(body)
    assert 0.9 <= free <= 1.0


def test_a_run_takes_cfl_times_the_limit_and_massless_penalty_does_not_cut_it():
    free = simulate(thrown(duration=0.2, contact=tc.MasslessContact()), cfl=0.7)
    assert free.dt == pytest.approx(0.7 * free.dt_limit, rel=1e-14)
    soft = simulate(thrown(duration=0.2, contact=tc.MasslessContact(penalty=1e12)))
    assert soft.dt_limit == free.dt_limit
    hard = simulate(thrown(duration=0.2, contact=tc.PenaltyContact(10 * 2.3e7 / 0.06)))
    assert hard.dt_limit < 0.6 * free.dt_limit


@pytest.mark.parametrize(("kind", "law"), [("hex8", "neo"), ("tet4", "neo"), ("hex8", "svk")])
@pytest.mark.parametrize("products", [20, 6])
def test_ratio_after_deformation(kind, law, products):
    """Compressed to three quarters, sheared and turned; few products from the mode of the estimate before."""
    mesh = block(kind, 3)
    body = tc.Body(mesh, material(law))
    stretch = np.diag([1.1, 0.95, 0.75 if law == "neo" else 0.9]) + np.array([[0, 0.2, 0], [0, 0, 0], [0.1, 0, 0]])
    deformed = mesh.nodes @ (meshes.rotation(1) @ stretch).T - mesh.nodes
    share, estimator = ratio(body, deformed)
    assert 0.9 <= share <= 1.0
    order = plan(tc.Scene(bodies=[body], duration=1.0)).bodies[0].node_order
    again = estimator.estimate(deformed[order].reshape(-1), products=products)
    full = estimator.estimate(deformed[order].reshape(-1), products=20)
    assert again == pytest.approx(full, rel=0.05)


def test_a_step_that_comes_close_to_the_stable_one_is_cut_to_cfl_times_it(monkeypatch):
    """The second look finds a stable step of half the first one: from there on the step is cfl times that."""
    estimate, found = StableSteps.estimate, []

    def halved(self, *arguments, **options):
        found.append(estimate(self, *arguments, **options) if not found else 0.5 * found[0])
        return found[-1]

    monkeypatch.setattr(StableSteps, "estimate", halved)
    monkeypatch.setattr(loop, "FIRST_CHECK", 5)
    scene = tc.Scene(bodies=[tc.Body(block("hex8", 2), material("neo"), velocity=lambda x: 0.1 * x)], duration=5e-3)
    result = simulate(scene, cfl=0.6)
    assert len(found) > 1
    steps = np.diff(result.history["time"])
    assert steps[0] == pytest.approx(0.6 * found[0], rel=1e-9)
    assert steps[-1] == pytest.approx(loop.coarse(0.3 * found[0]), rel=1e-9)


def test_the_step_shrinks_with_a_body_that_is_crushed():
    """A neo-Hookean block thrown hard: later steps are shorter, and the run stays sound."""
    scene = thrown("neo", "hex8", speed=0.35, duration=3.0, contact=tc.MasslessContact(), shake=0.0)
    result = simulate(scene, cfl=0.95)
    steps = np.diff(result.history["time"])
    assert steps[0] == pytest.approx(result.dt, rel=1e-12)
    assert steps.min() < 0.97 * steps[0]
    assert result.history["energy_error"].max() < 0.05


def test_a_front_that_stiffens_the_body_elsewhere_is_found_with_few_products():
    """The mode found last lies behind a shock: searched from there alone, the step stays a fifth too large and the run
    ends with inverted cells."""
    result = tc.simulate(wall_shock.scene(cells=160, mach=0.4), threads=THREADS)
    assert result.ok, result.message
    assert np.abs(result.history["energy_error"]).max() < 0.03 * result.history["energy"][0]


def test_a_shortened_step_is_the_same_for_estimates_that_differ_in_rounding():
    """It is never longer, by 1.3e-4 shorter at most, and stays what it is when it is rounded again."""
    for step in np.random.default_rng(3).uniform(1e-9, 1e-3, 200):
        short = loop.coarse(step)
        assert (1.0 - 2.0**-13) * step <= short <= step
        assert loop.coarse(short) == short
        middle = short * (1.0 + 2.0**-16)
        assert loop.coarse(middle * (1.0 + 1e-9)) == loop.coarse(middle * (1.0 - 1e-9))
    assert loop.coarse(np.inf) == np.inf


@pytest.mark.parametrize("numbers", [[], [7], [5, 5, 0], range(3, 200_000, 7), [80_000, 2, 40_000]])
def test_rows_of_the_random_start_are_those_of_the_whole_one(numbers):
    """The rows are equal in any order, with one of them twice, without any, and drawn in several portions."""
    numbers = np.array(numbers, dtype=np.int32)
    assert np.array_equal(random_rows(numbers), random_vector(3 * 200_000).reshape(-1, 3)[numbers])


def test_a_stiffness_that_overflows_is_refused_by_name_without_other_warnings():
    """NumPy has nothing to say of lines of the program."""
    body = tc.Body(tc.box_mesh((1.0, 1.0, 1.0), (2, 1, 1)), tc.LinearElastic(1e308, 0.3, 1000.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(tc.InputError, match=r"material of body-0 = .*1e\+308.*forces overflow"):
            tc.simulate(tc.Scene(body, duration=1.0))


def test_a_body_that_has_no_stiffness_left_ends_with_an_inverted_cell():
    """Crushed beyond the limit of its law no mode has a stiffness: once the next step was not a number then."""
    soft = tc.StVenantKirchhoff(2.3e7, 0.27, 1350.0)
    body = tc.Body(block(cells=2, shake=0.1), soft, lambda x: 1200.0 * (0.1 - x), name="crushed")
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        result = tc.simulate(tc.Scene([body], [], 4e-3, contact=None), threads=THREADS)
    assert result.reason == "inverted-cell"
    assert np.isfinite(result.history["time"]).all()
