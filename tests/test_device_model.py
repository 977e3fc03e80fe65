"""The bytes of a step on a GPU, its model for an H100, and the rows of the benchmark there."""

import pytest

from tcontact.commands.cli import main
from tcontact.kernels.columns import NODE_SUMS, cell_groups, group_size
from tcontact.kernels.lanes import DEVICE_ROWS, MOST_THREADS
from tcontact.lab.bench import collect, device_model, driver_calls, table
from tcontact.planning.device_memory import Cells
from tcontact.planning.device_traffic import traffic


def test_traffic_is_that_of_every_array_once_a_launch():
    """Hexahedra by hand: 8 corners, 3 components; the nodes of a large cube are as many as its cells."""
    cells, nodes = 128**3, 129**3
    moved = traffic([Cells(cells, 8, 0, 0)], nodes)
    sums = 8 * MOST_THREADS
    assert moved.cells_written == 8 * 3 * 8 * cells + sums * group_size(*cell_groups(False, False))
    assert moved.cells_read == 4 * 8 * cells + (24 + 24) * nodes + sums * NODE_SUMS
    assert moved.nodes_written == 48 * nodes + sums * NODE_SUMS
    lists = 4 * (nodes + 1 + 8 * cells) + 192 * cells
    assert moved.nodes_read == lists + (8 + 48) * nodes + sums * group_size(*cell_groups(False, False))
    assert moved.kept == 2 * 48 * nodes / DEVICE_ROWS
    stored = traffic([Cells(cells, 8, 10, 0)], nodes)
    assert stored.cells_read - moved.cells_read == 80 * cells - 24 * nodes
    metal = traffic([Cells(cells, 8, 0, 56)], nodes)
    assert metal.cells_written - moved.cells_written == 8 * 56 * cells


def test_the_model_takes_the_nearer_limit(monkeypatch):
    counts = {"hex8-box": ((100, 0),), "hex8": ((10**5 - 100, 10),), "wedge6": (None,)}
    monkeypatch.setattr(device_model, "COUNTS", counts)
    light, heavy = (device_model.model(kind, "linear", 128) for kind in ("hex8", "hex8-distorted"))
    assert (light["limit"], heavy["limit"]) == ("bytes", "operations")
    bytes_moved = 128**3 * (light["read_per_cell"] + light["written_per_cell"])
    assert light["step_s"] == pytest.approx(bytes_moved / device_model.BANDWIDTH + 2 * device_model.LAUNCH)
    more = heavy["step_s"] - light["step_s"]
    moved = device_model.moved_bytes("hex8", 128)
    of_cells = (moved.cells_read + moved.cells_written) / device_model.BANDWIDTH
    assert more == pytest.approx(10**5 * 128**3 / device_model.RATE - of_cells)
    uncounted = device_model.model("wedge6", "linear", 32)
    assert uncounted["operations_per_cell"] is None
    text = "\n".join(device_model.lines(device_model.rows(["hex8", "wedge6"], ["linear"])))
    assert "MODEL, nothing measured" in text
    assert "256^3 ms" in text


def test_a_large_cube_meets_the_bound_of_the_model():
    """128^3 hexahedra within 1 ms a step and 256^3 within 8 ms, by the counts."""
    for kind in ("hex8", "hex8-skew", "hex8-distorted", "hex8-reduced", "hex8-mean-dilatation"):
        assert device_model.model(kind, "neo-hookean", 128)["step_s"] <= 1e-3, kind
        assert device_model.model(kind, "neo-hookean", 256)["step_s"] <= 8e-3, kind


def test_contact_adds_its_one_block_to_the_model():
    """A small cube on a plane: linear in the nodes of its face, which one processor takes."""
    small, large = (device_model.contact_seconds(size, "frictionless") for size in (14, 29))
    once = sum(part.moved_once for part in device_model.CONTACT["frictionless"][:3]) / device_model.ONE_BANDWIDTH
    assert (large[0] - once) / (small[0] - once) == pytest.approx(4.0, rel=1e-6)
    text = "\n".join(device_model.lines(device_model.rows(["hex8"], ["linear"])))
    assert "friction, viscous cells" in text


@pytest.mark.parametrize("contact", device_model.CONTACT)
def test_a_large_cube_with_contact_meets_the_bound_of_the_model(contact):
    """128^3 hexahedra on a plane within 1 ms a step, 256^3 within 8 ms: several blocks of threads take their nodes."""
    for size, bound in ((128, 1e-3), (256, 8e-3)):
        added = sum(device_model.contact_seconds(size, contact))
        assert 0.1e-3 < added < 0.6e-3
        assert device_model.model("hex8", "neo-hookean", size)["step_s"] + added <= bound


def test_several_blocks_are_bound_by_the_memory_or_by_their_processors():
    """Bytes of nodes and blocks by hand, with the launches of one block between them."""
    part = device_model.Spread(operations=1.0, moved=1000.0, by_block=10.0, once=1.1e6, launches=3)
    moved = 1000.0 * 2**20 + 10.0 * 128
    assert part.seconds(2**20, 128) == pytest.approx(moved / device_model.BANDWIDTH + 1e-5)
    assert part.seconds(512, 2) == pytest.approx((512000.0 + 20.0) / (2 * device_model.ONE_BANDWIDTH) + 1e-5)


def test_calls_are_counted_in_the_log(monkeypatch, tmp_path):
    log = tmp_path / "calls"
    log.write_text("launch a <<<1, 2, 3>>>\nlaunch b\nHtoDasync 8\nsync\nDtoH 24\nallocasync 8\nsync\n")
    monkeypatch.setenv(driver_calls.LOG, str(log))
    assert driver_calls.calls_so_far() == {"launches": 2, "syncs": 2, "copies": 1}
    monkeypatch.delenv(driver_calls.LOG)
    assert driver_calls.calls_so_far() is None


def test_a_fake_device_is_named_before_its_figures(monkeypatch):
    monkeypatch.setenv(driver_calls.FAKE, "somewhere")
    machine = {"processor": "p", "cores": 1, "versions": {}, "device": collect.device()}
    assert "whose times mean nothing" in table.lines({"machine": machine, "rows": []})[0]


def test_bench_without_a_device_says_why_and_fails(capsys, tmp_path, monkeypatch):
    """Every row carries the reason; the model, which needs no device, is there."""
    monkeypatch.setenv("CUDA_VISIBLE_DEVICES", "")
    arguments = ["bench", "--arch", "cuda", "--quick", "--kinds", "hex8", "--sizes", "2", "--contact", "none"]
    assert main([*arguments, "--out", str(tmp_path)]) == 1
    text = capsys.readouterr().out
    assert "no usable CUDA device was found" in text
    assert "MODEL, nothing measured" in text
    assert (tmp_path / "bench.json").is_file()
