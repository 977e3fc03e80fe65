"""Implicit schemes over whole runs: what they conserve, how contact behaves."""

from dataclasses import replace

import numpy as np
import pytest
import scenes

import tcontact as tc
from tcontact.schemes.implicit.solution.linear_solver import Direct
from tcontact.schemes.implicit.solution.newton import Settings, newton
from tcontact.schemes.implicit.solution.penalty import conserving_pressure
from tcontact.schemes.implicit.solution.sparsity import sparsity_of

RUBBER = tc.NeoHookean(young=1e7, poisson=0.3, density=1000.0)
STIFF = 100.0 * 1e7 / 0.025  # 100 E/h of the cube below
CENTRE = (0.01, 0.02, -0.3)
WALLS = {
    "plane": tc.Plane(),
    "sphere": tc.Sphere(center=CENTRE, radius=0.3),
    "cylinder": tc.Cylinder(point=CENTRE, axis=(1.0, 0.3, 0.0), radius=0.3),
}


def cube(n=4, kind="hex8", material=RUBBER, spin=(0.0, 0.0, 0.0), gap=1e-3, speed=10 / 3.6, **options):
    """The cube of the case cube-impact."""
    mesh = tc.box_mesh(size=(0.1,) * 3, cells=(n,) * 3, kind=kind, origin=(-0.05, -0.05, gap))
    centre = mesh.nodes.mean(axis=0)
    return tc.Body(mesh, material, lambda x: np.cross(spin, x - centre) - (0, 0, speed), contact="zmin", **options)


def scene(body, obstacle=None, contact=None, duration=3e-3, **options):
    walls = [] if obstacle is None else [obstacle]
    return tc.Scene(bodies=[body], obstacles=walls, contact=contact, duration=duration, **options)


def run(scene, scheme, **options):
    result = tc.simulate(scene, scheme=scheme, **options)
    assert result.ok, f"{result.reason}: {result.message}"
    return result


def energy_error(result):
    energy = result.history["energy"]
    return np.abs(energy - energy[0]).max() / energy[0]


def momentum_error(result):
    """What the impulses do not explain, over the largest momentum."""
    history = result.history
    change = history["momentum"] - history["momentum"][0] - history["impulse"] - history["support_impulse"]
    return np.abs(change).max() / np.linalg.norm(history["momentum"], axis=1).max()


def spin_about(result, point):
    """Angular momentum about a point [rows, 3]."""
    history = result.history
    return history["angular_momentum"] - np.cross(point, history["momentum"])


# conservation


@pytest.mark.parametrize(
    ("scheme", "law", "kind", "formulation"),
    [
        (tc.DiscreteGradient, "neo", "hex8", "full"),
        (tc.Gonzalez, "neo", "tet4", "full"),
        (tc.DiscreteGradient, "svk", "tet4", "full"),
        (tc.DiscreteGradient, "mooney", "tet4", "full"),
        (tc.DiscreteGradient, "neo", "hex8", "reduced"),
        (tc.DiscreteGradient, "neo", "hex8", "mean-dilatation"),
    ],
)
def test_free_flight_with_spin_keeps_energy_and_momenta(scheme, law, kind, formulation):
    material = tc.MooneyRivlin.of(1e7, 0.3, 1000.0) if law == "mooney" else scenes.LAWS[law](1e7, 0.3, 1000.0)
    mesh = tc.box_mesh(size=(0.1,) * 3, cells=(2,) * 3, kind=kind)
    spin = np.array([100.0, 50.0, -80.0])
    body = tc.Body(mesh, material, lambda x: np.cross(spin, x) + 80.0 * x[:, [1, 0, 2]], formulation=formulation)
    result = run(scene(body, duration=8e-3), scheme(dt=2e-4))
    history = result.history
    assert history["elastic"].max() > 0.05 * history["energy"][0]
    assert energy_error(result) < 1e-10
    assert momentum_error(result) < 1e-10
    turned = history["angular_momentum"]
    assert np.abs(turned - turned[0]).max() < 1e-10 * np.linalg.norm(turned[0])


@pytest.mark.parametrize("name", WALLS)
@pytest.mark.parametrize("removal", [None, "full"])
def test_spinning_impact_keeps_the_energy(name, removal):
    """Kinetic + elastic + penalty energy; momentum changes by the impulse alone; no torque about round obstacles."""
    contact = tc.PenaltyContact(STIFF) if removal is None else tc.MasslessContact(penalty=STIFF, removal=removal)
    body = cube(3, spin=(300.0, 200.0, 100.0), speed=3.0)
    result = run(scene(body, WALLS[name], contact, 2e-3), tc.DiscreteGradient(dt=4e-5, reproject=False))
    assert np.abs(result.history["contact_force"]).max() > 1e3
    assert energy_error(result) < 1e-10
    assert momentum_error(result) < 1e-10
    turned = spin_about(result, (0.0, 0.0, 0.0) if name == "plane" else CENTRE)
    axis = {"plane": np.array([[0, 0, 1.0]]), "sphere": np.eye(3), "cylinder": WALLS["cylinder"].axis[None]}[name]
    turned = turned @ axis.T
    assert np.abs(turned - turned[0]).max() < 1e-10 * np.linalg.norm(result.history["angular_momentum"], axis=1).max()


def test_gonzalez_keeps_the_energy_of_an_impact():
    body = cube(2)
    result = run(scene(body, tc.Plane(), tc.PenaltyContact(STIFF)), tc.Gonzalez(dt=1e-4))
    assert energy_error(result) < 1e-10
    assert momentum_error(result) < 1e-10


@pytest.mark.parametrize("removal", ["normal", "full"])
def test_reprojection_only_loses_energy(removal):
    contact = tc.MasslessContact(penalty=STIFF, removal=removal)
    result = run(scene(cube(), tc.Plane(), contact), tc.DiscreteGradient(dt=4e-5))
    energy = result.history["energy"]
    assert momentum_error(result) < 1e-10
    assert (np.diff(energy) < 1e-10 * energy[0]).all()
    assert 0.0 < energy_error(result) < 3e-4


@pytest.mark.parametrize("reproject", [True, False])
def test_exact_contact_of_massless_nodes(reproject):
    """No overlap, forces push, momenta exact, energy never rises; also edge first, where nodes meet two walls."""
    for walls, material in (
        ([tc.Plane()], RUBBER),
        ([tc.Plane(), tc.Plane(point=(-0.052, 0, 0), normal=(1, 0, 0))], RUBBER),
    ):
        body = replace(cube(2, material=material), contact=["zmin", "xmin"][: len(walls)], velocity=(-1.0, 0.5, -2.0))
        own = tc.Scene(bodies=[body], obstacles=walls, contact=tc.MasslessContact(), duration=3e-3)
        result = run(own, tc.DiscreteGradient(dt=5e-5, reproject=reproject))
        history, energy = result.history, result.history["energy"]
        assert history["gap_min"].min() > -1e-12
        for axis, _ in zip((2, 0), walls, strict=False):
            assert history["contact_force"][:, axis].max() > 100.0
            assert history["contact_force"][:, axis].min() > -1e-6
        assert momentum_error(result) < 1e-10
        assert (np.diff(energy) < 1e-10 * energy[0]).all()
        assert energy_error(result) < 6e-3
        if len(walls) == 2:
            total = result.obstacle_force
            assert np.allclose(sum(total.values()), -history["contact_force"], atol=1e-9)
            pairs = zip(walls, total.values(), result.obstacle_moment.values(), strict=True)
            torque = -sum(moment + np.cross(wall.point, force) for wall, force, moment in pairs)  # on the body, about 0
            turned = np.diff(history["angular_momentum"], axis=0) / np.diff(history["time"])[:, None]
            assert np.abs(turned - torque[1:]).max() <= 1e-10 * np.abs(torque).max()
            assert np.abs(torque).max() > 1.0


def test_dissipation_keeps_momenta_and_never_raises_the_energy():
    body = replace(cube(2, kind="tet4", spin=(100.0, 300.0, 0.0), speed=0.0), contact=None)
    history = run(scene(body, duration=6e-3), tc.Dissipative(dt=2e-4, chi=0.5)).history
    energy, turned = history["energy"], history["angular_momentum"]
    assert (np.diff(energy) < 1e-13 * energy[0]).all()
    assert energy[-1] < 0.9999 * energy[0]
    assert np.abs(turned - turned[0]).max() < 1e-10 * np.linalg.norm(turned[0])


def test_hht_dissipates_and_its_trapezoidal_limit_does_not():
    """On a linear body, where the energy of both is known to fall or to stay."""
    mesh = tc.box_mesh(size=(0.1,) * 3, cells=(2,) * 3)
    body = tc.Body(mesh, tc.LinearElastic(1e7, 0.3, 1000.0), lambda x: 30.0 * x[:, [1, 0, 2]])
    loss = {}
    for alpha in (0.0, -0.3):
        energy = run(scene(body, duration=6e-3), tc.HilberHughesTaylor(dt=2e-4, alpha=alpha)).history["energy"]
        loss[alpha] = 1.0 - energy[-1] / energy[0]
    assert abs(loss[0.0]) < 1e-10
    assert loss[-0.3] > 0.01


def test_driven_supports_are_paid_for():
    """Energy and momentum balance with supports that move and a body that falls."""
    mesh = tc.box_mesh(size=(0.2, 0.1, 0.1), cells=(3, 2, 2))
    supports = [tc.Support("xmin", "xyz"), tc.Support("xmax", "z", velocity=3.0)]
    body = tc.Body(mesh, RUBBER, supports=supports)
    result = run(scene(body, duration=5e-3, gravity=(0, -50.0, 0)), tc.DiscreteGradient(dt=2e-4))
    history = result.history
    assert np.ptp(history["energy"]) < 1e-10 * history["elastic"].max()
    weight = 1000.0 * 0.2 * 0.01 * np.array([0, -50.0, 0])
    change = (
        history["momentum"] - history["momentum"][0] - history["support_impulse"] - np.outer(history["time"], weight)
    )
    assert np.abs(change).max() < 1e-10 * np.abs(history["momentum"]).max()


# the paper's contrast


def beam(ratio):
    """1 x 0.1 in plane strain, mu 1 MPa, lam = ratio mu, clamped at the left, thrown into its first bending mode."""
    mesh = tc.box_mesh(size=(1.0, 0.1, 0.05), cells=(20, 2, 1))
    mesh = tc.Mesh(mesh.nodes, mesh.cells, "hex8", {"all": np.arange(mesh.node_count)}, mesh.face_sets)
    poisson = ratio / (2.0 * (ratio + 1.0))
    material = tc.NeoHookean(2e6 * (1.0 + poisson), poisson, 1000.0)
    supports = [tc.Support("xmin", "xyz"), tc.Support("all", "z")]
    return tc.Body(
        mesh, material, lambda x: 5.0 * x[:, [0]] ** 2 * (0, 1, 0), supports=supports, formulation="mean-dilatation"
    )


def test_incompressible_beam_diverges_with_the_trapezoidal_rule():
    result = tc.simulate(scene(beam(10.0), duration=2.0), scheme=tc.Trapezoidal(dt=0.02))
    energy = result.history["energy"]
    assert energy.max() > 2.0 * energy[0]
    assert result.reason == "diverged"


def test_incompressible_beam_is_kept_by_the_discrete_gradient():
    assert energy_error(run(scene(beam(10.0), duration=1.6), tc.DiscreteGradient(dt=0.02))) < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("scheme", [tc.DiscreteGradient, tc.Gonzalez])
@pytest.mark.parametrize(("ratio", "dt", "end"), [(10.0, 0.02, 6.0), (1000.0, 0.01, 4.0)])
def test_incompressible_beam_is_kept_for_long(scheme, ratio, dt, end):
    assert energy_error(run(scene(beam(ratio), duration=end), scheme(dt=dt))) < 1e-8


@pytest.mark.slow
def test_nearly_incompressible_beam_fails_with_the_trapezoidal_rule():
    assert not tc.simulate(scene(beam(1000.0), duration=4.0), scheme=tc.Trapezoidal(dt=0.01)).ok


class Particle:
    """One particle of unit mass on a penalty plane z = 0 of unit stiffness: the equations of a step."""

    def __init__(self, height, speed, dt):
        self.height, self.speed, self.dt = height, speed, dt

    def evaluate(self, d):
        pressure, self.slope = conserving_pressure(
            np.array([self.height]), np.array([self.height + d[0, 2]]), np.ones(1)
        )
        force = 2.0 / self.dt**2 * (d - np.array([[0, 0, self.dt * self.speed]])) - [[0, 0, pressure[0]]]
        return force, 2.0 / self.dt * abs(self.speed) + pressure[0]

    def tangent(self, d):
        return 2.0 / self.dt**2 * np.eye(3)[None] - np.diag([0, 0, self.slope[0]])[None]


@pytest.mark.parametrize("step", [1.0, 10.0, 100.0])
def test_a_particle_leaves_a_penalty_plane_as_fast_as_it_came(step):
    """omega dt = 1, 10, 100: restitution 1 to rounding, however the steps fall."""
    solver = Direct(sparsity_of(np.array([[0]]), 1))
    for start in np.linspace(0.05, 1.0, 7):
        height, speed, steps = start * step, -1.0, 0
        while steps == 0 or height < 0 or speed < 0:
            d = newton(Particle(height, speed, step), np.zeros((1, 3)), solver, Settings(1e-14, 60)).d[0, 2]
            height, speed, steps = height + d, 2.0 * d / step - speed, steps + 1
            assert steps < 100
        assert abs(speed - 1.0) < 1e-12


# redistributed mass against ordinary mass


def peaks(contact, steps):
    return [
        run(scene(cube(), tc.Plane(), contact), tc.DiscreteGradient(dt=dt)).history["contact_force"][:, 2].max()
        for dt in steps
    ]


def test_peak_force_of_massless_nodes_does_not_depend_on_the_step():
    massless, ordinary = tc.MasslessContact(penalty=STIFF), tc.PenaltyContact(STIFF)
    assert np.ptp(peaks(massless, (4e-4, 1e-4, 5e-5))) < 0.02 * 3600.0
    few, many = peaks(ordinary, (4e-4, 5e-5))
    assert many > 2.0 * few


@pytest.mark.slow
def test_peak_force_over_five_steps():
    steps = (4e-4, 2e-4, 1e-4, 5e-5, 2.5e-5)
    massless, ordinary = (peaks(c, steps) for c in (tc.MasslessContact(penalty=STIFF), tc.PenaltyContact(STIFF)))
    assert max(massless) < 1.02 * min(massless)
    assert ordinary[-1] > 2.0 * ordinary[0]


def variation(n, contact, solid=False):
    """Total variation of the penetration energy over twice its largest value: 1 = rises and falls once (Fig. 4)."""
    thick = 0.1 if solid else 0.1 / n
    mesh = tc.box_mesh(size=(0.1, thick, 0.1), cells=(n, n if solid else 1, n), origin=(0, 0, 1e-3))
    mesh = tc.Mesh(mesh.nodes, mesh.cells, "hex8", {"all": np.arange(mesh.node_count)}, mesh.face_sets)
    supports = [] if solid else [tc.Support("all", "y")]
    body = tc.Body(mesh, RUBBER, (0, 0, -10 / 3.6), contact="zmin", supports=supports)
    penalty = 1000.0 * 1e7 * n / 0.1
    model = tc.PenaltyContact(penalty) if contact == "ordinary" else tc.MasslessContact(penalty=penalty)
    stored = run(scene(body, tc.Plane(), model, 4e-3), tc.PaperImplicit(cfl=1.0)).history["contact"]
    assert stored[-1] == 0.0
    return np.abs(np.diff(stored)).sum() / (2.0 * stored.max())


def test_penetration_energy_of_the_paper_s_scheme():
    assert variation(12, "massless") <= 1.1
    assert variation(12, "ordinary") >= 3.0


@pytest.mark.slow
@pytest.mark.parametrize(("n", "solid", "least"), [(24, False, 3.0), (8, True, 2.0)])
def test_penetration_energy_of_finer_squares_and_cubes(n, solid, least):
    assert variation(n, "massless", solid) <= 1.1
    assert variation(n, "ordinary", solid) >= least


def test_implicit_and_explicit_runs_agree():
    """At small steps implicit and explicit runs give the same impulse at three times of the contact."""
    own = scene(cube(3), tc.Plane(), tc.MasslessContact(), 3e-3)
    explicit = run(own, tc.CentralDifference(cfl=0.25)).history
    implicit = run(own, tc.DiscreteGradient(cfl=0.25)).history
    for time in (0.8e-3, 1.5e-3, 2.9e-3):
        a, b = (np.interp(time, h["time"], h["impulse"][:, 2]) for h in (explicit, implicit))
        assert abs(a - b) < 2e-3 * explicit["impulse"][-1, 2]


# consistent mass (paper eq. 13)


@pytest.mark.parametrize("removal", ["normal", "full"])
def test_consistent_redistributed_mass(removal):
    from tcontact.planning.planning import plan
    from tcontact.schemes.implicit.solution.mass import consistent_cells

    own = scene(cube(3), tc.Plane(), tc.MasslessContact(penalty=STIFF, removal=removal))
    planned = plan(own).bodies[0]
    total = consistent_cells(planned).sum(axis=(0, 1, 3))
    assert np.allclose(total, np.eye(3), rtol=0, atol=1e-13)  # 1 kg in all
    result = run(own, tc.DiscreteGradient(dt=5e-5, mass="consistent", reproject=False))
    assert energy_error(result) < 1e-10
    assert momentum_error(result) < 1e-10
    lumped = run(own, tc.DiscreteGradient(dt=5e-5, reproject=False))
    assert result.history["impulse"][-1, 2] == pytest.approx(lumped.history["impulse"][-1, 2], rel=0.05)


# more than one body, more than one run


def test_bodies_move_on_their_own_and_a_run_goes_on_where_another_ended():
    """Two cubes in one scene do what each does alone; two runs one after the other are one run; history thinned."""
    left, right = cube(2), cube(2, speed=4.0)
    moved = tc.Mesh(right.mesh.nodes + np.array([0.5, 0, 0]), right.mesh.cells, "hex8", face_sets=right.mesh.face_sets)
    right = replace(right, mesh=moved, velocity=(0, 0, -4.0))
    contact, scheme = tc.MasslessContact(penalty=STIFF), tc.DiscreteGradient(dt=1e-4)
    both = tc.Scene(bodies=[left, right], obstacles=[tc.Plane()], contact=contact, duration=1e-3)
    together = run(both, scheme, history_every=3)
    alone = [run(scene(body, tc.Plane(), contact, 1e-3), scheme) for body in (left, right)]
    assert np.abs(together.position - np.concatenate([one.position for one in alone])).max() < 1e-13
    impulse = sum(one.history["impulse"][-1] for one in alone)
    assert np.abs(together.history["impulse"][-1] - impulse).max() < 1e-12
    half = replace(both, duration=0.5e-3)
    after = run(half, scheme, initial=run(half, scheme))
    assert np.abs(after.position - together.position).max() < 1e-11


def test_frames_and_pressures_of_an_implicit_run(tmp_path):
    """The last frame and the pressures on record belong to the rows of the history."""
    own = scene(cube(2), tc.Plane(), tc.MasslessContact(), 1e-3)
    result = run(own, tc.DiscreteGradient(dt=1e-4), out=tmp_path / "run", frames=4, pressures=True)
    assert (tmp_path / "run" / "result.vtkhdf").stat().st_size > 1000
    total = result.contact_node_force.sum(axis=0)
    assert np.abs(total - result.history["contact_force"][-1]).max() < 1e-9
    assert total[2] > 100.0


@pytest.mark.parametrize("wall", ["sphere", "cylinder"])
@pytest.mark.parametrize("scheme", [tc.DiscreteGradient, tc.Gonzalez])
def test_normal_removal_meets_curved_obstacles(wall, scheme):
    """The static solve moves the nodes along the directions without mass, which are not the normals there."""
    body, contact = cube(3, gap=5e-4, speed=1.5), tc.MasslessContact(removal="normal")
    made = scene(body, WALLS[wall], contact, duration=2e-3)
    result = run(made, scheme(dt=1e-4))
    other = run(made, scheme(dt=1e-4, reproject=False))
    assert result.history["contact_force"].max() > 0.0
    assert energy_error(result) < 1.05 * energy_error(other) < 5e-3
    assert momentum_error(result) < 1e-9
    assert result.history["impulse"][-1] == pytest.approx(other.history["impulse"][-1], rel=1e-3)
