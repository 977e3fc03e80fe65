"""Varying friction between bodies whose contact ranks share is that of one process, also in a second half."""

import os
import subprocess
import sys

import numpy as np
from test_ranks import HERE, mpiexec, pytestmark  # noqa: F401 - skips these tests where MPI is missing


def test_the_coefficients_of_a_shared_pair_are_those_of_one_process(tmp_path):
    """The static solve that each rank does whole sets the coefficients of rows that have got their masters."""
    environment = os.environ | {"PYTHONPATH": str(HERE.parent), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "rank_gone_on.py", str(tmp_path / "one.npz")]
    subprocess.run(command, cwd=HERE, env=environment, check=True, timeout=300)
    done = mpiexec(2, "rank_gone_on.py", tmp_path / "two.npz", timeout=300)
    assert done.returncode == 0, done.stderr
    one, two = (np.load(tmp_path / f"{name}.npz") for name in ("one", "two"))
    for known in (one, two):
        whole, second = known["arr_0"], known["arr_1"]
        bound = 1e-9 * np.abs(whole).max()
        np.testing.assert_allclose(second, whole[int(known["seam"]) :], rtol=0, atol=bound)
        np.testing.assert_allclose(whole, one["arr_0"], rtol=0, atol=1e-11 * np.abs(whole).max())
