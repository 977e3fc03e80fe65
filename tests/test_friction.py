"""Coulomb friction: the problem of a node, every row against the oracle, exact stick, belts, the ledger (METHOD 3)."""

import dataclasses
from itertools import pairwise

import numpy as np
import oracle
import pytest
from scenes import bar_speed, material, python, simulate, state_of, thrown, twin, twin_planes
from scipy.optimize import brentq
from test_central_difference import COLUMNS, contact_models, there_position

import tcontact as tc
from tcontact.cases import pressure_shear, sliding_block
from tcontact.results import checks as ck

MU = 0.35


def resisting(law, mobilities, slips, most, scale):
    """Friction [m, 2] of many nodes by the kernel."""
    import taichi as ti

    from tcontact.device import arrays
    from tcontact.kernels.contact.friction import friction_force
    from tcontact.kernels.language.arguments import ARRAY

    @ti.kernel
    def evaluate(w: ARRAY, s: ARRAY, c: ARRAY, e: float, out: ARRAY):
        for i in range(c.shape[0]):
            mobility = ti.Matrix([[w[4 * i], w[4 * i + 1]], [w[4 * i + 2], w[4 * i + 3]]])
            force = friction_force(law, mobility, ti.Vector([s[2 * i], s[2 * i + 1]]), c[i], e)
            out[2 * i], out[2 * i + 1] = force[0], force[1]

    found = arrays.zeros(2 * len(most))
    evaluate(arrays.put(mobilities), arrays.put(slips), arrays.put(most), scale, found)
    return arrays.get(found).reshape(-1, 2).copy()


def random_nodes(count=300, seed=3):
    """Mobilities from well to badly conditioned, slips and limits over many orders of magnitude."""
    random = np.random.default_rng(seed)
    turns = random.uniform(0, np.pi, count)
    axes = np.array([[np.cos(turns), -np.sin(turns)], [np.sin(turns), np.cos(turns)]]).transpose(2, 0, 1)
    sizes = 10.0 ** np.stack([random.uniform(-2, 2, count), random.uniform(-2, 2, count)], axis=1)
    mobilities = np.einsum("mij,mj,mkj->mik", axes, sizes, axes)
    slips = random.normal(size=(count, 2)) * 10.0 ** random.uniform(-6, 3, (count, 1))
    stopping = np.linalg.norm(np.linalg.solve(mobilities, slips[..., None])[..., 0], axis=1)
    return mobilities, slips, stopping * 10.0 ** random.uniform(-3, 0.5, count)


def least(mobility, slip, most):
    """min 1/2 t.W t + s*.t over |t| <= c in the axes of W."""
    sizes, axes = np.linalg.eigh(mobility)
    there = axes.T @ slip
    if np.linalg.norm(there / sizes) <= most:
        return -axes @ (there / sizes)
    top = np.linalg.norm(slip) / most
    shift = brentq(lambda a: np.linalg.norm(there / (sizes + a)) / most - 1, 0, top, xtol=1e-300, rtol=1e-15)
    return -axes @ (there / (sizes + shift))


def test_force_of_a_node_is_the_minimiser_of_the_tresca_problem():
    mobilities, slips, most = random_nodes()
    found = resisting("coulomb", mobilities, slips, most, 1.0)
    wanted = np.array([least(*node) for node in zip(mobilities, slips, most, strict=True)])
    assert np.abs(found - wanted).max(axis=1) == pytest.approx(0.0, abs=1e-9 * most.max())
    assert (np.abs(found - wanted).max(axis=1) <= 1e-9 * most).all()
    sizes = np.linalg.norm(found, axis=1)
    assert (sizes <= most * (1 + 1e-13)).all()
    assert 30 < np.sum(sizes < 0.999 * most) < 200  # some stick, some slide
    turns = np.linspace(0, 2 * np.pi, 181)
    circle = np.stack([np.cos(turns), np.sin(turns)], axis=1)

    for i in range(0, len(most), 7):  # and brute force: no force on a grid of the disk is better
        grid = (most[i] * np.linspace(0, 1, 40))[:, None, None] * circle
        values = 0.5 * np.einsum("abi,ij,abj->ab", grid, mobilities[i], grid) + grid @ slips[i]
        own = 0.5 * found[i] @ mobilities[i] @ found[i] + slips[i] @ found[i]
        assert own <= values.min() + 1e-12 * np.abs(values).max()


def test_no_pressure_no_force_and_no_mobility_no_loss():
    mobilities, slips = np.zeros((3, 2, 2)), np.array([[1.0, 2.0], [3e-9, 0.0], [0.0, 0.0]])
    assert not resisting("coulomb", mobilities, slips, np.zeros(3), 1.0).any()
    mobilities[:, 0, 0] = 2.0  # a support holds the other direction
    found = resisting("coulomb", mobilities, np.array([[1.0, 0.0], [1e-9, 0.0], [8.0, 0.0]]), np.ones(3), 1.0)
    assert found == pytest.approx(np.array([[-0.5, 0], [-5e-10, 0], [-1.0, 0]]), rel=1e-12)


def resisting_in_lanes(mobilities, slips, most, start):
    """Coulomb friction [m, 2] of many nodes by the kernel of the sweeps, several at once."""
    import taichi as ti

    from tcontact.device import arrays
    from tcontact.kernels.lanes import SWEEP_LANES as LANES
    from tcontact.kernels.language.arguments import ARRAY
    from tcontact.kernels.language.compile_options import KEEP_VECTORS, compiled_with
    from tcontact.kernels.language.vectors import load, store
    from tcontact.kernels.static.friction_lanes import coulomb_lanes

    count = -(-len(most) // LANES) * LANES

    @ti.kernel
    def evaluate(data: ARRAY, out: ARRAY):
        ti.loop_config(serialize=True)
        for pack in range(count // LANES):
            part = [load(data, i * count + pack * LANES, LANES) for i in range(7)]
            found = coulomb_lanes(part[0:3], part[3:5], part[5], part[6], part[5] >= 0.0)
            store(out, pack * LANES, found[0], LANES)
            store(out, count + pack * LANES, found[1], LANES)

    rows = [mobilities[:, 0, 0], mobilities[:, 0, 1], mobilities[:, 1, 1], *slips.T, most, start]
    data = np.array([np.concatenate([row, np.zeros(count - len(most))]) for row in rows])
    found = arrays.zeros(2 * count)
    compiled_with(evaluate, **KEEP_VECTORS)(arrays.put(data), found)
    return arrays.get(found).reshape(2, count)[:, : len(most)].T.copy()


def test_force_in_lanes_is_that_of_single_nodes_wherever_the_search_starts():
    mobilities, slips, most = random_nodes()
    most[::20] = 0.0
    mobilities[5::40, 1] = mobilities[5::40, :, 1] = 0.0  # a support holds the other direction
    wanted = resisting("coulomb", mobilities, slips, most, 1.0)
    for start in (0.0, 0.3):
        guess = start * np.linalg.norm(slips, axis=1) / np.maximum(most, 1e-300)
        found = resisting_in_lanes(mobilities, slips, most, guess)
        assert (np.abs(found - wanted).max(axis=1) <= 1e-9 * most).all()


def test_regularised_force_is_against_the_slip_and_as_large_as_its_law_says():
    mobilities, slips, most = random_nodes()
    scale = 0.02
    found = resisting("regularized", mobilities, slips, most, scale)
    left = slips + np.einsum("mij,mj->mi", mobilities, found)
    z = np.minimum(1, np.linalg.norm(left, axis=1) / scale)
    for i in range(len(most)):
        size, speed = np.linalg.norm(found[i]), np.linalg.norm(left[i])
        assert size == pytest.approx(most[i] * z[i] * (2 - z[i]), rel=1e-6, abs=1e-9 * most[i])
        if speed > 1e-9 * np.linalg.norm(slips[i]):
            assert found[i] @ left[i] == pytest.approx(-size * speed, rel=1e-6)


TWINS = {  # law, walls, contact, penalty in E/h, do the walls move
    "normal removal, moving wall": ("linear", 1, "normal", None, True),
    "full removal, moving wall": ("linear", 1, "full", None, True),
    "full removal, corner": ("linear", 2, "full", None, False),
    "penalty, corner": ("linear", 2, "penalty", 3.0, False),
    "impulse": ("linear", 1, "impulse", None, False),
}


def rubbing(name, duration=2.0):
    """A block thrown at walls with friction, and the oracle's contact model."""
    law, walls, contact, penalty, moving = TWINS[name]
    mine, theirs = contact_models(contact, penalty and penalty * material().young / 0.06)
    scene = thrown(law, "hex8", walls=walls, contact=mine, duration=duration)
    obstacles = scene.obstacles
    if moving:
        speed = np.linalg.norm(scene.bodies[0].velocity)
        drift = speed * np.array([0.3, -0.5, 0.1])
        obstacles = [dataclasses.replace(wall, velocity=tuple(drift)) for wall in obstacles]
    return dataclasses.replace(scene, obstacles=obstacles, friction=tc.Coulomb(MU)), theirs


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] if name == "full removal, corner" else []) for name in TWINS]
)
def test_every_row_equals_the_oracle(name):
    scene, theirs = rubbing(name)
    result = simulate(scene, cfl=0.25 if name.startswith("penalty") else 0.8)
    body = scene.bodies[0]
    planes = [
        oracle.Plane(plane.point, plane.normal, tuple(np.zeros(3) if wall.velocity is None else wall.velocity))
        for plane, wall in zip(twin_planes(scene), scene.obstacles, strict=True)
    ]
    there = oracle.run(
        twin(body), planes, body.initial_velocity, steps=result.steps, dt=result.dt, contact=theirs,
        gravity=np.asarray(scene.gravity), friction=MU, viscosity=0.2 if name.startswith("normal") else None,
    )  # fmt: skip
    assert there.friction_work[-1] > 0.01 * there.kinetic[0]
    assert (there.viscous_work[-1] > 0.0) == ("viscous_work" in result.history) == name.startswith("normal")
    for column in (*COLUMNS, "friction_work", *(["viscous_work"] if there.viscous_work[-1] > 0.0 else [])):
        if name == "full removal, corner" and column in ("friction_work", "contact"):
            continue  # two walls may share the force on a node in more than one way; only the sum is unique
        # the last kick of a run is half a kick, and what stops a node in it another force
        wanted, found = getattr(there, column)[:-1], result.history[column][:-1]
        scale = np.abs(wanted).max() or 1.0
        if column in ("contact", "external_work", "support_force"):
            scale = max(np.abs(there.kinetic).max() if column != "support_force" else 0.0, scale)
        assert np.abs(found - wanted).max() <= 1e-7 * scale, column
    assert np.abs(result.position - there_position(body, there)).max() <= 1e-8 * 0.2


@pytest.mark.parametrize("removal", ["normal", "full"])
def test_pressure_shear_slab_meets_its_checks_in_both_regimes(removal):
    for name, scene in pressure_shear.comparison(cells=80, removal=removal).items():
        result = simulate(scene, cfl=0.9)
        found = pressure_shear.checks(result)
        assert any(check.name.startswith("friction work" if name == "slip" else "lost") for check in found)
        assert not [check for check in found if not check.passed]


@pytest.mark.parametrize("removal", ["normal", "full"])
def test_what_a_sticking_impact_loses_falls_with_the_cells(removal):
    """The mass of the layer that is stopped at once. Started in touch: else the share of the step before it matters."""
    lost = []
    for cells in (40, 80, 160):
        result = simulate(pressure_shear.scene(cells=cells, friction=1.0, gap=0.0, removal=removal), cfl=0.9)
        lost.append(result.history["friction_work"][-1] / result.history["kinetic"][0])
    assert lost[1] <= 2e-2
    assert all(1.7 <= coarse / fine <= 2.5 for coarse, fine in pairwise(lost)), lost


def test_a_sliding_column_rubs_by_the_coefficient_and_the_ledger_closes():
    result = simulate(pressure_shear.scene(cells=40), cfl=0.2)
    impulse = result.history["impulse"][-1]
    assert -impulse[0] / impulse[2] == pytest.approx(0.2, rel=1e-3)
    assert result.history["energy_error"].max() <= 4e-3


def test_a_block_that_slides_rubs_by_the_coefficient():
    scene = sliding_block.scene(motion="slide", speed=2.0)
    result = simulate(scene, cfl=0.9)
    impulse = result.history["impulse"][-1]
    assert -impulse[0] / impulse[2] == pytest.approx(0.2, rel=1e-3)


@pytest.mark.parametrize(
    "parameters",
    [{"motion": "stop"}, {"motion": "slide"}, {"motion": "slide", "friction": 0.1}, {"motion": "hold"}],
    ids=str,
)
def test_sliding_block_meets_its_checks(parameters):
    result = simulate(sliding_block.scene(**parameters), cfl=0.9)
    found = sliding_block.checks(result)
    assert len(found) >= 7
    assert not [check for check in found if not check.passed]


@pytest.mark.parametrize(
    "parameters",
    [{"motion": "hold", "friction": 0.36}, {"motion": "slide", "friction": 0.37}, {"motion": "stop", "angle": 17.0}],
    ids=str,
)
def test_sliding_block_refuses_a_motion_that_its_friction_does_not_give(parameters):
    with pytest.raises(tc.InputError, match=r"friction = .*tan\(angle\)"):
        sliding_block.scene(**parameters)


def held(steps, removal="normal", slip_speed=None):
    """Largest motion of any node over `steps` steps after the block has settled on the incline, over its length."""
    scene = sliding_block.scene(motion="hold", removal=removal, slip_speed=slip_speed)
    settled = simulate(scene, cfl=0.9)
    scene = dataclasses.replace(scene, duration=steps * settled.dt)
    result = simulate(scene, dt=settled.dt, initial=settled, history_every=max(1, steps // 100))
    assert steps <= result.steps <= steps + 1
    return np.abs(result.position - settled.position).max() / 1.5


def test_what_sticks_does_not_creep_and_the_regularised_law_does():
    """mu .37 on 20 degrees, tan 20 = .364, E = 1e5 rho g H."""
    assert held(5000) <= 1e-9
    assert held(1000, slip_speed=1e-3) > 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("removal", ["normal", "full"])
def test_what_sticks_does_not_creep_in_1e5_steps(removal):
    assert held(100_000, removal) <= 1e-9


@pytest.mark.parametrize("removal", ["normal", "full"])
def test_a_belt_takes_a_block_to_its_speed(removal):
    """Momentum, force and power of the belt: what it does is friction's work and the energy of the block."""
    block = sliding_block.scene(motion="hold", angle=0.0, friction=0.5, damping=0.0, removal=removal, duration=0.08)
    belt = tc.Plane(velocity=(0.12, 0.09, 0.0), name="belt")
    result = simulate(dataclasses.replace(block, obstacles=[belt]), cfl=0.4)
    history, mass = result.history, ck.mass(result)
    speed, speed_across = history["momentum"][:, 0] / mass, history["momentum"][:, 1] / mass
    time = 0.15 / (0.5 * 9.81)
    assert np.interp(0.5 * time, history["time"], speed) == pytest.approx(0.06, rel=0.05)
    late = history["time"] > 1.3 * time
    assert speed[late].mean() == pytest.approx(0.12, rel=0.02)
    assert speed_across[late].mean() == pytest.approx(0.09, rel=0.02)
    assert np.abs(result.obstacle_force["belt"] + history["contact_force"]).max() <= 1e-9 * mass * 9.81
    power = history["contact_force"] @ (0.12, 0.09, 0.0)
    driven = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(history["time"]))])
    weight = np.abs(history["external_work"] - driven).max()
    assert weight <= 0.01 * driven[-1]  # the rest is gravity
    assert driven[-1] == pytest.approx(mass * 0.15**2, rel=0.03)  # half of it heat
    assert history["friction_work"][-1] == pytest.approx(0.5 * mass * 0.15**2, rel=0.05)
    assert history["energy_error"].max() <= 4e-3


@pytest.mark.parametrize("removal", ["normal", "full"])
def test_a_turntable_turns_a_block(removal):
    """It slides everywhere: the torque is mu times the weight times the mean distance from the axis."""
    side, spin, mu = 1.0, 3.0, 0.2
    block = sliding_block.scene(motion="hold", angle=0.0, friction=mu, damping=0.0, removal=removal, duration=0.02)
    body = block.bodies[0]
    centre = body.mesh.nodes.mean(axis=0) * (1.0, 1.0, 0.0)
    table = tc.Plane(point=centre, angular_velocity=(0.0, 0.0, spin), name="table")
    result = simulate(dataclasses.replace(block, obstacles=[table]), cfl=0.4)
    history, weight = result.history, ck.mass(result) * 9.81
    x, y = (np.linspace(-0.5, 0.5, 2001)[:-1] + 0.5 / 2000) * np.array([[1.5 * side], [side]])
    mean = np.hypot(x[:, None], y[None, :]).mean()
    about = history["angular_momentum"] - np.cross(centre, history["momentum"])
    assert about[-1, 2] == pytest.approx(mu * weight * mean * result.time, rel=0.05)
    given = -np.sum(result.obstacle_moment["table"][1:, 2] * np.diff(history["time"]))
    assert given == pytest.approx(about[-1, 2], rel=0.02)
    slid = history["friction_work"][-1]
    assert slid == pytest.approx(spin * about[-1, 2] - history["kinetic"][-1], rel=0.05)
    assert history["energy_error"].max() <= 4e-3


@pytest.mark.parametrize("name", ["normal removal, moving wall", "full removal, moving wall"])
def test_the_ledger_closes_and_friction_never_gains(name):
    """An oblique impact on a wall that moves, of friction alone (test_cell_viscosity has the ledger of both)."""
    scene, _ = rubbing(name)
    contact = dataclasses.replace(scene.contact, cell_viscosity=0.0)
    scene = dataclasses.replace(scene, gravity=None, contact=contact)
    errors = []
    for cfl in (0.4, 0.2):
        result = simulate(scene, cfl=cfl)
        errors.append(result.history["energy_error"].max())
        work = result.history["friction_work"]
        assert np.diff(work).min() >= -1e-9 * work[-1]
    assert errors[1] <= 0.5 * errors[0]
    assert errors[1] <= 4e-3


def test_the_ledger_of_a_block_that_slides_over_a_turntable_closes_with_the_square_of_the_step():
    """A slip with the arm of one end of the step is wrong in proportion to the step."""
    scene, _ = rubbing("full removal, moving wall", duration=1.0)
    body, wall = scene.bodies[0], scene.obstacles[0]
    normal, nodes, speed = np.asarray(wall.normal), body.mesh.nodes, 0.3 * bar_speed(body.material)
    middle = nodes.mean(axis=0)
    foot = middle + normal * ((nodes - middle) @ normal).min()
    across = np.cross(normal, (1.0, 0.0, 0.0))
    body = dataclasses.replace(body, velocity=speed * across / np.linalg.norm(across))
    table = tc.Plane(foot, normal, angular_velocity=speed / 0.06 * normal)
    scene = dataclasses.replace(scene, bodies=[body], obstacles=[table], gravity=-(speed**2) * normal)
    errors = [simulate(scene, cfl=cfl).history["energy_error"].max() for cfl in (0.4, 0.2)]
    assert errors[0] <= 2e-4
    assert errors[1] <= 0.3 * errors[0]


def test_friction_is_a_term_only_where_there_is_friction():
    """No array, no launch, no kernel file of the kick without it."""
    with_it = sliding_block.scene(motion="slide", duration=1e-3)
    without = dataclasses.replace(with_it, friction=None)
    for scene, there in ((with_it, True), (without, False)):
        planned = tc.plan(scene)
        assert ("coulomb-friction" in planned.terms) is there
        state = state_of(scene, planned.bodies[0])
        assert (state.contact.friction is not None) is there
        assert any("friction" in name for name in simulate(scene).memory) is there


def test_frictionless_scenes_import_and_make_no_friction_kernels():
    code = "import scenes, sys, tcontact as tc; "
    code += "scene = scenes.thrown('linear', contact=tc.PenaltyContact(1e9)); assert tc.simulate(scene, threads=1).ok; "
    code += "modules = [m for m in sys.modules if not m.endswith('layer_places')]; "  # a table of places
    code += "print([m for m in modules if 'kick_friction' in m or 'layer' in m and 'kernels' in m])"
    done = python(code)
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize("friction", ["coulomb", "layer"])
def test_a_compressed_slab_in_uniform_motion_rubs_from_the_first_step_on(friction):
    """Forces in balance to the last bit are no solution while a pressed node slips without its friction."""
    law = tc.NeoHookean(1e6, 0.3, 1000.0) if friction == "coulomb" else tc.NeoHookean(70e9, 0.3, 2700.0)
    slab = tc.Body(
        tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2)),
        law,
        velocity=(1.0, 0.0, 0.0) if friction == "coulomb" else (20.0, 0.0, 0.0),
        contact="zmin",
        periodic="xy",
        displacement=lambda x: x * [0.0, 0.0, -0.02],
        supports=[tc.Support("zmax", "z")],
    )
    model = tc.Coulomb(0.05) if friction == "coulomb" else tc.FrictionLayer(points=8)
    contact = tc.MasslessContact(removal="full")
    duration = 10.0 * 0.02 / law.wave_speed
    history = simulate(tc.Scene([slab], [tc.Plane()], duration, contact=contact, friction=model)).history
    force, rows = history["contact_force"], slice(1, None)
    assert len(force) >= 4
    assert (force[rows, 0] < 0.0).all()
    assert (history["sweeps"][rows] > 0).all()
    if friction == "coulomb":
        assert force[rows, 0] == pytest.approx(-0.05 * force[rows, 2], rel=1e-6)
    assert np.abs(force[:, 1]).max() <= 1e-9 * np.abs(force[:, 2]).max()
