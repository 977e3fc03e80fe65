"""The second solver of the contact nodes, MPRGP, against quadratic programs solved densely; when it is chosen."""

import dataclasses
import functools
from collections import namedtuple

import numpy as np
import pytest
import taichi as ti
from scenes import block, material, simulate, state_of, thrown, wall
from scipy.optimize import nnls
from stopped_runs import scene as sliding_block
from test_resume import split

import tcontact as tc
from tcontact.cases import cube_impact
from tcontact.device import arrays
from tcontact.kernels.lanes import ISLAND, SWEEP_LANES
from tcontact.kernels.language.arguments import ARRAY, INDEX
from tcontact.kernels.language.bundles import ContactOptions
from tcontact.kernels.language.compile_options import KEEP_VECTORS, LEAVE_TO_LLVM, compiled_with
from tcontact.kernels.language.solve_bundles import System
from tcontact.kernels.node_places import PLACES
from tcontact.kernels.static import control as names
from tcontact.kernels.static.mprgp import mprgp
from tcontact.planning.static_solver import FULL_POISSON, TALL, height_over_width, static_solver
from tcontact.planning.sweep_order import sweep_order

Contact = namedtuple("Contact", "active islands options")
Solved = namedtuple("Solved", "definite motion active products")
SOLVERS = ("gauss-seidel", "projected-gradient")


@functools.cache
def make_solve(size):
    """Kernel that solves for island 0, with `size` components a node."""

    @ti.kernel
    def solve(
        islands: INDEX, lane_start: INDEX, pack_start: INDEX, column: INDEX, values: ARRAY, inverse: ARRAY,
        stiffness: ARRAY, right: ARRAY, gaps: ARRAY, normals: ARRAY, response: ARRAY, increment: ARRAY, settings: ARRAY,
        stats: ARRAY, active: INDEX, answer: INDEX,
    ):  # fmt: skip
        system = ti.static(
            System(
                lane_start, pack_start, column, values, inverse, stiffness, right, gaps, normals, response, increment,
                settings, stats,
            )
        )  # fmt: skip
        ti.loop_config(serialize=True)
        for _ in range(1):
            answer[0] = mprgp(ti.static(Contact(active, islands, ContactOptions())), None, None, system, 0, size)

    return compiled_with(solve, **KEEP_VECTORS, **LEAVE_TO_LLVM)


def graph_of(kind, cells):
    """The graph of the contact nodes of a small block."""
    body = tc.Body(tc.box_mesh((0.1,) * 3, cells, kind), material("linear"), contact="zmin")
    scene = tc.Scene([body], [tc.Plane((0, 0, -1.0))], 1.0, contact=tc.MasslessContact(removal="full"))
    return tc.plan(scene).bodies[0].contact.graph


def problem(graph, size, seed, soft=1e-2, scale=1.0):
    """Random K [k, size, k, size] summed from definite blocks of the cells, r, n of any length and g of both signs."""
    rng = np.random.default_rng(seed)
    count = len(graph.nodes)
    matrix = np.zeros((count, size, count, size))
    for cell in range(len(graph.cells)):
        corners = np.unique(graph.pair_nodes[graph.pair_start[cell] : graph.pair_start[cell + 1]])
        width = len(corners) * size
        turn = np.linalg.qr(rng.normal(size=(width, width)))[0]
        own = (turn * 10.0 ** rng.uniform(np.log10(soft), 0.0, width)) @ turn.T
        matrix[np.ix_(corners, range(size), corners, range(size))] += own.reshape(len(corners), size, -1, size)
    right = rng.normal(size=(count, size))
    normals = rng.normal(size=(count, size)) * rng.uniform(0.2, 1.0, (count, 1))
    gaps = rng.uniform(-0.1, 1.0, count) * rng.choice([0.0, 1.0], count)  # some touch from the start
    normals[rng.uniform(size=count) < 0.1] = 0.0  # which nothing can push
    gaps[~normals.any(axis=1)] = 1.0
    return scale * matrix, scale * right, normals, gaps


def solved(graph, matrix, right, normals, gaps, tolerance=1e-12, pivot=1.0):
    """Return what the kernel finds for island 0."""
    count, size = right.shape
    order = sweep_order(graph, size)
    room = count + SWEEP_LANES - 1
    values = np.zeros(order.column.size * size * size)
    row = np.repeat(np.arange(count), np.diff(graph.row_start))
    for entry in np.flatnonzero(order.entry_place >= 0):
        blocks = matrix[row[entry], :, graph.column[entry]].ravel()
        values[order.entry_place[entry] + np.arange(size * size) * SWEEP_LANES] = blocks

    def last(array):
        """The node comes last; what lies beyond the nodes must not matter."""
        flat = np.full((int(np.prod(array.shape[1:])), room), np.nan)
        flat[:, :count] = array.reshape(count, -1).T
        return flat.ravel()

    diagonal = matrix[np.arange(count), :, np.arange(count)]
    settings, stats = np.zeros(names.SETTINGS), np.zeros(names.STATS)
    settings[[names.AIM, names.TOLERANCE, names.LINEAR]] = tolerance, tolerance, 1.0
    settings[[names.POLISHING_SWEEPS, names.MAXIMUM_IN_ALL]] = 2000.0
    settings[names.STEP_LENGTH] = 1.9 / graph.corners_together
    stats[names.F_REF], stats[names.PIVOT] = np.abs(right).max(), pivot
    response, increment = np.full(room * PLACES[size].end, np.nan), np.full(3 * room * size, np.nan)
    active, answer = np.zeros(count, dtype=np.int32), np.zeros(1, dtype=np.int32)
    islands = np.zeros((2, ISLAND), dtype=np.int32)
    islands[1] = len(order.pack_start) - 1  # the solver asks for the packs only
    lists = [a.astype(np.int32).ravel() for a in (order.lane_start, order.pack_start, order.column)]
    inverse, stiffness = np.linalg.inv(diagonal), np.trace(diagonal, axis1=1, axis2=2)
    make_solve(size)(
        islands.ravel(), *lists, values, last(inverse), last(stiffness), last(right), last(gaps),
        last(normals), response, increment, settings, stats, active, answer,
    )  # fmt: skip
    motion = increment[: room * size].reshape(size, room)[:, :count].T
    return Solved(answer[0], motion, active.astype(bool), stats[names.SWEEPS])


def dense(matrix, right, normals, gaps):
    """d and lambda of min 1/2 d.K d - r.d with g + n.d >= 0, from the dual problem by non-negative least squares."""
    count, size = right.shape
    rows = np.zeros((count, count, size))
    rows[np.arange(count), np.arange(count)] = normals
    pushed = normals.any(axis=1)
    rows, matrix = rows.reshape(count, -1)[pushed], matrix.reshape(count * size, -1)
    triangle = np.linalg.cholesky(matrix)
    half = np.linalg.solve(triangle, rows.T)  # rows K^-1 rows^t = half^t half
    free = np.linalg.solve(matrix, right.ravel())
    # lambda >= 0 minimises |half lambda + c|^2 with half^t c = g + n.free
    target = np.linalg.lstsq(half.T, -(gaps[pushed] + rows @ free), rcond=None)[0]
    pressing = np.zeros(count)
    pressing[pushed] = nnls(half, target, maxiter=10 * count)[0]
    motion = free + np.linalg.solve(matrix, rows.T @ pressing[pushed])
    return motion.reshape(count, size), pressing


@pytest.mark.parametrize("scale", [1.0, 1e9])
@pytest.mark.parametrize("size", [1, 3])
@pytest.mark.parametrize(("kind", "cells"), [("hex8", (1, 1, 1)), ("hex8", (5, 3, 1)), ("tet4", (3, 2, 1))])
def test_random_problems_are_solved_as_densely(kind, cells, size, scale):
    """Bounds that are left and met again, any normals, nodes that nothing can push, packs of any length."""
    graph = graph_of(kind, cells)
    pressed = left = 0
    for seed in range(20):
        given = problem(graph, size, seed, scale=scale)
        matrix, right, normals, gaps = given
        found = solved(graph, *given)
        wanted, pressing = dense(*given)
        assert found.definite == 1
        assert np.abs(found.motion - wanted).max() <= 1e-8 * np.abs(wanted).max()
        sure = pressing * np.linalg.norm(normals, axis=1) > 1e-7 * np.abs(right).max()
        assert found.active[sure].all()
        pressed, left = pressed + sure.sum(), left + (~found.active).sum()
        assert (gaps + (normals * found.motion).sum(axis=1)).min() >= -1e-13 * np.abs(wanted).max()
        rest = np.einsum("kila,la->ki", matrix, found.motion) - right
        held = np.where(found.active, (rest * normals).sum(axis=1) / np.maximum((normals**2).sum(axis=1), 1e-300), 0.0)
        assert held.min() >= -1e-9 * np.abs(right).max()
        assert np.abs(rest - held[:, None] * normals).max() <= 1e-11 * np.abs(right).max()
    assert min(pressed, left) >= 20  # neither set is empty


def test_without_bounds_the_products_are_those_of_conjugate_gradients():
    """k unknowns need at most k products; many soft modes need about the root of the condition number."""
    graph = graph_of("hex8", (2, 1, 1))
    matrix, right, normals, gaps = problem(graph, 3, 1, soft=1e-4)
    found = solved(graph, matrix, right, 0.0 * normals, gaps + 1.0)
    wanted = np.linalg.solve(matrix.reshape(right.size, -1), right.ravel()).reshape(right.shape)
    assert np.abs(found.motion - wanted).max() <= 1e-7 * np.abs(wanted).max()
    assert not found.active.any()
    assert found.products <= 2 * right.size


@pytest.mark.parametrize("pivot", [1.0, -1.0])
def test_an_indefinite_stiffness_is_given_back(pivot):
    """Negative curvature between definite nodes (pivot 1), or at one node."""
    graph = graph_of("hex8", (2, 2, 1))
    matrix, right, normals, gaps = problem(graph, 3, 3)
    across = matrix.reshape(right.size, -1)
    values, vectors = np.linalg.eigh(across)
    soft = vectors[:, 0].reshape(right.shape)
    low = matrix - 3.0 * values[0] * np.einsum("ki,lj->kilj", soft, soft)
    assert np.linalg.eigvalsh(low.reshape(right.size, -1))[0] < 0.0
    found = solved(graph, low, soft, 0.0 * normals, gaps + 1.0, pivot=pivot)
    assert found.definite == 0
    assert found.products <= right.size, "at the first direction that shows it"
    assert solved(graph, matrix, soft, 0.0 * normals, gaps + 1.0).definite == 1


def with_solver(scene, solver):
    """Return the scene with this solver of the static solve."""
    return dataclasses.replace(scene, contact=dataclasses.replace(scene.contact, solver=solver))


@pytest.mark.parametrize(("kind", "law", "removal"), [("hex8", "linear", "full"), ("tet4", "neo", "normal")])
def test_an_impact_is_the_same_with_both_solvers(kind, law, removal, request):
    """Both solvers agree within their tolerance; tetrahedra take the launches of large bodies."""
    if kind == "tet4":
        request.getfixturevalue("parallel_path")
    contact = tc.MasslessContact(removal=removal, tolerance=1e-11)
    scene = thrown(law, kind, duration=1.2, speed=0.04, contact=contact, gravity=False)
    one, other = (simulate(with_solver(scene, name)) for name in SOLVERS)
    force = np.abs(one.history["contact_force"]).max()
    assert force > 0.0
    assert other.history["static_residual"].max() <= 1e-10
    assert np.abs(one.history["contact_force"] - other.history["contact_force"]).max() <= 1e-7 * force
    assert np.abs(one.position - other.position).max() <= 1e-9 * 0.2
    assert np.array_equal(one.history["contact_nodes"], other.history["contact_nodes"])
    assert not np.array_equal(one.position, other.position)
    assert not np.array_equal(one.history["sweeps"], other.history["sweeps"])  # sweeps of one, products of the other


def test_a_run_with_mprgp_goes_on_from_a_checkpoint_with_the_same_bits(monkeypatch, tmp_path):
    """Results, history and frames of a run that was split at two checkpoints are those of one that never stopped."""
    scene = sliding_block(contact=tc.MasslessContact(removal="full", solver="projected-gradient"))
    assert chosen(scene).projected
    whole = split(monkeypatch, tmp_path, scene, 2)
    assert whole.history["contact_force"][:, 2].max() > 0.0
    assert whole.history["sweeps"][2:].min() >= 1.0  # the block starts in equilibrium


def chosen(scene):
    """Return the solver of the first body of a scene and the reason."""
    return static_solver(scene, tc.plan(scene).bodies[0])


def test_the_choice_and_its_reason_stand_in_the_description():
    """Above poisson .45 with full removal, above .49 with one volume change per cell, for tall cells; else sweeps."""
    for changes, projected, reason in (
        ({"removal": "full"}, False, "few"),
        ({"removal": "full", "poisson": FULL_POISSON}, False, "few"),
        ({"removal": "full", "poisson": 0.46}, True, "poisson 0.46"),
        ({"removal": "normal", "poisson": 0.499}, False, "few"),
        ({"removal": "normal", "poisson": 0.499, "formulation": "mean-dilatation"}, True, "volume"),
        ({"removal": "full", "poisson": 0.49, "penalty": 10.0}, False, "penalty"),
    ):
        scene = cube_impact.scene(cells=3, **changes)
        solver = chosen(scene)
        assert (solver.projected, reason in solver.reason) == (projected, True), changes
        assert f"static solve by {solver}" in tc.plan(scene).describe()
    tall = tc.Body(tc.box_mesh((0.03, 0.03, 2.0 * 0.01 * TALL * 1.1), (3, 3, 2)), material("linear"), contact="zmin")
    scene = tc.Scene([tall], [tc.Plane()], 1.0, contact=tc.MasslessContact())
    assert height_over_width(tc.plan(scene).bodies[0]) == pytest.approx(1.1 * TALL)
    assert "tall" in chosen(scene).reason
    assert not chosen(with_solver(scene, "gauss-seidel")).projected
    flat = dataclasses.replace(tall, contact="xmin")
    assert not chosen(dataclasses.replace(scene, bodies=[flat], obstacles=[tc.Plane(normal=(1.0, 0, 0))])).projected


@pytest.mark.parametrize("why", ["more than one obstacle", "friction", "penalty"])
def test_what_it_cannot_solve_is_refused_by_name(why):
    body = tc.Body(block("hex8", 2), material("linear"), contact="zmin")
    below = [wall(body.mesh, (0, 0, 1.0), 1e-3)] * (2 if why.startswith("more") else 1)
    contact = tc.MasslessContact("full", solver="projected-gradient", penalty=1e9 if why == "penalty" else None)
    friction = tc.Coulomb(0.3) if why == "friction" else None
    scene = tc.Scene([body], below, 1.0, contact=contact, friction=friction)
    with pytest.raises(tc.InputError, match=rf"MasslessContact\.solver.*projected-gradient.*{why}"):
        tc.plan(scene)
    assert not chosen(with_solver(scene, "auto")).projected


def losing(solver):
    """Return a scene of a block of St Venant-Kirchhoff, which loses ellipticity in compression, thrown at a wall."""
    mesh, law = block("hex8", 3), material("svk")
    body = tc.Body(mesh, law, velocity=(0.0, 0.0, -0.4 * law.wave_speed), contact="zmin")
    return tc.Scene([body], [wall(mesh, (0, 0, 1.0), 1e-4)], 1e-2, contact=tc.MasslessContact("full", solver=solver))


def placed(scene, stretch):
    """Return the displacement after the static solve of a block with this stretch in z, its sweeps and products."""
    start = scene.bodies[0].mesh.nodes * np.array([0.0, 0.0, stretch - 1.0])
    state = state_of(scene, tc.plan(scene).bodies[0], start)
    state.begin_contact(1e-6)
    return state.views[0].displacement(), arrays.get(state.contact.static_solve.system["stats"])[names.SWEEPS]


@pytest.mark.parametrize(
    ("stretch", "falls_back", "products"),
    [(0.8, False, True), (0.638, True, True), (0.55, True, False)],
    ids=["definite", "indefinite between nodes", "indefinite at a node"],
)
def test_where_mprgp_gives_back_the_sweeps_alone_decide_to_the_last_bit(stretch, falls_back, products):
    """Products until a direction of negative curvature count beside the sweeps; an indefinite node costs none."""
    (one, sweeps), (other, count) = (placed(losing(solver), stretch) for solver in SOLVERS)
    assert np.abs(one - other).max() <= 1e-6 * np.abs(one).max()
    assert np.array_equal(one, other) == falls_back
    assert (count != sweeps) == products
    if falls_back:
        assert count >= sweeps


def test_a_body_of_a_law_that_loses_ellipticity_goes_on_with_sweeps():
    """St Venant-Kirchhoff in strong compression: both ask for the same end, and the message names the law."""
    ends = [tc.simulate(losing(solver)) for solver in SOLVERS]
    assert ends[0].reason == ends[1].reason
    assert ends[1].reason in ("not-converged", "inverted-cell")
    assert "NeoHookean" in ends[1].message
    assert ends[1].time == pytest.approx(ends[0].time, rel=0.05)


@pytest.mark.filterwarnings("ignore:block has poisson")
def test_the_bench_compares_both_solvers():
    """Near poisson 1/2 products are fewer than sweeps; the table has a line for each."""
    from tcontact.lab.bench import static_solvers

    rows = static_solvers.compare(4, 2, poissons=(0.499,), removals=("full",))
    assert [row["solver"] for row in rows] == list(static_solvers.SOLVERS)
    assert rows[1]["count_mean"] < rows[0]["count_mean"]
    assert rows[1]["static_residual"] <= 1e-4
    assert len(static_solvers.lines(rows)) == 2 + len(rows)
