"""Curves: every one is named where it ends, friction is drawn where there is some, nothing is blown up."""

from __future__ import annotations

import numpy as np
import pytest
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
