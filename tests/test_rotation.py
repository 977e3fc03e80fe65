"""What turns under normal removal: the choice of `auto` by the initial spin, and named warnings of the rest."""

import warnings

import numpy as np
import pytest
from oracle import meshes
from scenes import block, material, wall

import tcontact as tc
from tcontact.planning.rotation import angle, rotation, spin

DURATION = 0.03
NORMAL = np.array([0.0, 0.0, 1.0])


def spinning(rate, kind="hex8", cells=3, law="neo", turn=None, flight=(0.0, 0.0, 0.0), **options):
    """A block that spins at `rate` [3] about its centre of mass and flies."""
    turn = np.eye(3) if turn is None else turn
    mesh = block(kind, cells, (0.2, 0.2, 0.2), turn=turn, shift=(0.3, -2.0, 5.0), shake=0.0)
    centre = mesh.nodes.mean(axis=0)
    return tc.Body(
        mesh,
        material(law, poisson=options.pop("poisson", 0.3)),
        velocity=lambda x: np.cross(rate, x - centre) + flight,
        contact="zmin",
        **options,
    )


def scene(body, removal="auto", normal=NORMAL, gap=0.5, duration=DURATION, **motion):
    """The body over a plane far below."""
    plane = wall(body.mesh, normal, gap)
    plane = tc.Plane(plane.point, plane.normal, **motion)
    return tc.Scene([body], [plane], duration, contact=tc.MasslessContact(removal=removal))


def removal_of(body, **options):
    return tc.plan(scene(body, **options)).bodies[0].contact.removal


def run(scene, **options):
    """The result and its warnings of rotation."""
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        result = tc.simulate(scene, **options)
    return result, [str(one.message) for one in seen if one.category is tc.RotationWarning]


def lost(result):
    """Largest change of the angular momentum, relative."""
    momentum = result.history["angular_momentum"]
    return np.linalg.norm(momentum - momentum[0], axis=1).max() / np.linalg.norm(momentum[0])


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_the_spin_of_a_rigid_motion_is_found(kind):
    rate = np.array([3.0, -2.0, 7.0])
    body = spinning(rate, kind, turn=meshes.rotation(3), flight=(100.0, -50.0, 9.0))
    assert spin(body, body.initial_velocity, body.initial_nodes) == pytest.approx(rate, rel=1e-9)
    still = spinning(0.0 * rate, kind, flight=(1e3, 0.0, 0.0))
    assert not spin(still, still.initial_velocity, still.initial_nodes).any()


def test_the_spin_of_any_motion_carries_its_angular_momentum():
    """I w = L: the rigid rotation has the angular momentum of the field, by hand with the lumped masses of a box."""
    mesh = tc.box_mesh((0.2, 0.3, 0.5), (2, 3, 4))
    field = np.random.default_rng(1).normal(size=mesh.nodes.shape)
    body = tc.Body(mesh, material(), velocity=field)
    mass = np.zeros(mesh.node_count)
    np.add.at(mass, mesh.cells, 1.0)  # cells of one size
    arm = mesh.nodes - (mass @ mesh.nodes) / mass.sum()
    found = spin(body, body.initial_velocity, body.initial_nodes)
    rigid = np.cross(found, arm)
    wanted = np.einsum("n,ni->i", mass, np.cross(arm, field - mass @ field / mass.sum()))
    assert np.einsum("n,ni->i", mass, np.cross(arm, rigid)) == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize(("held", "free"), [((), 6), ((("zmin", "z"),), 3), ((("zmin", "z"), ("xmin", "y")), 2)])
def test_the_spin_is_that_of_the_nearest_rigid_motion_that_supports_leave_free(held, free):
    """Least squares by hand: weighted velocities over the rigid motions without motion of the supported components."""
    box, rng = tc.box_mesh((0.2, 0.3, 0.5), (2, 3, 4), "tet4"), np.random.default_rng(4)
    nodes = box.nodes + np.array([3.0, -1.0, 2.0]) + rng.uniform(-0.01, 0.01, box.nodes.shape) * (not held)
    mesh = tc.Mesh(nodes, box.cells, "tet4", face_sets=box.face_sets)
    supports = [tc.Support(name, axes) for name, axes in held]
    body = tc.Body(mesh, material(), velocity=rng.normal(size=nodes.shape), supports=supports)
    mass = rng.uniform(0.5, 2.0, len(nodes))
    arm = nodes - (mass @ nodes) / mass.sum()
    motions = np.stack(
        [*(np.broadcast_to(axis, arm.shape) for axis in np.eye(3)), *(np.cross(e, arm) for e in np.eye(3))]
    )
    _, sizes, ways = np.linalg.svd(np.vstack([motions[:, np.isfinite(body.prescribed)].T, np.zeros((6, 6))]))
    basis = ways[sizes < 1e-9].T
    assert basis.shape[1] == free
    weight = np.sqrt(np.repeat(mass, 3))
    found = np.linalg.lstsq(
        weight[:, None] * (motions.reshape(6, -1).T @ basis), weight * body.initial_velocity.ravel()
    )
    wanted = (basis @ found[0])[3:]
    assert spin(body, body.initial_velocity, nodes, mass) == pytest.approx(wanted, rel=1e-9, abs=1e-9)


def test_supports_and_periodic_sides_hold_a_body():
    rate = np.array([1.0, 2.0, 3.0])
    field = {"velocity": lambda x: np.cross(rate, x)}
    mesh = tc.box_mesh((0.2, 0.2, 0.2), (2, 2, 2), "hex8", (-0.1, -0.1, -0.1))

    def of(**options):
        body = tc.Body(mesh, material(), **(field | options))
        return spin(body, body.initial_velocity, body.initial_nodes)

    assert of() == pytest.approx(rate)
    assert not of(supports=tc.Support("zmax", "xyz")).any()
    one_axis = of(supports=tc.Support("zmax", "z"))  # it may turn about z alone
    assert np.abs(one_axis[:2]).max() < 1e-9
    assert one_axis[2] == pytest.approx(3.0, rel=1e-6)
    about = {"velocity": lambda x: np.cross((0.0, 0.0, 3.0), x)}
    assert of(periodic="z", **about)[2] == pytest.approx(3.0)


@pytest.mark.parametrize("axis", [(1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0), (0.6, 0, -0.8)])
def test_auto_takes_full_removal_of_a_body_that_spins(axis):
    for turns, wanted in ((0.049, "normal"), (0.051, "full"), (4.0, "full")):
        assert removal_of(spinning(np.array(axis) * turns / DURATION)) == wanted
    assert removal_of(spinning(np.zeros(3), flight=(900.0, 3.0, -5.0))) == "normal"
    slow = spinning(np.array(axis) * 0.02 / DURATION)
    assert removal_of(slow, duration=10 * DURATION) == "full"  # the same spin, for longer


def test_auto_keeps_the_angular_momentum_that_normal_removal_loses():
    rate = np.array([4.0 / DURATION, 0.0, 0.0])
    result, told = run(scene(spinning(rate, cells=4)))
    assert lost(result) < 1e-6
    assert not told
    result, told = run(scene(spinning(rate, cells=4), "normal"))
    assert lost(result) > 0.01
    assert len(told) == 2  # before the run, and when it has turned
    assert "starts to turn by 4 rad" in told[0]
    assert "has turned by" in told[1]
    assert all("removal='full'" in text for text in told)
    assert result.warnings == told


def test_a_spin_about_the_normal_is_harmless_and_not_warned_of():
    """The normals of the body stay, and so does its angular momentum, as far as the static solve is exact."""
    normal = meshes.rotation(9)[2]
    body = spinning(4.0 / DURATION * normal, turn=np.linalg.inv(meshes.rotation(9)))
    result, told = run(scene(body, "normal", normal=normal))
    assert lost(result) < 1e-7
    assert not told


def test_a_body_that_starts_to_turn_in_mid_run_is_warned_of():
    """A cube that lands on an edge of its face: normal removal was right at the start."""
    turn = _tilt(np.radians(12.0))
    mesh = block("hex8", 3, (0.1, 0.1, 0.1), turn=turn, shake=0.0)
    body = tc.Body(mesh, material("neo"), velocity=(0.0, 0.0, -20.0), contact="zmin")
    one = tc.Scene([body], [wall(mesh, NORMAL, 1e-3)], 6e-3, contact=tc.MasslessContact(removal="auto"))
    assert tc.plan(one).bodies[0].contact.removal == "normal"
    for pressures in (True, False):  # one row a launch, or many
        result, told = run(one, pressures=pressures)
        assert len(told) == 1
        turned, time = (float(told[0].split(word)[1].split()[0]) for word in ("turned by ", "t = "))
        assert 5.0 <= turned < 15.0
        assert 0.0 < time <= result.time


def _tilt(by):
    return np.array([[np.cos(by), 0.0, np.sin(by)], [0.0, 1.0, 0.0], [-np.sin(by), 0.0, np.cos(by)]])


@pytest.mark.parametrize(
    "rate", [(13.0, 0.0, 0.0), lambda t: (0.0, 1e3 * t, 0.0)], ids=["constant", "function of time"]
)
def test_a_wall_that_turns_under_normal_removal_is_warned_of(rate):
    still = spinning(np.zeros(3))
    result, told = run(scene(still, "normal", angular_velocity=rate, gap=1.0))
    assert result.ok
    assert len(told) == 2
    assert "plane" in told[0]
    assert "degrees under removal='normal'" in told[0]
    turntable = scene(still, "normal", angular_velocity=(0.0, 0.0, 30.0))
    assert not run(turntable)[1]
    assert not run(scene(still, "full", angular_velocity=rate, gap=1.0))[1]


def test_a_start_from_another_run_is_looked_at_as_it_is():
    """The scene names a body at rest, and it goes on from the end of a run in which it spins."""
    rate = np.array([0.0, 2.0 / DURATION, 0.0])
    first, _ = run(scene(spinning(rate), "normal", duration=1e-5))
    _, told = run(scene(spinning(np.zeros(3)), "normal"), initial=first)
    assert "starts to turn" in told[0]


def test_implicit_schemes_are_watched_too():
    rate = np.array([0.0, 1.0 / DURATION, 0.0])
    body = spinning(rate, cells=2)
    _, told = run(scene(body, "normal"), scheme=tc.DiscreteGradient(dt=DURATION / 20))
    assert len(told) == 2


def test_the_rotation_of_a_deformed_body():
    """R of x = R U X with any stretch U, for any weights, and the tilt of an axis."""
    generator = np.random.default_rng(6)
    start, mass = generator.normal(size=(50, 3)), generator.uniform(0.5, 2.0, 50)
    for number in range(5):
        turn = meshes.rotation(number)
        gram = np.einsum("n,ni,nj->ij", mass, start - mass @ start / mass.sum(), start - mass @ start / mass.sum())
        squeezed = start @ np.linalg.inv(gram)  # symmetric with the moment matrix: no rotation of its own
        assert rotation(start, start @ turn.T + 3.0, mass) == pytest.approx(turn, abs=1e-12)
        assert rotation(start, squeezed @ turn.T, mass) == pytest.approx(turn, abs=1e-9)
    assert angle(_tilt(0.3)) == pytest.approx(0.3)
    assert angle(_tilt(0.3), np.array([0.0, 1.0, 0.0])) == pytest.approx(0.0, abs=1e-7)
    assert angle(_tilt(0.3), NORMAL) == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("law", "angle", "supports", "warned"),
    [
        ("linear", 0.5, (), True),
        ("linear", 0.05, (), False),
        ("svk", 0.5, (), False),
        ("linear", 0.5, [tc.Support("xmin", "xyz")], False),
    ],
)
def test_a_body_of_the_linear_law_that_has_turned_is_told(law, angle, supports, warned):
    """At the end of a run: the law holds for small rotations only."""
    body = spinning((0.0, 0.0, angle / 0.01), law=law, supports=supports)
    _result, found = run(tc.Scene([body], duration=0.01))
    assert ["LinearElastic holds for small rotations only" in text for text in found] == [True] * warned
