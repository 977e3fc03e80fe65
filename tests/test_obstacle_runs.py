"""Runs do not depend on how a wall is described, nor on who moves."""

import numpy as np
import pytest

import tcontact as tc

GAP = 1e-4
BLOCK = tc.Box((0.05, 0.05, -0.5 - GAP), (2.0, 2.0, 1.0))
SAMPLED = tc.Sdf(lambda x: x[:, 2] + GAP, origin=(-0.1, -0.1, -0.1), spacing=0.05, nodes=(7, 7, 7))


def dropped(wall, speed=2.0):
    """History of a cube that hits a wall."""
    cube = tc.Body(
        tc.box_mesh((0.1, 0.1, 0.1), (3, 3, 3)), tc.NeoHookean(1e7, 0.3, 1000.0), (0, 0, -speed), contact="zmin"
    )
    scene = tc.Scene(cube, wall, duration=1e-3, contact=tc.MasslessContact(removal="full"))
    result = tc.simulate(scene, scheme=tc.CentralDifference(dt=2e-5))
    assert result.ok
    return result.history


@pytest.fixture(scope="module")
def plane():
    return dropped(tc.Plane((0, 0, -GAP)))


@pytest.mark.parametrize("wall", [BLOCK, SAMPLED], ids=["box", "sdf"])
@pytest.mark.slow  # a kernel for each shape is compiled
def test_a_wall_is_a_wall_whatever_its_description(plane, wall):
    history = dropped(wall)
    largest = plane["contact_force"].max()
    assert largest > 1e3
    assert np.abs(history["contact_force"] - plane["contact_force"]).max() < 1e-9 * largest
    np.testing.assert_allclose(history["gap_min"], plane["gap_min"], atol=1e-12)


@pytest.mark.parametrize(
    "velocity", [(0.0, 0.0, 2.0), lambda t: np.array([0.0, 0.0, 2.0])], ids=["constant", "function of time"]
)
def test_a_moving_block_that_hits_a_body_is_a_body_that_hits_it(plane, velocity):
    moving = tc.Box(BLOCK.center, BLOCK.size, velocity=velocity)
    history = dropped(moving, speed=0.0)
    largest = plane["contact_force"].max()
    assert np.abs(history["contact_force"] - plane["contact_force"]).max() < 1e-9 * largest


# edges and seams of blocks

LINEAR = tc.LinearElastic(young=1e6, poisson=0.0, density=1000.0)  # it does not spread over an edge
MODELS = {
    "full": tc.MasslessContact(removal="full"),
    "normal": tc.MasslessContact(removal="normal"),
    "soft": tc.MasslessContact(penalty=1e9),
    "penalty": tc.PenaltyContact(1e8),
    "impulse": tc.ImpulseContact(),
}


def landed(floor, contact, duration=0.02, **options):
    """A cube thrown flat at what lies 1 mm below it."""
    cube = tc.Body(tc.box_mesh((1.0, 1.0, 1.0), (3, 3, 3)), LINEAR, (0.0, 0.0, -1.0), contact="zmin")
    result = tc.simulate(tc.Scene([cube], [floor], duration, contact=contact), tc.CentralDifference(cfl=0.3), **options)
    assert result.ok, result.message
    return result


def footing(margin):
    """A block under the cube, larger by a margin [m] on every side."""
    return tc.Box((0.5, 0.5, -0.501), (1.0 + 2.0 * margin, 1.0 + 2.0 * margin, 1.0), name="footing")


@pytest.mark.parametrize("name", MODELS)
def test_nodes_that_land_beside_an_edge_are_held_by_the_face_on_which_they_land(name):
    """However near the edge is to the path of a step; nearer than the face, the side would push them out and down."""
    known = landed(footing(0.5), MODELS[name])
    force = known.history["contact_force"]
    assert force[:, 2].max() > 1e4
    if name in ("full", "normal"):
        plane = landed(tc.Plane((0.0, 0.0, -1e-3)), MODELS[name])
        assert np.abs(plane.history["contact_force"] - force).max() < 1e-9 * force.max()
    for margin in (0.0, 1e-12, 1e-4, 1e-3):
        found = landed(footing(margin), MODELS[name])
        assert np.abs(found.history["contact_force"] - force).max() < 1e-11 * force.max()
        assert np.abs(found.position - known.position).max() < 1e-13


def test_a_turned_and_shifted_block_has_the_same_edges():
    from oracle import meshes

    turn = meshes.rotation(3)
    block = tc.box_mesh((1.0, 1.0, 1.0), (3, 3, 3))
    mesh = tc.Mesh(block.nodes @ turn.T, block.cells, "hex8", face_sets=block.face_sets)
    cube = tc.Body(mesh, LINEAR, tuple(-turn[:, 2]), contact="zmin")
    floors = [
        tc.Plane(tuple(-1e-3 * turn[:, 2]), tuple(turn[:, 2])),
        tc.Box(tuple(turn @ (0.5, 0.5, -0.501)), (1.0 + 1e-5, 1.0 + 1e-5, 1.0), turn.T),
    ]
    scenes = [tc.Scene([cube], [floor], 0.02, contact=MODELS["full"]) for floor in floors]
    forces = [tc.simulate(scene, tc.CentralDifference(cfl=0.3)).history["contact_force"] for scene in scenes]
    assert np.abs(forces[1] - forces[0]).max() < 1e-12 * np.abs(forces[0]).max()


def test_a_run_that_goes_on_knows_the_faces(tmp_path, monkeypatch):
    """It stops while the cube stands on the edges."""
    import stopped_runs

    cube = tc.Body(tc.box_mesh((1.0, 1.0, 1.0), (3, 3, 3)), LINEAR, (0.0, 0.0, -1.0), contact="zmin")
    scene = tc.Scene([cube], [footing(0.0)], 0.02, contact=MODELS["penalty"])
    scheme = tc.CentralDifference(cfl=0.5)
    whole, copies = stopped_runs.copied(monkeypatch, tmp_path, scene, scheme, 1)
    pressed = np.flatnonzero(whole.history["contact_force"][:, 2] > 0.0)
    assert set(pressed) & set(copies)
    for path in copies.values():
        stopped_runs.same(whole, tc.resume(path, scene, scheme))


@pytest.mark.parametrize("name", ["full", "normal", "penalty"])
def test_a_cube_that_begins_on_the_edges_stands_on_them(name):
    """Its outer nodes bear their share of the weight, as on a plane."""
    forces = []
    for floor in (tc.Plane(), tc.Box((0.5, 0.5, -0.5), (1.0, 1.0, 1.0))):
        cube = tc.Body(tc.box_mesh((1.0, 1.0, 1.0), (3, 3, 3)), LINEAR, contact="zmin")
        parts = {"gravity": (0.0, 0.0, -10.0), "damping": tc.MassDamping(40.0)}
        result = tc.simulate(
            tc.Scene([cube], [floor], 0.5, contact=MODELS[name], **parts), tc.CentralDifference(cfl=0.5)
        )
        assert result.ok
        forces.append(result.contact_node_force)
    assert abs(forces[0][:, 2].sum() - 1e4) < 10.0
    assert np.abs(forces[1] - forces[0]).max() < 1e-3 * forces[0].max()


def test_without_blocks_a_row_keeps_no_face():
    from tcontact.kernels.language.bundles import ContactOptions

    plane, block = (
        ContactOptions("massless", 3, shapes=shapes).row_places for shapes in (("plane",), ("box", "plane"))
    )
    assert (plane.face, plane.width) == (-1, block.width - 1)


def floor_of(*blocks):
    """Blocks with their tops at z = 0: middle along x, half length."""
    return [
        tc.Box((middle, 0.0, -0.5), (2.0 * half, 2.0, 1.0), name=f"block {number}")
        for number, (middle, half) in enumerate(blocks)
    ]


FLOORS = {
    "flush": floor_of((-0.5, 0.5), (0.5, 0.5)),
    "overlapping": floor_of((-0.45, 0.55), (0.5, 0.5)),
    "in a plane": [tc.Plane(name="ground"), *floor_of((0.5, 0.5))],
}


@pytest.mark.parametrize("name", FLOORS)
def test_a_body_slides_over_the_seam_of_blocks_of_one_height(name):
    """Their sides are covered there: nothing holds what slides, at any speed and phase of the steps."""
    for removal, speed, height in (
        ("full", 2.0, 1e-3),
        ("full", 1.3, 4e-3),
        ("normal", 2.6, 2e-3),
        ("normal", 1.0, 1e-3),
    ):
        mesh = tc.box_mesh((0.5, 0.5, 0.25), (4, 4, 2), origin=(-0.7, -0.25, height))
        body = tc.Body(mesh, tc.NeoHookean(1e6, 0.3, 1000.0), velocity=(speed, 0.0, -1.0), contact="zmin")
        options = {"gravity": (0.0, 0.0, -20.0), "contact": tc.MasslessContact(removal=removal)}
        result = tc.simulate(tc.Scene([body], FLOORS[name], 0.3, **options))
        assert result.ok
        momentum = result.history["momentum"][:, 0]
        assert np.abs(momentum - momentum[0]).max() < 1e-9 * momentum[0]


def test_a_wall_that_stands_on_the_floor_stops_what_slides_into_it():
    """Its lower face is level with the floor, and faces it."""
    mesh = tc.box_mesh((0.5, 0.5, 0.5), (3, 3, 3), origin=(-0.7, -0.25, 0.0))
    body = tc.Body(mesh, tc.NeoHookean(1e6, 0.3, 1000.0), velocity=(2.0, 0.0, 0.0), contact=["zmin", "xmax"])
    wall = tc.Box((0.5, 0.0, 0.5), (1.0, 2.0, 1.0), name="wall")
    scene = tc.Scene([body], [tc.Plane(), wall], 0.4, gravity=(0.0, 0.0, -10.0), contact=MODELS["full"])
    result = tc.simulate(scene)
    assert result.ok
    assert result.position[:, 0].max() < 0.0
    assert result.history["momentum"][-1, 0] < -0.3 * result.history["momentum"][0, 0]
    assert result.history["energy_error"].max() < 0.05
