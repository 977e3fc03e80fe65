"""Named warnings of a run: cells that lock, energy that is not kept; test_friction_contact_layer.py has the layers."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scenes import block, material, thrown, wall

import tcontact as tc
from tcontact.run.end_checks import energy_warning


def warned(scene, scheme="central-difference", **options):
    """The result, and the kinds of the warnings of its run; each is in the result, too."""
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        result = tc.simulate(scene, scheme, **options)
    kinds = [one.category for one in seen if issubclass(one.category, RuntimeWarning)]
    assert [str(one.message) for one in seen if issubclass(one.category, RuntimeWarning)] == result.warnings
    return result, kinds


def cantilever(kind, mat, formulation="full"):
    """A short run of one body of that material."""
    mesh = tc.box_mesh((0.2, 0.1, 0.1), (4, 2, 2), kind)
    return tc.Scene([tc.Body(mesh, mat, formulation=formulation, name="rubber")], duration=1e-6)


@pytest.mark.parametrize(
    ("kind", "formulation", "poisson", "locks", "law"),
    [
        ("tet4", "full", 0.4, False, "neo"),
        ("tet4", "full", 0.41, True, "neo"),
        ("tet4", "full", 0.4, False, "mooney"),
        ("tet4", "full", 0.41, True, "mooney"),
        ("tet4", None, 0.49, False, "neo"),
        ("hex8", "full", 0.45, False, "neo"),
        ("hex8", "full", 0.49, True, "neo"),
        ("hex8", "mean-dilatation", 0.49, False, "neo"),
        ("hex8", "reduced", 0.49, False, "neo"),
    ],
)
def test_cells_that_lock_are_named(kind, formulation, poisson, locks, law):
    """By the Poisson's ratio at small strains, which MooneyRivlin has from its moduli."""
    result, kinds = warned(cantilever(kind, material(law, poisson=poisson), formulation))
    assert kinds == [tc.LockingWarning] * locks
    if locks:
        assert "rubber has poisson 0.4" in result.warnings[0]
        assert ("node-averaged" if kind == "tet4" else "mean-dilatation") in result.warnings[0]


def test_a_law_without_mean_dilatation_is_told_another():
    result, kinds = warned(cantilever("hex8", material("svk", poisson=0.48)))
    assert kinds == [tc.LockingWarning]
    assert "NeoHookean" in result.warnings[0]


def halves(share, **options):
    """Two halves of a block thrown apart at that share of its wave speed."""
    mesh, mat = tc.box_mesh((0.1, 0.1, 0.2), (2, 2, 8)), material("neo")
    c = mat.wave_speed

    def velocity(nodes):
        return share * c * np.sign(nodes[:, 2:] - 0.1) * np.array([0.0, 0.0, 1.0])

    return tc.Scene([tc.Body(mesh, mat, velocity=velocity)], duration=0.6 / c, **options)


def test_energy_that_is_not_kept_is_named_with_what_helps():
    """The remedies work: with the step that the warning advises, and with viscosity, the error is below 5 %."""
    result, kinds = warned(halves(0.5))
    assert result.ok
    assert kinds == [tc.EnergyWarning]
    assert result.history["energy_error"].max() > 0.05
    text = result.warnings[0]
    assert "cfl, for example 0.45" in text
    assert "BulkViscosity" in text
    for scene, scheme in (
        (halves(0.5), tc.CentralDifference(cfl=0.45)),
        (halves(0.5, viscosity=tc.BulkViscosity()), "central-difference"),
    ):
        better, none = warned(scene, scheme)
        assert better.history["energy_error"].max() < 0.05
        assert not none


def test_energy_that_is_not_kept_between_the_rows_of_the_history_is_named():
    """The largest error lies between two kept rows, whose own errors are below the bound."""
    whole, _ = warned(halves(0.5))
    result, kinds = warned(halves(0.5), history_every=10)
    assert result.history["energy_error"].max() < 0.05
    assert kinds == [tc.EnergyWarning]
    assert result.warnings == whole.warnings


def test_bodies_that_touch_are_told_of_the_slave_and_of_finer_faces():
    """A smaller step does not help where an edge of the master presses into the slave; a body alone has no slave."""
    from pair_scenes import oblique_cubes

    worst = 0.26, 1e-3
    scene = oblique_cubes(3, 3, "tet4", tc.LinearElastic, 1.0, duration=1e-9)
    for scheme, smaller in ((tc.CentralDifference(), "cfl, for example 0.45"), (tc.CentralDifference(dt=1e-6), "dt")):
        pair, alone = (energy_warning(one, scheme, 1e-6, 0.0, worst) for one in (scene, halves(0.5)))
        assert f"use a smaller {smaller}" in pair
        assert "or name the body with the sharper edge as slave (Pair(slave=)), or refine the contact faces" in pair
        assert "slave" not in alone


def test_bodies_on_a_sampled_distance_are_told_of_its_grid():
    """No smaller step helps where the force of a grid is not along the gradient of its gap."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (1, 1, 1)).translated((0.0, 0.0, 0.1))
    bodies = [tc.Body(mesh, material("neo"), contact="zmin")]
    cam = tc.Sdf.from_function(lambda x: np.linalg.norm(x, axis=1) - 0.02, (-0.05,) * 3, (0.05,) * 3, 8, name="cam")
    grid, ball = (
        energy_warning(tc.Scene(bodies, [one], duration=1e-3), tc.CentralDifference(), 1e-6, 0.0, (0.07, 1e-3))
        for one in (cam, tc.Sphere((0.0, 0.0, 0.0), 0.02))
    )
    assert "the grid of Sdf cam interpolates" in grid
    assert "give it more cells" in grid
    assert "Sdf" not in ball


def test_baselines_that_lose_energy_by_design_are_told_so():
    impulse = thrown("linear", "hex8", contact=tc.ImpulseContact(), gravity=False)
    result, kinds = warned(impulse)
    assert (result.history["energy_error"].max() > 0.05) == (kinds == [tc.EnergyWarning])
    assert kinds
    assert "by design" in result.warnings[0]
    assert "cfl" not in result.warnings[0]
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2))
    squeezed = tc.Body(mesh, material("neo"), displacement=lambda x: -0.1 * x)
    result, kinds = warned(tc.Scene([squeezed], duration=2e-3), tc.Dissipative(dt=5e-5, chi=1.0))
    assert kinds == [tc.EnergyWarning]
    assert "dissipative dissipates by design" in result.warnings[0]


def test_a_body_at_rest_has_no_energy_error():
    """Rounding is no error, whatever it is divided by."""
    mesh = block("hex8", 2)
    body = tc.Body(mesh, material("linear"), displacement=(1e3, 0.0, 0.0), supports=tc.Support("zmin", "xyz"))
    result, kinds = warned(tc.Scene([body], duration=1e-3))
    assert result.ok
    assert not kinds


def test_a_run_that_is_resumed_keeps_its_warnings(monkeypatch, tmp_path):
    from stopped_runs import copied, quietly

    scene = replace(cantilever("tet4", material("neo", poisson=0.48)), duration=1e-4)
    scheme = tc.CentralDifference(dt=1e-6)
    whole, copies = copied(monkeypatch, tmp_path, scene, scheme, 60)
    for folder in copies.values():
        assert quietly(tc.resume, folder, scene, scheme).warnings == whole.warnings
    assert len(whole.warnings) == 1


def test_a_slave_much_stiffer_than_its_master_is_named():
    """Only where it was chosen, and where the other body can be the slave."""
    from pair_scenes import oblique_cubes

    def kinds(ratio, low=None, **options):
        scene = oblique_cubes(3, 3, "tet4", tc.LinearElastic, ratio, duration=1e-9, **options)
        bodies = [scene.bodies[0], replace(scene.bodies[1], supports=low or ())]
        return warned(replace(scene, bodies=bodies))

    chosen = [tc.Pair("up", "low", slave="up")]
    result, found = kinds(10.0, pairs=chosen)
    assert found == [tc.SlaveWarning]
    assert "the slave up of the pair up-low is 10 times stiffer than its master low" in result.warnings[0]
    assert "about 59 products" in result.warnings[0]
    assert "make low the slave" in result.warnings[0]
    assert kinds(4.0, pairs=chosen)[1] == []
    assert kinds(10.0)[1] == []
    assert kinds(0.1, pairs=chosen)[1] == []
    assert kinds(10.0, tc.Support("zmax", "xyz"), pairs=chosen)[1] == []


def test_a_wall_far_away_does_not_hide_the_kinds(recwarn):
    """Named warnings are RuntimeWarnings, as all others of a run: scripts that ask for these still get them."""
    named = (tc.RotationWarning, tc.LockingWarning, tc.EnergyWarning, tc.LayerWarning, tc.SlaveWarning)
    for kind in (*named, tc.PlasticStepWarning, tc.RemovalWarning):
        assert issubclass(kind, RuntimeWarning)
    body = tc.Body(block("tet4", 2), material("neo", poisson=0.45), contact="zmin", formulation="full")
    tc.simulate(tc.Scene([body], [wall(body.mesh, (0, 0, 1.0), 1.0)], 1e-6))
    assert tc.LockingWarning in {one.category for one in recwarn.list}


def test_long_plastic_steps_and_unbalanced_pairs_are_named():
    from types import SimpleNamespace

    from tcontact.run.end_checks import flow_warning, residual_warning

    times = np.array([0.0, 1.0, 2.0, 3.0])
    flow = {"time": times, "plastic_strain_max": np.array([0.0, 0.05, 0.2, 0.21])}
    assert "grew by 0.15 in a step at t = 2 s" in flow_warning(flow, 1.0)
    assert flow_warning(flow | {"plastic_strain_max": flow["plastic_strain_max"] / 2.0}, 1.0) is None
    assert flow_warning({"time": times}, 1.0) is None
    left = {"time": times, "static_residual": np.array([0.0, 1e-3, 0.3, 1e-3])}
    pairs, alone = (SimpleNamespace(body_pairs=given, contact=tc.MasslessContact()) for given in ((1,), ()))
    assert "a residual of 0.3 at t = 2 s" in residual_warning(pairs, left)
    assert residual_warning(alone, left) is None
    assert residual_warning(pairs, left | {"static_residual": np.full(4, 1e-3)}) is None


def test_a_tolerance_that_pairs_miss_is_named():
    """Up to ten times the tolerance, and up to .02 without one, nothing is said; rows above it are counted."""
    from types import SimpleNamespace

    from tcontact.run.end_checks import residual_warning

    rows = {"time": np.arange(4.0), "static_residual": np.array([0.0, 2e-6, 3e-4, 5e-7])}

    def said(tolerance, pairs=(1,)):
        contact = tc.MasslessContact(tolerance=tolerance)
        return residual_warning(SimpleNamespace(body_pairs=pairs, contact=contact), rows)

    text = said(1e-6)
    assert "residual of 0.0003 at t = 2 s" in text
    assert "MasslessContact.tolerance = 1e-06 in 2 of 4 rows" in text
    assert "smaller cfl" in text
    assert "smaller tolerance" in text
    assert said(None) is None
    assert said(4e-5) is None
    assert said(1e-6, ()) is None
    rows["static_residual"] *= 1e-7
    assert said(1e-13) is None  # rounding
    rows["static_residual"][2] = 0.3
    assert "cells of more even shape" in said(None)
    assert "cells of more even shape" in said(0.1)
    empty = {name: values[:0] for name, values in rows.items()}
    assert residual_warning(SimpleNamespace(body_pairs=(1,), contact=tc.MasslessContact()), empty) is None
