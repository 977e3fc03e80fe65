"""Signatures of kernels: arrays in the order of the bundles, nothing for what is absent, few enough for Taichi."""

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pytest
import taichi as ti
from scenes import block, state_of

import tcontact as tc
from tcontact.kernels.language.arguments import Array, Index, Shared
from tcontact.kernels.language.joint_lists import joined
from tcontact.kernels.language.signatures import MAXIMUM_ARGUMENTS as LIMIT
from tcontact.kernels.language.signatures import arguments, kernel_of, signature_of
from tcontact.kernels.language.solve_bundles import PAIR_LISTS, JointPairs


class Motion(NamedTuple):
    """A bundle of every kind of field."""

    nodes: Index = None
    u: Array = None
    v: Array = None
    sums: Shared = None
    options: Any = None

    @property
    def moves(self) -> bool:
        """Return whether there are velocities."""
        return self.v is not None


class Walls(NamedTuple):
    """Another bundle, some of whose fields have the names of the first one's."""

    gaps: Array = None
    nodes: Index = None
    sums: Shared = None

    @property
    def exist(self) -> bool:
        """Return whether there are walls."""
        return self.nodes is not None


def filled():
    """Return two bundles whose arrays have 3 numbers each; the second one has no gaps."""
    whole, sums = np.zeros(3, dtype=np.int32), np.zeros(3)
    motion = Motion(whole, np.zeros(3), np.zeros(3), sums, options="elastic")
    return {"motion": motion, "walls": Walls(nodes=whole.copy(), sums=sums)}


def test_arrays_stand_in_the_order_of_bundles_and_fields_under_both_names():
    """A field of the same name in two bundles is two arguments, a shared one is one."""
    bundles = filled()
    motion, walls = bundles.values()
    kinds = signature_of(bundles).arguments()
    assert list(kinds) == ["motion_nodes", "motion_u", "motion_v", "sums", "walls_nodes"]
    assert list(kinds.values()) == [Index, Array, Array, Shared, Index]
    wanted = (motion.nodes, motion.u, motion.v, motion.sums, walls.nodes)
    found = arguments(bundles)
    assert len(found) == len(wanted)
    assert all(one is other for one, other in zip(found, wanted, strict=True))
    turned = dict(reversed(bundles.items()))
    assert list(signature_of(turned).arguments()) == ["walls_nodes", "sums", "motion_nodes", "motion_u", "motion_v"]


def test_what_is_absent_is_no_argument():
    """Neither a field that is None nor a bundle of such fields; it makes another signature all the same."""
    whole = filled()
    bare = {"motion": whole["motion"]._replace(v=None), "walls": Walls()}
    assert list(signature_of(bare).arguments()) == ["motion_nodes", "motion_u", "sums"]
    assert len(arguments(bare)) == 3
    assert arguments({"walls": Walls()}) == ()
    assert signature_of({"walls": Walls()}).arguments() == {}
    assert signature_of(bare) != signature_of(whole)
    assert signature_of(whole) == signature_of(filled())
    assert hash(signature_of(whole)) == hash(signature_of(filled()))


@ti.func
def mark(first, second, motion: ti.template(), walls: ti.template()):
    """Write another number into each array, and into `sums` what the kernel knows when it is compiled."""
    for i in range(first, second):
        motion.nodes[i] = 1
        motion.u[i] = 2.0
        motion.sums[i] = 5.0
        if ti.static(motion.moves):
            motion.v[i] = 3.0
        if ti.static(walls.exist):
            walls.nodes[i] = 4
            walls.sums[i] += 10.0
        if ti.static(motion.options == "elastic"):
            motion.sums[i] += 100.0


@pytest.mark.parametrize("bare", [False, True])
def test_a_kernel_finds_every_array_under_its_name(bare):
    """Numbers come first, then the arrays; absent fields are None and options are constants when it is compiled."""
    bundles = filled()
    if bare:
        bundles = {"motion": bundles["motion"]._replace(v=None), "walls": Walls()}
    kernel = kernel_of(mark, signature_of(bundles), ("first", "second"), options=bundles["motion"].options)
    kernel(1, 3, *arguments(bundles))
    motion, walls = bundles.values()
    assert motion.nodes.tolist() == [0, 1, 1]
    assert motion.u.tolist() == [0.0, 2.0, 2.0]
    total = 105.0 if bare else 115.0
    assert motion.sums.tolist() == [0.0, total, total]
    if not bare:
        assert motion.v.tolist() == [0.0, 3.0, 3.0]
        assert walls.nodes.tolist() == [0, 4, 4]


def test_wrong_bundles_are_errors():
    """Fewer arrays, another kind of array, a field that a bundle does not have, and what is no bundle."""
    bundles = filled()
    kernel = kernel_of(mark, signature_of(bundles), ("first", "second"), options="elastic")
    fewer = bundles | {"walls": Walls()}
    with pytest.raises(ti.TaichiSyntaxError, match=r"walls_nodes .* missing"):
        kernel(0, 3, *arguments(fewer))
    other = bundles | {"motion": bundles["motion"]._replace(nodes=np.zeros(3))}
    with pytest.raises(ValueError, match=r"motion_nodes .* dtype=i32.* dtype=f64"):
        kernel(0, 3, *arguments(other))
    with pytest.raises(TypeError, match="speeds"):
        Walls(speeds=np.zeros(3))
    with pytest.raises(AttributeError, match="_fields"):
        signature_of({"walls": (np.zeros(3),)})


def test_lists_of_pairs_in_one_array_read_as_arrays_of_their_own():
    lists = [np.arange(3 + k, dtype=np.int32) + 100 * k for k in range(len(PAIR_LISTS))]
    bundles = {"pairs": JointPairs(joined(lists), np.zeros(1), np.zeros(3))}

    @ti.func
    def read(pairs: ti.template()):
        for i in range(3):
            pairs.values[i] = pairs.nodes[i] + 1000.0 * pairs.entry_pairs[2 * i]

    kernel_of(read, signature_of(bundles))(*arguments(bundles))
    wanted = lists[PAIR_LISTS.index("nodes")][:3] + 1000.0 * lists[PAIR_LISTS.index("entry_pairs")][[0, 2, 4]]
    assert np.array_equal(bundles["pairs"].values, wanted)


@pytest.mark.parametrize("count", [LIMIT, LIMIT + 1])
def test_taichi_takes_as_many_arguments_as_we_count_on(count):
    many = NamedTuple("Many", [(f"a{number}", Array) for number in range(count - 1)] + [("last", Array)])

    @ti.func
    def fill(bundle: ti.template()):
        for i in range(1):
            bundle.last[i] = 1.0

    bundles = {"bundle": many(*np.zeros((count, 1)))}
    if count > LIMIT:
        with pytest.raises(TypeError, match=rf"kernel fill has {count} arguments \(bundle {count}\), Taichi takes 64"):
            kernel_of(fill, signature_of(bundles))
    else:
        kernel_of(fill, signature_of(bundles))(*arguments(bundles))
        assert [array[0] for array in bundles["bundle"]] == [0.0] * (count - 1) + [1.0]


@dataclass(frozen=True)
class Remembering(tc.NeoHookean):
    """A law whose points keep a number."""

    law: ClassVar[str] = "test_remembering"


CONTACTS = {
    "full removal": tc.MasslessContact("full"),
    "normal removal, viscous contact cells": tc.MasslessContact("normal"),
    "penalty of massless nodes": tc.MasslessContact("normal", penalty=1e9),
    "penalty": tc.PenaltyContact(1e9),
}


@pytest.mark.parametrize("path", ["serial", "parallel"])
@pytest.mark.parametrize("contact", CONTACTS)
def test_all_terms_together_need_no_more_arguments_than_taichi_takes(contact, path, monkeypatch, request):
    """Everything that brings arrays at once: state, layers, supports, images, damping, viscosity, moving obstacles."""
    from tcontact.kernels.materials import LAWS, neo_hookean

    if path == "parallel":
        request.getfixturevalue("parallel_path")
    monkeypatch.setitem(LAWS, "test_remembering", neo_hookean.LAW._replace(state=("number",)))
    body = tc.Body(
        block("hex8", 2, shake=0.0),
        Remembering(1e6, 0.3, 1000.0),
        contact="zmin",
        periodic="xy",
        supports=[tc.Support("zmax", "z", -1.0)],
    )
    scene = tc.Scene(
        [body],
        [tc.Plane((0.0, 0.0, -0.01 * number), velocity=(0.0, 0.0, 0.1)) for number in range(1, 5)],
        duration=1e-3,
        gravity=(0.0, 0.0, -9.81),
        contact=CONTACTS[contact],
        friction=tc.FrictionLayer(),
        damping=tc.MassDamping(5.0),
        viscosity=tc.BulkViscosity(),
    )
    state = state_of(scene, tc.plan(scene).bodies[0])
    force, serial = state.internal_force, state.serial
    body = force.bundle()._replace(u=state.u, v=state.v)
    handed = force.arguments(state.u, state.v)
    assert all(one is other for one, other in zip(handed, arguments({"body": body}), strict=True))
    assert len(handed) + 4 <= LIMIT  # with the numbers of the force pass
    assert force.memory is not None
    assert (30 if contact == "penalty" else 60) <= len(handed) + len(serial._parts) <= LIMIT
