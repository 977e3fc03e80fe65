"""Layers of a run that starts from another one go on as those of what they were on, whatever a body meets then."""

import dataclasses

import numpy as np
import pytest
from scenes import simulate

import tcontact as tc
from tcontact.friction_layer import COPPER, STAINLESS_304, Layer

DT, STEPS = 2e-8, 30


def metal(temperature=300.0):
    """A metal whose cells keep a temperature, so that layers at them have open ends."""
    law = tc.LinearHardening(1e9, 1e9)
    return tc.ElastoPlastic(200e9, 0.3, 7900.0, law, specific_heat=500.0, initial_temperature=temperature)


ELASTIC = tc.NeoHookean(200e9, 0.3, 7900.0)


def bridge(laws, steps=STEPS, metals=(None, None), slave="up"):
    """A block that is pressed on two others side by side and slides on both; laws and metals: of these two."""
    origins = (-2.1e-3, 0.0, -1e-3), (1e-4, 0.0, -1e-3)
    mesh = tc.box_mesh((2e-3, 1e-3, 1e-3), (4, 1, 1), origin=(-1e-3, 0.0, 1e-6))
    driven, held = tc.Support("zmax", "xz", (60.0, -10.0)), tc.Support("zmin", "xyz")
    up = tc.Body(mesh, metal(), (60.0, 0.0, -10.0), "zmin", [driven], name="up")
    low = [
        tc.Body(
            tc.box_mesh((2e-3, 1e-3, 1e-3), (2, 1, 1), origin=origin),
            law,
            contact="zmax",
            supports=[held],
            name=name,
            metal=own,
        )
        for name, origin, law, own in zip("ab", origins, laws, metals, strict=True)
    ]
    pairs = [tc.Pair("up", name, slave=slave if slave == "up" else name) for name in "ab"]
    friction, contact = tc.FrictionLayer(thickness=1e-5), tc.MasslessContact("normal")
    return tc.Scene([up, *low], [], (steps - 0.5) * DT, friction=friction, pairs=pairs, contact=contact)


def slider(obstacles, steps=STEPS, **model):
    """A block that is pressed on obstacles and slides on the first of them."""
    driven = tc.Support("zmax", "xz", (60.0, -10.0))
    mesh = tc.box_mesh((2e-3,) * 3, (2, 2, 2), origin=(0.0, 0.0, 1e-6))
    body = tc.Body(mesh, ELASTIC, (60.0, 0.0, -10.0), "zmin", [driven], name="slider")
    friction, contact = tc.FrictionLayer(**({"thickness": 1e-5} | model)), tc.MasslessContact("normal")
    return tc.Scene([body], obstacles, (steps - 0.5) * DT, friction=friction, contact=contact)


def far(**more):
    """A floor that the slider does not reach."""
    return tc.Plane((0.0, 0.0, -1.0), **more)


@pytest.fixture(scope="module")
def slid():
    """The ends of runs on one floor, by the metal of the floor."""
    return {floor: simulate(slider([tc.Plane(metal=floor)]), dt=DT) for floor in (None, COPPER)}


@pytest.mark.parametrize("laws", [(metal(), metal(301.0)), (ELASTIC, metal()), (metal(), ELASTIC)])
def test_layers_of_one_metal_on_two_masters_go_on_each_for_itself(laws):
    """They differ in their start temperature, or in which cells keep heat: the halves are the whole run."""
    whole, first = simulate(bridge(laws, 2 * STEPS), dt=DT), simulate(bridge(laws), dt=DT)
    assert first.layers[0].partners == ((STAINLESS_304, True),) * 2
    second = simulate(bridge(laws), dt=DT, initial=first)
    before, after = first.history, second.history
    assert before["layer_temperature_max"][-1] > 500.0
    for name in ("layer_temperature_max", "layer_shear_min"):
        assert after[name][0] == pytest.approx(before[name][-1], rel=1e-12)
    for wanted, found in zip(whole.layers[0].kinds, second.layers[0].kinds, strict=True):
        assert wanted == found
    np.testing.assert_array_equal(second.layers[0].internal["used"], whole.layers[0].internal["used"])
    rise = np.abs(whole.layers[0].temperature - 300.0).max()
    np.testing.assert_allclose(second.layers[0].temperature, whole.layers[0].temperature, rtol=0, atol=3e-3 * rise)
    for place in range(2):
        profiles = (one.layers[0].internal[f"{place}/rise"] for one in (second, whole))
        np.testing.assert_allclose(*profiles, rtol=0, atol=3e-3 * rise)
    for name in ("friction_work", "layer_heat", "body_heat"):
        total, work = before[name][-1] + after[name][-1], whole.history["friction_work"][-1]
        np.testing.assert_allclose(total, whole.history[name][-1], rtol=0, atol=2e-3 * work)


def test_a_state_of_an_earlier_version_says_its_kinds_by_the_scene():
    """It has none: the scene of its run has them in the same order."""
    first = simulate(bridge((metal(), metal(301.0))), dt=DT)
    known = simulate(bridge((metal(), metal(301.0)), 3), dt=DT, initial=first)
    old = tuple(None if one is None else dataclasses.replace(one, kinds=()) for one in first.layers)
    again = simulate(bridge((metal(), metal(301.0)), 3), dt=DT, initial=dataclasses.replace(first, layers=old))
    np.testing.assert_array_equal(again.layers[0].temperature, known.layers[0].temperature)


@pytest.mark.parametrize(
    ("floor", "other", "slip"), [(None, COPPER, 5.0), (COPPER, STAINLESS_304, 90.0), (COPPER, None, None)]
)
def test_the_own_side_goes_on_where_the_floor_has_another_metal(slid, floor, other, slip):
    """It keeps temperature and strain, the floor's side starts new, and the heat of the run is its friction work.

    slip [K]: the most that a step of slip adds to the surface temperature of the two half spaces that touch.
    """
    first = slid[floor]
    left = first.layers[0]
    start = simulate(slider([tc.Plane(metal=other)], 1), dt=DT, initial=first)
    state = start.layers[0]
    hottest = left.temperature.max()
    assert hottest > 360.0
    assert start.history["layer_temperature_max"][0] == pytest.approx(hottest, rel=1e-9)
    second = simulate(slider([tc.Plane(metal=other)], 5), dt=DT, initial=first)
    assert (second.layers[0].plastic_strain >= left.plastic_strain * (1.0 - 1e-12)).all()
    assert second.layers[0].plastic_strain.max() > 0.0
    work, parts = second.history["friction_work"], ("layer_heat", "obstacle_heat")
    np.testing.assert_allclose(sum(second.history[name] for name in parts), work, rtol=0, atol=1e-12 * work[-1])
    inside = second.layers[0].depth > 4e-6
    np.testing.assert_allclose(second.layers[0].temperature[:, inside], left.temperature[:, inside], atol=40.0)
    if other is not None:
        own, partner = (values[:, 0].mean() for values in (state.temperature, state.partner_temperature))
        assert own == pytest.approx(partner, rel=1e-9)
        share = STAINLESS_304.effusivity / (STAINLESS_304.effusivity + other.effusivity)
        touch = 300.0 + share * (left.temperature[:, 0].mean() - 300.0)  # of a warm half space and a new one
        assert -1.0 < own - touch < slip
        np.testing.assert_allclose(state.partner_temperature[:, -1], 300.0, atol=0.1)


def test_the_own_side_takes_the_plastic_heat_that_waits_with_it(taichi):
    """One side of two goes on alone: its heat, its strain and the heat that its flow has not yet given it."""
    old = Layer((COPPER,), 3, points=12, thickness=2e-6, plastic_heat=0.9)
    speed, pressure = np.zeros(old.padded), np.zeros(old.padded)
    speed[:2], pressure[:2] = 100.0, 1e9
    for _ in range(30):
        old.advance(speed, pressure, 1e-9)
    own, cells = old.state() | {"own": np.array(True)}, np.arange(3)
    assert (old.carried()[:2] > 0.0).all()
    for share in (0.9, 0.0):
        new = Layer((COPPER, STAINLESS_304), 3, points=12, thickness=2e-6, plastic_heat=share)
        new.start_from(cells, cells, own)
        np.testing.assert_allclose(new.heat() + new.carried(), old.heat() + old.carried(), rtol=1e-12)
        np.testing.assert_array_equal(new.plastic_strain(), old.plastic_strain())
        assert not new.heat(1).any()
        assert not new.plastic_strain(1).any()
        assert not new.cell("STRESS").any()
        np.testing.assert_array_equal(new.cell("WARM"), old.cell("WARM"))


def test_what_cannot_go_on_is_refused_before_a_folder_is_made(slid, tmp_path):
    """Another metal of a master, pairs the other way round, layers that would be one here and several there."""
    laws, out = (metal(), metal()), tmp_path / "out"
    first = simulate(bridge(laws), dt=DT)
    plain = slid[None]
    shared = simulate(slider([tc.Plane(), far()], 10), dt=DT)
    apart = simulate(slider([tc.Plane(), far(metal=COPPER)], 10), dt=DT)
    for scene, initial, said in (
        (bridge(laws, metals=(None, COPPER)), first, r"Body\.metal.*b had another metal in the run of initial.*of up"),
        (bridge(laws, slave="low"), first, r"layers between up and a are those of up.*Pair\(slave=\"up\"\)"),
        (slider([tc.Plane(metal=COPPER), far()]), shared, "slider on obstacle-0 and obstacle-1 are one"),
        (slider([tc.Plane(metal=COPPER), far(metal=COPPER)]), apart, "slider on obstacle-0 and obstacle-1 are one"),
        (slider([tc.Plane(metal=COPPER), tc.Plane()]), plain, "new ones names or last places"),
    ):
        with pytest.raises(tc.InputError, match=said):
            tc.simulate(scene, tc.CentralDifference(dt=DT), initial=initial, out=out)
        assert not out.exists()


def test_obstacles_may_come_and_go(slid):
    """The layer on the floor goes on beside those on new obstacles, and as that on another one in its place."""
    first = slid[None]
    hottest = first.history["layer_temperature_max"][-1]
    for obstacles in (
        [tc.Plane(), far(metal=COPPER)],
        [far(metal=COPPER, name="new"), tc.Plane()],
        [tc.Plane(metal=COPPER, name="other")],
    ):
        history = simulate(slider(obstacles, 1), dt=DT, initial=first).history
        assert history["layer_temperature_max"][0] == pytest.approx(hottest, rel=1e-9)
    warmer = slider([tc.Plane(), far(metal=COPPER)], 1, initial_temperature=320.0)
    assert simulate(warmer, dt=DT, initial=first).history["layer_temperature_max"][0] == pytest.approx(hottest)
