"""Several ranks, each on a CUDA device, do what one process does on a CPU: forces of shared nodes go through the host.

The scenes have every way in which a rank takes a block of steps: without contact nodes of its own, with a static solve,
with friction layers between two launches, with pairs of bodies row by row, with a block that is taken again up to a row
beyond the limits, and with a solve that fails within a block, which the others learn of at its end.
"""

import subprocess
import sys

import cuda_device
import numpy as np
import pytest
import test_ranks
import tiers
from test_rank_runs import differs, scale, unlike

REASON = cuda_device.missing()
pytestmark = [pytest.mark.cuda, pytest.mark.skipif(bool(REASON), reason=REASON), *test_ranks.pytestmark]
RANKS = 2
REASONS = {"crushed": "inverted-cell"}
NAMES = tiers.of_tier(("layered", "held"), ("crushed", "sank"), ("pair",) if tiers.slow() else ())


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """Results of one process on its CPU."""
    folder = tmp_path_factory.mktemp("alone")
    command = [sys.executable, "rank_results.py", str(folder), *NAMES]
    subprocess.run(command, cwd=test_ranks.HERE, check=True, timeout=900)
    return folder


@pytest.fixture(scope="module")
def together(tmp_path_factory):
    """Results of ranks on devices; below "stopped" a run that was stopped and went on."""
    folder = tmp_path_factory.mktemp("devices")
    run = test_ranks.MPIEXEC, RANKS, folder
    cuda_device.on_ranks(*run, "rank_results.py", "--cuda", folder, *NAMES)
    for mode in ("signalled", "resumed"):
        cuda_device.on_ranks(*run, "rank_resumed.py", "--cuda", folder / "stopped", mode, "held")
    return folder


@pytest.mark.parametrize("name", [name for name in NAMES if name != "sank"])
def test_runs_of_ranks_on_devices_are_those_of_one_process(alone, together, name):
    known, found = (np.load(folder / name / "values.npz") for folder in (alone, together))
    assert known.files == found.files
    assert str(found["reason"]) == str(known["reason"]) == REASONS.get(name, "finished")
    assert found["steps"] == known["steps"]
    assert unlike(known, found) == []
    told = np.load(together / name / "ranks.npz")
    assert told["copies"] == 0  # have other bits
    assert told["touching"] == (name != "held")


@pytest.mark.long
def test_a_solve_that_fails_amid_a_block_ends_all_ranks_at_its_row(alone, together):
    """Up to the row before, the rows are those of one process; what a solve leaves that fails depends on rounding."""
    known, found = (np.load(folder / "sank" / "values.npz") for folder in (alone, together))
    assert str(found["reason"]) == str(known["reason"]) == "not-converged"
    assert found["steps"] == known["steps"] > 10
    for column in ("time", "kinetic", "elastic", "momentum", "contact_force", "impulse"):
        rows = [values[f"history {column}"][:-1] for values in (known, found)]
        assert not differs(*rows, 1e-11), column


def test_a_run_of_devices_goes_on_with_the_same_bits(together):
    whole, stopped, found = (
        np.load(together / name)
        for name in ("held/values.npz", "stopped/held/signalled.npz", "stopped/held/resumed.npz")
    )
    assert str(stopped["reason"]) == "interrupted"
    assert len(stopped["time"]) < len(found["time"])
    for key in ("x", "v", "force"):
        assert np.array_equal(whole[key], found[key])
    assert scale(found["v"]) > 0.0
