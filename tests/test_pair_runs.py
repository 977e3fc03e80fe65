"""Impacts of two and more bodies: exact solutions of bars, conservation, invariance, the stable step."""

from dataclasses import replace

import numpy as np
import pytest
from oracle import meshes
from pair_scenes import OBLIQUE, bar, mirror_images, oblique_cubes, soft, total, touches, touching, variation

import tcontact as tc

SPEED = 0.02


def two_bars(cells=(20, 30), across=(2, 3), removal="auto", **options):
    """Two equal bars that meet at SPEED; gap 0.002."""
    bodies = [
        bar(cells[0], across[0], 0.002, -SPEED, "up", contact="zmin", **options),
        bar(cells[1], across[1], -1.0, 0.0, "low", contact="zmax", **options),
    ]
    return tc.Scene(bodies, duration=3.4, contact=tc.MasslessContact(removal))


@pytest.mark.parametrize(("cells", "rms", "energy"), [((20, 30), 5e-3, 5e-3), ((40, 60), 5e-4, 2.5e-3)])
def test_two_equal_bars_press_with_half_the_impact_pressure_and_exchange_their_speed(cells, rms, energy):
    """rho c V / 2 for as long as the wave runs to the end and back; then the bars part with exchanged velocities."""
    scene = two_bars(cells)
    assert tc.plan(scene).bodies[0].contact.removal == "normal"
    result = tc.simulate(scene)
    assert result.ok
    time, force = result.history["time"], result.pair_force["up-low"][:, 2] / (0.5 * SPEED * 0.01)
    plateau = force[(time > 0.5) & (time < 1.7)]
    assert np.sqrt(((plateau - 1.0) ** 2).mean()) <= rms
    assert variation(force) <= 1.5
    assert touches(force) == 1
    assert np.abs(result.history["energy_error"]).max() <= energy
    assert total(result, "momentum") <= 1e-11
    assert abs(np.trapezoid(force, time) - 2.0) <= 2.0e-2
    up, low = np.split(result.velocity[:, 2], [scene.bodies[0].mesh.node_count])
    assert abs(up.mean()) <= 0.02 * SPEED
    assert abs(low.mean() + SPEED) <= 0.02 * SPEED


def test_three_bars_in_a_row_pass_the_speed_on():
    """The bar in the middle is slave of one neighbour and master or slave of the other."""
    bodies = [bar(12, 1, 2.004, -SPEED, "a"), bar(18, 2, 1.002, 0.0, "b"), bar(15, 1, 0.0, 0.0, "c")]
    for pairs in ("auto", [tc.Pair("a", "b", slave="a"), tc.Pair("b", "c", slave="b")]):
        scene = tc.Scene(bodies, duration=5.2, pairs=pairs)
        result = tc.simulate(scene)
        assert result.ok
        ends = np.cumsum([body.mesh.node_count for body in bodies])
        speeds = [part[:, 2].mean() / -SPEED for part in np.split(result.velocity, ends[:-1])]
        assert np.abs(np.array(speeds) - (0.0, 0.0, 1.0)).max() <= 0.04
        assert np.abs(result.history["energy_error"]).max() <= 8e-3
        assert total(result, "momentum") <= 1e-11


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
def test_oblique_cubes_keep_energy_and_momentum(kind):
    """Both surfaces end inside faces of the other."""
    result = tc.simulate(oblique_cubes(kind=kind))
    assert result.ok
    force = result.pair_force["up-low"]
    assert np.abs(result.history["energy_error"]).max() <= 4e-3
    assert total(result, "momentum") <= 1e-11
    assert total(result, "angular_momentum") <= 2e-3
    assert touches(force[:, 2]) == 1
    assert variation(force[:, 2]) <= 1.2
    assert abs(np.trapezoid(force[:, 2], result.history["time"]) - 0.0389) <= 1e-3


def test_products_of_the_static_solve_stay_few_when_the_softer_body_is_slave():
    for young in (1.0, 10.0, 100.0):
        scene = oblique_cubes(
            young=young, duration=2.0 if young > 1.0 else 3.0, contact=tc.MasslessContact("full", tolerance=1e-4)
        )
        assert scene.bodies[scene.body_pairs[0].slave].name == "low"
        result = tc.simulate(scene)
        products = result.history["solver_products"][touching(result, "up-low")]
        assert products.mean() <= 25
        assert products.max() <= 90


def test_a_run_turned_and_shifted_is_the_same_run():
    turn, offset = meshes.rotation(12), np.array((40.0, -7.0, 3.0))
    scheme = tc.CentralDifference(dt=0.14)
    one, other = (tc.simulate(oblique_cubes(motion=motion), scheme) for motion in (None, (turn, offset)))
    assert one.steps == other.steps
    moved = one.position @ turn.T + offset
    assert np.abs(moved - other.position).max() <= 1e-7
    force = one.pair_force["up-low"] @ turn.T
    assert np.abs(force - other.pair_force["up-low"]).max() <= 1e-5 * np.abs(force).max()


def test_force_and_moment_are_those_on_the_first_body_whichever_is_slave():
    results = [
        tc.simulate(oblique_cubes(pairs=[pair]))
        for pair in (tc.Pair("up", "low", slave="low"), tc.Pair("low", "up", slave="low"))
    ]
    first, second = results
    assert np.abs(first.pair_force["up-low"] + second.pair_force["low-up"]).max() <= 1e-15
    moments = first.pair_moment["up-low"], second.pair_moment["low-up"]  # of slave and master: apart while slipping
    assert np.abs(moments[0] + moments[1]).max() <= 2e-2 * np.abs(moments[0]).max()
    assert np.abs(first.history["contact_force"]).max() <= 1e-14


@pytest.mark.parametrize("young", [1e-3, 1.0, 1e3])
def test_contact_never_shortens_the_stable_step(young):
    """The step of two bodies is that of the stiffer one with its own contact nodes massless or not, at least."""
    scene = oblique_cubes(young=young)
    steps = [tc.simulate(replace(scene, bodies=[body], duration=1e-3, pairs=None)).dt_limit for body in scene.bodies]
    together = tc.simulate(replace(scene, duration=1e-3)).dt_limit
    assert together >= 0.999 * min(steps)


def test_a_body_against_its_mirror_image_is_a_body_against_a_plane():
    one, other = mirror_images()
    contact, scheme = tc.MasslessContact("full", tolerance=1e-8), tc.CentralDifference(dt=0.1)
    alone = tc.simulate(tc.Scene([one], [tc.Plane()], 3.0, contact=contact), scheme)
    both = tc.simulate(tc.Scene([one, other], duration=3.0, contact=contact), scheme)
    force = alone.history["contact_force"][:, 2]
    assert np.abs(both.pair_force["up-low"][:, 2] - force).max() <= 1e-5 * force.max()
    assert force.max() > 0.0


def test_bodies_out_of_reach_have_no_rows_and_the_bits_of_bodies_without_pairs():
    scene = oblique_cubes(duration=1.0)
    low = scene.bodies[1]
    away = replace(scene, bodies=[scene.bodies[0], replace(low, mesh=low.mesh.translated((0, 0, -9.0)))])
    assert away.body_pairs == ()
    with pytest.warns(tc.OverlapWarning):
        alone = replace(away, pairs=None)
    assert tc.simulate(away).position.tobytes() == tc.simulate(alone).position.tobytes()


def test_a_pair_that_never_meets_moves_freely():
    """An empty coupling is no error; the bodies fly on."""
    scene = oblique_cubes(duration=0.03, pairs=[tc.Pair("up", "low")])
    result = tc.simulate(scene, tc.CentralDifference(dt=0.01))
    assert result.ok
    assert not result.history["pair_pressed:up-low"].any()
    moved = result.position[:125] - scene.bodies[0].mesh.nodes
    assert np.abs(moved - result.time * OBLIQUE).max() <= 1e-14


def test_a_body_of_flat_cells_is_met_where_it_lies():
    """Rows exist within a reach that thin cells make small; they are built before a body has gone through it."""
    low = tc.box_mesh((1, 1, 0.15), (4, 4, 10), origin=(0, 0, -0.15))
    up = tc.box_mesh((1, 1, 0.5), (3, 3, 3), origin=(0.1, 0.05, 0.03))
    bodies = [
        tc.Body(up, soft(), (0, 0, -0.1), contact="zmin", name="up"),
        tc.Body(low, soft(), contact="zmax", name="low"),
    ]
    contact = tc.MasslessContact("full")
    result = tc.simulate(tc.Scene(bodies, duration=1.0, pairs=[tc.Pair("up", "low")], contact=contact))
    assert result.ok
    time, force = result.history["time"], result.pair_force["up-low"][:, 2]
    assert abs(time[np.argmax(force > 0.0)] - 0.3) <= 0.02
    assert result.history["pair_gap_min:up-low"].min() >= -1e-6
    assert np.abs(result.history["energy_error"]).max() <= 2e-3


def test_a_stack_on_a_floor_settles_with_its_weight_on_the_floor_and_between_the_blocks():
    gravity, bodies = 0.02, []
    for number in range(3):
        mesh = tc.box_mesh((1, 1, 0.5), (2 + number % 2,) * 2 + (2,), origin=(-0.5, -0.5, 0.501 * number + 0.001))
        mesh = mesh.rotated(((0, 0, 1), np.radians(7.0 * number)))
        bodies.append(tc.Body(mesh, soft(), contact=("zmin", "zmax"), name=f"b{number}"))
    pairs = [tc.Pair("b0", "b1"), tc.Pair("b1", "b2")]
    scene = tc.Scene(bodies, [tc.Plane()], 60.0, gravity=(0, 0, -gravity), damping=tc.MassDamping(0.8), pairs=pairs)
    result = tc.simulate(scene)
    assert result.ok
    assert abs(result.history["contact_force"][-1, 2] - 1.5 * gravity) <= 1e-3 * 1.5 * gravity
    assert abs(result.pair_force["b0-b1"][-1, 2] + 1.0 * gravity) <= 1e-3 * gravity
    assert abs(result.pair_force["b1-b2"][-1, 2] + 0.5 * gravity) <= 1e-3 * gravity
    assert min(result.history[f"pair_gap_min:{pair.name}"][-1] for pair in scene.body_pairs) >= -1e-3 * 0.3


def test_a_body_whose_contact_face_is_held_is_master():
    scene = oblique_cubes()
    held = replace(scene.bodies[1], supports=[tc.Support("zmax", "xyz")])
    scene = replace(scene, bodies=[scene.bodies[0], held])
    assert scene.body_pairs[0].slave == 0
    result = tc.simulate(scene)
    assert result.ok
    assert result.pair_force["up-low"][:, 2].max() > 0.0
    assert np.abs(result.history["contact_force"]).max() <= 1e-14
    change = result.history["momentum"] - result.history["momentum"][0]
    assert np.abs(change - result.history["support_impulse"]).max() <= 1e-10
    assert result.history["pair_gap_min:up-low"].min() > -1e-4


@pytest.mark.parametrize("formulation", ["reduced", "mean-dilatation"])
def test_formulations_of_hexahedra(formulation):
    scene = oblique_cubes()
    scene = replace(scene, bodies=[replace(body, formulation=formulation) for body in scene.bodies])
    result = tc.simulate(scene)
    assert result.ok
    assert np.abs(result.history["energy_error"]).max() <= 4e-3
    assert total(result, "momentum") <= 1e-11


def test_damping_and_viscosity_keep_the_balance():
    scene = replace(oblique_cubes(kind="tet4"), damping=tc.MassDamping(0.2), viscosity=tc.BulkViscosity())
    result = tc.simulate(scene)
    assert result.ok
    assert np.abs(result.history["energy_error"]).max() <= 4e-3


def rings(initial_gap, inner=16, outer=24, thickness=0.2, kind="hex8"):
    """A ring that spins inside another one that it fits into but for the facets."""
    sizes = (0.5, 1.0, thickness, inner, kind), (1.0, 1.5, thickness, outer, kind)
    meshes = [tc.ring_mesh(*size, layers=1, start=start) for size, start in zip(sizes, (-0.1, 0.0), strict=True)]
    spin = np.array((0.0, 0.0, 0.02))
    bodies = [
        tc.Body(meshes[0], soft(), lambda nodes: np.cross(spin, nodes), "outer", name="inner"),
        tc.Body(meshes[1], soft(), contact="inner", name="outer"),
    ]
    pairs = [tc.Pair("inner", "outer", slave="inner", initial_gap=initial_gap)]
    return tc.Scene(bodies, duration=4.0, pairs=pairs, contact=tc.MasslessContact("full"))


def test_facets_of_fitting_rings_touch_all_around_if_their_gaps_count_as_closed():
    """As meshed, facets of a coarse ring in a fine one leave a gap of the size of the sagitta."""
    closed, meshed = (tc.simulate(rings(gap)) for gap in ("closed", "as-meshed"))
    assert closed.history["pair_pressed:inner-outer"].max() == 32
    assert not meshed.history["pair_pressed:inner-outer"].any()
    assert meshed.history["pair_gap_min:inner-outer"][0] == pytest.approx(1.0 - np.cos(np.pi / 16) - 0.013, abs=3e-3)
    for result in (closed, meshed):
        spin = result.history["angular_momentum"][:, 2]
        assert np.abs(spin / spin[0] - 1.0).max() <= 3e-3


@pytest.mark.parametrize(("kind", "thickness"), [("hex8", 0.05), ("tet4", 0.2)])
def test_gaps_of_facets_count_as_closed_whatever_the_shape_of_the_faces(kind, thickness):
    """The sagitta follows from the length of the facets around the ring, not from the area of their faces."""
    result = tc.simulate(replace(rings("closed", 24, 72, thickness, kind), duration=0.5))
    assert result.history["pair_gap_min:inner-outer"][0] == pytest.approx(0.0, abs=1e-12)


def test_rings_that_overlap_by_their_facets_are_refused_with_the_remedy():
    with pytest.raises(tc.InputError, match="initial_gap='closed'"):
        tc.simulate(rings("as-meshed", 24, 24))
    assert tc.simulate(rings("closed", 24, 24)).ok


EDGES = {"edge at 20 degrees": [((1, 0, 0), 20.0)], "corner": [((1, 0, 0), 45.0), ((0, 1, 0), 35.26)]}


@pytest.mark.parametrize(("name", "bound"), [("edge at 20 degrees", 1e-2), ("corner", 2e-2)])
def test_sharp_edges_and_corners_of_the_slave_land_on_a_flat_master(name, bound):
    """With the slave's mean normal at its edge the energy would grow by 39 %."""
    up = tc.box_mesh((1, 1, 1), (4, 4, 4), origin=(-0.5, -0.5, -0.5))
    for axis, degrees in EDGES[name]:
        up = up.rotated((axis, np.radians(degrees)))
    up = up.translated((0.03, 0.02, 0.002 - up.nodes[:, 2].min()))
    low = tc.box_mesh((1, 1, 1), (5, 5, 5), origin=(-0.5, -0.5, -1.0)).rotated(((0, 0, 1), np.radians(11.0)))
    bodies = [
        tc.Body(up, soft(), (0, 0, -0.1), contact="auto", name="up"),
        tc.Body(low, soft(), contact="zmax", name="low"),
    ]
    scene = tc.Scene(bodies, duration=4.0, pairs=[tc.Pair("up", "low", slave="up")], contact=tc.MasslessContact("full"))
    result = tc.simulate(scene)
    assert result.ok
    assert np.abs(result.history["energy_error"]).max() <= bound
    assert total(result, "momentum") <= 1e-11
    assert result.pair_force["up-low"][:, 2].max() > 0.0


def test_bodies_of_two_kinds_of_cells_and_two_materials_touch():
    """The lower cube has prisms and hexes, the upper one a stiff and a soft half."""
    scene = oblique_cubes(duration=2.0)
    up, low = scene.bodies
    middle = up.mesh.cell_centres()[:, 0] < up.mesh.cell_centres()[:, 0].mean()
    halves = up.mesh.with_sets(cell_sets={"left": np.flatnonzero(middle), "right": np.flatnonzero(~middle)})
    up = replace(up, mesh=halves, material={"left": soft(young=2.0), "right": soft(tc.LinearElastic)})
    columns = low.mesh.cell_centres()[:, 0] < 0.5
    cells, hexes = low.mesh.cells[columns], low.mesh.cells[~columns]
    prisms = np.concatenate([cells[:, [0, 1, 3, 4, 5, 7]], cells[:, [1, 2, 3, 5, 6, 7]]])
    mixed = tc.Mesh(low.mesh.nodes, {"hex8": hexes, "wedge6": prisms},
                    node_sets={"top": np.flatnonzero(low.mesh.nodes[:, 2] > -1e-9)})  # fmt: skip
    low = replace(low, mesh=mixed, contact="top")
    result = tc.simulate(replace(scene, bodies=[up, low]))
    assert result.ok
    assert result.pair_force["up-low"][:, 2].max() > 0.01
    assert np.abs(result.history["energy_error"]).max() <= 5e-3
    assert total(result, "momentum") <= 1e-11


def test_a_moving_wall_under_a_pair_has_its_own_load_and_work():
    """The wall pushes the lower cube up against the upper one; the force of the pair is not a load of the wall."""
    scene = oblique_cubes(kind="tet4")
    low = replace(scene.bodies[1], contact=("zmax", "zmin"))
    wall = tc.Plane((0.0, 0.0, -1.05), velocity=(0.0, 0.0, 0.05), name="wall")
    scene = replace(scene, bodies=[scene.bodies[0], low], obstacles=[wall])
    result = tc.simulate(scene)
    assert result.ok
    apart = result.history["time"] < 0.9  # the wall is not there yet
    assert result.pair_force["up-low"][apart].any()
    assert not result.obstacle_force["wall"][apart].any()
    assert -result.obstacle_force["wall"][:, 2].min() > 0.01
    assert np.abs(result.obstacle_force["wall"] + result.history["contact_force"]).max() <= 1e-14
    assert np.abs(result.history["energy_error"]).max() <= 1e-2


def test_a_run_goes_on_from_the_end_of_another_one_that_ended_in_contact():
    """The static solve leaves an overlap that a mesh would be refused for."""
    scheme = tc.CentralDifference(dt=0.14)
    half = oblique_cubes(duration=1.4)
    first = tc.simulate(half, scheme)
    assert first.pair_force["up-low"][-1].any()
    second = tc.simulate(half, scheme, initial=first)
    whole = tc.simulate(oblique_cubes(duration=2.8), scheme)
    assert second.ok
    assert np.abs(second.position - whole.position).max() <= 2e-3 * 0.14
    back = tc.simulate(half, scheme, initial=first.reversed())
    assert np.abs(back.position[:125] - half.bodies[0].mesh.nodes).max() <= 2e-2
