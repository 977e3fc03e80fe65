"""Tetrahedra with the volume change averaged at nodes: force against numpy, invariants, locking, contact stiffness."""

from dataclasses import replace

import numpy as np
import oracle
import pytest
from contact_stiffness import spread_of
from one_point import Force, moved
from oracle import meshes
from scenes import TWINS, block, material, simulate, stable_steps, state_of
from scipy.spatial import Delaunay
from test_resume import split

import tcontact as tc
from tcontact.cells.stress import VonMises
from tcontact.device import arrays
from tcontact.planning.describe import memory
from tcontact.planning.domain_packs import pack_domain
from tcontact.planning.node_volumes import volume_arrays

AVERAGED = "node-averaged"
SPLIT = ["neo", "linear", "mooney"]


def delaunay(counts=(3, 3, 2), size=(0.2, 0.22, 0.18), seed=3):
    """A box with the Delaunay tetrahedra of a lattice moved at random, its slivers included."""
    box = tc.box_mesh(size, counts, "tet4")
    low, high = np.zeros(3), np.array(size)
    inside = (box.nodes > low + 1e-9) & (box.nodes < high - 1e-9)
    move = np.random.default_rng(seed).uniform(-0.25, 0.25, box.nodes.shape) * high / counts
    nodes = box.nodes + inside * move
    cells = Delaunay(nodes).simplices.astype(np.int64)
    edges = nodes[cells[:, 1:]] - nodes[cells[:, :1]]
    volume = np.linalg.det(edges) / 6.0
    cells[volume < 0.0] = cells[volume < 0.0][:, [0, 2, 1, 3]]
    cells = cells[np.abs(volume) > 1e-3 * np.prod(high) / len(cells)]
    return tc.Mesh(nodes, cells, "tet4").with_sets(
        node_sets={
            name + end: np.flatnonzero(np.abs(nodes[:, axis] - value) < 1e-9)
            for axis, name in enumerate("xyz")
            for end, value in (("min", low[axis]), ("max", high[axis]))
        }
    )


MESHES = {"kuhn": block("tet4", (3, 3, 2)), "delaunay": delaunay()}


def averaged(mesh, law="neo", poisson=0.499, **how):
    return tc.Body(mesh, material(law, poisson=poisson), formulation=AVERAGED, **how)


def force_of(body):
    """The force pass of a body, its supported nodes included."""
    force = Force(body)
    force.term = force.term.without_boundary()
    return force


def twin(body):
    """Return the numpy twin of a body (`oracle.NodeAveraged`)."""
    law = TWINS[type(body.material).__name__](body.material.young, body.material.poisson)
    held = np.isfinite(body.prescribed).all(axis=1)
    return oracle.NodeAveraged(np.array(body.mesh.nodes), np.array(body.mesh.cells), law, held)


@pytest.mark.parametrize("law", SPLIT)
@pytest.mark.parametrize("shape", MESHES)
def test_force_and_energy_match_numpy_and_each_other(law, shape):
    """Force = numpy's = the exact slope of the energy; with a bonded face, whose nodes have no volume."""
    mesh = MESHES[shape]
    supports = [tc.Support("zmax", "xyz"), tc.Support("xmin", "xyz"), tc.Support("ymin", "x")] if law == "neo" else []
    body = averaged(mesh, law, supports=supports)
    there, force, u = twin(body), force_of(body), moved(mesh, 0.1)
    found, exact = force(u), there.force(u)
    assert np.abs(found - exact).max() <= 1e-12 * np.abs(exact).max()
    assert force.energy == pytest.approx(there.energy(u), rel=1e-12)
    assert force.jacobian == pytest.approx(1.0 + oracle.laws.volume_change(gradients(there, u)).min(), rel=1e-12)
    assert np.abs(found.sum(axis=0)).max() <= 1e-13 * np.abs(found).sum()
    if law != "linear":
        torque = np.cross(mesh.nodes + u, found)
        assert np.abs(torque.sum(axis=0)).max() <= 1e-13 * np.abs(torque).sum()
    way, step = np.random.default_rng(3).uniform(-1, 1, u.shape), 1e-6
    ends = []
    for sign in (1.0, -1.0):
        force(u + sign * step * way)
        ends.append(force.energy)
    assert (ends[0] - ends[1]) / (2 * step) == pytest.approx(np.sum(found * way), rel=1e-6)


def gradients(there, u):
    return oracle.cells.displacement_gradient(there.quad, u)


def test_rigid_motion_gives_no_force_and_a_rotation_turns_it():
    body = averaged(MESHES["delaunay"], "mooney")
    nodes, force = body.mesh.nodes, force_of(body)
    scale = (body.material.lame_lambda + 2 * body.material.lame_mu) * 0.06**2
    assert not force(np.zeros_like(nodes) + np.array([1024.0, -512.0, 2048.0])).any()
    assert force.energy == 0.0
    assert np.abs(force(nodes @ meshes.rotation(5).T - nodes)).max() <= 1e-13 * scale
    u, turn = moved(body.mesh, 0.2), meshes.rotation(9)
    before = force(u)
    energy = force.energy
    after = force((nodes + u) @ turn.T - nodes)
    assert np.abs(after - before @ turn.T).max() <= 1e-12 * np.abs(before).max()
    assert force.energy == pytest.approx(energy, rel=1e-12)


@pytest.mark.parametrize("law", SPLIT)
def test_patch_carries_a_uniform_strain(law):
    """A linear field: energy, forces and von Mises stress of full integration, and balance at inner nodes."""
    mesh = MESHES["delaunay"]
    body = averaged(mesh, law)
    u = mesh.nodes @ (0.2 * np.random.default_rng(6).uniform(-1, 1, (3, 3))).T
    mean, usual = force_of(body), Force(replace(body, formulation="full"))
    found, wanted = mean(u), usual(u)
    assert np.abs(found - wanted).max() <= 1e-12 * np.abs(wanted).max()
    assert mean.energy == pytest.approx(usual.energy, rel=1e-12)
    stress = VonMises(replace(body, formulation="full"))(u)
    assert VonMises(body)(u) == pytest.approx(stress, rel=1e-11)


def test_tiny_strain_keeps_its_digits_and_its_volume():
    """At a strain of 1e-9 far from the origin the force is that of numbers 1e9 times larger; averages keep volume."""
    mesh = MESHES["delaunay"]
    away = tc.Mesh(mesh.nodes, mesh.cells, "tet4")
    way = moved(mesh, 1.0)
    linear, force = (force_of(averaged(away, law)) for law in ("linear", "neo"))
    wanted = linear(way)
    assert np.abs(linear(1e-9 * way) - 1e-9 * wanted).max() <= 1e-12 * np.abs(1e-9 * wanted).max()
    small = force(1e-9 * way)
    assert np.abs(small - 1e-9 * wanted).max() <= 1e-7 * np.abs(1e-9 * wanted).max()
    exact = twin(averaged(away, "neo")).force(1e-9 * way)
    assert np.abs(small - exact).max() <= 1e-12 * np.abs(exact).max()
    change = node_changes(force)
    cells = np.linalg.det(corners(mesh.nodes + 1e-9 * way, mesh)) - np.linalg.det(corners(mesh.nodes, mesh))
    assert change == pytest.approx(cells.sum() / 6.0, rel=1e-5)  # the difference of volumes has lost these digits


def corners(points, mesh):
    return points[mesh.cells[:, 1:]] - points[mesh.cells[:, :1]]


def node_changes(force):
    """Return the sum over the volume nodes of V_a th_a of the last pass."""
    from tcontact.kernels import volume_places as at

    lists, values = arrays.get(force.term.volume_lists), arrays.get(force.term.volumes)
    count = lists[at.COUNT]
    numbers = lists[lists[at.NUMBERS] : lists[at.NUMBERS] + count]
    return float(np.sum(values[lists[at.CHANGES] + numbers] / values[lists[at.INVERSES] :][:count]))


@pytest.mark.parametrize("poisson", [0.3, 0.4999])
@pytest.mark.parametrize("shape", MESHES)
def test_stable_step_is_not_shorter_than_that_of_locking_cells(poisson, shape):
    body = averaged(MESHES[shape], poisson=poisson)
    force, there, u = force_of(body), twin(body), moved(body.mesh, 0.05)
    estimate = stable_steps(force.plan, force.term).estimate(u[force.plan.node_order].reshape(-1))
    mass = oracle.assemble(there.cells, oracle.lumped_cell_mass(there.quad, body.material.density), len(u))
    root = np.repeat(mass, 3) ** -0.5
    tangents = there.tangent(u), oracle.tangent(there.quad, there.law, u).toarray()
    limits = [2.0 / np.sqrt(np.linalg.eigvalsh(root[:, None] * tangent * root)[-1]) for tangent in tangents]
    assert 0.9 <= estimate / limits[0] <= 1.0
    assert limits[0] >= (1.0 - 1e-6) * limits[1]


def contact_stiffness(body, removal, u):
    """K_KK [k * block, k * block] at u, its nodes in the user's numbering and their basis [k, 3, block]."""
    import taichi as ti

    from tcontact.kernels.cells.node_volumes import make_volume_phase
    from tcontact.kernels.language.bundles import Contact, Launch, Pairs
    from tcontact.kernels.language.compile_options import KEEP_VECTORS, compiled_with
    from tcontact.kernels.language.signatures import arguments, kernel_of, signature_of
    from tcontact.kernels.static.averaged_tangent import sum_members
    from tcontact.kernels.static.solve import summed
    from tcontact.kernels.static.surface_tangent import make_surface_tangent

    contact = tc.MasslessContact(removal=removal)
    scene = tc.Scene([body], [tc.Plane((0, 0, -1.0))], 1.0, contact=contact)
    plan = tc.plan(scene).bodies[0]
    state = state_of(scene, plan, u)
    term, graph, block = state.contact, plan.contact.graph, plan.contact.block
    for place in state.internal_force.strengths:  # elastic, as the products
        arrays.set_values(state.internal_force.parameters, np.array([1e300]), place)
    out = arrays.zeros(len(graph.column) * block * block)
    kinds = state.domain.kinds
    tangent, phase = make_surface_tangent(*kinds[0], block, term.plain), make_volume_phase(kinds)

    def stiffness(body: ti.template(), contact: ti.template(), pairs: ti.template(), launch: ti.template()):
        ti.loop_config(serialize=True)
        for _ in range(1):
            phase(0, 16, body, 1, 1)
            tangent(body, contact.basis, pairs, 0)
            sum_members(body, contact, 0)
            for e in range(contact.active.shape[0]):
                for i in range(pairs.row_start[e], pairs.row_start[e + 1]):
                    value = summed(body, pairs, i, block)
                    for p, q in ti.static(ti.ndrange(block, block)):
                        launch.raw_out[(i * block + p) * block + q] = value[p, q]

    bundles = {
        "body": state.internal_force.bundle()._replace(u=state.u),
        "contact": Contact(**term.arguments(), sums=state.serial.sums),
        "pairs": Pairs(**term.static_solve.pairs),
        "launch": Launch(raw_out=out),
    }
    kernel = kernel_of(ti.func(stiffness), signature_of(bundles), options=term.options)
    compiled_with(kernel, **KEEP_VECTORS)(*arguments(bundles))
    count = len(plan.contact.nodes)
    matrix = np.zeros((count, block, count, block))
    rows = np.repeat(np.arange(count), np.diff(graph.row_start))
    for row, column, value in zip(rows, graph.column, np.array(arrays.get(out)).reshape(-1, block, block), strict=True):
        matrix[row, :, column] = value
    return matrix.reshape(count * block, -1), plan.node_order[plan.contact.nodes], plan.contact.basis[:, :, :block]


@pytest.mark.parametrize(
    ("law", "removal"), [("neo", "normal"), ("neo", "full"), ("mooney", "normal"), ("linear", "full")]
)
def test_contact_stiffness_is_the_slope_of_the_force_and_positive_definite(law, removal):
    """Nodes that share a volume node but no cell are coupled; with a support: its component is not massless."""
    mesh = MESHES["delaunay"]
    supports = [tc.Support("xmin", "x")] if removal == "full" else []
    body = averaged(mesh, law, contact="zmin", supports=supports)
    u = moved(mesh, 0.05)
    found, nodes, basis = contact_stiffness(body, removal, u)
    dofs, spread = spread_of(nodes, basis)
    slope = spread.T @ force_of(body).stiffness(u, 1e-6 * 0.06, dofs)[dofs] @ spread
    assert np.abs(found - slope).max() <= 1e-7 * np.abs(slope).max()
    exact = spread.T @ twin(body).tangent(u)[np.ix_(dofs, dofs)] @ spread
    assert np.abs(found - exact).max() <= 1e-11 * np.abs(found).max()
    assert np.abs(found - found.T).max() <= 1e-14 * np.abs(found).max()
    massless = np.linalg.norm(spread, axis=0) > 0
    rest = contact_stiffness(body, removal, np.zeros_like(u))[0][np.ix_(massless, massless)]
    root = np.diag(rest) ** -0.5
    values = np.linalg.eigvalsh(root[:, None] * rest * root)
    print(removal, values[-1] / values[0])
    assert values[0] > 0.0


def solved(mesh, poisson, held, pull, formulation):
    """Return displacement and stiffness where `pull` [n, 3] is a load of free nodes and a displacement of held ones."""
    law, nodes, cells = oracle.LinearElastic(1.0, poisson), np.array(mesh.nodes), np.array(mesh.cells)
    u, free = np.where(held[:, None], pull, 0.0).ravel(), np.repeat(~held, 3)
    there = {
        "mean-dilatation": lambda: oracle.MeanDilatation(nodes, cells, law),
        AVERAGED: lambda: oracle.NodeAveraged(nodes, cells, law, held),
        "all averaged": lambda: oracle.NodeAveraged(nodes, cells, law),
    }[formulation]()
    matrix = there.tangent(np.zeros_like(nodes))
    u[free] = np.linalg.solve(matrix[np.ix_(free, free)], (pull.ravel() - matrix @ u)[free])
    return u, matrix, there


@pytest.mark.parametrize(("poisson", "wanted", "hexes"), [
    (0.4999, 0.805, 0.982), pytest.param(0.3, 0.857, 0.986, marks=pytest.mark.slow)
])  # fmt: skip
def test_bending_of_a_nearly_incompressible_cantilever_does_not_lock(poisson, wanted, hexes):
    """Tip over that of fine hexes, by hexes with a mean dilatation, whose own is known; plain tetrahedra: .044."""
    tips = []
    for kind, formulation in (("tet4", AVERAGED), ("hex8", "mean-dilatation")):
        mesh = tc.box_mesh((1.0, 1.0, 5.0), (4, 4, 20), kind)
        load = np.zeros_like(mesh.nodes)
        load[:, 0] = oracle.face_area_weights(np.array(mesh.nodes), mesh.face_sets["zmax"])
        u, _, _ = solved(mesh, poisson, mesh.nodes[:, 2] < 1e-9, load, formulation)
        tips.append(u @ load.ravel())
    assert tips[0] / tips[1] * hexes == pytest.approx(wanted, abs=0.01)


def test_bonded_faces_do_not_lock():
    """Block between bonded plates, poisson 0.4999: force over that of fine hexes; 1.30 with volume at bonded nodes."""
    forces, largest = {}, {}
    for kind, formulation in (("tet4", AVERAGED), ("tet4", "all averaged"), ("hex8", "mean-dilatation")):
        mesh = tc.box_mesh((1.0, 1.0, 0.5), (8, 8, 4), kind)
        top = mesh.nodes[:, 2] > 0.5 - 1e-9
        pull = np.zeros_like(mesh.nodes)
        pull[top, 2] = -0.01
        u, matrix, there = solved(mesh, 0.4999, top | (mesh.nodes[:, 2] < 1e-9), pull, formulation)
        forces[formulation] = (matrix @ u).reshape(-1, 3)[top, 2].sum()
        pressure = there._pressure(u.reshape(-1, 3))[0] if kind == "hex8" else there.pressure(u.reshape(-1, 3))
        largest[formulation] = np.abs(pressure).max()
    assert forces[AVERAGED] / forces["mean-dilatation"] * 1.039 == pytest.approx(1.11, abs=0.02)
    assert forces["all averaged"] / forces["mean-dilatation"] * 1.039 > 1.25
    assert largest[AVERAGED] < 1.4 * largest["mean-dilatation"]


def confined_bar(poisson, cells=40, cfl=0.9):
    """Plane wave in a bar of tetrahedra 2 cells across, thrown at a wall with 0.01 m/s."""
    size, speed, mat = 0.01, 0.01, tc.NeoHookean(1e7, poisson, 1000.0)
    mesh = tc.box_mesh((2 * size, 2 * size, cells * size), (2, 2, cells), "tet4")
    sides = [tc.Support(axis + end, axis) for axis in "xy" for end in ("min", "max")]
    body = tc.Body(mesh, mat, (0.0, 0.0, -speed), contact="zmin", supports=sides, formulation=AVERAGED)
    time = 2.0 * cells * size / mat.wave_speed
    contact = tc.MasslessContact(removal="normal")
    scene = tc.Scene([body], [tc.Plane((0, 0, 0), (0, 0, 1.0))], 1.1 * time, contact=contact)
    history = simulate(scene, cfl=cfl).history
    plateau = mat.density * mat.wave_speed * speed * (2 * size) ** 2
    inside = (history["time"] > 0.3 * time) & (history["time"] < 0.9 * time)
    force = history["contact_force"][:, 2] / plateau
    return force[inside], force.max(), history["impulse"][-1, 2] / (plateau * time) - 1.0, history


@pytest.mark.parametrize(("poisson", "rms"), [(0.4999, 2e-2), (0.3, 4e-3)])
def test_plane_wave_of_an_impact_gives_the_plateau_of_the_wall_force(poisson, rms):
    force, _, impulse, history = confined_bar(poisson)
    assert force.mean() == pytest.approx(1.0, abs=3e-3)
    assert force.std() <= rms
    assert abs(impulse) <= 2e-2
    assert np.abs(history["energy_error"]).max() <= 5e-3
    assert history["static_residual"].max() <= 1e-4


def thrown(mesh, poisson=0.49, law="neo", removal="normal", duration=8e-4, **options):
    body = averaged(mesh, law, poisson, velocity=(0.5, 0.3, -4.0), contact="zmin", **options.pop("body", {}))
    plane = tc.Plane((0, 0, -1e-4), (0, 0, 1.0))
    return tc.Scene([body], [plane], duration, contact=tc.MasslessContact(removal=removal), **options)


def test_cold_sweeps_of_normal_removal_stay_few_near_one_half():
    """Poisson 0.4999: at most 50 sweeps to a residual of 1e-8 (sec. 8 of the method), slivers included."""
    contact = tc.MasslessContact(removal="normal", tolerance=1e-8)
    scene = replace(thrown(MESHES["delaunay"], 0.4999, "linear", duration=3e-4), contact=contact)
    history = simulate(scene).history
    assert history["contact_force"].any()
    assert 10 < history["sweeps"].max() <= 50


REFUSED = {
    "hexahedra": lambda: averaged(block("hex8", 2)),
    "a law without a volume part": lambda: averaged(block("tet4", 2), "svk", 0.45),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bodies_without_this_formulation_are_refused(case):
    with pytest.raises(tc.InputError, match=r"Body\.formulation"):
        REFUSED[case]()


def test_full_removal_near_one_half_and_implicit_steps_are_refused_by_name():
    with pytest.raises(tc.InputError, match=r"MasslessContact\.removal.*0\.49995.*normal"):
        tc.plan(thrown(block("tet4", 2), 0.49995, removal="full"))
    with pytest.raises(tc.InputError, match=r"formulation.*node-averaged.*full"):
        tc.simulate(thrown(block("tet4", 2)), tc.Gonzalez(dt=1e-5))


def test_the_default_is_averaged_where_tetrahedra_would_lock():
    """Above poisson 0.4, of the law at small strains, block by block; a law that cannot keeps full integration."""
    mesh = block("tet4", 2)
    half = mesh.nodes[mesh.cells].mean(axis=1)[:, 2] < 0.09
    mesh = mesh.with_sets(cell_sets={"low": np.flatnonzero(half), "high": np.flatnonzero(~half)})
    stiff, soft = material("neo", poisson=0.3), material("mooney", poisson=0.45)
    assert tc.Body(mesh, {"low": stiff, "high": soft}).element == "tet4 + tet4-node-averaged"
    assert tc.Body(mesh, material("neo", poisson=0.4)).element == "tet4"
    assert tc.Body(mesh, material("svk", poisson=0.45)).element == "tet4"
    assert tc.Body(mesh, soft, formulation="full").element == "tet4"
    assert tc.Body(block("hex8", 2), soft).element == "hex8"


def test_images_share_the_volume_of_their_master():
    """The energy of a periodic body is that of its averages over both sides: its slope along a tied motion."""
    body = averaged(block("tet4", (3, 2, 2), shake=0.2), periodic="xy")
    force, master = force_of(body), body.images.master
    u, way = moved(body.mesh, 0.1)[master], moved(body.mesh, 1.0, 5)[master]
    found, ends, step = force(u), [], 1e-6
    for sign in (1.0, -1.0):
        force(u + sign * step * way)
        ends.append(force.energy)
    assert (ends[0] - ends[1]) / (2 * step) == pytest.approx(np.sum(found * way), rel=1e-6)
    free = force_of(replace(body, periodic=None))
    free(u)
    assert abs(free.energy - ends[0]) > 1e-3 * free.energy


def test_averages_do_not_cross_materials():
    """Two materials: the energy is that of two bodies that share nodes."""
    mesh = MESHES["kuhn"]
    low = mesh.nodes[mesh.cells].mean(axis=1)[:, 0] < 0.1
    both = mesh.with_sets(cell_sets={"low": np.flatnonzero(low), "high": np.flatnonzero(~low)})
    materials = {"low": material("neo", poisson=0.499), "high": material("linear", poisson=0.45)}
    force, u = force_of(tc.Body(both, materials)), moved(mesh, 0.1)
    force(u)
    energy = 0.0
    for part, name in ((low, "low"), (~low, "high")):
        law = TWINS[type(materials[name]).__name__](materials[name].young, materials[name].poisson)
        energy += oracle.NodeAveraged(np.array(mesh.nodes), np.array(mesh.cells)[part], law).energy(u)
    assert force.energy == pytest.approx(energy, rel=1e-12)


RUNS = {
    "normal removal": {},
    "full removal": {"removal": "full"},
    "friction": {"friction": tc.Coulomb(0.4)},
    "friction in the static solve": {"removal": "full", "friction": tc.Coulomb(0.4)},
    "viscosity": {"viscosity": tc.BulkViscosity()},
}


@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=() if case == "normal removal" else pytest.mark.slow) for case in RUNS]
)
def test_impacts_keep_the_ledger_on_both_paths(case, parallel_path, monkeypatch):
    """Momentum and energy; the parallel path has the bits of the serial one."""
    from tcontact.planning import body_plan

    scene = thrown(MESHES["delaunay"], **RUNS[case])
    runs = [simulate(scene)]
    monkeypatch.setitem(body_plan.SMALL, "tet4-node-averaged", 10000)
    runs.append(simulate(scene))
    for history in (run.history for run in runs):
        assert history["contact_force"].any()
        assert history["static_residual"].max() <= 1e-4
        assert np.abs(history["energy_error"]).max() <= 2e-2
        change = history["momentum"] - history["momentum"][0] - history["impulse"]
        assert np.abs(change).max() <= 1e-12 * np.abs(history["momentum"]).max()
    first, second = (run.history["contact_force"] for run in runs)
    count = min(len(first), len(second))
    assert np.abs(first[:count] - second[:count]).max() <= 1e-9 * np.abs(first).max()


COPPER = tc.ElastoPlastic(117e9, 0.35, 8930.0, tc.LinearHardening(4e8, 1e8), specific_heat=383.0)


def test_the_guard_of_metals_is_part_of_energy_force_and_contact_stiffness():
    """Below yield: q/4 (J - 1)^4 of each cell, q = 0.2 mu, and its slopes; a metal is averaged by default."""
    body = tc.Body(MESHES["delaunay"], COPPER, contact="zmin")
    assert body.formulation == AVERAGED
    force, u = force_of(body), moved(body.mesh, 0.02)
    found, ends = force(u), []
    way, step = np.random.default_rng(3).uniform(-1, 1, u.shape), 1e-6
    for sign in (1.0, -1.0):
        force(u + sign * step * way)
        ends.append(force.energy)
    assert (ends[0] - ends[1]) / (2 * step) == pytest.approx(np.sum(found * way), rel=1e-6)
    stiffness, nodes, basis = contact_stiffness(body, "normal", u)
    dofs, spread = spread_of(nodes, basis)
    slope = spread.T @ force.stiffness(u, 1e-6 * 0.06, dofs)[dofs] @ spread
    assert np.abs(stiffness - slope).max() <= 1e-7 * np.abs(slope).max()


def taylor_bar(cells, duration=80e-6):
    """A quarter of a copper bar, 32.4 mm long and of 3.2 mm radius, that hits a wall with 227 m/s."""
    radius, length = 3.2e-3, 32.4e-3
    box = tc.box_mesh((1.0, 1.0, length), (cells, cells, round(length * cells / radius)), "tet4")
    nodes, across = np.array(box.nodes), box.nodes[:, :2]
    largest, distance = across.max(axis=1), np.linalg.norm(across, axis=1)
    scale = np.where(distance > 0.0, largest / np.maximum(distance, 1e-300), 1.0) ** largest
    nodes[:, :2] = radius * across * scale[:, None]
    mesh = tc.Mesh(nodes, box.cells, "tet4", face_sets=box.face_sets)
    sides = [tc.Support("xmin", "x"), tc.Support("ymin", "y")]
    body = tc.Body(mesh, COPPER, (0.0, 0.0, -227.0), contact="zmin", supports=sides)
    return tc.Scene([body], [tc.Plane()], duration, contact=tc.MasslessContact(removal="normal"))


@pytest.mark.parametrize(("cells", "long", "wide", "strain", "error", "smallest"), [
    (3, 21.555, 7.445, (2.5, 4.2), 3e-3, 0.5),
    pytest.param(5, 21.48, 7.48, (3.0, 4.2), 2e-3, 0.4, marks=pytest.mark.slow),
])  # fmt: skip
def test_a_copper_bar_spreads_as_it_should(cells, long, wide, strain, error, smallest):
    """Taylor bar: length and foot radius [mm] after 80 us, plastic strain, ledger, volume changes, sweeps."""
    scene = taylor_bar(cells)
    result = simulate(scene)
    mesh, history, x = scene.bodies[0].mesh, result.history, result.position
    foot = mesh.nodes[:, 2] < 1e-9
    assert 1e3 * np.ptp(x[:, 2]) == pytest.approx(long, abs=0.04)
    assert 1e3 * np.linalg.norm(x[foot, :2], axis=1).max() == pytest.approx(wide, abs=0.06)
    assert strain[0] < history["plastic_strain_max"][-1] < strain[1]
    assert np.abs(history["energy_error"]).max() <= error
    assert history["sweeps"].max() <= 60
    assert history["static_residual"].max() <= 1e-4
    there = oracle.NodeAveraged(np.array(mesh.nodes), np.array(mesh.cells), oracle.NeoHookean(1.0, 0.3))
    average, change, _, _ = there.changes(x - mesh.nodes)
    assert 1.0 + change.min() > smallest
    assert np.abs(average).max() <= 0.03


def test_resume_has_the_same_bits(monkeypatch, tmp_path):
    """Averages are no state: they are made anew from the displacements."""
    scene = thrown(MESHES["delaunay"], removal="full", duration=8e-4, friction=tc.Coulomb(0.3))
    history = split(monkeypatch, tmp_path, scene, 2).history
    assert history["friction_work"][-1] > 0.0
    assert history["static_residual"].max() <= 1e-4
    assert np.abs(history["energy_error"]).max() <= 2e-2


def test_scene_files_keep_the_choice(tmp_path):
    """The default stays the default, and full integration where it was asked for stays that."""
    for formulation, element in ((None, "tet4-node-averaged"), ("full", "tet4")):
        mesh = block("tet4", 2)
        body = tc.Body(mesh, material(poisson=0.45), formulation=formulation)
        tc.save_scene(tc.Scene([body], duration=1.0), tmp_path / "scene.toml")
        assert ("formulation" in (tmp_path / "scene.toml").read_text()) == (formulation == "full")
        assert tc.load_scene(tmp_path / "scene.toml")[0].bodies[0].element == element


def test_the_plan_foresees_the_memory(parallel_path):
    """Lists and numbers of the averages count among those of the force pass; a full body has none of them."""
    scene = thrown(MESHES["kuhn"], duration=2e-5)
    planned = tc.plan(scene)
    foreseen, taken = memory(planned, planned.domains[0])["internal-force"], simulate(scene).memory["internal-force"]
    assert foreseen == pytest.approx(taken, abs=512)
    assert "volume change averaged at the nodes" in planned.describe()
    plain = tc.plan(replace(scene, bodies=[replace(scene.bodies[0], formulation="full")]))
    lists, values = volume_arrays(planned.domains[0], pack_domain(planned.domains[0]))
    assert foreseen - memory(plain, plain.domains[0])["internal-force"] == lists.nbytes + values.nbytes
    assert volume_arrays(plain.domains[0], pack_domain(plain.domains[0])) is None


def test_a_pressure_that_depends_on_heat_is_refused_by_name():
    metal = tc.metal("copper-ofhc", pressure=tc.MieGrueneisen(1.489, 2.0))
    mesh = block("tet4", 2)
    assert tc.Body(mesh, metal).blocks[0].formulation == "full"
    with pytest.raises(tc.InputError, match="the heat of a cell"):
        tc.Body(mesh, metal, formulation="node-averaged")
