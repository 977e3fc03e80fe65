"""`tcontact doctor --engines`: short runs on each installed compiler that can take the place of Taichi.

The kernels import their compiler in one module, `kernels/engine.py`. The same runs go through each compiler, each in a
process of its own, and the bits of their histories are compared with those of Taichi. A compiler that fails is reported
and is no failure of the machine: Taichi is the one that is supported.
"""

from __future__ import annotations

import hashlib
import importlib.util
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from .. import cases
from ..device import runtime

ENGINES = ("taichi", "quadrants")
SHORT = {
    "bar-impact": {"cells": 20},
    "tumbling-block": {"cells": 2},
    "two-cubes": {"cells": 2},
    "taylor-bar": {"cells": 2},
    "sliding-block": {"cells": 2},
}
SHARE = 0.1  # of the duration of a case
LIMIT = 600.0  # seconds for one compiler


def compare_engines() -> None:
    """Print a line for each compiler: its version, what runs, and whether the histories have the bits of Taichi's."""
    expected: dict[str, str] = {}
    for name in ENGINES:
        if importlib.util.find_spec(name) is None:
            print(f"{name:<14}not installed (pip install {name})")
            continue
        found = digests(name)
        expected = expected or found["runs"]
        same = [case for case in SHORT if found["runs"].get(case) == expected.get(case, "")]
        print(f"{name:<14}{found['version']}: {len(found['runs'])} of {len(SHORT)} runs, {len(same)} with equal bits")
        for case, error in found["errors"].items():
            print(f"{'':<14}{case}: {error}")


def digests(engine: str, names: Sequence[str] = tuple(SHORT)) -> dict[str, Any]:
    """Return the version of a compiler, the digests of the histories by case, and what went wrong, from a new process.

    engine: name of a module with the language of Taichi; names: cases of `SHORT`.
    """
    command = [sys.executable, "-m", __name__, *names]
    environment = os.environ | {"TCONTACT_ENGINE": engine}
    try:
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=LIMIT)
        return dict(json.loads(done.stdout.splitlines()[-1]))
    except subprocess.TimeoutExpired:
        error = f"no answer within {LIMIT:g} s"
    except (IndexError, ValueError):
        error = (done.stderr.strip().splitlines() or ["no answer"])[-1]
    return {"version": "does not run", "runs": {}, "errors": {"all": error}}


def _run(names: Sequence[str]) -> dict[str, Any]:
    """Take the first steps of cases in this process."""
    import tcontact as tc

    engine = runtime.start(threads=1)
    runs, errors = {}, {}
    for name in names:
        scene = cases.load(name).scene(**SHORT[name])
        try:
            result = tc.simulate(replace(scene, duration=SHARE * scene.duration))
        except Exception as error:
            errors[name] = f"{type(error).__name__}: {error}"
            continue
        history = result.history
        digest = hashlib.sha256()
        for column in sorted(history):
            digest.update(history[column].tobytes())
        runs[name] = digest.hexdigest()
    version = ".".join(str(part) for part in engine.__version__)
    return {"version": version, "runs": runs, "errors": errors}


if __name__ == "__main__":
    print(json.dumps(_run(sys.argv[1:])))
