"""The bar chart: the whole step beside the plain one, with quartiles, ratio and errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...base.window_backend import import_matplotlib
from ...device.atomic_file import replaced

OURS, TOUCHING, PLAIN, INK = "#1f5fa8", "#d98200", "#b0b0b0", "#303030"


def draw(path: Path, report: Mapping[str, Any]) -> bool:
    """Write the chart as PNG; False if no row has a speed."""
    import_matplotlib()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    bars = _bars(report["rows"])
    if not bars:
        return False
    figure = Figure(figsize=(10.0, 1.6 + 0.34 * len(bars)), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    place, longest = np.arange(len(bars))[::-1], max(bar["high"] for bar in bars)
    for y, bar in zip(place, bars, strict=True):
        axes.barh(y, bar["median"], height=0.72, color=bar["colour"])
        axes.plot([bar["low"], bar["high"]], [y, y], color=INK, lw=1.2, marker="|", ms=6)
        axes.text(bar["high"] + 0.012 * longest, y, bar["text"], va="center", fontsize=8, color=INK)
    axes.set_yticks(place, [bar["label"] for bar in bars], fontsize=8)
    axes.set_ylim(-0.7, len(bars) - 0.3)
    axes.set_xlim(0.0, 1.68 * longest)
    where = f"{report['machine']['processor']}, {report['machine']['cores']} cores"
    axes.set_xlabel(f"million cell updates a second, whole step: median and quartiles ({where})")
    axes.grid(axis="x", color="#e4e4e4", lw=0.8)
    axes.set_axisbelow(True)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.tick_params(axis="y", length=0)
    names = {OURS: "tcontact, with history", TOUCHING: "with massless contact on one face", PLAIN: "plain kernel"}
    used = {bar["colour"] for bar in bars}
    patches = [Patch(color=colour, label=name) for colour, name in names.items() if colour in used]
    figure.legend(handles=patches, loc="outside upper center", ncols=3, frameon=False, fontsize=9)
    with replaced(path, synced=False) as part:
        figure.savefig(part, format="png", dpi=130)
    return True


def _bars(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    bars = []
    for row in rows:
        if not row["ok"]:
            continue
        alone = row["contact"] == "none"
        label = f"{row['kind']}  {row['law']}  {row['size']}³  {row['threads']} thr" if row["arch"] == "cpu" else ""
        label = label or f"{row['kind']}  {row['law']}  {row['size']}³  {row['arch']}"
        errors = f"force error {row['force_error']:.0e}, energy error {row['energy_error']:.0e}"
        if alone:
            text = f"{row['ratio_to_plain']['median']:.2f} × plain;  {errors}"
            bars.append(_bar(row["rate"], OURS, label, text))
            off = f"differs from the step by {row['plain_error']:.0e}"
            bars.append(_bar(row["plain_rate"], PLAIN, "plain", off))
        else:
            text = f"contact {100 * row['contact_share']['median']:.0f} % of the step;  {errors}"
            bars.append(_bar(row["rate"], TOUCHING, f"{label}  {row['contact']} removal", text))
    return bars


def _bar(rate: Mapping[str, float], colour: str, label: str, text: str) -> dict[str, Any]:
    found = {"median": "median", "low": "first_quartile", "high": "third_quartile"}
    return {name: 1e-6 * rate[key] for name, key in found.items()} | {"colour": colour, "label": label, "text": text}
