"""Friction layers give the heat that leaves through their far ends to the cells behind them, and nothing is lost."""

import dataclasses

import numpy as np
import pytest
from scenes import simulate
from test_layers_two_sides import blocks, sliding
from test_resume import split

import tcontact as tc
from tcontact.friction_layer import COPPER, STAINLESS_304
from tcontact.results.files.vtkhdf import ResultData
from tcontact.schemes.explicit.state import DomainState

FAST = tc.CentralDifference(cfl=0.5)
STEEL = tc.ElastoPlastic(200e9, 0.3, 7900.0, tc.LinearHardening(1e9, 1e9), specific_heat=500.0)
RED = tc.ElastoPlastic(117e9, 0.35, 8930.0, tc.LinearHardening(9e8, 1e9), specific_heat=385.0)


def metal_blocks(removal="normal", laws=(STEEL, RED), floor=None, **model):
    """Two blocks of metal, driven against each other until they yield, that slide on each other at 34 m/s."""
    scene = blocks(removal, 8e-7, (STAINLESS_304, COPPER), floor=floor, thickness=1e-6, **model)
    driven = [tc.Support("zmax", "z", -30.0), tc.Support("zmin", "z", 30.0)]
    bodies = [
        dataclasses.replace(body, material=law, formulation=None, displacement=None, supports=[support])
        for body, law, support in zip(scene.bodies, laws, driven, strict=True)
    ]
    return dataclasses.replace(scene, bodies=bodies)


def rises(folder, scene):
    """Return by how much [K] every cell of every body is warmer than at the start, in the last frame."""
    data = ResultData.open(folder / "result.vtkhdf")
    values = np.split(data.frame(len(data) - 1).cell_data["temperature"], [scene.bodies[0].mesh.cell_count])
    return [now - body.material.initial_temperature for now, body in zip(values, scene.bodies, strict=True)]


@pytest.mark.parametrize("removal", ["normal", pytest.param("full", marks=pytest.mark.slow)])
def test_heat_of_friction_and_of_flow_is_in_layers_and_cells(removal, monkeypatch, tmp_path):
    """Row by row, the cells hold what flowed into them and what plastic flow made, and a resumed run has the bits."""
    scene = metal_blocks(removal, laws=(STEEL, dataclasses.replace(RED, initial_temperature=350.0)))
    whole = split(monkeypatch, tmp_path, scene, 1, FAST, every=9, frames=2)
    history, work = whole.history, whole.history["friction_work"]
    total = history["layer_heat"] + history["body_heat"] + history["obstacle_heat"]
    np.testing.assert_allclose(total, work, rtol=0, atol=1e-12 * work[-1])
    assert history["plastic_heat"][-1] > 0.1 * work[-1]
    assert history["body_heat"][-1] > 0.5 * work[-1]
    warmer = rises(tmp_path / "whole", scene)
    capacities = [
        body.material.density * body.material.specific_heat * body.mesh.cell_volumes() for body in scene.bodies
    ]
    held = sum(float(capacity @ rise) for capacity, rise in zip(capacities, warmer, strict=True))
    assert held == pytest.approx(history["plastic_heat"][-1] + history["body_heat"][-1], rel=1e-9)


def test_points_whose_heat_has_a_pressure_keep_the_heat_of_the_layers(tmp_path):
    """With Gamma = 0 the volume leaves the temperature alone: the cells hold what they were given."""
    law = dataclasses.replace(RED, pressure=tc.MieGrueneisen(1.5, 0.0))
    scene = metal_blocks(laws=(law, law))
    history = tc.simulate(scene, FAST, out=tmp_path / "run", frames=2).history
    capacities = [law.density * law.specific_heat * body.mesh.cell_volumes() for body in scene.bodies]
    held = sum(float(part @ rise) for part, rise in zip(capacities, rises(tmp_path / "run", scene), strict=True))
    assert history["body_heat"][-1] > 0.02 * held
    assert held == pytest.approx(history["plastic_heat"][-1] + history["body_heat"][-1], rel=1e-9)


def test_the_far_end_has_the_temperature_of_the_cells():
    """Between smooth elastic bodies of one temperature nothing flows; a hot one warms a cold one through its layers."""
    strong = tc.LinearHardening(4e9)
    hot = dataclasses.replace(RED, initial_temperature=600.0, hardening=strong)
    for start in (600.0, 300.0):
        law = dataclasses.replace(STEEL, initial_temperature=start, hardening=strong)
        scene = dataclasses.replace(metal_blocks(laws=(law, hot), coefficient=0.0), duration=5e-7)
        result = simulate(scene, cfl=0.5)
        history, state = result.history, next(state for state in result.layers if state is not None)
        sides = state.temperature, state.partner_temperature
        flow = np.abs(history["body_heat"]).max()
        np.testing.assert_allclose(history["layer_heat"] + history["body_heat"], 0.0, rtol=0, atol=1e-16 + 1e-12 * flow)
        if start == 600.0:
            assert flow < 1e-15  # rounding; 1e-7 where the other is cold
            np.testing.assert_allclose(sides, 600.0, rtol=1e-13)
        else:
            np.testing.assert_allclose(sides[0][:, 0], sides[1][:, 0], rtol=1e-12)
            first, second = sorted(side[:, -1].mean() for side in sides)
            assert 300.0 < first < second < 600.0
            assert flow > 1e-8


def test_layers_that_touch_for_the_first_time_are_as_warm_as_the_cells(taichi):
    """What plastic flow has heated is not cold at its surface; layers that have touched keep their own temperature."""
    scene = metal_blocks()
    plan = tc.plan(scene)
    rest = [np.zeros_like(body.initial_nodes) for body in scene.bodies]
    state = DomainState(scene, plan.domains[0], rest, rest, plan.layout)
    layers, exchange = state.layered.layers, state.layered.exchange
    state.begin_contact(1e-9)
    state.internal_force.memory[exchange._places] = 70.0
    pressed = np.ones(len(exchange.given), dtype=bool)
    exchange.set_far_ends(pressed)
    slaves = layers.nodes[0]
    np.testing.assert_allclose(layers.surface_temperature()[slaves], 370.0, rtol=1e-12)
    np.testing.assert_allclose(layers.batches[0].surface_temperature(1), 370.0, rtol=1e-12)
    layers.batches[0]._set_cell(layers.batches[0]._names.WARM, np.ones(len(slaves)))
    state.internal_force.memory[exchange._places] = 90.0
    exchange.set_far_ends(pressed)
    np.testing.assert_allclose(layers.surface_temperature()[slaves], 370.0, rtol=1e-12)


def test_only_bodies_of_metal_take_heat():
    """Steel on rigid copper: cells take it; elastic bodies and metals without a specific heat keep insulated layers."""
    assert "body_heat" not in tc.plan(sliding()).columns
    cold = dataclasses.replace(STEEL, specific_heat=None)
    assert "body_heat" not in tc.plan(metal_blocks(laws=(cold, cold))).columns
    assert "body_heat" in tc.plan(metal_blocks(laws=(cold, RED))).columns
    scene = sliding(thickness=1e-6, duration=2e-7)
    body = dataclasses.replace(scene.bodies[0], material=STEEL, formulation=None)
    scene = dataclasses.replace(scene, bodies=[body], obstacles=[tc.Plane(metal=COPPER)])
    history = simulate(scene, cfl=0.5).history
    parts = [history[name] for name in ("layer_heat", "body_heat", "obstacle_heat")]
    np.testing.assert_allclose(sum(parts), history["friction_work"], rtol=0, atol=1e-12 * history["friction_work"][-1])
    assert min(part[-1] for part in parts) > 0.02 * history["friction_work"][-1]


def test_a_body_hotter_than_its_layer_melts_is_refused():
    hot = dataclasses.replace(RED, initial_temperature=1400.0)
    with pytest.raises(tc.InputError, match=r"Body\.metal.*melts at 1356 K.*start at 1400 K"):
        metal_blocks(laws=(STEEL, hot))


@pytest.mark.parametrize("order", [("bottom", "top"), ("top", "bottom")])
def test_cells_away_from_the_contact_do_not_matter_to_the_layers(order):
    """Whether they keep a temperature, which one, and which region is named first."""
    mesh = tc.box_mesh((4e-5,) * 3, (2, 2, 2))
    low = mesh.cell_centres()[:, 2] < 2e-5
    mesh = mesh.with_sets(cell_sets={"bottom": np.flatnonzero(low), "top": np.flatnonzero(~low)})
    warm = dataclasses.replace(STEEL, initial_temperature=600.0)
    for other in (
        dataclasses.replace(STEEL, specific_heat=None),
        dataclasses.replace(STEEL, initial_temperature=1750.0),
    ):
        laws = {"bottom": warm, "top": other}
        body = tc.Body(
            mesh, {name: laws[name] for name in order}, (30.0, 0.0, -10.0), "zmin", displacement=(0, 0, 2e-8)
        )
        contact, friction = tc.MasslessContact(removal="normal"), tc.FrictionLayer(thickness=1e-6, points=10)
        scene = tc.Scene([body], [tc.Plane()], 4e-9, contact=contact, friction=friction)
        history = simulate(scene, cfl=0.5).history
        assert history["layer_temperature_max"][:2].tolist() == [600.0, 600.0]
        assert history["layer_temperature_max"][-1] > 601.0
        assert history["body_heat"][-1] > 0.0


def test_a_region_at_the_contact_that_starts_molten_is_refused_whatever_is_named_first():
    mesh = tc.box_mesh((1e-3,) * 3, (1, 1, 2))
    mesh = mesh.with_sets(cell_sets={"bottom": [0], "top": [1]})
    hot = dataclasses.replace(STEEL, initial_temperature=3000.0)
    for names in (("top", "bottom"), ("bottom", "top")):
        body = tc.Body(mesh, {name: {"top": STEEL, "bottom": hot}[name] for name in names}, contact="zmin")
        with pytest.raises(tc.InputError, match="its layers start at 3000 K"):
            tc.Scene([body], [tc.Plane()], 1e-9, friction=tc.FrictionLayer())
