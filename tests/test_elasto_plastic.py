"""The law of metals at one point: exact solutions, objectivity, closure of the energy, melting, refusals."""

from itertools import pairwise

import numpy as np
import pytest
from material_point import Path

import tcontact as tc

STEEL = tc.ElastoPlastic(200e9, 0.29, 7850.0, tc.LinearHardening(300e6, 1500e6))
COPPER = tc.ElastoPlastic(117e9, 0.35, 8930.0, tc.LinearHardening(400e6, 100e6), specific_heat=385.0)
COOK = tc.JohnsonCook(90e6, 292e6, 0.31, 0.025, 1.09, 1356.0)


def isochoric_tension(logarithms):
    """H of tension with these logarithmic strains at constant volume."""
    h = np.zeros((len(logarithms), 3, 3))
    h[:, 0, 0] = np.expm1(logarithms)
    h[:, 1, 1] = h[:, 2, 2] = np.expm1(-0.5 * np.asarray(logarithms))
    return h


def shear(amounts):
    h = np.zeros((len(amounts), 3, 3))
    h[:, 0, 1] = amounts
    return h


def ramp(ends, steps):
    return np.concatenate([np.linspace(a, b, steps + 1)[1:] for a, b in pairwise(ends)])


def rotations(angles, axis):
    k = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    sines, cosines = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    return np.eye(3) + sines * k + (1.0 - cosines) * (k @ k)


@pytest.mark.parametrize(("steps", "bound", "closure"), [(200, 2e-5, 1e-3), (2000, 2e-6, 2e-5)])
def test_isochoric_tension_has_the_exact_stress_strain_and_energy(steps, bound, closure):
    found = Path(STEEL, isochoric_tension(ramp([0.0, 0.7], steps)))
    assert found.strain[-1] == pytest.approx(0.69424873, rel=bound)
    assert found.mises[-1] == pytest.approx(1341.373094e6, rel=bound)
    assert found.energy[-1] == pytest.approx(3.853581e6, rel=2 * bound)
    assert abs(found.closure) < closure


def test_a_cycle_of_tension_and_compression_is_exact():
    found = Path(STEEL, isochoric_tension(ramp([0.0, 0.05, -0.05, 0.05, -0.05, 0.0], 200)))
    assert found.strain[-1] == pytest.approx(0.37608705, rel=1e-6)
    assert found.mises[-1] == pytest.approx(864.130570e6, rel=1e-6)
    assert found.energy[-1] == pytest.approx(1.601475e6, rel=1e-6)
    assert abs(found.closure) < 2e-4


def test_the_dissipation_is_of_second_order_in_the_step():
    """With the flow modulus 3 mu the error of the compression stays at 3e-3 however small the steps."""
    errors = [abs(Path(COPPER, isochoric_tension(ramp([0.0, -1.0], n))).closure) for n in (100, 1000, 10000)]
    assert errors[1] < 2e-5
    assert errors[2] < 1e-6
    turning = abs(Path(COPPER, shear(ramp([0.0, 1.0, 0.0, 1.0], 1600))).closure)
    assert turning < 1e-5


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("rate_factor", [0.025, 0.2])
def test_the_dissipation_at_a_strain_rate_is_of_second_order_in_the_step(rate_factor, sign):
    """With a flow modulus of the yield stress at rest the error stays at 2.4e-4 (C = .025) however small the steps."""
    law = tc.JohnsonCook(90e6, 292e6, 0.31, rate_factor, 1.09, 1356.0)
    metal = tc.ElastoPlastic(124e9, 0.34, 8960.0, law, specific_heat=383.0, heat_share=0.0)
    errors = []
    for count in (1000, 4000):
        path = Path(metal, isochoric_tension(ramp([0.0, 0.2 * sign], count)), step=0.2 / 1e5 / count)
        errors.append(abs(path.closure))
    assert errors[0] < 4e-5
    assert errors[1] < errors[0] / 4.0


def test_a_tiny_strain_keeps_its_digits():
    found = Path(STEEL, shear([1e-9]))
    assert found.p[0, 0, 1] == pytest.approx(STEEL.lame_mu * 1e-9, rel=1e-12)
    assert found.energy[0] == pytest.approx(0.5 * STEEL.lame_mu * 1e-18, rel=1e-12)


@pytest.mark.parametrize("pressure", ["bulk", "barrier"])
def test_below_yield_stress_is_the_slope_of_the_energy_and_the_state_keeps_its_bits(pressure):
    rng = np.random.default_rng(5)
    metal = tc.ElastoPlastic(200e9, 0.29, 7850.0, tc.LinearHardening(1500e6, 0.0), pressure=pressure)
    state = Path(metal, ramp([0.0, 1.0], 50)[:, None, None] * rng.normal(size=(3, 3)) * 0.2).state[-1]
    inverse = np.eye(3) + np.array(
        [[state[0], state[3], state[4]], [state[3], state[1], state[5]], [state[4], state[5], state[2]]]
    )
    root = np.linalg.cholesky(np.linalg.inv(inverse))  # Cp = root root^t, so F = R root^t has b = I
    f = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    f = (f * np.sign(np.linalg.det(f))) @ root.T @ (np.eye(3) + 1e-4 * rng.normal(size=(3, 3)))
    h = f - np.eye(3)
    steps = 1e-6 * np.array([np.eye(9)[i].reshape(3, 3) for i in range(9)])
    there = Path(metal, [h], state)
    assert there.lost[0] == 0.0
    assert np.array_equal(there.state[0], state)
    for i, step in enumerate(steps):
        up, down = Path(metal, [h + step], state), Path(metal, [h - step], state)
        slope = (up.energy[0] - down.energy[0]) / 2e-6
        assert slope == pytest.approx(there.p[0].reshape(-1)[i], abs=1e-7 * np.abs(there.p[0]).max() + 1e4)


@pytest.mark.parametrize("pressure", ["bulk", "barrier"])
def test_the_pressure_is_the_slope_of_the_energy_of_the_volume(pressure):
    metal = tc.ElastoPlastic(200e9, 0.29, 7850.0, tc.LinearHardening(1500e6, 0.0), pressure=pressure)
    stretch = np.array([-0.4, -0.1, 0.05])
    up, down = (
        Path(metal, (stretch + shift)[:, None, None] * np.eye(3), np.zeros(8)).energy for shift in (1e-6, -1e-6)
    )
    found = np.trace(Path(metal, stretch[:, None, None] * np.eye(3), np.zeros(8)).p, axis1=1, axis2=2)
    assert found == pytest.approx((up - down) / 2e-6, rel=1e-7)
    e = (1.0 + stretch) ** 3 - 1.0
    law = e if pressure == "bulk" else 0.5 * (1.0 + e - 1.0 / (1.0 + e))
    assert found / 3.0 / (1.0 + stretch) ** 2 == pytest.approx(metal.bulk_modulus * law, rel=1e-12)


def test_superposed_rotations_change_nothing():
    path = shear(ramp([0.0, 0.5, 0.2], 100)) + 0.3 * isochoric_tension(ramp([0.0, 0.3, 0.1], 100))
    turns = rotations(np.linspace(0.0, 400.0, len(path)), np.array([1.0, 2.0, -2.0]) / 3.0)
    plain = Path(COPPER, path)
    turned = Path(COPPER, turns @ (path + np.eye(3)) - np.eye(3))
    assert turned.p == pytest.approx(turns @ plain.p, abs=1e-12 * np.abs(plain.p).max())
    assert turned.lost == pytest.approx(plain.lost, rel=1e-11, abs=1e-13 * plain.lost.max())
    rest = Path(COPPER, rotations(np.linspace(0.0, 1000.0, 500), np.array([0.0, 0.6, 0.8])) - np.eye(3))
    assert not rest.strain.any()
    assert not rest.lost.any()


def test_plastic_flow_keeps_the_volume():
    found = Path(STEEL, shear(ramp([0.0, 3.0], 2000)))
    assert np.linalg.det(found.inverse_plastic[-1]) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    ("metal", "shear_strain", "strain", "temperature", "mises"),
    [
        (tc.friction_layer.ALUMINIUM_6061, 3.0, 1.72704, 565.558, 414.566e6),
        (tc.friction_layer.COPPER, 4.0, 2.30405, 645.419, 765.587e6),
    ],
)
def test_adiabatic_shear_heats_and_softens_as_the_exact_ode(metal, shear_strain, strain, temperature, mises):
    """Steinberg, Cochran and Guinan; integrated to first order in the elastic part."""
    young = 2.0 * metal.shear_modulus * 1.33
    body = tc.ElastoPlastic(young, 0.33, metal.density, metal, specific_heat=metal.heat_capacity)
    found = Path(body, shear(ramp([0.0, shear_strain], 4000)))
    assert found.strain[-1] == pytest.approx(strain, rel=1e-4)
    assert found.warming[-1] + 300.0 == pytest.approx(temperature, abs=0.02)
    assert found.mises[-1] == pytest.approx(mises, rel=1e-4)


@pytest.mark.parametrize("kind", ["guinan", "cook"])
def test_a_metal_that_melts_loses_its_strength_and_stays_finite(kind):
    hot = {"guinan": tc.friction_layer.STAINLESS_304, "cook": tc.JohnsonCook(340e6, 400e6, 0.35, 0.01, 1.0, 1900.0)}[
        kind
    ]
    for start, steps in ((1890.0, 3000), (1899.9, 60)):
        metal = tc.ElastoPlastic(198e9, 0.29, 7900.0, hot, specific_heat=500.0, initial_temperature=start)
        found = Path(metal, shear(ramp([0.0, 30.0], steps)), step=1e-8)
        assert np.isfinite(found.p).all()
        assert (found.warming + start <= 1900.0 + 1e-4).all()
        assert (np.diff(found.warming) >= 0.0).all()
        assert found.mises[-1] < 2e8


def test_steinberg_guinan_is_the_law_of_the_friction_layer():
    """Every point of a path lies on its yield surface, which is that of `Metal.yields_at`."""
    metal = tc.friction_layer.STAINLESS_304
    body = tc.ElastoPlastic(198e9, 0.29, 7900.0, metal, specific_heat=500.0)
    found = Path(body, shear(ramp([0.0, 2.0], 400)) + 0.99 ** (1 / 3) * np.eye(3) - np.eye(3))
    pressure = -np.trace(found.kirchhoff, axis1=1, axis2=2) / 3.0 / np.linalg.det(found.f)
    before = 300.0 + np.concatenate([[0.0], found.warming[:-1]])
    assert found.mises[100:] == pytest.approx(metal.yields_at(before, pressure, found.strain)[100:], rel=1e-9)


def test_johnson_cook_takes_the_rate_of_the_step():
    metal = tc.ElastoPlastic(124e9, 0.34, 8960.0, COOK, specific_heat=383.0)
    dt = 1e-8
    found = Path(metal, shear(ramp([0.0, 1.0], 1000)), step=dt)
    rate = np.diff(found.strain, prepend=0.0) / dt
    before = 300.0 + np.concatenate([[0.0], found.warming[:-1]])
    y = (COOK.yield_stress + COOK.hardening * found.strain**COOK.hardening_exponent) * (
        1.0 + COOK.rate_factor * np.log(np.maximum(rate, 1.0))
    )
    y *= (
        1.0 - ((before - COOK.reference_temperature) / (1356.0 - COOK.reference_temperature)) ** COOK.softening_exponent
    )
    assert found.mises[20:] == pytest.approx(y[20:], rel=1e-8)
    slow = Path(metal, shear(ramp([0.0, 1.0], 1000)), step=10.0)
    assert slow.mises[-1] < found.mises[-1] / 1.2


def test_all_yield_stresses_solve_their_equation_on_random_states():
    rng = np.random.default_rng(11)
    for law in (COOK, tc.friction_layer.COPPER.hardening_law, tc.LinearHardening(90e6, 200e6)):
        metal = tc.ElastoPlastic(124e9, 0.34, 8960.0, law, specific_heat=383.0)
        for _ in range(100):
            state = np.zeros(8)
            state[6] = rng.choice([0.0, 1e-4, 0.1, 3.0])
            h = 10.0 ** rng.uniform(-4, -0.7) * rng.normal(size=(3, 3))
            found = Path(metal, [h], state, step=1e-8)
            if found.lost[0] == 0.0:
                continue
            if isinstance(law, tc.SteinbergGuinan):
                pressure = -np.trace(found.kirchhoff[0]) / 3.0 / np.linalg.det(found.f[0])
                wanted = law.yields_at(300.0, pressure, found.strain[0])
            elif isinstance(law, tc.LinearHardening):
                wanted = law.yield_stress + law.modulus * found.strain[0]
            else:
                rate = (found.strain[0] - state[6]) / 1e-8
                cold = 1.0 - ((300.0 - 298.0) / (1356.0 - 298.0)) ** 1.09
                wanted = (90e6 + 292e6 * found.strain[0] ** 0.31) * (1.0 + 0.025 * np.log(max(rate, 1.0))) * cold
            assert found.mises[0] == pytest.approx(wanted, rel=1e-6)


@pytest.mark.parametrize(
    ("values", "field"),
    [
        ({"hardening": None}, "ElastoPlastic.hardening"),
        ({"hardening": tc.LinearHardening(20e9)}, "ElastoPlastic.hardening"),
        ({"heat_share": 1.1}, "ElastoPlastic.heat_share"),
        ({"specific_heat": 0.0}, "ElastoPlastic.specific_heat"),
        ({"initial_temperature": 1400.0, "hardening": COOK}, "ElastoPlastic.initial_temperature"),
        ({"pressure": "spring"}, "ElastoPlastic.pressure"),
        ({"young": -1.0}, "young"),
    ],
)
def test_bad_input_names_the_field(values, field):
    good = {"young": 200e9, "poisson": 0.3, "density": 7850.0, "hardening": tc.LinearHardening(300e6)}
    with pytest.raises(tc.InputError) as error:
        tc.ElastoPlastic(**(good | values))
    assert error.value.field == field


@pytest.mark.parametrize(
    ("build", "field"),
    [
        (lambda: tc.LinearHardening(0.0), "yield_stress"),
        (lambda: tc.LinearHardening(1e8, -1.0), "modulus"),
        (lambda: tc.JohnsonCook(1e8, 1e8, 1.5), "hardening_exponent"),
        (lambda: tc.JohnsonCook(1e8, 1e8, 0.5, melting_temperature=200.0), "melting_temperature"),
        (lambda: tc.SteinbergGuinan(1e8, 0.0, 0.5), "hardening"),
        (lambda: tc.SteinbergGuinan(1e8, 1.0, 0.5, largest_yield_stress=1e7), "largest_yield_stress"),
    ],
)
def test_bad_yield_stresses_name_the_field(build, field):
    with pytest.raises(tc.InputError) as error:
        build()
    assert error.value.field == field


def test_presets_are_metals_with_their_sources():
    from tcontact.scene import metal_presets
    from tcontact.scene.metal_presets import PRESETS

    for name, preset in PRESETS.items():
        assert f"| {name} |" in metal_presets.__doc__
        assert tc.metal(name) == preset
        assert preset.specific_heat > 0.0
    assert tc.metal("steel-4340", initial_temperature=400.0).initial_temperature == 400.0
    with pytest.raises(tc.InputError, match="steel-4340"):
        tc.metal("steel")


def test_the_inverse_cube_root_is_exact_to_the_last_digits():
    """Over all scales a volume change may have; the law takes J^(-2/3) and 1/J from it."""
    from tcontact.device import runtime

    runtime.start("cpu")
    import taichi as ti

    from tcontact.kernels.language.arguments import ARRAY
    from tcontact.kernels.language.transcendental import inverse_cube_root

    @ti.kernel
    def roots(a: ARRAY, out: ARRAY):
        for i in range(a.shape[0]):
            out[i] = inverse_cube_root(a[i])

    values = np.concatenate([np.exp(np.random.default_rng(2).uniform(-23.0, 23.0, 2000)), [1.0, 1.0 + 1e-15, 2.0]])
    found = np.zeros_like(values)
    roots(values, found)
    assert found * np.cbrt(values) == pytest.approx(np.ones(len(values)), abs=1e-15)
