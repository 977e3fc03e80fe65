"""The explicit step against the oracle row by row, its order, its way back, and continuing a run (METHOD 2)."""

from itertools import pairwise

import numpy as np
import oracle
import pytest
from oracle import meshes
from scenes import bar_speed, block, material, simulate, thrown, twin, twin_planes, wall

import tcontact as tc

HELD = (tc.Support("ymax", "y"), tc.Support("xmax", "xz", velocity=0.01))
COLUMNS = (
    "contact_force", "impulse", "support_force", "momentum", "angular_momentum", "kinetic", "elastic", "gap_min",
    "contact", "external_work",
)  # fmt: skip
TWINS = [  # kind, law, walls, removal (or other contact), penalty in E/h, supports
    ("hex8", "neo", 2, "full", None, ()),
    ("tet4", "neo", 1, "normal", None, ()),
    ("hex8", "svk", 1, "full", None, ()),
    ("tet4", "linear", 2, "full", None, ()),
    ("hex8", "linear", 1, "normal", 30.0, ()),
    ("hex8", "neo", 2, "full", 300.0, ()),
    ("tet4", "linear", 1, "normal", None, HELD),
    ("hex8", "linear", 1, "penalty", 3.0, ()),
    ("tet4", "neo", 1, "impulse", None, ()),
    ("wedge6", "neo", 2, "full", None, ()),
]


def contact_models(name, stiffness):
    """Return one contact model twice: for the program and for the oracle."""
    if name == "penalty":
        return tc.PenaltyContact(stiffness), oracle.Penalty(stiffness)
    if name == "impulse":
        return tc.ImpulseContact(), oracle.Impulse()
    mine = tc.MasslessContact(removal=name, penalty=stiffness, tolerance=1e-13)
    return mine, oracle.Massless(name, stiffness)


@pytest.mark.parametrize(("kind", "law", "walls", "contact", "penalty", "supports"), TWINS)
def test_every_row_equals_the_oracle(kind, law, walls, contact, penalty, supports):
    stiffness = penalty and penalty * material().young / 0.06
    mine, theirs = contact_models(contact, stiffness)
    turn = np.eye(3) if supports else None
    scene = thrown(law, kind, walls=walls, turn=turn, contact=mine, supports=supports)
    result = simulate(scene, cfl=0.25 if contact == "penalty" else 0.8)
    body = scene.bodies[0]
    there = oracle.run(
        twin(body), twin_planes(scene), body.initial_velocity, steps=result.steps, dt=result.dt, contact=theirs,
        gravity=np.asarray(scene.gravity),
    )  # fmt: skip
    assert np.abs(there.contact_force).max() > 0.0
    for name in COLUMNS:
        wanted, found = getattr(there, name), result.history[name]
        scale = np.abs(wanted).max() or 1.0
        if name in ("contact", "external_work", "support_force"):
            scale = max(np.abs(there.kinetic).max() if name != "support_force" else 0.0, scale)
        assert np.abs(found - wanted).max() <= 1e-8 * scale, name
    assert np.abs(result.position - there_position(body, there)).max() <= 1e-9 * 0.2
    assert np.abs(result.contact_node_force - there.node_force).max() <= 1e-8 * np.abs(there.contact_force).max()


def there_position(body, there):
    return body.mesh.nodes + there.displacement


def slanted_cube(kind, removal, tolerance, cells=4, law="linear", gap=0.0, shake=0.0, speed=2.0, face="zmin"):
    turn = meshes.rotation(12)
    mesh, mat = block(kind, cells, (0.1,) * 3, turn=turn, shake=shake), material(law, 1e7, 0.3, 1000.0)
    axis = "xyz".index(face[0])
    normal = turn[:, axis] * (1.0 if face.endswith("min") else -1.0)
    body = tc.Body(mesh, mat, velocity=-speed * normal, contact=face)
    contact = tc.MasslessContact(removal=removal, tolerance=tolerance)
    wave = 0.1 / mat.wave_speed
    gap *= 0.1
    duration = gap / speed + 2.5 * wave
    return tc.Scene(bodies=[body], obstacles=[wall(mesh, normal, gap)], duration=duration, contact=contact), normal, gap


@pytest.mark.parametrize(
    ("kind", "removal"), [("hex8", "auto"), ("hex8", "full"), ("tet4", "full"), ("wedge6", "full")]
)
def test_the_contact_force_converges_with_the_square_of_the_step(kind, removal):
    """Successive differences on a fixed mesh at cfl .8 .. .05: observed order >= 1.8."""
    scene, normal, _ = slanted_cube(kind, removal, 1e-11)
    limit = simulate(scene, dt=1e-3 * scene.duration).dt_limit
    count = np.ceil(scene.duration / (0.8 * limit))
    forces = []
    for level in range(5):
        dt = scene.duration / count / 2**level
        forces.append((simulate(scene, dt=dt).history["contact_force"] @ normal)[:: 2**level])
    rows = min(map(len, forces))
    differences = [np.linalg.norm(fine[:rows] - coarse[:rows]) for coarse, fine in pairwise(forces)]
    orders = np.log2(np.array(differences[:-1]) / differences[1:])
    assert orders[-1] >= 1.8
    assert orders.mean() >= 1.8


@pytest.mark.parametrize(("kind", "removal", "face"), [("hex8", "auto", "ymin"), ("tet4", "full", "zmax")])
def test_time_runs_back_through_a_linear_impact(kind, removal, face):
    scene, normal, gap = slanted_cube(kind, removal, 1e-13, gap=0.02, shake=0.2, speed=8.0, face=face)
    there = simulate(scene, cfl=0.8)
    force = there.history["contact_force"] @ normal
    assert force.max() > 0.0
    back = tc.Scene(bodies=scene.bodies, obstacles=scene.obstacles, duration=there.time, contact=scene.contact)
    home = simulate(back, dt=there.dt, initial=there.reversed())
    assert home.steps == there.steps
    assert np.abs(home.position - scene.bodies[0].mesh.nodes).max() <= 1e-9 * gap
    speed = np.abs(home.velocity + scene.bodies[0].initial_velocity).max()
    assert speed <= 1e-7 * 8.0


@pytest.mark.parametrize(("kind", "removal"), [("hex8", "full"), ("tet4", "normal")])
def test_a_run_continued_from_its_middle_ends_where_the_whole_run_does(kind, removal):
    """initial=result takes up positions and velocities; linear, tight solves: the same rows to rounding."""
    scene, _, _ = slanted_cube(kind, removal, 1e-13)
    steps = 40
    dt = scene.duration / steps

    def part(count, initial=None):
        shorter = tc.Scene(bodies=scene.bodies, obstacles=scene.obstacles, duration=count * dt, contact=scene.contact)
        return simulate(shorter, dt=dt, initial=initial)

    whole, first = part(steps), part(17)
    second = part(steps - 17, first)
    assert second.steps == steps - 17
    scale = np.abs(whole.history["contact_force"]).max()
    assert np.abs(second.position - whole.position).max() <= 1e-10 * 0.1
    assert np.abs(second.velocity - whole.velocity).max() <= 1e-8 * 2.0
    assert np.abs(second.history["contact_force"] - whole.history["contact_force"][17:]).max() <= 1e-8 * scale


def test_history_every_keeps_every_so_many_rows_and_all_sums():
    scene, _, _ = slanted_cube("hex8", "auto", None)
    full = simulate(scene, cfl=0.7)
    for every in (7, full.steps, full.steps + 1):  # the last row is kept, and once, also where it is one of these
        thin = simulate(scene, cfl=0.7, history_every=every)
        rows = np.unique([*range(0, full.steps + 1, every), full.steps])
        for name, column in full.history.items():
            assert np.array_equal(thin.history[name], column[rows]), (every, name)


def test_a_history_that_grows_too_long_is_thinned_by_itself():
    """Every second row goes, as often as that takes, as if `history_every` had been larger from the start."""
    scene, _, _ = slanted_cube("hex8", "auto", None)
    full = simulate(scene, cfl=0.7, pressures=True)
    most = full.steps // 5
    with pytest.warns(RuntimeWarning, match=f"every 8th of about .* rows .history_rows={most}"):
        thin = simulate(scene, cfl=0.7, pressures=True, history_rows=most)
    rows = np.unique([*range(0, full.steps + 1, 8), full.steps])
    assert len(rows) <= most + 1
    for name, column in full.history.items():
        assert np.array_equal(thin.history[name], column[rows]), name
    for one, other in zip(thin.contact_pressures, full.contact_pressures, strict=True):
        assert np.array_equal(one.pressure, other.pressure[rows])


def test_velocity_of_the_result_is_of_the_last_row():
    """Momentum and kinetic energy of the last row from result.velocity and the mass tensors of the plan."""
    scene = thrown("neo", "tet4", contact=tc.MasslessContact(removal="normal"), duration=1.5)
    result = simulate(scene)
    mass = tc.plan(scene).bodies[0].mass
    moving = np.einsum("nij,nj->ni", mass, result.velocity)
    assert np.allclose(moving.sum(axis=0), result.history["momentum"][-1], rtol=1e-11)
    assert np.sum(moving * result.velocity) / 2 == pytest.approx(result.history["kinetic"][-1], rel=1e-11)
    spin = np.cross(result.position, moving).sum(axis=0)
    assert np.allclose(spin, result.history["angular_momentum"][-1], rtol=1e-10)


def test_steps_end_at_the_duration_or_within_one_step_after_it():
    scene = thrown(contact=tc.MasslessContact(), duration=1.0)
    result = simulate(scene)
    assert result.time == pytest.approx(result.history["time"][-1])
    assert 0.0 <= result.time - scene.duration < result.dt
    assert len(result.history["time"]) == result.steps + 1
    assert result.dt <= 0.2 / 3 / bar_speed(material())
