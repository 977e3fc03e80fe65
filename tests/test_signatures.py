"""Signatures of kernels that are made from bundles: the limit that Taichi sets, and that every scene keeps to."""

from typing import NamedTuple

import numpy as np
import pytest

from tcontact.kernels.language import bundles
from tcontact.kernels.language.arguments import Array
from tcontact.kernels.language.signatures import MOST, arguments, is_array, kernel_of, label, signature_of


def many(ti, count):
    """A bundle of so many arrays, and a kernel that adds the last array to the first one."""
    bundle = NamedTuple(f"Many{count}", [(f"a{number}", Array) for number in range(count)])
    given = bundle(*[np.full(1, float(number)) for number in range(count)])

    @ti.func
    def added(one: ti.template()):
        one[0][0] += one[ti.static(count - 1)][0]

    return given, kernel_of(added, signature_of({"one": given}))


def test_a_kernel_takes_as_many_arguments_as_taichi(taichi):
    given, kernel = many(taichi, MOST)
    kernel(*arguments({"one": given}))
    assert given[0][0] == MOST - 1


def test_one_argument_more_is_refused_by_its_count(taichi):
    with pytest.raises(TypeError, match=rf"kernel added has {MOST + 1} arguments \(one {MOST + 1}\), Taichi takes 64"):
        many(taichi, MOST + 1)


def test_no_scene_needs_more():
    """All arrays of a step at once; a penalty on nodes with mass has no static solve."""
    parts = [bundles.Body, bundles.Boundary, bundles.Supports, bundles.Contact, bundles.Obstacles, bundles.Rows]
    parts += [bundles.System, bundles.Pairs, bundles.Launch]
    names = {label(part.__name__, part, name) for part in parts for name in part._fields if is_array(part, name)}
    assert len(names - {"Contact_penalty_stiffness"}) <= MOST
