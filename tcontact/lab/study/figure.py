"""The work-precision figure: error over wall time, a line per method; beside it the energy error of the same runs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...base.window_backend import import_matplotlib
from ...device.atomic_file import replaced

COLOURS = ("#1f5fa8", "#d98200", "#2e8b57", "#c03a2b", "#7a4fa3", "#707070", "#00939c", "#8c5a2b", "#b8860b", "#303030")
MARKERS = "osD^vP*Xhd"


def draw(path: Path, report: Mapping[str, Any]) -> bool:
    """Write the figure as PNG; False if no run has an error. Runs that failed are hollow."""
    import_matplotlib()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    name = report["error"]
    measured = [row | {"error": row["errors"][name]} for row in report["rows"] if name in row.get("errors", {})]
    rows = [row for row in measured if isinstance(row["error"], float) and row["wall_s"] > 0.0]
    if not rows:
        return False
    figure = Figure(figsize=(10.5, 5.0), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2)
    for number, method in enumerate(dict.fromkeys(row["method"] for row in rows)):
        colour, marker = COLOURS[number % len(COLOURS)], MARKERS[number % len(MARKERS)]
        for cfl in dict.fromkeys(row["cfl"] for row in rows):
            mine = [row for row in rows if row["method"] == method and row["cfl"] == cfl]
            for axes, key in ((left, "error"), (right, "energy_error")):
                shown = [row for row in mine if isinstance(row[key], float) and row[key] > 0.0]
                label = method if axes is left and cfl == rows[0]["cfl"] else None
                style = {"color": colour, "marker": marker, "ms": 5.5}
                axes.plot([row["wall_s"] for row in shown], [row[key] for row in shown], lw=1.1, label=label, **style)
                failed = [row for row in shown if row["failure"]]
                places = [row["wall_s"] for row in failed], [row[key] for row in failed]
                axes.plot(*places, ls="none", mfc="white", **style)
    main = name.removesuffix("_error").replace("_", " ")
    for axes, text in ((left, f"{main} error"), (right, "energy error")):
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel(f"wall time after compiling [s], {report['threads']} thread{'s' * (report['threads'] != 1)}")
        axes.set_ylabel(text)
        axes.grid(which="major", color="#e0e0e0", lw=0.8)
        axes.set_axisbelow(True)
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
    hollow = "; hollow: failed" if any(row["failure"] for row in rows) else ""
    left.set_title(f"{report['case']}, a point per size{hollow}", fontsize=9, loc="left", color="#606060")
    figure.legend(loc="outside lower center", ncols=4, frameon=False, fontsize=8.5)
    with replaced(path, synced=False) as part:
        figure.savefig(part, format="png", dpi=130)
    return True
