"""How long the cases take, from the shell to the last file, as `tcontact list -v` says it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tcontact import cases

from ...base.errors import OutputError
from ..bench.collect import machine


def measure(out: Path, say: Callable[[str], None]) -> dict[str, Any]:
    """Run every case twice in processes of their own, into folders below `out`; return what `cases.took` reads.

    The first run has an empty kernel cache, the second one what the first left. Times are those of a wall clock [s].
    Raises `OutputError` for a case that ends with an error; one that fails its own checks counts.
    """
    found = {}
    for name in cases.names():
        with tempfile.TemporaryDirectory(prefix="tcontact-times-") as cache:
            found[name] = [round(_run(name, out / name, cache), 1) for _ in range(2)]
        say(f"{name}: {found[name][0]} s, again {found[name][1]} s")
    about = machine()
    return {"processor": about["processor"], "cores": about["cores"], "seconds": found}


def write(root: Path, times: dict[str, Any]) -> Path:
    """Write the times into the checkout below `root`; return the file."""
    path = root / "cases" / cases.TIMES
    lines = ",\n".join(f'    "{name}": {json.dumps(pair)}' for name, pair in times["seconds"].items())
    head = f'  "processor": {json.dumps(times["processor"])},\n  "cores": {times["cores"]},\n'
    path.write_text(f'{{\n{head}  "seconds": {{\n{lines}\n  }}\n}}\n', encoding="utf-8")
    return path


def _run(name: str, folder: Path, cache: str) -> float:
    """Return the seconds of one run."""
    command = [sys.executable, "-m", "tcontact", "run", name, "--out", str(folder), "--force", "--quiet"]
    start = time.perf_counter()
    done = subprocess.run(
        command,
        env=os.environ | {"TI_OFFLINE_CACHE_FILE_PATH": cache},
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        check=False,
    )
    passed = time.perf_counter() - start
    if done.returncode not in (0, 1):
        raise OutputError(f"`tcontact run {name}` ended with exit code {done.returncode}: {done.stderr.strip()[-300:]}")
    return passed
