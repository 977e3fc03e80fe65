"""Sets of nodes of periodic bodies name degrees of freedom: masses, forces, springs and probes count a node once."""

import numpy as np
import pytest
from scenes import material, simulate

import tcontact as tc

SIZE, COUNTS = np.array([0.04, 0.04, 0.02]), np.array([4, 3, 2])
TERMS = {
    "point mass": lambda name: {"point_masses": [tc.PointMass(name, 0.05)]},
    "force": lambda name: {"loads": [tc.Load(name, force=(0.0, 0.0, 500.0))]},
    "spring": lambda name: {"springs": [tc.Spring(name, 1e5, 20.0, axes="z")]},
    "spring along its line": lambda name: {"springs": [tc.Spring(name, 1e5, to=(0.02, 0.02, 0.05))]},
}


def slab(kind="hex8", periods=(1, 1), cut=(0, 0)):
    """A slab of some periods that is cut so many cells further along x and y; node sets of its top."""
    counts, step = COUNTS * [*periods, 1], SIZE / COUNTS
    mesh = tc.box_mesh(SIZE * [*periods, 1], counts, kind, origin=[*(cut * step[:2]), 0.0])
    x, y, z = np.round(mesh.nodes / step).astype(int).T
    top = z == COUNTS[2]
    first, last = (top & (x == cut[0] + n[0]) & (y == cut[1] + n[1]) for n in ((0, 0), counts[:2]))
    sets = {"top": top, "first": first, "last": last, "corners": first | last}
    sets |= {"row": top & (x % COUNTS[0] == 0), "low": top & (x == cut[0]), "high": top & (x == cut[0] + counts[0])}
    return mesh.with_sets({name: np.flatnonzero(here) for name, here in sets.items()})


@pytest.mark.parametrize("name", ["top", "zmax"])
@pytest.mark.parametrize("term", TERMS)
def test_uniform_data_stay_uniform(term, name):
    """What acts on the nodes of a face pulls all of them alike, and none aside."""
    mesh = slab()
    body = tc.Body(mesh, material(), (0, 0, 1.0), periodic="xy", supports=[tc.Support("zmin", "z")],
                   **TERMS[term](name))  # fmt: skip
    result = simulate(tc.Scene([body], duration=1e-4, contact=None), dt=2e-6)
    moved = result.position - mesh.nodes
    far = np.abs(moved).max()
    assert np.ptp(moved[mesh.node_sets["top"], 2]) <= 1e-12 * far
    assert np.abs(moved[:, :2]).max() <= 1e-12 * far


def uneven(nodes):
    """A velocity that differs from node to node and repeats in x and y."""
    x, y, z = 2 * np.pi * (nodes / SIZE).T
    return np.stack([0.3 * np.sin(x) + 0.2, 0.2 * np.cos(y + z), 0.5 * np.cos(x + y) - 1.0], axis=1)


QUANTITIES = ("displacement", "velocity", "acceleration", "stress", "von_mises")


def acted(name, share=1.0, **cut):
    """The history of a slab that falls on a plane, with everything on one set; share: of it in one period."""
    mesh = slab(**cut)
    body = tc.Body(mesh, material(), uneven, contact="zmin", periodic="xy",
                   point_masses=[tc.PointMass(name, 0.02 * share), tc.PointMass("zmin", 0.01 * share)],
                   loads=[tc.Load(name, force=lambda t: np.array([20.0, 0.0, -50.0]) * share)],
                   springs=[tc.Spring(name, 1e5 * share, 10.0 * share)],
                   probes=[tc.Probe(name, quantity) for quantity in QUANTITIES])  # fmt: skip
    scene = tc.Scene([body], [tc.Plane((0, 0, -1e-5))], 2e-4, contact=tc.MasslessContact("normal", tolerance=1e-12))
    return simulate(scene, dt=2e-6).history


def check_same(history, other, names=("", ""), share=1.0):
    """Check that all forces, sums and probes of two runs agree, to rounding; names: of the sets of the probes."""
    columns = [name for name in history if name.startswith("probe")]
    assert len(columns) == len(QUANTITIES)
    for column in columns:
        there = other[column.replace(*names)] if names[0] else other[column]
        assert np.abs(there - history[column]).max() <= 1e-8 * np.abs(history[column]).max(), column
    for column in ("contact_force", "momentum", "kinetic", "elastic", "applied_work", "spring_force", "spring_work"):
        name = next(one for one in history if one.startswith(column))
        there = other[next(one for one in other if one.startswith(column))]
        scale = np.abs(history[name]).max()
        assert scale > 0.0, column
        assert np.abs(there / share - history[name]).max() <= 1e-8 * scale, column


@pytest.mark.parametrize("name", ["top", "row"])
@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_nothing_depends_on_where_the_body_is_cut_or_how_often_it_is_repeated(kind, name):
    if kind == "tet4":  # whose diagonals need not repeat with the period of cells
        other, share = {"periods": (2, 1)}, 2.0
        check_same(acted(name, kind=kind), acted(name, share, kind=kind, **other), share=share)
        return
    one = acted(name)
    check_same(one, acted(name, 2.0, periods=(1, 2)), share=2.0)
    if name == "top":
        check_same(one, acted(name, cut=(1, 2)))


@pytest.mark.parametrize(("one", "other"), [("first", "last"), ("first", "corners"), ("low", "high")])
def test_a_node_may_be_named_by_any_of_its_images(one, other):
    check_same(acted(one), acted(other), (one, other))


def test_positions_are_those_of_the_first_images():
    probes = [tc.Probe(name, quantity) for name in ("low", "high") for quantity in ("position", "displacement")]
    mesh = slab()
    body = tc.Body(mesh, material(), uneven, periodic="xy", probes=probes, name="b")
    found = simulate(tc.Scene([body], duration=2e-5, contact=None), dt=2e-6).probes
    assert np.array_equal(found["b_low_position"], found["b_high_position"])
    step = SIZE / COUNTS
    middle = [0.0, 0.5 * (SIZE[1] - step[1]), SIZE[2]]
    assert found["b_low_position"] - found["b_low_displacement"] == pytest.approx(np.tile(middle, (11, 1)), abs=1e-15)


def test_point_masses_keep_their_sum_and_weigh_all_images_of_a_node():
    """Redistribution takes the share of a contact node from the cells at all of its images."""
    bare, loaded = (
        tc.plan(tc.Scene([tc.Body(slab(), material(), contact="zmin", periodic="xy", point_masses=masses)],
                         [tc.Plane((0, 0, -1e-5))], 1e-3)).bodies[0]
        for masses in ((), [tc.PointMass("zmin", 0.5)])
    )  # fmt: skip
    assert loaded.lumped.sum() == pytest.approx(bare.lumped.sum() + 0.5, rel=1e-13)
    added = bare.images.total(loaded.lumped - bare.lumped)[loaded.contact.nodes]
    assert added == pytest.approx(0.5 / (COUNTS[0] * COUNTS[1]), rel=1e-12)
    layer = np.isclose(loaded.reference[loaded.boundary, 2], SIZE[2] / COUNTS[2])
    masters = loaded.images.master[loaded.boundary] == loaded.boundary
    normal = loaded.tensors[layer & masters, 2, 2]
    assert len(normal) == COUNTS[0] * COUNTS[1]
    assert normal == pytest.approx(normal[0], rel=1e-12)


def test_an_own_force_may_return_an_array_of_the_nodes_that_are_not_repeated():
    """The check before a run, the run and the fingerprint of checkpoints ask for the same nodes."""
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
    forces = np.tile((0.0, 0.0, 0.1), (4, 1))
    load = tc.Load("zmax", force=lambda positions, velocities, time: forces)
    body = tc.Body(mesh, tc.LinearElastic(1.0, 0.3, 1.0), periodic="xy", loads=[load])
    result = simulate(tc.Scene([body], duration=0.5))
    assert result.history["applied_force"][-1, 2] == pytest.approx(0.4)
    with pytest.raises(tc.InputError, match=r"shape \[9, 3\]"):
        tc.Body(mesh, tc.LinearElastic(1.0, 0.3, 1.0), loads=[load])
