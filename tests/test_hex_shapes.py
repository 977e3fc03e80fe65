"""Hexahedra that are boxes or parallelepipeds: the plan's choice, and forces equal to those of cells of any shape."""

import numpy as np
import pytest
from force_pass import Step, block, numpy_force

import tcontact as tc
from tcontact.device import runtime

SHEAR = np.array([[1.0, 0.1, 0.0], [0.2, 1.1, 0.1], [0.0, -0.1, 0.9]])
TURN = np.array([[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
CYCLED = [0, 3, 7, 4, 1, 2, 6, 5]  # the same cell with r1, r2, r3 along y, z, x
NAMES = ("hex8", "hex8-affine", "hex8-box")


@pytest.fixture(autouse=True)
def _runtime():
    runtime.start("cpu", 2)


def graded(scale=(1.0, 1.0, 1.0), seed=0):
    """Nodes and cells of boxes along the axes with edges of many lengths, coordinates of a plane the same bits."""
    nodes, cells, _ = block("hex8", distortion=0.0)
    random = np.random.default_rng(seed)
    planes = [np.cumsum(random.uniform(0.4, 1.6, 4)) for _ in range(3)]
    return np.stack([scale[c] * planes[c][nodes[:, c].astype(int)] for c in range(3)], axis=1), cells


def agree(one, other, bound):
    assert np.abs(one[0] - other[0]).max() <= bound * np.abs(other[0]).max()
    assert one[1] == pytest.approx(other[1], rel=10 * bound)
    assert one[2] == pytest.approx(other[2], rel=10 * bound)


@pytest.mark.parametrize("law", ["neo_hookean", "linear_elastic"])
def test_boxes_and_parallelepipeds_have_the_forces_of_any_cell(law):
    for scale in ((1.0, 1.0, 1.0), (1e-9, 2e-9, 1e-9), (3e5, 1e5, 1e5), (1.0, 1.0, 1e-3)):
        nodes, cells = graded(scale)
        u = 0.05 * min(scale) * np.random.default_rng(1).uniform(-1, 1, nodes.shape)
        exact = numpy_force("hex8", law, nodes, cells, u)
        found = [Step(name, law, nodes, cells).force(u) for name in NAMES]
        for one in found:
            agree(one, exact, 1e-13)
            agree(one, found[0], 1e-14)
        skew = nodes @ SHEAR
        sheared = [Step(name, law, skew, cells).force(u) for name in NAMES[:2]]
        agree(sheared[1], numpy_force("hex8", law, skew, cells, u), 1e-12)
        agree(*sheared, 1e-12 if min(scale) < 0.1 * max(scale) else 1e-14)


def test_forces_of_boxes_keep_their_digits_and_vanish_in_rigid_motion():
    nodes, cells = graded()
    step = Step("hex8-box", "neo_hookean", nodes, cells)
    u = 1e-9 * np.random.default_rng(1).uniform(-1, 1, nodes.shape)
    agree(step.force(u), Step("hex8", "linear_elastic", nodes, cells).force(u), 1e-7)
    moved = step.force(np.zeros_like(nodes) + np.array([1024.0, -512.0, 2048.0]))
    assert not moved[0].any()
    assert moved[1:] == (0.0, 1.0)
    turned = step.force(nodes @ TURN.T - nodes)
    assert np.abs(turned[0]).max() <= 1e-14 * 50
    assert abs(turned[1]) <= 1e-14


def test_flat_boxes_are_seen_as_inverted():
    nodes, cells = graded()
    step = Step("hex8-box", "neo_hookean", nodes, cells)
    for squeeze in (1.0, 1.5):
        force, energy, jacobian = step.force(-squeeze * nodes * np.array([0, 0, 1.0]))
        assert np.isfinite(force).all()
        assert np.isfinite(energy)
        assert jacobian == pytest.approx(1.0 - squeeze, abs=1e-12)


def variant(nodes, cells, formulation="full"):
    material = tc.NeoHookean(young=1e6, poisson=0.3, density=1e3)
    body = tc.Body(tc.Mesh(nodes, cells, "hex8"), material, formulation=formulation)
    return tc.plan(tc.Scene([body], duration=1e-3)).bodies[0].variant


def test_the_plan_takes_boxes_only_where_the_error_is_rounding():
    nodes, cells = graded()
    assert variant(nodes, cells) == "hex8-box"
    assert variant(nodes, cells, "mean-dilatation") == "hex8-mean-dilatation-box"
    assert variant(nodes, cells, "reduced") == "hex8-reduced-affine"
    assert variant(nodes * 1e-9 + 1e-9, cells) == "hex8-box"
    assert variant(nodes + np.array([1e6, -1e7, 1e4]), cells) == "hex8-box"  # planes stay planes, rounded or not
    assert variant(nodes @ SHEAR, cells) == "hex8-affine"
    assert variant(nodes @ TURN, cells) == "hex8-affine"
    assert variant(nodes, cells[:, CYCLED]) == "hex8-affine"
    flat = nodes * np.array([1.0, 1.0, 1e-4])
    assert variant(flat, cells) == "hex8-box"
    for axis, other in ((0, 2), (2, 0)):  # an error small beside the longest edge turns the shortest
        bent = flat.copy()
        bent[:, axis] += 1e-12 * flat[:, other]
        bent[cells[0, 6], axis] += 1e-13
        assert "box" not in variant(bent, cells)
    bent = nodes.copy()
    bent[cells[3, 6], 1] += 1e-9
    assert variant(bent, cells) == "hex8"


@pytest.mark.parametrize("flatness", [1.0, 1e-2, 1e-3, 1e-4])
def test_the_force_of_the_variant_of_bent_flat_cells_is_that_of_any_cell(flatness):
    """To 1e-9: the corners of turned plates are moved by less and less until the plan calls them parallelepipeds."""
    nodes, cells = graded((1.0, 1.0, flatness))
    random = np.random.default_rng(0)
    u = 0.05 * flatness * random.uniform(-1, 1, nodes.shape)
    away, seen = random.uniform(-1, 1, nodes.shape), set()
    for size in (1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14, 0.0):
        bent = nodes @ TURN.T[:, [2, 0, 1]] + size * away
        name = variant(bent, cells)
        seen.add(name)
        agree(Step(name, "neo_hookean", bent, cells).force(u), Step("hex8", "neo_hookean", bent, cells).force(u), 1e-9)
    assert seen == {"hex8", "hex8-affine"}


def test_a_run_of_boxes_is_that_of_the_same_cells_with_their_corners_turned():
    """The plan takes the kernel of boxes for the one and that of parallelepipeds for the other."""
    nodes, cells = graded()
    material = tc.NeoHookean(young=1e6, poisson=0.3, density=1e3)
    runs = []
    for own in (cells, cells[:, CYCLED]):
        body = tc.Body(tc.Mesh(nodes, own, "hex8"), material, lambda x: 0.5 * np.sin(x[:, [1, 2, 0]]))
        runs.append(tc.simulate(tc.Scene([body], duration=0.2)))
    assert runs[0].steps == runs[1].steps
    for column in ("elastic", "kinetic", "energy"):
        one, other = (run.history[column] for run in runs)
        assert one.shape == other.shape
        assert np.abs(one - other).max() <= 1e-10 * np.abs(other).max()
    errors = [run.history["energy_error"].max() for run in runs]
    assert errors[0] == pytest.approx(errors[1], rel=1e-6)


def test_description_names_the_boxes():
    body = tc.Body(tc.box_mesh((1, 1, 1), (2, 2, 2)), tc.NeoHookean(young=1e6, poisson=0.3, density=1e3))
    assert "boxes along the axes" in tc.plan(tc.Scene([body], duration=1.0)).describe()
