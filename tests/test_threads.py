"""The same bits with one thread, with two, and again (issue table)."""

import pytest
from scenes import python

CODE = """
import hashlib
import numpy as np
import scenes, tcontact as tc
from oracle import meshes
threads = int(sys.argv[1])
for kind, law, removal, cells in (
    ("hex8", "neo", "normal", 10), ("tet4", "neo", "full", 8), ("tet4", "linear", "normal", 8), ("hex8", "svk", "full", 9)
):
    scene = scenes.thrown(law, kind, cells=cells, duration=0.5, gap=0.001, contact=tc.MasslessContact(removal=removal))
    result = scenes.simulate(scene, threads=threads)
    assert np.abs(result.history["contact_force"]).max() > 0
    digest = hashlib.sha256(result.position.tobytes() + result.velocity.tobytes())
    for name in sorted(result.history):
        digest.update(np.ascontiguousarray(result.history[name]).tobytes())
    print(kind, law, removal, result.steps, digest.hexdigest())
from tcontact import runtime
assert runtime.threads() == threads
"""


@pytest.fixture(scope="module")
def digests():
    found = []
    for threads in (1, 2, 2):
        done = python(CODE, threads)
        assert done.returncode == 0, done.stderr[-2000:]
        found.append(done.stdout.split("\n"))
    return found


def test_one_and_two_threads_give_the_same_bits(digests):
    assert len(digests[0]) == 5
    assert digests[0] == digests[1]


def test_a_second_run_gives_the_same_bits(digests):
    assert digests[1] == digests[2]
