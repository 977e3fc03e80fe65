"""Our internal force beside that of FElupe, of SciPy's CSR product and of the plain kernel, timed in turns.

All methods have the same cells, whose shapes differ, in the same order, the same displacements and threads. What is not
installed keeps a row that says so.
"""

from __future__ import annotations

import gc
import tracemalloc
from collections.abc import Callable, Sequence
from time import perf_counter
from typing import Any

import numpy as np

from ...device import runtime
from ...planning.planning import plan
from . import accuracy, blocks, others, timing
from .columns import columns

KINDS = ("hex8-distorted", "tet4")
BATCH_SECONDS, ROUNDS = 0.05, 7
LARGEST = 40  # cells along an edge in a report of everything: a larger matrix takes too much memory
OURS = "tcontact"
# method -> function that prepares it, package to install (None: there always), what it does
METHODS: dict[str, tuple[Callable[..., others.Force], str | None, str]] = {
    OURS: (others.ours, None, "the force pass of the explicit step, with the energy of its ledger"),
    "plain Taichi": (others.plain, None, "a loop over the cells with atomic adds to the nodes"),
    "FElupe": (
        others.felupe,
        "felupe",
        "SolidBody.assemble.vector: gradients of all points kept, stresses by NumPy in new arrays, a sparse vector",
    ),
    "SciPy CSR": (
        others.scipy,
        "scipy",
        "K u with the assembled matrix, for small strains only, on one thread whatever their number",
    ),
}
OF_A_LAW = {
    "neo-hookean": (OURS, "plain Taichi", "FElupe"),
    "linear": (OURS, "plain Taichi", "SciPy CSR"),
}


def alternatives(arch: str, threads: int, size: int, kinds: Sequence[str] = KINDS) -> dict[str, Any]:
    """Return a row for each kind of cells, law and method at a cube of size^3 hexes (six tets for each).

    `rate`: cells a second; `times_ours`: time over that of our pass, round by round; `force_error`: largest difference
    to our force over the largest force; `held_bytes`, `peak_bytes`: memory between and during the calls; `ready_s`:
    time until the first force: compilation, shape functions, assembly of the matrix.
    """
    runtime.start(arch, threads)
    load, rows = timing.load(), []
    for law, methods in OF_A_LAW.items():
        for kind in kinds:
            rows += [row | {"threads": threads} for row in _rows(kind, law, size, threads, methods)]
    return {"rows": rows, "load": [load, timing.load()]}


def _rows(kind: str, law: str, size: int, threads: int, methods: Sequence[str]) -> list[dict[str, Any]]:
    scene, displacement = blocks.shaken(kind, law, size)
    body = plan(scene).bodies[0]
    u = displacement[body.node_order].ravel()
    rows, works, forces = [], {}, {}
    for name in methods:
        make, package, _ = METHODS[name]
        row: dict[str, Any] = {"kind": kind, "law": law, "size": size, "cells": len(body.cells), "method": name}
        rows.append(row | {"installed": True, "ok": True, "reason": ""})
        try:
            found, works[name], forces[name] = _prepared(make, body, u, threads)
            rows[-1] |= found
        except ImportError as error:
            install = f"pip install {package}, or the extra tcontact[compare]"
            rows[-1] |= {"installed": False, "reason": f"not installed ({error}): {install}"}
        except Exception as error:  # another version of the package; the other methods go on
            rows[-1] |= {"ok": False, "reason": f"{type(error).__name__}: {error}"}
    taken = timing.rounds(works, 0.0, ROUNDS) if OURS in works else {}
    for row in rows:
        if row["method"] in taken:
            mine = taken[row["method"]]
            row["rate"] = timing.spread(row["cells"] / mine)
            row["times_ours"] = timing.spread(mine / taken[OURS])
            row["force_error"] = accuracy.difference(forces[row["method"]], forces[OURS])
    return rows


def _prepared(
    make: Callable[..., others.Force], body: Any, u: np.ndarray, threads: int
) -> tuple[dict[str, Any], timing.Work, np.ndarray]:
    """Return columns of a row, the work to time and the force [3n] [N]; raises what the package raises."""
    begin = perf_counter()
    force = make(body, u, threads)
    force()
    ready, begin = perf_counter() - begin, perf_counter()
    value = force()
    once = perf_counter() - begin
    value = np.asarray(value.todense() if hasattr(value, "todense") else value).ravel()
    held, peak = _memory(lambda: make(body, u, threads))
    work = timing.batch(force, max(1, round(BATCH_SECONDS / once)), runtime.load().sync)
    return {"ready_s": ready - once, "held_bytes": held, "peak_bytes": peak}, work, value


def _memory(make: Callable[[], others.Force]) -> tuple[int, int]:
    """Return the bytes of Python and NumPy that a method holds between calls and at the peak of a call.

    A second one is made for that: what counts bytes takes time.
    """
    gc.collect()
    tracemalloc.start()
    try:
        force = make()
        gc.collect()
        held = tracemalloc.get_traced_memory()[0]
        tracemalloc.reset_peak()
        force()
        return held, tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def lines(found: Sequence[dict[str, Any]]) -> list[str]:
    """Return the rows of all thread counts as text, with what each method does."""
    text = []
    for part in found:
        if not part["ok"]:
            text.append(f"other ways to the force, {part['threads']} threads: FAILED: {part['reason']}")
    rows = [row for part in found if part["ok"] for row in part["rows"]]
    if rows:
        text += ["internal force at random displacements, beside what could be used instead, in the same rounds"]
        text += columns([_cells(row) for row in rows])
        text += [f"{row['method']}, {row['kind']}: FAILED: {row['reason']}" for row in rows if not row["ok"]]
        text += list(dict.fromkeys(f"{row['method']}: {row['reason']}" for row in rows if not row["installed"]))
        text += [
            "x ours       time over that of tcontact, round by round",
            "differs      largest difference to the force of tcontact over its largest value",
            "MB           held between calls, and at the peak of one; Taichi's own is in neither",
            "ready s      until the first force, beyond a call: compilation with an empty kernel cache, shape",
            "             functions, assembly of the matrix",
            *(f"{name:<12} {METHODS[name][2]}" for name in dict.fromkeys(row["method"] for row in rows)),
        ]
    return text


def _cells(row: dict[str, Any]) -> dict[str, str]:
    cells = {name: str(row[name]) for name in ("kind", "law", "size")}
    cells |= {"thr": str(row["threads"]), "method": row["method"]}
    if "rate" not in row:
        return cells | {"Mcell/s": "FAILED" if not row["ok"] else "not installed" if not row["installed"] else "-"}
    rate = {name: 1e-6 * row["rate"][name] for name in ("median", "first_quartile", "third_quartile")}
    return cells | {
        "Mcell/s": f"{rate['median']:.3g} [{rate['first_quartile']:.3g}, {rate['third_quartile']:.3g}]",
        "x ours": f"{row['times_ours']['median']:.2f}",
        "differs": f"{row['force_error']:.1e}",
        "MB held": f"{1e-6 * row['held_bytes']:.1f}",
        "MB peak": f"{1e-6 * row['peak_bytes']:.1f}",
        "ready s": f"{row['ready_s']:.1f}",
    }
