"""The stable step follows the shape of the cells, also where their volume stays (METHOD 2)."""

import numpy as np
import oracle
import pytest
from conftest import THREADS
from oracle import meshes
from scenes import block, material, simulate, twin
from stopped_runs import copied, quietly, same

import tcontact as tc
from tcontact.cells.shape_rates import ShapeRates
from tcontact.device import arrays, runtime
from tcontact.planning.planning import plan
from tcontact.run import loop
from tcontact.schemes.explicit.state import DomainState

SIGNS = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]])


def hex_derivatives(r):
    """Derivatives [8, 3] of the shape functions of a hex8."""
    part = 1.0 + SIGNS * r
    return SIGNS * part[:, [1, 2, 0]] * part[:, [2, 0, 1]] / 8.0


CORNERS = {
    "tet4": lambda r: np.array([[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    "hex8": hex_derivatives,
    "wedge6": lambda r: np.array(
        [
            [-(1 - r[2]), -(1 - r[2]), -(1 - r[0] - r[1])], [1 - r[2], 0.0, -r[0]], [0.0, 1 - r[2], -r[1]],
            [-r[2], -r[2], 1 - r[0] - r[1]], [r[2], 0.0, r[0]], [0.0, r[2], r[1]],
        ]
    ),
}  # fmt: skip
G = 3.0**-0.5
POINTS = {
    "tet4": [(np.zeros(3), 1 / 6)],
    "hex8": [(np.array([x, y, z]), 1.0) for x in (-G, G) for y in (-G, G) for z in (-G, G)],
    "wedge6": [
        (np.array([r, s, 0.5 + 0.5 * t]), 1 / 12)
        for r, s in [(1 / 6, 1 / 6), (2 / 3, 1 / 6), (1 / 6, 2 / 3)]
        for t in (-G, G)
    ],
}


def volume(kind, x):
    """The volume of a cell by its Gauss points, which integrate it exactly."""
    return sum(weight * np.linalg.det(x.T @ CORNERS[kind](point)) for point, weight in POINTS[kind])


def rate(kind, x, y):
    """The shape rate of a cell with corners x at rest and y now: slopes of the volume by complex differences."""
    slopes = np.zeros_like(y)
    for place in np.ndindex(y.shape):
        there = y.astype(complex)
        there[place] += 1e-30j
        slopes[place] = volume(kind, there).imag / 1e-30
    values = np.linalg.eigvalsh(slopes.T @ slopes)
    return len(x) * 0.5 * (values[-1] + values.sum()) / (volume(kind, y) * volume(kind, x))


@pytest.mark.parametrize(("kind", "viscosity"), [("hex8", None), ("tet4", tc.BulkViscosity()), ("wedge6", None)])
def test_rates_are_those_of_the_worst_cells(kind, viscosity):
    """Nonlinear bodies, far from the origin and of other sizes and laws (with other numbers of constants, behind those
    of a viscosity), and a linear one beside them."""
    runtime.start("cpu", THREADS)
    rng = np.random.default_rng(3)
    bodies, start, before = [], [], []
    for size, law in ((0.2, "neo"), (0.15, "mooney"), (3e-3, "svk"), (0.1, "linear")):
        mesh = block(kind, 2, (size, size, 0.6 * size), meshes.rotation(5), (70.0 * size, 0.0, 900.0 * size))
        bodies.append(tc.Body(mesh, material(law)))
        bend = meshes.rotation(2) @ (np.diag([1.2, 1.1, 0.6]) + 0.3 * rng.uniform(-1, 1, (3, 3))) - np.eye(3)
        start.append(mesh.nodes @ bend.T + 0.02 * size * rng.standard_normal(mesh.nodes.shape))
        before.append(start[-1] - 0.02 * size * rng.standard_normal(mesh.nodes.shape))
    scene = tc.Scene(bodies=bodies, duration=1.0, viscosity=viscosity)
    (domain,) = plan(scene).domains
    state = DomainState(scene, domain, start, [0 * u for u in start])
    rates = ShapeRates(domain, state.internal_force, state.u, arrays.put(state._started(before)))
    found = rates.measure(0.7)
    for number, body in enumerate(bodies):
        speed = 0.0 if body.linear else body.material.wave_speed
        for place, u in enumerate((start[number], start[number] + 0.7 * (start[number] - before[number]))):
            cells = [rate(kind, body.mesh.nodes[cell], (body.mesh.nodes + u)[cell]) for cell in body.mesh.cells]
            assert found[place, number] == pytest.approx(speed**2 * max(cells), rel=1e-3)


def test_viscosity_does_not_change_the_rates():
    """Its constants stand before those of the law."""
    runtime.start("cpu", THREADS)
    body = tc.Body(block("tet4", 2), material("neo"))
    found = []
    for viscosity in (None, tc.BulkViscosity()):
        scene = tc.Scene(bodies=[body], duration=1.0, viscosity=viscosity)
        (domain,) = plan(scene).domains
        start = [0.1 * body.mesh.nodes]
        state = DomainState(scene, domain, start, [0 * start[0]])
        rates = ShapeRates(domain, state.internal_force, state.u, arrays.put(state._started(start)))
        found.append(rates.measure(0.0))
    assert (found[0] > 0.0).all()
    assert (found[0] == found[1]).all()


def true_step(body, u):
    """2/omega of the free body at displacement u [n, 3], by a dense eigenvalue."""
    there = twin(body)
    quad = oracle.quadrature(there.nodes, there.cells, there.kind)
    if body.formulation == "mean-dilatation":
        stiffness = oracle.MeanDilatation(there.nodes, there.cells, there.law).tangent(u)
    else:
        stiffness = oracle.tangent(quad, there.law, u).toarray()
    mass = oracle.assemble(there.cells, oracle.lumped_cell_mass(quad, there.density), len(there.nodes))
    root = np.repeat(mass, 3) ** -0.5
    return 2.0 / np.sqrt(np.linalg.eigvalsh(root[:, None] * stiffness * root)[-1])


def followed(scene, monkeypatch, every=1, **options):
    """The result of a run, its steps over the true stable step, and the step that its watch held for stable over it."""
    shares, watch = [], loop.Run._watch

    def watched(run, row, number):
        watch(run, row, number)
        if number % every == 0:
            truth = min(true_step(state.plan.body, state.plan.to_user(state.latest())) for state in run.states)
            shares.append((run.dt / truth, run.shape.factor * run._elastic / truth))

    monkeypatch.setattr(loop.Run, "_watch", watched)
    result = quietly(simulate, scene, **options)
    monkeypatch.undo()
    return result, np.array(shares)


def pulled(rate=0.01, stretch=2.4, formulation="mean-dilatation", kind="hex8", speed=1.0):
    """A cube of soft rubber drawn out by `rate` in a step: it grows thin and det F stays near 1."""
    mesh, law = block(kind, 3, (1.0, 1.0, 1.0), shake=0.0), material("neo", poisson=0.49)
    stretching = speed * rate * law.wave_speed / (0.9 / 3)
    return tc.Scene(
        tc.Body(
            mesh,
            law,
            formulation=formulation,
            velocity=lambda x: stretching * (x - 0.5) * (-0.5, -0.5, 1.0),
            supports=[tc.Support(f"z{end}", "z", sign * 0.5 * stretching) for end, sign in (("min", -1), ("max", 1))],
        ),
        duration=(stretch - 1.0) / stretching,
    )


def test_a_body_that_is_drawn_out_at_det_f_of_1_stays_below_the_true_stable_step(monkeypatch):
    """Estimates at intervals, and where det F falls, come too late: the run blows up without the looks."""
    result, shares = followed(pulled(), monkeypatch, every=3)
    steps = np.diff(result.history["time"])
    assert steps.min() < 0.75 * steps[0]
    assert result.history["energy_error"].max() < 1e-4
    assert shares[:, 0].max() < 1.0
    assert shares[:, 1].min() > 0.85
    assert shares[:, 1].max() < 1.1
    monkeypatch.setattr(loop.ShapeWatch, "wanted", lambda *_: False)
    blind = tc.simulate(pulled())
    assert not blind.ok or blind.history["energy_error"].max() > 0.1


def test_a_soft_block_that_is_hit_hard_stays_below_the_true_stable_step(monkeypatch):
    mesh, law = block("hex8", 3, (1.0, 1.0, 1.0), shake=0.0), material("neo", poisson=0.49)
    hit = tc.Body(
        mesh, law, (0.0, 0.0, -0.15 * law.wave_speed), contact="zmin", formulation="mean-dilatation"
    )  # of the speed of shear waves
    scene = tc.Scene(hit, tc.Plane((0.0, 0.0, -0.002)), duration=4.0 / law.wave_speed)
    result, shares = followed(scene, monkeypatch, every=2)
    assert np.diff(result.history["time"]).min() < 0.7 * result.dt
    assert result.history["energy_error"].max() < 0.05
    assert shares[:, 0].max() < 1.0


def test_a_slow_body_is_looked_at_rarely(monkeypatch):
    """One per mille of the wave speed: looks at intervals that grow, a few more at the first touch."""
    looks, look = [], loop.ShapeWatch.look
    monkeypatch.setattr(loop.ShapeWatch, "look", lambda self, *rest: (looks.append(rest[0]), look(self, *rest))[1])
    law = material("neo")
    body = tc.Body(block("hex8", 3, shake=0.0), law, (0.0, 0.0, -1e-3 * law.wave_speed), contact="zmin")
    scene = tc.Scene(body, tc.Plane((0.0, 0.0, -1e-5)), duration=1500 * 0.05 / law.wave_speed)
    result = simulate(scene)
    assert result.steps > 1000
    assert len(looks) < 25
    assert np.diff(result.history["time"])[:-1] == pytest.approx(result.dt, rel=1e-9)


def test_linear_bodies_have_no_looks():
    body = tc.Body(block("hex8", 2), material("linear"), velocity=(1.0, 0.0, 0.0))
    scene = tc.Scene(body, duration=1e-4)
    planned = plan(scene)
    runtime.start("cpu", THREADS)
    run = loop.Run(scene, planned, tc.CentralDifference(), [np.zeros((27, 3))], [np.zeros((27, 3))], 1)
    assert run.shape is None


@pytest.mark.parametrize("viscosity", [None, tc.BulkViscosity()])
def test_a_split_run_follows_the_same_shapes(viscosity, monkeypatch, tmp_path):
    """What the looks remember is in the checkpoint: the same steps, and the same bits."""
    still = pulled(rate=0.02, stretch=2.0)
    physics = tc.Scene(still.bodies, duration=still.duration, viscosity=viscosity)
    whole, copies = copied(monkeypatch, tmp_path, physics, tc.CentralDifference(), 5, frames=2)
    assert whole.ok
    assert np.diff(whole.history["time"]).min() < 0.9 * whole.dt
    for row in sorted(copies)[2::3][:3]:
        same(quietly(tc.resume, copies[row], physics, tc.CentralDifference()), whole)
