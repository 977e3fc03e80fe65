"""Shared by all tests: one start of Taichi, and slow tests only on request."""

import os
import sys
from pathlib import Path

import pytest
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
    parser.addoption("--slow", action="store_true", help="run slow tests too (or set TCONTACT_SLOW=1)")


def slow(config):
    """Return whether slow tests are asked for."""
    return config.getoption("--slow") or os.environ.get("TCONTACT_SLOW", "0") not in ("", "0")


def pytest_configure(config):
    """Let Taichi leave the optimization of all kernels to LLVM; in child processes too.

    Small bodies compile in half the time or less, to the same bits (test_threads.py). With --slow it is as for a user.
    Compiled kernels are kept for the next run: all tests need many times Taichi's limit of 100 MB, above which every
    process that ends removes a quarter of the kernels.
    """
    if slow(config):
        os.environ["TCONTACT_SLOW"] = "1"  # for the processes that tests start
    else:
        os.environ |= {name: "0" for name in SHORT if name not in os.environ}
    os.environ.setdefault("TI_OFFLINE_CACHE_MAX_SIZE_OF_FILES", str(2**31 - 1))


def pytest_collection_modifyitems(config, items):
    for item in items:
        if item.name in SLOW_VARIANTS.get(item.path.stem, ()):
            item.add_marker(pytest.mark.slow)
    if slow(config) or "slow" in (config.getoption("markexpr") or ""):
        return
    skip = pytest.mark.skip(reason="slow: run with --slow or TCONTACT_SLOW=1")
    for item in items:
        if "slow" in item.keywords:
            item.add_marker(skip)


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
