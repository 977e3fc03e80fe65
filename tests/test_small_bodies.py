"""Many steps per launch give what one step per launch gives: rows, frames, stops (kernels/step/serial_step).

The same scene takes both paths here; bodies that take them by their size, with every term, are in test_periodic.py.
"""

from dataclasses import replace

import numpy as np
import pytest
from scenes import simulate, state_of, thrown

import tcontact as tc
from tcontact.device import arrays
from tcontact.planning.body_plan import SMALL
from tcontact.planning.planning import plan

SCENES = {
    "free hexes": lambda: thrown("linear", "hex8", contact=None, duration=4.0),
    "normal removal": lambda: thrown("neo", "hex8", contact=tc.MasslessContact(removal="normal")),
    "full removal, two walls, tets": lambda: thrown("neo", "tet4", walls=2, contact=tc.MasslessContact(removal="full")),
}


@pytest.fixture
def small(monkeypatch):
    """Sets what counts as few cells; True: all, False: none."""

    def switch(on):
        for kind in SMALL:
            monkeypatch.setitem(SMALL, kind, 10**6 if on is True else int(on))

    return switch


@pytest.mark.parametrize("name", SCENES)
def test_rows_and_end_state_are_the_same(name, small):
    scene = SCENES[name]()
    results = []
    for on in (False, True):
        small(on)
        assert ("many steps a launch" in plan(scene).describe()) is on
        results.append(simulate(scene, frames=0))
    one, many = results
    assert many.steps == one.steps > 10
    for column, values in one.history.items():
        scale = np.abs(values[np.isfinite(values)]).max(initial=1e-300)
        if column in ("sweeps", "static_residual", "energy_error"):  # rounding may move where the sweeps end
            assert np.abs(many.history[column] - values).max() <= max(1e-5, 0.1 * scale), column
        elif np.isfinite(values).all():
            assert np.abs(many.history[column] - values).max() <= 1e-6 * scale, column
    assert np.abs(many.position - one.position).max() <= 1e-9 * 0.2
    assert np.abs(many.velocity - one.velocity).max() <= 1e-6 * np.abs(one.velocity).max()


FEW = {
    "full removal": lambda: thrown("neo", "hex8", cells=4, contact=tc.MasslessContact(removal="full")),
    "normal removal, viscosity": lambda: replace(
        thrown("neo", "hex8", cells=4, contact=tc.MasslessContact(removal="normal")), viscosity=tc.BulkViscosity()
    ),
}


@pytest.mark.parametrize("name", ["full removal", pytest.param("normal removal, viscosity", marks=pytest.mark.slow)])
def test_few_contact_cells_on_one_thread_give_the_same(name, small):
    scene = FEW[name]()
    results = []
    for most in (0, 16):  # 64 cells, 16 of them at the wall
        small(most)
        assert plan(scene).domains[0].few_contact_cells is (most == 16)
        assert ("prediction, contact cells" in plan(scene).describe()) is (most == 16)
        results.append(simulate(scene))
    one, other = results
    assert np.abs(one.history["contact_force"]).max() > 0.0
    assert np.abs(one.position - other.position).max() <= 1e-12 * 0.2


@pytest.mark.parametrize("on", [False, True])
def test_what_is_known_of_contact_cells_changes_no_bit(small, on):
    """A pass takes the forces of the last measure where no node has moved since, and none that a product left."""
    small(on)
    mesh = tc.box_mesh(size=(0.2,) * 3, cells=(3, 3, 3))
    rubber = tc.NeoHookean(1e7, 0.3, 1000.0)
    body = tc.Body(mesh, rubber, velocity=(0.0, 0.0, -2.0), contact="zmin")
    scene = tc.Scene([body], [tc.Plane()], 1.0, contact=tc.MasslessContact(removal="normal"))
    dt, steps, ends = 2e-4, 30, []
    trial = arrays.put(np.random.default_rng(0).uniform(-1e-3, 1e-3, 3 * len(mesh.nodes)))
    for way in ("known", "forgotten", "after products"):
        state = state_of(scene, plan(scene).bodies[0], velocity=body.initial_velocity)
        force, rows, known = state.internal_force, [], 0
        state.begin_contact(dt)
        for n in range(steps):
            if way == "forgotten":
                force.surface_known = False
            if way == "after products":
                force.without_boundary().minus_force(trial, arrays.zeros(3 * len(mesh.nodes)))
            known += force.surface_known
            state.advance(dt / 2, dt / 2, dt, n * dt, (dt if n else 0.0, dt))
            rows.append(state.rows(np.array([n * dt])))
        ends.append((np.array(arrays.get(state.u)), np.array(rows)))
        assert (known > steps // 3) is (way == "known")
    for u, rows in ends[1:]:
        assert np.array_equal(u, ends[0][0])
        assert np.array_equal(rows, ends[0][1])


def test_frames_come_at_the_same_times(small, tmp_path):
    import h5py

    scene = SCENES["normal removal"]()
    times = []
    for on in (False, True):
        small(on)
        simulate(scene, frames=7, out=tmp_path / str(on))
        with h5py.File(tmp_path / str(on) / "result.vtkhdf") as file:
            times.append(file["VTKHDF/Steps/Values"][:])
    assert len(times[0]) == 7
    assert np.array_equal(*times)


def test_thinned_history_keeps_the_same_rows_and_sums(small):
    scene = SCENES["normal removal"]()
    small(True)
    whole, thin = simulate(scene), simulate(scene, history_every=7)
    rows = np.append(np.arange(0, whole.steps, 7), whole.steps)
    for column in ("time", "impulse", "energy"):
        assert np.array_equal(thin.history[column], whole.history[column][np.unique(rows)])


def test_a_run_stops_at_the_same_row(small):
    """Far too fast for the mesh: a cell inverts, and nothing after that row is kept."""
    scene = thrown("neo", "hex8", speed=2.5, duration=2.0, contact=tc.PenaltyContact(3e11), gravity=False)
    ends = []
    for on in (False, True):
        small(on)
        result = tc.simulate(scene)
        assert not result.ok
        assert len(result.history["time"]) == result.steps + 1
        ends.append((result.reason, result.steps, result.message))
    assert ends[0] == ends[1]


def test_a_small_body_compiles_one_kernel_only(small):
    """Its force products for the stable step go through the same kernel."""
    scene = SCENES["free hexes"]()
    small(True)
    body = plan(scene).bodies[0]
    state = state_of(scene, body)
    assert state.internal_force.kernel is not None
    assert state.serial is not None
    assert type(state.internal_force.kernel).__name__ != "Prepared"
