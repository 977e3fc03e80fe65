"""Rows of the report from measured seconds: rates, ratios within a round, shares, errors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...mesh.mesh import Mesh
from ...results.result import Result
from .configuration import Configuration
from .device_model import VARIANTS, moved_bytes
from .timing import spread

NODE_BYTES = 3 * 8 + 2 * 3 * 8 + 2 * 3 * 8 + 8 + 4 + 2 * 3 * 8  # X; u and v in and out; m; info; force out and in


def step_bytes(mesh: Mesh) -> float:
    """Return the bytes per cell that a step must touch: connectivity, and per node X, u, v, m, place and force."""
    return 4.0 * mesh.cells.shape[1] + NODE_BYTES * mesh.node_count / mesh.cell_count


def rows_of(
    configuration: Configuration,
    taken: Mapping[str, np.ndarray],
    results: Mapping[str, Result],
    parts: Mapping[str, Mapping[str, float]],
    found: Mapping[str, Any],
    failures: Mapping[str, str],
    calls: Mapping[str, Mapping[str, float]],
) -> list[dict[str, Any]]:
    """Return a row per contact asked for; taken: seconds [rounds] a unit by work: "step none", "kernel", "plain", ..

    calls: of the driver of a GPU in a step, by contact, where they are logged.
    """
    rows = []
    for contact in configuration.contacts:
        row = configuration.row(contact)
        if contact in failures:
            rows.append(row | {"ok": False, "reason": failures[contact]})
            continue
        row |= {"ok": True, "reason": "", "parts_s": dict(parts[contact])}
        if calls[contact]:
            row["calls_per_step"] = dict(calls[contact])
        rows.append(row | _row(configuration, contact, taken, results[contact], parts[contact]) | dict(found))
    return rows


def _row(
    configuration: Configuration,
    contact: str,
    taken: Mapping[str, np.ndarray],
    result: Result,
    parts: Mapping[str, float],
) -> dict[str, Any]:
    cells, step = configuration.cells, taken[f"step {contact}"]
    free, plain, copy = taken["step none"], taken["plain"], taken["copy"]
    touched = step_bytes(result.scene.bodies[0].mesh)
    if configuration.arch == "cuda" and configuration.kind in VARIANTS:
        moved = moved_bytes(configuration.kind, configuration.size)
        touched = (moved.read + moved.written) / cells
    row: dict[str, Any] = {
        "rate": spread(cells / step),
        "step_s": spread(step),
        "energy_error": float(np.abs(result.history["energy_error"]).max()),
        "static_residual": float(result.history["static_residual"].max()),
        "sweeps": float(result.history["sweeps"].mean()),
        "bytes_per_cell": sum(result.memory.values()) / cells,
        "memory_bytes": dict(result.memory),
        "plain_rate": spread(cells / plain),
        "ratio_to_plain": spread(plain / step),
        "kernel_rate": spread(cells / taken["kernel"]),
        "kernel_ratio_to_plain": spread(plain / taken["kernel"]),
        "copy_bytes_per_s": spread(1.0 / copy),
        "step_bytes_per_cell": touched,
        "roofline_share": spread(touched * cells * copy / step),
    }
    if contact == "none" and "no energy" in taken:
        looks = parts.get("stable step", 0.0)  # at the stability of dt: they are no part of the ledger
        row["ledger_share"] = spread(1.0 - (taken["no energy"] + looks) / step)
        row["ledger_energy_share"] = spread((taken["kernel"] - taken["no energy"]) / step)
        row["ledger_host_share"] = spread(1.0 - (taken["kernel"] + looks) / step)
    elif contact != "none":
        row["contact_share"] = spread(1.0 - free / step)
    return row
