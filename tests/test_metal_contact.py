"""Contact of metals: tangent of plastic flow, removal of mass, impacts of two metal bodies."""

import numpy as np
import pytest
from contact_stiffness import contact_plan, contact_stiffness, spread_of
from one_point import distorted
from oracle import meshes
from scenes import block, force_of

import tcontact as tc
from tcontact.device import arrays
from tcontact.planning.packing import WIDTH

LINEAR = tc.LinearHardening(400e6, 100e6)
GUINAN = tc.SteinbergGuinan(400e6, 36.0, 0.45, 0.0, 3e-4, 1e-3, 1356.0)  # hardening by pressure is not symmetric
COOK = tc.JohnsonCook(90e6, 292e6, 0.31, 0.025, 1.09, 1356.0)
SIZE = 0.06  # of a cell [m]
STATE = 8  # numbers of a point
STRAIN = 6  # place of the plastic strain among them


def copper(hardening=LINEAR, **options):
    return tc.ElastoPlastic(117e9, 0.35, 8930.0, hardening, specific_heat=390.0, **options)


class Committed:
    """The force pass of a body over a plane, whose points keep the state of the displacements committed."""

    def __init__(self, body, removal):
        self.plan = contact_plan(body, removal)
        self.term = force_of(self.plan)
        self.rest = arrays.zeros(self.plan.reference.size)

    def commit(self, u):
        self.term.advance(self._placed(u), self.rest, 0.0, 0.0, 0.0, before=1e-7)

    def harden(self):
        """Give all points a plastic strain so large that they are elastic."""
        arrays.get(self.term.memory).reshape(-1, STATE, WIDTH)[:, STRAIN] = 50.0

    def force(self, u):
        """Return the force of the contact cells at the contact nodes [3k]; commits nothing."""
        self.term.measure_surface(self._placed(u), self.rest)
        rows, lists = np.array(arrays.get(self.term.rows)).reshape(-1, 3), np.array(arrays.get(self.term.corner_rows))
        count = len(self.plan.contact.nodes)
        return np.array([rows[lists[lists[k] : lists[k + 1]]].sum(axis=0) for k in range(count)]).ravel()

    def _placed(self, u):
        return arrays.put(np.ascontiguousarray(u[self.plan.node_order]).ravel())


@pytest.mark.parametrize("step", [2e-3, 2e-2, 0.0])
@pytest.mark.parametrize(
    ("kind", "formulation", "hardening", "removal"),
    [
        ("hex8", "mean-dilatation", LINEAR, "full"),
        ("hex8", "mean-dilatation", LINEAR, "normal"),
        ("hex8", "mean-dilatation", GUINAN, "full"),
        pytest.param("hex8", "mean-dilatation", COOK, "full", marks=pytest.mark.slow),
        ("hex8", "reduced", LINEAR, "full"),
        pytest.param("hex8", "full", LINEAR, "full", marks=pytest.mark.slow),
        ("tet4", "full", LINEAR, "full"),
    ],
)
def test_contact_tangent_is_the_slope_of_the_force_from_the_committed_state(
    kind, formulation, hardening, removal, step
):
    """After a random plastic path, in plastic flow, and (step 0) in elasticity; it is symmetric."""
    mesh = distorted((3, 3, 2), 0.2, inner_only=True) if kind == "hex8" else block(kind, 2)
    body = tc.Body(mesh, copper(hardening), formulation=formulation, contact="zmin")
    committed, random = Committed(body, removal), np.random.default_rng(4)
    stretch = np.diag([0.09, 0.09, -0.18]) + np.array([[0, 0.03, 0], [0, 0, 0.06], [0.015, 0, 0]])
    for share in np.linspace(0.0, 1.0, 5):
        u = share * mesh.nodes @ stretch.T + 0.02 * SIZE * random.uniform(-1, 1, mesh.nodes.shape)
        committed.commit(u)
    if step == 0.0:
        committed.harden()
    u = u + step * SIZE * random.uniform(-1, 1, u.shape)
    found, nodes, basis = contact_stiffness(body, removal, u, committed.term)
    dofs, spread = spread_of(nodes, basis)
    columns = []
    for dof in dofs:
        way = np.zeros(u.size)
        way[dof] = 1e-7 * SIZE
        way = way.reshape(u.shape)
        columns.append((committed.force(u + way) - committed.force(u - way)) / (2e-7 * SIZE))
    slope = spread.T @ np.stack(columns, axis=1) @ spread
    largest = np.abs(slope).max()
    assert np.abs(found - slope).max() <= (2e-3 if step else 1e-6) * largest
    assert np.abs(found - found.T).max() <= 1e-14 * largest


BOX = tc.box_mesh((0.01, 0.01, 0.01), (4, 4, 4))
FLOOR = tc.Plane((0.0, 0.0, -1e-6))
WALL = tc.Plane((-1e-6, 0.0, 0.0), (1.0, 0.0, 0.0))
BALL = tc.Sphere(center=(0.005, 0.005, -0.004), radius=0.004)


def thrown(speed, obstacles, removal="auto", contact=("zmin", "xmin"), mesh=BOX, material=None):
    """A metal block thrown along the sum of the normals of its first faces."""
    way = -np.array([1.0, 0.0, 1.0] if "xmin" in contact else [0.0, 0.0, 1.0])
    body = tc.Body(mesh, material or copper(), velocity=speed * way, contact=contact)
    return tc.Scene([body], obstacles, 2e-6, contact=tc.MasslessContact(removal=removal))


def contact_of(scene):
    return tc.plan(scene).bodies[0].contact


@pytest.mark.parametrize(
    ("speed", "obstacles", "contact", "wanted"),
    [
        (100.0, [FLOOR], ("zmin",), "normal"),
        (100.0, [FLOOR, WALL], ("zmin", "xmin"), "normal"),
        (100.0, [BALL], ("zmin",), "normal"),
        (60.0, [BALL], ("zmin",), "full"),  # rho v^2/Y = 0.08
        (70.0, [BALL], ("zmin",), "normal"),  # 0.11
        (60.0, [FLOOR], ("zmin", "xmin"), "normal"),  # a plane, whatever the faces
        (1e200, [FLOOR], ("zmin",), "normal"),  # its square is no number
    ],
)
def test_metals_have_full_removal_in_slow_impacts_alone(speed, obstacles, contact, wanted):
    assert contact_of(thrown(speed, obstacles, contact=contact)).removal == wanted
    if wanted == "normal" and speed > 68.0:
        with pytest.raises(tc.InputError, match=r"rho v\^2/Y = .*removal='normal'"):
            tc.plan(thrown(speed, obstacles, "full", contact))
    elif speed < 66.0:
        assert contact_of(thrown(speed, obstacles, "full", contact)).removal == "full"
    elastic = thrown(speed, obstacles, "full", contact, material=tc.NeoHookean(117e9, 0.35, 8930.0))
    assert contact_of(elastic).removal == "full"


def test_a_metal_that_is_not_at_the_contact_does_not_count():
    """A striker with a rubber tip chooses as one of rubber; one layer of metal at the contact nodes decides."""
    low = BOX.cell_centres()[:, 2] < 0.005
    mesh = BOX.with_sets(cell_sets={"low": np.flatnonzero(low), "high": np.flatnonzero(~low)})
    rubber = tc.NeoHookean(1e9, 0.35, 1000.0)
    for contact, tip, back in ((("zmin",), rubber, copper()), (("zmax",), copper(), rubber)):
        for removal in ("auto", "full"):
            scene = thrown(100.0, [BALL], removal, contact, mesh, {"low": tip, "high": back})
            assert contact_of(scene).removal == "full"
    scene = thrown(100.0, [BALL], "auto", ("zmin",), mesh, {"low": copper(), "high": rubber})
    assert contact_of(scene).removal == "normal"


@pytest.mark.parametrize("velocity", [(0.0, 0.0, 100.0), lambda t: (0.0, 0.0, 100.0 * t / 2e-6)])
def test_the_speed_of_an_impact_counts_the_obstacle_and_not_its_slip(velocity):
    moving = tc.Sphere(center=BALL.center, radius=0.004, velocity=velocity)
    assert contact_of(thrown(0.0, [moving], contact=("zmin",))).removal == "normal"
    along = tc.Box(center=(0.005, 0.005, -0.002), size=(0.1, 0.1, 0.004), velocity=(300.0, 0.0, 0.0))
    assert contact_of(thrown(0.0, [along], contact=("zmin",))).removal == "full"


def test_directions_without_mass_are_the_normals_of_the_faces_around_a_node():
    """A block in a corner has one on a face and two on the edge; a ball has one everywhere, across its skin."""
    scene = thrown(100.0, [FLOOR, WALL])
    plan = tc.plan(scene).bodies[0]
    nodes = plan.reference[plan.contact.nodes]
    for place, basis in zip(nodes, plan.contact.basis, strict=True):
        wanted = np.diag([place[0] < 1e-9, False, place[2] < 1e-9]).astype(float)
        assert np.abs(basis @ basis.T - wanted).max() <= 1e-14
    below = tc.Sphere(center=(0.0, 0.0, -0.0091), radius=0.004)
    ball = thrown(100.0, [below], contact=("low",), mesh=tc.ball_mesh(0.005, 4))
    plan = tc.plan(ball).bodies[0]
    assert plan.contact.block == 1
    outward = plan.reference[plan.contact.nodes] / 0.005
    assert np.abs(np.einsum("ki,ki->k", plan.contact.basis[:, :, 0], outward)).min() > np.cos(np.radians(15.0))


def test_impact_on_two_planes_and_on_a_ball_converges_and_keeps_its_energy():
    """Along the normals of the faces; the energy error of a plastic front is of second order in the step."""
    scheme = tc.CentralDifference(cfl=0.2)
    for obstacles, contact in (([FLOOR, WALL], ("zmin", "xmin")), ([BALL], ("zmin",))):
        scene = thrown(100.0, obstacles, contact=contact)
        result = tc.simulate(scene, scheme)
        history = result.history
        assert result.reason == "finished"
        assert history["static_residual"].max() <= 1e-4
        assert history["energy_error"].max() <= 5e-3
        assert history["plastic_strain_max"][-1] > 0.05
        given = history["impulse"][-1]
        change = history["momentum"][-1] - history["momentum"][0]
        assert np.abs(given - change).max() <= 1e-9 * np.abs(given).max()


def two_blocks(material, speed, removal="auto", turn=None):
    """Two blocks that meet face to face at `speed` each, turned in space."""
    bodies, turn = [], np.eye(3) if turn is None else turn
    for side in (1.0, -1.0):
        mesh = tc.box_mesh((0.01, 0.01, 0.01), (4, 4, 4), origin=(-0.005, -0.005, 0.0 if side > 0.0 else -0.01))
        nodes = mesh.nodes @ turn.T
        mesh = tc.Mesh(nodes, mesh.cells, "hex8", face_sets=mesh.face_sets)
        face = "zmin" if side > 0.0 else "zmax"
        bodies.append(tc.Body(mesh, material, -side * speed * turn[:, 2], contact=face))
    return tc.Scene(bodies, [], 4e-6, contact=tc.MasslessContact(removal=removal), pairs=[tc.Pair("body-0", "body-1")])


def test_two_blocks_of_metal_meet_with_momentum_energy_and_symmetry():
    turn = meshes.rotation(3)
    result = tc.simulate(two_blocks(copper(), 100.0, turn=turn), tc.CentralDifference(cfl=0.2))
    history, bodies = result.history, result.scene.bodies
    assert result.reason == "finished"
    assert history["static_residual"].max() <= 1e-4
    assert history["energy_error"].max() <= 3e-3
    assert history["plastic_work"][-1] > 0.1 * history["kinetic"][0]
    assert np.abs(history["momentum"]).max() <= 1e-10 * bodies[0].mass * 100.0
    half = len(result.position) // 2
    now = (result.position - np.concatenate([body.mesh.nodes for body in bodies])) @ turn
    upper, lower = now[:half].reshape(5, 5, 5, 3), now[half:].reshape(5, 5, 5, 3)
    mirrored = lower[::-1] * np.array([1.0, 1.0, -1.0])  # layers of nodes go along z first
    assert np.abs(upper - mirrored).max() <= 1e-4 * np.abs(upper).max()  # as closely as the static solve is solved


def test_pairs_of_metals_refuse_full_removal_in_fast_impacts():
    assert contact_of(two_blocks(copper(), 30.0, "full")).removal == "full"
    with pytest.raises(tc.InputError, match=r"rho v\^2/Y"):
        tc.plan(two_blocks(copper(), 100.0, "full"))
    balls = [
        tc.Body(
            tc.Mesh(mesh.nodes + place, mesh.cells, "hex8", face_sets=mesh.face_sets),
            copper(),
            (0.0, 0.0, -speed),
            contact=face,
        )
        for mesh, place, speed, face in (
            (tc.ball_mesh(0.005, 4), np.array([0.0, 0.0, 0.005]), 100.0, "low"),
            (tc.ball_mesh(0.005, 4), np.array([0.0, 0.0, -0.005]), -100.0, "high"),
        )
    ]
    scene = tc.Scene(balls, [], 2e-6, contact=tc.MasslessContact(), pairs=[tc.Pair("body-0", "body-1")])
    assert contact_of(scene).removal == "normal"
