"""Threads of a GPU that read or overwrite what others write at the same time: none may be there (watched_ptx.py)."""

from pathlib import Path

import cuda_device
import numpy as np
import pytest

REASON = "PTX is translated by fake_cuda.sh alone" if cuda_device.real() else cuda_device.missing()
pytestmark = [pytest.mark.cuda, pytest.mark.skipif(bool(REASON), reason=REASON)]
WORKER = Path(__file__).resolve().parent / "cuda_meeting_worker.py"


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """What the device computed, and which threads met."""
    return cuda_device.results(tmp_path_factory.mktemp("meetings"), worker=WORKER, watched=True)


def test_threads_that_meet_are_told(found):
    """Those that add to one number, and one that changes what others read; not those that wait or store the same."""
    together, in_turn, unaware, alike = found["planted"]
    assert together > 0
    assert unaware > 0
    assert in_turn == alike == 0


def test_no_threads_meet_in_a_run(found):
    """A friction force on a free obstacle was once added to a node by several threads at a time, and lost in part."""
    names = [key.partition("/")[0] for key in found if key.endswith("/told")]
    assert {"floated", "paired", "tumbling", "forged"} <= set(names)
    for name in names:
        assert found[f"{name}/steps"] > 0
        assert not len(found[f"{name}/told"]), (name, np.unique(found[f"{name}/told"])[:5])
