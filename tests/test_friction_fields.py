"""Slip distance and friction work of contact nodes in frames: the work is the ledger's, the slip is what nodes slid."""

from __future__ import annotations

import numpy as np
import pytest
from stopped_runs import copied, quietly, same, same_files, scene

import tcontact as tc
from tcontact.results.files.vtkhdf import ResultData

RUBBER = tc.NeoHookean(1e7, 0.3, 1000.0)
FIELDS = ["slip_distance", "friction_work"]
FINE = tc.CentralDifference(cfl=0.5)
LAYER = tc.FrictionLayer()


def blocks():
    """A block that slides on another one, which slides on a floor."""
    lower = tc.box_mesh((0.1, 0.1, 0.04), (3, 3, 2), origin=(0.0, 0.0, 1e-4))
    upper = tc.box_mesh((0.06, 0.06, 0.04), (3, 3, 2), origin=(0.02, 0.02, 0.0402))
    return [
        tc.Body(lower, RUBBER, (0.3, 0.0, -1.0), contact=["zmin", "zmax"], name="lower"),
        tc.Body(upper, RUBBER, (1.0, 0.5, -2.0), contact="zmin", name="upper"),
    ]


SCENES = {
    "normal removal": lambda: scene(contact=tc.MasslessContact("normal"), friction=tc.Coulomb(0.3)),
    "full removal, two bodies": lambda: scene(contact=tc.MasslessContact("full"), friction=tc.Coulomb(0.3), bodies=2),
    "penalty, regularized": lambda: scene(contact=tc.PenaltyContact(3e9), friction=tc.RegularizedCoulomb(0.3, 0.1)),
    "two walls": lambda: scene(
        wall=[tc.Plane(velocity=(0.2, 0.0, 0.0)), tc.Sphere((0.1, 0.03, 0.02), 0.035)], friction=tc.Coulomb(0.3)
    ),
    "periodic": lambda: scene(periodic="xy", contact=tc.MasslessContact("normal"), friction=tc.Coulomb(0.3)),
    "layers": lambda: scene(contact=tc.MasslessContact("normal"), friction=LAYER, duration=3e-4),
    "pair and floor, normal": lambda: tc.Scene(
        blocks(), tc.Plane(), duration=2e-3, contact=tc.MasslessContact("normal"), friction=tc.Coulomb(0.2)
    ),
    "pair and floor, full": lambda: tc.Scene(
        blocks(), tc.Plane(), duration=2e-3, contact=tc.MasslessContact("full"), friction=tc.Coulomb(0.2)
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_the_work_of_all_nodes_is_that_of_the_ledger(name, tmp_path):
    """Sum of friction_work times area weight over the nodes = `friction_work` of the row, in every frame."""
    physics = SCENES[name]()
    result = quietly(tc.simulate, physics, FINE, out=tmp_path / "run", frames=6, fields=FIELDS)
    assert result.ok
    ledger, times = result.history["friction_work"], result.history["time"]
    data = ResultData.open(tmp_path / "run" / "result.vtkhdf")
    areas = np.concatenate([body.contact_areas() for body in tc.plan(physics).bodies])
    assert ledger[-1] > 0.0
    before = np.zeros(len(areas))
    for index, time in enumerate(data.times):
        found = data.frame(index).point_data
        row = np.flatnonzero(times == time)[0]
        assert abs((found["friction_work"] * areas).sum() - ledger[row]) <= 1e-10 * ledger[-1]
        assert (found["slip_distance"] >= before).all()
        before = found["slip_distance"]
    assert (before[areas == 0.0] == 0.0).all()
    assert before.max() > 0.0


@pytest.mark.parametrize("cells", [2, 17], ids=["serial", "parallel"])
@pytest.mark.parametrize("removal", ["normal", "full"])
def test_a_block_that_slides_has_slid_as_far_as_it_went(cells, removal, tmp_path):
    """It lies on the floor under its weight and slides with one speed: every node slips that far, but for its strain,
    and the work is mu times its weight times the way."""
    speed, steps = 10.0, 10 if cells > 2 else 60
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (cells, cells, min(cells, 15)))
    steel = tc.LinearElastic(1e7, 0.0, 1000.0)
    settled = -9.81 * 1000.0 / 1e7 * (0.1 * mesh.nodes[:, 2] - 0.5 * mesh.nodes[:, 2] ** 2)
    displacement = np.column_stack([np.zeros((mesh.node_count, 2)), settled])
    body = tc.Body(mesh, steel, (0.6 * speed, 0.8 * speed, 0.0), contact="zmin", displacement=displacement)
    dt = 0.4 * 0.1 / cells / steel.wave_speed
    physics = tc.Scene(body, tc.Plane(), duration=steps * dt, gravity=(0.0, 0.0, -9.81),
                       contact=tc.MasslessContact(removal), friction=tc.Coulomb(1e-3))  # fmt: skip
    assert tc.plan(physics).domains[0].small == (cells == 2)
    result = quietly(tc.simulate, physics, tc.CentralDifference(dt=dt), out=tmp_path / "run", frames=2, fields=FIELDS)
    found = ResultData.open(tmp_path / "run" / "result.vtkhdf").frame(1).point_data
    low = mesh.nodes_of("zmin")
    way = np.linalg.norm(found["displacement"][low, :2], axis=1)
    pressed = np.linalg.norm(found["contact_force"][low], axis=1) > 0.0 if "contact_force" in found else way > 0.0
    np.testing.assert_allclose(found["slip_distance"][low][pressed], way[pressed], rtol=1e-3)
    assert np.abs(way - speed * result.time).max() < 1e-3 * way.max()
    assert result.history["friction_work"][-1] == pytest.approx(1e-3 * 9.81 * speed * result.time, rel=0.05)


def test_a_split_run_goes_on_with_them(monkeypatch, tmp_path):
    physics = SCENES["normal removal"]()
    whole, copies = copied(monkeypatch, tmp_path, physics, FINE, 7, frames=5, fields=["pressure", *FIELDS])
    row = sorted(copies)[2]
    same(quietly(tc.resume, copies[row], physics, FINE), whole)
    same_files(copies[row], tmp_path / "whole")


def test_they_are_there_only_where_they_are_named(tmp_path):
    """A run without them has no number for them and the same motion; scenes without friction have none."""
    physics = SCENES["normal removal"]()
    plain = quietly(tc.simulate, physics, FINE, out=tmp_path / "plain", frames=2)
    named = quietly(tc.simulate, physics, FINE, out=tmp_path / "named", frames=2, fields="all")
    nodes = len(physics.bodies[0].contact_nodes)
    grown = named.memory["coulomb-friction"] - plain.memory["coulomb-friction"]
    assert grown == 4 * 8 * nodes
    assert np.array_equal(plain.position, named.position)
    data = [ResultData.open(tmp_path / name / "result.vtkhdf") for name in ("plain", "named")]
    further = {*data[1].point_fields, *data[1].cell_fields} - {*data[0].point_fields, *data[0].cell_fields}
    assert further == {*FIELDS, "pressure"}
    with pytest.raises(tc.InputError, match="slip_distance"):
        tc.simulate(scene(), out=tmp_path / "other", frames=2, fields=FIELDS)
