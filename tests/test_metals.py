"""Bodies of metal: what their state does in runs, files, frames and resumed runs; invariance; what other scenes pay."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scenes import block, force_of, state_of
from test_metal_stress import by_points
from test_resume import split

import tcontact as tc
from tcontact.device import arrays
from tcontact.planning.packing import WIDTH
from tcontact.results.files.vtkhdf import ResultData
from tcontact.results.report import run_attributes
from tcontact.show.notebook import EndState

COPPER = tc.ElastoPlastic(117e9, 0.35, 8930.0, tc.LinearHardening(400e6, 100e6), specific_heat=385.0)

HALF = tc.CentralDifference(cfl=0.45)


def hit(formulation=None, material=COPPER, cells=2, duration=1e-6, speed=150.0, **options):
    """A small block of copper on its way into a wall."""
    mesh = block("hex8", cells, size=(2e-3, 2e-3, 2e-3))
    body = tc.Body(mesh, material, (0.0, 0.0, -speed), contact="zmin", formulation=formulation)
    return tc.Scene([body], [tc.Plane()], duration, contact=tc.MasslessContact(removal="normal"), **options)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("metal")
    return tc.simulate(hit(), HALF, out=folder / "run", frames=3), folder / "run"


def test_the_energy_balance_closes_with_the_plastic_work(run):
    result, _folder = run
    history = result.history
    assert result.ok
    assert result.scene.bodies[0].formulation == "mean-dilatation"
    assert history["plastic_work"][-1] > 0.2 * history["kinetic"][0]
    assert history["plastic_heat"] == pytest.approx(0.9 * history["plastic_work"], rel=1e-12)
    assert (np.diff(history["plastic_work"]) >= 0.0).all()
    assert (np.diff(history["plastic_strain_max"]) >= 0.0).all()
    assert history["energy_error"].max() < 0.05  # eight cells; of second order in the step
    stored = history["kinetic"] + history["elastic"] + history["plastic_work"]
    assert history["energy"] == pytest.approx(stored, rel=1e-12)
    assert run_attributes(result)["temperature_max"] == history["temperature_max"].max()


def test_frames_hold_plastic_strain_temperature_and_the_stress_of_the_state(run):
    result, folder = run
    data = ResultData.open(folder / "result.vtkhdf")
    last = data.frame(len(data) - 1)
    strain, temperature, stress = (last.cell_data[name] for name in ("plastic_strain", "temperature", "von_mises"))
    assert 0.0 < strain.max() <= result.history["plastic_strain_max"][-1]
    assert 300.0 <= temperature.min() < temperature.max() <= result.history["temperature_max"][-1]
    assert stress.max() < 1.3 * 500e6  # on the yield surface, not that of an elastic body at this strain
    hardest = 400e6 + 100e6 * result.history["plastic_strain_max"][-1]
    mesh = result.scene.bodies[0].mesh
    _mean, least = by_points(mesh, "hex8", result.position, result.points[0][0], True)
    assert 0.5 * hardest < stress.max() <= hardest / least  # the Kirchhoff stress of every point is at most Y
    assert EndState(result).frame(0).cell_data["von_mises"] == pytest.approx(stress, rel=1e-9)


@pytest.mark.parametrize("formulation", ["mean-dilatation", "reduced"])
def test_resume_has_the_same_bits(monkeypatch, tmp_path, formulation):
    whole = split(monkeypatch, tmp_path, hit(formulation, duration=4e-7), 1, HALF, every=3, pressures=False)
    assert whole.history["plastic_work"][-1] > 0.0


def test_scene_files_give_the_same_scene(tmp_path):
    for number, law in enumerate(
        (tc.LinearHardening(3e8, 1e9), tc.friction_layer.COPPER.hardening_law, tc.JohnsonCook(9e7, 3e8, 0.31))
    ):
        metal = tc.ElastoPlastic(117e9, 0.35, 8930.0, law, heat_share=0.7, specific_heat=385.0, pressure="barrier")
        tc.save_scene(hit(material=metal), tmp_path / f"{number}.toml")
        scene, _options = tc.load_scene(tmp_path / f"{number}.toml")
        assert scene.bodies[0].material == metal
        assert scene.bodies[0].formulation == "mean-dilatation"


def test_a_plastic_block_that_spins_or_flies_does_no_plastic_work():
    mesh = hit().bodies[0].mesh
    rate = 5e4  # 60 m/s at the corners
    velocity = np.cross([0.0, 0.6 * rate, 0.8 * rate], mesh.nodes - mesh.nodes.mean(axis=0)) + np.array(
        [300.0, 0.0, 0.0]
    )
    body = tc.Body(mesh, COPPER, velocity)
    turned = tc.simulate(tc.Scene([body], [], 20.0 * np.pi / rate))
    assert turned.ok
    assert turned.history["plastic_work"][-1] == 0.0
    assert turned.history["plastic_strain_max"][-1] == 0.0


def test_other_units_give_the_same_run():
    """Lengths 1e3, times 1e-2, masses 1e4: every number of the run changes by its unit alone."""
    length, time, mass = 1e3, 1e-2, 1e4
    stress, density = mass / (length * time**2), mass / length**3
    first = tc.simulate(hit(duration=3e-7), HALF)
    law = tc.LinearHardening(400e6 * stress, 100e6 * stress)
    heat = 385.0 * length**2 / time**2
    metal = tc.ElastoPlastic(117e9 * stress, 0.35, 8930.0 * density, law, specific_heat=heat)
    body = first.scene.bodies[0]
    mesh = body.mesh.scaled(length)
    other = tc.Body(mesh, metal, (0.0, 0.0, -150.0 * length / time), contact="zmin")
    scene = tc.Scene([other], [tc.Plane()], 3e-7 * time, contact=tc.MasslessContact(removal="normal"))
    second = tc.simulate(scene, HALF)
    assert len(second.history["time"]) == len(first.history["time"])
    energy = mass * length**2 / time**2
    for name, unit in (("plastic_work", energy), ("temperature_max", 1.0), ("plastic_strain_max", 1.0)):
        assert second.history[name] == pytest.approx(unit * first.history[name], rel=1e-12), name
    assert second.position == pytest.approx(length * first.position, abs=1e-12 * np.abs(first.position).max() * length)


def test_full_integration_is_accepted_with_a_named_warning():
    with pytest.warns(tc.LockingWarning, match="plastic-locking"):
        tc.simulate(hit("full", duration=1e-8))


def test_the_remedy_against_locking_is_one_that_the_metal_has():
    """The pressure of heated cells is not averaged at nodes: tetrahedra of such a metal are integrated fully."""
    mesh = block("tet4", 2, size=(2e-3, 2e-3, 2e-3))
    heated = replace(COPPER, pressure=tc.MieGrueneisen(1.49, 1.99))
    scene = tc.Scene([tc.Body(mesh, heated)], [], 1e-9, contact=None)
    assert scene.bodies[0].formulation == "full"
    with pytest.warns(tc.LockingWarning, match="use hexahedra .* or a pressure without heat, such as 'bulk'"):
        tc.simulate(scene, HALF)
    assert tc.Body(mesh, replace(COPPER, pressure="bulk")).formulation == "node-averaged"


def test_implicit_schemes_refuse_it_by_name():
    with pytest.raises(tc.InputError, match="j2_linear"):
        tc.simulate(hit(), tc.Midpoint(dt=1e-8))


def test_a_scene_without_metals_has_no_byte_and_no_column_of_them():
    scene = hit(material=tc.NeoHookean(117e9, 0.35, 8930.0), duration=1e-7)
    planned = tc.plan(scene)
    assert not any(name.startswith(("plastic", "temperature", "hourglass_work")) for name in planned.layout.place)
    state = state_of(scene, planned.bodies[0])
    assert state.internal_force.memory is None
    assert "memory" not in [name for name, part in state.internal_force.bundle()._asdict().items() if part is not None]


@pytest.mark.parametrize(
    ("formulation", "material"),
    [("mean-dilatation", COPPER), ("reduced", COPPER), ("mean-dilatation", tc.metal("copper-ofhc"))],
    ids=["mean-dilatation", "reduced", "johnson-cook"],
)
def test_a_run_goes_on_from_another_with_its_plastic_state(formulation, material):
    """At the seam nothing flows: the state, the energy and the stable step are those of the end of the first run. With
    a strength that grows with the rate, the rate at the end of the first run is not lost there."""
    first = tc.simulate(hit(formulation, material, duration=2e-7), HALF)
    second = tc.simulate(hit(formulation, material, duration=2e-7), HALF, initial=first)
    for name in ("elastic", "kinetic", "plastic_strain_max", "temperature_max"):
        assert second.history[name][0] == pytest.approx(first.history[name][-1], rel=1e-9), name
    assert second.history["plastic_work"][0] < 1e-9 * first.history["plastic_work"][-1]
    assert second.history["plastic_work"][-1] > 0.0
    assert second.dt == pytest.approx(first.dt, rel=0.2)
    for other in (hit("full", duration=1e-8), hit(formulation, replace(material, initial_temperature=400.0))):
        with pytest.raises(tc.InputError, match="same materials and formulations"):
            tc.simulate(other, initial=first)


def test_the_state_of_a_metal_stays_with_its_cells_however_regions_are_named_and_cut():
    hard = replace(COPPER, hardening=tc.LinearHardening(3e9, 100e6))
    mesh = hit(cells=3).bodies[0].mesh
    left = mesh.cell_centres()[:, 0] < 1e-3
    halves = {"left": np.flatnonzero(left), "right": np.flatnonzero(~left)}
    low = mesh.cell_centres()[:, 2] < 7e-4
    others = {"right": np.flatnonzero(low), "left": np.flatnonzero(~low)}

    def scene(sets, materials, duration=1e-9):
        body = tc.Body(mesh.with_sets(cell_sets=sets), materials, (0.0, 0.0, -150.0), contact="zmin")
        return tc.Scene([body], [tc.Plane()], duration, contact=tc.MasslessContact(removal="normal"))

    first = tc.simulate(scene(halves, {"left": COPPER, "right": hard}, 3e-7), HALF)
    strain, same = first.metals["plastic_strain"], []
    assert strain[left].mean() > 2.0 * strain[~left].mean()
    for sets, materials in (
        (halves, {"right": hard, "left": COPPER}),
        ({"one": halves["right"], "two": halves["left"]}, {"one": hard, "two": COPPER}),
        (others, {"left": COPPER, "right": hard}),
        ({}, COPPER),
    ):
        second = tc.simulate(scene(sets, materials), HALF, initial=first)
        assert (second.metals["plastic_strain"] >= strain - 1e-12).all(), materials  # it never falls
        if sets and sets is not others:
            same.append(second.position)
    assert np.abs(same[0] - same[1]).max() < 1e-15


def test_a_start_from_a_mesh_of_another_shape_is_refused():
    """A translation alone changes nothing; a rotated or stretched mesh would be under stress at once."""
    scene = hit(duration=1e-8)
    first, (body,) = tc.simulate(scene, HALF), scene.bodies
    for mesh in (body.mesh.scaled(1.001), body.mesh.rotated(((0, 0, 1), 0.3))):
        with pytest.raises(tc.InputError, match="nodes at other places in the mesh"):
            tc.simulate(replace(scene, bodies=[replace(body, mesh=mesh)]), HALF, initial=first)
    moved = replace(body, mesh=body.mesh.translated((1e-4, 0.0, 0.0)))
    again = [tc.simulate(replace(scene, bodies=[one]), HALF, initial=first) for one in (body, moved)]
    assert np.abs(again[0].position - again[1].position).max() < 1e-12


def test_a_plastic_state_taken_over_is_neither_warned_of_nor_lost_by_resume(monkeypatch, tmp_path):
    """A step that suits the state is not called too long; checkpoints hold the state also where nothing flows."""
    first = tc.simulate(hit(duration=3e-7), HALF)
    rest = np.zeros_like(first.velocity)
    calm = replace(first, velocity=rest)
    away = replace(hit(duration=2e-7), obstacles=[tc.Plane((0.0, 0.0, -1.0))])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        going = tc.simulate(away, tc.CentralDifference(dt=0.5 * first.dt), initial=calm)
    assert going.history["plastic_strain_max"][0] > 0.0
    split(monkeypatch, tmp_path, away, 1, tc.CentralDifference(cfl=0.2), every=3, pressures=False, initial=calm)


def test_a_run_goes_on_with_a_metal_beside_a_rubber():
    """Only the metal keeps a state; a body of several materials keeps it block by block."""
    mesh = hit(cells=3).bodies[0].mesh
    low = mesh.nodes[mesh.cells].mean(axis=1)[:, 2] < 1e-3
    mesh = mesh.with_sets(cell_sets={"low": np.flatnonzero(low), "high": np.flatnonzero(~low)})
    mixed = {"low": COPPER, "high": tc.NeoHookean(117e9, 0.35, 8930.0)}
    bodies = [
        tc.Body(mesh, mixed, (0.0, 0.0, -150.0), contact="zmin", name="both"),
        tc.Body(block("hex8", 2, (2e-3, 2e-3, 2e-3), shift=(5e-3, 0.0, 0.0)), mixed["high"], name="elastic"),
    ]
    scene = tc.Scene(bodies, [tc.Plane()], 1e-7, contact=tc.MasslessContact(removal="normal"))
    first = tc.simulate(scene, HALF)
    second = tc.simulate(scene, HALF, initial=first)
    assert [len(own) for own in first.points] == [2, 1]
    assert first.points[1][0].size == 0
    for name in ("elastic", "plastic_strain_max", "temperature_max"):
        assert second.history[name][0] == pytest.approx(first.history[name][-1], rel=1e-9), name


def test_the_hourglass_stiffness_follows_the_secant_modulus_and_what_it_lets_go_is_counted():
    """One cell in an hourglass mode: force and energy are Y/(Y + 3 mu ep) of the elastic ones, at least 0.01."""
    body = tc.Body(block("hex8", 1, size=(1e-3, 1e-3, 1e-3), shake=0.0), COPPER, formulation="reduced")
    plan = tc.plan(tc.Scene([body], [], 1e-6)).bodies[0]
    signs = np.sign(plan.reference - plan.reference.mean(axis=0))
    u = np.zeros_like(plan.reference)
    u[:, 2] = 1e-6 * signs[:, 0] * signs[:, 1]

    def hourglass(strain):
        force = force_of(plan)
        arrays.set_values(force.memory, np.full(WIDTH, strain), 6 * WIDTH)
        out = arrays.zeros(u.size)
        force.minus_force(arrays.put(u), out)
        return np.array(arrays.get(out)), force.sum_of("hourglass")

    elastic, energy = hourglass(0.0)
    assert np.abs(elastic).max() > 0.0
    mu = COPPER.lame_mu
    for strain in (1e-3, 0.05, 3.0):
        strength = 400e6 + 100e6 * strain
        share = max(strength / (strength + 3.0 * mu * strain), 0.01)
        soft, left = hourglass(strain)
        assert soft == pytest.approx(share * elastic, rel=1e-9, abs=1e-9 * np.abs(elastic).max())
        assert left == pytest.approx(share * energy, rel=1e-9)
    run = tc.simulate(hit("reduced", cells=3, duration=4e-7), HALF)
    assert run.history["hourglass_work"][-1] > 0.0
    assert (np.diff(run.history["hourglass_work"]) >= 0.0).all()
    assert run.history["energy_error"].max() < 0.02


@pytest.mark.parametrize("formulation", ["mean-dilatation", "reduced"])
def test_the_stable_step_is_estimated_without_yielding(formulation):
    """Products are elastic at any state: what flows is softer, but it unloads elastically."""
    body = tc.Body(block("hex8", 2, size=(1e-3, 1e-3, 1e-3), shake=0.0), COPPER, formulation=formulation)
    plan = tc.plan(tc.Scene([body], [], 1e-6)).bodies[0]
    shear = np.zeros_like(plan.reference)
    shear[:, 0] = plan.reference[:, 2]  # a hundredth of it is three times the strain at which copper yields

    def force(term, share):
        out = arrays.zeros(shear.size)
        term.minus_force(arrays.put(share * shear), out)
        return np.array(arrays.get(out)) / share

    term = force_of(plan)
    small, product = force(term, 1e-6), force(term.without_boundary(), 1e-2)
    assert product == pytest.approx(small, abs=0.02 * np.abs(small).max())
    assert np.abs(force(term, 1e-2)).max() < 0.6 * np.abs(small).max()


def test_the_rate_of_a_run_is_that_of_its_steps():
    """A cube stretched at a constant rate: its stress is A (1 + C ln rate) of a metal that does not harden."""
    size, rate = 1e-3, 1e4
    mesh = block("hex8", 1, size=(size,) * 3, shake=0.0)
    law = tc.JohnsonCook(200e6, 0.0, 1.0, 0.05)
    metal = tc.ElastoPlastic(124e9, 0.34, 8960.0, law)
    x = mesh.nodes - mesh.nodes.mean(axis=0)
    velocity = rate * x * np.array([-0.5, -0.5, 1.0])
    supports = [tc.Support("zmin", "z", velocity[:, 2].min()), tc.Support("zmax", "z", velocity[:, 2].max())]
    body = tc.Body(mesh, metal, velocity, supports=supports, formulation="reduced")
    result = tc.simulate(tc.Scene([body], [], 2e-6), tc.CentralDifference(cfl=0.2))
    history = result.history
    flow = np.diff(history["plastic_strain_max"][-40:]) / np.diff(history["time"][-40:])
    work = np.diff(history["plastic_work"][-40:]) / np.diff(history["plastic_strain_max"][-40:])
    assert work / size**3 == pytest.approx(200e6 * (1.0 + 0.05 * np.log(flow)), rel=5e-3)
    assert flow.mean() == pytest.approx(rate, rel=0.1)


def test_the_stable_step_is_that_without_yield_where_the_yield_stress_is_at_its_largest():
    """Points that have just warmed are above the yield surface: a plastic product gives too long a step."""
    heat = {"thermal_softening": 3.8e-4, "sharpness": 1e-3, "melting_temperature": 1356.0}
    laws = (
        tc.SteinbergGuinan(6.399e8, 1e3, 0.45, largest_yield_stress=6.4e8, **heat),
        tc.SteinbergGuinan(6.4e8, 1e-9, 1.0, **heat),
    )
    supports = [tc.Support(side, side[0]) for side in ("zmin", "xmin", "ymin")]
    limits = []
    for law in laws:
        metal = tc.ElastoPlastic(1.29e11, 0.34, 8930.0, law, specific_heat=383.0)
        body = tc.Body(
            tc.box_mesh((0.01,) * 3, (2, 2, 2)), metal, lambda x: 6e4 * x * (0.5, 0.5, -1.0), supports=supports
        )
        first = tc.simulate(tc.Scene([body], duration=2e-6), threads=2)
        assert first.metals["plastic_strain"].min() > 0.05
        limits.append(tc.simulate(tc.Scene([body], duration=1e-8), initial=first, threads=2).dt_limit)
    assert limits[0] == pytest.approx(limits[1], rel=1e-3)
