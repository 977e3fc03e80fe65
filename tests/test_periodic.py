"""Bodies whose opposite sides share their degrees of freedom: exact waves, and independence of where they are cut."""

import dataclasses
from functools import cache

import numpy as np
import pytest
from scenes import force_of, material, simulate, stable_steps

import tcontact as tc
from tcontact.planning.body_plan import SMALL
from tcontact.planning.describe import memory

H, COUNT = 0.4, 40
FLOOR = tc.Plane()


def column(kind="hex8", law="linear", cross=(1, 1), count=COUNT, **body):
    """A column of cubes along z, periodic in x and y."""
    h = H / count
    mesh = tc.box_mesh((cross[0] * h, cross[1] * h, H), (*cross, count), kind)
    return tc.Body(mesh, material(law), **{"periodic": "xy", **body})


def speeds(body):
    """Pressure and shear wave speed [m/s]."""
    return body.material.wave_speed, np.sqrt(body.material.lame_mu / body.material.density)


def impact(body, contact=None, share=1.3, **options):
    """A body falls on the floor; share: of the time of contact 2H/c_d."""
    scene = tc.Scene([body], [FLOOR], duration=share * 2 * H / speeds(body)[0], contact=contact, **options)
    return scene, speeds(body)[0]


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
@pytest.mark.parametrize("axis", [0, 2])
def test_waves_of_a_free_column_are_the_discrete_ones(kind, axis):
    """v = cos(k z) of a linear column: sin(omega dt/2) = c dt/h sin(k h/2), c_d along the column, c_s across it."""
    k, h = 3 * np.pi / H, H / COUNT

    def start(nodes):
        return 0.1 * np.cos(k * nodes[:, 2:]) * np.eye(3)[axis]

    body = column(kind, velocity=start)
    speed = speeds(body)[0 if axis == 2 else 1]
    result = simulate(tc.Scene([body], duration=4 * H / speed, contact=None), dt=0.7 * h / speeds(body)[0])
    omega = 2 / result.dt * np.arcsin(speed * result.dt / h * np.sin(k * h / 2))
    expected = start(body.mesh.nodes) * np.cos(omega * result.time)
    assert np.abs(result.velocity - expected).max() <= 1e-9 * 0.1
    assert omega == pytest.approx(speed * k, rel=2e-3)


@cache
def column_impact(kind, removal, formulation="full"):
    body = column(kind, velocity=(0, 0, -0.5), contact="zmin", formulation=formulation)
    scene, speed = impact(body, tc.MasslessContact(removal=removal))
    return simulate(scene, cfl=0.9), speed


@pytest.mark.parametrize(
    ("kind", "removal", "formulation"),
    [("hex8", "normal", "full"), ("hex8", "full", "full"), ("hex8", "full", "reduced"), ("tet4", "normal", "full")],
)
def test_a_column_hits_the_floor_like_a_bar_without_lateral_strain(kind, removal, formulation):
    """Contact force rho c_d v A over 2H/c_d, then the body flies off with the speed it came with."""
    result, speed = column_impact(kind, removal, formulation)
    area, density = (H / COUNT) ** 2, material().density
    time, force = result.history["time"], result.history["contact_force"]
    exact, end = density * speed * 0.5 * area, 2 * H / speed
    plateau = force[(time > 0.1 * end) & (time < 0.9 * end), 2]
    assert plateau.mean() == pytest.approx(exact, rel=1e-3)
    assert np.sqrt(np.mean((plateau / exact - 1) ** 2)) <= 2e-3
    assert time[force[:, 2] > 1e-6 * exact].max() == pytest.approx(end, rel=0.03)
    assert np.abs(force[:, :2]).max() <= 1e-9 * exact
    assert result.history["impulse"][-1, 2] == pytest.approx(2 * density * H * area * 0.5, rel=5e-3)
    assert result.history["energy_error"].max() <= 6e-3


@pytest.mark.parametrize("removal", ["normal", "full"])
@pytest.mark.parametrize(("friction", "sideways"), [(0.5, 0.5), (0.2, 1.0)])
def test_pressure_shear_impact_sticks_or_slides_as_the_waves_say(removal, friction, sideways):
    """p = rho c_d v_n; stick iff rho c_s v_t <= mu p, with that shear; else mu p at slip v_t - mu p/(rho c_s)."""
    count, density, normal = 80, material().density, 1.0
    body = column(velocity=(sideways, 0, -normal), contact="zmin", count=count)
    scene, fast = impact(body, tc.MasslessContact(removal=removal), friction=tc.Coulomb(friction))
    result, slow = simulate(scene, cfl=0.9), speeds(body)[1]
    area, end = (H / count) ** 2, 2 * H / fast
    pressure, stick = density * fast * normal, density * slow * sideways
    shear = min(stick, friction * pressure)
    slip = sideways - shear / (density * slow)
    time, force = result.history["time"], result.history["contact_force"] / area
    plateau = force[(time > 0.1 * end) & (time < 0.9 * end)].mean(axis=0)
    assert plateau == pytest.approx((-shear, 0.0, pressure), rel=1e-3, abs=1e-9 * pressure)
    work, kinetic = result.history["friction_work"][-1], result.history["kinetic"][0]
    if slip > 0.0:
        assert work == pytest.approx(shear * slip * end * area, rel=0.01)
    else:
        assert 0.0 <= work <= 5e-3 * kinetic
    speed = result.history["momentum"][-1, 0] / (density * area * H)
    assert speed == pytest.approx(sideways - shear * end / (density * H), abs=5e-3 * sideways)
    assert result.history["energy_error"].max() <= 4e-3


def test_a_slab_of_uniform_data_is_the_column():
    """Four columns side by side: four times every force, the same motion."""
    results = []
    for cross in ((1, 1), (2, 2)):
        body = column(cross=cross, velocity=(0.4, 0, -0.5), contact="zmin", count=20)
        scene, speed = impact(body, tc.MasslessContact(removal="full", tolerance=1e-12))
        results.append((simulate(scene, dt=0.8 * H / 20 / speed), body.mesh))
    (one, thin), (four, thick) = results
    for name in ("contact_force", "momentum", "elastic", "kinetic"):
        scale = np.abs(one.history[name]).max()
        assert np.abs(four.history[name] / 4 - one.history[name]).max() <= 1e-10 * scale
    for level in np.unique(thin.nodes[:, 2]):
        ours = one.position[thin.nodes[:, 2] == level] - thin.nodes[thin.nodes[:, 2] == level]
        theirs = four.position[thick.nodes[:, 2] == level] - thick.nodes[thick.nodes[:, 2] == level]
        assert np.abs(theirs - ours[0]).max() <= 1e-11 * H


L, CELLS = 0.2, (5, 2, 4)
WIDTHS = (L, 0.8 * L, 0.7 * L)


def wavy(periods, kind):
    """A slab of some periods along x whose nodes are shaken alike in every period; and which node is which."""
    nx, ny, nz = CELLS
    box = tc.box_mesh((periods * WIDTHS[0], *WIDTHS[1:]), (periods * nx, ny, nz), kind)
    x, y, z = box.nodes.T / np.array(WIDTHS)[:, None]
    across, along = np.sin(2 * np.pi * x), np.sin(2 * np.pi * y)  # the sides stay flat
    sway = 0.05 * L * np.stack([across * (0.3 + z), along * np.cos(2 * np.pi * x), (across - along + 0.5) * z], axis=1)
    i, j, k = (np.round(box.nodes / (np.array(WIDTHS) / CELLS)).astype(int)).T
    name = (i % nx) + nx * ((j % ny) + ny * k)
    return tc.Mesh(box.nodes + sway, box.cells, kind, face_sets=box.face_sets), name


def uneven(nodes):
    """A velocity that differs from node to node and repeats in x and y."""
    x, y, z = nodes.T / np.array(WIDTHS)[:, None]
    wave = np.cos(2 * np.pi * np.round(x * CELLS[0]) / CELLS[0]) * np.sin(
        2 * np.pi * np.round(y * CELLS[1]) / CELLS[1] + 0.4
    )
    return np.stack([0.8 * wave, 0.5 * wave * z, -2.0 - 0.7 * wave], axis=1)


SUMS = ("contact_force", "momentum", "kinetic", "elastic", "external_work", "support_force", "friction_work")
HELD = [tc.Support("zmax", "x", velocity=0.1)]
NORMAL, FULL = (tc.MasslessContact(removal, tolerance=1e-12) for removal in ("normal", "full"))
LOADS = [
    tc.Load("zmin", pressure=lambda t: 1e4 * np.cos(800.0 * t)),
    tc.Load("zmax", traction=(2e3, 0.0, -3e4)),
    tc.Load("zmin", force=lambda x, v, t: -5.0 * v),
]
CUTS = {
    "normal removal": ("hex8", "linear", {"contact": NORMAL}, {}),
    "full removal, tets, damping": (
        "tet4",
        "neo",
        {"contact": tc.MasslessContact("full", depth=2, tolerance=1e-12), "damping": tc.MassDamping(30.0)},
        {},
    ),
    "one-point hexes, gravity": (
        "hex8",
        "linear",
        {"contact": FULL, "gravity": (30.0, 0.0, -900.0)},
        {"formulation": "reduced"},
    ),
    "normal removal, friction": ("hex8", "linear", {"contact": NORMAL, "friction": tc.Coulomb(0.3)}, {}),
    "full removal, friction": ("hex8", "linear", {"contact": FULL, "friction": tc.Coulomb(0.3)}, {}),
    "friction layers, moving wall": (
        "hex8",
        "linear",
        {"contact": NORMAL, "friction": tc.FrictionLayer(), "velocity": (0.3, -0.2, 0.1)},
        {},
    ),
    "penalty, supports, viscosity": (
        "tet4",
        "linear",
        {"contact": tc.PenaltyContact(3e9), "viscosity": tc.BulkViscosity()},
        {"supports": HELD},
    ),
    "impulse": ("hex8", "linear", {"contact": tc.ImpulseContact()}, {}),
    "prisms, full removal": ("wedge6", "linear", {"contact": FULL}, {}),
    "normal removal, loads": ("hex8", "linear", {"contact": NORMAL}, {"loads": LOADS[:2]}),
    "full removal, own force, gravity in time": (
        "hex8",
        "linear",
        {"contact": FULL, "gravity": lambda t: (30.0, 0.0, -9e5 * t)},
        {"loads": LOADS},
    ),
    "mean dilatation": ("hex8", "neo", {"contact": FULL}, {"formulation": "mean-dilatation"}),
}
LONG = ("mean dilatation", "normal removal, friction")  # to compile; the layers are friction with normal removal too


def slab(name, periods):
    """The scene of a name in CUTS with a body of so many periods along x; and which node is which."""
    kind, law, scene, body = CUTS[name]
    mesh, names = wavy(periods, kind)
    body = tc.Body(mesh, material(law), velocity=uneven, contact="zmin", periodic="xy", **body)
    floor = tc.Plane((0, 0, -0.002 * L), velocity=scene.get("velocity"))
    terms = {term: value for term, value in scene.items() if term != "velocity"}
    return tc.Scene([body], [floor], duration=4e-3, **terms), names


def enough_for_large(name):
    """Periods of a body that is too large to take many steps per launch on one thread."""
    body = slab(name, 1)[0].bodies[0]
    return SMALL[body.element] // len(body.mesh.cells) + 1


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in CUTS])
def test_one_period_is_what_many_periods_are(name):
    """Nothing knows where the body was cut, nor how large it is: uneven cells and velocities, every term; sums add up.

    One period is a small body, which takes many steps per launch on one thread. So many periods are a large one, which
    takes a step per launch on all threads, and its few contact cells on one.
    """
    scene, names = slab(name, 1)
    periods = enough_for_large(name)
    large, again = slab(name, periods)
    assert [tc.plan(one).domains[0].small for one in (scene, large)] == [True, False]
    dt = 0.5 * tc.simulate(dataclasses.replace(scene, duration=1e-9)).dt_limit
    one, many = (simulate(whole, dt=dt) for whole in (scene, large))
    assert np.abs(one.history["contact_force"][:, 2]).max() > 0.0
    for column in (*SUMS, *(name for name in one.history if name.startswith(("applied", "gravity")))):
        scale = np.abs(one.history[column]).max()
        assert np.abs(many.history[column] / periods - one.history[column]).max() <= 1e-8 * scale, column
    for field in (lambda r: r.position - r.scene.bodies[0].mesh.nodes, lambda r: r.velocity):
        ours = np.empty((names.max() + 1, 3))
        ours[names] = field(one)
        assert np.abs(ours[names] - field(one)).max() <= 1e-15 * L  # images move as one
        assert np.abs(ours[again] - field(many)).max() <= 1e-8 * np.abs(ours).max()


def test_many_contact_cells_are_measured_by_all_threads_alike():
    """A body with more contact cells than one thread takes between two steps: the same as one period of it."""
    scene, _ = slab("normal removal", 1)
    nx, ny, _ = CELLS
    periods = SMALL["hex8"] // (nx * ny) + 1
    large, _ = slab("normal removal", periods)
    assert [tc.plan(one).domains[0].few_contact_cells for one in (scene, large)] == [True, False]
    dt = 0.5 * tc.simulate(dataclasses.replace(scene, duration=1e-9)).dt_limit
    one, many = (simulate(dataclasses.replace(whole, duration=2e-3), dt=dt) for whole in (scene, large))
    force = one.history["contact_force"][:, 2]
    assert force.max() > 0.0
    assert np.abs(many.history["contact_force"][:, 2] / periods - force).max() <= 1e-8 * force.max()


def test_momentum_mass_and_forces_count_every_degree_of_freedom_once():
    scene, _ = slab("one-point hexes, gravity", 1)
    body = tc.plan(scene).bodies[0]
    weight = body.lumped.sum()
    assert np.allclose(body.mass.sum(axis=0), weight * np.eye(3), rtol=1e-13, atol=1e-13 * weight)
    assert np.allclose(body.loads.sum(axis=0) + _ordinary(body) * body.gravity, weight * body.gravity, rtol=1e-12)
    result = simulate(scene, cfl=0.5)
    history, time = result.history, result.history["time"]
    given = history["momentum"][0] + history["impulse"] + weight * np.outer(time, scene.gravity)
    assert np.abs(history["momentum"] - given).max() <= 1e-9 * np.abs(history["momentum"]).max()
    force = result.contact_node_force
    assert np.allclose(force.sum(axis=0), history["contact_force"][-1], rtol=1e-12)
    shared = scene.bodies[0].images
    assert np.array_equal(force, force[shared.master])


def _ordinary(body):
    """Mass of the nodes that are not on the list of boundary nodes [kg]."""
    return np.delete(body.lumped, body.boundary).sum()


def test_energy_is_conserved_better_the_smaller_the_step():
    scene, _ = slab("normal removal", 1)
    errors = [simulate(scene, cfl=cfl).history["energy_error"].max() for cfl in (0.4, 0.1)]
    assert errors[1] <= 0.5 * errors[0]
    assert errors[1] <= 5e-3


def test_a_support_on_one_image_holds_them_all():
    mesh = tc.box_mesh((0.1, 0.1, 0.2), (2, 2, 4)).with_sets({"one": [0]})
    body = tc.Body(mesh, material("linear"), velocity=(0, 0, 1.0), periodic="xy", supports=[tc.Support("one", "xz")])
    held = np.flatnonzero(np.isfinite(body.prescribed[:, 0]))
    corners = (np.isin(mesh.nodes[:, :2], (0.0, 0.1)).all(axis=1)) & (mesh.nodes[:, 2] == 0.0)
    assert np.array_equal(held, np.flatnonzero(corners))
    result = simulate(tc.Scene([body], duration=2e-3, contact=None))
    assert np.array_equal(result.position[held][:, [0, 2]], mesh.nodes[held][:, [0, 2]])
    history = result.history
    change = history["momentum"] - history["momentum"][0]
    assert np.abs(change - history["support_impulse"]).max() <= 1e-9 * np.abs(history["momentum"]).max()


def test_the_stable_step_is_that_of_the_tied_body():
    """A column has no modes across: exactly h/c_d; a slab is never below the body with free sides."""
    body = column(count=10)
    limit = simulate(tc.Scene([body], duration=1e-5, contact=None)).dt_limit * speeds(body)[0] / (H / 10)
    assert 0.95 <= limit <= 1.0
    slabs = [tc.Body(wavy(1, "tet4")[0], material("linear"), periodic=sides) for sides in (None, "x", "xy")]
    limits = [simulate(tc.Scene([body], duration=1e-7, contact=None)).dt_limit for body in slabs]
    assert 0.97 * limits[0] <= limits[1] <= 2.0 * limits[0]
    assert 0.97 * limits[1] <= limits[2]


def test_a_search_that_goes_on_stays_in_the_tied_body():
    """Few products from the mode of the body at rest, far from equilibrium: close to a search from scratch."""
    body = tc.Body(wavy(1, "tet4")[0], material(), periodic="xy")
    planned = tc.plan(tc.Scene([body], duration=1.0, contact=None)).bodies[0]
    noise = np.random.default_rng(4).uniform(-0.03, 0.03, (len(planned.reference), 3)) * body.mesh.size
    moved = planned.images.follow(noise * np.linspace(0.0, 1.0, len(noise))[:, None] / 10).reshape(-1)
    found = []
    for before, products in ((True, 8), (False, 80)):
        estimator = stable_steps(planned, force_of(planned))
        if before:
            estimator.estimate(np.zeros_like(moved))
        found.append(estimator.estimate(moved, products=products))
        search = estimator.bodies[0]
        assert np.allclose(search.start, planned.images.follow(search.start.reshape(-1, 3)).reshape(-1), atol=1e-5)
    assert 0.9 <= found[0] / found[1] <= 1.05


def test_memory_and_plan_name_the_images_and_a_plain_body_has_none():
    scene, _ = slab("normal removal", 1)
    planned = tc.plan(scene)
    assert "periodic" in planned.terms
    assert "periodic" in planned.describe()
    taken, foreseen = simulate(scene).memory, memory(planned, planned.domains[0])
    assert set(taken) == set(foreseen)
    for term, size in taken.items():
        assert foreseen[term] == pytest.approx(size, rel=0.2, abs=512), term
    nx, ny, nz = CELLS
    assert taken["periodic"] == foreseen["periodic"] == 8 * (nx + ny + 1) * (nz + 1)
    plain = tc.Scene([tc.Body(wavy(1, "hex8")[0], material("linear"), contact="zmin")], scene.obstacles, 1e-5)
    assert "periodic" not in tc.plan(plain).terms
    assert tc.plan(plain).bodies[0].images is None
    assert "periodic" not in simulate(plain).memory


def sided(move):
    """A box with one node of the side x = 0 moved."""
    box = tc.box_mesh((1, 1, 1), (3, 3, 3))
    nodes = np.array(box.nodes)
    nodes[np.flatnonzero((nodes[:, 0] == 0.0) & (nodes[:, 1:] == 1 / 3).all(axis=1))[0]] += move
    return tc.Mesh(nodes, box.cells, "hex8", face_sets=box.face_sets)


def five():
    """A cube of five tets: diagonals of opposite sides cross."""
    cells = [(0, 1, 3, 4), (1, 2, 3, 6), (1, 3, 4, 6), (1, 4, 5, 6), (3, 4, 6, 7)]
    hexahedron = tc.box_mesh((1, 1, 1), (1, 1, 1))
    return tc.Mesh(hexahedron.nodes, hexahedron.cells[0][np.array(cells)], "tet4")


def unlike(nodes):
    return nodes * (1.0, 0.0, 0.0)


BOX = {"mesh": tc.box_mesh((1, 1, 1), (3, 3, 3)), "material": material(), "periodic": "xy"}
BAD = {
    "no letter": ({"periodic": ""}, "periodic"),
    "twice": ({"periodic": "xx"}, "periodic"),
    "no string": ({"periodic": True}, "periodic"),
    "moved along its side": ({"mesh": sided((0, 1e-4, 0))}, "periodic"),
    "moved off its side": ({"mesh": sided((1e-3, 0, 0))}, "periodic"),
    "divided otherwise": ({"mesh": five(), "periodic": "x"}, "periodic"),
    "turned": ({"mesh": BOX["mesh"].rotated(np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]]))}, "periodic"),
    "contact on a periodic side": ({"contact": ["zmin", "xmax"]}, "contact"),
    "images start apart": ({"displacement": unlike}, "displacement"),
    "images start at other speeds": ({"velocity": unlike}, "velocity"),
    "supports disagree": ({"supports": [tc.Support("xmin", "y"), tc.Support("xmax", "y", 1.0)]}, "supports"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_bodies_are_refused(name):
    options, field = BAD[name]
    with pytest.raises(tc.InputError, match=f"Body.{field}"):
        tc.Body(**{**BOX, **options})


def test_a_wall_that_does_not_repeat_is_refused():
    body = tc.Body(**BOX, contact="zmin")
    turning = tc.Plane(angular_velocity=(0.0, 0.0, 1.0))
    for wall in (
        tc.Plane((-1, 0, -1), (0.01, 0, 1)),
        tc.Plane((-1, 0, 0), (1, 0, 0)),
        tc.Sphere((0, 0, -3), 1),
        turning,
    ):
        with pytest.raises(tc.InputError, match="obstacles"):
            tc.Scene([body], [wall], 1.0)
    tc.Scene([tc.Body(**BOX)], [tc.Plane((-1, 0, -1), (0.01, 0, 1))], 1.0)  # nothing touches
    tc.Scene([tc.Body(**{**BOX, "periodic": "y"}, contact="zmin")], [tc.Plane((-1, 0, -1), (0.01, 0, 1))], 1.0)


SLAB = tc.box_mesh((1, 1, 1), (2, 2, 2))
WALLS = {
    "faced by a side that repeats": tc.Plane((0, 0, -0.01)),
    "tilted": tc.Plane((0, 0, -2), (0, 1, 1)),
    "sphere": tc.Sphere((0.5, 0.5, -1.1), 1.0),
    "box": tc.Box((0.5, 0.5, -1.1), (4, 4, 2)),
    "turning": tc.Plane((-0.01, 0, 0), (1, 0, 0), angular_velocity=(1.0, 0, 0)),
}


@pytest.mark.parametrize("contact", ["auto", ("xmin", "ymin")])
@pytest.mark.parametrize("wall", WALLS)
@pytest.mark.parametrize("periodic", ["z", "zy", "xyz"])
def test_no_body_falls_through_a_wall_that_a_repeated_side_faces(wall, periodic, contact):
    """Whether its contact faces are found or named: refused by name, not found to touch nothing."""
    if contact != "auto":
        contact = [name for name in contact if name[0] not in periodic]
        if not contact:
            return
    body = tc.Body(SLAB, material(), velocity=(0, 0, -1.0), contact=contact, periodic=periodic)
    with pytest.raises(tc.InputError, match="obstacles"):
        tc.Scene([body], [WALLS[wall]], 1.0)
    for passes in ({"contact": None}, {}):
        free = body if passes else tc.Body(SLAB, material(), periodic=periodic)
        with pytest.warns(UserWarning, match="pass through"):
            tc.Scene([free], [WALLS[wall]], 1.0, **passes)
    beside = tc.Scene(
        [tc.Body(SLAB, material(), contact="auto", periodic="z")], [tc.Plane((-0.01, 0, 0), (1, 0, 0))], 1.0
    )
    assert len(beside.bodies[0].contact_faces) == 4
