"""Runs of bodies with volume changes averaged at nodes: refusals, defaults, impacts, metals, files, memory."""

from dataclasses import replace

import numpy as np
import oracle
import pytest
from contact_stiffness import spread_of
from one_point import moved
from scenes import TWINS, block, material, simulate
from test_node_averaged import AVERAGED, MESHES, averaged, contact_stiffness, force_of
from test_resume import split

import tcontact as tc
from tcontact.planning.describe import memory
from tcontact.planning.domain_packs import pack_domain
from tcontact.planning.node_volumes import volume_arrays


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


def test_viscous_contact_cells_of_the_linear_law_are_those_of_small_strains():
    """Linear and neo-Hookean bodies that slide slowly on a plane differ by their strains."""
    results = []
    for law in ("linear", "neo"):
        scene = thrown(block("tet4", 3), 0.45, law, friction=tc.Coulomb(0.3), duration=4e-4)
        slow = replace(scene.bodies[0], velocity=(5e-4, 3e-4, -4e-3))
        scene = replace(scene, bodies=[slow], obstacles=[tc.Plane((0, 0, -1e-7), (0, 0, 1.0))])
        results.append(tc.simulate(scene, tc.CentralDifference(dt=1.5e-5)).history)
    linear, neo = results
    for name in ("contact_force", "friction_work", "viscous_work"):
        assert np.abs(linear[name]).max() > 0.0
        assert np.allclose(linear[name], neo[name], rtol=0.0, atol=1e-3 * np.abs(neo[name]).max())


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
    shapes = 8 * pack_domain(plain.domains[0]).shapes  # which its tetrahedra store instead
    assert foreseen - memory(plain, plain.domains[0])["internal-force"] == lists.nbytes + values.nbytes - shapes
    assert volume_arrays(plain.domains[0], pack_domain(plain.domains[0])) is None


def test_a_pressure_that_depends_on_heat_is_refused_by_name():
    metal = tc.metal("copper-ofhc", pressure=tc.MieGrueneisen(1.489, 2.0))
    mesh = block("tet4", 2)
    assert tc.Body(mesh, metal).blocks[0].formulation == "full"
    with pytest.raises(tc.InputError, match="the heat of a cell"):
        tc.Body(mesh, metal, formulation="node-averaged")
