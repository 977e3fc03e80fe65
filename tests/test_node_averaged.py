"""Tetrahedra with the volume change averaged at nodes: force against numpy, invariants, locking, contact stiffness."""

from dataclasses import replace

import numpy as np
import oracle
import pytest
from contact_stiffness import spread_of
from one_point import Force, check_turning, moved
from oracle import meshes
from scenes import TWINS, block, material, simulate, stable_steps, state_of
from scipy.spatial import Delaunay

import tcontact as tc
from tcontact.cells.stress import VonMises
from tcontact.device import arrays

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
    check_turning(body, force, 0.2)


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
    from tcontact.kernels.language.bundles import Contact, Launch
    from tcontact.kernels.language.compile_options import KEEP_VECTORS, compiled_with
    from tcontact.kernels.language.signatures import arguments, kernel_of, signature_of
    from tcontact.kernels.language.solve_bundles import Pairs
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
            tangent(body, contact, pairs, 0)
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
