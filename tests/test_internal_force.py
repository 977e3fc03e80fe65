"""The step kernel: force against numpy and energy, rigid motion, patches, leapfrog, sums, logarithm, same bits."""

import subprocess
import sys
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from force_pass import KINDS, LAM, LAWS, MODULI, MU, Step, block, law_energy_stress, numpy_force
from scenes import python

from tcontact.device import runtime
from tcontact.kernels import lanes
from tcontact.kernels.columns import NODE_SUMS


def both(law, kind):
    nodes, cells, _ = block(kind)
    u = 0.1 * np.random.default_rng(1).uniform(-1, 1, nodes.shape)
    return nodes, cells, u, Step(kind, law, nodes, cells)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("law", LAWS)
def test_force_and_energy_match_numpy_and_each_other(kind, law):
    nodes, cells, u, step = both(law, kind)
    force, energy, jacobian = step.force(u)
    exact, exact_energy, exact_jacobian = numpy_force(kind, law, nodes, cells, u)
    assert np.abs(force - exact).max() <= 1e-13 * np.abs(exact).max()
    assert energy == pytest.approx(exact_energy, rel=1e-13)
    assert jacobian == pytest.approx(exact_jacobian, rel=1e-13)
    way = np.random.default_rng(3).uniform(-1, 1, u.shape)
    slope = (step.force(u + 1e-5 * way)[1] - step.force(u - 1e-5 * way)[1]) / 2e-5
    assert slope == pytest.approx(np.sum(force * way), rel=1e-8)


LONG = {("hex8", "st_venant_kirchhoff"), ("hex8", "mooney_rivlin")}  # to compile; tetrahedra have the same laws


@pytest.mark.parametrize(
    ("kind", "law"),
    [pytest.param(*one, marks=[pytest.mark.slow] * (one in LONG)) for one in product(KINDS[:2], LAWS)],
)
def test_plain_kernel_adds_the_same_force(kind, law):
    from tcontact.kernels.cells.plain_force import make_plain_force

    nodes, cells, u, _step = both(law, kind)
    force = np.ones(u.size)
    params = np.array([0.0] * lanes.MATERIALS + [*MODULI.get(law, (LAM, MU))])
    connectivity = cells.astype(np.int32).ravel()
    make_plain_force(kind, law)(connectivity, nodes.ravel().copy(), params, u.ravel().copy(), force)
    exact = numpy_force(kind, law, nodes, cells, u)[0]
    assert np.abs(force.reshape(-1, 3) - 1.0 - exact).max() <= 1e-13


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("law", LAWS)
def test_rigid_motion_gives_no_force(kind, law):
    nodes, _cells, _, step = both(law, kind)
    moved = np.zeros_like(nodes) + np.array([1024.0, -512.0, 2048.0])  # no rounding: the differences are exactly zero
    force, energy, jacobian = step.force(moved)
    assert not force.any()
    assert energy == 0.0
    assert jacobian == 1.0
    assert np.abs(step.force(np.zeros_like(nodes) + np.array([0.3, -7.1, 1e3]))[0]).max() <= 1e-12
    if law != "linear_elastic":
        turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
        turn *= np.linalg.det(turn)
        force, energy, jacobian = step.force(nodes @ turn.T - nodes)
        assert np.abs(force).max() <= 1e-14 * 50
        assert abs(energy) <= 1e-14
        assert jacobian == pytest.approx(1.0, abs=1e-13)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("law", LAWS)
def test_patch_of_distorted_cells_carries_a_uniform_strain(kind, law):
    nodes, cells, inner = block(kind, (3, 3, 3), 0.25)
    gradient = 0.2 * np.random.default_rng(6).uniform(-1, 1, (3, 3))
    force, energy, jacobian = Step(kind, law, nodes, cells).force(nodes @ gradient.T)
    assert np.abs(force[inner]).max() <= 1e-14
    assert np.abs(force).max() > 1e-2
    volume = numpy_force(kind, "linear_elastic", nodes, cells, nodes * 0.0 + nodes @ np.diag([1.0, 0, 0]))[1]
    volume /= law_energy_stress("linear_elastic", np.diag([1.0, 0.0, 0.0]))[0]
    assert energy == pytest.approx(volume * law_energy_stress(law, gradient)[0], rel=1e-13)
    assert jacobian == pytest.approx(np.linalg.det(np.eye(3) + gradient), rel=1e-13)


@pytest.mark.parametrize("kind", KINDS)
def test_tiny_strain_keeps_its_digits(kind):
    """At strain 1e-9 every law is linear elasticity to 2e-8 in force and energy, rounding of det F or not."""
    nodes, cells, u, linear = both("linear_elastic", kind)
    force, energy, _ = linear.force(1e-8 * u)
    assert energy > 0
    for law in LAWS[1:]:
        other, other_energy, _ = Step(kind, law, nodes, cells).force(1e-8 * u)
        assert np.abs(other - force).max() <= 2e-8 * np.abs(force).max()
        assert other_energy == pytest.approx(energy, rel=2e-8)


@pytest.mark.parametrize("kind", KINDS)
def test_inverted_and_flat_cells_give_finite_numbers_and_are_seen(kind):
    nodes, _cells, _, step = both("neo_hookean", kind)
    for squeeze in (1.0, 1.5, 3.0):  # flat, inverted, inverted and stretched
        force, energy, jacobian = step.force(-squeeze * nodes * np.array([0, 0, 1.0]))
        assert np.isfinite(force).all()
        assert np.isfinite(energy)
        assert jacobian == pytest.approx(1.0 - squeeze, abs=1e-12)


TWO_KINDS = [("hex8", "neo_hookean", "tet4", "mooney_rivlin"), ("wedge6", "linear_elastic", "hex8", "neo_hookean")]


@pytest.mark.parametrize(("kind", "law", "other", "other_law"), TWO_KINDS)
def test_two_kinds_of_cells_in_one_pass_match_numpy(kind, law, other, other_law):
    """Cells of two kinds and laws, among them contact cells of both, whose corner forces stay in rows of their own."""
    nodes, cells, _ = block(kind, (3, 2, 4))
    _, cells_of_other, _ = block(other, (3, 2, 4))
    half = [len(one) // 2 for one in (cells, cells_of_other)]
    parts = [cells[: half[0]], cells_of_other[half[1] :]]
    contact = [5, 3]
    boundary = np.unique(np.concatenate([part[-count:].ravel() for part, count in zip(parts, contact, strict=True)]))
    boundary = np.random.default_rng(7).permutation(boundary)
    step = Step.of_blocks(
        [(kind, law, parts[0], contact[0]), (other, other_law, parts[1], contact[1])], nodes, boundary
    )
    u, v = 0.1 * np.random.default_rng(1).uniform(-1, 1, nodes.shape), np.zeros(nodes.size)
    first, second = numpy_force(kind, law, nodes, parts[0], u), numpy_force(other, other_law, nodes, parts[1], u)
    force, energy = first[0] + second[0], first[1] + second[1]
    jacobians = [one[2] for one, name in ((first, law), (second, other_law)) if name != "linear_elastic"]
    kept = u.ravel().copy()
    step(kept, v)
    assert kept.tobytes() == u.tobytes()
    ordinary = np.setdiff1d(np.arange(len(nodes)), boundary)
    found = -v.reshape(-1, 3) * step.mass[:, None]
    largest = np.abs(force).max()
    assert np.abs(found - force)[ordinary].max() <= 1e-13 * largest
    assert not found[boundary].any()
    assert np.abs(step.special_force.reshape(-1, 3) - force[boundary]).max() <= 1e-13 * largest
    sums = step.sums()
    assert sums[0] == pytest.approx(energy, rel=1e-13)
    assert sums[1] == pytest.approx(min(jacobians), rel=1e-13)  # beside others the linear law has no limit
    starts = np.cumsum([0, *(count * part.shape[1] for part, count in zip(parts, contact, strict=True))])
    for number, (part, count) in enumerate(zip(parts, contact, strict=True)):
        own = numpy_corners([(kind, law), (other, other_law)][number], nodes, part[-count:], u)
        rows = step.rows.reshape(-1, 3)[step.packs.corners[starts[number] : starts[number + 1]]]
        assert np.abs(rows - own.reshape(-1, 3)).max() <= 1e-13 * largest
    v[:] = 0.0
    step(kept, v, free=1.0)  # a product: every node is an ordinary one
    assert np.abs(-v.reshape(-1, 3) * step.mass[:, None] - force).max() <= 1e-13 * largest


def numpy_corners(cell, nodes, cells, u):
    """Corner forces [m, corners, 3] of every cell by itself."""
    return np.array([numpy_force(*cell, nodes, one[None], u)[0][one] for one in cells])


@pytest.mark.parametrize("counts", [(1, 1, 1), (2, 1, 1), (1, 1, 33)])
@pytest.mark.parametrize("chunks", [1, 8, 31])
def test_few_cells_and_any_chunks(counts, chunks):
    for kind in KINDS:
        nodes, cells, _ = block(kind, counts)
        u = 0.05 * np.random.default_rng(1).uniform(-1, 1, nodes.shape)
        nodes, u = np.vstack((nodes, [[9, 9, 9]])), np.vstack((u, [[1, 1, 1]]))  # a node without cells
        force, energy, _ = Step(kind, "neo_hookean", nodes, cells, chunks=chunks).force(u)
        exact, exact_energy, _ = numpy_force(kind, "neo_hookean", nodes, cells, u)
        assert np.abs(force - exact).max() <= 1e-14
        assert energy == pytest.approx(exact_energy, rel=1e-12)


def test_leapfrog_moves_ordinary_nodes_and_sums_their_ledger():
    kind, law = "tet4", "neo_hookean"
    nodes, cells, _ = block(kind)
    boundary = [5, 0, 17]
    step = Step(kind, law, nodes, cells, boundary)
    rng = np.random.default_rng(8)
    u, v = 0.1 * rng.uniform(-1, 1, nodes.shape), rng.uniform(-1, 1, nodes.shape)
    gravity = np.array([0.3, -0.2, -9.81])
    force = numpy_force(kind, law, nodes, cells, u)[0]
    ordinary = np.setdiff1d(np.arange(len(nodes)), boundary)
    m = step.mass[ordinary, None]
    acceleration = gravity - force[ordinary] / m
    flat_u, flat_v = u.ravel().copy(), v.ravel().copy()
    step(flat_u, flat_v, 0.013, 0.017, 0.03, gravity)
    middle = v[ordinary] + 0.013 * acceleration
    after = middle + 0.017 * acceleration
    moved_u, moved_v = flat_u.reshape(-1, 3), flat_v.reshape(-1, 3)
    assert np.abs(moved_v[ordinary] - after).max() <= 1e-14
    assert np.abs(moved_u[ordinary] - u[ordinary] - 0.03 * after).max() <= 1e-15
    assert np.array_equal(moved_u[boundary], u[boundary])
    assert np.array_equal(moved_v[boundary], v[boundary])
    assert np.abs(step.special_force.reshape(-1, 3) - force[boundary]).max() <= 1e-14
    sums = step.node_sums.reshape(-1, NODE_SUMS).sum(axis=0)
    expected = np.concatenate(
        (
            [0.5 * np.sum(m * middle**2)],
            np.sum(m * middle, axis=0),
            np.sum(m * np.cross((nodes + u)[ordinary], middle), axis=0),
            np.sum(m * u[ordinary], axis=0),
        )
    )
    assert sums == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_without_drift_displacement_keeps_its_bits_even_the_sign_of_zero():
    nodes, cells, _ = block("tet4", (1, 1, 1))
    step = Step("tet4", "linear_elastic", nodes, cells)
    u = np.where(np.random.default_rng(0).uniform(size=nodes.size) < 0.5, -0.0, 1e-300)
    before = u.tobytes()
    step(u, np.full(u.size, np.nan))
    assert u.tobytes() == before


def test_logarithm_is_exact_to_the_last_digits():
    """e - ln(1+e) = e^2/2 - e^3/3 .. for small e, and against long double elsewhere; 1/(1+e) too."""
    import taichi as ti

    from tcontact.kernels.language.transcendental import log_split

    @ti.kernel
    def split(change: ti.types.ndarray(), excess_out: ti.types.ndarray(), inverse_out: ti.types.ndarray()):
        for i in range(change.shape[0]):
            answer = log_split(change[i])
            excess_out[i] = answer[0]
            inverse_out[i] = answer[1]

    jacobian = np.concatenate(
        (np.linspace(0.2, 5.0, 100001), np.geomspace(1e-9, 1e9, 20001), 2.0 ** np.arange(-20, 20))
    )
    tiny = np.geomspace(1e-18, 1e-3, 2001)
    change = np.concatenate((jacobian - 1.0, tiny, -tiny, [0.0, -1.0, -5.0]))
    excess, inverse = np.zeros_like(change), np.zeros_like(change)
    split(change, excess, inverse)
    assert np.isfinite(excess).all()
    assert np.isfinite(inverse).all()
    wide = change[:-3].astype(np.longdouble)
    logarithm = np.log1p(wide)
    error = np.abs((wide - excess[:-3]) - logarithm)
    assert np.max((error / np.maximum(np.abs(excess[:-3]), 1.0))[:100001]) < 4e-16  # J from 0.2 to 5
    assert np.max(error / np.maximum(np.abs(excess[:-3]), 1.0)) < 1e-15
    assert np.max(np.abs(inverse[:-3] * (1.0 + wide) - 1.0)) < 1e-15
    small = (np.abs(wide) < 1e-3) & (wide != 0)
    wide = wide[small]
    series = wide**2 / 2 - wide**3 / 3 + wide**4 / 4 - wide**5 / 5 + wide**6 / 6
    assert np.max(np.abs(excess[:-3][small] / series - 1.0)) < 1e-14
    assert excess[-3] == 0.0


VECTORS = """
import sys
import numpy as np
import taichi as ti
sys.path[:0] = [{root!r}, {tests!r}]
ti.init(ti.cpu, default_fp=ti.f64, fast_math=False, offline_cache=False, print_kernel_llvm_ir_optimized=True)
import force_pass as t
nodes, cells, _ = t.block("tet4")
t.Step("tet4", "neo_hookean", nodes, cells).force(nodes * 0.1)
assert ti.cfg.real_matrix_scalarize
"""


def test_lanes_reach_the_machine_as_vectors(tmp_path):
    """Split into scalars the kernel gives the same numbers at a third of the speed: look at the code instead.

    What is done for single nodes stays scalar, more or less of it by the processor; split, it has 957 products and none
    of vectors.
    """
    tests = Path(__file__).resolve().parent
    code = VECTORS.format(root=str(tests.parent), tests=str(tests))
    run = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    written = "".join(path.read_text() for path in tmp_path.glob("*.ll"))
    whole, split = written.count("fmul <8 x double>"), written.count("fmul double")
    assert whole > 100
    assert split < 0.5 * whole


def bits():
    """What twenty steps leave, number by number."""
    found = []
    for kind in KINDS:
        nodes, cells, _ = block(kind, (9, 7, 8))
        step = Step(kind, "neo_hookean", nodes, cells, [3, 99])
        rng = np.random.default_rng(0)
        u, v = 0.1 * rng.uniform(-1, 1, nodes.size), rng.uniform(-1, 1, nodes.size)
        for _ in range(20):
            step(u, v, 1e-3, 1e-3, 2e-3, (0, 0, -1.0))
        found += [a.tobytes().hex() for a in (u, v, step.node_sums, step.cell_sums, step.special_force)]
    return found


def test_one_and_two_threads_give_the_same_bits():
    assert runtime.threads() == 2
    code = "from tcontact.device import runtime; runtime.start(threads=1); import test_internal_force as t"
    done = python(code + "\nprint(*t.bits(), sep=chr(10))")
    assert done.returncode == 0, done.stderr[-2000:]
    answers = done.stdout.splitlines()[-5 * len(KINDS) :]
    assert answers == bits()
