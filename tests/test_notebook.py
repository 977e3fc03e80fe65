"""A result in a notebook: a table that says how it went and a picture of the end."""

from __future__ import annotations

import base64
import io
import re
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

import tcontact as tc
from tcontact.results.files.vtkhdf import ResultData
from tcontact.show.notebook import EndState


def run(out=None, bodies=1):
    """Blocks that strike a wall."""
    parts = []
    for index in range(bodies):
        mesh = tc.box_mesh((0.1, 0.1, 0.1), (3, 3, 3), origin=(0.2 * index, 0.0, 1e-4))
        parts.append(
            tc.Body(mesh, tc.NeoHookean(1e7, 0.3, 1000.0), (0, 0, -2.0), contact="zmin", name=f"block {index}")
        )
    scene = tc.Scene(parts, [tc.Plane()], duration=6e-4, contact=tc.MasslessContact())
    return tc.simulate(scene, out=out, frames=2)


def test_a_result_shows_a_table_and_a_picture():
    result = run()
    text = result._repr_html_()
    assert f"after {result.steps} steps" in text
    assert f"{result.history['energy_error'].max():.2g} at most" in text
    (data,) = re.findall(r"base64,([^\"]+)", text)
    image = Image.open(io.BytesIO(base64.b64decode(data)))
    assert image.size == (640, 480)
    assert base64.b64decode(data) == result._repr_png_()
    assert len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 500


@pytest.mark.parametrize("bodies", [1, 2])
def test_the_end_in_memory_is_the_last_frame_of_the_file(bodies, tmp_path):
    result = run(tmp_path, bodies)
    stored, end = ResultData.open(tmp_path / "result.vtkhdf"), EndState(result)
    np.testing.assert_array_equal(end.points, stored.points)
    last, there = stored.frame(-1), end.frame(0)
    assert last.time == there.time
    assert end.cell_fields == (("von_mises", "body") if bodies == 2 else ("von_mises",))
    if bodies == 2:
        assert end.attributes["bodies"] == stored.attributes["bodies"] == ["block 0", "block 1"]
    for name in end.cell_fields[1:]:
        np.testing.assert_array_equal(there.cell_data[name], last.cell_data[name])
    np.testing.assert_allclose(there.point_data["displacement"], last.point_data["displacement"], atol=1e-15)
    np.testing.assert_allclose(there.cell_data["von_mises"], last.cell_data["von_mises"], rtol=1e-9)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_broken_end_is_still_shown():
    result = run()
    broken = replace(result, position=np.full_like(result.position, np.nan), ok=False, message="a < b & c")
    assert "a &lt; b &amp; c" in broken._repr_html_()
