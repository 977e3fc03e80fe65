"""A body that starts displaced: strained, moved or in equilibrium with a wall that gives way."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import bar_speed, block, material, simulate, thrown

import tcontact as tc
from tcontact.results.files.vtkhdf import ResultData

SPREAD = 1e-4


def bar(cells=10, **changes):
    """A bar along z, 1 m long, poisson 0."""
    mesh, law = block("hex8", (1, 1, cells), (0.1, 0.1, 1.0), shake=0.0), material("linear", poisson=0.0)
    return tc.Body(**{"mesh": mesh, "material": law, **changes})


def mode(x):
    """The first mode of a free bar."""
    return np.stack([0 * x[:, 2], 0 * x[:, 2], SPREAD * np.cos(np.pi * x[:, 2])], axis=1)


def test_a_bar_let_go_in_its_first_mode_comes_back_with_the_other_sign(tmp_path):
    """Half a period later, u = u0 cos(pi c t / L); the first frame and row are the start."""
    body = bar(displacement=mode)
    c = bar_speed(body.material)
    scene = tc.Scene(bodies=[body], duration=1.0 / c, contact=None)
    result = simulate(scene, out=tmp_path / "out", frames=2)
    start = mode(body.mesh.nodes)
    moved = result.position - body.mesh.nodes
    assert result.time * c >= 1.0
    assert np.abs(moved - start * np.cos(np.pi * c * result.time)).max() <= 1e-3 * SPREAD
    first = ResultData.open(tmp_path / "out" / "result.vtkhdf").frame(0).point_data
    np.testing.assert_allclose(first["displacement"], start, atol=1e-6 * SPREAD)
    stored = 0.25 * body.material.young * 0.01 * (np.pi * SPREAD) ** 2
    assert result.history["elastic"][0] == pytest.approx(stored, rel=0.01)
    assert result.history["kinetic"][0] == 0.0


@pytest.mark.parametrize("law", ["linear", "neo"])
def test_it_is_the_start_from_a_state_with_these_positions(law):
    """To the bit what `initial` does, in a slanted impact."""
    scene = thrown(law, contact=tc.MasslessContact(), duration=1.0)
    state = simulate(replace(scene, duration=1e-9), dt=1e-9)
    rng = np.random.default_rng(3)
    moved = 2e-4 * rng.uniform(-1.0, 1.0, state.position.shape)
    body = scene.bodies[0]
    state = replace(state, position=body.mesh.nodes + moved, velocity=np.array(body.initial_velocity))
    by_state = simulate(scene, initial=state)
    by_field = simulate(replace(scene, bodies=[replace(body, displacement=state.position - body.mesh.nodes)]))
    assert np.array_equal(by_state.position, by_field.position)
    for name, column in by_state.history.items():
        assert np.array_equal(column, by_field.history[name]), name


def test_supports_hold_and_drive_components_from_where_they_start():
    """A bar stretched between held ends rests in its strain; the driven component goes on from its displacement."""
    strain = 1e-3
    held = [tc.Support("zmin", "z"), tc.Support("zmax", "z"), tc.Support("xmin", "x", velocity=0.5)]
    body = bar(supports=held, displacement=lambda x: np.stack([0 * x[:, 0] + 0.02, 0 * x[:, 0], strain * x[:, 2]], 1))
    body = replace(body, velocity=(0.5, 0.0, 0.0))
    scene = tc.Scene(bodies=[body], duration=3.0 / bar_speed(body.material), contact=None)
    result = simulate(scene)
    moved = result.position - body.mesh.nodes
    np.testing.assert_allclose(moved[:, 2], strain * body.mesh.nodes[:, 2], atol=1e-12)
    np.testing.assert_allclose(moved[:, 0], 0.02 + 0.5 * result.time, atol=1e-12)
    stored = 0.5 * body.material.young * strain**2 * 0.01
    np.testing.assert_allclose(result.history["elastic"], stored, rtol=1e-9)


def test_the_state_of_another_run_wins_over_it():
    body = bar(displacement=mode)
    scene = tc.Scene(bodies=[body], duration=1e-4, contact=None)
    first = simulate(scene)
    second = simulate(replace(scene, duration=1e-9), dt=1e-9, initial=first)
    assert second.history["elastic"][0] == pytest.approx(first.history["elastic"][-1], rel=1e-12)


def test_the_gap_at_the_start_is_that_of_the_displaced_nodes():
    """A body drawn out of the wall is fine, one pushed into it is not, unless a penalty gives way by part of a cell."""

    def start(depth, contact=None, **changes):
        body = bar(contact="zmin", **({"displacement": (0.0, 0.0, -depth)} | changes))
        return tc.Scene(bodies=[body], obstacles=[tc.Plane()], duration=1e-5, contact=contact or tc.MasslessContact())

    start(0.0)
    start(-0.3)
    with pytest.raises(tc.InputError, match=r"starts 0\.01 inside"):
        start(0.01)
    inside = bar().mesh.translated((0.0, 0.0, -0.2))
    assert start(-0.2, mesh=inside)
    with pytest.raises(tc.InputError, match="inside"):
        start(0.0, mesh=inside, displacement=None)
    for soft in (tc.MasslessContact(penalty=1e9), tc.PenaltyContact(1e9)):
        stored = simulate(start(0.01, soft)).history["contact"][0]
        put = 0.5 * 1e9 * 0.01 * 0.01**2  # nodes with mass start where they are put, those without come to rest
        assert stored == pytest.approx(put) if isinstance(soft, tc.PenaltyContact) else 0.0 < stored < put
        with pytest.raises(tc.InputError, match="inside"):
            start(0.11, soft)
    with pytest.raises(tc.InputError, match="inside"):
        start(0.01, tc.ImpulseContact())


def test_bodies_apart_when_displaced_are_apart():
    with pytest.warns(tc.OverlapWarning):
        tc.Scene(bodies=[bar(), bar()], duration=1.0, contact=None)
    tc.Scene(bodies=[bar(), bar(displacement=(1.0, 0.0, 0.0))], duration=1.0, contact=None)


def test_contact_nodes_without_mass_start_in_equilibrium_so_the_last_cell_of_a_strained_bar_is_relaxed():
    """The static solve at t = 0 frees the end of stress: of n equally strained cells n - 1 keep their energy."""
    n, strain = 10, 1e-4
    body = bar(n, displacement=lambda x: strain * x * [0.0, 0.0, 1.0], contact="zmin")
    scene = tc.Scene(bodies=[body], obstacles=[tc.Plane(point=(0, 0, -1.0))], duration=1e-6)
    first = simulate(scene).history
    whole = 0.5 * body.material.young * strain**2 * 0.01
    assert first["elastic"][0] == pytest.approx((1.0 - 1.0 / n) * whole, rel=1e-9)
    assert first["energy_error"][0] == 0.0


def test_an_end_deep_inside_an_obstacle_is_refused():
    """Such a start would end in inverted cells, whose message does not name the cause."""
    cube = tc.Body(tc.box_mesh((0.1,) * 3, (2,) * 3), material("linear"), velocity=(0.0, 0.0, -50.0), contact="zmin")
    end = simulate(tc.Scene([cube], [], duration=4e-3))
    wall = tc.Plane((0.0, 0.0, -0.1), (0.0, 0.0, 1.0), name="wall")
    with pytest.raises(tc.InputError, match=r"initial = .* ends 0\.1.* inside obstacle wall"):
        simulate(tc.Scene([cube], [wall], duration=4e-3), initial=end)
