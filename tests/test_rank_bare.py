"""A rank that has a whole body, of which no node is a boundary node, steps with those that have the contact."""

import numpy as np
import pytest
from rank_bare import save, scene
from test_rank_runs import scale, unlike
from test_ranks import mpiexec, pytestmark  # noqa: F401 - skips these tests where MPI is missing

import tcontact as tc


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """Return what one process gives."""
    path = tmp_path_factory.mktemp("alone") / "alone.npz"
    save(path, tc.simulate(scene()))
    return np.load(path)


@pytest.mark.parametrize("contact_ranks", [None, 2])
def test_ranks_without_a_boundary_node_give_what_one_process_gives(alone, tmp_path, contact_ranks):
    """The first rank has the contact, or may share it with another one; some rank has only bodies that fly."""
    words = [] if contact_ranks is None else [contact_ranks]
    done = mpiexec(3, "rank_bare.py", tmp_path, *words, timeout=400)
    assert done.returncode == 0, done.stderr
    found = np.load(tmp_path / f"{contact_ranks}.npz")
    assert found["steps"] == alone["steps"]
    assert found.files == alone.files
    assert unlike(alone, found) == []
    assert scale(found["force"]) > 0.0
