"""Several walls at a body: far ones, touching ones, the same one twice; walls that let go of tall cells (METHOD 2)."""

import dataclasses

import numpy as np
import pytest
from oracle import meshes
from scenes import simulate
from test_static_solve import problem, solved

import tcontact as tc
from tcontact.device import arrays
from tcontact.kernels import columns
from tcontact.kernels.static import control as static_control

SPEED = 0.01  # m/s: moves of 1e-5 m in the time that a wave needs there and back
FAR = tc.Plane(point=(0.0, 100.0, 0.0), normal=(0.0, -1.0, 0.0))
CEILING = tc.Plane(point=(0.0, 0.0, 100.0), normal=(0.0, 0.0, -1.0))


def rubber(law=tc.LinearElastic):
    return law(young=1e7, poisson=0.3, density=1000.0)


def pushed(more=(), first=False, removal="full", penalty=None, friction=None):
    """A linear cube of tets between floor and side wall, thrown at both; `more` obstacles before or behind these."""
    body = tc.Body(
        tc.box_mesh((0.1,) * 3, (4,) * 3, "tet4"),
        rubber(),
        velocity=(-0.3 * SPEED, 0.0, -SPEED),
        contact=["xmin", "zmin"],
    )
    near = [tc.Plane(), tc.Plane(normal=(1.0, 0.0, 0.0))]
    return simulate(
        tc.Scene(
            bodies=[body],
            obstacles=[*more, *near] if first else [*near, *more],
            duration=3e-3,
            contact=tc.MasslessContact(removal=removal, penalty=penalty),
            friction=None if friction is None else tc.Coulomb(friction),
        )
    )


@pytest.mark.parametrize(
    ("more", "removal", "penalty", "friction"),
    [([FAR], "full", None, None), ([FAR], "full", 1e9, None), ([CEILING], "normal", None, None),
     ([FAR], "normal", None, None), ([FAR, CEILING], "full", None, None), ([FAR], "full", None, 0.3),
     pytest.param([FAR], "normal", None, 0.3, marks=pytest.mark.slow)],
    ids=["one", "penalty", "normal removal, parallel", "normal removal, across",
         "two, so that nodes choose three of four", "friction", "normal removal, friction"],
)  # fmt: skip
def test_a_wall_out_of_reach_changes_not_a_bit(more, removal, penalty, friction):
    alone = pushed(removal=removal, penalty=penalty, friction=friction)
    pressing = np.abs(alone.history["contact_force"]).max(axis=0)
    assert (pressing[[0, 2]] > 0.0).all(), "both walls are touched"
    if penalty is None:
        assert alone.history["gap_min"].min() >= -1e-9
    for first in (False, True):
        found = pushed(more, first, removal, penalty, friction)
        assert np.array_equal(found.position, alone.position)
        for name in ("contact_force", "gap_min", "static_residual", "sweeps"):
            assert np.array_equal(found.history[name], alone.history[name]), name


@pytest.mark.parametrize("removal", ["full", "normal"])
@pytest.mark.parametrize("seed", range(2))
def test_a_shaken_bar_between_touching_walls_stays_between_them(removal, seed):
    """Every node has a wall at gap 0 and another across the bar, at 4e-2 m: 1e7 times its moves."""
    size = np.array([0.04, 0.04, 0.3])
    box = tc.box_mesh(size, (4, 4, 30))
    mesh = tc.Mesh(meshes.shaken(np.array(box.nodes), 2e-3, seed), box.cells, "hex8", face_sets=box.face_sets)
    walls = [
        tc.Plane(point=side * size * axis, normal=(1 - 2 * side) * axis) for axis in np.eye(3)[:2] for side in (0, 1)
    ]
    speed = 1e-5
    body = tc.Body(mesh, rubber(), velocity=(0.0, 0.0, -speed), contact=["xmin", "xmax", "ymin", "ymax", "zmin"])
    duration = 0.02 / body.material.wave_speed
    result = simulate(
        tc.Scene(
            bodies=[body],
            obstacles=[*walls, tc.Plane()],
            duration=10 * duration,
            contact=tc.MasslessContact(removal=removal),
        )
    )
    moved = np.abs(result.position - mesh.nodes).max()
    assert moved > speed * duration
    assert result.history["gap_min"].min() >= -1e-9 * moved
    assert result.history["static_residual"].max() <= 1e-6


def thrown_flat(obstacles, law, friction=0.3, slip=0.3):
    """A cube that hits the floor along and across it."""
    body = tc.Body(tc.box_mesh((0.1,) * 3, (4,) * 3), rubber(law), velocity=(slip, 0.0, -1.0), contact="zmin")
    return simulate(
        tc.Scene(
            bodies=[body],
            obstacles=obstacles,
            duration=0.3 / body.material.wave_speed,
            contact=tc.MasslessContact(removal="full"),
            friction=tc.Coulomb(friction),
        )
    )


@pytest.mark.parametrize("count", [2, 3])
def test_a_floor_named_several_times_rubs_as_one(count):
    one, several = (thrown_flat(floors, tc.LinearElastic) for floors in ([tc.Plane()], [tc.Plane()] * count))
    force = np.abs(one.history["contact_force"]).max()
    assert np.abs(one.history["contact_force"][:, 0]).max() > 0.1 * force
    assert np.allclose(several.history["contact_force"], one.history["contact_force"], atol=1e-5 * force)
    assert np.allclose(several.position, one.position, atol=1e-8)


@pytest.mark.parametrize("law", [tc.LinearElastic, tc.NeoHookean])
@pytest.mark.parametrize("slip", [0.3, 3.0])
@pytest.mark.parametrize("friction", [5.0, 10.0])
def test_large_friction_closes_the_contact(law, slip, friction):
    """Normal and tangential force answer each other by more than they are: still no overlap is left."""
    with pytest.warns(RuntimeWarning, match="several solutions"):
        result = thrown_flat([tc.Plane()], law, friction=friction, slip=slip)
    assert np.abs(result.history["contact_force"][:, 2]).max() > 0.0
    assert result.history["gap_min"].min() >= -1e-9
    assert result.history["static_residual"].max() <= 1e-5


@pytest.mark.parametrize("law", [tc.LinearElastic, tc.NeoHookean])
@pytest.mark.parametrize("rows", [2, 5])
def test_the_residual_sees_an_overlap(law, rows):
    """One sweep leaves overlaps: the force that would undo one is part of the residual."""
    mesh = tc.box_mesh((0.1,) * 3, (4,) * 3)
    body = tc.Body(mesh, rubber(law), velocity=(3.0, 0.0, -1.0), contact="zmin")
    scene = tc.Scene(
        bodies=[body],
        obstacles=[tc.Plane()],
        duration=rows * 1e-4,
        contact=tc.MasslessContact(removal="full", tolerance=1.0, sweeps=1),
        friction=tc.Coulomb(0.9),
    )
    result = simulate(scene, dt=1e-4)
    static, _, _ = problem(scene)
    moved = result.position - mesh.nodes
    _, reference = static.force(moved)
    stiffness = np.diag(static._tangent(moved)).min()
    overlap = -result.history["gap_min"][-1]
    assert overlap > 1e-7
    assert result.history["static_residual"][-1] * reference >= stiffness * overlap


def residual(state):
    """Residual of the row of the present state, without a step."""
    state.advance(0.0, 0.0, 0.0, 0.0, (0.0, 0.0))
    return np.array(arrays.get(state.serial.sums))[columns.SUMS.static_residual]


@pytest.mark.parametrize("friction", [None, 0.5])
def test_the_residual_sees_balanced_states_that_break_contact_laws(friction):
    """Every node stays in balance; overlaps, forces across a gap and friction outside its cone count on their own."""
    mesh, depth, across = tc.box_mesh((0.1,) * 3, (3,) * 3), 1e-6, 3e-6
    contact = tc.MasslessContact(removal="full", tolerance=1e-12, sweeps=400)
    scene = tc.Scene(
        bodies=[tc.Body(mesh, rubber(), contact="zmin")],
        obstacles=[tc.Plane()],
        duration=1.0,
        contact=contact,
        friction=None if friction is None else tc.Coulomb(friction),
    )
    start = np.zeros((mesh.node_count, 3))
    start[mesh.nodes[:, 2] > 0.0] = (across, 0.0, -1e-4)
    _, state = solved(scene, start)
    static, _, _ = problem(scene)
    stiffness = np.diag(static._tangent(start)).min()
    reference = np.array(arrays.get(state.contact.static_solve.stats))[static_control.F_REF]
    placed = np.array(arrays.get(state.u)).reshape(-1, 3)
    assert residual(state) <= 1e-9
    for shift in (-depth, depth):  # a translation changes no force: an overlap, and forces across a gap
        arrays.set_values(state.u, placed + np.array([0.0, 0.0, shift]))
        assert residual(state) * reference >= stiffness * depth > 1e-4 * reference
    arrays.set_values(state.u, placed)
    assert residual(state) <= 1e-9
    if friction is not None:
        rows = state.contact.friction.rows
        values = np.array(arrays.get(rows.values)).reshape(-1, rows.places.width)
        first, coefficient = rows.places.traction, 1e-3
        sticking = np.linalg.norm(values[:, first : first + 3], axis=1)
        values[:, rows.places.coefficient] = coefficient  # the forces stay, their bound does not
        arrays.set_values(rows.values, values)
        excess = (sticking - coefficient * values[:, rows.places.pressing]).max()
        assert residual(state) * reference >= 0.99 * excess > 1e-4 * reference


def test_the_residual_sees_overlaps_and_gaps_at_two_walls():
    """A cube pressed into the edge of two walls: a move along a normal breaks the law of that wall."""
    mesh, depth = tc.box_mesh((0.1,) * 3, (3,) * 3), 1e-6
    scene = tc.Scene(
        bodies=[tc.Body(mesh, rubber(), contact=["zmin", "xmin"])],
        obstacles=[tc.Plane(), tc.Plane(normal=(1.0, 0.0, 0.0))],
        duration=1.0,
        contact=tc.MasslessContact(removal="full", tolerance=1e-12, sweeps=400),
    )
    start = np.zeros((mesh.node_count, 3))
    start[(mesh.nodes[:, 2] > 0.0) & (mesh.nodes[:, 0] > 0.0)] = (-1e-4, 0.0, -1e-4)
    _, state = solved(scene, start)
    static, _, _ = problem(scene)
    reference = np.array(arrays.get(state.contact.static_solve.stats))[static_control.F_REF]
    placed = np.array(arrays.get(state.u)).reshape(-1, 3)
    wanted = np.diag(static._tangent(start)).min() * depth / reference
    assert wanted > 1e-4
    for shift in ((0, 0, -1), (0, 0, 1), (-1, 0, 0), (1, 0, 0), (-1, 0, -1)):
        arrays.set_values(state.u, placed + depth * np.array(shift, dtype=float))
        assert residual(state) >= wanted, shift
    arrays.set_values(state.u, placed + depth * np.array((0.0, 1.0, 0.0)))
    assert residual(state) <= 1e-9


def lifted(kind, law, removal, ratio, solver="auto"):
    """A body whose cells are `ratio` times taller than wide, standing on one end, thrown at the floor."""
    body = tc.Body(
        tc.box_mesh((0.04, 0.04, 0.03 * ratio), (4, 4, 3), kind),
        rubber(law),
        velocity=(0.0, 0.0, -1.0),
        contact="zmin",
    )
    return simulate(
        tc.Scene(
            bodies=[body],
            obstacles=[tc.Plane()],
            duration=3.0 * 0.03 * ratio / body.material.wave_speed,
            contact=tc.MasslessContact(removal=removal, solver=solver),
        )
    )


@pytest.mark.parametrize("ratio", [30, 60, 100])
@pytest.mark.parametrize("removal", ["full", "normal"])
@pytest.mark.parametrize(
    ("kind", "law"), [("hex8", tc.LinearElastic), ("hex8", tc.NeoHookean), ("tet4", tc.LinearElastic)]
)
def test_tall_cells_lift_off(kind, law, removal, ratio):
    """The nodes of the floor then have a mode as soft as a cell is tall beside stiff ones."""
    result = lifted(kind, law, removal, ratio, "gauss-seidel")
    force = result.history["contact_force"][:, 2]
    assert force.max() > 0.0
    assert force[-1] == 0.0
    assert result.history["gap_min"][-1] > 0.0
    assert result.history["sweeps"].max() > 60, "plain sweeps would not do"


@pytest.mark.parametrize(("kind", "law", "ratio"), [("hex8", tc.LinearElastic, 60), ("hex8", tc.NeoHookean, 100)])
def test_tall_cells_lift_off_after_few_products(kind, law, ratio):
    """The solver that is chosen there needs no more of them than for cubes, and the force is that of the sweeps."""
    result, sweeps = lifted(kind, law, "full", ratio), lifted(kind, law, "full", ratio, "gauss-seidel")
    force = result.history["contact_force"][:, 2]
    assert force[-1] == 0.0
    assert result.history["gap_min"][-1] > 0.0
    assert result.history["sweeps"].max() <= 60
    assert np.abs(force - sweeps.history["contact_force"][:, 2]).max() <= 1e-4 * force.max()


def falling(obstacles, removal="auto", speed=1.0):
    """A linear cube thrown at the plane z = 0 from 1e-4 m above."""
    mesh = tc.box_mesh((0.1,) * 3, (4,) * 3, origin=(0.0, 0.0, 1e-4))
    body = tc.Body(mesh, rubber(), velocity=(0.0, 0.0, -speed), contact=["xmax", "zmin"])
    return tc.Scene([body], obstacles, 1e-3, contact=tc.MasslessContact(removal=removal))


def test_a_wall_out_of_reach_does_not_change_which_mass_is_removed():
    """One floor: normal removal suits faces that look at it; a side wall within reach asks for full removal."""
    side = tc.Plane(point=(50.0, 0.0, 0.0), normal=(-1.0, 0.0, 0.0))
    near = tc.Plane(point=(0.11, 0.0, 0.0), normal=(-1.0, 0.0, 0.0))

    def removal(obstacles):
        scene = falling(obstacles)
        body = scene.bodies[0]
        floor = tc.Body(body.mesh, body.material, velocity=body.velocity, contact="zmin")
        return tc.plan(tc.Scene([floor], obstacles, scene.duration)).bodies[0].contact.removal

    assert removal([tc.Plane()]) == removal([tc.Plane(), side]) == removal([side, tc.Plane()]) == "normal"
    assert removal([tc.Plane(), near]) == "full"
    turning = tc.Plane(point=(50.0, 0.0, 0.0), normal=(-1.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, 100.0))
    assert removal([tc.Plane(), turning]) == "full", "its rim comes near"


@pytest.mark.parametrize("kind", ["many rows a launch", "frames"])
def test_a_body_that_comes_to_a_wall_out_of_reach_stops_with_the_remedy(kind, monkeypatch, tmp_path):
    """The scene starts at rest far from the side wall; another run has thrown the body at it, unknown to planning."""
    side = tc.Plane(point=(3.0, 0.0, 0.0), normal=(-1.0, 0.0, 0.0))
    scene = falling([tc.Plane(point=(0.0, 0.0, -0.01)), side], "normal", 0.0)
    start, along = simulate(scene), np.array([4e3, 0.0, 0.0])
    thrown = dataclasses.replace(start, velocity=start.velocity + along)
    options = {"out": tmp_path / "out", "frames": 9} if kind == "frames" else {}
    monkeypatch.setattr(tc.Scene, "starting", lambda scene, number: scene.bodies[number])
    result = tc.simulate(scene, initial=thrown, **options)
    assert result.reason == "missed-contact"
    assert "obstacle-1" in result.message
    assert "removal='full'" in result.message
    assert abs(result.time - 2.9 / 4e3) <= result.dt, "the last row before it"
    away = simulate(scene, initial=dataclasses.replace(start, velocity=start.velocity - along))
    assert away.ok


def test_a_body_that_another_run_has_thrown_at_a_far_wall_meets_it():
    """The wall is within reach of the velocity at which the body starts, whatever the scene names."""
    side = tc.Plane(point=(1.0, 0.0, 0.0), normal=(-1.0, 0.0, 0.0), name="side")
    scene = falling([tc.Plane(point=(0.0, 0.0, -0.01)), side], "normal", 0.0)
    start = simulate(scene)
    thrown = dataclasses.replace(start, velocity=start.velocity + np.array([30.0, 0.0, 0.0]))
    with pytest.warns(tc.RemovalWarning, match="along other directions"):
        result = tc.simulate(dataclasses.replace(scene, duration=0.04), initial=thrown)
    assert result.ok
    assert -30.0 < result.velocity[:, 0].mean() < -20.0
