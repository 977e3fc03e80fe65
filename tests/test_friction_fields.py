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


FAST = ("normal removal", "full removal, two bodies", "pair and floor, normal")


@pytest.mark.parametrize(
    "name", [name if name in FAST else pytest.param(name, marks=pytest.mark.slow) for name in SCENES]
)
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


@pytest.mark.parametrize(("removal", "cells"), [("normal", 17), ("full", 3)], ids=["normal-parallel", "full-serial"])
def test_a_block_that_slides_has_slid_as_far_as_it_went(cells, removal, tmp_path):
    """It lands softly and slides fast along one line: every node slips as far as it goes, with work mu times force."""
    speed, steps = 10.0, 10 if cells > 3 else 12
    mesh = tc.box_mesh((0.06, 0.06, 0.04), (cells, cells, min(cells, 15)))
    body = tc.Body(mesh, RUBBER, (0.6 * speed, 0.8 * speed, -0.05), contact="zmin")
    dt = 0.4 * 0.04 / cells / RUBBER.wave_speed
    physics = tc.Scene(body, tc.Plane(), duration=steps * dt, gravity=(0.0, 0.0, -9.81),
                       contact=tc.MasslessContact(removal), friction=tc.Coulomb(0.3))  # fmt: skip
    assert tc.plan(physics).domains[0].small == (cells == 3)
    result = quietly(tc.simulate, physics, tc.CentralDifference(dt=dt), out=tmp_path / "run", frames=2, fields=FIELDS)
    found = ResultData.open(tmp_path / "run" / "result.vtkhdf").frame(1).point_data
    low = mesh.nodes_of("zmin")
    way = np.linalg.norm(found["displacement"][low, :2], axis=1)
    assert result.history["contact_nodes"][1:].min() == len(low)
    share = 1.0 if removal == "full" else (result.steps - 1) / result.steps  # in the first step nothing presses yet
    np.testing.assert_allclose(found["slip_distance"][low], share * way, rtol=2e-3)
    assert np.abs(way - speed * result.time).max() < 1e-2 * way.max()
    impulse = result.history["impulse"][-1, 2]
    assert result.history["friction_work"][-1] == pytest.approx(0.3 * impulse * speed, rel=1e-2)


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
