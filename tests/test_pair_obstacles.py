"""Bodies in contact with each other beside several obstacles: linear problems against dense ones, statics, impacts."""

import functools

import numpy as np
import taichi as ti
from scipy.optimize import nnls
from test_mprgp import graph_of, problem

from tcontact.kernels import pair_places as at
from tcontact.kernels.contact.islands import node_count
from tcontact.kernels.contact.pair_rows import collect
from tcontact.kernels.lanes import ISLAND, SWEEP_LANES
from tcontact.kernels.language.arguments import ARRAY, INDEX
from tcontact.kernels.language.bundles import Contact, ContactOptions, Coupling, Rows, System
from tcontact.kernels.language.compile_options import KEEP_VECTORS, LEAVE_TO_LLVM, compiled_with
from tcontact.kernels.node_places import PLACES
from tcontact.kernels.static import control as names
from tcontact.kernels.static.chosen_rows import choose_rows
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
    """Return whether every normal has a part of this size that is orthogonal to all others."""
    there = normals[normals.any(axis=1)]
    inverse = np.linalg.pinv(there)
    return len(there) <= 3 and (np.linalg.norm(inverse, axis=0) <= 1.0 / sine).all()


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
    islands[1] = count, len(order.pack_start) - 1, 0, count, 0
    lists, numbers = coupling_of(normals, weights)
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


def coupling_of(normals, weights):
    """Return `Coupling.lists` and `Coupling.values` with the rows of pairs; masters stand before their slaves."""
    slaves = np.flatnonzero(weights.any(axis=1))[::-1]  # the third body has none, the first one comes last
    first, masters = np.cumsum([0, *((weights[k] != 0.0).sum() for k in slaves)]), [np.flatnonzero(weights[k]) for k in slaves]
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
    # dependent rows leave half^t singular: the least squares problem of the dual is that of K^-1 all the same
    pressing = np.zeros(there.shape)
    pressing[there] = nnls(half, target, maxiter=100 * len(rows))[0]
    motion = free + np.linalg.solve(matrix, rows.T @ pressing[there])
    return motion.reshape(count, 3), pressing


def test_d():
    for seed in range(30):
        for sine in (0.5, 0.1):
            given = three_bodies(seed, sine=sine)
            graph, matrix, right, normals, gaps, weights = given
            motion, active, products = solved(*given)
            wanted, pressing = dense(*given[1:])
            g = gaps + (rows_of(normals, weights).reshape(normals.shape[0]*4, -1) @ wanted.ravel()).reshape(gaps.shape)
            print(seed, sine, np.abs(motion - wanted).max() / np.abs(wanted).max(), products, (pressing > 1e-9).sum(), active.sum(), g[normals.any(axis=2)].min(), (normals.any(axis=2).sum(axis=1)>1).sum(), len(right))
