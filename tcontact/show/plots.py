"""Curves of a run by matplotlib: contact force, gap and penetration, energies. Nothing is smoothed or filtered."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.window_backend import import_matplotlib
from ..device.atomic_file import replaced
from ..kernels.columns import COLUMNS
from ..results.acting_force import acting_force, pair_forces, partner_forces
from ..results.report import si_scale
from ..results.tables import AXES
from .render.png import write_png
from .texts import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLUE, RED, GREEN, ORANGE, GREY = "#1f5fa8", "#c03a2b", "#2e8b57", "#d98200", "#707070"
PURPLE, BROWN, VIOLET = "#7d3c98", "#8b5a2b", "#c71585"
ENERGIES = {
    "kinetic": BLUE,
    "elastic": GREEN,
    "contact": RED,
    "friction_work": ORANGE,
    "damping_work": PURPLE,
    "viscous_work": BROWN,
    "external_work": GREY,
}
TIME = ("time", "s")
GAP_ROUNDING = 1e-12  # gap over the size of the bodies, or over the widest gap, below which there is none
FORCE_ROUNDING = 1e-9  # contact force times the size of the bodies over their elastic energy, the same
Curves = Mapping[str, tuple[np.ndarray, np.ndarray]]
History = Mapping[str, np.ndarray]


def contact_force(
    path: Path,
    history: History,
    normals: Sequence[np.ndarray],
    known: Curves | None = None,
    title: str = "",
    size: float = 0.0,
) -> None:
    """Plot the contact force over time, with curves it can be judged by if there are any.

    With several obstacles or pairs of bodies each has a curve with its name. size: of the bodies [m]; a force below the
    rounding that belongs to it and to the elastic energy is called so and not drawn as noise.
    """
    figure, (axes,) = _figure(1, title)
    draw_force(axes, history, normals, known, size)
    time, unit = _time(history)
    _finish(figure, [axes], time, unit[1], path)


def draw_force(
    axes: Axes, history: History, normals: Sequence[np.ndarray], known: Curves | None = None, size: float = 0.0
) -> None:
    """Draw the curves of `contact_force` on axes."""
    time, unit = _time(history)
    force = force_component(history, normals)
    known = known or {}
    parts = {name: np.linalg.norm(values, axis=1) for name, values in part_forces(history).items()}
    drawn = [force, *(values for _, values in known.values()), *parts.values()]
    largest = max(float(np.nanmax(np.abs(values), initial=0.0)) for values in drawn)
    noise = FORCE_ROUNDING * float(np.nanmax(history["elastic"], initial=0.0)) / size if size else 0.0
    if largest <= noise:
        below = f": below its rounding of {_figures(noise, 'N')}" if largest else ""
        _nothing(axes, f"no resultant contact force{below}")
        axes.set_yticks([0.0])
        axes.set_ylabel("contact force [N]")
        return
    factor, prefix = si_scale(largest)
    along = _tangential(history, normals)
    if not parts:
        axes.plot(time, force / factor, color=BLUE, lw=1.0, label="computed" if along is None else "normal")
    for (name, values), color in zip(parts.items(), itertools.cycle((BLUE, ORANGE, GREEN, PURPLE, BROWN, VIOLET))):
        axes.plot(time, values / factor, color=color, lw=1.0, label=plain(name))
    for label, (times, values) in known.items():
        axes.plot(times / unit[0], values / factor, color=RED, lw=1.0, ls="--", label=label)
    if along is not None:
        color, label = (GREY, "friction on the obstacles") if parts else (ORANGE, "friction")
        axes.plot(time, along / factor, color=color, lw=1.0, label=label)
    if known or parts or along is not None:
        axes.legend(loc="best", frameon=False)
    if np.nanmin(force, initial=0.0) >= 0.0 and np.isfinite(force).all():
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))  # small changes of a large force should look small
    axes.set_ylabel(f"contact force {'on the body ' if len(normals) == 1 else ''}[{_greek(prefix)}N]")


def gap(path: Path, history: History, title: str = "", size: float = 0.0) -> None:
    """Plot the smallest gap (penetration where negative) and the number of nodes in contact.

    size: of the bodies [m]; gaps below their rounding are called so and not drawn as noise.
    """
    import_matplotlib()
    from matplotlib.ticker import MaxNLocator

    figure, (upper, lower) = _figure(2, title)
    time, unit = _time(history)
    draw_gap(upper, history, size)
    lower.plot(time, history["contact_nodes"], color=BLUE, lw=1.0, drawstyle="steps-post")
    lower.set_ylabel("nodes in contact")
    lower.set_ylim(bottom=0.0)
    lower.yaxis.set_major_locator(MaxNLocator(integer=True))
    _finish(figure, [upper, lower], time, unit[1], path)


def draw_gap(axes: Axes, history: History, size: float = 0.0) -> None:
    """Draw the smallest gap of `gap` on axes."""
    time, _ = _time(history)
    smallest = np.where(np.isinf(history["gap_min"]), np.nan, history["gap_min"])  # nothing is near: no curve
    widest = float(np.nanmax(np.abs(smallest), initial=0.0))
    rounding = GAP_ROUNDING * max(widest, size)
    factor, prefix = si_scale(widest)
    axes.axhline(0.0, color=GREY, lw=0.8)
    if widest > rounding:
        axes.plot(time, smallest / factor, color=BLUE, lw=1.0)
        axes.fill_between(time, np.minimum(smallest, 0.0) / factor, 0.0, color=RED, alpha=0.35, lw=0)
        axes.set_ylabel(f"smallest gap [{_greek(prefix)}m]")
    else:
        _nothing(axes, f"neither gap nor penetration: below their rounding of {_figures(rounding, 'm')}")
        axes.set_yticks([0.0])
        axes.set_ylabel("smallest gap [m]")
    deepest = max(0.0, -float(np.nanmin(smallest, initial=0.0)))
    depth = f"deepest penetration {_figures(deepest, 'm')}" if deepest > rounding else "no penetration"
    axes.set_title(depth, fontsize=9, loc="right", color=GREY)


def energy(path: Path, history: History, title: str = "") -> None:
    """Plot the energies over time, and the energy error below."""
    figure, (upper, lower) = _figure(2, title)
    time, unit = _time(history)
    draw_energies(upper, history)
    lower.axhline(0.0, color=GREY, lw=0.8)
    lower.plot(time, history["energy_error"], color=BLUE, lw=0.9)
    lower.set_ylabel("energy error [-]")
    lower.ticklabel_format(axis="y", style="sci", scilimits=(-2, 2))
    _finish(figure, [upper, lower], time, unit[1], path)


def draw_energies(axes: Axes, history: History) -> None:
    """Draw the energies of the ledger and their sum on axes, each with its name at its end."""
    time, _ = _time(history)
    parts = [column for kind in ("stored", "dissipated", "supplied") for column in COLUMNS if column.energy == kind]
    signs = {column.name: (-1.0, "− ") if column.energy == "supplied" else (1.0, "") for column in parts}
    present = [name for name in signs if name in history and np.any(history[name])]
    factor, prefix = si_scale(float(max(np.nanmax(np.abs(history[name])) for name in ["energy", *present])))
    ends: dict[str, tuple[float, str]] = {}
    for name in present:
        (sign, mark), color = signs[name], ENERGIES.get(name, VIOLET)  # the sign with which it enters the sum
        curve, label = sign * history[name] / factor, mark + name.replace("_", " ")
        axes.plot(time, curve, color=color, lw=1.1, label=label)
        ends[label] = float(curve[-1]), color
    total = history["energy"] / factor
    axes.plot(time, total, color="black", lw=1.1, ls=(0, (4, 2)), label="sum")
    ends["sum"] = float(total[-1]), "black"
    axes.set_ylabel(f"energy [{_greek(prefix)}J]")
    _label_ends(axes, ends)


def draw_column(axes: Axes, history: History, name: str, unit: str) -> None:
    """Draw a column of the history on axes, a vector as a curve for each axis."""
    time, _ = _time(history)
    values = history[name].reshape(len(time), -1)
    bare = unit in ("1", "") or unit.startswith("kg")  # without a prefix
    factor, prefix = (1.0, "") if bare else si_scale(float(np.nanmax(np.abs(values), initial=0.0)))
    count = values.shape[1]
    names = [""] if count == 1 else AXES.get(count, map(str, range(count)))
    for part, label, color in zip(values.T, names, itertools.cycle((BLUE, ORANGE, GREEN, PURPLE, BROWN, VIOLET))):
        axes.plot(time, part / factor, color=color, lw=1.0, label=label)
    if count > 1:
        axes.legend(loc="best", frameon=False)
    mark = f" [{_greek(prefix)}{unit}]" if unit not in ("1", "") else ""
    axes.set_ylabel(plain(name.replace("_", " ")) + mark)


def time_axis(axes: Axes, history: History) -> None:
    """Write the name and unit of the time below axes."""
    axes.set_xlabel(f"time [{_time(history)[1][1]}]")
    axes.grid(True, color="#dddddd", lw=0.6)


def comparison(path: Path, runs: Mapping[str, History], normals: Sequence[np.ndarray]) -> None:
    """Plot runs side by side on the same scales: contact force, penetration, penetration energy."""
    rows = {
        "contact force": ("N", lambda history: force_component(history, normals)),
        "penetration": ("m", _penetration),
        "penetration energy": ("J", lambda history: history["contact"]),
    }
    figure, grid = _grid(len(rows), len(runs))
    _, unit = _time(next(iter(runs.values())))
    for row, (title, (name, column)) in enumerate(rows.items()):
        factor, prefix = si_scale(
            max(float(np.nanmax(np.abs(column(history)), initial=0.0)) for history in runs.values())
        )
        for number, (axes, (label, history)) in enumerate(zip(grid[row], runs.items(), strict=True)):
            color = (BLUE, RED, GREEN, ORANGE, PURPLE, BROWN)[number % 6]
            values = column(history)
            axes.plot(history["time"] / unit[0], values / factor, color=color, lw=0.8)
            if not np.any(values):
                _nothing(axes, "none")
            if row == 0:
                error = float(np.nanmax(np.abs(history["energy_error"])))
                up_and_down = f"$\\sum|\\Delta F|\\,/\\,2F_{{max}}$ = {unrest(column(history)):.3g}"
                figures = f"{up_and_down}, energy error {error:.1e}"
                axes.set_title(f"{plain(label)}\n{len(history['time']) - 1} steps, {figures}", fontsize=9)
        grid[row][0].set_ylabel(f"{title}\n[{_greek(prefix)}{name}]")
    for axes in grid[-1]:
        axes.set_xlabel(f"time [{unit[1]}]")
    _save(figure, path)


def panels(path: Path, rows: Mapping[tuple[str, str], Curves], title: str = "", along: tuple[str, str] = TIME) -> None:
    """Plot quantities over time, one panel each: {(name, unit): {label: (times [s], values)}}.

    along: name and unit of what stands in place of the time.

    A panel with the labels of the one before it goes without a legend of its own.
    """
    figure, drawn = _figure(len(rows), title)
    end = max(float(times[-1]) for curves in rows.values() for times, _ in curves.values())
    span, mark = si_scale(end)
    explained: list[str] = []
    for axes, ((name, unit), curves) in zip(drawn, rows.items(), strict=True):
        largest = max(float(np.nanmax(np.abs(values), initial=0.0)) for _, values in curves.values())
        factor, prefix = si_scale(largest if unit != "-" else 1.0)
        for number, (label, (times, values)) in enumerate(curves.items()):
            color, style = ((BLUE, "-"), (RED, "--"), (GREEN, ":"), (ORANGE, "-."))[number % 4]
            axes.plot(times / span, values / factor, color=color, lw=1.0, ls=style, label=label)
        axes.set_ylabel(f"{name} [{_greek(prefix)}{unit}]")
        if list(curves) != explained:
            axes.legend(loc="best", frameon=False)
            explained = list(curves)
    _finish(figure, drawn, np.array([0.0, end / span]), f"{_greek(mark)}{along[1]}", path, along[0])


def outlines(path: Path, lines: Curves, title: str = "") -> None:
    """Plot outlines of a round body, height over radius: {label: (radii [m], heights [m])}."""
    figure, (axes,) = _figure(1, title)
    factor, prefix = si_scale(max(float(np.abs(values).max()) for pair in lines.values() for values in pair))
    for (label, (radius, height)), colour in zip(lines.items(), itertools.cycle((GREY, BLUE, RED, ORANGE, PURPLE))):
        axes.plot(radius / factor, height / factor, color=colour, lw=1.1, label=label)
    axes.set_xlabel(f"radius [{_greek(prefix)}m]")
    axes.set_ylabel(f"height [{_greek(prefix)}m]")
    axes.legend(loc="best", frameon=False, fontsize=8)
    _save(figure, path)


def energies(path: Path, runs: Mapping[str, History]) -> None:
    """Plot the energies of runs over the one at the start: on their own scale above, around 1 below."""
    figure, (upper, lower) = _figure(2, "")
    longest = max(runs.values(), key=lambda history: float(history["time"][-1]))
    _, unit = _time(longest)
    colours = (BLUE, RED, GREEN, ORANGE, PURPLE, BROWN, GREY, "#00939c", "#303030")
    for number, (label, history) in enumerate(runs.items()):
        share = history["energy"] / history["energy"][0]
        style: dict[str, Any] = {"color": colours[number % len(colours)], "lw": 1.1, "ls": ("-", "--")[number // 5 % 2]}
        upper.plot(history["time"] / unit[0], share, label=label, **style)
        lower.plot(history["time"] / unit[0], np.maximum(np.abs(share - 1.0), 1e-16), **style)
    upper.set_ylabel("energy / energy at the start")
    upper.set_ylim(0.0, 3.0)
    upper.legend(frameon=False, fontsize=7, ncols=2)
    lower.set_yscale("log")
    lower.set_ylabel("relative change")
    _finish(figure, [upper, lower], longest["time"] / unit[0], unit[1], path)


def penetration_energies(path: Path, panels: Mapping[str, Mapping[str, History]]) -> None:
    """Plot penetration energies over time, a panel for each group of runs, all on the same scales."""
    figure, grid = _grid(1, len(panels))
    histories = [history for runs in panels.values() for history in runs.values()]
    factor, prefix = si_scale(max(float(np.nanmax(history["contact"], initial=0.0)) for history in histories))
    longest = max(histories, key=lambda history: float(history["time"][-1]))
    _, unit = _time(longest)
    for axes, (title, runs) in zip(grid[0], panels.items(), strict=True):
        for colour, (label, history) in zip((BLUE, RED, GREEN, ORANGE, PURPLE), runs.items(), strict=False):
            axes.plot(history["time"] / unit[0], history["contact"] / factor, color=colour, lw=1.1, label=label)
        axes.set_title(title, fontsize=9)
        axes.legend(frameon=False, fontsize=8)
        axes.set_xlabel(f"time [{unit[1]}]")
    grid[0][0].set_ylabel(f"penetration energy [{_greek(prefix)}J]")
    _finish(figure, [grid[0][-1]], longest["time"] / unit[0], unit[1], path)


def against(path: Path, lines: Curves, across: tuple[str, str], upward: tuple[str, str], title: str = "") -> None:
    """Plot curves (x, y) by label; across, upward: name and SI unit of x and y."""
    figure, (axes,) = _figure(1, title)
    scales = [si_scale(max(float(np.nanmax(np.abs(line[part]), initial=0.0)) for line in lines.values()))
              for part in (0, 1)]  # fmt: skip
    for (label, (x, y)), color in zip(lines.items(), itertools.cycle((BLUE, RED, ORANGE, GREEN))):
        axes.plot(np.divide(x, scales[0][0]), np.divide(y, scales[1][0]), color=color, lw=1.0, label=label)
    axes.legend(loc="best", frameon=False)
    axes.set_xlabel(f"{across[0]} [{_greek(scales[0][1])}{across[1]}]")
    axes.set_ylabel(f"{upward[0]} [{_greek(scales[1][1])}{upward[1]}]")
    _save(figure, path)


def unrest(force: np.ndarray) -> float:
    """Return the sum of all changes of a force over twice its largest value: 1 for one that rises and falls once."""
    return float(np.abs(np.diff(force)).sum() / max(2.0 * np.nanmax(force), 1e-300))


def force_component(history: History, normals: Sequence[np.ndarray]) -> np.ndarray:
    """Return the largest partner's force along the obstacle normal [N]; its size for several normals, and of a pair."""
    acting = acting_force(history)
    if normals and not acting.of_pair and all(np.allclose(normal, normals[0]) for normal in normals):
        with np.errstate(invalid="ignore"):  # a run that blew up has inf and nan in its last rows
            return acting.force @ np.asarray(normals[0])
    return acting.size


def part_forces(history: History) -> dict[str, np.ndarray]:
    """Return the contact forces [rows, 3] [N] of several obstacles and of pairs of bodies by their names.

    Nothing of these is {}: one obstacle has the contact force of all. What no body touches is left away.
    """
    parts = partner_forces(history)
    if len(parts) == 1 and not pair_forces(history):
        return {}
    return {name.partition(":")[2] or "obstacles": force for name, force in parts.items() if np.any(force)}


def _penetration(history: History) -> np.ndarray:
    """Return the penetration [m] of every row, 0 where it is below the rounding of the gaps."""
    gaps = history["gap_min"]
    widest = np.max(np.abs(gaps), initial=0.0, where=np.isfinite(gaps))
    depth = np.maximum(0.0, -gaps)
    return np.where(depth > GAP_ROUNDING * widest, depth, 0.0)


def _tangential(history: History, normals: Sequence[np.ndarray]) -> np.ndarray | None:
    """Return the length of the contact force across a single normal [N]; None where nothing slides."""
    if not normals or not np.any(history.get("friction_work", 0.0)):
        return None
    if not all(np.allclose(normal, normals[0]) for normal in normals):
        return None
    normal = np.asarray(normals[0])
    force = history["contact_force"]
    with np.errstate(invalid="ignore"):
        return np.linalg.norm(force - np.outer(force @ normal, normal), axis=1)


def _nothing(axes: Axes, text: str) -> None:
    """Say in the middle of an empty panel that there is nothing to draw."""
    axes.text(0.5, 0.6, text, transform=axes.transAxes, ha="center", color=GREY, fontsize=9)


def _figures(value: float, unit: str) -> str:
    factor, prefix = si_scale(value)
    return f"{value / factor:.3g} {_greek(prefix)}{unit}"


def _label_ends(axes: Axes, ends: Mapping[str, tuple[float, str]]) -> None:
    """Write each curve's name beside its end, in its colour, moved apart where ends lie close together."""
    low, high = axes.get_ylim()
    room, wanted = 0.085, sorted(ends, key=lambda name: np.nan_to_num(ends[name][0]))
    places = [float(np.clip((np.nan_to_num(ends[name][0]) - low) / (high - low), 0.0, 1.0)) for name in wanted]
    for index in range(1, len(places)):
        places[index] = max(places[index], places[index - 1] + room)
    for index in range(len(places) - 1, -1, -1):  # and back down from the top
        most = 1.0 if index == len(places) - 1 else places[index + 1] - room
        places[index] = min(places[index], most)
    for name, place in zip(wanted, places, strict=True):
        axes.annotate(name, (1.01, place), xycoords="axes fraction", color=ends[name][1], va="center", fontsize=9)


def _figure(panels: int, title: str) -> tuple[Figure, list[Axes]]:
    figure, grid = _grid(panels, 1)
    grid[0][0].set_title(plain(title), fontsize=9, loc="left", color=GREY)
    return figure, [row[0] for row in grid]


def _grid(rows: int, columns: int) -> tuple[Figure, Any]:
    import_matplotlib()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    width, height = (7.5, 4.2) if rows == 1 else (7.5, 5.4)
    if columns > 1:
        width, height = 4.6 * columns, 2.4 * rows + 0.6
    figure = Figure(figsize=(width, height), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(rows, columns, sharex=True, sharey="row", squeeze=False)
    for axes in grid.flat:
        axes.grid(True, color="#dddddd", lw=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(labelsize=9)
    return figure, grid


def _finish(
    figure: Figure, panels: Sequence[Axes], time: np.ndarray, unit: str, path: Path, name: str = TIME[0]
) -> None:
    panels[-1].set_xlabel(f"{name} [{unit}]")
    end = float(time[-1]) or 1.0
    panels[-1].set_xlim(-0.01 * end, 1.01 * end)
    figure.align_ylabels(panels)
    _save(figure, path)


def _save(figure: Figure, path: Path) -> None:
    """Write a figure; a PNG from what is drawn once, where `savefig` draws a second time to find the margins."""
    if path.suffix != ".png":
        with replaced(path, synced=False) as part:
            figure.savefig(part, format=path.suffix[1:] or "png")
        return
    canvas: Any = figure.canvas
    canvas.draw()
    write_png(path, np.asarray(canvas.buffer_rgba())[..., :3])


def _time(history: History) -> tuple[np.ndarray, tuple[float, str]]:
    factor, prefix = si_scale(float(history["time"][-1]))
    return history["time"] / factor, (factor, f"{_greek(prefix)}s")


def _greek(prefix: str) -> str:
    return "µ" if prefix == "u" else prefix
