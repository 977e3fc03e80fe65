"""Ranks look at a block of steps behind it: one that should have ended earlier is put back and done again."""

from test_ranks import mpiexec, pytestmark  # noqa: F401 - skips these tests where MPI is missing


def test_a_block_that_should_have_ended_earlier_is_done_again_to_equal_bits_and_one_message_tells_of_all_its_rows():
    """Free and rigid bodies, friction in a corner, a static solve that ends early: all that a block can change."""
    done = mpiexec(2, "rank_blocks.py")
    assert done.returncode == 0, done.stderr
    found = {name: numbers for name, *numbers in map(str.split, done.stdout.splitlines())}
    for name in ("rigid", "walls", "loose"):
        redone, equal = found[name]
        assert int(redone) > 1
        assert equal == "True", name
    steps, gathered = map(int, found["flight"])
    assert steps > 100
    assert gathered <= -(-steps // 32) + 4  # the first and last rows stand alone
