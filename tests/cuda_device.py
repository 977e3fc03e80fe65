"""Finds a CUDA device for the tests: a real one, or one that runs PTX on the CPU, `fake_cuda.sh`.

The latter is looked for at TCONTACT_FAKE_CUDA (the path of the file), else at ../shared/gpu beside the checkout. It
counts launches, copies and waiting, and can run the threads of a launch in reversed order; it needs gcc.
"""

from __future__ import annotations

import ctypes
import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import SHORT

ROOT = Path(__file__).resolve().parent.parent
WORKER = ROOT / "tests" / "cuda_worker.py"
FAKE = Path(os.environ.get("TCONTACT_FAKE_CUDA") or ROOT.parent / "shared" / "gpu" / "fake_cuda.sh")


def real() -> bool:
    """Return whether there is a real device."""
    count = ctypes.c_int(0)
    try:
        driver = ctypes.CDLL("libcuda.so.1")
        return driver.cuInit(0) == 0 and driver.cuDeviceGetCount(ctypes.byref(count)) == 0 and count.value > 0
    except (OSError, AttributeError):
        return False


def missing() -> str:
    """Return why the tests of CUDA cannot run here, "" if they can."""
    if real():
        return ""
    if not FAKE.is_file():
        return "no CUDA device, and no fake_cuda.sh (set TCONTACT_FAKE_CUDA to its path)"
    return "" if shutil.which("gcc") else "no CUDA device; fake_cuda.sh needs gcc"


def register_tool() -> Path:
    """Return the program that counts registers and spills of PTX; the test is skipped where it cannot run."""
    tool = FAKE.parent / "registers.py"
    if real() or not tool.is_file():
        pytest.skip("PTX is kept by fake_cuda.sh alone")
    if importlib.util.find_spec("nvidia") is None and shutil.which("ptxas") is None:
        pytest.skip("no ptxas: pip install 'tcontact[cuda-test]'")
    return tool


def _environment() -> dict[str, str]:
    """Return the environment of a process that runs on the device, and compiles as for a user."""
    found = {name: value for name, value in os.environ.items() if name not in SHORT}
    if not real():
        cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "tcontact" / "ptx"
        tool = ROOT / "tests" / "translated_ptx.py"
        found["FAKE_CUDA_TOOL"] = f"{sys.executable} {tool} {FAKE.parent / 'ptx2c.py'} {cache}"
    return found


def on_ranks(launcher: str, count: int, folder: Path, *command: object) -> None:
    """Run Python with a command on several ranks, each on a device: without hardware one of its own in the folder."""
    start = [launcher, "-n", str(count)]
    if not real():
        start += ["sh", str(ROOT / "tests" / "rank_device.sh"), str(folder), str(FAKE)]
    start += [sys.executable, *map(str, command)]
    environment = _environment() | {"OMP_NUM_THREADS": "1", "PYTHONPATH": str(ROOT)}
    given = {"cwd": ROOT / "tests", "env": environment, "capture_output": True, "text": True, "timeout": 900}
    done = subprocess.run(start, check=False, **given)  # type: ignore[call-overload]
    assert done.returncode == 0, done.stderr[-4000:]


def results(folder: Path, worker: Path = WORKER, watched: bool = False) -> dict[str, np.ndarray]:
    """Run a worker in a process of its own and return what it stored; its modules (PTX) lie in the folder then.

    watched: data races go to the file TCONTACT_RACES (watched_ptx.py).
    """
    environment, command = _environment(), [sys.executable, str(worker), str(folder / "found.npz")]
    if not real():
        environment |= {"FAKE_CUDA_DIR": str(folder), "FAKE_CUDA_LOG": str(folder / "calls")}
        if watched:
            tool = f"{sys.executable} {ROOT / 'tests' / 'watched_ptx.py'} {FAKE.parent / 'ptx2c.py'}"
            environment |= {"FAKE_CUDA_TOOL": tool, "TCONTACT_RACES": str(folder / "races")}
        command = ["sh", str(FAKE), *command]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-4000:]
    with np.load(folder / "found.npz") as found:
        return dict(found)
