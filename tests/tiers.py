"""How much is tested: quick tests always, long ones with `--long`, slow ones too with `--slow`.

Long tests are variants of tests of which a quicker one always runs, and runs of some seconds that combine what others
test term by term: their names stand in long_tests.txt, `FILE::TEST`, in the order of the alphabet. Lists of scenes that
one process runs for many tests are shorter in the same way. Slow tests have the mark `slow` or stand in
slow_variants.py; with `--slow` kernels are compiled as for a user.
"""

import os
from pathlib import Path

TABLE = Path(__file__).with_name("long_tests.txt")


def asked(name):
    """Return whether an environment variable asks for more tests; processes that tests start see it too."""
    return os.environ.get(name, "0") not in ("", "0")


def slow():
    """Return whether slow tests run."""
    return asked("TCONTACT_SLOW")


def long():
    """Return whether long tests run."""
    return slow() or asked("TCONTACT_LONG")


def long_tests():
    """Return the names of long tests by their files."""
    found = {}
    for line in TABLE.read_text(encoding="utf-8").splitlines():
        file, _, name = line.partition("::")
        found.setdefault(file, set()).add(name)
    return found


def of_tier(quick, *rest):
    """Return names of scenes: the quick ones, and all where long tests run."""
    return tuple(dict.fromkeys((*quick, *(name for names in rest for name in names)))) if long() else tuple(quick)
