"""Shared by all tests: one start of Taichi, and slow tests only on request."""

import os
import sys
from pathlib import Path

import pytest

# before NumPy is loaded: threads of its products wait in a loop, which takes the cores from the other process of tests
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

ROOT = Path(__file__).resolve().parent.parent
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))  # a bare checkout

THREADS = 2  # other counts run in processes of their own: Taichi starts once


def pytest_addoption(parser):
    parser.addoption("--slow", action="store_true", help="run slow tests too (or set TCONTACT_SLOW=1)")


def slow(config):
    """Return whether slow tests are asked for."""
    return config.getoption("--slow") or os.environ.get("TCONTACT_SLOW", "0") not in ("", "0")


def pytest_collection_modifyitems(config, items):
    if slow(config) or "slow" in (config.getoption("markexpr") or ""):
        return
    skip = pytest.mark.skip(reason="slow: run with --slow or TCONTACT_SLOW=1")
    for item in items:
        if "slow" in item.keywords:
            item.add_marker(skip)


@pytest.fixture(scope="session", autouse=True)
def taichi(pytestconfig):
    """Taichi on the CPU with two threads, for every test of the session.

    Every kernel leaves common subexpressions to LLVM, as most kernels do anyway (compile_options.py): small bodies
    compile in half the time. The bits are those of a user's process (test_threads.py); `--slow` compiles as there.
    """
    from tcontact.device import runtime

    taichi = runtime.start("cpu", THREADS)
    if not slow(pytestconfig):
        from tcontact.kernels.language.compile_options import LEAVE_TO_LLVM

        for name, value in LEAVE_TO_LLVM.items():
            setattr(taichi.cfg, name, value)
    return taichi


@pytest.fixture
def parallel_path(monkeypatch):
    """Bodies of any size step one launch at a time on all threads, as only large ones do otherwise.

    For tests of many laws and elements: their force pass is compiled once for all terms of a scene. That both paths do
    the same is tested on bodies of both sizes (test_periodic.py).
    """
    from tcontact.planning.body_plan import SMALL

    for element in SMALL:
        monkeypatch.setitem(SMALL, element, 0)
