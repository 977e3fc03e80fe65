"""Obstacles that move freely: exact laws of impact, the ledger, free flight, the stable step, restart, files."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scenes import python, simulate

import tcontact as tc
from tcontact.cases import striker
from tcontact.results import checks as ck
from tcontact.run.checkpoint.fingerprint import fingerprint

SIZE = (0.1, 0.1, 0.05)


def hit(mass=0.5, cells=(4, 4, 4), turn=None, speed=1.0, box=None, duration=4e-3, tolerance=None, law=tc.LinearElastic,
        poisson=0.3, **options):  # fmt: skip
    """A free block of rubber is hit from above by a rigid box (or `box`) of its own mass; all is turned by `turn`."""
    turn = np.eye(3) if turn is None else turn
    mesh = tc.box_mesh(SIZE, cells)
    mesh = tc.Mesh(mesh.nodes @ turn.T, mesh.cells, "hex8", face_sets=mesh.face_sets)
    body = tc.Body(mesh, law(young=1e6, poisson=poisson, density=1000.0), contact="zmax", **options.pop("body", {}))
    if box is None:
        place = np.array([0.06, 0.045, SIZE[2] + 0.02 + 1e-5])
        box = tc.Box(turn @ place, (0.05, 0.06, 0.04), turn.T, mass=mass, velocity=-speed * turn[:, 2])
    return tc.Scene(
        [body], [box], duration=duration, contact=tc.MasslessContact("full", tolerance=tolerance), **options
    )


def balance(result):
    """Largest error of momentum and of angular momentum without loads, over their size."""
    found = []
    for name in ("momentum", "angular_momentum"):
        column = result.history[name]
        found.append(np.abs(column - column[0]).max() / np.abs(column).max())
    return found


def test_a_block_on_a_bar_slows_down_exactly_as_its_wave_says():
    """M dv/dt = -rho c A v, so v = v0 exp(-rho c A t/M), until the wave comes back; first order in the cell size."""
    errors = []
    for cells in (8, 16):
        mesh = tc.box_mesh(striker.SIZE, (2, 2, cells))
        scene = striker.scene(striker="box", law="linear", poisson=0.0)
        held = [tc.Support("zmin", "xyz")]
        body = tc.Body(mesh, scene.bodies[0].material, contact="zmax", supports=held, name="rubber")
        result = simulate(replace(scene, bodies=[body], gravity=None))
        exact = striker.exact_speed(replace(result.scene, gravity=(0.0, 0.0, 0.0)), result.history["time"])
        speed = -result.history["obstacle_velocity:striker"][:, 2]
        errors.append(np.nanmax(np.abs(speed - exact)) / speed[0])
        layer = body.mass / cells
        assert errors[-1] <= 0.6 * layer / 0.5
        assert ck.energy(result, 5e-3).passed
    assert errors[1] < 0.6 * errors[0]


def test_sensors_change_nothing_and_see_the_run():
    """Many rows are done in a launch, with the step that the free box allows."""
    probes = [tc.Probe("zmax", "displacement"), tc.Probe("zmax", "velocity"), tc.Probe("zmin", "von_mises")]
    plain = simulate(hit())
    seen = simulate(hit(body={"probes": probes}, maxima=("von_mises",)))
    assert plain.steps == seen.steps > 20
    for name, column in plain.history.items():
        assert np.array_equal(column, seen.history[name], equal_nan=True), name
    mesh = seen.scene.bodies[0].mesh
    nodes = mesh.nodes_of("zmax")
    for quantity, known in (("displacement", seen.position - mesh.nodes), ("velocity", seen.velocity)):
        column = seen.history[f"probe_body-0_zmax_{quantity}"]
        assert len(column) == seen.steps + 1
        assert np.abs(column[-1] - known[nodes].mean(axis=0)).max() <= 1e-12 * np.abs(column).max()
    largest = seen.history["von_mises_max"]
    assert seen.maxima["von_mises"].value == largest.max() > 0.0
    assert seen.maxima["von_mises"].time == seen.history["time"][largest.argmax()]


@pytest.mark.parametrize("ratio", [1e-3, 1e-2, 0.1, 1.0, 10.0, 1e3])
def test_momentum_and_energy_at_any_ratio_of_masses(ratio):
    """Action and reaction cancel to rounding; the step follows the frequency of the box on the cells."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = simulate(hit(0.5 * ratio))
    assert balance(result)[0] <= 1e-10
    history = result.history
    assert history["contact_nodes"].max() > 0.0
    np.testing.assert_allclose(
        history["rigid_force"], -history["contact_force"], atol=1e-9 * np.abs(history["contact_force"]).max()
    )
    np.testing.assert_array_equal(history["rigid_force"], history["obstacle_force:obstacle-0"])
    assert np.abs(history["external_work"]).max() == 0.0
    given = np.abs(history["energy_error"][: int(np.argmax(history["contact_nodes"] > 0.0)) + 10])
    assert given.max() <= 1e-2  # the first steps of the impact; what follows is that of the mesh
    steps = np.diff(history["time"])
    if ratio <= 0.01:
        assert steps.min() < 0.7 * steps.max()  # short in contact, long after it
        assert steps[-1] > 0.8 * result.dt_limit
    if ratio >= 10.0:
        assert steps.min() == pytest.approx(0.9 * result.dt_limit, rel=1e-3)


def test_far_from_the_origin_and_turned_it_is_the_same():
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    here, there = simulate(hit(0.2)), simulate(hit(0.2, turn=turn))
    assert balance(there)[0] <= 1e-10
    rows = slice(0, min(len(here.history["time"]), len(there.history["time"])) // 2)
    np.testing.assert_allclose(
        there.history["obstacle_velocity:obstacle-0"][rows] @ turn,
        here.history["obstacle_velocity:obstacle-0"][rows],
        atol=1e-7,
    )


def test_angular_momentum_of_an_oblique_impact():
    """The law is that of large rotations; what is left is the residual of the static solve."""
    box = tc.Box((0.06, 0.045, 0.08), (0.05, 0.06, 0.02), tilted(), mass=0.1, velocity=(0.3, 0.0, -1.0),
                 angular_velocity=(5.0, -3.0, 2.0))  # fmt: skip
    result = simulate(hit(box=box, law=tc.NeoHookean, tolerance=1e-12, duration=2e-2))
    assert result.history["contact_nodes"].max() > 0.0
    assert max(balance(result)) <= 1e-10
    assert ck.energy(result, 5e-3).passed


def tilted():
    """Axes of a box that strikes with a corner."""
    c, s = np.cos(0.3), np.sin(0.3)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]) @ np.array(
        [[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]]
    )


def test_a_box_spins_in_flight_about_its_middle_axis_beside_a_body():
    """100 turns: angular momentum to rounding, energy without drift, and it tumbles as Euler's equations say."""
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (1, 1, 1))
    body = tc.Body(mesh, tc.LinearElastic(young=4e5, poisson=0.3, density=1000.0), contact="zmax")
    box = tc.Box((0.0, 0.0, 10.0), (1.0, 2.0, 3.0), mass=3.0, velocity=(1.0, 0.0, 0.0),
                 angular_velocity=(0.01, 2.0 * np.pi, 0.02))  # fmt: skip
    result = simulate(tc.Scene([body], [box], duration=100.0))
    history = result.history
    assert max(balance(result)) <= 1e-10
    np.testing.assert_allclose(history["obstacle_position:obstacle-0"][:, 0], history["time"], rtol=1e-12, atol=1e-12)
    energy = history["kinetic"] / history["kinetic"][0] - 1.0
    assert np.abs(energy).max() < 2e-3
    last = len(energy) // 4
    assert abs(energy[-last:].mean() - energy[:last].mean()) < 2e-4
    spin = history["obstacle_angular_velocity:obstacle-0"]
    assert np.abs(spin[:, [0, 2]]).max() > 2.0  # the middle axis is not stable
    time, wanted = _euler(box)
    errors = []
    for dt in (0.01, 0.005):
        history = simulate(replace(result.scene, duration=3.0), dt=dt).history
        spin = history["obstacle_angular_velocity:obstacle-0"]
        there = np.column_stack([np.interp(history["time"], time, wanted[:, axis]) for axis in range(3)])
        errors.append(np.abs(spin - there)[history["time"] <= time[-1]].max())
    assert errors[1] < 0.3 * errors[0] < 0.01  # second order


def _euler(box, end=3.0, step=1e-4):
    """Return times and angular velocities in the world of a free body, by Runge and Kutta on Euler's equations."""
    moments = np.diagonal(box.inertia_about_center())

    def rates(state):
        own, turn = state[:3], state[3:].reshape(3, 3)
        cross = np.array([[0.0, -own[2], own[1]], [own[2], 0.0, -own[0]], [-own[1], own[0], 0.0]])
        return np.concatenate([np.cross(moments * own, own) / moments, (turn @ cross).ravel()])

    state = np.concatenate([box.angular_velocity, np.eye(3).ravel()])
    found = []
    for _ in range(int(end / step)):
        found.append(state[3:].reshape(3, 3) @ state[:3])
        a = rates(state)
        b = rates(state + 0.5 * step * a)
        c = rates(state + 0.5 * step * b)
        state = state + step / 6.0 * (a + 2.0 * b + 2.0 * c + rates(state + step * c))
    return step * np.arange(len(found)), np.array(found)


def test_a_ball_falls_freely_where_no_body_can_touch():
    body = tc.Body(tc.box_mesh((1.0, 1.0, 1.0), (1, 1, 1)), tc.LinearElastic(4e5, 0.3, 1000.0))
    ball = tc.Sphere((0.0, 0.0, 9.0), 0.5, mass=2.0, velocity=(1.0, 0.0, 3.0), name="ball")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the body passes through the ball
        result = simulate(tc.Scene([body], [ball], duration=0.5, gravity=(0.0, 0.0, -9.81)))
    time = result.history["time"]
    np.testing.assert_allclose(result.history["obstacle_velocity:ball"][:, 2], 3.0 - 9.81 * time, atol=1e-11)
    np.testing.assert_allclose(
        result.history["obstacle_position:ball"][:, 2], 9.0 + 3.0 * time - 0.5 * 9.81 * time**2, atol=1e-10
    )
    assert result.history["energy_error"].max() <= 1e-12
    assert ck.momentum_balance(result, 1e-12).passed


def test_resumed_runs_have_the_same_bits(tmp_path):
    scene = hit(0.02, gravity=(0.0, 0.0, -9.81))
    whole = simulate(scene)
    simulate(scene, out=tmp_path, checkpoint={"every_steps": 25, "every_seconds": None, "keep": True})
    (tmp_path / "result.vtkhdf").exists()
    resumed = tc.resume(tmp_path, scene)
    assert resumed.ok
    for name, column in whole.history.items():
        np.testing.assert_array_equal(resumed.history[name], column, err_msg=name)
    heavier = replace(scene, obstacles=[replace(scene.obstacles[0], mass=0.03)])
    with pytest.raises(tc.InputError, match="mass"):
        tc.resume(tmp_path, heavier)


def test_scene_files_and_fingerprints(tmp_path):
    box = tc.Box((0.0, 0.0, 1.0), mass=2.0, inertia=np.diag([1.0, 2.0, 2.5]), angular_velocity=(0.0, 1.0, 0.0))
    ball = tc.Sphere((3.0, 0.0, 1.0), mass=1.0, inertia=0.5, name="ball")
    rod = tc.Cylinder((0.0, 9.0, 1.0), mass=1.0, inertia=(1.0, 1.0, 0.1))
    scene = replace(hit(), obstacles=[box, ball, rod])
    tc.save_scene(scene, tmp_path / "scene.toml")
    again = tc.load_scene(tmp_path / "scene.toml")
    again = again[0] if isinstance(again, tuple) else again
    assert fingerprint(again, None) == fingerprint(scene, None)
    other = replace(scene, obstacles=[replace(box, inertia=(1.0, 2.0, 2.4)), ball, rod])
    assert fingerprint(other, None) != fingerprint(scene, None)


def test_plan_names_what_there_is_and_nothing_without_it():
    planned = tc.plan(hit())
    assert "rigid-bodies" in planned.terms
    assert "rigid" in planned.describe()
    assert {"obstacle_position:obstacle-0", "rigid_impulse"} <= set(planned.columns)
    still = tc.plan(hit(box=tc.Box((0.05, 0.05, 0.1), (0.05, 0.05, 0.04), velocity=(0.0, 0.0, -1.0))))
    assert "rigid" not in still.describe()
    assert not [name for name in still.columns if "rigid" in name or "position" in name]
    assert still.domains[0].rigid == ()


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: tc.Plane(mass=1.0), "Plane.inertia"),
        (lambda: tc.Cylinder(mass=1.0), "Cylinder.inertia"),
        (lambda: tc.Sphere(mass=1.0, inside=True), "Sphere.inertia"),
        (lambda: tc.Sphere(mass=0.0), "Sphere.mass"),
        (lambda: tc.Sphere(inertia=1.0), "Sphere.inertia"),
        (lambda: tc.Sphere(mass=1.0, velocity=lambda time: (0.0, 0.0, time)), "Sphere.velocity"),
        (lambda: tc.Box(mass=1.0, inertia=(1.0, 1.0, 2.1)), "Box.inertia"),
        (lambda: tc.Box(mass=1.0, inertia=-np.eye(3)), "Box.inertia"),
        (lambda: tc.Box(mass=1.0, inertia=[[1, 0.5, 0], [0, 1, 0], [0, 0, 1]]), "Box.inertia"),
        (lambda: replace(hit(), contact=tc.ImpulseContact()), "Scene.contact"),
        (lambda: hit(friction=tc.FrictionLayer()), "Scene.friction"),
        (lambda: tc.simulate(hit(), scheme=tc.Midpoint(dt=1e-4)), r"Scene.obstacles\[0\]"),
    ],
)
def test_what_cannot_be_is_refused_by_name(make, field):
    with pytest.raises(tc.InputError, match=field):
        make()


def test_a_run_does_not_start_from_another_one():
    result = simulate(hit(duration=1e-4))
    with pytest.raises(tc.InputError, match="initial"):
        tc.simulate(hit(), initial=result)


def test_one_thread_and_two_give_the_same_bits():
    code = "import test_free_obstacles as t, tcontact as tc, hashlib\n"
    code += "r = tc.simulate(t.hit(0.02, cells=(24, 24, 12), duration=1e-3), threads=int(sys.argv[1]))\n"
    code += "assert r.ok and not tc.plan(r.scene).domains[0].small\n"
    code += (
        "print(hashlib.sha256(r.position.tobytes() + r.history['obstacle_velocity:obstacle-0'].tobytes()).hexdigest())"
    )
    digests = []
    for threads in (1, 2):
        done = python(code, threads)
        assert done.returncode == 0, done.stderr[-2000:]
        digests.append(done.stdout.split()[-1])
    assert digests[0] == digests[1]
