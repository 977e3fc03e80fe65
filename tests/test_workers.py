"""Runs in worker processes: kernels are kept, pools end, and what cannot work in them is refused by name."""

import contextlib
import json
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys

import pool_worker
import pytest
from scenes import ROOT, python

import tcontact as tc

FORK = "fork" in multiprocessing.get_all_start_methods()
pytestmark = pytest.mark.skipif(not FORK, reason="this system starts no process by fork")
POOLS = {
    "pool": "with multiprocessing.get_context({start!r}).Pool(1) as pool: pool.apply(tiny_kernel.run)",
    "executor": "with futures.ProcessPoolExecutor(1, multiprocessing.get_context({start!r})) as pool:"
    " pool.submit(tiny_kernel.run).result()",
    "process": "one = multiprocessing.get_context({start!r}).Process(target=tiny_kernel.run); one.start(); one.join()",
}


@pytest.mark.parametrize(
    ("kind", "start"), [("pool", "fork"), ("pool", "spawn"), ("executor", "fork"), ("process", "fork")]
)
def test_workers_keep_the_kernels_that_they_have_compiled(kind, start, tmp_path):
    """A copy of a process ends without taking Taichi apart, and a pool ends its workers by a signal."""
    code = "import multiprocessing, tiny_kernel\nfrom concurrent import futures\n" + POOLS[kind].format(start=start)
    done = python(code, env=os.environ | {"TI_OFFLINE_CACHE_FILE_PATH": str(tmp_path)})
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    assert list(tmp_path.glob("*.tic"))


def test_a_pool_is_left_amid_a_run(tmp_path):
    """Its worker ends with the run, which is stored, instead of waiting for the next task for ever."""
    script = [sys.executable, ROOT / "tests" / "pool_worker.py", tmp_path / "run"]
    paths = os.environ | {"PYTHONPATH": str(ROOT)}
    program = subprocess.Popen(script, stdout=subprocess.PIPE, text=True, env=paths, start_new_session=True)
    try:
        assert program.communicate(timeout=100) == ("left\n", None)
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(program.pid, signal.SIGKILL)  # a worker that goes on
    assert program.returncode == 0
    stored = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert stored["reason"] == "interrupted"
    assert "SIGTERM" in stored["message"]


def test_a_copy_of_a_process_that_has_computed_is_refused():
    """Taichi's threads are not copied: it would wait for them for ever."""
    code = """
import multiprocessing, tiny_kernel
import tcontact as tc
tiny_kernel.run()
with multiprocessing.get_context("fork").Pool(1) as pool:
    try:
        pool.apply(tiny_kernel.run)
    except tc.InputError as error:
        print(error)
print(tiny_kernel.run().sum())
"""
    done = python(code)
    assert done.returncode == 0, done.stderr
    assert "spawn" in done.stdout
    assert done.stdout.endswith("6.0\n")


def test_a_material_of_an_own_law_reaches_workers(tmp_path):
    """It does so whatever variable holds the class; a process that has not registered the law is told to."""
    made = tc.register_law("PoolLaw", pool_worker.energy, {"mu": 4e5, "bulk": 2e6})
    (tmp_path / "material").write_bytes(pickle.dumps(made(mu=1e5, bulk=1e6, density=1100.0)))
    register = "tc.register_law('PoolLaw', pool_worker.energy, {'mu': 1e5, 'bulk': 1e6})"
    code = """
import pathlib, pickle, pool_worker
import tcontact as tc
for before in "", sys.argv[2]:
    exec(before)
    try:
        print(pickle.loads(pathlib.Path(sys.argv[1]).read_bytes()))
    except tc.InputError as error:
        print(error)
"""
    done = python(code, tmp_path / "material", register)
    assert done.returncode == 0, done.stderr
    refused, read = done.stdout.splitlines()
    assert "register_law" in refused
    assert read == "PoolLaw(mu=100000.0, bulk=1000000.0, density=1100.0)"


def test_a_program_may_make_errors_of_warnings():
    """Taichi warns while it is imported."""
    code = "import warnings; warnings.simplefilter('error')\nimport tiny_kernel; print(tiny_kernel.run().sum())"
    done = python(code)
    assert (done.returncode, done.stdout) == (0, "6.0\n"), done.stderr


def test_threads_compute_in_turn():
    """Taichi serves one thread at a time: another one found it half started, or waited for ever."""
    code = """
import threading
from concurrent.futures import ThreadPoolExecutor
import numpy as np, pool_worker
import tcontact as tc
together = threading.Barrier(3)
def run(duration):
    together.wait()
    result = tc.simulate(pool_worker.block(duration))
    together.wait()
    result.render()
    return result.position
with ThreadPoolExecutor(3) as pool:
    found = list(pool.map(run, (0.05, 0.1, 0.2)))
for duration, position in zip((0.05, 0.1, 0.2), found):
    print(np.array_equal(tc.simulate(pool_worker.block(duration)).position, position))
"""
    done = python(code)
    assert (done.returncode, done.stdout) == (0, "True\n" * 3), done.stderr
