"""Shared by all tests: one start of Taichi, and long and slow tests only on request (tiers.py)."""

import os
import sys
from pathlib import Path

import pytest
import tiers
from slow_variants import SLOW_VARIANTS

# before NumPy is loaded: threads of its products wait in a loop, which takes the cores from the other process of tests
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

ROOT = Path(__file__).resolve().parent.parent
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))  # a bare checkout

# search for common subexpressions (compile_options.py), simplification of the intermediate code
SHORT = ("TI_OPT_LEVEL", "TI_ADVANCED_OPTIMIZATION")
THREADS = 2  # other counts run in processes of their own: Taichi starts once


def pytest_addoption(parser):
    parser.addoption("--long", action="store_true", help="run long tests too (or set TCONTACT_LONG=1)")
    parser.addoption("--slow", action="store_true", help="run all tests, slow ones too (or set TCONTACT_SLOW=1)")


def pytest_configure(config):
    """Let Taichi leave the optimization of all kernels to LLVM; in child processes too.

    Small bodies compile in half the time or less, to the same bits (test_threads.py). With --slow it is as for a user.
    Compiled kernels are kept for the next run: all tests need many times Taichi's limit of 100 MB, above which every
    process that ends removes a quarter of the kernels.
    """
    for tier in ("long", "slow"):  # in the environment for the processes that tests start
        if config.getoption(f"--{tier}"):
            os.environ[f"TCONTACT_{tier.upper()}"] = "1"
    if not tiers.slow():
        os.environ |= {name: "0" for name in SHORT if name not in os.environ}
    os.environ.setdefault("TI_OFFLINE_CACHE_MAX_SIZE_OF_FILES", str(2**31 - 1))


@pytest.hookimpl(hookwrapper=True)
def pytest_collection():
    """Import the kernels of all tests without Taichi's search for the module of each of their functions."""
    from tcontact.device.tracing import quick_import

    with quick_import():
        yield


def pytest_collection_modifyitems(config, items):
    check_tables(config, items)
    long_tests, marks = tiers.long_tests(), config.getoption("markexpr") or ""
    for item in items:
        if item.name in SLOW_VARIANTS.get(item.path.stem, ()):
            item.add_marker(pytest.mark.slow)
        elif item.name in long_tests.get(item.path.stem, ()):
            item.add_marker(pytest.mark.long)
        for tier, runs in (("slow", tiers.slow()), ("long", tiers.long())):
            if tier in item.keywords and not runs and tier not in marks:
                item.add_marker(pytest.mark.skip(reason=f"{tier}: run with --{tier} or TCONTACT_{tier.upper()}=1"))


def check_tables(config, items):
    """Refuse names of long and slow tests that their files do not have, so that renamed tests do not get lost."""
    found = {}
    for item in items:
        found.setdefault(item.path.stem, set()).add(item.name)
    whole = not any("::" in word for word in config.args)
    for table in (SLOW_VARIANTS, tiers.long_tests()):
        for file, names in table.items():
            gone = names - found.get(file, names) if whole else ()
            if gone or not (ROOT / "tests" / f"{file}.py").is_file():
                raise pytest.UsageError(f"long_tests.txt or slow_variants.py name tests without a file: {file} {gone}")


@pytest.fixture(scope="session", autouse=True)
def taichi():
    """Taichi on the CPU with two threads, for every test of the session."""
    from tcontact.device import runtime

    return runtime.start("cpu", THREADS)


@pytest.fixture
def parallel_path(monkeypatch):
    """Bodies of any size step one launch at a time on all threads, as only large ones do otherwise.

    For tests of many laws and elements: their force pass is compiled once for all terms of a scene. That both paths do
    the same is tested on bodies of both sizes (test_periodic.py).
    """
    from tcontact.planning.body_plan import SMALL

    for element in SMALL:
        monkeypatch.setitem(SMALL, element, 0)
