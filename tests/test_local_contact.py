"""The contact problem of one node against a quadratic program solved by brute force.

min 1/2 d.D d - r.d   with   g_p + n_p.d + e lambda_p >= 0,  lambda_p >= 0,  complementary
"""

import functools
from itertools import product

import numpy as np
import pytest
import taichi as ti
from scipy.optimize import nnls

from tcontact.kernels.contact.local_contact import multipliers
from tcontact.kernels.language.arguments import ARRAY


@functools.cache
def make_all(block, slots):
    @ti.kernel
    def solve_all(free: ARRAY, normals: ARRAY, gaps: ARRAY, inverse: ARRAY, compliance: ARRAY, out: ARRAY):
        for k in range(compliance.shape[0]):
            d = ti.Vector([free[k * block + j] for j in ti.static(range(block))])
            n = ti.Matrix(
                [
                    [normals[(k * slots + p) * block + j] for j in ti.static(range(block))]
                    for p in ti.static(range(slots))
                ]
            )
            g = ti.Vector([gaps[k * slots + p] for p in ti.static(range(slots))])
            w = ti.Matrix(
                [
                    [inverse[(k * block + i) * block + j] for j in ti.static(range(block))]
                    for i in ti.static(range(block))
                ]
            )
            found = multipliers(d, n, g, w, compliance[k], slots)
            for p in ti.static(range(slots)):
                out[k * slots + p] = found[p]

    return solve_all


def solve(free, normals, gaps, inverse, compliance):
    """lambda [count, slots] by the kernel."""
    count, slots, block = normals.shape
    out = np.zeros(count * slots)
    flat = [np.ascontiguousarray(a, dtype=float).reshape(-1) for a in (free, normals, gaps, inverse, compliance)]
    make_all(block, slots)(*flat, out)
    return out.reshape(count, slots)


def brute(free, normals, gaps, inverse, compliance):
    """lambda by numpy: the feasible active set of least potential, least-norm where normals depend."""
    slots = len(gaps)
    coupling = normals @ inverse @ normals.T + compliance * np.eye(slots)
    start = gaps + normals @ free
    tolerance = 1e-11 * max(1.0, np.abs(start).max())
    best, least = None, np.inf
    for choice in product((False, True), repeat=slots):
        on = np.array(choice)
        trial = np.zeros(slots)
        if on.any():
            trial[on] = np.linalg.lstsq(coupling[np.ix_(on, on)], -start[on], rcond=1e-11)[0]
        if (trial >= -tolerance).all() and (start + coupling @ trial >= -tolerance).all():
            value = trial @ (coupling @ trial / 2 + start)
            if value < least - 1e-10:
                best, least = trial, value
    return best


def problems(block, slots, count, seed, soft):
    generator = np.random.default_rng(seed)
    root = generator.normal(size=(count, block, block))
    stiffness = root @ np.swapaxes(root, 1, 2) + 0.3 * np.eye(block)
    inverse = np.linalg.inv(stiffness)
    free = generator.normal(size=(count, block))
    normals = generator.normal(size=(count, slots, block))
    while True:  # walls well apart: what depends has tests of its own
        normals /= np.linalg.norm(normals, axis=2)[..., None]
        close = np.linalg.svd(normals, compute_uv=False)[:, min(slots, block) - 1] < 0.2
        if not close.any():
            break
        normals[close] = generator.normal(size=(int(close.sum()), slots, block))
    gaps = generator.normal(scale=0.7, size=(count, slots))
    compliance = generator.uniform(0.01, 2.0, count) if soft else np.zeros(count)
    return free, normals, gaps, inverse, compliance


@pytest.mark.parametrize("soft", [False, True], ids=["exact", "penalty"])
@pytest.mark.parametrize("slots", [1, 2, 3])
@pytest.mark.parametrize("block", [1, 3])
def test_random_nodes_against_brute_force(block, slots, soft):
    count = 300
    data = problems(block, slots, count, 10 * block + slots, soft)
    free, normals, gaps, inverse, compliance = data
    if block == 1:
        normals = np.abs(normals)  # in one component opposite walls may leave no solution
        data = free, normals, gaps, inverse, compliance
    found = solve(*data)
    counts = set()
    for k in range(count):
        wanted = brute(*(array[k] for array in data))
        assert wanted is not None
        # the move is unique even where multipliers are not
        assert np.allclose(normals[k].T @ found[k], normals[k].T @ wanted, rtol=1e-8, atol=1e-9)
        assert (found[k] >= 0.0).all()
        moved = free[k] + inverse[k] @ normals[k].T @ found[k]
        apart = gaps[k] + normals[k] @ moved + compliance[k] * found[k]
        assert apart.min() >= -1e-9
        assert np.abs(apart * found[k]).max() <= 1e-8 * (1.0 + np.abs(found[k]).max())
        counts.add(int((wanted > 1e-9).sum()))
    assert counts >= set(range(min(slots, block) + 1)), "every number of active walls occurs"


def test_the_potential_is_least():
    """No other admissible move does better: nonnegative least squares on the dual, an independent algorithm."""
    free, normals, gaps, inverse, compliance = problems(3, 3, 200, 77, False)
    found = solve(free, normals, gaps, inverse, compliance)
    for k in range(200):
        root = np.linalg.cholesky(inverse[k])
        slant = root.T @ normals[k].T  # [3, slots], coupling = slant^t slant
        start = gaps[k] + normals[k] @ free[k]
        target = np.linalg.lstsq(slant.T, -start, rcond=None)[0]
        dual, _ = nnls(slant, target)
        assert np.allclose(found[k], dual, rtol=1e-7, atol=1e-8)


def repeated(slots):
    """Multipliers of one wall, and of the same wall named several times."""
    free, normals, gaps, inverse, compliance = problems(3, 1, 100, 5, False)
    one = solve(free, normals, gaps, inverse, compliance)
    many = solve(free, np.repeat(normals, slots, axis=1), np.repeat(gaps, slots, axis=1), inverse, compliance)
    assert (one > 0.0).any()
    return one[:, 0], many


@pytest.mark.parametrize("slots", [2, 3])
def test_a_wall_named_several_times_pushes_as_one(slots):
    one, many = repeated(slots)
    assert (many >= 0.0).all()
    assert np.allclose(many.sum(axis=1), one, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("slots", [2, 3])
def test_equal_walls_share_the_load(slots):
    """The least-norm multipliers are equal."""
    one, many = repeated(slots)
    assert np.allclose(many, one[:, None] / slots, rtol=1e-3, atol=1e-9)


def test_three_walls_through_one_line_take_the_least_norm():
    """Normals in one plane depend on each other: the move is unique, the multipliers the smallest ones."""
    angles = np.radians([30.0, 90.0, 150.0])
    normals = np.stack([np.cos(angles), np.zeros(3), np.sin(angles)], axis=1)
    free = np.array([0.1, 0.4, -1.0])
    found = solve(free[None], normals[None], np.zeros((1, 3)), np.eye(3)[None], np.zeros(1))[0]
    moved = free + normals.T @ found
    assert np.allclose(moved, [0.0, 0.4, 0.0], atol=1e-10)  # down in the groove
    wanted = np.linalg.pinv(normals.T) @ (moved - free)
    assert (wanted > 0.0).all()
    assert np.allclose(found, wanted, rtol=1e-2)


def test_a_wall_out_of_reach_never_pushes():
    """A zero normal with an open gap stands for a wall that the node cannot move towards."""
    free, normals, gaps, inverse, compliance = problems(3, 2, 50, 8, False)
    normals[:, 1], gaps[:, 1] = 0.0, 1.0
    found = solve(free, normals, gaps, inverse, compliance)
    assert not found[:, 1].any()
    assert np.allclose(found[:, :1], solve(free, normals[:, :1], gaps[:, :1], inverse, compliance), rtol=1e-10)


def assert_optimal(data, found, count):
    """The conditions of optimality of every node in long double, relative to the penetration of the free motion."""
    free, normals, gaps, inverse, compliance = (np.asarray(array, dtype=np.longdouble) for array in data)
    active = set()
    for k in range(count):
        moved = free[k] + inverse[k] @ normals[k].T @ found[k]
        start = gaps[k] + normals[k] @ free[k]
        span = np.maximum(-start, 0.0).max()
        apart = gaps[k] + normals[k] @ moved + compliance[k] * found[k]
        weight = np.einsum("pi,ij,pj->p", normals[k], inverse[k], normals[k]) + compliance[k]
        rounding = 1e-14 * (np.abs(gaps[k]) + np.abs(normals[k] @ free[k]) + np.abs(found[k] * weight).max())
        assert (found[k] >= 0.0).all()
        assert (apart >= -1e-9 * span - rounding).all(), k
        assert (np.where(found[k] > 0.0, np.abs(apart), 0.0) <= 1e-9 * span + rounding).all(), k
        active.add(int((found[k] > 0.0).sum()))
    return active


@pytest.mark.parametrize("soft", [False, True], ids=["exact", "penalty"])
@pytest.mark.parametrize("slots", [2, 3])
def test_gaps_of_every_size(slots, soft):
    """Gaps, motions and penetrations from 1e-12 to 1e3 at the same node: the largest one is no measure of the rest."""
    count = 400
    free, normals, gaps, inverse, compliance = problems(3, slots, count, 30 + slots, soft)
    generator = np.random.default_rng(slots)
    free *= 10.0 ** generator.uniform(-12.0, 0.0, count)[:, None]
    gaps = np.abs(gaps) * 10.0 ** generator.uniform(-12.0, 3.0, gaps.shape)
    data = free, normals, gaps, inverse, compliance
    assert assert_optimal(data, solve(*data), count) >= {0, 1, 2}


@pytest.mark.parametrize("slots", [2, 3])
def test_normals_that_nearly_depend_on_each_other(slots):
    """Walls at angles from 1e-9 to 1e-1, both leaning apart and facing each other: creases, and slits that taper."""
    count = 400
    free, normals, gaps, inverse, compliance = problems(3, slots, count, 50 + slots, False)
    generator = np.random.default_rng(slots)
    lean = 10.0 ** generator.uniform(-9.0, -1.0, count)[:, None]
    normals[:, 1] = normals[:, 0] + lean * normals[:, 1]
    normals[: count // 4, 1] *= -1.0
    normals[:, 1] /= np.linalg.norm(normals[:, 1], axis=1)[:, None]
    gaps[:, 1] = gaps[:, 0] + lean[:, 0] * generator.normal(size=count)
    gaps[: count // 4, 1] = np.abs(gaps[: count // 4, 0]) + 3.0 + np.abs(free[: count // 4]).sum(axis=1)
    for k in range(count // 2, count):  # both push
        wanted = np.concatenate([generator.uniform(0.1, 1.0, 2), np.zeros(slots - 2)])
        meets = normals[k] @ free[k] + normals[k] @ inverse[k] @ normals[k].T @ wanted
        gaps[k] = np.concatenate([np.zeros(2), np.ones(slots - 2)]) - meets
    data = free, normals, gaps, inverse, compliance
    assert assert_optimal(data, solve(*data), count) >= {0, 1, 2}


@pytest.mark.parametrize("place", [0, 1, 2])
def test_an_obstacle_out_of_reach_changes_not_a_bit(place):
    free, normals, gaps, inverse, compliance = problems(3, 2, 400, 61, False)
    few = solve(free * 1e-6, normals, gaps * 1e-6, inverse, compliance)
    far = np.random.default_rng(9).normal(size=(400, 3))
    far /= np.linalg.norm(far, axis=1)[:, None]
    many = solve(
        free * 1e-6, np.insert(normals, place, far, axis=1), np.insert(gaps * 1e-6, place, 100.0, axis=1), inverse,
        compliance,
    )  # fmt: skip
    assert (few > 0.0).all(axis=1).any()
    assert not many[:, place].any()
    assert np.array_equal(np.delete(many, place, axis=1), few)
