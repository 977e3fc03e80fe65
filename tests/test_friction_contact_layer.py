"""Friction layers in a run: their heat is friction work, they outlive contact, cost nothing where absent (METHOD 5)."""

import sys
from dataclasses import fields, replace
from itertools import pairwise

import numpy as np
import pytest
from scenes import simulate, state_of
from test_named_warnings import warned

import tcontact as tc
from tcontact.cases import hot_slide
from tcontact.contact import layered_friction
from tcontact.friction_layer import COPPER
from tcontact.kernels.columns import group_columns
from tcontact.results.files.vtkhdf import ResultData

LAYERS = [column.name for column in group_columns("layers") if column.name != "body_heat"]  # for that of metals
REMOVALS = ["normal", "full"]
SPEED, PRESSURE = 34.0, 1e9
AREAL_MASS, DENSITY = 0.5, 7900.0  # [kg/m^2], [kg/m^3]


def plate(removal, duration=2e-7, stiffness=2e15):
    """One squeezed cell that slides, so stiff that it stays one lump of mass: what it loses has gone into friction."""
    side = AREAL_MASS / DENSITY
    block = tc.Body(
        tc.box_mesh((side, side, side), (1, 1, 1)),
        tc.LinearElastic(stiffness, 0.0, DENSITY),
        velocity=(SPEED, 0.0, 0.0),
        contact="zmin",
        displacement=lambda nodes: nodes * (0.0, 0.0, -PRESSURE / stiffness),
        supports=[tc.Support("zmax", "z")],
    )
    contact = tc.MasslessContact(removal=removal)
    return tc.Scene([block], [tc.Plane()], duration, contact=contact, friction=tc.FrictionLayer())


def sliding(removal="normal", duration=1e-7, friction=None, **model):
    """The squeezed steel block of hot-slide, two cells high."""
    scene = hot_slide.scene(cells=2, speed=SPEED, pressure=PRESSURE, removal=removal, duration=duration)
    friction = friction or tc.FrictionLayer(**model)
    return tc.Scene(scene.bodies, scene.obstacles, duration, contact=scene.contact, friction=friction)


@pytest.mark.parametrize("removal", REMOVALS)
def test_a_mass_brought_to_rest_has_turned_into_friction_work_and_heat(removal):
    result = simulate(plate(removal), cfl=0.5)
    history = result.history
    kinetic, work = history["kinetic"], history["friction_work"]
    side = AREAL_MASS / DENSITY
    assert kinetic[0] == pytest.approx(0.5 * AREAL_MASS * side**2 * SPEED**2, rel=1e-12)
    assert kinetic[-1] < 1e-5 * kinetic[0]  # at rest but for what the stop left ringing
    lost = (kinetic + history["elastic"])[0] - (kinetic + history["elastic"])[-1]
    resisted = history["viscous_work"][-1] if removal == "normal" else 0.0  # in the contact cells
    assert 0.0 <= resisted <= 1e-5 * work[-1]
    assert work[-1] + resisted == pytest.approx(kinetic[0] - kinetic[-1], rel=1e-6)
    assert work[-1] == pytest.approx(lost, rel=1e-4)  # the rest of the ringing
    assert history["layer_heat"][-1] == pytest.approx(0.5 * work[-1], rel=1e-6)
    # the layer and not mu P held it: 34 m/s stopped within 94 ns by some 180 MPa
    braking = -history["contact_force"][:, 0] / side**2
    assert 150e6 < braking[: len(braking) // 4].max() < 0.3 * PRESSURE


@pytest.mark.parametrize("removal", REMOVALS)
def test_heat_is_its_share_of_the_friction_work_row_by_row(removal):
    history = simulate(sliding(removal), cfl=0.2).history
    work = history["friction_work"]
    assert len(work) >= 5
    assert (np.diff(work) >= -1e-12 * work.max()).all()  # massless nodes stick until their stress has built up
    assert work[-1] > 1e-3
    np.testing.assert_allclose(history["layer_heat"], 0.5 * work, rtol=0, atol=1e-12 * work.max())


def test_layers_are_what_the_model_says():
    """Every option of the model, none at its default and all of them, arrives at the layers of the contact nodes."""
    options = {"points": 8, "grading": 10.0, "thickness": 2e-6, "heat_share": 0.3, "plastic_heat": 0.5}
    options |= {"initial_temperature": 400.0, "method": "stress-secant", "reload": False}
    defaults = {field.name: field.default for field in fields(tc.FrictionLayer)}
    assert all(defaults[name] != value for name, value in options.items())
    assert set(defaults) - set(options) == {"material", "coefficient", "tolerance", "substeps"}
    for given in ({"material": COPPER} | options, {}):
        scene = sliding(**given)
        body = tc.plan(scene).bodies[0]
        layer, wanted = state_of(scene, body).contact.friction.layers.batches[0], defaults | given
        assert layer.metals == (wanted["material"],)
        for name in set(options) - {"grading"}:
            assert getattr(layer, name) == wanted[name], name
        assert np.diff(layer.depth)[-1] / np.diff(layer.depth)[0] == pytest.approx(wanted["grading"])


def test_hot_slide_meets_its_checks_and_says_when_it_does_not():
    scene = hot_slide.scene(cells=2, speed=SPEED, pressure=PRESSURE, duration=1e-7)
    result = simulate(scene, cfl=hot_slide.SCHEME["cfl"])
    found = hot_slide.checks(result)
    assert len(found) == 11
    assert not [check for check in found if not check.passed]
    for column, share in (("layer_heat", 1.001), ("friction_work", 1.2), ("layer_temperature_max", 10.0)):
        spoiled = replace(result, history=result.history | {column: share * result.history[column]})
        assert [check for check in hot_slide.checks(spoiled) if not check.passed], column
    layer, dry = hot_slide.comparison(cells=2).values()
    assert isinstance(layer.friction, tc.FrictionLayer)
    assert dry.friction == tc.Coulomb(layer.friction.coefficient)


def test_layers_stay_warm_through_opening_and_meet_the_wall_again_warm():
    mesh = tc.box_mesh((1e-3, 1e-3, 1e-3), (2, 2, 2), origin=(0, 0, 1.3e-7))
    body = tc.Body(mesh, tc.LinearElastic(200e9, 0.3, DENSITY), velocity=(SPEED, 0.0, -20.0), contact="zmin")
    scene = tc.Scene(
        [body],
        [tc.Plane()],
        6e-6,
        gravity=(0.0, 0.0, -2e7),  # brings it back within 2 us
        contact=tc.MasslessContact("normal"),
        friction=tc.FrictionLayer(),
    )
    history = simulate(scene, cfl=0.5).history
    touching = history["contact_nodes"] > 0
    began = np.flatnonzero(touching & ~np.roll(touching, 1))
    opened = np.flatnonzero(history["contact_nodes"] == 0)
    first, again = began[0], began[began > opened[opened > began[0]][0]][0]
    away = opened[(opened > first) & (opened < again)]
    assert len(away) >= 5
    hottest, heat = history["layer_temperature_max"], history["layer_heat"]
    held = heat[away[0]] / 1e-6 / (3.95e6 * 10e-6)  # [K], spread over the layer: it insulates the depth
    assert held > 10.0
    assert (hottest[away] > 300.0 + 0.9 * held).all()  # never back at the start
    assert (np.diff(hottest[away]) <= 0.0).all()  # it only evens out
    assert np.ptp(heat[away]) <= 1e-12 * heat[-1]  # nothing rubs
    assert (np.diff(heat) >= -1e-12 * heat[-1]).all()
    assert hottest[again] > 300.0 + held
    assert heat[-1] > 1.2 * heat[away[-1]]
    assert hottest[again:].max() > hottest[again]


@pytest.mark.parametrize("removal", REMOVALS)
def test_a_smaller_tolerance_brings_heat_and_shear_closer(removal):
    fine = simulate(sliding(removal, duration=3e-7, tolerance=1e-5, substeps=256), cfl=0.2).history
    runs = [
        simulate(sliding(removal, duration=3e-7, tolerance=0.16 / 4**n, substeps=256), cfl=0.2).history
        for n in range(6)
    ]
    for name in ("layer_temperature_max", "layer_shear_min"):
        errors = [np.abs(run[name] - fine[name])[1:].max() for run in runs]
        assert all(closer <= 1.05 * far for far, closer in pairwise(errors))
        assert errors[-1] < 0.25 * errors[0]


def test_a_scene_without_layers_has_nothing_of_them(monkeypatch):
    import tcontact.kernels.layer

    with_layers = tc.plan(sliding())
    assert set(LAYERS) <= set(with_layers.columns)
    monkeypatch.delitem(sys.modules, "tcontact.kernels.layer.layer1d", raising=False)
    monkeypatch.delattr(tcontact.kernels.layer, "layer1d", raising=False)
    scene = sliding()
    result = simulate(tc.Scene(scene.bodies, scene.obstacles, 5e-8, contact=scene.contact))
    assert "tcontact.kernels.layer.layer1d" not in sys.modules
    assert not [name for name in result.history if name.startswith("layer")]
    assert "friction-layer" not in result.memory
    assert "friction-layer" not in result.terms


def test_frames_hold_temperature_and_shear_of_the_layers(tmp_path):
    scene = sliding("normal")
    result = simulate(scene, cfl=0.2, out=tmp_path, frames=2)
    data = ResultData.open(tmp_path / "result.vtkhdf")
    assert len(data) == 2
    below = scene.bodies[0].mesh.nodes[:, 2] == 0.0
    for index in range(2):
        fields = data.frame(index).point_data
        assert (fields["layer_temperature"][~below] == 300.0).all()
        assert (fields["layer_shear"][~below] == 0.0).all()
    last = data.frame(1).point_data
    assert last["layer_temperature"].max() == pytest.approx(result.history["layer_temperature_max"][-1], rel=1e-6)
    assert last["layer_shear"][below].min() == pytest.approx(result.history["layer_shear_min"][-1], rel=1e-6)
    assert (last["layer_temperature"][below] > 320.0).all()
    assert (last["layer_shear"][below] > 150e6).all()


@pytest.mark.slow  # kernels for a moving wall are compiled
def test_a_wall_that_slides_under_a_resting_body_heats_as_much_as_a_resting_one_under_a_moving_body():
    wall = np.array([SPEED, 0.0, 20.0])

    def hit(moving):
        mesh = tc.box_mesh((1e-3, 1e-3, 1e-3), (2, 2, 2), origin=(0, 0, 1.3e-7))
        velocity = (0.0, 0.0, 0.0) if moving else -wall
        body = tc.Body(mesh, tc.LinearElastic(200e9, 0.3, DENSITY), velocity=velocity, contact="zmin")
        plane = tc.Plane(velocity=wall if moving else None)
        contact = tc.MasslessContact("full", tolerance=1e-12)
        return simulate(tc.Scene([body], [plane], 4e-7, contact=contact, friction=tc.FrictionLayer()), dt=2e-8)

    thrown, struck = hit(False), hit(True)
    assert thrown.history["layer_temperature_max"][-1] > 400.0
    for name in ("contact_force", "friction_work", "elastic", *LAYERS):
        wanted = np.nan_to_num(thrown.history[name])
        found = np.nan_to_num(struck.history[name])
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9 * np.abs(wanted).max(), err_msg=name)
    np.testing.assert_allclose(struck.position, thrown.position + wall * struck.time, rtol=0, atol=1e-12)


@pytest.mark.parametrize(("removal", "tolerance"), [("normal", 0.5), ("full", 1e-2)])  # 0.5: steps between layer steps
def test_a_layer_that_has_left_the_wall_holds_its_share_of_the_work(removal, tolerance, tmp_path):
    """Nothing of it waits for the next contact: the last steps before a node opens count too."""
    thickness, side = 1e-6, 1e-3
    mesh = tc.box_mesh((side, side, side), (2, 2, 2), origin=(0, 0, 1.3e-7))
    body = tc.Body(mesh, tc.LinearElastic(200e9, 0.3, DENSITY), velocity=(SPEED, 0.0, -20.0), contact="zmin")
    layer = tc.FrictionLayer(thickness=thickness, tolerance=tolerance)
    scene = tc.Scene([body], [tc.Plane()], 2.5e-6, contact=tc.MasslessContact(removal), friction=layer)
    history = simulate(scene, cfl=0.5, out=tmp_path, frames=2).history
    assert history["contact_nodes"].max() == 9
    assert not history["contact_nodes"][-20:].any()  # three times as long as heat takes through the layer
    x, y, z = mesh.nodes.T
    share = (z == z.min()) * (1 + np.isclose(x, side / 2)) * (1 + np.isclose(y, side / 2)) / 16
    warmth = ResultData.open(tmp_path / "result.vtkhdf").frame(1).point_data["layer_temperature"] - 300.0
    held = (share * warmth).sum() * side**2 * thickness * layer.material.volumetric_heat
    assert held == pytest.approx(layer.heat_share * history["friction_work"][-1], rel=1e-4)


@pytest.mark.parametrize("removal", REMOVALS)
def test_layers_that_stuck_for_long_heat_as_soon_as_they_slide(removal):
    """A block sheared by its top sticks for some forty steps; what makes long layer steps then must end with it."""
    side, young = 1e-3, 200e9
    block = tc.Body(
        tc.box_mesh((side, side, side), (2, 2, 2)),
        tc.LinearElastic(young, 0.0, DENSITY),
        contact="zmin",
        displacement=lambda nodes: nodes * (0.0, 0.0, -PRESSURE / young),
        supports=[tc.Support("zmax", "xyz", velocity=(SPEED, 0.0, 0.0))],
    )
    contact = tc.MasslessContact(removal)
    scene = tc.Scene([block], [tc.Plane()], 5e-7, contact=contact, friction=tc.FrictionLayer())
    history = simulate(scene, dt=5e-9).history
    work, hottest = history["friction_work"], history["layer_temperature_max"]
    onset = np.flatnonzero(work > 1e-6 * work[-1])[0]
    assert 30 <= onset <= 50
    assert hottest[onset - 2] == pytest.approx(300.0, abs=1e-6)
    assert history["layer_substeps"][onset - 2] < 1.0  # nothing to resolve
    assert hottest[onset + 3] > 300.1


@pytest.mark.parametrize("removal", REMOVALS)
def test_a_row_shows_the_layers_at_its_time(removal, tmp_path):
    """Cold in row 0, and then as the layer alone with the speed of the rows: not half a step ahead.

    The speed of the rows is that of the whole block: its contact cell has no viscosity, which would hold the face back.
    """
    scene = plate(removal, duration=2e-8, stiffness=2e13)
    scene = replace(scene, contact=replace(scene.contact, cell_viscosity=0.0))
    result = simulate(scene, dt=1e-9, out=tmp_path, frames=2)
    history = result.history
    hottest, shear = history["layer_temperature_max"], history["layer_shear_min"]
    assert hottest[0] == 300.0
    assert abs(history["layer_heat"][0]) <= 1e-15 * history["layer_heat"][-1]
    first = ResultData.open(tmp_path / "result.vtkhdf").frame(0).point_data["layer_temperature"]
    assert (first == 300.0).all()
    if removal == "full":  # sticks until the massless nodes have built up their stress
        return
    parts = 40
    time, speed = history["time"], history["momentum"][:, 0] / (AREAL_MASS * (AREAL_MASS / DENSITY) ** 2)
    fine = (np.arange(parts * (len(time) - 1)) + 0.5) * time[-1] / (parts * (len(time) - 1))
    alone = tc.friction_layer.solve(
        velocity=np.interp(fine, time, speed)[:, None],
        pressure=PRESSURE,
        duration=time[-1],
        dt=fine[1] - fine[0],
        points=40,
        grading=30.0,
        reload=True,
    )
    wanted = alone.surface_temperature[::parts, 0]
    assert wanted[1] > 310.0
    rise = (np.abs(hottest - wanted)[1:] / (wanted[1:] - 300.0))[:6]  # later the block swings in itself
    assert rise[0] < 0.06  # half a step ahead: 0.22, and then 0.12, 0.08, 0.06, 0.05, 0.04
    assert rise[1:].max() < 0.03
    np.testing.assert_allclose(shear[:7], alone.shear_stress[::parts, 0][:7], rtol=5e-3)


def test_plastic_heat_is_that_of_the_row():
    """Heat, share of the friction work and plastic heat belong to one time: nothing is there before anything moves."""
    history = simulate(sliding(plastic_heat=0.9, duration=5e-8), cfl=0.2).history
    assert abs(history["layer_heat"][0]) < 1e-15 * history["layer_heat"][-1]
    more = history["layer_heat"] - 0.5 * history["friction_work"]
    assert (np.diff(more) > 0.0).all()
    assert more[-1] > 1e-4 * history["layer_heat"][-1]


def test_a_contact_that_closes_again_knows_nothing_of_the_stress_before():
    """A block that slides, lifts off and comes back has layers far too strong to flow, which have no error at all."""
    body = tc.Body(
        tc.box_mesh((0.1, 0.1, 0.05), (3, 3, 2)), tc.NeoHookean(1e6, 0.2, 1e3), velocity=(0.05, 0, 0), contact="zmin"
    )
    friction, contact = tc.FrictionLayer(coefficient=0.3), tc.MasslessContact("full")
    scene = tc.Scene([body], [tc.Plane()], 0.02, gravity=(0, 0, -9.81), friction=friction, contact=contact)
    result, kinds = warned(scene)
    nodes = result.history["contact_nodes"]
    assert (np.diff(nodes) < 0).any()  # they open
    assert (np.diff(nodes) > 0).any()  # they close
    assert result.history["layer_error"].max() < 1e-3
    assert not kinds


def test_friction_layers_that_are_not_accurate_are_named():
    """One layer step a mechanical one at 2 km/s is far off; as many as it takes are not."""
    scene = hot_slide.scene(cells=2, speed=2000.0, duration=3e-7)
    coarse = replace(scene, friction=replace(scene.friction, substeps=1))
    result, kinds = warned(coarse)
    assert result.ok
    assert kinds == [tc.LayerWarning]
    assert result.history["layer_error"].max() > 5.0 * scene.friction.tolerance
    assert "more than substeps=1" in result.warnings[0]
    result, kinds = warned(scene)
    assert result.history["layer_error"].max() < 5.0 * scene.friction.tolerance
    assert not kinds


@pytest.mark.parametrize(("own", "of_scene"), [(0.05, 0.3), (0.3, 0.05), (0.05, None), (0.0, 0.3)])
def test_a_layer_has_the_coefficient_of_the_obstacle(own, of_scene):
    """Whether the obstacle or the scene names it: in the force, and in the heat that the profiles hold."""
    scene = sliding(duration=6e-8)
    (plane,) = scene.obstacles
    friction = tc.FrictionLayer(coefficient=own) if own else tc.NoFriction()
    law = None if of_scene is None else tc.FrictionLayer(coefficient=of_scene)
    found = simulate(replace(scene, obstacles=[replace(plane, friction=friction)], friction=law), cfl=0.2)
    if not own:
        assert (found.history["layer_temperature_max"] == 300.0).all()
        assert not found.history["friction_work"].any()
        return
    wanted = simulate(replace(scene, friction=friction), cfl=0.2)
    assert wanted.history["friction_work"][-1] > 0.0
    for name in ("contact_force", "friction_work", *LAYERS):
        assert np.array_equal(found.history[name], wanted.history[name], equal_nan=True), name
    assert np.array_equal(found.layers[0].temperature, wanted.layers[0].temperature)


@pytest.mark.parametrize("removal", ["normal", pytest.param("full", marks=pytest.mark.slow)])
def test_obstacles_that_press_a_node_together_share_the_limit_of_its_layer(removal):
    """A plane twice is a plane: the rows of a node have the shear force of its layer together, not each."""
    scene = sliding(removal, duration=6e-8)
    once, twice = (simulate(replace(scene, obstacles=scene.obstacles * count), cfl=0.2).history for count in (1, 2))
    area = np.prod(np.ptp(scene.bodies[0].mesh.nodes, axis=0)[:2])
    assert -once["contact_force"][-1, 0] < 0.25 * once["contact_force"][-1, 2]  # mu is .3: the layer limits it
    rounding = 1e-9 if removal == "normal" else 2e-3  # its layers use the stress of the step before
    for name in ("contact_force", "friction_work", "layer_heat", "layer_temperature_max"):
        np.testing.assert_allclose(twice[name], once[name], rtol=rounding, atol=rounding * np.abs(once[name]).max())
    assert -twice["contact_force"][-1, 0] / area < 1.1 * twice["layer_shear_min"][-1]


def beside_a_wall(pressure, contact):
    """The block on a floor and at a wall without friction; pressure: on the wall, as a share of that on the floor."""
    mesh = tc.box_mesh((1e-3,) * 3, (2, 1, 2))
    squeeze = PRESSURE / 200e9 * np.array((0.0, pressure, 1.0))
    body = tc.Body(
        mesh,
        tc.LinearElastic(200e9, 0.0, DENSITY),
        velocity=(SPEED, 0.0, 0.0),
        contact=["zmin", "ymin"],
        supports=[tc.Support("zmax", "z"), tc.Support("ymax", "y")],
        displacement=lambda x: -x * squeeze,
    )
    smooth = tc.Plane((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), friction=tc.NoFriction())
    return tc.Scene([body], [tc.Plane(), smooth], 3e-8, contact=contact, friction=tc.FrictionLayer())


def test_a_wall_without_friction_leaves_that_of_the_floor_however_hard_it_presses():
    """At the edge it presses harder than the floor, whose friction the layers there limit."""
    last = [
        simulate(beside_a_wall(pressure, tc.PenaltyContact(1e16)), cfl=0.2).history["contact_force"][-1]
        for pressure in (0.5, 4.0)
    ]
    assert last[0][0] < -200.0
    assert last[1][0] == pytest.approx(last[0][0], rel=0.05)


def test_friction_of_static_solve_and_kick_together_have_the_limit_of_the_layer():
    """Nodes at planes of two directions have mass along both in normal removal, and friction from both."""
    history = simulate(beside_a_wall(0.9, tc.MasslessContact(removal="normal")), cfl=0.2).history
    force = history["contact_force"][-1]
    assert 200.0 < -force[0] < 0.3 * force[2]


@pytest.mark.parametrize("removal", REMOVALS)
def test_a_layer_step_spans_no_pulse_of_heat(monkeypatch, removal):
    """A layer too strong to flow, whose slip stops and turns: steps of several mechanical ones heat it as single ones.

    Its stress does not change, its surface temperature does: spans chosen by the stress alone are 74 K off.
    """
    size = 1e-4
    pulses = [0.0, 0.3e-6, 0.31e-6, 0.45e-6, 0.46e-6, 1.0], [SPEED, SPEED, 0.0, 0.0, -25.0, -25.0]
    column = tc.Body(
        tc.box_mesh((size,) * 3, (1, 1, 4)),
        tc.LinearElastic(200e9, 0.0, DENSITY),
        velocity=(SPEED, 0.0, 0.0),
        contact="zmin",
        displacement=lambda nodes: nodes * (0.0, 0.0, -PRESSURE / 200e9),
        supports=[
            tc.Support("zmax", "z"),
            tc.Support("zmax", "x", velocity=lambda time: float(np.interp(time, *pulses))),
            tc.Support("zmax", "y"),
        ],
        periodic="xy",
    )
    contact = tc.MasslessContact(removal=removal, cell_viscosity=0.2 if removal == "normal" else None)
    scene = tc.Scene([column], [tc.Plane()], 0.6e-6, contact=contact, friction=tc.FrictionLayer())
    spanned = simulate(scene, dt=2.4e-9).history
    monkeypatch.setattr(layered_friction, "MAXIMUM_SPAN", 1)
    single = simulate(scene, dt=2.4e-9).history
    assert spanned["layer_substeps"].min() <= 0.25
    off = np.abs(spanned["layer_temperature_max"] - single["layer_temperature_max"])
    assert single["layer_temperature_max"].max() > 550.0
    assert off.max() < 5.0
    assert spanned["layer_error"].max() < 2.0 * scene.friction.tolerance
