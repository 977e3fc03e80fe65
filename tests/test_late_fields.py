"""Fields that are put together where a frame is written, and frames that go to disk together."""

import os
import signal
import socket
from multiprocessing.connection import Connection

import numpy as np
import pytest

from tcontact.results.files import frame_server
from tcontact.results.files.frame_process import FrameProcess
from tcontact.results.files.late_fields import LateField, Part, whole
from tcontact.results.files.vtkhdf import ResultData, ResultFile

POINTS, CELLS = np.random.default_rng(1).normal(size=(8, 3)), np.arange(8)[None]


@pytest.fixture
def file(tmp_path):
    return ResultFile.create(tmp_path / "result.vtkhdf", POINTS, [("hex8", CELLS)])


def test_a_velocity_is_between_two_half_steps_with_the_massless_part_added():
    random = np.random.default_rng(2)
    old, new, massless = random.normal(size=(5, 3)), random.normal(size=(5, 3)), random.normal(size=(2, 3))
    place, nodes = np.array([3, 1, 4, 0, 2]), np.array([4, 0])
    wanted = (0.75 * old + 0.25 * new)[place]
    for number, node in enumerate(nodes):
        wanted[node] += massless[number]
    found = Part("velocity", (old, new, massless), (place, nodes), (0.25,)).values()
    assert found == pytest.approx(wanted, rel=1e-14)
    inner = Part("velocity", (old, new), (place,), (1.0,)).values()
    assert inner == pytest.approx(new[place], rel=1e-14)


def test_values_of_some_nodes_are_zero_elsewhere_and_bodies_follow_each_other():
    force = Part("spread", (np.ones((2, 3)),), (np.array([3, 1]),), (4.0,))
    other = Part("renumbered", (np.arange(6.0).reshape(2, 3),), (np.array([1, 0]),))
    values = whole(LateField((force, other)))
    assert values.tolist() == [[0.0] * 3, [1.0] * 3, [0.0] * 3, [1.0] * 3, [3.0, 4.0, 5.0], [0.0, 1.0, 2.0]]
    assert whole(values) is values


def test_the_process_puts_the_fields_of_every_frame_together(file, tmp_path):
    process = FrameProcess.start(10**7, 20)
    process._line.poll(60.0)
    assert process.ready()
    place, nodes = np.random.default_rng(3).permutation(8), np.array([5, 2])

    def field(number, moving):
        return {
            "u": LateField((Part("renumbered", (moving,), (place,)),)),
            "f": LateField((Part("spread", (np.full(2, number),), (nodes,), (8.0,)),)),
        }

    rows = np.arange(24.0).reshape(8, 3)
    file.append(0.0, {name: whole(value) for name, value in field(0.0, 0.0 * rows).items()})
    process.take_over(file, tmp_path / "result.vtkhdf", {})
    for number in range(1, 12):
        moving = number * rows
        process.append(float(number), field(float(number), moving))
        moving[:] = np.nan
    process.close()
    data = ResultData.open(tmp_path / "result.vtkhdf")
    assert len(data) == 12
    for number in range(12):
        fields = data.frame(number).point_data
        assert np.array_equal(fields["u"], number * rows[place])
        assert fields["f"].tolist() == [0, 0, number, 0, 0, number, 0, 0]


@pytest.fixture
def signals():
    """Signals as they were before the test."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def test_frames_that_wait_go_to_disk_together(file, tmp_path, monkeypatch, signals):
    """Five frames stand in the line: three go at once, the other two as the run is gone."""
    path, commits = tmp_path / "result.vtkhdf", []
    file.append(0.0, {"a": np.zeros(8)})
    file.close()
    memory = os.memfd_create("frames")
    os.ftruncate(memory, 64)
    ours, theirs = socket.socketpair()
    line = Connection(ours.detach())
    line.send(("open", str(path), 1, {}))
    line.send(("room", 64))
    for number in range(1, 6):
        line.send(("append", float(number), [("point", "a", [("as they are", [("<f8", (8,), 0)], [], ())])]))
    socket.socket(fileno=os.dup(line.fileno())).shutdown(socket.SHUT_WR)

    both = ResultFile.commit
    monkeypatch.setattr(ResultFile, "commit", lambda result: (commits.append(len(result)), both(result)))
    frame_server.serve(theirs.detach(), memory)
    os.close(memory)
    assert commits == [1, 4]  # the attributes, three frames; `close` brings the rest
    assert [line.recv() for _ in range(4)] == ["ready", None, None, None]
    assert ResultData.open(path).times.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
