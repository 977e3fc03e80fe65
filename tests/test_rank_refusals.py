"""Errors of one rank alone: where a script catches them, all ranks have them, and none is left waiting."""

import pytest
from test_ranks import mpiexec, pytestmark  # noqa: F401 - skips these tests where MPI is missing

from tcontact.run.folder_lock import locked

RANKS = 2


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """Return what each rank was told (rank_refusals.py); `mpiexec` raises `TimeoutExpired` if one of them waits."""
    folder = tmp_path_factory.mktemp("told")
    (folder / "locked").mkdir()
    with locked(folder / "locked"):  # by this process
        done = mpiexec(RANKS, "rank_refusals.py", folder, timeout=300)
    assert done.returncode == 0, done.stderr
    lines = [(folder / f"told.{rank}").read_text(encoding="utf-8").splitlines() for rank in range(RANKS)]
    return [dict(line.split(": ", 1) for line in one) for one in lines]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("locked", "is writing a run there; wait for it or name another folder"),
        ("frames", "frames = -1: "),
        ("scene", "scene = None: give a tcontact.Scene"),
        ("scheme", "scheme = 'no scheme': "),
        ("checkpoint", "needs a folder: give out too"),
        ("initial", "give the Result of another run"),
        ("gravity", "no run with it can be resumed, or shared among processes"),
        ("threads", "threads = 0: "),
        ("resumed", "no such folder"),
    ],
)
def test_an_error_of_one_rank_alone_can_be_caught_on_all_of_them(told, name, text):
    """A folder in which another process runs, options and scenes that are wrong on one rank, and a missing folder."""
    assert text in told[0][name]
    assert told[0][name] == told[1][name]


def test_the_script_goes_on_with_further_runs(told):
    assert [one["well"] for one in told] == ["finished", "finished"]


def test_a_notebook_of_another_rank_says_who_shows_the_result(told):
    assert "rank 1 has no values of nodes and cells: rank 0 has them" in told[1]["notebook"]
    assert told[1]["notebook"].endswith("None")
