"""Ranks other than the first have no whole mesh, plan or result; what they lack is refused, or given where all ask."""

from test_ranks import mpiexec, pytestmark  # noqa: F401 - skips these tests where MPI is missing


def test_other_ranks_make_no_whole_mesh_or_plan_and_get_the_end_where_all_ask(tmp_path):
    done = mpiexec(3, "rank_memory.py", tmp_path)
    assert done.returncode == 0, done.stderr
    found = dict(line.split(" ", 1) for line in done.stdout.splitlines())
    assert found["refused"] == "2"
    where = "with the communicator of the run where simulate had one"
    assert found["remedy"] == f"result.on_all_ranks() on all ranks, {where}"
    assert found["alike"] == "1 1"
    assert float(found["back"]) < 1e-2  # of the way; 4 if the velocity were not reversed
    # two runs: no cells of whole bodies beside the states, no states beside the whole end
    assert found["noted"] == "2 2 0 0"


def test_a_rank_that_alone_asks_for_the_end_of_a_run_is_told_so(tmp_path):
    done = mpiexec(2, "rank_memory.py", tmp_path, "alone", timeout=120)
    assert done.returncode != 0
    assert done.stderr.count("rank 0 starts a run; rank 1 shares a result") == 1


def test_looks_at_whole_bodies_fetch_the_nodes_that_they_read():
    """What comes to the first rank between frames does not grow with the cells inside the bodies."""
    done = mpiexec(3, "rank_looks.py")
    assert done.returncode == 0, done.stderr
    found = {name: list(map(int, values)) for name, *values in (line.split() for line in done.stdout.splitlines())}
    assert found["kinds"] == [3]
    sampled, samples = found["most"]
    assert 0 < sampled <= samples
    largest, surface, nodes = found["others"]
    assert largest == surface < nodes / 2
    compared, equal = found["equal"]
    assert compared == equal > 0
    assert found["touched"] == found["told"] == [1]


def test_other_ranks_make_no_whole_mesh_or_plan_where_they_share_the_contact(tmp_path):
    done = mpiexec(3, "rank_memory.py", tmp_path, "shared")
    assert done.returncode == 0, done.stderr
    *found, told = [line.split() for line in done.stdout.splitlines()]
    of_layers = "contact_ranks has no effect: the first rank has the whole contact of body-0, due to friction layers"
    assert told == ["told", *of_layers.split()]
    assert [name for name, *_ in found] == ["normal", "rubber", "pressed", "crossed"]
    assert all(ok == "True" and float(nodes) > 0.0 for _, ok, nodes in found)
