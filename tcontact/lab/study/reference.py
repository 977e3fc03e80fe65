"""A fine run as reference where no exact solution is known: computed once, kept in the user's cache folder, dated."""

from __future__ import annotations

import hashlib
import json
import os
import warnings
from collections.abc import Callable
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...device import runtime
from ...results.report import plain, versions
from .methods import method
from .setting import Study, build

METHOD = "massless-normal"


def folder() -> Path:
    """Return where references are kept: tcontact/references in the user's cache folder (XDG_CACHE_HOME)."""
    return runtime.user_cache() / "references"


def prepare(study: Study, say: Callable[[str], None]) -> tuple[dict[str, np.ndarray] | None, dict[str, Any]]:
    """Return the reference of the study and its description; None where the problem has an exact solution.

    A problem that needs one has `reference(result)` (arrays to keep), FINER (times the largest size) and REFERENCE_CFL.
    Raises `InputError` if the fine run does not finish.
    """
    problem = study.problem
    if not hasattr(problem, "reference"):
        return None, {"kind": "exact", "what": problem.REFERENCE}
    size = problem.FINER * max(study.sizes)
    about = {
        "kind": "self-converged",
        "what": f"{METHOD}, size {size}, cfl {problem.REFERENCE_CFL:g}",
        "case": study.name,
        "parameters": study.parameters,
        "version": versions()["tcontact"],
    }
    key = hashlib.sha256(json.dumps(plain(about), sort_keys=True).encode()).hexdigest()[:16]
    path = folder() / f"{study.name}-{size}-{key}.npz"
    kept = _read(path)
    if kept is not None:
        arrays, made = kept
        say(f"reference {about['what']}, of {made}")
        return arrays, about | {"made": made, "file": path.name}
    import tcontact as tc

    say(f"reference {about['what']}: computing")
    chosen = method(METHOD)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = tc.simulate(
            build(study, chosen, size), scheme=chosen.scheme(problem.REFERENCE_CFL), threads=study.threads
        )
    if not result.ok:
        raise InputError("--sizes", size, f"the reference run ended as {result.reason}: {result.message}")
    arrays, made = problem.reference(result), datetime.now(timezone.utc).isoformat(timespec="seconds")
    _write(path, arrays, made)
    return arrays, about | {"made": made, "file": path.name, "wall_s": result.wall_s}


def _read(path: Path) -> tuple[dict[str, np.ndarray], str] | None:
    try:
        with np.load(path, allow_pickle=False) as data:
            found = {name: data[name] for name in data.files}
        return found, str(found.pop("made"))
    except (OSError, ValueError, KeyError):
        return None  # absent or damaged: computed anew


def _write(path: Path, arrays: dict[str, np.ndarray], made: str) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        partial = path.with_name(f"{path.stem}.{os.getpid()}.npz")
        np.savez(partial, made=np.array(made), **arrays)  # type: ignore[arg-type]
        partial.replace(path)
    except OSError:
        pass  # no place to keep it: the next study computes it again
