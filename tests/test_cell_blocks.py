"""Bodies of several kinds of cells and of several materials: forces, masses, steps, impacts, against exact values."""

import dataclasses

import numpy as np
import oracle
import pytest
from mixed_meshes import OTHERS, SIZE, STEEL, beside, corner, halves, shaken
from oracle import cells as oracle_cells
from oracle import meshes
from scenes import TWINS

import tcontact as tc
from tcontact import checks as ck
from tcontact.cases import layered_bar
from tcontact.cells.internal_force import InternalForce
from tcontact.cells.stress import VonMises
from tcontact.device import arrays
from tcontact.run.worst_cell import worst_cell_of

FINE = tc.CentralDifference(cfl=0.3)


def body_of(mesh, other="stiff", **options):
    """A body whose halves along y are of two materials."""
    return tc.Body(halves(mesh), {"low": STEEL, "high": OTHERS[other]}, **options)


def force_of(body, u):
    """Internal force [n, 3] [N] of the kernels at u [n, 3], in the user's numbering."""
    (domain,) = tc.plan(tc.Scene([body], [], 1e-3, contact=None)).domains
    plan, n = domain.bodies[0], len(domain.reference)
    out = arrays.put(np.zeros(3 * n))
    InternalForce(domain).minus_force(arrays.put(u[plan.node_order].reshape(-1)), out)
    return plan.to_user(-arrays.get(out).reshape(-1, 3) * domain.lumped[:, None])


def twin(material):
    """The law of the oracle with the constants of a material."""
    return TWINS[type(material).__name__](material.young, material.poisson)


def by_definition(body, function, constants=twin):
    """Sum a function (quadrature, law) of the oracle over the blocks of a body, found by the sets of its mesh."""
    total, first = 0.0, 0
    for kind, cells in body.mesh.blocks:
        for name, material in body.material.items():
            inside = np.isin(np.arange(first, first + len(cells)), body.mesh.cell_sets[name])
            if inside.any():
                total = total + function(oracle.quadrature(body.mesh.nodes, cells[inside], kind), constants(material))
        first += len(cells)
    return total


def random_field(mesh, size=0.02, seed=5):
    return size * mesh.shortest_edge * np.random.default_rng(seed).normal(size=(mesh.node_count, 3))


@pytest.mark.parametrize(("make", "other"), [(corner, "stiff"), (beside, "linear")])
def test_force_mass_and_stress_are_those_of_the_cells_one_by_one(make, other, parallel_path):
    body = body_of(shaken(make()), other)
    assert len(body.blocks) == 2 * len(body.mesh.blocks)
    u = random_field(body.mesh)
    wanted = by_definition(body, lambda quad, law: oracle_cells.internal_force(quad, law, u))
    assert np.abs(force_of(body, u) - wanted).max() <= 1e-12 * np.abs(wanted).max()

    def lumped(quad, density):
        share = density * np.einsum("mq,qa->ma", quad.weight, quad.shape)
        return oracle_cells.assemble(quad.cells, share[..., None], body.mesh.node_count)[:, 0]

    plan = tc.plan(tc.Scene([body], [], 1e-3, contact=None)).bodies[0]
    mass = by_definition(body, lumped, lambda material: material.density)
    assert np.abs(plan.to_user(plan.lumped) - mass).max() <= 1e-13 * mass.max()
    assert body.mass == pytest.approx(mass.sum(), rel=1e-13)

    stress, first = VonMises(body)(u), 0
    for kind, cells in body.mesh.blocks:
        for name, material in body.material.items():
            inside = np.isin(np.arange(first, first + len(cells)), body.mesh.cell_sets[name])
            exact = oracle_cells.von_mises(body.mesh.nodes, cells[inside], kind, twin(material), u)
            found = stress[first : first + len(cells)][inside]
            assert np.abs(found - exact).max() <= 1e-9 * exact.max()
        first += len(cells)


def test_patch_of_all_kinds_carries_a_uniform_strain(parallel_path):
    mesh = shaken(corner())
    body = tc.Body(mesh, STEEL)
    u = mesh.nodes @ np.array([[0.02, 0.01, 0.0], [-0.03, 0.01, 0.02], [0.015, 0.0, -0.02]])
    inner = np.setdiff1d(np.arange(mesh.node_count), np.unique(mesh.boundary_faces()))
    force = force_of(body, u)
    assert len(inner) > 0
    assert np.abs(force[inner]).max() <= 1e-12 * np.abs(force).max()
    stress = VonMises(body)(u)
    assert np.ptp(stress) <= 1e-11 * stress.max()


def test_two_materials_in_series_carry_one_stress(parallel_path):
    soft, stiff = tc.LinearElastic(1e7, 0.0, 1000.0), tc.LinearElastic(4e7, 0.0, 2500.0)
    mesh = halves(shaken(beside((4, 3, 4))), axis=2, at=SIZE[2] / 2)
    z, middle, strain = mesh.nodes[:, 2], SIZE[2] / 2, 4e-3
    # the middle plane of the shaken mesh is even again
    nodes = np.array(mesh.nodes)
    nodes[:, 2] = np.where(np.abs(z - middle) < 0.2 * mesh.shortest_edge, middle, z)
    mesh = tc.Mesh(nodes, dict(mesh.blocks), mesh.kind, cell_sets=mesh.cell_sets)
    body, z = tc.Body(mesh, {"low": soft, "high": stiff}), mesh.nodes[:, 2]
    u = np.zeros_like(mesh.nodes)
    u[:, 2] = np.where(z < middle, strain * z, strain * middle + 0.25 * strain * (z - middle))
    force, inner = force_of(body, u), (z > 1e-9) & (z < SIZE[2] - 1e-9)
    assert np.abs(force[inner]).max() <= 1e-12 * np.abs(force).max()
    assert VonMises(body)(u) == pytest.approx(np.full(mesh.cell_count, 1e7 * strain), rel=1e-12)


def test_rigid_motion_gives_no_force(parallel_path):
    body = body_of(shaken(corner()))
    turned = body.mesh.nodes @ meshes.rotation(7).T + (0.3, -0.2, 0.5)
    scale = np.abs(force_of(body, random_field(body.mesh, 1e-3))).max()
    assert np.abs(force_of(body, turned - body.mesh.nodes)).max() <= 1e-9 * scale


def test_stable_step_is_close_below_the_exact_one(parallel_path):
    body = body_of(corner((2, 2, 2)))
    result = tc.simulate(tc.Scene([body], [], 1e-6, contact=None))
    plan = tc.plan(result.scene).bodies[0]
    mass = np.repeat(plan.to_user(plan.lumped), 3)
    zero = np.zeros((body.mesh.node_count, 3))
    stiffness = by_definition(body, lambda quad, law: oracle_cells.tangent(quad, law, zero).toarray())
    root = 1.0 / np.sqrt(mass)
    exact = 2.0 / np.sqrt(np.linalg.eigvalsh(root[:, None] * stiffness * root)[-1])
    assert 0.9 * exact <= result.dt_limit <= exact


def thrown(body, removal, speed=3.0, **options):
    """A body thrown at the plane z = 0."""
    obstacles = options.pop("obstacles", [tc.Plane((0.0, 0.0, -1e-4))])
    model = options.pop("contact", tc.MasslessContact(removal, cell_viscosity=options.pop("cell_viscosity", None)))
    return tc.Scene([body], obstacles, options.pop("duration", 1.2e-3), contact=model, **options)


def falling(mesh, speed=3.0, other="stiff", **options):
    return body_of(mesh, other, velocity=(0.4, 0.2, -speed), contact="zmin", **options)


def rising(mesh, other="stiff"):
    """A body thrown at a ceiling: the last corners of its contact cells are contact nodes."""
    return body_of(mesh, other, velocity=(0.4, 0.2, 3.0), contact="zmax")


CEILING = tc.Plane((0.0, 0.0, SIZE[2] + 1e-4), (0.0, 0.0, -1.0))


@pytest.mark.parametrize("removal", ["normal", "full"])
@pytest.mark.parametrize(
    ("mesh", "way", "count"), [(corner, falling, 4), (corner, rising, 2), (beside, falling, 4), (beside, rising, 4)]
)
def test_impact_on_contact_cells_of_two_kinds_and_materials_keeps_the_ledger(mesh, way, count, removal, parallel_path):
    body = way(mesh())
    scene = thrown(body, removal, **({"obstacles": [CEILING]} if way is rising else {}))
    contact = tc.plan(scene).bodies[0]
    assert len(contact.contact_blocks) == count  # kinds times materials
    result = tc.simulate(scene, FINE)
    for check in (ck.finished(result), ck.momentum_balance(result, 1e-11), ck.energy(result, 6e-3),
                  ck.no_overlap(result), ck.pushing(result), ck.touched(result)):  # fmt: skip
        assert check.passed, check
    assert result.history["static_residual"].max() <= 1e-4
    assert result.history["momentum"][0] == pytest.approx(body.mass * np.array(body.velocity), rel=1e-12)


@pytest.mark.parametrize("way", [falling, rising])
def test_the_mass_of_contact_nodes_goes_to_their_neighbours_by_distance(way):
    body = way(corner())
    scene = thrown(body, "full", **({"obstacles": [CEILING]} if way is rising else {}))
    plan = tc.plan(scene).bodies[0]
    mesh, taken = body.mesh, np.isin(np.arange(body.mesh.node_count), body.contact_nodes)
    wanted = np.zeros(mesh.node_count)
    for block in body.blocks:
        quad = oracle.quadrature(mesh.nodes, block.cells, block.kind)
        share = block.material.density * np.einsum("mq,qa->ma", quad.weight, quad.shape)
        for cell, masses in zip(block.cells, share, strict=True):
            outside = cell[~taken[cell]]
            for node, mass in zip(cell, masses, strict=True):
                if taken[node]:
                    weight = 1.0 / np.linalg.norm(mesh.nodes[outside] - mesh.nodes[node], axis=1)
                    wanted[outside] += mass * weight / weight.sum()
                else:
                    wanted[node] += mass
    assert np.abs(plan.mass - wanted[:, None, None] * np.eye(3)).max() <= 1e-13 * wanted.max()


@pytest.mark.parametrize("mesh", [beside, corner])
def test_the_contact_graph_has_every_pair_of_corners_of_a_cell_once(mesh):
    plan = tc.plan(thrown(rising(mesh()), "full", obstacles=[CEILING])).bodies[0]
    graph, number = plan.contact.graph, 0
    for block in plan.contact_blocks:
        for cell in block.cells[block.contact]:
            own = slice(graph.pair_start[number], graph.pair_start[number + 1])
            places = np.flatnonzero(np.isin(cell, plan.contact.nodes))
            wanted = [(one, two) for one in places for two in places if one <= two]
            assert sorted(map(tuple, graph.pair_corners[own].tolist())) == wanted
            assert np.array_equal(graph.nodes[graph.pair_nodes[own]], cell[graph.pair_corners[own]])
            number += 1
    assert number == len(graph.cells)


def test_the_most_compressed_cell_is_found_among_those_that_can_fail():
    body = body_of(shaken(corner()), "linear")
    u, smallest, first = random_field(body.mesh, 0.05), np.full(body.mesh.cell_count, np.inf), 0
    for kind, cells in body.mesh.blocks:
        gradient = oracle_cells.displacement_gradient(oracle.quadrature(body.mesh.nodes, cells, kind), u)
        smallest[first : first + len(cells)] = np.linalg.det(np.eye(3) + gradient).min(axis=1)
        first += len(cells)
    assert worst_cell_of(body, u) == (smallest.argmin(), pytest.approx(smallest.min()))
    smallest[body.mesh.cell_sets["high"]] = np.inf  # a linear law has no limit
    assert worst_cell_of(body, u, failing=True) == (smallest.argmin(), pytest.approx(smallest.min()))


def test_a_smaller_step_has_a_smaller_energy_error(parallel_path):
    errors = [
        np.abs(tc.simulate(thrown(falling(corner()), "full"), tc.CentralDifference(cfl=cfl)).history["energy_error"])
        .max()
        for cfl in (0.8, 0.2)
    ]  # fmt: skip
    assert errors[1] < 0.2 * errors[0]


@pytest.mark.parametrize(("path", "removal"), [("serial", "full"), ("parallel", "normal")])
def test_two_materials_with_the_same_constants_are_one(path, removal, request):
    if path == "parallel":
        request.getfixturevalue("parallel_path")
    mesh = halves(beside())
    options = {"velocity": (0.4, 0.2, -3.0), "contact": "zmin"}
    bodies = [tc.Body(mesh, material, **options) for material in (STEEL, {"low": STEEL, "high": STEEL})]
    one, two = (tc.simulate(thrown(body, removal), tc.CentralDifference(dt=1e-6)) for body in bodies)
    moved = np.abs(one.position - mesh.nodes).max()
    assert np.abs(one.position - two.position).max() <= 1e-12 * moved
    assert np.abs(one.velocity - two.velocity).max() <= 1e-9 * np.abs(one.velocity).max()
    assert two.dt_limit == pytest.approx(one.dt_limit, rel=1e-6)


def test_the_serial_and_the_parallel_path_agree(request):
    terms = {"friction": tc.Coulomb(0.3), "viscosity": tc.BulkViscosity(), "damping": tc.MassDamping(40.0)}
    scene = thrown(falling(corner()), "full", **terms)
    small = tc.simulate(scene, FINE)
    request.getfixturevalue("parallel_path")
    large = tc.simulate(scene, FINE)
    assert (
        np.abs(small.position - large.position).max()
        <= 1e-11 * np.abs(small.position - scene.bodies[0].mesh.nodes).max()
    )


TERMS = {
    "friction on masses": {"removal": "normal", "friction": tc.Coulomb(0.3)},
    "friction in massless components": {"removal": "full", "friction": tc.Coulomb(0.3)},
    "layers": {"removal": "normal", "friction": tc.FrictionLayer()},
    "penalty": {"contact": tc.PenaltyContact(3e11), "removal": "full"},
    "impulse": {"contact": tc.ImpulseContact(), "removal": "full"},
    "viscosity and damping": {
        "removal": "full", "viscosity": tc.BulkViscosity(), "damping": tc.MassDamping(40.0), "gravity": (0, 0, -9.81),
    },
    "two walls": {"removal": "full", "obstacles": [tc.Plane((0, 0, -1e-4)), tc.Sphere((0.03, 0.02, -0.5001), 0.5)]},
    "depth": {"contact": tc.MasslessContact("full", depth=2), "removal": "full"},
}  # fmt: skip


@pytest.mark.filterwarnings("ignore::tcontact.EnergyWarning")
@pytest.mark.parametrize("name", TERMS)
def test_every_term_keeps_momentum_and_energy(name, parallel_path):
    result = tc.simulate(thrown(falling(corner()), **TERMS[name]), FINE)
    assert result.ok, result.message
    assert ck.momentum_balance(result, 1e-11).passed
    bound = 0.3 if name == "impulse" else 8e-3  # an impulse takes the energy of the contact nodes
    assert ck.energy(result, bound).passed, ck.energy(result, bound)
    assert np.abs(result.history["contact_force"]).max() > 0.0


@pytest.mark.parametrize("formulation", ["mean-dilatation", "reduced"])
def test_a_formulation_goes_to_the_kinds_that_have_it(formulation, parallel_path):
    body = falling(beside(), formulation=formulation)
    assert {block.element for block in body.blocks} == {f"hex8-{formulation}", "wedge6"}
    result = tc.simulate(thrown(body, "full"), FINE)
    assert ck.momentum_balance(result, 1e-11).passed
    assert ck.energy(result, 1e-2).passed
    assert ("hourglass" in result.history) == (formulation == "reduced")


@pytest.mark.parametrize("second_kind", ["hex8", "wedge6"])
def test_a_wave_is_reflected_where_two_materials_meet(second_kind):
    own = layered_bar.scene(cells=30, second_kind=second_kind)
    result = tc.simulate(own)
    failed = [check for check in layered_bar.checks(result) if not check.passed]
    assert not failed
    # the share of the amplitude that a wave of stress leaves behind where the impedance rises from Z1 to Z2
    first, second = own.bodies[0].material.values()
    z1, z2 = (one.density * one.wave_speed for one in (first, second))
    assert layered_bar.levels(own)[-1] == pytest.approx((z2 - z1) / (z2 + z1))
    swapped = dataclasses.replace(own.bodies[0], material={"first": first, "second": first})
    same = tc.simulate(dataclasses.replace(own, bodies=[swapped]))
    assert "share reflected, error" in [check.name for check in layered_bar.checks(result)]
    wrong = layered_bar.checks(dataclasses.replace(same, scene=own))
    assert not all(check.passed for check in wrong)


def test_an_inverted_cell_is_named_with_the_law_of_its_block():
    mesh = halves(beside((4, 2, 4)), axis=2)
    clamps = [tc.Support("zmin", "xyz"), tc.Support("zmax", "xyz", velocity=(0.0, 0.0, -100.0))]
    soft = tc.StVenantKirchhoff(1e5, 0.3, 1000.0)
    body = tc.Body(mesh, {"low": tc.LinearElastic(1e3, 0.3, 1000.0), "high": soft}, supports=clamps)
    result = tc.simulate(tc.Scene([body], [], 2e-3, contact=None))
    assert result.reason == "inverted-cell"
    number = int(result.message.split("cell ")[1].split()[0])
    assert number in mesh.cell_sets["high"]
    assert "StVenantKirchhoff" in result.message or "elliptic" in result.message


def test_a_periodic_body_of_two_materials_keeps_its_momentum(parallel_path):
    mesh = halves(tc.box_mesh((0.04, 0.04, 0.06), (3, 3, 4)), axis=2)
    body = tc.Body(mesh, {"low": STEEL, "high": OTHERS["stiff"]}, (0.0, 0.0, -3.0), "zmin", periodic="xy")
    result = tc.simulate(thrown(body, "full"), FINE)
    assert ck.momentum_balance(result, 1e-11).passed
    assert ck.energy(result, 6e-3).passed
    across = result.velocity[:, :2]
    assert np.abs(across).max() <= 1e-9 * np.abs(result.velocity).max()


def test_a_periodic_body_of_two_kinds_keeps_its_momentum(parallel_path):
    body = falling(beside((4, 2, 3)), periodic="y")
    result = tc.simulate(thrown(body, "full"), FINE)
    assert ck.momentum_balance(result, 1e-11).passed
    assert ck.energy(result, 6e-3).passed


def test_a_body_of_blocks_shares_a_domain_with_another(parallel_path):
    first = falling(corner())
    box = tc.box_mesh((0.03, 0.03, 0.03), (2, 2, 2), "tet4", origin=(0.2, 0.0, 0.0))
    second = tc.Body(box, OTHERS["stiff"], (0.0, 0.0, -3.0), "zmin")
    step = tc.CentralDifference(dt=5e-7)
    plane, model = [tc.Plane((0.0, 0.0, -1e-4))], tc.MasslessContact("full")
    both = tc.simulate(tc.Scene([first, second], plane, 6e-4, contact=model), step)
    for body, part in ((first, slice(0, first.mesh.node_count)), (second, slice(first.mesh.node_count, None))):
        alone = tc.simulate(tc.Scene([body], plane, 6e-4, contact=model), step)
        assert np.abs(both.position[part] - alone.position).max() <= 1e-11


@pytest.mark.filterwarnings("ignore::tcontact.LockingWarning")
def test_the_solver_is_chosen_by_the_cells_at_the_contact():
    mesh = halves(tc.box_mesh((0.06, 0.06, 0.06), (3, 3, 4)), axis=2)
    soft, hard = tc.NeoHookean(1e6, 0.49, 1000.0), tc.NeoHookean(1e7, 0.3, 1000.0)
    words = []
    for low, high in ((soft, hard), (hard, soft)):
        body = tc.Body(mesh, {"low": low, "high": high}, (0.0, 0.0, -1.0), "zmin")
        words.append(tc.plan(thrown(body, "full")).describe())
    assert "MPRGP: poisson 0.49" in words[0]
    assert "Gauss-Seidel" in words[1]


def test_locking_is_warned_of_by_region():
    mesh = halves(beside())
    body = tc.Body(mesh, {"low": STEEL, "high": tc.NeoHookean(1e6, 0.48, 1000.0)}, name="block")
    with pytest.warns(tc.LockingWarning, match="'high' of block") as caught:
        tc.simulate(tc.Scene([body], [], 1e-5, contact=None))
    assert "'low'" not in str(caught[0].message)
