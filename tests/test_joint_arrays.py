"""Arrays of a GPU that stand in two large ones: the host and the kernels use them like arrays of their own.

The arrays of Taichi that a GPU gets are made on the CPU here.
"""

from typing import Any, NamedTuple

import numpy as np
import pytest
import taichi as ti

from tcontact.device import arrays, leaves, runtime
from tcontact.device.joint import MOST, Joint
from tcontact.device.launch import Prepared
from tcontact.kernels.language.arguments import Array, Index
from tcontact.kernels.language.joint_arrays import REALS, WHOLES
from tcontact.kernels.language.signatures import arguments, kernel_of, signature_of

MASS, PLACES = np.array([1.5, 2.5, 4.0]), np.array([2, 0, 1], dtype=np.int32)


class Nodes(NamedTuple):
    """A bundle; a scene may have arrays of it alone and parts of a joint."""

    mass: Array = None
    places: Index = None
    sums: Array = None
    counts: Index = None
    options: Any = None


@pytest.fixture(autouse=True)
def started():
    runtime.start("cpu")


def made(joint, shift=0.0):
    """Return a bundle of parts, made in a fixed order."""
    return Nodes(
        joint.part(np.float64, 3, MASS + shift),
        joint.part(np.int32, 3, PLACES.copy()),
        joint.part(np.float64, 2),
        joint.part(np.int32, 4),
    )


@ti.func
def weigh(nodes: ti.template()):
    """Sum up masses by place, count the nodes of even places, note the sizes."""
    for _ in range(1):
        for i in range(nodes.mass.shape[0]):
            nodes.sums[0] += nodes.mass[nodes.places[i]] * (i + 1)
            if nodes.places[i] % 2 == 0:
                ti.atomic_add(nodes.counts[3], 1)
        nodes.sums[1] = nodes.mass[2]
        nodes.counts[0] = nodes.sums.shape[0]
        nodes.counts[1], nodes.counts[2] = nodes.places.shape[0], 7


def weighed(nodes, times=1):
    launch = Prepared(kernel_of(weigh, signature_of({"nodes": nodes})))
    for _ in range(times):
        launch(*arguments({"nodes": nodes}))


def test_a_kernel_reads_and_writes_parts_in_place():
    """The first launch, which compiles, and later ones alike; numbers beside the parts stay."""
    joint = Joint()
    before, nodes, behind = joint.part(np.float64, 2, np.ones(2)), made(joint), joint.part(np.int32, 2, np.full(2, 9))
    weighed(nodes, times=3)
    expected = 3 * (4.0 * 1 + 1.5 * 2 + 2.5 * 3)
    assert nodes.sums.to_numpy().tolist() == [expected, 4.0]
    assert nodes.counts.to_numpy().tolist() == [2, 3, 7, 6]
    assert arrays.get(nodes.mass).tolist() == MASS.tolist()
    assert arrays.get(nodes.places).tolist() == PLACES.tolist()
    assert (before.to_numpy() == 1.0).all()
    assert (behind.to_numpy() == 9).all()


def test_a_launch_names_two_arrays_for_all_parts():
    joint = Joint()
    nodes = made(joint)
    assert list(signature_of({"nodes": nodes}).arguments()) == [REALS, WHOLES]
    assert [given.type for given in arguments({"nodes": nodes})] == [np.float64, np.int32]
    lone = nodes._replace(mass=arrays.put(MASS))
    assert list(signature_of({"nodes": lone}).arguments()) == ["nodes_mass", WHOLES, REALS]
    assert [type(given).__name__ for given in arguments({"nodes": lone})] == ["ndarray", "Whole", "Whole"]
    whole = Nodes(places=nodes.places)
    assert list(signature_of({"nodes": whole}).arguments()) == [WHOLES]


def test_kernels_serve_parts_of_any_size_made_in_the_same_order():
    one, other = Joint(), Joint()
    large = Nodes(*(other.part(part.type, 50) for part in made(one)[:4]))
    assert signature_of({"nodes": large}) == signature_of({"nodes": made(Joint())})
    turned = Joint()
    turned.part(np.float64, 1)
    assert signature_of({"nodes": made(turned)}) != signature_of({"nodes": large})


def test_parts_of_two_joints_are_refused():
    nodes = made(Joint())._replace(mass=Joint().part(np.float64, 3))
    with pytest.raises(TypeError, match="nodes_places stands in another joint array"):
        arguments({"nodes": nodes})


@pytest.mark.parametrize("full", [False, True], ids=["before", "after"])
def test_the_host_reads_and_writes_parts(full):
    """The host has the same values before the arrays are made on the device and afterwards."""
    joint, given = Joint(), PLACES.copy()
    nodes = made(joint)._replace(places=joint.part(np.int32, 3, given))
    given[:] = 7
    if full:
        joint.fill()
    arrays.set_values(nodes.mass, np.array([8.0, 9.0]), 1)
    arrays.set_values(nodes.places, np.array([5.0]), 2)
    arrays.set_values(nodes.sums, np.array([0.5, 0.25]))
    assert arrays.get(nodes.mass).tolist() == [1.5, 8.0, 9.0]
    assert arrays.get(nodes.places).tolist() == [2, 0, 5]
    assert arrays.part(nodes.mass, 1, 2).tolist() == [8.0, 9.0]
    assert arrays.get(nodes.sums).tolist() == [0.5, 0.25]
    assert arrays.get(nodes.counts).tolist() == [0, 0, 0, 0]
    assert arrays.get(nodes.places).dtype == np.int32
    assert arrays.size_in_bytes(list(nodes[:4])) == 5 * 8 + 7 * 4
    read = arrays.get(nodes.mass)
    read[:] = 0.0
    assert arrays.get(nodes.mass)[0] == 1.5


def test_copies_stay_on_the_device():
    """Parts are copied to parts of the same joint or of another one, and `alone` gives a copy that stands in none."""
    joint, other = Joint(), Joint()
    other.part(np.float64, 5)
    nodes, kept = made(joint), made(other, shift=1.0)
    alone = arrays.alone(nodes.places)
    arrays.copy(nodes.mass, kept.mass)
    assert arrays.get(kept.mass).tolist() == MASS.tolist()
    arrays.set_values(nodes.mass, np.zeros(3))
    arrays.copy(kept.mass, nodes.mass)
    assert arrays.get(nodes.mass).tolist() == MASS.tolist()
    assert alone.tolist() == PLACES.tolist()
    assert arrays.alone(alone) is alone


def test_a_joint_that_is_made_takes_no_more():
    """An array that comes later or is too large stands alone; a checkpoint finds every part once, and no joint."""

    class Term:
        pass

    Term.__module__ = "tcontact.of_a_test"
    term, joint = Term(), Joint()
    assert joint.takes(np.int32, MOST)
    assert not joint.takes(np.int32, MOST + 1)
    term.nodes, term.launch = made(joint)[:4], arguments({"nodes": made(joint)})
    assert not joint.takes(np.int32, MOST)
    joint.fill()
    assert not joint.takes(np.int32, 1)
    with arrays.standing_in(joint):
        assert isinstance(arrays.put(MASS), np.ndarray)
    found = list(leaves.leaves(term))
    assert [leaf.path for leaf in found] == [f"nodes.{number}" for number in range(4)]
    found[0].put(2.0 * MASS)
    assert arrays.get(term.nodes[0]).tolist() == (2.0 * MASS).tolist()
