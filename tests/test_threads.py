"""Runs have the same bits with one thread and with two, compiled as for a user and as for these tests."""

import hashlib
import os

import numpy as np
import pytest
from conftest import SHORT
from scenes import python, simulate, thrown

import tcontact as tc
from tcontact.device import runtime

LARGE = (("hex8", "neo", "normal", 17), ("tet4", "neo", "full", 15))
SMALL = (("hex8", "linear", "normal", 3), ("tet4", "neo", "normal", 4))  # on one thread, compiled otherwise by conftest


def digests():
    """One line per run: steps and a hash over all that the run returns."""
    lines = []
    for kind, law, removal, cells in LARGE + SMALL:
        contact = tc.MasslessContact(removal=removal)
        scene = thrown(law, kind, cells=cells, duration=0.5, gap=0.001, contact=contact)
        assert tc.plan(scene).domains[0].small == (cells < 10)
        result = simulate(scene)
        assert np.abs(result.history["contact_force"]).max() > 0.0
        digest = hashlib.sha256(result.position.tobytes() + result.velocity.tobytes())
        for name in sorted(result.history):
            digest.update(np.ascontiguousarray(result.history[name]).tobytes())
        lines.append(f"{kind} {removal} {result.steps} {digest.hexdigest()}")
    return lines


@pytest.fixture(scope="module")
def here():
    assert runtime.threads() == 2
    return digests()


def test_one_and_two_threads_give_the_same_bits(here):
    """The other process compiles as for a user, with Taichi's own optimization of the kernels."""
    code = "from tcontact.device import runtime; runtime.start('cpu', 1); import test_threads"
    user = {name: value for name, value in os.environ.items() if name not in SHORT}
    done = python(code + "\nprint(*test_threads.digests(), sep=chr(10))", env=user)
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.splitlines() == here


def test_a_second_run_gives_the_same_bits(here):
    assert digests() == here
