"""Ranks other than the first have no whole mesh, plan or result; what they lack is refused, or given where all ask."""

from test_ranks import mpiexec, pytestmark  # noqa: F401 - skips these tests where MPI is missing


def test_other_ranks_make_no_whole_mesh_or_plan_and_get_the_end_where_all_ask(tmp_path):
    done = mpiexec(3, "rank_memory.py", tmp_path)
    assert done.returncode == 0, done.stderr
    found = dict(line.split(" ", 1) for line in done.stdout.splitlines())
    assert found["refused"] == "2"
    assert found["remedy"] == "result.on_all_ranks() on all ranks"
    assert found["alike"] == "1 1"
    assert float(found["back"]) < 1e-2  # of the way; 4 if the velocity were not reversed


def test_a_rank_that_alone_asks_for_the_end_of_a_run_is_told_so(tmp_path):
    done = mpiexec(2, "rank_memory.py", tmp_path, "alone", timeout=120)
    assert done.returncode != 0
    assert done.stderr.count("rank 0 starts a run; rank 1 shares a result") == 1
