"""Plot curves of friction layers with matplotlib: as in the paper's Figs. 2 and 3, and error against cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..base.window_backend import import_matplotlib
from ..device.atomic_file import replaced
from .result import LayerResult

COLOURS = ("#1f5fa8", "#2e8b57", "#d98200", "#c03a2b", "#7a4fa0", "#404040")
FLOWING = 1e-9  # relative distance to the yield limit of a node that flows


def yield_limits(path: Path, profiles: Mapping[str, Sequence[LayerResult]]) -> None:
    """Plot the yield limit over the depth at several times, a panel per label; thick where the metal flows (Fig. 2).

    profiles: runs of one cell that end at these times.
    """
    figure, panels = _panels(len(profiles))
    for axes, (label, runs) in zip(panels, profiles.items(), strict=True):
        for run, colour in zip(runs, _fading(len(runs)), strict=True):
            depth, limit = 1e6 * run.depth, 1e-6 * run.yield_stress[0]
            stress = 1e-6 * np.sqrt(3.0) * run.shear_stress[-1, 0]
            flows = limit <= stress * (1.0 + FLOWING)
            axes.plot(depth, limit, color=colour, lw=1.2, label=f"{1e6 * run.time[-1]:.2g} µs")
            axes.plot(depth, np.where(flows, limit, np.nan), color=colour, lw=4.0, alpha=0.6, marker=".", ms=7)
        axes.set_title(f"{label} (thick: plastic flow)", fontsize=9, loc="left")
        axes.set_xlabel("depth [µm]")
        axes.set_ylabel("yield limit [MPa]")
        axes.legend(frameon=False, fontsize=8)
    with replaced(path, synced=False) as part:
        figure.savefig(part, format="png")


def surface(path: Path, runs: Mapping[str, LayerResult], melting_temperature: float) -> None:
    """Plot surface temperature and shear stress against time, a line per label (the paper's Fig. 3)."""
    figure, (left, right) = _panels(2)
    for (label, run), colour in zip(runs.items(), COLOURS, strict=False):
        time = 1e6 * run.time
        left.plot(time, run.surface_temperature[:, 0], color=colour, lw=1.2, label=label)
        right.plot(time, 1e-6 * run.shear_stress[:, 0], color=colour, lw=1.2, label=label)
    left.axhline(melting_temperature, color="#707070", lw=0.8, ls=":")
    left.set_ylabel("surface temperature [K]")
    right.set_ylabel("shear stress [MPa]")
    right.set_ylim(bottom=0.0)
    for axes in (left, right):
        axes.set_xlabel("time [µs]")
        axes.legend(frameon=False, fontsize=8)
    with replaced(path, synced=False) as part:
        figure.savefig(part, format="png")


def error_against_cost(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Plot the error of the surface temperature against time per cell, a panel per speed, a line per method, grid."""
    velocities = sorted({row["velocity"] for row in rows if row["kind"] == "accuracy"})
    figure, panels = _panels(len(velocities))
    for axes, velocity in zip(panels, velocities, strict=True):
        mine = [row for row in rows if row["kind"] == "accuracy" and row["velocity"] == velocity]
        series = dict.fromkeys((row["method"], row["grading"]) for row in mine)
        for (method, grading), colour in zip(series, COLOURS, strict=False):
            for points, marker in zip(sorted({row["points"] for row in mine}), "v^oDsPX", strict=False):
                line = [r for r in mine if (r["method"], r["grading"], r["points"]) == (method, grading, points)]
                line.sort(key=lambda row: row["dt"])
                if line:
                    cost = [1e6 * row["wall_s"] / row["cells"] for row in line]
                    error = [row["temperature_error"] for row in line]
                    name = f"{method}, {'uniform' if grading == 1 else f'graded {grading:g}'}, {points}"
                    axes.loglog(cost, error, color=colour, marker=marker, ms=4, lw=0.8, label=name)
        axes.set_title(f"{velocity:g} m/s, 0.6 µs", fontsize=9, loc="left")
        axes.set_xlabel("time per cell [µs]")
        axes.set_ylabel("error of the surface temperature / its rise")
        axes.legend(frameon=False, fontsize=6)
    with replaced(path, synced=False) as part:
        figure.savefig(part, format="png")


def _fading(count: int) -> list[Any]:
    import_matplotlib()
    from matplotlib import colormaps

    return [colormaps["viridis"](0.9 * k / max(count - 1, 1)) for k in range(count)]


def _panels(count: int) -> tuple[Any, list[Any]]:
    import_matplotlib()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.8 * count, 3.8), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    panels = list(figure.subplots(1, count, squeeze=False)[0])
    for axes in panels:
        axes.grid(True, color="#dddddd", lw=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(labelsize=8)
    return figure, panels
