"""Friction by partner, coefficients that depend on speed and pressure, a largest shear stress (METHOD 3)."""

import dataclasses
from itertools import product

import numpy as np
import pytest
from pair_scenes import oblique_cubes
from scenes import simulate, state_of
from scipy.interpolate import RegularGridInterpolator
from test_resume import split

import tcontact as tc
from cases import block_on_block, sliding_block
from tcontact.planning.describe import memory
from tcontact.planning.lumped_mass import node_areas
from tcontact.scene.friction_laws import law_numbers

G = 9.81
FALLING = tc.Coulomb(static=0.4, kinetic=0.2, decay=2.0)
REMOVALS = ("normal", "full")
SLOWLY = ("normal", pytest.param("full", marks=pytest.mark.slow))


def mu(law, speed, pressure=0.0):
    """The coefficient by the definition of the law."""
    if isinstance(law, tc.FrictionTable):
        table = np.array(law.coefficients)
        by_speed = [np.interp(pressure, law.pressures, row) for row in table]
        return np.interp(speed, law.speeds, by_speed)
    if law.coefficient is not None:
        return law.coefficient
    return law.kinetic + (law.static - law.kinetic) * np.exp(-law.decay * speed)


def speed_after(start, deceleration, time, steps=4000):
    """The speed of a rigid block, dv/dt = -deceleration(v), by the midpoint rule until it stops."""
    speed, step = start, time / steps
    for _ in range(steps):
        speed -= step * deceleration(speed - 0.5 * step * deceleration(speed))
    return speed


def on_plane(law, scene_law=None, **parameters):
    """The block of the case sliding-block on a plane with its own law."""
    scene = sliding_block.scene(**({"cells": 2, "motion": "stop"} | parameters))
    duration = parameters.get("duration", scene.duration)
    return dataclasses.replace(scene, friction=scene_law, obstacles=[tc.Plane(friction=law)], duration=duration)


def test_coefficients_of_the_kernel_are_those_of_the_laws():
    """Tables of all sizes against scipy, between their entries and beyond them; laws beside each other."""
    import taichi as ti

    from tcontact.device import arrays
    from tcontact.kernels.contact.friction_laws import coefficient
    from tcontact.kernels.language.arguments import ARRAY

    @ti.kernel
    def evaluate(numbers: ARRAY, asked: ARRAY, out: ARRAY):
        for i in range(out.shape[0]):
            out[i] = coefficient(numbers, 5, int(asked[3 * i]), asked[3 * i + 1], asked[3 * i + 2])

    random = np.random.default_rng(1)
    laws = [tc.Coulomb(0.3), FALLING, tc.NoFriction(), tc.Coulomb(0.1, limit=1e5)]
    for rows, columns in product((1, 2, 5, 16), (1, 2, 7)):
        axes = [np.cumsum(random.uniform(0.1, 2.0, count)) for count in (rows, columns)]
        laws.append(tc.FrictionTable(*axes, random.uniform(0, 1, (rows, columns))))
    numbers = np.concatenate([np.full(5, np.nan), law_numbers(laws)])
    asked = np.column_stack([random.integers(0, len(laws), 4000), *random.uniform(0, 12, (2, 4000))])
    for law in laws:
        if isinstance(law, tc.FrictionTable):  # at the entries too
            at = np.array([(law.speeds[-1], law.pressures[0]), (law.speeds[0], law.pressures[-1]), (0.0, 0.0)])
            asked = np.concatenate([asked, np.column_stack([np.full(3, laws.index(law)), at])])
    found = arrays.zeros(len(asked))
    evaluate(arrays.put(numbers), arrays.put(asked), found)
    for number, law in enumerate(laws):
        mine = asked[:, 0] == number
        if isinstance(law, tc.FrictionTable):
            axes, table = [np.array(law.speeds), np.array(law.pressures)], np.array(law.coefficients)
            inside = np.column_stack([asked[mine, 1 + i].clip(axes[i][0], axes[i][-1]) for i in range(2)])
            for i in range(2):  # scipy wants two entries along each axis
                if len(axes[i]) == 1:
                    axes[i], table = np.append(axes[i], axes[i] + 1.0), np.repeat(table, 2, axis=i)
            wanted = RegularGridInterpolator(axes, table)(inside)
        else:
            wanted = np.array([mu(law, speed) for speed in asked[mine, 1]])
        assert np.abs(arrays.get(found)[mine] - wanted).max() <= 1e-13, law


TABLE = tc.FrictionTable((0.0, 0.5, 1.0), 0.0, (0.4, 0.2, 0.3))


@pytest.mark.parametrize("removal", REMOVALS)
@pytest.mark.parametrize("law", [tc.Coulomb(0.3), FALLING, TABLE], ids=["constant", "falling", "table"])
def test_a_sliding_block_slows_down_by_its_law(law, removal):
    """dv/dt = -g mu(v), in every row; the scene has another friction, or none."""
    for scene_law in (None, tc.Coulomb(0.7)):
        result = simulate(on_plane(law, scene_law, duration=0.2, removal=removal), cfl=0.9)
        assert result.ok
        _, speed = sliding_block.travel(result)
        for row in (len(speed) // 2, -1):
            wanted = speed_after(1.0, lambda v: G * mu(law, v), result.history["time"][row])
            assert speed[row] == pytest.approx(wanted, abs=3e-3), row
        assert result.history["energy_error"].max() <= 1e-4
        lost = 0.5 * 1500.0 * (1.0 - speed[-1] ** 2)
        assert result.history["friction_work"][-1] == pytest.approx(lost, rel=5e-3)


@pytest.mark.parametrize("contact", ["penalty", pytest.param("impulse", marks=pytest.mark.slow)])
def test_contact_nodes_with_mass_slow_down_by_the_law_too(contact):
    result = simulate(on_plane(FALLING, duration=0.1, contact=contact, penalty=3.0), cfl=0.5)
    wanted = speed_after(1.0, lambda v: G * mu(FALLING, v), result.time)
    assert sliding_block.travel(result)[1][-1] == pytest.approx(wanted, abs=3e-3)


@pytest.mark.parametrize("removal", SLOWLY)
def test_two_floors_stop_two_blocks_each_by_its_own_friction(removal):
    """Stop distances v^2 / (2 mu g), in one scene; a third block slides on without friction."""
    one = sliding_block.scene(cells=1, motion="stop", friction=0.5, removal=removal)
    bodies, floors = [], []
    laws = tc.Coulomb(0.5), tc.Coulomb(0.25), tc.NoFriction()
    for number, law in enumerate(laws):
        mesh = one.bodies[0].mesh.translated((0.0, 3.0 * number, 0.0))
        bodies.append(dataclasses.replace(one.bodies[0], mesh=mesh, name=f"block-{number}"))
        floors.append(tc.Box((0.0, 3.0 * number, -0.5), (20.0, 2.9, 1.0), friction=law))
    stop = 1.0 / (0.25 * G)
    scene = dataclasses.replace(one, bodies=bodies, obstacles=floors, friction=None, duration=1.2 * stop)
    assert scene.largest_friction == 0.5
    result = simulate(scene, cfl=0.9)
    count = bodies[0].mesh.node_count
    for number, coefficient in enumerate((0.5, 0.25, 0.0)):
        mine = slice(number * count, (number + 1) * count)
        moved = (result.position[mine] - bodies[number].mesh.nodes)[:, 0].mean()
        wanted = 0.5 / (coefficient * G) if coefficient else result.time
        assert moved == pytest.approx(wanted, rel=0.02), number


def test_a_law_holds_what_rests_and_does_not_stop_what_slides():
    """tan(15 degrees) = .268 lies between kinetic and static friction: no creep from rest, no stop from 1 m/s."""
    law = tc.Coulomb(static=0.37, kinetic=0.1, decay=5.0)
    rest = simulate(on_plane(law, motion="hold", angle=15.0), cfl=0.9)
    path, _ = sliding_block.travel(rest)
    assert np.ptp(path[len(path) // 2 :]) <= 1e-9
    force = rest.history["contact_force"][-1]
    assert -force[0] / force[2] == pytest.approx(np.tan(np.radians(15.0)), rel=1e-6)
    slides = on_plane(law, motion="hold", angle=15.0, damping=0.0, duration=0.15)
    body = dataclasses.replace(slides.bodies[0], velocity=(1.0, 0.0, 0.0))
    result = simulate(dataclasses.replace(slides, bodies=[body]), cfl=0.9)
    down, press = slides.gravity[0], -slides.gravity[2]
    wanted = speed_after(1.0, lambda v: press * mu(law, v) - down, result.time)
    assert wanted > 1.1
    assert sliding_block.travel(result)[1][-1] == pytest.approx(wanted, abs=3e-3)
    at_once = on_plane(tc.Coulomb(static=0.37, kinetic=0.1), motion="hold", angle=15.0, damping=0.0, duration=0.15)
    result = simulate(dataclasses.replace(at_once, bodies=[body]), cfl=0.9)
    wanted = 1.0 + (down - 0.1 * press) * result.time
    assert sliding_block.travel(result)[1][-1] == pytest.approx(wanted, abs=3e-3)


@pytest.mark.parametrize("removal", REMOVALS)
def test_static_friction_is_the_threshold_of_sliding(removal):
    """tan(20 degrees) = .36397: static friction .370 holds without creep, .358 does not, and slides with mu(v)."""
    held, slides = (
        simulate(on_plane(tc.Coulomb(static=static, kinetic=0.1, decay=5.0), motion="hold", removal=removal), cfl=0.9)
        for static in (0.370, 0.358)
    )
    path, _ = sliding_block.travel(held)
    assert np.ptp(path[len(path) // 2 :]) <= 1e-9
    path, speed = sliding_block.travel(slides)
    assert speed[-1] > 1e-5
    force, late = slides.history["contact_force"], slice(len(path) // 2, None)
    wanted = mu(slides.scene.obstacles[0].friction, speed)
    assert -force[late, 0] == pytest.approx(wanted[late] * force[late, 2], rel=1e-4)


@pytest.mark.parametrize("removal", REMOVALS)
def test_a_table_of_pressures_gives_the_friction_of_the_pressure(removal):
    """A thin plate: the force of every row is the sum of mu(v, p) p A of its nodes, with the pressures of the row.

    The static solve of full removal takes mu at the pressure of the row before.
    """
    pressure, law = 500.0, tc.LinearElastic(1e7, 0.0, 1000.0)
    table = tc.FrictionTable((0.0, 1.0), (0.0, pressure, 2.0 * pressure), ((0.5, 0.4, 0.3), (0.3, 0.15, 0.05)))

    def sag(x):
        return (0.05 * x[:, 2:] - x[:, 2:] ** 2 / 2.0) * (0.0, 0.0, -15.0 * 1000.0 / law.young)

    body = tc.Body(tc.box_mesh((1, 1, 0.05), (3, 3, 1)), law, (0.6, 0, 0), contact="zmin", displacement=sag)
    scene = tc.Scene([body], [tc.Plane(friction=table)], 0.05, (0, 0, -15.0), tc.MasslessContact(removal))
    result = simulate(scene, cfl=0.9, pressures=True)
    record, (_, speed) = result.contact_pressures[0], sliding_block.travel(result)
    pressures, nodes = np.asarray(record.pressure), np.asarray(record.nodes)
    areas = node_areas(body.mesh.nodes, body.contact_faces)[nodes]
    shares = np.zeros_like(pressures)
    for _ in range(3):  # the record holds the whole force on a node: p sqrt(1 + mu^2)
        pressing = pressures / np.sqrt(1.0 + shares**2)
        before = pressing if removal == "normal" else np.roll(pressing, 1, axis=0)
        shares = np.array([[mu(table, v, p) for p in row] for v, row in zip(speed, before, strict=True)])
    pressures, rows = pressing, slice(5, -1)
    wanted = (shares * pressures)[rows] @ areas
    found = -result.history["contact_force"][rows, 0]
    assert np.ptp(before[rows]) > 0.2 * pressure
    assert np.abs(found - wanted).max() <= 0.02 * wanted.max()
    assert found.sum() == pytest.approx(wanted.sum(), rel=5e-3)  # nodes do not all have the mean speed


@pytest.mark.parametrize("removal", REMOVALS)
def test_shear_stress_has_its_limit(removal):
    """Pressure of 9.81 kPa in the mean: shear force limit x area where every node slides at it, else mu x pressure."""
    area, pressure = 1.5, 1000.0 * G
    for limit, wanted in ((0.1 * pressure, 0.1), (100.0 * pressure, 0.3)):
        result = simulate(on_plane(tc.Coulomb(0.3, limit=limit), duration=0.1, removal=removal), cfl=0.9)
        force = result.history["contact_force"][:-1, 0]
        assert -force.min() <= limit * area * (1.0 + 1e-9)
        slowed = (1.0 - sliding_block.travel(result)[1][-1]) / result.time
        assert slowed == pytest.approx(wanted * G, rel=5e-3)


def cornered(contact, floor, wall, obstacles=(), **options):
    """A block that gravity presses on a floor and on a wall, along which it slides."""
    law = tc.LinearElastic(1e8, 0.3, 1000.0)
    body = tc.Body(tc.box_mesh((1.5, 1.0, 1.0), (3, 2, 2)), law, (1.0, 0.0, 0.0), contact=("zmin", "ymin"))
    walls = [tc.Plane(friction=floor), tc.Plane(normal=(0, 1, 0), friction=wall), *obstacles]
    return tc.Scene([body], walls, 0.05, (0.0, -6.0, -G), contact, **options)


@pytest.mark.parametrize("removal", REMOVALS)
def test_every_obstacle_at_a_node_has_its_own_friction(removal):
    """m dv/dt = -mu1 N1 - mu2 N2 on floor and wall, the edge on both; distant obstacles change not a bit."""
    contact = tc.MasslessContact(removal)
    far = [tc.Plane((0.0, 0.0, 9.0 + number), (0, 0, -1), friction=tc.Coulomb(0.9)) for number in range(3)]
    none, laws = tc.NoFriction(), (tc.Coulomb(0.2), tc.Coulomb(0.4))
    cases = (
        (*laws, None, (0.2, 0.4)), (None, none, laws[0], (0.2, 0.0)), (none, None, laws[0], (0.0, 0.2))
    )  # fmt: skip
    for floor, wall, friction, wanted in cases:
        result = simulate(cornered(contact, floor, wall, friction=friction), cfl=0.9)
        for number, (axis, coefficient) in enumerate(zip((2, 1), wanted, strict=True)):
            force = result.obstacle_force[f"obstacle-{number}"][:-1].sum(axis=0)
            assert -force[0] / force[axis] == pytest.approx(coefficient, rel=1e-3, abs=1e-9)
    if removal == "normal":
        return
    alone = simulate(cornered(contact, *laws), cfl=0.9)
    beside = simulate(cornered(contact, *laws, far), cfl=0.9)
    assert np.abs(beside.position - alone.position).max() <= 1e-12
    assert beside.history["friction_work"] == pytest.approx(alone.history["friction_work"], rel=1e-9)


@pytest.mark.parametrize("removal", REMOVALS)
def test_pairs_and_obstacles_have_their_own_laws(removal):
    """A block on a free block: dw/dt = -g (1 + m1/m2) mu(w), on a floor without friction; momentum stays."""
    scene = block_on_block.scene(cells=2, lower_cells=3, removal=removal)
    law, floor = (
        tc.Coulomb(static=0.5, kinetic=0.2, decay=3.0),
        tc.Plane(scene.obstacles[0].point, friction=tc.NoFriction()),
    )
    pairs = [dataclasses.replace(scene.pairs[0], friction=law)]
    options = {"pairs": pairs, "friction": None, "duration": 0.3 * scene.duration}
    result = simulate(dataclasses.replace(scene, obstacles=[floor], **options), cfl=0.9)
    upper, lower = block_on_block.motion(result)
    wanted = speed_after(1.0, lambda w: 1.5 * G * mu(law, w), result.time)
    assert upper[-1] - lower[-1] == pytest.approx(wanted, abs=3e-3)
    momentum = result.history["momentum"][:, :2]
    assert np.abs(momentum - momentum[0]).max() <= 1e-11 * np.abs(momentum[0]).max()
    assert result.history["energy_error"].max() <= 1e-4
    # the pair rubs by its law, the floor by a constant coefficient
    rough = dataclasses.replace(floor, friction=tc.Coulomb(0.05))
    result = simulate(dataclasses.replace(scene, obstacles=[rough], **options), cfl=0.9)
    pair, force = result.pair_force["upper-lower"][5:], result.history["contact_force"][5:]
    assert np.linalg.norm(force[:, :2].sum(axis=0)) / force[:, 2].sum() == pytest.approx(0.05, rel=0.02)
    share = np.linalg.norm(pair[:, :2].sum(axis=0)) / pair[:, 2].sum()
    upper, lower = block_on_block.motion(result)  # of the upper block; the lower one has what the floor left
    assert upper[-1] < 0.9
    assert mu(law, 1.0) < share < mu(law, upper[-1])


@pytest.mark.parametrize("removal", SLOWLY)
def test_large_bodies_slow_down_by_the_law(removal):
    """The parallel force pass, with and without obstacles of which only the nearest have rows."""
    scene = on_plane(FALLING, cells=14, duration=4e-3, removal=removal)
    assert not tc.plan(scene).domains[0].small
    result = simulate(scene, cfl=0.9)
    scene = dataclasses.replace(scene, obstacles=[*scene.obstacles, *(
        tc.Plane((0.0, 0.0, 9.0 + number), (0, 0, -1), friction=tc.Coulomb(0.9)) for number in range(3))])  # fmt: skip
    for found in (result, simulate(scene, cfl=0.9)):
        force = found.history["contact_force"][30:-1]
        assert -force[:, 0].sum() / force[:, 2].sum() == pytest.approx(mu(FALLING, 0.998), rel=2e-3)


@pytest.mark.parametrize("removal", SLOWLY)
def test_a_belt_that_speeds_up_takes_a_block_along_below_static_friction(removal):
    """Its acceleration rises to .27 g and falls to 0 again, below and above static friction."""
    time, peak = 0.1, 0.27 * G

    def belt(t):
        return np.array([peak * (0.5 * t - time * np.sin(2.0 * np.pi * t / time) / (4.0 * np.pi)), 0.0, 0.0])

    for static, holds in ((0.3, True), (0.2, False)):
        law = tc.Coulomb(static=static, kinetic=0.05, decay=50.0)
        scene = on_plane(law, motion="hold", angle=0.0, damping=0.0, viscosity=0.5, removal=removal, duration=time)
        result = simulate(dataclasses.replace(scene, obstacles=[tc.Plane(velocity=belt, friction=law)]), cfl=0.9)
        share = sliding_block.travel(result)[1][-1] / belt(result.time)[0]
        assert share == pytest.approx(1.0, abs=5e-3) if holds else share < 0.9


@pytest.mark.parametrize("removal", REMOVALS)
def test_a_resumed_run_with_laws_has_the_same_bits(tmp_path, monkeypatch, removal):
    scene = on_plane(FALLING, duration=6e-3, removal=removal)
    split(monkeypatch, tmp_path, scene, 2, tc.CentralDifference(), 3)


def test_a_resumed_run_of_a_pair_with_a_law_has_the_same_bits(tmp_path, monkeypatch):
    scene = block_on_block.scene(cells=2, lower_cells=3, removal="full")
    pairs = [dataclasses.replace(scene.pairs[0], friction=FALLING)]
    scene = dataclasses.replace(scene, pairs=pairs, friction=None, duration=0.02 * scene.duration)
    split(monkeypatch, tmp_path, scene, 2, tc.CentralDifference(), 3)


@pytest.mark.slow
def test_a_layer_on_one_obstacle_and_nothing_on_the_other():
    """Friction layers differ in their coefficient only, and not at all where there is no friction."""
    layer = tc.FrictionLayer(coefficient=0.2)
    contact = tc.MasslessContact("normal")
    for floor, wall, wanted in ((None, tc.NoFriction(), 0.2 * G), (tc.NoFriction(), None, 0.2 * 6.0)):
        result = simulate(cornered(contact, floor, wall, friction=layer), cfl=0.9)
        momentum = result.history["momentum"][:, 0]
        assert (momentum[0] - momentum[-1]) / 1500.0 / result.time == pytest.approx(wanted, rel=0.03)
        heat = sum(result.history[name][-1] for name in ("layer_heat", "obstacle_heat") if name in result.history)
        assert heat == pytest.approx(result.history["friction_work"][-1], rel=1e-3)


@pytest.mark.parametrize("law", [tc.Coulomb(0.3), FALLING], ids=["constant", "falling"])
@pytest.mark.parametrize("removal", REMOVALS)
def test_only_what_varies_is_built(law, removal):
    """A constant coefficient costs not a number; the plan counts the bytes of a law that varies."""
    scene = on_plane(law, duration=1e-4, removal=removal)
    plain = dataclasses.replace(scene, obstacles=[tc.Plane()], friction=tc.Coulomb(0.3))
    planned = tc.plan(scene)
    state, same = (state_of(one, tc.plan(one).bodies[0]) for one in (scene, plain))
    varied = law != tc.Coulomb(0.3)
    assert state.contact.options.varied is varied
    assert (state.contact.options == same.contact.options) is not varied
    assert len(state.contact.arguments()) == len(same.contact.arguments())
    assert state.contact.friction.data.shape == same.contact.friction.data.shape or varied
    assert state.contact.rows.values.shape == same.contact.rows.values.shape or varied
    assert ("its coefficients" in planned.describe()) is varied
    taken, foreseen = simulate(scene).memory, memory(planned, planned.domains[0])
    assert foreseen["coulomb-friction"] == taken["coulomb-friction"]
    if varied:
        without = tc.plan(plain)
        less = memory(without, without.domains[0])["massless-contact"] - simulate(plain).memory["massless-contact"]
        assert foreseen["massless-contact"] - taken["massless-contact"] == less


def test_a_scene_has_the_friction_of_its_partners():
    """Scene.friction is a law without friction of their kind; the largest coefficient of all laws counts."""
    block = sliding_block.scene(cells=1)

    def scene(*laws, friction=None):
        return dataclasses.replace(block, obstacles=[tc.Plane(friction=law) for law in laws], friction=friction)

    assert scene(tc.NoFriction()).friction is None
    assert scene(None, friction=tc.NoFriction()).friction is None
    assert "friction" not in tc.plan(scene(tc.NoFriction())).describe()
    assert scene(None, FALLING).friction == tc.Coulomb(0.0)
    assert scene(None, FALLING).largest_friction == 0.4
    assert scene(TABLE, tc.NoFriction()).largest_friction == 0.4
    assert scene(None, tc.NoFriction(), friction=tc.Coulomb(0.7)).largest_friction == 0.7
    assert scene(FALLING, friction=tc.Coulomb(0.7)).largest_friction == 0.4
    assert scene(tc.RegularizedCoulomb(0.3, 0.1)).friction == tc.RegularizedCoulomb(0.0, 0.1)
    assert scene(tc.FrictionLayer()).friction == tc.FrictionLayer(coefficient=0.0)
    viscous = [tc.plan(scene(law)).bodies[0].viscous_cells for law in (None, tc.NoFriction(), tc.Coulomb(0.0), FALLING)]
    assert viscous == [False, False, False, True]


REFUSED = {
    "nothing": (lambda: tc.Coulomb(), "Coulomb.coefficient"),
    "both": (lambda: tc.Coulomb(0.3, static=0.4), "Coulomb.static"),
    "half": (lambda: tc.Coulomb(static=0.4, decay=1.0), "Coulomb.kinetic"),
    "zero decay": (lambda: tc.Coulomb(static=0.4, kinetic=0.3, decay=0.0), "Coulomb.decay"),
    "negative": (lambda: tc.Coulomb(static=-0.4, kinetic=0.3, decay=1.0), "Coulomb.static"),
    "limit": (lambda: tc.Coulomb(0.3, limit=0.0), "Coulomb.limit"),
    "order": (lambda: tc.FrictionTable([1.0, 0.5], [0.0], [[0.1], [0.2]]), "FrictionTable.speeds"),
    "shape": (lambda: tc.FrictionTable([0.0, 0.5], [0.0, 1.0], [[0.1], [0.2]]), "FrictionTable.coefficients"),
    "sign": (lambda: tc.FrictionTable([0.0, 0.5], [0.0], [-0.1, 0.2]), "FrictionTable.coefficients"),
    "empty": (lambda: tc.FrictionTable([], [0.0], []), "FrictionTable.speeds"),
    "number": (lambda: tc.Plane(friction=0.3), "Plane.friction"),
    "families": (lambda: partners(FALLING, tc.RegularizedCoulomb(0.3, 0.1)), "Plane.friction"),
    "speeds": (lambda: partners(tc.RegularizedCoulomb(0.3, 0.2), tc.RegularizedCoulomb(0.3, 0.1)), "Plane.friction"),
    "layer": (lambda: partners(FALLING, friction=tc.FrictionLayer()), "Plane.friction"),
    "pair": (
        lambda: oblique_cubes(pairs=[tc.Pair("up", "low", tc.RegularizedCoulomb(0.1, 1.0))], friction=FALLING),
        "Pair.friction",
    ),
}


def partners(*laws, **options):
    """A block with planes of several laws."""
    scene = sliding_block.scene(cells=1)
    planes = [tc.Plane(friction=law) for law in laws]
    return dataclasses.replace(scene, obstacles=planes, **({"friction": None} | options))


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_is_refused_by_name(name):
    build, field = REFUSED[name]
    with pytest.raises(tc.InputError) as caught:
        build()
    assert caught.value.field == field


def test_implicit_schemes_refuse_the_friction_of_an_obstacle():
    scene = dataclasses.replace(partners(FALLING), duration=1e-3)
    with pytest.raises(tc.InputError, match=r"Scene.obstacles\[0\].friction"):
        tc.simulate(scene, tc.DiscreteGradient(dt=1e-4))


def test_large_coefficients_of_any_law_are_warned_of():
    steep = tc.Coulomb(static=1.2, kinetic=0.1, decay=9.0)
    with pytest.warns(RuntimeWarning, match=r"coefficient of 1\.2 with full removal"):
        simulate(on_plane(steep, removal="full", duration=1e-4))


def test_scene_files_keep_tables_of_pairs(tmp_path):
    pairs = [tc.Pair("up", "low", friction=tc.FrictionTable((0.0, 1.0), (0.0, 5.0), ((0.4, 0.3), (0.2, 0.1))))]
    tc.save_scene(oblique_cubes(pairs=pairs), tmp_path / "scene.toml")
    assert tc.load_scene(tmp_path / "scene.toml")[0].pairs == tuple(pairs)
