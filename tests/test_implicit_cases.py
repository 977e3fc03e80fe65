"""The cases of the implicit schemes: their checks pass on small sizes and can fail, their pictures are drawn."""

import json
from dataclasses import replace

import numpy as np
import pytest

import tcontact as tc
from tcontact.cases import incompressible_beam, penetration_energy, tumbling_block
from tcontact.commands.cli import main
from tcontact.planning.planning import plan
from tcontact.schemes.implicit.solution.linear_solver import DIRECT
from tcontact.show import plots


def verdicts(case, result):
    return {check.name: check.passed for check in case.checks(result)}


def test_beam_keeps_its_energy_and_says_when_it_does_not():
    own = incompressible_beam.scene(cells=10, duration=0.3)
    result = tc.simulate(own, scheme=tc.DiscreteGradient(dt=0.02))
    assert all(verdicts(incompressible_beam, result).values())
    assert result.history["elastic"].max() > 0.2 * result.history["energy"][0]
    lossy = tc.simulate(own, scheme=tc.PaperImplicit(dt=0.02))
    assert not verdicts(incompressible_beam, replace(lossy, scheme=result.scheme))["energy error"]


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_block_tumbles_without_loss(kind):
    own = tumbling_block.scene(cells=3, kind=kind, duration=4e-3)
    result = tc.simulate(own, scheme=tc.DiscreteGradient(dt=2e-4))
    found = verdicts(tumbling_block, result)
    assert all(found.values())
    assert len(found) == 5
    lossy = tc.simulate(own, scheme=tc.PaperImplicit(dt=2e-4))
    assert not all(verdicts(tumbling_block, replace(lossy, scheme=result.scheme)).values())


def test_penetration_energy_rises_and_falls_once():
    scenes = [penetration_energy.scene(cells=4, redistributed=which) for which in (True, False)]
    smooth, rough = (tc.simulate(own, scheme=tc.PaperImplicit(cfl=1.0)) for own in scenes)
    assert all(verdicts(penetration_energy, smooth).values())
    assert penetration_energy.variation(rough) > penetration_energy.variation(smooth)


def test_comparison_of_schemes_from_the_command_line(tmp_path, capsys):
    """The case's own scheme and step without being asked, a scheme per run of a comparison, its own picture."""
    words = ["--set", "cells=3", "--set", "duration=2e-3", "--frames", "0", "--quiet"]
    assert main(["run", "tumbling-block", *words, "--out", str(tmp_path / "one")]) == 0
    summary = json.loads((tmp_path / "one" / "summary.json").read_text())
    assert summary["dt"] == tumbling_block.SCHEME["dt"]
    assert main(["run", "tumbling-block", "--set", "compare=true", *words, "--out", str(tmp_path / "all")]) == 0
    assert (tmp_path / "all" / "comparison.png").stat().st_size > 1000
    summary = json.loads((tmp_path / "all" / "summary.json").read_text())
    assert "discrete-gradient" in summary["labels"]
    assert "central-difference" in summary["labels"]


def test_options_of_a_scheme_from_the_command_line(tmp_path, capsys):
    words = ["run", "tumbling-block", "--set", "cells=2", "--set", "duration=1e-3", "--frames", "0", "--quiet"]
    own = ["--set", "scheme=hilber-hughes-taylor", "--set", "alpha=-0.2", "--set", "dt=1e-4"]
    assert main([*words, *own, "--out", str(tmp_path / "hht")]) == 0
    assert main([*words, "--set", "chi=0.2", "--out", str(tmp_path / "no")]) == 2
    assert "chi" in capsys.readouterr().err


def test_penetration_energies_are_drawn_in_two_panels(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(plots, "_save", lambda figure, path: drawn.append(figure))
    time = np.linspace(0.0, 1e-3, 11)
    history = {"time": time, "contact": 1e-3 * np.sin(np.pi * time / 1e-3)}
    labels = [f"{name} mass, {share:g} dt" for name in penetration_energy.NAMES for share in penetration_energy.STEPS]
    assert set(penetration_energy.comparison(cells=2)) == set(labels)
    penetration_energy.draw_comparison(tmp_path / "a.png", dict.fromkeys(labels, history))
    assert [len(axes.lines) for axes in drawn[0].axes] == [len(penetration_energy.STEPS)] * 2
    assert [axes.get_title() for axes in drawn[0].axes] == [f"{name} mass" for name in penetration_energy.NAMES]


def test_description_names_the_solver_and_why():
    small, large = (plan(tumbling_block.scene(cells=n)) for n in (4, 24))
    scheme = tc.DiscreteGradient(dt=1e-4)
    assert f"SuperLU): no more than {DIRECT} unknowns" in small.describe(scheme)
    assert f"BiCGStab, inverse diagonal blocks: more than {DIRECT} unknowns" in large.describe(scheme)
    stiff = plan(incompressible_beam.scene(cells=100, ratio=1000.0))
    assert "lambda/mu = 1e+03 is 100 or more" in stiff.describe(scheme)
    assert "as asked for" in large.describe(tc.DiscreteGradient(dt=1e-4, solver="direct"))
    assert "points(neo_hookean, discrete)" in small.describe(scheme)


@pytest.mark.parametrize("options", ["scheme=paper-implicit", "scheme=dissipative chi=0.3"])
def test_a_cube_that_is_meant_to_lose_energy_passes_where_it_gains_none(options, tmp_path):
    arguments = [part for option in [*options.split(), "cells=4", "dt=1e-4"] for part in ("--set", option)]
    assert main(["run", "cube-impact", *arguments, "--quiet", "--out", str(tmp_path / "run")]) == 0
    checks = json.loads((tmp_path / "run" / "summary.json").read_text())["checks"]
    assert "energy gained" in [check["name"] for check in checks]
