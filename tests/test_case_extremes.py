"""Extreme and wrong values of every parameter of every case: refused in the words of the case, and at once."""

from __future__ import annotations

import signal
import time
import typing
from contextlib import contextmanager
from inspect import signature

import pytest
import tiers

import tcontact as tc
from tcontact import cases

LONGEST = 20  # seconds until building a scene counts as endless
NAN, INFINITE = float("nan"), float("inf")
WRONG = {  # by the type that a parameter is declared with: never values of it
    float: (NAN, INFINITE, "1", [1, 2], True, 1e300, 1e-300, 10**100),
    int: (NAN, 2.5, "x", [1, 2], True, -(10**30), 10**30),
    bool: (NAN, "x", 1, None),
    str: (NAN, 1, [1, 2]),
}
EXTREME = (0.0, -1.0, 1e-50, 1e-12, 2.5, 1e12, 1e30, 1e50)  # numbers that a formula may or may not bear
FEW = (1e-50, 1e50)  # of them, without --slow
ENOUGH = 1.5  # seconds of the processor after which a case has been tried enough without --slow


@contextmanager
def limited(seconds):
    """Fail where a block takes longer."""

    def end(*_):
        raise TimeoutError(f"more than {seconds} s")

    before = signal.signal(signal.SIGALRM, end)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def declared(case):
    """Return the build function of a case, and name and type of its parameters."""
    build = case.scene if hasattr(case, "scene") else case.solve
    hints = typing.get_type_hints(build)
    found = {}
    for name in signature(build).parameters:
        kinds = typing.get_args(hints[name]) or (hints[name],)
        found[name] = next((kind for kind in (bool, int, float) if kind in kinds), str)
    return build, found


def small(build, name):
    """Return parameters for a coarse mesh, but for the one tried."""
    return {"cells": 3} if "cells" in signature(build).parameters and name != "cells" else {}


def faults(build, name, values):
    """Return what building a scene with these values of a parameter does but return, or refuse it by its name."""
    found = []
    for value in values:
        try:
            with limited(LONGEST):
                build(**small(build, name), **{name: value})
        except tc.InputError as error:
            if error.field.rpartition(".")[2] != name:
                found.append(f"{name}={value!r}: names {error}")
        except Exception as error:
            found.append(f"{name}={value!r}: {type(error).__name__} {error}")
    return found


@pytest.mark.parametrize("name", cases.names())
def test_wrong_values_are_refused_by_the_name_of_the_parameter(name):
    build, parameters = declared(cases.load(name))
    for parameter, kind in parameters.items():
        for value in WRONG[kind]:
            with pytest.raises(tc.InputError) as error, limited(LONGEST):
                build(**small(build, parameter), **{parameter: value})
            assert error.value.field.rpartition(".")[2] == parameter, f"{parameter}={value!r}: {error.value}"


@pytest.mark.parametrize("name", [one for one in cases.names() if hasattr(cases.load(one), "scene")])
def test_extreme_numbers_make_a_scene_or_are_refused_by_name(name, request):
    build, parameters = declared(cases.load(name))
    slow = tiers.slow()
    found, began = [], time.process_time()
    for parameter, kind in parameters.items():
        if kind is float and (slow or time.process_time() - began < ENOUGH):
            found += faults(build, parameter, EXTREME if slow else FEW)
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("block-on-block", {"young": 2.5}, "young = 2.5: the block would be pressed flat: give more than"),
        ("block-on-block", {"stiffness": 1e-9}, "stiffness = 1e-09: the block would be pressed flat"),
        ("hot-slide", {"pressure": 1e30}, "pressure = 1e[+]30: give less than half of young"),
        ("ball-drop", {"yield_stress": 1e12}, "yield_stress = 1000000000000.0: the yield stress must be at most 0.1"),
        ("ball-drop", {"young": 2.5}, "young = 2.5: .*the default is 2"),
        ("ball-drop", {"hardening": -1}, "hardening = -1.0: must be at least 0"),
        ("ball-drop", {"density": 1e-40}, "density = 1e-40: .*the contact radius would be below"),
        ("incompressible-beam", {"ratio": 1e30}, "ratio = 1e[+]30"),
        ("two-materials", {"second_young": 0}, "second_young = 0.0: must be greater than 0"),
        ("two-cubes", {"turn": NAN}, "turn = nan: give a finite number"),
        ("taylor-bar", {"kind": NAN}, "kind = nan: use one of 'hex8', 'tet4'"),
        ("penetration-energy", {"redistributed": NAN}, "redistributed = nan: use True or False"),
    ],
)
def test_messages_name_what_was_given_and_what_to_do(name, given, message):
    with pytest.raises(tc.InputError, match=message):
        cases.load(name).scene(**given)


def test_a_whole_number_for_a_real_one_makes_the_same_scene():
    build = cases.load("two-cubes").scene
    one, other = (build(cells=3, turn=turn) for turn in (30, 30.0))
    assert (one.bodies[0].mesh.nodes == other.bodies[0].mesh.nodes).all()
