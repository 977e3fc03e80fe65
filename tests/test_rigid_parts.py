"""Rigid parts: nodes that keep their shape, free and driven; friction on free obstacles; what is refused."""

import warnings

import numpy as np
import pytest
from scenes import simulate

import tcontact as tc
from tcontact.results import checks as ck

RADIUS, INNER, WIDTH = 0.1, 0.06, 0.02
MIDDLE = np.array([0.0, 0.5 * WIDTH, RADIUS])


def ring(around=24):
    """A ring about the y axis that stands on z = 0, two cells thick."""
    mesh = tc.ring_mesh(INNER, RADIUS, WIDTH, around, axis="y", center=MIDDLE, across=2, layers=1)
    sets = {"rim": mesh.face_sets["inner"], "tread": mesh.face_sets["outer"]}
    return tc.Mesh(mesh.nodes, mesh.cells, "hex8", face_sets=sets)


def rolling(part, speed=1.0, duration=0.05, friction=0.5, **options):
    """A rubber ring rolls on a plane at the speed of its tread."""
    spin = np.array([0.0, speed / RADIUS, 0.0])
    body = tc.Body(
        ring(),
        tc.NeoHookean(young=1e6, poisson=0.3, density=1000.0),
        velocity=lambda x: np.array([speed, 0.0, 0.0]) + np.cross(spin, x - MIDDLE),
        contact="tread",
        rigid_parts=[part],
        **options,
    )
    law = tc.Coulomb(friction) if friction else None
    return tc.Scene([body], [tc.Plane()], duration=duration, gravity=(0.0, 0.0, -9.81), friction=law)


def lengths(points):
    """Distances [n, n] of points."""
    return np.linalg.norm(points[:, None] - points[None], axis=2)


def check_rigid(result, name="rim"):
    """The nodes of the part keep their distances, and stand where the history says."""
    mesh = result.scene.bodies[0].mesh
    nodes = mesh.nodes_of(name)
    np.testing.assert_allclose(lengths(result.position[nodes]), lengths(mesh.nodes[nodes]), atol=1e-14)
    history = result.history
    centre, spin = (history[f"part_{what}:body-0-{name}"][-1] for what in ("position", "angular_velocity"))
    velocity = history[f"part_velocity:body-0-{name}"][-1] + np.cross(spin, result.position[nodes] - centre)
    np.testing.assert_allclose(result.velocity[nodes], velocity, atol=1e-11)


def test_a_rigid_rim_in_a_rolling_ring():
    """Momentum, energy and rigidity; the rim takes over the motion of its nodes at the start."""
    result = simulate(rolling(tc.RigidPart("rim", mass=0.5)))
    history = result.history
    assert history["contact_nodes"].max() > 0
    assert ck.momentum_balance(result, 1e-10).passed
    assert ck.energy(result, 5e-3).passed
    check_rigid(result)
    np.testing.assert_allclose(history["part_velocity:body-0-rim"][0], (1.0, 0.0, 0.0), atol=1e-12)
    np.testing.assert_allclose(history["part_angular_velocity:body-0-rim"][0], (0.0, 10.0, 0.0), atol=1e-11)
    total = result.scene.bodies[0].mass + 0.5
    np.testing.assert_allclose(history["momentum"][0], (total, 0.0, 0.0), atol=1e-12)
    inertia = _inertia(result.scene) + 0.5 * INNER**2  # nodes of the rim stand at one radius
    np.testing.assert_allclose(history["angular_momentum"][0, 1], 10.0 * inertia + total * RADIUS, rtol=1e-12)


def _inertia(scene):
    """Moment of inertia of the ring about its axis, with the masses that the contact nodes gave to others."""
    mass, away = tc.plan(scene).bodies[0].mass[:, 0, 0], scene.bodies[0].mesh.nodes - MIDDLE
    return float(mass @ (away[:, 0] ** 2 + away[:, 2] ** 2))


def test_a_driven_rim_is_where_it_is_driven():
    """Its reaction keeps the momentum, its work the energy; a function of time gives the motion of a vector."""
    motion = {"center": tuple(MIDDLE), "velocity": (1.0, 0.0, 0.1)}
    result = simulate(rolling(tc.RigidPart("rim", driven=True, angular_velocity=(0.0, 12.0, 0.0), **motion)))
    history = result.history
    assert ck.momentum_balance(result, 1e-10).passed
    assert ck.energy(result, 5e-3).passed
    assert np.abs(history["external_work"]).max() > 1e-3
    check_rigid(result)
    wanted = MIDDLE + np.outer(history["time"], motion["velocity"])
    np.testing.assert_allclose(history["part_position:body-0-rim"], wanted, atol=1e-13)
    np.testing.assert_allclose(history["part_rotation:body-0-rim"][:, 1], 12.0 * history["time"], atol=1e-12)
    other = simulate(rolling(tc.RigidPart("rim", driven=True, angular_velocity=lambda t: (0.0, 12.0, 0.0), **motion)))
    np.testing.assert_allclose(other.position, result.position, atol=1e-12)


def test_a_heavy_free_part_moves_as_a_driven_one_and_a_light_one_as_its_nodes():
    heavy = simulate(rolling(tc.RigidPart("rim", mass=1e9, inertia=1e9, velocity=(1.0, 0.0, 0.1)), duration=0.01))
    driven = tc.RigidPart(
        "rim", driven=True, velocity=lambda t: (1.0, 0.0, 0.1 - 9.81 * t), angular_velocity=(0, 10.0, 0)
    )
    np.testing.assert_allclose(heavy.position, simulate(rolling(driven, duration=0.01)).position, atol=1e-9)


def test_two_rigid_ends_of_a_bar_swing_at_the_exact_frequency():
    """Rigid masses at the ends of a bar with poisson 0 and little mass: w^2 = 2 k/M, k = E A/L; no external force."""
    mesh = tc.box_mesh((0.4, 0.1, 0.1), (8, 2, 2))
    ends = [tc.RigidPart(name, mass=5.0, inertia=0.1) for name in ("xmin", "xmax")]
    body = tc.Body(
        mesh, tc.LinearElastic(young=1e6, poisson=0.0, density=1.0), rigid_parts=ends,
        velocity=lambda x: np.column_stack([0.01 * (x[:, 0] / 0.2 - 1.0), 0.0 * x[:, 0], 0.0 * x[:, 0]]),
    )  # fmt: skip
    frequency = np.sqrt(2.0 * (1e6 * 0.01 / 0.4) / 5.0)
    result = simulate(tc.Scene([body], duration=2.0 * np.pi / frequency))
    speed = result.history["part_velocity:body-0-xmax"][:, 0]
    wanted = 0.01 * np.cos(frequency * result.history["time"])
    np.testing.assert_allclose(speed, wanted, atol=1e-4)
    assert np.abs(result.history["momentum"]).max() <= 1e-12
    assert result.history["energy_error"].max() <= 1e-3


@pytest.mark.parametrize("removal", ["normal", pytest.param("full", marks=pytest.mark.slow)])
def test_friction_pulls_a_light_plate_along_without_a_jerk(removal):
    """A light rigid plate lies on a rubber block that slides: all nodes stick at last; momentum, work, no overshoot."""
    mesh = tc.box_mesh((0.1, 0.1, 0.05), (3, 3, 2))
    plate = tc.Box((0.05, 0.05, 0.06), (0.08, 0.08, 0.02), mass=0.01, name="plate")
    body = tc.Body(
        mesh,
        tc.NeoHookean(1e6, 0.3, 1000.0),
        velocity=(0.05, 0.0, 0.0),
        contact="zmax",
        supports=[tc.Support("zmin", "z")],
    )
    scene = tc.Scene([body], [plate], duration=0.02, gravity=(0.0, 0.0, -9.81), friction=tc.Coulomb(0.5),
                     contact=tc.MasslessContact(removal, tolerance=1e-8))  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = simulate(scene)
    assert ck.momentum_balance(result, 1e-10).passed
    assert ck.energy(result, 2e-2).passed
    speed = result.history["obstacle_velocity:plate"][:, 0]
    assert 0.02 < speed.max() < 0.06
    assert result.history["friction_work"].min() >= -1e-9


def edge_of_a_block(part):
    """Plan of a block, an edge of which is a rigid part."""
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
    low = np.flatnonzero((mesh.nodes[:, :2] == 0.0).all(axis=1))
    body = tc.Body(mesh.with_sets(node_sets={"edge": low}), tc.NeoHookean(1e7, 0.3, 1e3), rigid_parts=[part])
    return tc.plan(tc.Scene([body], duration=1e-5))


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: tc.RigidPart("rim"), "RigidPart.mass"),
        (lambda: tc.RigidPart("rim", mass=-1.0), "RigidPart.mass"),
        (lambda: tc.RigidPart("rim", mass=1.0, driven=True), "RigidPart.mass"),
        (lambda: tc.RigidPart("rim", mass=1.0, inertia=(1.0, 1.0, 5.0)), "RigidPart.inertia"),
        (lambda: tc.RigidPart("rim", mass=1.0, velocity=lambda t: (0.0, 0.0, t)), "RigidPart.velocity"),
        (lambda: edge_of_a_block(tc.RigidPart("edge", driven=True)), r"Support\(velocity=\)"),
        (lambda: edge_of_a_block(tc.RigidPart("edge", mass=1.0)), "give mass and inertia"),
        (lambda: rolling(tc.RigidPart("nothing", mass=1.0)), "nothing"),
        (lambda: rolling(tc.RigidPart("tread", mass=1.0)), "Body.rigid_parts"),
        (lambda: rolling(tc.RigidPart("rim", mass=1.0), supports=[tc.Support("rim", "x")]), "Body.rigid_parts"),
    ],
)
def test_what_cannot_be_is_refused_by_name(make, field):
    with pytest.raises(tc.InputError, match=field):
        make()


def test_scene_files_keep_rigid_parts(tmp_path):
    scene = rolling(tc.RigidPart("rim", mass=0.5, inertia=(1e-3, 2e-3, 1.5e-3)))
    tc.save_scene(scene, tmp_path / "scene.toml")
    found = tc.load_scene(tmp_path / "scene.toml")
    found = found[0] if isinstance(found, tuple) else found
    part = found.bodies[0].rigid_parts[0]
    assert (part.set, part.mass, part.driven) == ("rim", 0.5, False)
    np.testing.assert_array_equal(part.inertia, (1e-3, 2e-3, 1.5e-3))
    driven = rolling(tc.RigidPart("rim", driven=True, velocity=lambda t: (t, 0.0, 0.0)))
    with pytest.raises(tc.InputError, match="velocity"):
        tc.save_scene(driven, tmp_path / "other.toml")
    plain = tc.Scene(scene.bodies, [], duration=0.01, contact=None)
    with pytest.raises(tc.InputError, match="rigid_parts"):
        tc.simulate(plain, scheme=tc.Midpoint(dt=1e-4))


def accelerated(last=np.inf):
    """Velocity [m/s] at a time, an error after `last` [s]."""

    def velocity(t):
        if t > last:
            raise ValueError("unknown there")
        return (200.0 * t, 0.0, 0.0)

    return velocity


def test_the_last_row_of_a_driven_part_is_that_of_a_driven_support():
    """Reaction with inertia, velocity, work and energy, although no step follows; nothing where time ends there."""
    scheme, found = tc.CentralDifference(dt=2e-4), {}
    held = {
        "part": {"rigid_parts": [tc.RigidPart("zmax", driven=True, velocity=accelerated())]},
        "support": {"supports": [tc.Support("zmax", "xyz", velocity=accelerated())]},
        "ending": {"rigid_parts": [tc.RigidPart("zmax", driven=True, velocity=accelerated(4.00001e-3))]},
    }
    for name, one in held.items():
        block = tc.Body(tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2)), tc.NeoHookean(1e6, 0.3, 1000.0), **one)
        found[name] = tc.simulate(tc.Scene([block], duration=4e-3), scheme=scheme)
    part, support, ending = (found[name] for name in held)
    for name in ("support_force", "kinetic", "external_work", "momentum", "energy"):
        np.testing.assert_allclose(part.history[name], support.history[name], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(part.velocity, support.velocity, rtol=1e-9, atol=1e-12)
    assert ending.ok
    np.testing.assert_allclose(ending.position, support.position, rtol=1e-12, atol=1e-12)


def damped_parts(dt, damping, driven=False, rate=0.0):
    """Error of the energy of a soft cube with a spinning rigid top, dashpots at one edge of that and at its foot."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2))
    edge = np.flatnonzero((mesh.nodes[:, 2] > 0.099) & (mesh.nodes[:, 0] > 0.099))
    parts = [tc.RigidPart("zmax", mass=1.0, inertia=2e-3)]
    if driven:
        parts.append(tc.RigidPart("zmin", driven=True, velocity=lambda t: (0.0, 3.0 * np.sin(900.0 * t), 0.0)))
    springs = [
        tc.Spring("edge", 10.0, damping, to=(0.3, 0.05, 0.2)),
        tc.Spring("edge", 0.0, damping, to=("cube", "zmin"), axes="xyz"),
    ]
    cube = tc.Body(
        mesh.with_sets(node_sets={"edge": edge}), tc.NeoHookean(1e6, 0.3, 1000.0), name="cube", rigid_parts=parts,
        springs=springs, velocity=lambda x: np.cross((0.0, 20.0, 40.0), x - (0.07, 0.05, 0.1)),
    )  # fmt: skip
    mass_damping = tc.MassDamping(rate) if rate else None
    scene = tc.Scene([cube], duration=6e-3, damping=mass_damping, gravity=(0.0, 0.0, -9.81))
    result = tc.simulate(scene, scheme=tc.CentralDifference(dt=dt))
    assert result.ok
    return result.history["energy_error"].max()


@pytest.mark.parametrize(
    ("driven", "rate"), [(False, 0.0), (True, 0.0), (True, 200.0)], ids=["free", "beside a driven part", "mass damping"]
)
def test_dashpots_at_rigid_parts_are_of_second_order_and_stable(driven, rate):
    """At any c: with c dt/M = 40 too, where a dashpot that acts half a step late blows up."""
    coarse, fine = damped_parts(1e-4, 500.0, driven, rate), damped_parts(5e-5, 500.0, driven, rate)
    assert coarse < 3e-3
    assert coarse > 3.3 * fine
    assert damped_parts(1e-4, 4e5, driven, rate) < 2e-2
