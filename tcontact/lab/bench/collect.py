"""Collection of a report: start the processes, one after the other, and put together what they found."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import perf_counter
from typing import Any

from ...device import cuda
from ...results.report import versions
from . import alternatives, device_model, driver_calls, small, timing, waiting
from .configuration import Configuration

LONGEST = 3600.0  # [s] that a process may take
NUMPY_THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")
TASKS = {
    "rubbing": "friction of sliding nodes",
    "queries": "gap queries",
    "setup": f"set-up of {waiting.SETUP_SIZE}^3 cells",
    "frames": f"{waiting.FRAMES} frames of a run",
}
Say = Callable[[str], None]


def collect(configurations: Sequence[Configuration], say: Say, quick: bool = False) -> dict[str, Any]:
    """Measure everything; a configuration that fails gives rows with their reason.

    say: told what is measured next. Further rows: other ways to the force, and unless `quick` the bar of 100 cells, the
    friction layer, friction, gap queries, set-up, frames and the start of the main case; compile times unless `quick`.
    """
    rows: list[dict[str, Any]] = []
    compiled: dict[tuple[str, str, str], dict[str, Any]] = {}
    for at in configurations:
        say(f"{at.kind} {at.law} {at.size}^3, {at.threads} threads, contact {' '.join(at.contacts)}")
        found = run_worker("measure", at.to_dict())
        new = found["rows"] if "rows" in found else at.failed(found.get("failed", "no answer"))
        for row in new:
            key = (at.kind, at.law, row["contact"])
            if row["ok"] and key not in compiled and not quick:
                say(f"compile {' '.join(key)}")
                compiled[key] = compile_seconds(*key, at)
            row |= compiled.get(key, {})
        rows += new
    for row in rows:
        _scale(row, rows)
    report: dict[str, Any] = {"machine": machine(), "rows": rows}
    if not configurations:
        return report
    arch = configurations[0].arch
    threads = list(dict.fromkeys(at.threads for at in configurations))
    size = min(alternatives.LARGEST, max(at.size for at in configurations))
    if arch == "cuda":
        report["machine"]["device"] = device()
        kinds, laws = (list(dict.fromkeys(getattr(at, name) for at in configurations)) for name in ("kind", "law"))
        report["model"] = device_model.rows(kinds, laws)
    report["alternatives"] = other_ways(size, threads, arch, say)
    if not quick:
        say(f"bar of {small.BAR_CELLS} cells")
        report["bar"] = [_ok({"threads": n}, run_worker("bar", {"arch": arch, "threads": n})) for n in threads]
        say("friction layer")
        report["layer"] = [_ok({"threads": n}, run_worker("layer", {"arch": arch, "threads": n})) for n in threads]
        for task, text in TASKS.items():
            say(text)
            report[task] = [_ok({"threads": n}, run_worker(task, {"arch": arch, "threads": n})) for n in threads]
        say("start of cube-impact")
        report["start"] = [_ok({"threads": n}, start_seconds(arch, n)) for n in threads[-1:]]
    return report


def other_ways(size: int, threads: Sequence[int], arch: str, say: Say) -> list[dict[str, Any]]:
    """Return what bench/alternatives.py finds for every number of threads, with an empty kernel cache."""
    rows = []
    for count in threads:
        say(f"other ways to the internal force, {size}^3, {count} threads")
        with tempfile.TemporaryDirectory(prefix="tcontact-bench-") as cache:
            found = run_worker("alternatives", {"arch": arch, "threads": count, "size": size}, cache)
        rows.append(_ok({"threads": count}, found))
    return rows


def pairs_of_bodies(size: int, threads: Sequence[int], arch: str, say: Say) -> list[dict[str, Any]]:
    """Return a row of bench/pairs.py for every number of threads, each from a process of its own."""
    rows = []
    for count in threads:
        say(f"two cubes of {size}^3 in contact, {count} threads")
        found = run_worker("pairs", {"arch": arch, "threads": count, "size": size})
        rows.append(_ok({"threads": count}, found))
    return rows


def compile_seconds(kind: str, law: str, contact: str, at: Configuration) -> dict[str, Any]:
    """Return compile_cold_s and compile_warm_s: new processes, with an empty kernel cache and then with a full one."""
    options = {"kind": kind, "law": law, "contact": contact, "arch": at.arch, "threads": at.threads}
    options |= {"precision": at.precision}
    result: dict[str, Any] = {}
    with tempfile.TemporaryDirectory(prefix="tcontact-bench-") as cache:
        for name in ("compile_cold_s", "compile_warm_s"):
            found = run_worker("compilation", options, cache)
            result[name] = found.get("compile_s")
            if "failed" in found:
                result["compile_reason"] = found["failed"]
    return result


def start_seconds(arch: str, threads: int) -> dict[str, Any]:
    """Return seconds with an empty kernel cache ("cold") and then with a full one ("warm"), in new interpreters.

    cold_s, warm_s: import and first step of cube-impact; run_cold_s, run_cold_cpu_s, ..: its default run from the shell
    to the last file, CPU seconds of the whole process beside it.
    """
    result: dict[str, Any] = {}
    with tempfile.TemporaryDirectory(prefix="tcontact-bench-") as folder:
        for name in ("cold", "warm"):
            code = small.FIRST_STEP.format(arch=arch, threads=threads)
            done = _python(["-c", code], threads, f"{folder}/first")
            if done.returncode != 0:
                return {"failed": _last_line(done.stderr)}
            seconds, steps, error = done.stdout.split()
            result |= {f"{name}_s": float(seconds), "steps": int(steps), "energy_error": float(error)}
            words = ["run", "cube-impact", "--arch", arch, "--threads", str(threads), "--out", f"{folder}/{name}"]
            before, begin = os.times(), perf_counter()
            done = _python(["-m", "tcontact", *words], threads, f"{folder}/run")
            after = os.times()
            if done.returncode != 0:
                return {"failed": _last_line(done.stderr)}
            result[f"run_{name}_s"] = perf_counter() - begin
            spent = (getattr(after, part) - getattr(before, part) for part in ("children_user", "children_system"))
            result[f"run_{name}_cpu_s"] = sum(spent)
    return result


def run_worker(task: str, options: dict[str, Any], cache: str | None = None) -> dict[str, Any]:
    """Return the answer of a process of its own; {"failed": reason} if it has none."""
    try:
        done = _python(
            ["-m", "tcontact.lab.bench.worker", json.dumps({"task": task} | options)], options["threads"], cache
        )
    except subprocess.TimeoutExpired:
        return {"failed": f"took longer than {LONGEST:g} s"}
    try:
        return json.loads(done.stdout.splitlines()[-1])
    except (IndexError, ValueError):
        return {"failed": f"exit code {done.returncode}: {_last_line(done.stderr)}"}


def _python(arguments: list[str], threads: int, cache: str | None) -> subprocess.CompletedProcess[str]:
    """Run a process whose NumPy has so many threads, too: idle ones that wait for work spinning would take a core."""
    root = str(Path(__file__).resolve().parents[3])
    paths = [root, *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(paths)}
    environment |= {name: str(max(1, threads)) for name in NUMPY_THREADS}
    if cache is not None:
        environment["TI_OFFLINE_CACHE_FILE_PATH"] = cache
    command = [sys.executable, "-W", "ignore", *arguments]
    with tempfile.TemporaryDirectory(prefix="tcontact-bench-") as folder:
        if driver_calls.is_fake():
            environment.setdefault(driver_calls.LOG, f"{folder}/calls")
        return subprocess.run(
            command,
            env=environment,
            capture_output=True,
            text=True,
            timeout=LONGEST,
            stdin=subprocess.DEVNULL,
            check=False,
        )


def machine() -> dict[str, Any]:
    """Describe the machine that the figures belong to."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    name = platform.processor()
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        name = next(line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    return {"processor": name, "cores": cores, "load": timing.load(), "versions": _versions()}


def device() -> str:
    """Name the GPU that figures belong to, and say if it is none."""
    if driver_calls.is_fake():
        return f"{driver_calls.FAKE} is set: machine code of a GPU run on the CPU, whose times mean nothing"
    try:
        return cuda.find_device().name
    except cuda.NoDevice as error:
        return f"none: {error}"


def _versions() -> dict[str, str]:
    """Return the versions of a run and those of what it is compared with."""
    found = versions()
    for name in ("scipy", "felupe"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found


def _scale(row: dict[str, Any], rows: Sequence[dict[str, Any]]) -> None:
    """Add the rate over that of one thread (another process, minutes apart)."""
    same = ("kind", "law", "size", "arch", "precision", "contact")
    for other in rows:
        if other["ok"] and row["ok"] and other["threads"] == 1 and all(row[n] == other[n] for n in same):
            row["over_one_thread"] = row["rate"]["median"] / other["rate"]["median"]


def _ok(row: dict[str, Any], found: dict[str, Any]) -> dict[str, Any]:
    return row | found | {"ok": "failed" not in found, "reason": found.get("failed", "")}


def _last_line(text: str) -> str:
    return text.strip().splitlines()[-1] if text.strip() else "no message"
