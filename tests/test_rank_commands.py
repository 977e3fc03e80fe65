"""Commands under mpiexec that read a stored run: the first rank does them alone; a study is refused."""

import pytest
from rank_scenes import block
from test_ranks import mpiexec, pytestmark  # noqa: F401 - skips these tests where MPI is missing

import tcontact as tc
from tcontact.commands.cli import ALONE


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """Return the folder of a run of one process."""
    folder = tmp_path_factory.mktemp("stored") / "run"
    tc.simulate(tc.Scene([block(counts=(2, 2, 2))], duration=1e-4), out=folder, frames=2)
    return folder


def test_a_stored_run_is_shown_once(stored):
    done = mpiexec(2, "-m", "tcontact", "info", stored, timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("finished at") == 1


def test_a_stored_run_is_exported_once(stored):
    """Two ranks that write the same files, each aside at first, lose one of them."""
    done = mpiexec(2, "-m", "tcontact", "export", stored, "--to", "xdmf", timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("MB)") == 1
    assert (stored / "export").is_dir()


def test_what_reads_stored_runs_is_done_by_the_first_rank():
    """Pictures and pages too, which take long to make."""
    assert {"info", "render", "report", "export"} <= set(ALONE)


def test_the_exit_code_is_that_of_the_first_rank(stored):
    done = mpiexec(3, "-m", "tcontact", "info", stored / "nowhere", timeout=60)
    assert done.returncode == 2
    assert done.stderr.count("tcontact: ") == 1


def test_a_study_takes_one_process(tmp_path):
    done = mpiexec(2, "-m", "tcontact", "study", "bar-impact", "--out", tmp_path / "study", timeout=60)
    assert done.returncode == 2
    assert done.stderr.count("a study takes one process in this version; start it without mpiexec") == 1
    assert not (tmp_path / "study").exists()
