"""Data races of the kernels of a GPU: no thread reads or overwrites what others write meanwhile (watched_ptx.py)."""

from pathlib import Path

import cuda_device
import numpy as np
import pytest
import tiers

REASON = "PTX is translated by fake_cuda.sh alone" if cuda_device.real() else cuda_device.missing()
pytestmark = [pytest.mark.cuda, pytest.mark.skipif(bool(REASON), reason=REASON)]
WORKER = Path(__file__).resolve().parent / "cuda_race_worker.py"


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """What the device computed, and the races of its threads."""
    return cuda_device.results(tmp_path_factory.mktemp("races"), worker=WORKER, watched=True)


def test_races_are_told(found):
    """Those that add to one number, and one that changes what others read; not those that wait or store the same."""
    together, in_turn, unaware, alike = found["planted"]
    assert together > 0
    assert unaware > 0
    assert in_turn == alike == 0


def test_runs_have_no_races(found):
    """A friction force on a free obstacle was once added to a node by several threads at a time, and lost in part."""
    names = [key.partition("/")[0] for key in found if key.endswith("/told")]
    assert set(tiers.of_tier(("paired",), ("floated", "tumbling", "forged"))) <= set(names)
    for name in names:
        assert found[f"{name}/steps"] > 0
        assert not len(found[f"{name}/told"]), (name, np.unique(found[f"{name}/told"])[:5])
