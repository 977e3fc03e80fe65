"""Bodies in contact with each other beside several obstacles: linear problems against dense ones, statics, impacts."""

import dataclasses
import functools

import numpy as np
import pytest
import taichi as ti
from oracle import meshes
from pair_scenes import soft
from scipy.optimize import nnls
from test_mprgp import graph_of, problem
from test_resume import split

import tcontact as tc
from tcontact.kernels import pair_places as at
from tcontact.kernels.contact.islands import node_count
from tcontact.kernels.contact.pair_rows import collect
from tcontact.kernels.lanes import ISLAND, SWEEP_LANES
from tcontact.kernels.language.arguments import ARRAY, INDEX
from tcontact.kernels.language.bundles import Contact, ContactOptions, Coupling, Rows
from tcontact.kernels.language.compile_options import KEEP_VECTORS, LEAVE_TO_LLVM, compiled_with
from tcontact.kernels.language.solve_bundles import System
from tcontact.kernels.node_places import PLACES
from tcontact.kernels.static import control as names
from tcontact.kernels.static.chosen_rows import OPPOSED, choose_rows
from tcontact.kernels.static.mprgp import mprgp
from tcontact.planning.contact_graph import joined
from tcontact.planning.sweep_order import sweep_order

SLOTS = 4  # three obstacles and the masters
OPTIONS = ContactOptions("massless", 3, SLOTS, projected=True, coupled=True)
WIDTH = OPTIONS.row_places.width


@functools.cache
def make_solve():
    """Kernel that chooses the rows of all nodes and solves the linear problem of island 0."""

    @ti.kernel
    def solve(
        islands: INDEX, lane_start: INDEX, pack_start: INDEX, column: INDEX, values: ARRAY, inverse: ARRAY,
        stiffness: ARRAY, right: ARRAY, gaps: ARRAY, normals: ARRAY, response: ARRAY, increment: ARRAY, settings: ARRAY,
        stats: ARRAY, active: INDEX, basis: ARRAY, row_values: ARRAY, lists: INDEX, numbers: ARRAY, answer: INDEX,
        reach: float,
    ):  # fmt: skip
        system = ti.static(
            System(
                lane_start, pack_start, column, values, inverse, stiffness, right, gaps, normals, response, increment,
                settings, stats,
            )
        )  # fmt: skip
        contact = ti.static(Contact(islands=islands, active=active, basis=basis, options=OPTIONS))
        rows, coupling = ti.static(Rows(row_values, OPTIONS), Coupling(lists, numbers))
        ti.loop_config(serialize=True)
        for _ in range(1):
            for k in range(node_count(contact)):
                choose_rows(contact, rows, system, k, reach)
            collect(coupling, contact, rows, system.right, 0, system.stiffness.shape[0], 3)
            answer[0] = mprgp(contact, rows, coupling, system, 0, 3)

    return compiled_with(solve, **KEEP_VECTORS, **LEAVE_TO_LLVM)


def three_bodies(seed, scale=1.0, **options):
    """Return graph, K, r of three blocks, their rows, and which nodes are coupled with which weights.

    The first body is slave of both others, the second one of the third. rows: normals [k, 4, 3] and gaps [k, 4], three
    of obstacles and the one of the pair (0: none); weights [k, k + 2]: P, the last two columns are nodes with mass.
    """
    rng = np.random.default_rng(seed)
    parts = [graph_of(kind, cells) for kind, cells in (("hex8", (2, 1, 1)), ("tet4", (2, 1, 1)), ("hex8", (2, 2, 1)))]
    ends = np.cumsum([0, *(len(part.nodes) for part in parts)])
    graph = joined(parts, [0, 0, 0])
    matrix = np.zeros((ends[-1], 3, ends[-1], 3))
    right = np.zeros((ends[-1], 3))
    for number, part in enumerate(parts):
        own = slice(ends[number], ends[number + 1])
        matrix[own, :, own], right[own], _, _ = problem(part, 3, seed + 100 * number, soft=0.1, scale=scale)
    count = len(right)
    normals, gaps = np.zeros((count, SLOTS, 3)), np.ones((count, SLOTS))
    weights = np.zeros((count, count + 2))
    for k in range(count):
        body = int(np.searchsorted(ends, k, side="right")) - 1
        several = rng.integers(0, 4)
        if body < 2 and rng.uniform() < 0.7:
            above = rng.choice(np.arange(ends[1] if body == 0 else ends[2], count + 2), 4, replace=False)
            weights[k, above] = rng.uniform(-0.2, 1.0, 4)
            weights[k] /= weights[k].sum()
            normals[k, 3] = unit(rng)
            several = min(several, 2)
        for slot in rng.permutation(3)[:several]:
            normals[k, slot] = unit(rng)
            while not independent(normals[k], **options):
                normals[k, slot] = unit(rng)
        some = normals[k].any(axis=1)
        gaps[k, some] = rng.uniform(-0.05, 0.5, some.sum()) * rng.choice([0.0, 1.0], some.sum())
    return graph, matrix, right, normals, gaps, weights


def unit(rng):
    vector = rng.normal(size=3)
    return vector / np.linalg.norm(vector)


def independent(normals, sine=0.1):
    """Return whether every normal has a part of this size that is orthogonal to all others, and none is opposite."""
    there = normals[normals.any(axis=1)]
    parts = 1.0 / np.linalg.norm(np.linalg.pinv(there), axis=0)
    return len(there) <= 3 and (parts >= sine).all() and (there @ there.T).min() > OPPOSED


def solved(graph, matrix, right, normals, gaps, weights, reach=1e300, tolerance=1e-12):
    """Return the increments [k, 3], the active rows [k, 4] and the products that the kernel needs."""
    count = len(right)
    order = sweep_order(graph, 3)
    room = count + SWEEP_LANES - 1
    values = np.zeros(order.column.size * 9)
    row = np.repeat(np.arange(count), np.diff(graph.row_start))
    for entry in np.flatnonzero(order.entry_place >= 0):
        blocks = matrix[row[entry], :, graph.column[entry]].ravel()
        values[order.entry_place[entry] + np.arange(9) * SWEEP_LANES] = blocks
    response = np.full((PLACES[3].several_end, room), np.nan)
    diagonal = matrix[np.arange(count), :, np.arange(count)]
    response[PLACES[3].diagonal : PLACES[3].diagonal + 9, :count] = diagonal.reshape(count, 9).T
    given = np.full((3, room), np.nan)
    given[:, :count] = right.T
    rows = np.zeros((count, SLOTS, WIDTH))
    rows[:, :, OPTIONS.row_places.normal : OPTIONS.row_places.normal + 3] = normals
    rows[:, :, OPTIONS.row_places.gap] = gaps
    settings, stats = np.zeros(names.SETTINGS), np.zeros(names.STATS)
    settings[[names.AIM, names.TOLERANCE]] = tolerance
    settings[names.MINIMUM_SWEEPS] = 2.0
    settings[[names.POLISHING_SWEEPS, names.MAXIMUM_IN_ALL]] = 4000.0
    settings[names.STEP_LENGTH] = 1.9 / graph.corners_together
    stats[names.F_REF], stats[names.PIVOT], stats[names.TODO] = np.abs(right).max(), 1.0, names.LAST_SWEEP
    islands = np.zeros((2, ISLAND), dtype=np.int32)
    islands[1] = count, len(order.pack_start) - 1, count, 0
    lists, numbers = coupling_of(weights)
    active, answer = np.zeros(count, dtype=np.int32), np.zeros(1, dtype=np.int32)
    nan, increment = np.full(room * 12, np.nan), np.full(9 * room, np.nan)
    packs = [a.astype(np.int32).ravel() for a in (order.lane_start, order.pack_start, order.column)]
    make_solve()(
        islands.ravel(), *packs, values, nan.copy(), np.trace(np.resize(diagonal, (room, 3, 3)), axis1=1, axis2=2),
        given.ravel(), nan.copy(), nan.copy(), response.ravel(), increment, settings, stats, active,
        np.tile(np.eye(3), (count, 1, 1)).ravel(), rows.ravel(), lists, numbers, answer, reach,
    )  # fmt: skip
    assert answer[0] == 1
    motion = increment[: room * 3].reshape(3, room)[:, :count].T
    return motion, (active[:, None] >> np.arange(SLOTS)) & 1 == 1, stats[names.SWEEPS]


def coupling_of(weights):
    """Return `Coupling.lists` and `Coupling.values` with the rows of pairs; masters stand before their slaves."""
    slaves = np.flatnonzero(weights.any(axis=1))[::-1]  # the third body has none, the first one comes last
    masters = [np.flatnonzero(weights[k]) for k in slaves]
    first = np.cumsum([0, *map(len, masters)])
    row_of = np.full(len(weights), -1)
    row_of[slaves] = np.arange(len(slaves))
    sections = {at.SLAVES: slaves, at.FIRST_ENTRY: first, at.MASTERS: np.concatenate(masters), at.NODE_ROW: row_of}
    header = np.zeros(at.LISTS_HEADER, dtype=np.int64)
    header[at.ROWS], place = len(slaves), at.LISTS_HEADER
    for section, content in sections.items():
        header[section], place = place, place + len(content)
    header[at.WEIGHTS] = at.VALUES_HEADER
    values = np.concatenate([weights[k][weights[k] != 0.0] for k in slaves])
    lists = np.concatenate([header, *sections.values()]).astype(np.int32)
    return lists, np.concatenate([np.zeros(at.VALUES_HEADER), values])


def rows_of(normals, weights):
    """Return the matrix [k, 4, k, 3] of all rows: the change of their gaps with the increments."""
    count = len(normals)
    result = np.zeros((count, SLOTS, count, 3))
    for k in range(count):
        result[k, :, k] = normals[k]
        result[k, 3] -= weights[k, :count, None] * normals[k, 3]
    return result


def dense(matrix, right, normals, gaps, weights):
    """d and lambda of min 1/2 d.K d - r.d with all gaps at least 0, from the dual problem."""
    count = len(right)
    there = normals.any(axis=2)
    rows = rows_of(normals, weights)[there].reshape(there.sum(), -1)
    matrix = matrix.reshape(3 * count, -1)
    half = np.linalg.solve(np.linalg.cholesky(matrix), rows.T)
    free = np.linalg.solve(matrix, right.ravel())
    target = np.linalg.lstsq(half.T, -(gaps[there] + rows @ free), rcond=None)[0]
    pressing = np.zeros(there.shape)
    pressing[there] = nnls(half, target, maxiter=100 * len(rows))[0]
    motion = free + np.linalg.solve(matrix, rows.T @ pressing[there])
    return motion.reshape(count, 3), pressing


@pytest.mark.parametrize("sine", [0.5, 0.1])
@pytest.mark.parametrize("scale", [1.0, 1e9])
def test_several_rows_at_slaves_and_masters_are_solved_as_densely(sine, scale):
    """Three bodies in a chain, up to three rows a node whose normals are as little apart as `sine` says."""
    several = left = 0
    for seed in range(8):
        given = three_bodies(seed, scale, sine=sine)
        right, normals, gaps, weights = given[2:]
        motion, active, _ = solved(*given)
        wanted, pressing = dense(*given[1:])
        assert np.abs(motion - wanted).max() <= 1e-9 * np.abs(wanted).max()
        sure = pressing > 1e-7 * np.abs(right).max()
        assert active[sure].all()
        rows = rows_of(normals, weights)
        assert (gaps + np.einsum("kpla,la->kp", rows, motion)).min() >= -1e-12 * np.abs(wanted).max()
        several += (sure.sum(axis=1) > 1).sum()
        left += (normals.any(axis=2) & ~active).sum()
    assert several >= 20
    assert left >= 20


def test_rows_that_depend_on_nearer_ones_and_rows_out_of_reach_do_not_enter():
    """A wall named twice bounds once, at the nearer place; a gap that no move of the solve can close changes no bit."""
    graph, matrix, right, normals, gaps, weights = three_bodies(3, sine=0.5)
    alone = solved(graph, matrix, right, normals, gaps, weights, reach=10.0)
    free = ~normals[:, 2].any(axis=1) & normals[:, 0].any(axis=1) & ~weights.any(axis=1)
    assert free.sum() >= 3
    again, further = normals.copy(), gaps.copy()
    again[free, 2], further[free, 2] = normals[free, 0], gaps[free, 0] + 1e-3
    twice = solved(graph, matrix, right, again, further, weights, reach=10.0)
    assert np.array_equal(alone[0], twice[0])
    away = normals.copy()
    away[free, 2], further[free, 2] = np.roll(normals[free, 0], 1, axis=1), 11.0
    assert np.array_equal(alone[0], solved(graph, matrix, right, away, further, weights, reach=10.0)[0])


WALLS = {"floor": (0, 0, 1), "x": (1, 0, 0), "y": (0, 1, 0)}
LOW, UP, GAP = (1.0, 1.0, 0.6), (0.8, 0.9, 0.5), 1e-3


def corner(turn=None, **options):
    """A block in the corner of two walls and a floor, and a smaller one on it that touches both walls too."""
    low = tc.box_mesh(LOW, (3, 3, 2), origin=(GAP, GAP, GAP))
    up = tc.box_mesh(UP, (4, 4, 2), origin=(GAP, GAP, LOW[2] + 2 * GAP))
    motion = np.eye(3) if turn is None else turn
    bodies = [
        tc.Body(low.rotated(motion), soft(), motion @ (-0.05, -0.03, -0.02), contact=("zmin", "zmax", "xmin", "ymin"),
                name="low"),
        tc.Body(up.rotated(motion), soft(), motion @ (-0.04, -0.05, -0.06), contact=("zmin", "xmin", "ymin"),
                name="up"),
    ]  # fmt: skip
    walls = [tc.Plane((0, 0, 0), tuple(motion @ normal), name=name) for name, normal in WALLS.items()]
    return tc.Scene(bodies, walls, **{"duration": 3.0, **options})


def test_blocks_in_a_corner_rest_with_their_weights_on_floor_walls_and_each_other():
    """Gravity is oblique; nodes at the edges have the rows of a wall and of the other block, or of two walls."""
    gravity = np.array((-0.01, -0.006, -0.02))
    scene = corner(duration=60.0, gravity=tuple(gravity), damping=tc.MassDamping(0.8))
    result = tc.simulate(scene)
    assert result.ok
    weight = np.prod(LOW) * gravity, np.prod(UP) * gravity
    bound = 1e-3 * np.linalg.norm(weight[1])
    for name, normal in WALLS.items():
        held = (weight[0] + weight[1]) * normal
        assert np.abs(result.obstacle_force[name][-1] - held).max() <= bound
    assert np.abs(result.pair_force["low-up"][-1] - weight[1] * (0, 0, 1)).max() <= bound
    assert result.history["gap_min"][-1] >= -1e-6


def test_an_impact_into_a_corner_keeps_the_momentum_ledger_and_the_energy():
    result = tc.simulate(corner())
    assert result.ok
    time, force, momentum = (result.history[name] for name in ("time", "contact_force", "momentum"))
    steps = 0.5 * (force[1:] + force[:-1]) * np.diff(time)[:, None]
    change = momentum[1:] - momentum[0]
    assert np.abs(change - np.cumsum(steps, axis=0)).max() <= 1e-13 * np.abs(momentum[0]).max()
    walls = sum(result.obstacle_force[name] for name in WALLS)
    assert np.abs(walls + force).max() <= 1e-14
    assert all(np.abs(result.obstacle_force[name]).max() > 0.01 for name in WALLS)
    assert result.pair_force["low-up"][:, 2].min() < -0.01
    assert np.abs(result.history["energy_error"]).max() <= 1.5e-2
    assert result.history["static_residual"].max() <= 1e-3


def test_a_turned_corner_is_the_same_corner():
    turn, scheme = meshes.rotation(9), tc.CentralDifference(dt=0.1)
    one, other = (tc.simulate(corner(motion, duration=2.0), scheme) for motion in (None, turn))
    assert np.abs(one.position @ turn.T - other.position).max() <= 1e-6
    force = one.pair_force["low-up"] @ turn.T
    assert np.abs(force - other.pair_force["low-up"]).max() <= 1e-4 * np.abs(force).max()


def test_a_resumed_run_in_a_corner_has_the_same_bits(tmp_path, monkeypatch):
    whole = split(monkeypatch, tmp_path, corner(duration=2.0), 4, tc.CentralDifference(dt=0.1), 3)
    assert whole.history["pair_pressed:low-up"].max() > 0


def test_a_scene_file_with_several_obstacles_keeps_the_pair(tmp_path):
    tc.save_scene(corner(), tmp_path / "scene.toml")
    scene, _ = tc.load_scene(tmp_path / "scene.toml")
    assert [(pair.name, pair.slave) for pair in scene.body_pairs] == [("low-up", 1)]
    assert len(scene.obstacles) == 3
    chosen = tc.MasslessContact(solver="projected-gradient")
    assert "MPRGP" in tc.plan(dataclasses.replace(scene, contact=chosen)).describe()


def test_curved_and_moving_obstacles_carry_a_pair():
    """A plate comes down on two spheres, one of which rises, and a cylinder; a block comes down on the plate."""
    plate = tc.box_mesh((1, 1, 0.5), (4, 4, 3), origin=(-0.5, -0.5, 0.51)).rotated(((0, 0, 1), np.radians(11.0)))
    block = tc.box_mesh((0.8, 0.8, 0.5), (3, 3, 3), origin=(-0.35, -0.4, 1.02))
    bodies = [
        tc.Body(plate, soft(), (0, 0, -0.04), contact=("zmin", "zmax"), name="plate"),
        tc.Body(block, soft(), (0.03, 0, -0.08), contact="zmin", name="block"),
    ]
    obstacles = [
        tc.Sphere((-0.4, -0.3, 0), 0.5, name="left"),
        tc.Sphere((0.4, 0.35, 0), 0.5, velocity=(0, 0, 0.01), name="rising"),
        tc.Cylinder((0.45, -0.35, 0), (1, 0.2, 0), 0.5, name="rod"),
    ]
    result = tc.simulate(tc.Scene(bodies, obstacles, 4.0))
    assert result.ok
    loads = [result.obstacle_force[obstacle.name] for obstacle in obstacles]
    assert max(load[:, 2].max() for load in loads) <= 1e-15
    assert all(load[:, 2].min() < -0.003 for load in loads)
    assert np.abs(sum(loads) + result.history["contact_force"]).max() <= 1e-14
    assert result.pair_force["plate-block"][:, 2].min() < -0.01
    assert np.abs(result.history["energy_error"]).max() <= 1.5e-2


@pytest.mark.slow
def test_a_stack_between_floor_and_a_falling_lid_loses_normal_mass_alone():
    """All normals share one direction; a row of a wall at every node beside that of a pair, of which one can press."""
    sizes = {
        "top": ((0.9, 0.9, 0.4), (4, 4, 2), 2.02),
        "mid": ((1, 1, 1), (3, 3, 3), 1.012),
        "low": ((1.1, 1.1, 1), (4, 4, 3), 0.005),
    }
    bodies = [
        tc.Body(tc.box_mesh(size, cells, origin=(-0.5 * size[0], -0.5 * size[1], height)), soft(), (0, 0, -0.02),
                contact="zmin" if name == "top" else ("zmin", "zmax"), name=name)
        for name, (size, cells, height) in sizes.items()
    ]  # fmt: skip
    walls = [tc.Plane(name="floor"), tc.Plane((0, 0, 3.4), (0, 0, -1), velocity=(0, 0, -0.02), name="lid")]
    scene = tc.Scene(bodies, walls, 8.0)
    assert tc.plan(scene).bodies[0].contact.removal == "normal"
    result = tc.simulate(scene)
    assert result.ok
    assert -result.obstacle_force["floor"][:, 2].min() > 0.005
    assert np.abs(result.history["energy_error"]).max() <= 1.5e-2
    assert result.history["static_residual"].max() <= 1e-3
