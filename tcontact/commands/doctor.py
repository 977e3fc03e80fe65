"""`tcontact doctor`: it looks whether everything is here to run, and whether a small impact comes out right."""

from __future__ import annotations

import argparse
import ctypes
import io
import os
import sys
import tempfile
import time
import warnings
from collections.abc import Sequence
from contextlib import redirect_stdout
from dataclasses import replace
from pathlib import Path
from typing import Any

from .. import cases
from ..base.errors import InputError
from ..device import ranks, runtime
from ..device.team import team
from ..results.report import versions
from . import ranks_report, settings
from .devices import cuda_lines
from .engines import compare_engines

REMEDY = "set XDG_CACHE_HOME, or TI_OFFLINE_CACHE_FILE_PATH, to a folder that can be written and has 64 MB free"
FIRST_STEPS = 1e-3  # share of the duration of a case, about


def add(subparsers: Any) -> None:
    """Declare the command."""
    parser = subparsers.add_parser(
        "doctor",
        help="check this machine",
        description="Show versions and devices, and run a small impact with a known answer.",
    )
    parser.add_argument(
        "--compile",
        action="store_true",
        help="take the first steps of every case and draw a picture, so that later runs find the kernels in the cache:"
        " some minutes",
    )
    parser.add_argument(
        "--engines",
        action="store_true",
        help="make short runs with Taichi and with every installed compiler that can take its place, such as its fork"
        " Quadrants, and compare their bits: some minutes",
    )
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Print what is found; exit code 1 if the self test fails. All ranks do the test, the first one prints."""
    together = team()
    if together is not None:
        for asked in ("compile", "engines"):
            if getattr(arguments, asked):
                ranks.check_single(f"doctor --{asked}")
        found = ranks_report.lines(together, cores())
        with redirect_stdout(sys.stdout if together.leads else io.StringIO()):
            for line in found:
                print(f"{'ranks':<14}{line}", flush=True)
            return checked()
    if arguments.compile and not runtime.takes_files(runtime.kernel_cache()):
        raise InputError("--compile", True, f"the kernel cache {runtime.kernel_cache()} cannot be written; {REMEDY}")
    failed = checked()
    if arguments.compile:
        compile_cases(cases.names())
    if arguments.engines:
        compare_engines()
    return failed


def checked() -> int:
    """Print what is found and do the self test; return the exit code."""
    for name, version in versions().items():
        print(f"{name:<14}{version}")
    print(f"{'cores':<14}{cores()}")
    library = has_library("libX11.so.6")
    print(f"{'libX11':<14}{'found' if library else 'missing; Taichi needs it: apt-get install libx11-6'}")
    if not library:
        return 1
    cache = runtime.kernel_cache()
    if runtime.takes_files(cache):
        size = sum(file.stat().st_size for file in cache.rglob("*") if file.is_file())
        print(f"{'kernel cache':<14}{cache}, {size / 1e6:.1f} MB")
    else:
        print(f"{'kernel cache':<14}{cache} cannot be written, so that every run compiles its kernels anew: {REMEDY}")
    for line in cuda_lines():
        print(f"{'CUDA':<14}{line}")
    return self_test()


def compile_cases(names: Sequence[str]) -> None:
    """Take the first steps of cases, and draw a picture of each: their kernels are then in the kernel cache.

    The cache is written when the process ends.
    """
    import tcontact as tc

    from ..show.render import render_frames

    for name in names:
        case = cases.load(name)
        if not hasattr(case, "scene"):
            continue
        begin = time.perf_counter()
        scene, scheme = case.scene(), settings.scheme({}, case)
        with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            out = Path(folder)
            first = replace(scene, duration=FIRST_STEPS * scene.duration)
            result = tc.simulate(first, scheme=scheme, out=out, frames=1, pressures=True)
            if result.ok:
                render_frames(out / "result.vtkhdf", out)
        print(f"{name:<22}{time.perf_counter() - begin:5.1f} s", flush=True)


def self_test() -> int:
    """Run a bar of 20 cells against its exact solution; print its checks and return the exit code.

    Of several ranks the first one has the end of the bar and checks it.
    """
    import tcontact as tc
    from tcontact.cases import bar_impact

    begin = time.perf_counter()
    result = tc.simulate(bar_impact.scene(cells=20))
    if not ranks.is_first_rank():
        return 0
    checks = bar_impact.checks(result)
    failed = [check for check in checks if not check.passed]
    wall = time.perf_counter() - begin
    error = abs(result.history["energy_error"]).max()
    print(
        f"{'self test':<14}{'FAILED' if failed else 'passed'}: bar impact, {result.steps} steps, {len(checks)} checks,"
        f" energy error {error:.1e}, {wall:.1f} s with {result.compile_s:.1f} s of compilation"
    )
    for check in failed:
        print(f"{'':<14}{check.name}: {check.value} should be {check.bound}")
    return 1 if failed else 0


def cores() -> int:
    """Return the number of CPU cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def has_library(name: str) -> bool:
    """Tell whether the system's loader finds a library."""
    if os.name != "posix" or not Path("/lib").exists():
        return True
    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True
