"""Friction layers with two sides: metal slides on the metal of an obstacle or of another body (METHOD 5)."""

import dataclasses

import numpy as np
import pytest
from scenes import simulate
from test_friction_contact_layer import AREAL_MASS, DENSITY, PRESSURE, REMOVALS, SPEED, plate, sliding
from test_resume import split

import tcontact as tc
from tcontact.friction_layer import ALUMINIUM_6061, COPPER, STAINLESS_304
from tcontact.friction_layer.grid import half_cells

SIDE, YOUNG = 1e-3, 200e9


def blocks(removal="normal", duration=2e-7, metals=(None, None), lower=2, floor=None, contact="zmin", **model):
    """Two blocks between smooth tops slide on each other, squeezed; floor: obstacles of the lower one.

    With a floor the lower block has no support below.
    """
    law, strain = tc.LinearElastic(YOUNG, 0.0, DENSITY), PRESSURE / YOUNG
    meshes = (
        tc.box_mesh((SIDE,) * 3, (2, 2, 2)),
        tc.box_mesh((SIDE,) * 3, (lower,) * 3, origin=(0.0, 0.0, -SIDE)),
    )
    start = 0.0 if floor is None else SIDE

    def squeezed(nodes):
        return -strain * np.outer(nodes[:, 2] + start, (0.0, 0.0, 1.0))

    up = tc.Body(
        meshes[0],
        law,
        (SPEED / 2, 0.0, 0.0),
        contact,
        [tc.Support("zmax", "z")],
        name="up",
        displacement=squeezed,
        metal=metals[0],
    )
    low = tc.Body(
        meshes[1],
        law,
        (-SPEED / 2, 0.0, 0.0),
        "zmax" if floor is None else ["zmin", "zmax"],
        [tc.Support("zmin", "z")] if floor is None else (),
        name="low",
        displacement=squeezed,
        metal=metals[1],
    )
    friction, obstacles = tc.FrictionLayer(**model), [] if floor is None else floor
    pairs = [tc.Pair("up", "low")]
    return tc.Scene([up, low], obstacles, duration, contact=tc.MasslessContact(removal), friction=friction, pairs=pairs)


def heats(state):
    """Return the heat [k] [J/m^2] on both sides of the layers of a body, which all have one kind of partner."""
    width = half_cells(state.depth)
    sides = [(state.temperature, state.material), (state.partner_temperature, state.partners[0][0])]
    return [(warm - 300.0) @ width * metal.volumetric_heat for warm, metal in sides]


def closed(history):
    """Assert that heat in layers and obstacles is the friction work, in every row."""
    work = history["friction_work"]
    np.testing.assert_allclose(history["layer_heat"] + history["obstacle_heat"], work, rtol=0, atol=1e-12 * work.max())


@pytest.mark.parametrize(("removal", "contact"), [("normal", "zmin"), ("full", ["zmin", "xmin", "ymax"])])
def test_equal_blocks_share_the_heat_equally(removal, contact):
    """The layer is symmetric, all friction work is heat in it, and it bears its shear on the area that is covered."""
    result = simulate(blocks(removal, contact=contact), cfl=0.2)
    history, state = result.history, result.layers[0]
    closed(history)
    assert history["friction_work"][-1] > 1e-4
    assert not history["obstacle_heat"].any()
    assert result.layers[1] is None  # the masters follow
    assert state.partners == ((STAINLESS_304, True),)
    rubbed = state.shear_stress > 0.0
    assert rubbed.sum() == 9
    np.testing.assert_allclose(state.partner_temperature, state.temperature, rtol=1e-13)
    assert state.temperature[rubbed, 0].min() > 340.0
    shear = np.abs(result.pair_force["up-low"][-3:, 0]) / SIDE**2
    # with full removal the faces turn by some mrad; the areas of nodes on edges count more than the face
    np.testing.assert_allclose(shear, history["layer_shear_min"][-3:], rtol=5e-3 if removal == "normal" else 3e-2)


def test_a_layer_between_bodies_is_the_layer_alone():
    """Two lumps of mass that brake each other: shear and temperature at the speed of the rows, row by row."""
    up = plate("normal", stiffness=2e13).bodies[0]
    side = AREAL_MASS / DENSITY
    mesh = tc.box_mesh((side,) * 3, (1, 1, 1), origin=(0.0, 0.0, -side))
    low = dataclasses.replace(
        up, mesh=mesh, velocity=(-SPEED, 0.0, 0.0), contact="zmax", supports=[tc.Support("zmin", "z")], metal=COPPER
    )
    contact = tc.MasslessContact("normal", cell_viscosity=0.0)
    friction = tc.FrictionLayer(thickness=2e-6)
    scene = tc.Scene([up, low], (), 2e-8, contact=contact, friction=friction, pairs=[tc.Pair("body-0", "body-1")])
    history = simulate(scene, dt=1e-9).history
    time, parts = history["time"], 40
    speed = 2.0 * np.sqrt(history["kinetic"] / (AREAL_MASS * side**2))
    fine = (np.arange(parts * (len(time) - 1)) + 0.5) * time[-1] / (parts * (len(time) - 1))
    alone = tc.friction_layer.solve(
        velocity=np.interp(fine, time, speed)[:, None],
        pressure=PRESSURE,
        duration=time[-1],
        dt=fine[1] - fine[0],
        points=40,
        grading=30.0,
        thickness=2e-6,
        reload=True,
        other=COPPER,
    )
    wanted = alone.surface_temperature[::parts, 0]
    assert wanted[1] > 303.0
    rise = (np.abs(history["layer_temperature_max"] - wanted)[1:] / (wanted[1:] - 300.0))[
        :4
    ]  # later the lumps swing in themselves
    assert rise[0] < 0.06
    assert rise[1:].max() < 0.03
    np.testing.assert_allclose(history["layer_shear_min"][:5], alone.shear_stress[::parts, 0][:5], rtol=5e-3)


@pytest.mark.parametrize("removal", REMOVALS)
def test_two_metals_share_the_heat_by_their_effusivities(removal):
    """As two half-spaces in sliding contact, as long as the heat stays near the surface (Carslaw and Jaeger 2.14)."""
    result = simulate(blocks(removal, metals=(COPPER, None), thickness=4e-5), cfl=0.2)
    closed(result.history)
    state = result.layers[0]
    own, other = heats(state)
    wanted = COPPER.effusivity / (COPPER.effusivity + STAINLESS_304.effusivity)
    np.testing.assert_allclose(own / (own + other), wanted, rtol=2e-3)
    np.testing.assert_allclose(state.temperature[:, 0], state.partner_temperature[:, 0], rtol=1e-12)


@pytest.mark.parametrize(("metal", "rtol"), [(STAINLESS_304, 1e-12), (COPPER, 4e-3)])
def test_an_obstacle_with_a_metal_takes_its_part_of_the_heat(metal, rtol):
    scene = sliding(thickness=4e-5)
    scene = dataclasses.replace(scene, obstacles=[tc.Plane(metal=metal)])
    result = simulate(scene, cfl=0.2)
    closed(result.history)
    share = result.history["layer_heat"][-1] / result.history["friction_work"][-1]
    assert share == pytest.approx(STAINLESS_304.effusivity / (STAINLESS_304.effusivity + metal.effusivity), rel=rtol)
    one_sided = simulate(sliding(thickness=4e-5), cfl=0.2)
    closed(one_sided.history)
    hotter = result.history["layer_temperature_max"][-1] - one_sided.history["layer_temperature_max"][-1]
    assert abs(hotter) <= 1e-9 if metal is STAINLESS_304 else hotter < -50.0


@pytest.mark.parametrize("removal", ["normal", pytest.param("full", marks=pytest.mark.slow)])
def test_layers_of_several_kinds_close_the_ledger_and_go_on(removal, monkeypatch, tmp_path):
    """A block on a body on two floors, one of metal: checkpoints hold all layers, and runs go on from them."""
    floor = [tc.Plane((0.0, 0.0, -SIDE), metal=ALUMINIUM_6061), tc.Plane((0.0, 0.0, -1.0))]
    scene = blocks(removal, 1e-7, (COPPER, None), 3, floor, tolerance=0.1)
    whole = split(monkeypatch, tmp_path, scene, 2, tc.CentralDifference(cfl=0.2), every=2, frames=2)
    closed(whole.history)
    assert 0.0 < whole.history["obstacle_heat"][-1] < whole.history["layer_heat"][-1]
    partners = {kind for state in whole.layers if state is not None for kind in state.partners}
    assert {(ALUMINIUM_6061, False), (None, False)} < partners
    assert partners & {(COPPER, True), (STAINLESS_304, True)}
    further = simulate(scene, cfl=0.2, initial=whole).history
    closed(further)
    assert further["layer_temperature_max"][0] == pytest.approx(whole.history["layer_temperature_max"][-1], rel=1e-9)


def test_a_pair_may_have_its_own_coefficient():
    """The layers between two bodies transmit at most their mu P, here less than their metal bears."""
    scene = blocks()
    pair = tc.Pair("up", "low", friction=tc.FrictionLayer(coefficient=0.05))
    result = simulate(dataclasses.replace(scene, friction=None, pairs=[pair]), cfl=0.2)
    force = result.pair_force["up-low"]
    np.testing.assert_allclose(-force[2:, 0], 0.05 * force[2:, 2], rtol=1e-9)
    closed(result.history)


def test_heat_that_leaves_through_the_far_end_is_counted(taichi):
    """What is left in both sides and what has left is the slip work; nothing leaves towards equal temperatures."""
    layer = tc.friction_layer.Layer((COPPER, STAINLESS_304), 3, thickness=1e-6, open_ends=(True, False))
    speed, pressure = np.zeros(layer.padded), np.zeros(layer.padded)
    speed[:2], pressure[:2] = 50.0, 1e9
    layer.set_far_temperature(np.array([300.0, 400.0, 300.0]))
    for _ in range(200):
        layer.advance(speed, pressure, 1e-9)
    out, kept = layer.heat_out(), layer.heat(0) + layer.heat(1)
    np.testing.assert_allclose(kept + out, layer.cell("WORK"), rtol=1e-12, atol=1e-300)
    assert out[0] > 0.5 * layer.cell("WORK")[0]
    assert out[1] < out[0]
    assert out[2] == 0.0
    assert layer.temperature()[1, -1] > 390.0


def test_metals_that_do_not_go_are_refused():
    metal = dataclasses.replace(COPPER, melting_temperature=290.0)
    for wrong in (
        {"obstacles": [tc.Plane(metal=metal)]},
        {"bodies": [dataclasses.replace(plate("full").bodies[0], metal=metal)]},
    ):
        with pytest.raises(tc.InputError, match=r"(Plane|Body)\.metal.*melts at 290 K"):
            dataclasses.replace(plate("full"), **wrong)
    for method in ("stress-secant", "thermal-softening-secant"):
        with pytest.raises(tc.InputError, match=r"FrictionLayer\.method.*two sides"):
            blocks(method=method)
    with pytest.raises(tc.InputError, match=r"Sphere\.metal"):
        tc.Sphere(metal="copper")
    with pytest.raises(tc.InputError, match=r"Body\.metal"):
        dataclasses.replace(plate("full").bodies[0], metal=7.0)
