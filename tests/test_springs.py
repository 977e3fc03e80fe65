"""Springs, dashpots and point masses on sets of nodes (METHOD 1): frequencies, decay, momenta, refusals."""

import itertools

import numpy as np
import pytest
from scenes import simulate
from stopped_runs import copied, quietly, same

import tcontact as tc
from tcontact.planning.body_plan import SMALL
from tcontact.planning.describe import memory
from tcontact.planning.measured import raw_groups
from tcontact.planning.springs import spring_rates
from tcontact.results import checks as ck
from tcontact.schemes.explicit.state import DomainState

STIFF = tc.NeoHookean(young=1e9, poisson=0.3, density=1000.0)
SPEED = 0.1


def cube(law=STIFF, origin=(0.0, 0.0, 0.0), cells=2, kind="hex8", **options):
    """A cube of 0.1 m, 1 kg, that is nearly rigid for springs of 1e4 N/m."""
    return tc.Body(tc.box_mesh((0.1, 0.1, 0.1), (cells,) * 3, kind, origin), law, **options)


def oscillation(history, axis=2):
    """Return angular frequency [1/s] and decay rate [1/s] of the momentum along an axis, by its passages through 0."""
    time, value = history["time"], history["momentum"][:, axis]
    step = np.flatnonzero(value[:-1] * value[1:] < 0.0)
    passage = time[step] - value[step] * (time[step + 1] - time[step]) / (value[step + 1] - value[step])
    peaks = [np.abs(value[start:end]).max() for start, end in itertools.pairwise(step)]
    half = (passage[-1] - passage[0]) / (len(passage) - 1)
    return np.pi / half, -np.log(peaks[-1] / peaks[0]) / ((len(peaks) - 1) * half)


@pytest.mark.parametrize("damping", [0.0, 10.0])
def test_a_block_on_a_spring_has_its_frequency_and_decay(damping):
    """omega^2 = k/m - (c/2m)^2 and the decay c/2m, to 0.1 %; energy and momentum hold with the columns of springs."""
    stiffness, mass = 1e4, 1.0
    spring = tc.Spring("zmin", stiffness, damping)
    result = simulate(tc.Scene([cube(velocity=(0.0, 0.0, SPEED), springs=[spring])], duration=0.3))
    frequency, decay = oscillation(result.history)
    assert frequency == pytest.approx(np.sqrt(stiffness / mass - (0.5 * damping / mass) ** 2), rel=1e-3)
    assert decay == pytest.approx(0.5 * damping / mass, rel=2e-3, abs=1e-6)
    assert ck.momentum_balance(result, 1e-10).passed
    assert result.history["energy_error"].max() <= 1e-4
    assert (result.history["spring_work"][-1] > 0.0) == (damping > 0.0)


def test_a_point_mass_lowers_the_frequency_of_a_bar():
    """A light bar with a heavy end: omega^2 = E A/L / (M + m/3) to 0.1 %, and Body.mass counts it."""
    young, mass = 1e7, 5.0
    mesh = tc.box_mesh((0.1, 0.1, 1.0), (1, 1, 20))
    stretch = np.zeros((mesh.node_count, 3))
    stretch[:, 2] = SPEED * mesh.nodes[:, 2]
    law = tc.LinearElastic(young, 0.0, 10.0)
    held, weight = tc.Support("zmin", "z"), tc.PointMass("zmax", mass)
    body = tc.Body(mesh, law, stretch, supports=[held], point_masses=[weight])
    assert body.mass == pytest.approx(0.1 + mass, rel=1e-12)
    result = simulate(tc.Scene([body], duration=0.15))
    frequency, _decay = oscillation(result.history)
    ratio = 0.1 / mass  # of the masses: x tan x = ratio
    x = np.sqrt(ratio * (1.0 - ratio / 3.0 + 4.0 * ratio**2 / 45.0))
    assert frequency == pytest.approx(x * np.sqrt(young / 10.0), rel=1e-3)
    assert ck.momentum_balance(result, 1e-10).passed


def test_the_shares_of_point_masses_are_equal_and_survive_redistribution():
    body = cube(point_masses=[tc.PointMass("zmax", 2.0), tc.PointMass("zmin", 0.5)], contact="zmin")
    bare, loaded = (
        tc.plan(tc.Scene([one], [tc.Plane(point=(0.0, 0.0, -1e-3))], 1e-3)).bodies[0] for one in (cube(), body)
    )
    added = loaded.to_user(loaded.lumped) - bare.to_user(bare.lumped)
    assert added[body.mesh.nodes_of("zmax")] == pytest.approx(2.0 / 9.0, rel=1e-12)
    assert added[body.mesh.nodes_of("zmin")] == pytest.approx(0.5 / 9.0, rel=1e-12)
    assert loaded.mass.sum(axis=0) == pytest.approx(3.5 * np.eye(3), rel=1e-12)


@pytest.mark.parametrize("size", ["small", "large"])
def test_two_bodies_on_springs_keep_momentum_and_angular_momentum(size, monkeypatch):
    """Lines between sets of both: nothing outside acts, so both momenta stay to 1e-12."""
    for element in SMALL if size == "large" else ():
        monkeypatch.setitem(SMALL, element, 0)
    springs = [
        tc.Spring("zmax", 1e4, 5.0, to=("far", "zmin")),
        tc.Spring("xmax", 2e4, 10.0, to=("far", "xmax"), rest_length=0.2),
    ]
    near = cube(velocity=(0.0, 0.3, 0.1), springs=springs, name="near")
    far = cube(origin=(0.03, 0.0, 0.3), velocity=(0.1, 0.0, -0.1), name="far")
    result = simulate(tc.Scene([near, far], duration=0.02))
    history = result.history
    for name in ("momentum", "angular_momentum"):
        assert np.abs(history[name] - history[name][0]).max() <= 1e-12 * np.abs(history[name]).max(), name
    assert np.abs(history["spring_force"]).max() == 0.0
    assert history["spring_work"][-1] > 0.0
    assert history["energy_error"].max() <= 1e-3


def test_the_stable_step_holds_with_a_stiff_spring():
    """A spring as stiff as the cells: the step falls, the run stays stable, and the plan says so."""
    soft = tc.NeoHookean(young=1e6, poisson=0.3, density=1000.0)
    free, bound = (cube(soft, velocity=(0.0, 0.0, 1e-3), springs=springs) for springs in ((), [tc.Spring("zmin", 1e9)]))
    scenes = [tc.Scene([body], duration=0.02) for body in (free, bound)]
    steps = [simulate(scene, cfl=0.99) for scene in scenes]
    assert steps[1].dt_limit < 0.2 * steps[0].dt_limit
    early, late = np.array_split(steps[1].history["kinetic"] + steps[1].history["elastic"], 2)
    assert late.max() <= 1.2 * early.max()
    above = quietly(tc.simulate, scenes[1], tc.CentralDifference(dt=1.1 * steps[1].dt_limit))
    assert above.reason == "diverged"
    domain = tc.plan(scenes[1]).domains[0]
    masses = np.asarray(domain.lumped)[np.isclose(domain.reference[:, 2], 0.0)]
    assert spring_rates(domain)[0] == pytest.approx(1e9 * (1.0 / 81.0 / masses).sum(), rel=1e-12)
    assert "they are stiff beside the cells" in tc.plan(scenes[1]).describe()


def test_a_strong_dashpot_is_stable_and_dashpots_on_the_same_nodes_add_up():
    """At c dt/m >> 1 the node creeps; two dashpots of c/2 are one of c."""
    ends = []
    for parts in ([1e5], [5e4, 5e4]):
        springs = [tc.Spring("zmin", 1e3 / len(parts), part) for part in parts]
        result = simulate(tc.Scene([cube(velocity=(0.0, 0.0, SPEED), springs=springs)], duration=2e-3))
        ends.append(result)
        assert ck.momentum_balance(result, 1e-10).passed
        mesh = result.scene.bodies[0].mesh
        assert 0.0 < (result.position - mesh.nodes)[mesh.nodes_of("zmin"), 2].mean() < 0.02 * SPEED * result.time
        assert result.history["energy_error"].max() <= 0.1
    assert ends[0].position == pytest.approx(ends[1].position, abs=1e-9 * SPEED * 2e-3)


def test_springs_in_a_run_with_contact_resume_with_the_same_bits(monkeypatch, tmp_path):
    scheme = tc.CentralDifference(cfl=0.3)
    body = cube(
        tc.NeoHookean(1e7, 0.3, 1000.0), cells=3, contact="zmin", velocity=(0.5, 0.0, -1.0),
        springs=[tc.Spring("zmax", 1e5, 20.0, axes="xy"), tc.Spring("zmax", 1e4, to=(0.05, 0.05, 0.5))],
    )  # fmt: skip
    scene = tc.Scene([body], [tc.Plane(point=(0.0, 0.0, -1e-4))], 3e-3, friction=tc.Coulomb(0.3))
    whole, copies = copied(monkeypatch, tmp_path, scene, scheme, 7)
    assert whole.ok
    assert ck.momentum_balance(whole, 1e-10).passed
    assert np.abs(whole.history["contact_force"]).max() > 0.0
    same(quietly(tc.resume, copies[sorted(copies)[1]], scene, scheme), whole)


def test_a_body_that_a_stretched_spring_pulls_finds_the_wall():
    """The energy of the spring at the start bounds the speed by which faces with contact="auto" are found."""
    counts = []
    for length in (None, 0.1):
        spring = tc.Spring("zmax", 1e4, to=(0.05, 0.05, -1.0), rest_length=length)
        scene = tc.Scene([cube(contact="auto", springs=[spring])], [tc.Plane(point=(0.0, 0.0, -0.3))], duration=0.02)
        counts.append(len(scene.bodies[0].contact_faces))
    assert counts == [0, 4]


def test_a_driven_pair_on_springs_keeps_its_momentum_balance():
    """Two bodies in contact, joined and held by springs, both driven, with gravity and friction: one domain, 1e-10."""
    law = tc.NeoHookean(1e7, 0.3, 1000.0)
    springs = [tc.Spring("zmax", 1e5, 10.0, to=("low", "zmin")), tc.Spring("zmax", 1e4)]
    turn = tc.Support("zmax", "xy", displacement=lambda time: 2e-4 * np.sin(1e3 * time * np.ones(2)))
    lift = tc.Support("zmin", "z", velocity=lambda time: 0.3 * np.sin(1e3 * time))
    up = cube(law, (0.0, 0.0, 0.1001), 3, contact="zmin", velocity=(0.0, 0.0, -1.0), springs=springs, supports=[turn])
    low = cube(law, cells=3, contact="zmax", name="low", supports=[lift])
    scene = tc.Scene([up, low], duration=6e-3, gravity=(0.0, 0.0, -9.81), friction=tc.Coulomb(0.3))
    (domain,) = tc.plan(scene).domains
    assert raw_groups(scene, domain)[-2:] == ("springs", "pair")
    result = simulate(scene, cfl=0.4)
    assert ck.momentum_balance(result, 1e-10).passed
    assert np.abs(result.history["pair_force:body-0-low"]).max() > 0.0
    assert result.history["energy_error"].max() <= 0.01


def test_they_go_through_a_scene_file(tmp_path):
    springs = [
        tc.Spring("zmax", 1e4, 1.0, to="zmin"),
        tc.Spring("zmin", 1e4, to=("other", "zmax"), rest_length=0.01),
        tc.Spring("xmin", 1e4, to=(0.1, 0.2, 0.3), axes="xz"),
        tc.Spring("xmax", 0.0, 3.0),
    ]
    held = tc.Support("ymin", "y", displacement=1e-4)
    body = cube(springs=springs, point_masses=[tc.PointMass("zmax", 0.3)], supports=[held])
    scene = tc.Scene([body, cube(origin=(0.0, 0.0, -0.3), name="other")], duration=1e-3)
    tc.save_scene(scene, tmp_path / "scene.toml")
    loaded = tc.load_scene(tmp_path / "scene.toml")[0]
    assert loaded.bodies[0].springs == body.springs
    assert loaded.bodies[0].point_masses == body.point_masses
    assert loaded.bodies[0].supports == body.supports
    driven = cube(supports=[tc.Support("zmax", "z", velocity=np.sin)])
    with pytest.raises(tc.InputError, match="function of time has no plain data"):
        tc.save_scene(tc.Scene([driven], duration=1.0), tmp_path / "driven.toml")


def test_what_cannot_be_is_refused_by_name():
    def scene(body, *others):
        return tc.plan(tc.Scene([body, *others], [tc.Plane(point=(0.0, 0.0, -1e-3))], 1.0))

    wrong = [
        (lambda: tc.Spring("zmin", -1.0), "Spring.stiffness"),
        (lambda: tc.Spring("zmin", 0.0), "damping is 0 too"),
        (lambda: tc.Spring("zmin", 1.0, to=3.0), "Spring.to"),
        (lambda: tc.Spring("zmin", 1.0, to=(1.0, 2.0)), "Spring.to"),
        (lambda: tc.Spring("zmin", 1.0, axes="xx"), "Spring.axes"),
        (lambda: tc.Spring("zmin", 1.0, rest_length=1.0), "Spring.rest_length"),
        (lambda: tc.PointMass("zmin", 0.0), "PointMass.mass"),
        (lambda: cube(springs=[tc.Spring("nowhere", 1.0)]), "nowhere"),
        (lambda: cube(springs=[3]), "Body.springs"),
        (lambda: scene(cube(springs=[tc.Spring("zmin", 1.0, to="nowhere")])), "nowhere"),
        (lambda: scene(cube(springs=[tc.Spring("zmin", 1.0, to=("who", "zmin"))])), "no such body"),
        (lambda: scene(cube(springs=[tc.Spring("zmin", 1.0, to="zmin")])), "no direction"),
        (lambda: scene(cube(contact="zmin", springs=[tc.Spring("zmin", 1.0)])), "without mass"),
    ]
    for make, text in wrong:
        with pytest.raises(tc.InputError, match=text):
            make()
    implicit = tc.Scene([cube(springs=[tc.Spring("zmin", 1.0)])], duration=1.0)
    with pytest.raises(tc.InputError, match="no springs"):
        tc.simulate(implicit, tc.Midpoint(dt=0.1))
    heavy = tc.Scene([cube(point_masses=[tc.PointMass("zmin", 1.0)])], duration=1.0)
    with pytest.raises(tc.InputError, match="lumped"):
        tc.simulate(heavy, tc.Midpoint(dt=0.1, mass="consistent"))


def test_only_scenes_with_springs_and_functions_have_arguments_for_them():
    """A plain support keeps its two arrays; neither functions of time nor springs add one."""

    def state(**options):
        scene = tc.Scene([cube(**options)], duration=1.0)
        planned = tc.plan(scene)
        start = [np.zeros((27, 3))]
        return DomainState(scene, planned.domains[0], start, start, planned.layout), planned

    held = [tc.Support("zmax", "z")]
    (plain, planned), (driven, _), (sprung, _) = (
        state(supports=held),
        state(supports=[tc.Support("zmax", "z", velocity=np.sin)]),
        state(supports=held, springs=[tc.Spring("zmin", 1e3)]),
    )
    counts = [len(one.serial._parts) for one in (plain, driven, sprung)]
    assert counts == [counts[0]] * 3
    assert plain.timed == []
    assert plain.memory()["supports"] == 9 * (4 + 8)
    assert plain.memory()["boundary-nodes"] == 9 * (4 + 8 * (6 + 6 + 3 + 3))
    assert "springs" not in planned.terms
    assert "spring" not in " ".join(planned.columns)
    for one in (plain, driven, sprung):
        said = tc.plan(one.scene).describe()
        foreseen = memory(planned, one.domain)
        assert all(one.memory()[name] == foreseen[name] for name in ("supports", "boundary-nodes"))
        assert ("driven supports" in said, "springs" in said) == (one is driven, one is sprung)
