"""Implicit schemes: observed order, convergence of Newton's method, linear solvers, shorter steps where it fails."""

import functools

import numpy as np
import pytest
from test_implicit_runs import RUBBER, STIFF, cube, energy_error, momentum_error, run, scene

import tcontact as tc


@functools.cache
def smooth_problem():
    """A vibration with a finite rotation, and where it ends."""
    mesh = tc.box_mesh(size=(0.1,) * 3, cells=(1,) * 3)
    body = tc.Body(mesh, RUBBER, lambda x: np.cross((0, 100.0, 50.0), x) + 10.0 * x[:, [1, 0, 2]])
    own = scene(body, duration=1e-3)
    return own, run(own, tc.DiscreteGradient(dt=2e-6)).position


@pytest.mark.parametrize(
    "scheme",
    [tc.DiscreteGradient, tc.Gonzalez, tc.TransportAveraging, tc.StressAveraging, tc.Midpoint, tc.Trapezoidal,
     tc.HilberHughesTaylor, tc.PaperImplicit],
    ids=lambda scheme: scheme.name,
)  # fmt: skip
def test_observed_order_in_dt(scheme):
    """A smooth vibration with a finite rotation: positions against a much finer step."""
    own, fine = smooth_problem()
    steps = (5e-5, 2.5e-5) if scheme.order == 2 else (2.5e-5, 1.25e-5)
    first, second = (np.abs(run(own, scheme(dt=dt)).position - fine).max() for dt in steps)
    order = np.log2(first / second)
    assert order >= 1.9 if scheme.order == 2 else 0.9 < order < 1.3
    assert second < 1e-3 * 0.1 * (1 if scheme.order == 2 else 10)


@functools.cache
def on_a_ball(scheme, steps, removal):
    """A block that lands on a sphere while it slides over it, and stays on it: impulse and positions at the end."""
    mesh = tc.box_mesh(size=(0.2, 0.1, 0.1), cells=(3, 2, 1), origin=(-0.1, -0.05, 0.0))
    body = tc.Body(mesh, tc.NeoHookean(1e5, 0.3, 1000.0), (1.0, 0.3, -1.0), contact="zmin")
    ball = tc.Sphere(center=(0.03, 0.01, -0.203), radius=0.2)
    own = scene(body, ball, tc.MasslessContact(removal), 0.02)
    result = run(own, scheme(dt=0.02 / steps))
    assert result.history["contact_force"][-1, 2] > 10.0
    return result.history["impulse"][-1], result.position


HHT = functools.partial(tc.HilberHughesTaylor, alpha=-1.0 / 3.0)


@pytest.mark.parametrize(
    ("scheme", "removal"),
    [(tc.DiscreteGradient, "full"), (tc.Midpoint, "full"), (tc.Midpoint, "normal"), (tc.Trapezoidal, "full"),
     (tc.HilberHughesTaylor, "full"), (HHT, "full"), (HHT, "normal")],
    ids=["discrete-gradient", "midpoint", "midpoint-normal", "trapezoidal", "hht", "hht-third", "hht-third-normal"],
)  # fmt: skip
def test_observed_order_of_exact_contact_where_normals_turn(scheme, removal):
    """Impulse and positions over three halvings of the step, in which nodes close one after the other; one limit."""
    impulses, positions = zip(*(on_a_ball(scheme, steps, removal) for steps in (40, 80, 160, 320)), strict=True)
    for values in (impulses, positions):
        coarse, fine = (np.abs(values[i] - values[i + 1]).max() for i in (0, 2))
        assert 0.5 * np.log2(coarse / fine) > 1.75
    other = on_a_ball(tc.DiscreteGradient, 320, removal)[0]
    assert np.abs(impulses[-1] - other).max() < 1e-5 * np.abs(other).max()


def test_newton_converges_quadratically(capsys):
    result = run(scene(cube(), tc.Plane(), tc.PenaltyContact(STIFF)), tc.DiscreteGradient(dt=1e-4, verbose=True))
    assert result.history["sweeps"][1:].mean() <= 5.0
    lines = [line for line in capsys.readouterr().out.splitlines() if "newton" in line]
    residuals = np.array([float(line.split()[-1]) for line in lines])
    falls = [
        (a, b)
        for a, b, line in zip(residuals[:-1], residuals[1:], lines[1:], strict=True)
        if "newton 0" not in line and 1e-6 < a < 1e-3
    ]
    assert len(falls) > 10
    assert max(b / a**2 for a, b in falls) < 1e4
    assert np.median([b / a for a, b in falls]) < 1e-3


def test_krylov_and_direct_solvers_agree():
    own = scene(cube(3), tc.Plane(), tc.MasslessContact(), 6e-4)
    found = [run(own, tc.DiscreteGradient(dt=1e-4, solver=kind)) for kind in ("direct", "krylov")]
    assert np.abs(found[0].position - found[1].position).max() < 1e-12
    assert np.abs(found[0].velocity - found[1].velocity).max() < 1e-8


def test_krylov_solutions_conserve_over_many_steps():
    """Residuals add up: inexact solves that stopped just below the tolerance lost 2e-10 within six steps of 16^3."""
    result = run(scene(cube(7), tc.Plane(), tc.PenaltyContact(STIFF)), tc.DiscreteGradient(dt=1e-4, solver="krylov"))
    assert energy_error(result) < 1e-11
    assert momentum_error(result) < 1e-11


@pytest.mark.parametrize("far", [0.0, 1e4])
def test_massless_nodes_far_from_where_they_started(far):
    """Rounding of large displacements is no reason to stop."""
    mesh = tc.box_mesh(size=(0.06,) * 3, cells=(2,) * 3, origin=(0, 0, 1e-3))
    body = tc.Body(mesh, RUBBER, (1.0, 0, -1.0), contact="zmin", displacement=(far, 0, 0))
    result = run(scene(body, tc.Plane(), tc.MasslessContact("full"), 4e-3), tc.DiscreteGradient(dt=1e-4))
    assert result.history["contact_force"][:, 2].max() > 100.0
    assert momentum_error(result) < 1e-10


def test_steps_are_halved_where_newton_fails_and_recover(monkeypatch):
    """With few iterations allowed the touch needs smaller steps; energy and impulse stay exact."""
    from tcontact.schemes.implicit.solution import body as stepped

    tried = []
    take = stepped.ImplicitBody.take
    monkeypatch.setattr(stepped.ImplicitBody, "take", lambda self, level, dt: tried.append(dt) or take(self, level, dt))
    scheme = tc.DiscreteGradient(dt=4e-4, iterations=3)
    result = run(scene(cube(2), tc.Plane(), tc.PenaltyContact(STIFF)), scheme)
    assert min(tried) < 0.6 * scheme.dt
    assert scheme.dt in tried[next(i for i, dt in enumerate(tried) if dt < scheme.dt) :]
    assert energy_error(result) < 1e-9
    assert momentum_error(result) < 1e-9
    assert result.steps == 8


def test_a_run_that_cannot_go_on_stops_with_a_remedy():
    """A body crushed faster than anything can follow."""
    mesh = tc.box_mesh(size=(0.1,) * 3, cells=(1,) * 3)
    body = tc.Body(mesh, tc.StVenantKirchhoff(1e7, 0.3, 1000.0), lambda x: -1e5 * x)
    with np.errstate(all="ignore"):
        result = tc.simulate(scene(body, duration=1.0), scheme=tc.DiscreteGradient(dt=1.0, iterations=1))
    assert result.reason in ("not-converged", "inverted-cell")
    assert "use" in result.message or "refine" in result.message
    assert len(result.history["time"]) >= 1
