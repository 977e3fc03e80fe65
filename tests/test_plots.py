"""Curves: every one is named where it ends, friction is drawn where there is some, nothing is blown up."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.cbook import is_math_text
from matplotlib.figure import Figure

from tcontact.show import plots

UP = [np.array([0.0, 0.0, 1.0])]


@pytest.fixture
def history() -> dict[str, np.ndarray]:
    """A hundred rows of a block that slides: force 8 kN with small changes, friction a fifth of it."""
    time = np.linspace(0.0, 2e-6, 100)
    normal = 8e3 + 10 * np.sin(1e7 * time)
    force = np.stack([-0.2 * normal, 0 * time, normal], axis=1)
    work = 0.06 * time / time[-1]
    energies = {"kinetic": 0.07 - work, "elastic": 0.04 + 0 * time, "contact": 0 * time, "friction_work": work}
    return {"time": time, "contact_force": force, **energies, "energy": 0.11 + 0 * time, "energy_error": 1e-5 * work}


@pytest.fixture
def drawn(monkeypatch) -> list[Figure]:
    """Figures instead of files."""
    figures: list[Figure] = []
    monkeypatch.setattr(plots, "_save", lambda figure, path: figures.append(figure))
    return figures


def test_every_energy_is_named_beside_its_end_without_overlap(history, drawn, tmp_path):
    plots.energy(tmp_path / "e.png", history)
    axes = drawn[0].axes[0]
    labels = {text.get_text(): text for text in axes.texts}
    assert set(labels) == {"kinetic", "elastic", "friction work", "sum"}
    colours = {line.get_color() for line in axes.lines}
    assert {text.get_color() for text in labels.values()} == colours
    heights = sorted(text.xy[1] for text in labels.values())
    assert np.diff(heights).min() > 0.08
    order = sorted(labels, key=lambda name: labels[name].xy[1])
    assert order == ["kinetic", "elastic", "friction work", "sum"], "as the curves end"


def test_names_stay_apart_and_inside_where_all_curves_end_together(history, drawn, tmp_path):
    for name in ("kinetic", "elastic", "friction_work", "energy"):
        history[name] = np.linspace(1.0, 0.5, 100)
    plots.energy(tmp_path / "e.png", history)
    heights = sorted(text.xy[1] for text in drawn[0].axes[0].texts)
    assert np.diff(heights).min() > 0.08
    assert heights[-1] <= 1.0


def test_small_changes_of_a_large_force_look_small_and_friction_is_drawn(history, drawn, tmp_path):
    plots.contact_force(tmp_path / "f.png", history, UP)
    axes = drawn[0].axes[0]
    assert axes.get_ylim()[0] <= 0.0
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["normal", "friction"]
    np.testing.assert_allclose(axes.lines[1].get_ydata(), 0.2 * axes.lines[0].get_ydata())
    assert axes.get_ylabel().endswith("[kN]")


def test_without_friction_one_curve_needs_no_legend(history, drawn, tmp_path):
    history["friction_work"] = 0 * history["time"]
    plots.contact_force(tmp_path / "f.png", history, UP)
    assert len(drawn[0].axes[0].lines) == 1
    assert drawn[0].axes[0].get_legend() is None


def test_every_run_of_a_comparison_is_drawn(history, drawn, tmp_path):
    history["gap_min"] = 0 * history["time"]
    plots.comparison(tmp_path / "c.png", {str(number): history for number in range(7)}, UP)
    assert [len(axes.lines) for axes in drawn[0].axes] == [1] * 21


def test_a_run_that_blew_up_is_still_drawn(history, drawn, tmp_path):
    for column in history.values():
        if column is not history["time"]:
            column[-3:] = [[np.inf], [np.nan], [np.nan]] if column.ndim == 2 else [np.inf, np.nan, np.nan]
    plots.energy(tmp_path / "e.png", history)
    plots.contact_force(tmp_path / "f.png", history, UP)
    assert len(drawn) == 2


def test_panels_explain_their_lines_wherever_these_mean_something_else(drawn, tmp_path):
    time = np.linspace(0.0, 1.0, 5)
    first, second = {"computed": (time, time), "rigid": (time, 0 * time)}, {"work": (time, time), "heat": (time, time)}
    plots.panels(tmp_path / "p.png", {("path", "m"): first, ("speed", "m/s"): first, ("energy", "J"): second})
    found = [
        axes.get_legend() and [text.get_text() for text in axes.get_legend().get_texts()] for axes in drawn[0].axes
    ]
    assert found == [["computed", "rigid"], None, ["work", "heat"]]


def test_obstacles_and_pairs_have_curves_with_their_names(history, drawn, tmp_path):
    force, nothing = history["contact_force"], 0 * history["contact_force"]
    parts = {"obstacle_force:floor": 0.75 * force, "obstacle_force:lid": nothing, "obstacle_force:wall": 0.25 * force}
    plots.contact_force(tmp_path / "f.png", history | parts | {"pair_force:a-b": 0.5 * force}, [])
    axes = drawn[0].axes[0]
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["floor", "wall", "a-b"]
    largest = [line.get_ydata().max() for line in axes.lines]
    np.testing.assert_allclose(largest / np.linalg.norm(force, axis=1).max() * 1e3, [0.75, 0.25, 0.5])


@pytest.mark.parametrize("name", ["price$_{x$", "a$b", "a$b$c", "_hidden", "caf\udce9"])
def test_a_name_is_drawn_as_it_is(name, history, drawn, tmp_path):
    """It is no formula, hides no curve, and may come from a file whose name has no encoding."""
    shown = name.replace("\udce9", "?")
    force = history["contact_force"]
    parts = {f"obstacle_force:{name}": force, "obstacle_force:wall": 0.5 * force}
    plots.contact_force(tmp_path / "f.png", history | parts, [], title=name)
    plots.comparison(tmp_path / "c.png", {name: history | {"gap_min": 0.0 * history["time"]}}, UP)
    figure, compared = drawn
    label, other = (text.get_text() for text in figure.axes[0].get_legend().get_texts())
    title, head = figure.axes[0].get_title(loc="left"), compared.axes[0].get_title().split("\n")[0]
    assert other == "wall"
    for text in (label, title, head):
        assert not is_math_text(text)
        assert text.replace("\\$", "$").strip() == shown
    for one in drawn:
        one.canvas.draw()


def test_the_parts_of_a_stress_have_its_names(history):
    axes = Figure().subplots()
    plots.draw_column(axes, history | {"probe_$a$_stress": np.ones((100, 6))}, "probe_$a$_stress", "Pa")
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["xx", "yy", "zz", "xy", "yz", "xz"]
    assert not is_math_text(axes.get_ylabel())


def test_one_obstacle_with_a_force_of_its_own_is_drawn_once(history, drawn, tmp_path):
    plots.contact_force(tmp_path / "f.png", history | {"obstacle_force:floor": history["contact_force"]}, UP)
    assert [text.get_text() for text in drawn[0].axes[0].get_legend().get_texts()] == ["normal", "friction"]


@pytest.mark.parametrize(("share", "lines"), [(1e-3, 1), (1e3, 2)])
def test_a_force_below_its_rounding_is_no_curve(share, lines, history, drawn, tmp_path):
    """The bodies are 2 m large and store 0.04 J: forces below 2e-11 N are rounding."""
    history["contact_force"] *= share * 2e-11 / np.abs(history["contact_force"]).max()
    plots.contact_force(tmp_path / "f.png", history, UP, size=2.0)
    (axes,) = drawn[0].axes
    assert len(axes.lines) == (lines if share > 1.0 else 0)
    assert [text.get_text() for text in axes.texts] == (
        [] if share > 1.0 else ["no resultant contact force: below its rounding of 20 pN"]
    )


def test_a_gap_below_its_rounding_is_no_curve(history, drawn, tmp_path):
    history["contact_nodes"] = 0 * history["time"] + 4
    history["gap_min"] = -1e-13 * np.abs(np.sin(1e7 * history["time"]))
    for size in (1.0, 1e-3):  # rounding 1e-12 m and 1e-15 m
        plots.gap(tmp_path / "g.png", history, size=size)
    found = [(len(figure.axes[0].lines), figure.axes[0].get_title(loc="right")) for figure in drawn]
    assert found == [(1, "no penetration"), (2, "deepest penetration 0.1 pm")]
    assert [text.get_text() for text in drawn[0].axes[0].texts] == [
        "neither gap nor penetration: below their rounding of 1 pm"
    ]


def test_a_comparison_says_where_there_is_none(history, drawn, tmp_path):
    deep = history | {"gap_min": -1e-6 * np.ones(100), "contact": np.ones(100)}
    none = history | {"gap_min": np.linspace(1e-3, -1e-19, 100)}
    plots.comparison(tmp_path / "c.png", {"penalty": deep, "massless": none}, UP)
    assert [[text.get_text() for text in axes.texts] for axes in drawn[0].axes] == [[], [], [], ["none"], [], ["none"]]


def test_where_nothing_is_near_there_is_no_gap_to_draw(history, drawn, tmp_path):
    history["contact_nodes"] = 0 * history["time"]
    history["gap_min"] = np.where(np.arange(100) < 60, 1e-3 * history["time"], np.inf)
    plots.gap(tmp_path / "g.png", history)
    curve = drawn[0].axes[0].lines[1].get_ydata()
    assert np.isnan(curve[60:]).all()
    assert np.isfinite(curve[:60]).all()
    assert drawn[0].axes[0].get_ylabel() == "smallest gap [nm]"
