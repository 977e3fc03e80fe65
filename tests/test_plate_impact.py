"""Metal plates at a wall: exact waves, shocks with viscosity in contact cells and its heat, steps, resumed runs."""

import dataclasses

import numpy as np
import pytest
from test_resume import split

import tcontact as tc
from tcontact.cases import plate_impact
from tcontact.cases._metal_shock import MetalShock


def failed(result):
    return [check for check in plate_impact.checks(result) if not check.passed]


def test_the_exact_waves_of_steel_are_those_of_the_bilinear_solution():
    """Steel at 50 m/s: wall 1.9223 GPa, yield limit 525 MPa, plastic wave 4613.9 m/s at small strains."""
    shock = plate_impact.exact(plate_impact.scene())[0]
    assert shock.behind.stress == pytest.approx(1.92230e9, rel=1e-3)
    assert shock.elastic.stress == pytest.approx(525e6, rel=1e-3)
    assert shock.shock_speed == pytest.approx(4613.9, rel=1e-3)
    assert shock.behind.strain == pytest.approx(0.0055505, rel=6e-3)


@pytest.mark.parametrize("speed", [200.0, 1500.0])
def test_a_metal_that_hardly_resists_shear_follows_its_shock_curve(speed):
    curve = tc.MieGrueneisen(1.489, 2.0, 3940.0)
    law = tc.LinearHardening(1e4)
    soft = tc.ElastoPlastic(124e9, 0.34, 8930.0, law, heat_share=1.0, specific_heat=385.0, pressure=curve)
    shock = MetalShock(soft, speed)
    wanted = 3940.0 + 1.489 * speed
    assert shock.shock_speed == pytest.approx(wanted, rel=1e-5)
    assert shock.behind.pressure == pytest.approx(8930.0 * wanted * speed, rel=1e-5)
    assert shock.behind.temperature == pytest.approx(shock.curve_temperature(speed / wanted), rel=1e-4)


def test_a_slow_plate_is_refused():
    with pytest.raises(tc.InputError, match="elastic"):
        plate_impact.scene(speed=5.0)


def test_steel_meets_its_exact_waves_with_and_without_viscosity():
    smooth, plain = tc.simulate(plate_impact.scene()), tc.simulate(plate_impact.scene(linear=0.0, quadratic=0.0))
    assert not failed(smooth)
    assert not failed(plain)
    wall = [plate_impact.profile(result)["plastic strain"][0] for result in (smooth, plain)]
    assert wall[0] < 0.95 * wall[1]  # the viscosity acts in the cell at the wall too
    history = smooth.history
    given = history["impulse"] + history["support_impulse"]
    assert np.abs(history["momentum"] - history["momentum"][0] - given).max() <= 1e-12 * np.abs(given).max()
    assert np.diff(history["viscous_work"]).min() >= -1e-12 * history["viscous_work"][-1]
    whole = sum(history[name] for name in ("kinetic", "elastic", "plastic_work", "viscous_work"))
    assert history["energy"] == pytest.approx(whole - history["external_work"], rel=1e-12)


@pytest.mark.parametrize("speed", [200.0, 1500.0])
def test_copper_meets_its_shock_curve(speed):
    """Pressure and shock speed within 1 %, temperature within 3 %, by the checks of the case."""
    result = tc.simulate(plate_impact.scene(metal="copper", speed=speed))
    assert not failed(result)
    assert result.history["static_residual"].max() <= 1e-4


def test_heat_of_the_viscosity_warms_the_cells():
    """What the cells gained in heat is plastic heat and viscous work, whatever the equation of state."""
    for equation in ("bulk", "barrier"):
        scene = plate_impact.scene(cells=20, speed=150.0, equation=equation, heat_share=0.5)
        result = tc.simulate(scene)
        metal, body = scene.bodies[0].material, scene.bodies[0]
        volume = np.prod(np.ptp(body.mesh.nodes, axis=0)) / body.mesh.cell_count
        stored = metal.density * metal.specific_heat * volume * (result.metals["temperature"] - 300.0).sum()
        history = result.history
        assert history["viscous_work"][-1] > 0.05 * history["plastic_heat"][-1]
        assert stored == pytest.approx(history["plastic_heat"][-1] + history["viscous_work"][-1], rel=1e-9)


@pytest.mark.parametrize("cfl", [0.9, 0.05])
def test_small_steps_converge(cfl):
    """At small steps the rates of massless nodes are large: without their tangent the static solve diverges."""
    scene = plate_impact.scene(cells=8, linear=0.5, quadratic=2.0)
    result = tc.simulate(scene, tc.CentralDifference(cfl=cfl))
    assert result.ok
    assert result.history["static_residual"].max() <= 1e-4
    assert result.history["energy_error"].max() <= 0.03


def test_resume_has_the_same_bits(monkeypatch, tmp_path):
    scene = plate_impact.scene(cells=10, metal="copper", speed=500.0)
    scene = dataclasses.replace(scene, duration=0.5 * scene.duration)
    scheme = tc.CentralDifference(cfl=0.45)
    whole = split(monkeypatch, tmp_path, scene, 2, scheme, every=3, pressures=False)
    assert whole.history["viscous_work"][-1] > 0.0


def test_scene_files_hold_the_shock_curve(tmp_path):
    scene = plate_impact.scene(cells=4, metal="copper")
    tc.save_scene(scene, tmp_path / "scene.toml")
    back, _options = tc.load_scene(tmp_path / "scene.toml")
    assert back.bodies[0].material == scene.bodies[0].material
    assert isinstance(back.bodies[0].material.pressure, tc.MieGrueneisen)
