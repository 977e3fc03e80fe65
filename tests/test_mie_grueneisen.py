"""The equation of state of Mie and Grueneisen: isentrope, shock curve, energy, heat, refusals, scene files."""

import numpy as np
import pytest
from material_point import Path

import tcontact as tc

SLOPE, GAMMA, SPEED, HEAT, DENSITY = 1.489, 2.0, 3940.0, 385.0, 8930.0


def copper(strength=90e6, share=1.0, slope=SLOPE, **options):
    """Copper with its shock curve."""
    curve = tc.MieGrueneisen(slope, GAMMA, SPEED)
    law = tc.LinearHardening(strength, 0.0)
    given = {"heat_share": share, "specific_heat": HEAT, "pressure": curve} | options
    return tc.ElastoPlastic(124e9, 0.34, DENSITY, law, **given)


def swollen(volumes):
    """F - I of a change of volume alone."""
    return [(jacobian ** (1.0 / 3.0) - 1.0) * np.eye(3) for jacobian in volumes]


def pressure(path):
    return -np.trace(path.kirchhoff, axis1=1, axis2=2) / 3.0 / np.linalg.det(path.f)


def test_compression_and_release_bring_everything_back():
    """Into strong compression, into tension, and back; rotated on the way."""
    volumes = np.concatenate([np.linspace(1.0, 0.7, 60), np.linspace(0.7, 1.1, 60), np.linspace(1.1, 1.0, 60)])
    angle = np.linspace(0.0, 30.0, len(volumes))
    turns = [np.array([[np.cos(a), -np.sin(a), 0.0], [np.sin(a), np.cos(a), 0.0], [0.0, 0.0, 1.0]]) for a in angle]
    turns[-1] = np.eye(3)
    gradients = [turn @ (h + np.eye(3)) - np.eye(3) for turn, h in zip(turns, swollen(volumes), strict=True)]
    path, still = Path(copper(), gradients), Path(copper(), swollen(volumes))
    assert still.warming[-1] == 0.0
    assert still.energy[-1] == 0.0
    assert (still.state[:, 8:] == 0.0).all()
    assert np.abs(path.warming - still.warming).max() <= 1e-10 * 300.0
    assert np.abs(pressure(path) - pressure(still)).max() <= 1e-12 * pressure(still).max()
    assert 300.0 + still.warming == pytest.approx(300.0 * np.exp(GAMMA * (1.0 - volumes)), rel=1e-12)


def test_energy_and_pressure_of_the_isentrope_solve_its_equation():
    """dE/dm = p_H (1 - Gamma m/2) + Gamma E by fine steps of the classical Runge-Kutta method; in tension p = K m."""
    material, steps = copper(), 2000
    bulk = material.bulk_modulus

    def rate(m, energy):
        return bulk * m / (1.0 - SLOPE * m) ** 2 * (1.0 - 0.5 * GAMMA * m) + GAMMA * energy

    h, energy, wanted = 0.3 / steps, 0.0, []
    for step in range(steps):
        m = step * h
        one = rate(m, energy)
        two = rate(m + 0.5 * h, energy + 0.5 * h * one)
        three = rate(m + 0.5 * h, energy + 0.5 * h * two)
        energy += h / 6.0 * (one + 2.0 * two + 2.0 * three + rate(m + h, energy + h * three))
        wanted.append((energy, rate(m + h, energy)))
    path = Path(material, swollen(1.0 - h * np.arange(1, steps + 1)))
    for found, exact, bound in ((path.energy, 0, 2e-9), (pressure(path), 1, 2e-9)):
        exact = np.array(wanted)[:, exact]
        assert np.abs(found / exact - 1.0).max() <= bound
    tension = Path(material, swollen([1.05]))
    assert pressure(tension)[0] == pytest.approx(-0.05 * bulk, rel=1e-12)
    assert tension.energy[0] == pytest.approx(0.5 * bulk * 0.05**2, rel=1e-12)


def test_a_point_at_the_energy_of_the_shock_curve_has_its_pressure_and_heat():
    """Heat (E_H - E_s) put in at m gives p_H; the temperature follows from it."""
    material, m = copper(), 0.2
    bulk = material.bulk_modulus
    on_curve = bulk * m / (1.0 - SLOPE * m) ** 2
    isentrope = Path(material, swollen([1.0 - m])).energy[0]
    rise = (0.5 * on_curve * m - isentrope) / (DENSITY * HEAT)
    state = np.zeros(10)
    state[8], state[9] = rise * np.exp(-GAMMA * m), rise
    hot = Path(material, swollen([1.0 - m]), state)
    assert pressure(hot)[0] == pytest.approx(on_curve, rel=1e-9)
    assert hot.warming[0] == pytest.approx(300.0 * np.expm1(GAMMA * m) + rise, rel=1e-12)
    assert hot.energy[0] == pytest.approx(isentrope, rel=1e-12)  # heat is counted where it is dissipated


@pytest.mark.parametrize("volume", [0.9, 1.05])
def test_stress_is_the_slope_of_the_energy_of_a_hot_point(volume):
    material, h = copper(4e9), 1e-5
    state = np.zeros(10)
    state[6], state[7], state[8], state[9] = 0.3, 350.0, 400.0, 350.0
    gradient = 0.006 * np.random.default_rng(0).normal(size=(3, 3)) + (volume ** (1.0 / 3.0) - 1.0) * np.eye(3)
    found = Path(material, [gradient], state).p[0]
    slopes = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            step = np.zeros((3, 3))
            step[i, j] = h
            up, down = (Path(material, [gradient + sign * step], state).energy[0] for sign in (1.0, -1.0))
            slopes[i, j] = (up - down) / (2.0 * h)
    assert np.abs(found - slopes).max() <= 1e-7 * np.abs(found).max()


def test_the_work_of_a_plastic_cycle_is_stored_or_dissipated():
    """Uniaxial strain to -0.25 and back: what the thermal pressure takes up is stored."""
    errors = []
    for steps in (200, 2000):
        strain = np.concatenate([np.linspace(0.0, -0.25, steps)[1:], np.linspace(-0.25, 0.0, steps)])
        gradients = np.zeros((len(strain), 3, 3))
        gradients[:, 2, 2] = strain
        errors.append(abs(Path(copper(1e9), gradients).closure))
    assert errors[0] <= 2e-4
    assert errors[1] <= 0.1 * errors[0]


def test_the_shock_curve_sets_the_bulk_modulus_and_the_wave_speed():
    material = copper()
    assert material.bulk_modulus == pytest.approx(DENSITY * SPEED**2, rel=1e-15)
    assert material.wave_speed**2 == pytest.approx(SPEED**2 + 4.0 / 3.0 * material.lame_mu / DENSITY, rel=1e-14)
    plain = copper(pressure=tc.MieGrueneisen(SLOPE, GAMMA))
    assert plain.lame_lambda == tc.NeoHookean(124e9, 0.34, DENSITY).lame_lambda


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"specific_heat": None}, "specific_heat"),
        ({"initial_temperature": 0.0}, "initial_temperature"),
        ({"pressure": "mie"}, "pressure"),
    ],
)
def test_what_it_cannot_take_is_refused(options, field):
    with pytest.raises(tc.InputError, match=field):
        copper(**options)


@pytest.mark.parametrize("numbers", [(-0.1, 2.0), (1.5, -1.0), (1.5, 2.0, 0.0), (np.nan, 2.0), ("a", 2.0)])
def test_wrong_numbers_are_refused(numbers):
    with pytest.raises(tc.InputError, match="MieGrueneisen"):
        tc.MieGrueneisen(*numbers)
