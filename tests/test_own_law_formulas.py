"""Formulas of registered laws without kernels: derivatives, small strains, checks, refusals, files."""

import math
import re
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from own_law_formulas import FORMULAS, energy_of, gent, neo_hookean, numbers

import tcontact as tc
from tcontact.kernels.language.expressions import Graph
from tcontact.kernels.language.formula import Formula
from tcontact.kernels.language.small_strains import SmallStrains
from tcontact.kernels.language.traced_energy import traced
from tcontact.run.checkpoint.fingerprint import compare, fingerprint
from tcontact.scene import law_checks

GIVEN = {"mu": 4e5, "limit": 30.0, "bulk": 2e7}


def stresses(formula, parameters, h):
    """W and P of a displacement gradient [3, 3] as the kernels form them, by numbers."""
    at = traced(formula, tuple(parameters))
    small = SmallStrains(at.graph)
    roots = [small.parts(slope).change for slope in at.graph.gradient(at.energy, at.strain)]
    symbols = {f"h{i}{j}": h[i, j] for i in range(3) for j in range(3)}
    symbols |= {f"p{k}": value for k, value in enumerate(parameters.values())}
    found = numbers(at.graph, [small.beyond(at.energy), *roots], symbols)
    return found[0], np.array(found[1:], dtype=float).reshape(3, 3)


@pytest.mark.parametrize("formula", FORMULAS, ids=lambda one: one.__name__)
def test_stress_and_energy_are_those_of_the_function(formula):
    """Against the energy at a turned deformation by the function itself, and its complex steps."""
    given = FORMULAS[formula]
    h = law_checks.samples(0.2)[:4]
    for one in h:
        energy, stress = stresses(formula, given, one)
        assert energy == pytest.approx(energy_of(formula, np.eye(3) + one, **given), rel=1e-12)
        for i, j in np.ndindex(3, 3):
            step = np.zeros((3, 3), dtype=complex)
            step[i, j] = 1e-30j
            slope = energy_of(formula, np.eye(3) + one + step, **given).imag / 1e-30
            assert stress[i, j] == pytest.approx(slope, rel=1e-11, abs=1e-12 * np.abs(stress).max())


@pytest.mark.parametrize("formula", FORMULAS, ids=lambda one: one.__name__)
@pytest.mark.parametrize("size", [1e-6, 1e-9, 1e-15])
def test_small_strains_keep_their_digits(formula, size):
    """Stress and energy are those of the stiffness without strain; their next order is below it by the strain."""
    given = FORMULAS[formula]
    h = size * np.random.default_rng(4).uniform(-1, 1, (3, 3))
    at = Formula(formula, tuple(given))
    tangent = at.at(at.tangent, np.zeros((3, 3)), given).reshape(3, 3, 3, 3)
    strain = 0.5 * (h + h.T)
    hooke = np.einsum("ijkl,kl->ij", tangent, strain)
    energy, stress = stresses(formula, given, h)
    bound = 100.0 * size + 1e-13
    assert np.abs(stress - hooke).max() <= bound * np.abs(hooke).max()
    assert energy == pytest.approx(0.5 * np.sum(hooke * strain), rel=bound)


def test_a_formula_without_rounding():
    """det F - 1 of tiny rational components, in exact arithmetic."""
    graph = Graph()
    h = [Fraction(int(k), 10**12) for k in np.random.default_rng(1).integers(-9, 9, 9)]
    f = [[h[3 * i + j] + (i == j) for j in range(3)] for i in range(3)]
    exact = sum(
        f[0][j] * (f[1][(j + 1) % 3] * f[2][(j + 2) % 3] - f[1][(j + 2) % 3] * f[2][(j + 1) % 3]) for j in range(3)
    )
    symbols = [graph.symbol(f"h{i}{j}") for i in range(3) for j in range(3)]
    g = [[symbols[3 * i + j] + (1.0 if i == j else 0.0) for j in range(3)] for i in range(3)]
    determinant = sum(
        g[0][j] * (g[1][(j + 1) % 3] * g[2][(j + 2) % 3] - g[1][(j + 2) % 3] * g[2][(j + 1) % 3]) for j in range(3)
    )
    known = {f"h{i}{j}": float(h[3 * i + j]) for i in range(3) for j in range(3)}
    (found,) = numbers(graph, [SmallStrains(graph).parts(determinant).change], known)
    assert found == pytest.approx(float(exact - 1), rel=1e-15)


def test_material_constants():
    law = tc.register_law("FormulaGent", gent, GIVEN)
    material = law(mu=3e5, limit=20.0, bulk=2e6, density=1100.0)
    assert (material.lame_mu, material.lame_lambda) == pytest.approx((3e5, 2e6 - 2e5))
    assert material.wave_speed == pytest.approx(np.sqrt(2.4e6 / 1100.0))
    twin = tc.NeoHookean(material.young, material.poisson, 1100.0)
    assert (twin.lame_mu, twin.lame_lambda) == pytest.approx((3e5, 1.8e6))
    assert law.volumetric
    assert material.parameters == pytest.approx((2e6, 3e5, 20.0, 2.4e6))
    assert replace(material, mu=1e5).lame_mu == pytest.approx(1e5)
    assert tc.register_law("FormulaGent", gent, GIVEN) is law


@pytest.mark.parametrize(
    ("energy", "remedy"),
    [
        (lambda s, mu, lam: mu * (s.I1 - 3) if s.J > 1 else lam * (s.J - 1) ** 2, "one smooth formula without `if`"),
        (lambda s, mu, lam: mu * abs(s.I1 - 3) + lam, "one smooth formula without `if`"),
        (lambda s, mu, lam: mu * np.maximum(s.I1 - 3, 0) + lam, "one smooth formula without `if`"),
        (lambda s, mu, lam: mu * max(s.I1 - 3, lam), "one smooth formula without `if`"),
        (lambda s, mu, lam: mu * math.log(s.J) + lam, "use numpy.log"),
        (lambda s, mu, lam: mu * np.tan(s.J) + lam, "it calls numpy.tan; use "),
        (lambda s, mu, lam: mu * np.sqrt(s.I1 - 3) + lam, "what is 0 without strain"),
        (lambda s, mu, lam: s.C, "return the energy per reference volume, one number"),
        (lambda s, mu, lam: 1.0, "return the energy per reference volume, one number"),
        (lambda s, mu, lam: s.volume, "AttributeError"),
        (lambda s, mu, lam: mu / 2 * (s.I1 - 3) + lam / 2 * (s.J - 1) ** 2, "it has a stress of 1 Pa without strain"),
        (lambda s, mu, lam: -neo_hookean(s, lam, mu), "a small strain has a stiffness of -8 Pa"),
        (lambda s, mu, lam: mu * s.H[0, 0] ** 2 + lam * s.H[1, 1] ** 2, "a rotation of the body changes it"),
        (lambda s, mu, lam: neo_hookean(s, lam, mu) * np.random.default_rng().random(), "gives other values"),
        (lambda s, mu: mu * s.I1, "unexpected keyword argument 'lam'"),
        ("mu I1", "give a function"),
    ],
)
def test_what_is_no_law_is_refused(energy, remedy):
    with pytest.raises(tc.InputError, match=re.escape(remedy)):
        tc.register_law("Refused", energy, {"mu": 1.0, "lam": 2.0})
    with pytest.raises(tc.InputError, match=r"bodies\[0\].material.type"):
        load("Refused", mu=1.0)


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("NeoHookean", {"lam": 1.0, "mu": 1.0}),
        ("neo_hookean", {"lam": 1.0, "mu": 1.0}),
        ("my law", {"lam": 1.0, "mu": 1.0}),
        (3, {"lam": 1.0, "mu": 1.0}),
        ("Named", ("lam", "mu")),
        ("Named", {}),
        ("Named", {"lam": float("nan"), "mu": 1.0}),
        ("Named", {"lam": 1.0, "density": 1.0}),
        ("Named", {"lam": 1.0}),
    ],
)
def test_bad_names_and_parameters_are_refused(name, parameters):
    with pytest.raises(tc.InputError, match=r"register_law\.(name|parameters)"):
        tc.register_law(name, neo_hookean, parameters)


def test_another_formula_of_a_name_is_refused():
    """Kernels are compiled by the name of a law."""
    tc.register_law("Twice", neo_hookean, {"lam": 2.0, "mu": 1.0})
    with pytest.raises(tc.InputError, match="is registered with another formula"):
        tc.register_law("Twice", lambda s, lam, mu: neo_hookean(s, lam, mu) * 1.5, {"lam": 2.0, "mu": 1.0})


def test_a_wrong_derivative_is_seen(monkeypatch):
    right = Graph.slopes

    def wrong(graph, a):
        found = right(graph, a)
        return [(found[0][0], 1.001 * found[0][1])] if a.operation == "log" else found

    monkeypatch.setattr(Graph, "slopes", wrong)
    with pytest.raises(tc.InputError, match="its derivative by complex steps is not that of its formula"):
        tc.register_law("Wrong", gent, GIVEN)


@pytest.mark.parametrize("parameters", [{"mu": -1.0}, {"mu": 0.0}, {"limit": 0.0}, {"bulk": -1e9}, {"density": 0.0}])
def test_unstable_materials_are_refused(parameters):
    law = tc.register_law("FormulaGent", gent, GIVEN)
    with pytest.raises(tc.InputError, match=r"must be|no finite number"):
        law(**(GIVEN | {"density": 1000.0} | parameters))


def load(word, **constants):
    """A material through a scene file."""
    from tcontact.run.scene_files.read import Reader

    body = {"mesh": {"box": [1.0, 1.0, 1.0], "cells": [2, 2, 2]}, "material": {"type": word, **constants}}
    return Reader(".").body("bodies[0]", body).material


def test_scene_files_know_a_law_once_it_is_registered(tmp_path):
    with pytest.raises(tc.InputError, match=r"an own law is registered before the file is read: .* --import") as caught:
        load("FileGent", **GIVEN, density=1.0)
    assert caught.value.field == "bodies[0].material.type"
    law = tc.register_law("FileGent", gent, GIVEN)
    material = law(**GIVEN, density=1000.0)
    body = tc.Body(tc.box_mesh((1, 1, 1), (2, 2, 2)), material, contact="zmin")
    tc.save_scene(tc.Scene([body], duration=1.0), tmp_path / "scene.toml")
    assert tc.load_scene(tmp_path / "scene.toml")[0].bodies[0].material == material
    with pytest.raises(tc.InputError, match="unknown key; did you mean 'limit'"):
        load("FileGent", mu=1.0, limits=1.0, bulk=1.0, density=1.0)


def test_another_formula_is_another_scene(monkeypatch):
    """A run is not resumed with it."""
    law = tc.register_law("FormulaGent", gent, GIVEN)
    body = tc.Body(tc.box_mesh((1, 1, 1), (2, 2, 2)), law(**GIVEN, density=1000.0))
    scene = tc.Scene([body], duration=1.0)
    stored = fingerprint(scene, tc.CentralDifference())
    compare(stored, fingerprint(scene, tc.CentralDifference()))
    monkeypatch.setattr(law, "formula", "another")
    with pytest.raises(tc.InputError, match=r"bodies\[0\]\.material\.energy"):
        compare(stored, fingerprint(scene, tc.CentralDifference()))
