"""Loads: pressure that follows the faces, traction, force, own forces, and gravity as a function of time (METHOD 2)."""

import dataclasses

import numpy as np
import pytest
from oracle import meshes
from scenes import block, simulate, state_of
from stopped_runs import copied, same

import tcontact as tc
from tcontact.kernels.load_places import FORCE, HEAD, NODE, NODES
from tcontact.results.checks import momentum_balance

SIDES = ("xmin", "xmax", "ymin", "ymax", "zmin", "zmax")
SOFT = tc.LinearElastic(young=1e6, poisson=0.3, density=1000.0)
CUBE = tc.box_mesh((1.0, 1.0, 1.0), (3, 3, 3)).with_sets(node_sets={"all": np.arange(64)})
FLOOR = tc.Plane()
CFL = 0.3


def forces(scene, displacement):
    """Return the force [n, 3] of the loads on every node of the only body of a scene at t = 0."""
    state = state_of(scene, tc.plan(scene).bodies[0], displacement)
    state.begin_contact(1e-6)
    domain, load = state.domain, np.array(state.boundary_nodes.load)
    data = load[3 * len(domain.boundary) :]
    nodes = data[HEAD : HEAD + NODE * int(data[NODES])].reshape(-1, NODE)
    result = np.zeros_like(domain.reference)
    result[domain.boundary[nodes[:, 0].astype(int)]] = nodes[:, FORCE : FORCE + 3]
    return state.views[0].plan.to_user(result)


def by_quadrature(x, faces, pressures):
    """Return the sum of -p N_a n dA over bilinear faces or triangles by quadrature, force [n, 3]."""
    result = np.zeros_like(x)
    for face, pressure in zip(faces, pressures, strict=True):
        if len(set(face.tolist())) == 3:
            a, b, c = x[face[:3]]
            result[face[:3]] -= pressure * np.cross(b - a, c - a) / 6.0
            continue
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
        for point in corners / np.sqrt(3.0):
            factors = 1.0 + point * corners
            along = [corners[:, i] * factors[:, 1 - i] / 4.0 @ x[face] for i in (0, 1)]
            result[face] -= pressure * factors.prod(axis=1)[:, None] / 4.0 * np.cross(*along)
    return result


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
def test_a_uniform_pressure_on_a_closed_surface_has_no_net_force_and_no_moment(kind):
    """In any shape, turned and far away; and every node has the exact integral over its faces."""
    mesh, pressure = block(kind, 2, shift=(30.0, -20.0, 10.0)), 3e7
    turn, rng = meshes.rotation(7), np.random.default_rng(3)
    shape = (mesh.nodes - mesh.nodes[0]) @ (turn @ np.diag((1.5, 0.8, 1.1))).T
    u = shape + 0.03 * rng.normal(size=shape.shape) + np.array([3.0, 4.0, 5.0]) - mesh.nodes
    body = tc.Body(mesh, SOFT, displacement=u, loads=[tc.Load(side, pressure=pressure) for side in SIDES])
    force, x = forces(tc.Scene([body], duration=1.0), u), mesh.nodes + u
    faces = mesh.boundary_faces()
    wanted = by_quadrature(x, faces, np.full(len(faces), pressure))
    assert np.abs(force - wanted).max() <= 1e-13 * np.abs(wanted).max()
    size = pressure * 6 * 0.2**2
    assert np.abs(force.sum(axis=0)).max() <= 1e-12 * size
    assert np.abs(np.cross(x - x.mean(axis=0), force).sum(axis=0)).max() <= 1e-12 * size * 0.3


def test_pressure_traction_and_force_are_shared_as_they_say():
    """A pressure pushes in; shares are those of areas at rest, over nodes equal; several loads add up."""
    loads = [
        tc.Load("zmax", traction=(1.0, 2.0, 3.0)),
        tc.Load("zmax", force=lambda t: (4.0, 0.0, 0.0)),
        tc.Load("all", force=(0.0, 64.0, 0.0)),
        tc.Load("xmin", pressure=9.0),
    ]
    force = forces(tc.Scene([tc.Body(CUBE, SOFT, loads=loads)], duration=1.0), None)
    x = CUBE.nodes
    assert force.sum(axis=0) == pytest.approx([1.0 + 4.0 + 9.0, 2.0 + 64.0, 3.0], rel=1e-13)
    shares = [np.where((x[:, i] == 0.0) | (x[:, i] == 1.0), 1.0 / 6.0, 1.0 / 3.0) for i in range(3)]
    on_top = np.where(x[:, 2] == 1.0, shares[0] * shares[1], 0.0)
    side = np.where(x[:, 0] == 0.0, shares[1] * shares[2], 0.0)
    wanted = on_top[:, None] * (5.0, 2.0, 3.0) + side[:, None] * (9.0, 0.0, 0.0) + (0.0, 1.0, 0.0)
    assert np.abs(force - wanted).max() <= 1e-13


@pytest.mark.parametrize("turned", [False, True])
def test_a_hydrostatic_pressure_is_the_weight_of_what_is_displaced(turned):
    """A function of time and place, with its parameters in either order."""

    def depth(points, time):
        return 9810.0 * (2.0 + time - points[:, 2])

    function = depth if turned else lambda when, where: depth(where, when)
    body = tc.Body(CUBE, SOFT, loads=[tc.Load(side, pressure=function) for side in SIDES])
    force = forces(tc.Scene([body], duration=1.0), None)
    assert force.sum(axis=0) == pytest.approx([0.0, 0.0, 9810.0], abs=1e-9)


def test_a_free_block_gains_the_impulse_of_its_loads():
    """Momentum = traction times area times time, exact for a linear ramp too; the work is what the block has then."""
    traction = tc.Load("zmax", traction=(0.0, 0.0, -1e3))
    ramp = tc.Load("all", force=lambda t: (0.0, 2e4 * t, 0.0))
    result = simulate(tc.Scene([tc.Body(CUBE, SOFT, loads=[traction, ramp])], duration=0.2), cfl=CFL)
    history, time = result.history, result.time
    assert history["momentum"][-1] == pytest.approx([0.0, 1e4 * time**2, -1e3 * time], rel=1e-10, abs=1e-10)
    assert history["applied_impulse"][-1] == pytest.approx(history["momentum"][-1], rel=1e-10, abs=1e-10)
    assert history["energy_error"].max() <= 1e-3
    assert history["applied_work"][-1] == pytest.approx(history["kinetic"][-1] + history["elastic"][-1], rel=1e-3)
    pushed = simulate(tc.Scene([tc.Body(CUBE, SOFT, loads=tc.Load("xmin", pressure=1e3))], duration=0.2), cfl=CFL)
    assert pushed.history["momentum"][-1] == pytest.approx([1e3 * pushed.time, 0.0, 0.0], rel=1e-2, abs=1e-9)
    assert momentum_balance(pushed, 1e-10).passed
    assert pushed.history["energy_error"].max() <= 1e-3


def test_a_stiff_block_accelerates_by_pressure_times_area_over_mass():
    law = tc.LinearElastic(young=1e14, poisson=0.3, density=1000.0)
    result = simulate(tc.Scene([tc.Body(CUBE, law, loads=tc.Load("xmax", pressure=200.0))], duration=1e-5), cfl=CFL)
    assert result.history["momentum"][1:, 0] == pytest.approx(-200.0 * result.history["time"][1:], rel=1e-10)


@pytest.mark.parametrize("removal", ["full", "normal"])
def test_the_pressure_on_a_contact_face_bears_a_part_of_the_load(removal):
    """A column without Poisson's effect starts in equilibrium: the floor gives what the fluid below does not."""
    law, top, fluid = tc.LinearElastic(young=1e6, poisson=0.0, density=1000.0), 2e3, 700.0
    loads = [tc.Load("zmax", traction=(0.0, 0.0, -top)), tc.Load("zmin", pressure=fluid)]
    body = tc.Body(CUBE, law, displacement=CUBE.nodes * (0.0, 0.0, -top / 1e6), contact="zmin", loads=loads)
    scene = tc.Scene([body], FLOOR, duration=0.1, contact=tc.MasslessContact(removal, tolerance=1e-12))
    result = simulate(scene, cfl=CFL)
    assert np.abs(result.history["contact_force"] - (0.0, 0.0, top - fluid)).max() <= 1e-10 * top
    assert result.history["static_residual"].max() <= 1e-12
    assert momentum_balance(result, 1e-10).passed


def test_an_own_force_holds_a_block_as_springs_do():
    """Springs in proportion to the masses: the block stays rigid and moves as leapfrog does with their force."""
    mass = np.trace(tc.plan(tc.Scene([tc.Body(CUBE, SOFT)], duration=1.0)).bodies[0].mass, axis1=1, axis2=2) / 3.0
    rate, dt = 20.0, 2e-3

    def springs(positions, velocities, time):
        assert positions.shape == velocities.shape == (64, 3)
        return -(rate**2) * mass[:, None] * (positions - CUBE.nodes)

    body = tc.Body(CUBE, SOFT, displacement=(1e-2, 0.0, 0.0), loads=[tc.Load("all", force=springs)])
    result = tc.simulate(tc.Scene([body], duration=0.3), tc.CentralDifference(dt=dt))
    moved = result.position - CUBE.nodes
    turned = 2.0 * np.arcsin(0.5 * rate * dt) * result.steps
    assert np.abs(moved - (1e-2 * np.cos(turned), 0.0, 0.0)).max() <= 1e-12
    assert result.history["energy_error"].max() <= (0.5 * rate * dt) ** 2 * 1.01


def test_gravity_may_be_a_function_of_time():
    """Free fall under a gravity that grows: momentum exact, work as much as the kinetic energy, massless nodes too."""
    for contact, gap in ((None, 0.0), ("zmin", 1.0)):
        body = tc.Body(CUBE.translated((0.0, 0.0, gap)), SOFT, contact=contact)
        scene = tc.Scene([body], FLOOR if contact else (), duration=0.3, gravity=lambda t: (0.0, 1.0, -9.81 * t))
        result = simulate(scene, cfl=CFL)
        time = result.time
        assert result.history["momentum"][-1] == pytest.approx([0.0, 1e3 * time, -9.81e3 * time**2 / 2.0], abs=1e-9)
        assert momentum_balance(result, 1e-10).passed
        assert result.history["energy_error"].max() <= 1e-3
    constant = dataclasses.replace(scene, gravity=(0.0, 0.0, -9.81))
    same_value = dataclasses.replace(scene, gravity=lambda t: (0.0, 0.0, -9.81))
    one, other = simulate(constant, cfl=CFL), simulate(same_value, cfl=CFL)
    assert np.abs(one.position - other.position).max() <= 1e-14
    assert one.history["external_work"][-1] == pytest.approx(other.history["external_work"][-1], rel=1e-10)
    assert "gravity_impulse" not in one.history


def test_reach_knows_loads_and_gravity_that_grows():
    """Faces that a load or a gravity that begins later may bring to a wall are contact faces."""
    far = CUBE.translated((0.0, 0.0, 3.0))
    found = []
    for loads, gravity in (
        ((), None),
        ((tc.Load("zmax", traction=lambda t: (0.0, 0.0, -1e4 * t)),), None),
        ((tc.Load("zmax", pressure=5e3),), None),
        ((tc.Load("all", force=lambda x, v, t: np.tile((0.0, 0.0, -200.0), (64, 1))),), None),
        ((), lambda t: (0.0, 0.0, -5.0 * t)),
    ):
        body = tc.Body(far, SOFT, contact="auto", loads=loads)
        found.append(len(tc.Scene([body], FLOOR, duration=1.0, gravity=gravity).bodies[0].contact_faces))
    assert found == [0, 9, 9, 9, 9]


LATER = 0.012


def fails(t):
    """Fail at a time of the run."""
    if t > LATER:
        raise ValueError("no value")
    return 1e3


def fails_with_place(t, x):
    """Return a wrong shape at a time of the run."""
    return np.full(len(x) - (t > LATER), fails(0.0))


def fails_itself(positions, velocities, time):
    """Return NaN at a time of the run."""
    return np.full((64, 3), np.nan if time > LATER else 1.0)


@pytest.mark.parametrize("number", range(4))
def test_a_function_that_fails_stops_the_run_with_everything_kept(number):
    loads = [[tc.Load("zmax", pressure=fails)], [tc.Load("zmax", pressure=fails_with_place)],
             [tc.Load("all", force=fails_itself)], []][number]  # fmt: skip
    gravity = None if loads else lambda t: (0.0, 0.0, fails(t))
    body, other = (tc.Body(CUBE.translated((2.0 * i, 0.0, 0.0)), SOFT, loads=loads) for i in range(2))
    other = dataclasses.replace(other, loads=[])
    result = tc.simulate(tc.Scene([body, other], duration=0.05, gravity=gravity), tc.CentralDifference(cfl=CFL))
    assert (result.ok, result.reason) == (False, "function-failed")
    assert 0.5 * LATER < result.time <= LATER + 2.0 * result.dt
    assert ("Load." in result.message) is bool(loads)
    assert len(result.history["time"]) == result.steps + 1
    assert momentum_balance(result, 1e-10).passed


WRONG = [
    ({"set": 3, "force": (0.0, 0.0, 1.0)}, "Load.set"),
    ({"set": "nowhere", "pressure": 1.0}, "Load.set"),
    ({"set": "all", "pressure": 1.0}, "Load.set"),
    ({"set": "all", "traction": (0.0, 0.0, 1.0)}, "Load.set"),
    ({"set": "zmax"}, "Load"),
    ({"set": "zmax", "pressure": 1.0, "force": (0.0, 0.0, 1.0)}, "Load"),
    ({"set": "zmax", "pressure": np.nan}, "Load.pressure"),
    ({"set": "zmax", "pressure": (0.0, 0.0, 1.0)}, "Load.pressure"),
    ({"set": "zmax", "traction": 1.0}, "Load.traction"),
    ({"set": "zmax", "force": (0.0, 1.0)}, "Load.force"),
    ({"set": "zmax", "force": lambda t, x: (0.0, 0.0, 1.0)}, "Load.force"),
    ({"set": "zmax", "pressure": lambda x, v, t: 1.0}, "Load.pressure"),
    ({"set": "zmax", "pressure": lambda t: np.inf}, "Load.pressure on 'zmax'"),
    ({"set": "zmax", "pressure": lambda t, x: 1.0}, "Load.pressure on 'zmax'"),
    ({"set": "zmax", "traction": lambda t, x: np.ones(len(x))}, "Load.traction on 'zmax'"),
    ({"set": "zmax", "force": lambda x, v, t: np.ones(3)}, "Load.force on 'zmax'"),
]


@pytest.mark.parametrize("number", range(len(WRONG)))
def test_wrong_loads_are_refused_by_name(number):
    options, field = WRONG[number]
    with pytest.raises(tc.InputError) as caught:
        tc.Body(CUBE, SOFT, loads=[tc.Load(**options)])
    assert caught.value.field == field


def test_more_that_is_refused():
    with pytest.raises(tc.InputError, match="periodic sides"):
        tc.Body(CUBE, SOFT, periodic="x", loads=[tc.Load("xmin", pressure=1.0)])
    with pytest.raises(tc.InputError, match=r"Body\.loads"):
        tc.Body(CUBE, SOFT, loads=["zmax"])
    with pytest.raises(tc.InputError, match=r"Scene\.gravity"):
        tc.Scene([tc.Body(CUBE, SOFT)], duration=1.0, gravity=lambda t: (0.0, t))
    implicit = tc.DiscreteGradient(dt=1e-3)
    for load in (tc.Load("zmax", pressure=1.0), tc.Load("zmax", force=lambda t: (0.0, 0.0, t))):
        with pytest.raises(tc.InputError, match=r"bodies\[0\]\.loads"):
            tc.simulate(tc.Scene([tc.Body(CUBE, SOFT, loads=[load])], duration=1.0), implicit)
    with pytest.raises(tc.InputError, match="constant gravity"):
        tc.simulate(tc.Scene([tc.Body(CUBE, SOFT)], duration=1.0, gravity=lambda t: (0.0, 0.0, 1.0)), implicit)


def test_implicit_schemes_take_constant_tractions_and_forces():
    """A free block: momentum and energy exact."""
    loads = [tc.Load("zmax", traction=(0.0, 100.0, -2e3)), tc.Load("all", force=(30.0, 0.0, 0.0))]
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2)).with_sets(node_sets={"all": np.arange(27)})
    shares = np.where(mesh.nodes == 0.5, 0.5, 0.25).prod(axis=1)  # of the mass
    scene = tc.Scene([tc.Body(mesh, SOFT, loads=loads)], duration=0.1, gravity=(0.0, 0.0, -1.0))
    result = tc.simulate(scene, tc.DiscreteGradient(dt=1e-2))
    history = result.history
    assert history["momentum"][-1] == pytest.approx(result.time * np.array([30.0, 100.0, -3e3]), rel=1e-12)
    assert momentum_balance(result, 1e-12).passed
    assert history["energy_error"].max() <= 1e-10
    gained = history["kinetic"][-1] + history["elastic"][-1] + 1e3 * (result.position - mesh.nodes)[:, 2] @ shares
    assert history["applied_work"][-1] == pytest.approx(gained, rel=1e-10)


def test_scene_files_hold_numbers_and_refuse_functions(tmp_path):
    loads = [tc.Load("zmax", pressure=1e5 / 3.0), tc.Load("all", force=(0.0, 1.0 / 3.0, 0.0)),
             tc.Load("xmin", traction=(1.0, 2.0, 3.0))]  # fmt: skip
    body = tc.Body(CUBE, SOFT, loads=loads)
    tc.save_scene(tc.Scene([body], duration=0.1), tmp_path / "a.toml")
    again = tc.load_scene(tmp_path / "a.toml")[0].bodies[0].loads
    assert [load.kind for load in again] == ["pressure", "force", "traction"]
    assert all(np.array_equal(one.value, other.value) for one, other in zip(loads, again, strict=True))
    body = dataclasses.replace(body, loads=[tc.Load("zmax", pressure=fails)])
    with pytest.raises(tc.InputError, match=r"loads\[0\]\.pressure"):
        tc.save_scene(tc.Scene([body], duration=0.1), tmp_path / "b.toml")
    with pytest.raises(tc.InputError, match="gravity"):
        tc.save_scene(
            tc.Scene([tc.Body(CUBE, SOFT)], duration=0.1, gravity=lambda t: (0, 0, -1.0)), tmp_path / "c.toml"
        )
    (tmp_path / "d.toml").write_text((tmp_path / "a.toml").read_text().replace("pressure", "presure"))
    with pytest.raises(tc.InputError, match="did you mean 'pressure'"):
        tc.load_scene(tmp_path / "d.toml")


def test_a_resumed_run_has_the_same_bits_and_the_same_functions(monkeypatch, tmp_path):
    """Every kind of load at once on a block that lands; a function that differs is refused."""

    def scene(scale=1.0):
        loads = [
            tc.Load("zmin", pressure=lambda t: 500.0 * np.sin(90.0 * t)),
            tc.Load("xmax", traction=lambda x, t: scale * x * np.cos(50.0 * t)),
            tc.Load("all", force=lambda positions, velocities, time: -30.0 * velocities + 5.0 * time),
        ]
        body = tc.Body(CUBE, SOFT, velocity=(0.0, 0.0, -0.5), contact="zmin", loads=loads)
        contact = tc.MasslessContact("full")
        return tc.Scene([body], FLOOR, duration=0.05, gravity=lambda t: (0.0, 0.0, -10.0 * t), contact=contact)

    whole, copies = copied(monkeypatch, tmp_path, scene(), "central-difference", 4)
    assert copies
    for place in list(copies.values())[:-1]:
        same(whole, tc.resume(place, scene()))
    place = list(copies.values())[-1]
    with pytest.raises(tc.InputError, match="traction"):
        tc.resume(place, scene(1.01))
