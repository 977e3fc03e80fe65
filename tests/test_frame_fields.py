"""Frames: what they hold is chosen and their size is known before the run."""

from __future__ import annotations

import shutil
from types import SimpleNamespace

import pytest

import tcontact as tc
from tcontact.results import frame_fields
from tcontact.results.files.vtkhdf import ResultData


def scene(cells: int = 6, kind: str = "hex8", bodies: int = 1) -> tc.Scene:
    """Blocks that fly down onto a wall."""
    parts = []
    for index in range(bodies):
        mesh = tc.box_mesh((0.1, 0.1, 0.1), (cells,) * 3, kind, origin=(0.2 * index, 0.0, 1e-4))
        material = tc.NeoHookean(1e7, 0.3, 1000.0)
        parts.append(tc.Body(mesh, material, (0.0, 0.0, -2.0), contact="zmin", name=f"b{index}"))
    return tc.Scene(parts, [tc.Plane()], duration=2e-3, contact=tc.MasslessContact())


@pytest.mark.parametrize(
    ("kind", "bodies", "fields"), [("hex8", 1, None), ("tet4", 1, ["von_mises"]), ("hex8", 2, ["contact_pressure"])]
)
def test_the_size_is_known_before_the_run(kind, bodies, fields, tmp_path):
    case = scene(10, kind, bodies)
    tc.simulate(case, out=tmp_path / "run", frames=12, fields=fields)
    found = (tmp_path / "run" / "result.vtkhdf").stat().st_size
    expected = frame_fields.size(case, 12, fields)
    assert abs(found - expected) < 0.02 * found
    assert len(ResultData.open(tmp_path / "run" / "result.vtkhdf")) == 12


def test_frames_hold_what_was_asked_for_and_the_displacement(tmp_path):
    tc.simulate(scene(4), out=tmp_path, frames=2, fields=["contact_pressure"])
    data = ResultData.open(tmp_path / "result.vtkhdf")
    assert set(data.point_fields) == {"displacement", "contact_pressure"}
    assert data.cell_fields == ()


def test_wrong_fields_and_a_full_disk_are_refused_before_anything_is_written(tmp_path, monkeypatch):
    out = tmp_path / "run"
    for wrong in (["heat"], "von_mises", 5):
        with pytest.raises(tc.InputError, match="von_mises"):
            tc.simulate(scene(2), out=out, frames=2, fields=wrong)
    monkeypatch.setattr(shutil, "disk_usage", lambda place: SimpleNamespace(free=1000))
    with pytest.raises(tc.InputError, match=r"out = .*fewer frames"):
        tc.simulate(scene(2), out=out, frames=2)
    with pytest.raises(tc.InputError, match=r"out = .*another folder$"):
        tc.simulate(scene(2), out=out)
    assert not out.exists()


def test_frames_of_a_scene_with_layers_hold_their_temperature_and_shear(tmp_path):
    mesh = tc.box_mesh((1e-3, 1e-3, 1e-3), (2, 2, 2))
    steel = tc.LinearElastic(2e11, 0.3, 7900.0)
    block = tc.Body(mesh, steel, (10.0, 0.0, -5.0), contact="zmin")
    case = tc.Scene([block], [tc.Plane()], duration=2e-7, contact=tc.MasslessContact(), friction=tc.FrictionLayer())
    result = tc.simulate(case, out=tmp_path, frames=3)
    data = ResultData.open(tmp_path / "result.vtkhdf")
    assert set(frame_fields.available(case)) == {*data.point_fields, *data.cell_fields}
    hottest = data.frame(-1).point_data["layer_temperature"].max()
    assert hottest > 300.0
    assert hottest == result.history["layer_temperature_max"][-1]
