"""The film of a run: every frame in it, and what there is without the package that makes it, or with a broken one."""

import sys

import numpy as np
import pytest
from PIL import Image

import tcontact as tc
from tcontact.base.errors import InputError
from tcontact.commands.cli import main
from tcontact.results.files.vtkhdf import ResultData, ResultFile
from tcontact.show import render
from tcontact.show.render.animation import can_film


@pytest.fixture(scope="module")
def result(tmp_path_factory) -> ResultData:
    """A cube that falls and turns red, in three frames."""
    mesh, path = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2)), tmp_path_factory.mktemp("result") / "result.vtkhdf"
    with ResultFile.create(path, mesh.nodes, mesh.blocks) as file:
        for index in range(3):
            down = np.broadcast_to([0.0, 0.0, -0.1 * index], mesh.nodes.shape)
            file.append(1e-3 * index, {"displacement": down}, {"von_mises": 1e6 * index * np.arange(8.0)})
    return ResultData.open(path)


@pytest.mark.skipif(not can_film(), reason="needs imageio-ffmpeg")
def test_the_film_holds_every_frame(result, tmp_path):
    import imageio_ffmpeg

    render.render_frames(result, tmp_path, size=(321, 241), video=True, fps=5)
    frames, _ = imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "animation.mp4"))
    assert frames == len(result)
    reader = imageio_ffmpeg.read_frames(str(tmp_path / "animation.mp4"))
    assert next(reader)["size"] == (320, 240)
    first = np.frombuffer(next(reader), np.uint8).reshape(240, 320, 3).astype(int)
    given = np.asarray(Image.open(tmp_path / "frames" / "frame-0000.png")).astype(int)[:240, :320]
    assert np.abs(first - given).mean() < 6


def test_a_film_without_its_package_is_refused_with_the_remedy(result, tmp_path, monkeypatch):
    monkeypatch.setattr("tcontact.show.render.animation.find_spec", lambda name: None)
    with pytest.raises(InputError, match="pip install imageio-ffmpeg"):
        render.render_frames(result, tmp_path / "out", video=True)
    assert not (tmp_path / "out").exists()


FAILING = {
    "import": "raise RuntimeError('no ffmpeg')",
    "program": "def get_ffmpeg_version(): raise RuntimeError('no ffmpeg')",
}


@pytest.mark.parametrize("source", FAILING.values(), ids=FAILING)
def test_a_film_package_that_fails_costs_the_film_alone(source, result, tmp_path, monkeypatch, capsys):
    """The pictures and the GIF are there, and a warning names the package; who insists on a film is refused."""
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "imageio_ffmpeg.py").write_text(source, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path / "broken")
    monkeypatch.delitem(sys.modules, "imageio_ffmpeg", raising=False)
    told = ["render", str(result.path), "--size", "160x160", "--out", str(tmp_path / "out")]
    assert main([*told, "--mp4"]) == 2
    assert "imageio-ffmpeg does not work (no ffmpeg)" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    with pytest.warns(RuntimeWarning, match=r"no animation.mp4: .* imageio-ffmpeg does not work \(no ffmpeg\)"):
        assert main(told) == 0
    assert (tmp_path / "out" / "animation.gif").exists()
    assert not (tmp_path / "out" / "animation.mp4").exists()
    monkeypatch.delitem(sys.modules, "imageio_ffmpeg", raising=False)
