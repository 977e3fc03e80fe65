"""A result file that a run is writing: what does not go together is read again, what stays damaged is said to be."""

import shutil
import threading

import pytest

import tcontact as tc
from tcontact.errors import InputError
from tcontact.results.files import still_written
from tcontact.results.files.still_written import settled


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The folder of a run of one cell that falls."""
    folder = tmp_path_factory.mktemp("written") / "run"
    body = tc.Body(tc.box_mesh((0.1, 0.1, 0.1), (1, 1, 1)), tc.LinearElastic(1e6, 0.3, 1e3), velocity=(0.0, 0.0, -1.0))
    tc.simulate(tc.Scene([body], duration=2e-2), out=folder, frames=3)
    return folder


@pytest.fixture
def later(monkeypatch):
    """Do something between the first try and the second, in another thread; the pause is long for a busy machine."""
    monkeypatch.setattr(still_written, "PAUSE", 1.0)
    return lambda act: threading.Timer(0.3, act).start()


@pytest.mark.parametrize("share", [0.0, 0.3, 0.7])
def test_a_file_that_is_finished_meanwhile_is_read(written, tmp_path, later, share):
    whole, path = (written / "result.vtkhdf").read_bytes(), tmp_path / "result.vtkhdf"
    path.write_bytes(whole[: int(share * len(whole))])
    later(lambda: path.write_bytes(whole))
    found = tc.open_result(path)
    assert len(found.frames) == 3
    assert len(found.history["time"]) > 1


def test_a_frame_that_is_finished_meanwhile_is_read(written, tmp_path, later):
    path = tmp_path / "result.vtkhdf"
    shutil.copy(written / "result.vtkhdf", path)
    whole, data = path.read_bytes(), tc.open_result(path).frames
    known = data.frame(1).point_data["velocity"]
    path.write_bytes(whole[: len(whole) // 3])
    later(lambda: path.write_bytes(whole))
    assert (data.frame(1).point_data["velocity"] == known).all()


def test_a_file_that_stays_as_it_is_is_read_twice_and_damaged(tmp_path):
    path, tries = tmp_path / "file", []
    path.write_bytes(b"damaged")

    def read():
        tries.append(1)
        raise KeyError("lost")

    with pytest.raises(KeyError, match="lost"):
        settled(path, read, (KeyError,))
    assert len(tries) == 2


def test_a_file_that_changes_at_each_try_is_not_called_damaged(tmp_path, monkeypatch):
    monkeypatch.setattr(still_written, "PAUSE", 1e-3)
    path = tmp_path / "file"
    path.write_bytes(b"")

    def read():
        path.write_bytes(path.read_bytes() + b".")
        raise KeyError("lost")

    with pytest.raises(InputError, match="a run is writing it and has changed it at each try; read it again"):
        settled(path, read, (KeyError,))
    assert path.stat().st_size == still_written.TRIES
