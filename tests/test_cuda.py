"""CUDA: what a device computes is what the CPU computes, in any order of threads, without waiting within a block."""

import subprocess
import sys

import cuda_device
import cuda_scenes
import numpy as np
import pytest
import thread_orders

from tcontact.cells.internal_force import InternalForce
from tcontact.kernels.columns import raw_places
from tcontact.kernels.lanes import DEVICE_ROWS
from tcontact.planning.planning import plan
from tcontact.schemes.explicit.device_memory import domain_size, plan_bytes

REASON = cuda_device.missing()
pytestmark = [pytest.mark.cuda, pytest.mark.skipif(bool(REASON), reason=REASON)]
REGISTERS, SPILLS = 255, 300  # of a thread; bytes, stores and loads each
# a metal at eight points with geometries of their own and a pressure of the cell spills more [B]: the 63 modes of
# position, displacement and force alone fill half the registers
ABOVE = {"hex8-mean-dilatation j2_johnson_cook": 480}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("cuda")


@pytest.fixture(scope="module")
def found(folder):
    """What the device computed (cuda_worker.py)."""
    return cuda_device.results(folder)


def relative(one, other):
    """Return the largest difference over the largest value."""
    return np.abs(one - other).max() / np.abs(other).max()


@pytest.mark.parametrize("name", cuda_scenes.FORCES)
def test_forces_are_those_of_the_cpu(found, parallel_path, name):
    """The forces of every element and law agree to 1e-13 of the largest force of the body."""
    first, energies = 0, 0.0
    for body in cuda_scenes.FORCES[name]():
        force, sums = cuda_scenes.forces(InternalForce, [body])
        own = found[f"{name}/force"][first : first + len(force)]
        assert relative(own, force) < 1e-13, (body.formulation, body.mesh.kind, body.material)
        first += len(force)
        energies += sums[raw_places(False).cells.elastic]
    assert first == len(found[f"{name}/force"])
    assert found[f"{name}/sums"][raw_places(False).cells.elastic] == pytest.approx(energies, rel=1e-12)


@pytest.mark.parametrize("name", cuda_scenes.FORCES)
def test_shape_rates_are_those_of_the_cpu(found, parallel_path, name):
    """The rates of every body, which a thread per cell computes there."""
    expected = cuda_scenes.rates(InternalForce, cuda_scenes.FORCES[name]())
    assert (expected > 0.0).sum() >= 18
    assert np.abs(found[f"{name}/rates"] - expected).max() <= 1e-12 * expected.max()
    assert ((found[f"{name}/rates"] > 0.0) == (expected > 0.0)).all()


@pytest.mark.parametrize("name", cuda_scenes.RUNS)
def test_stable_steps_are_those_of_the_cpu(found, name):
    """The first search is the same to rounding; later ones start from modes that both keep in 16 bits of their own."""
    difference = np.abs(found[f"{name}/stable_steps"] / cuda_scenes.stable_steps_of(name) - 1.0).max(axis=1)
    assert (difference <= (1e-9, 1e-5, 1e-6)).all()


@pytest.mark.parametrize("name", cuda_scenes.RUNS)
def test_runs_are_those_of_the_cpu(found, name):
    """Positions, velocities and every column of the history: 1e-11; the same steps and the same end."""
    own = {key.partition("/")[2]: value for key, value in found.items() if key.startswith(f"{name}/")}
    expected = cuda_scenes.run(name, "cpu")
    assert own["steps"] == expected["steps"] > DEVICE_ROWS
    assert own["reason"] == expected["reason"] == ("inverted-cell" if name == "crushed" else "finished")
    energy = np.abs(expected["history_kinetic"]).max()
    for key, values in expected.items():
        if key in ("steps", "reason", "memory"):
            continue
        assert own[key].shape == values.shape, key
        same = np.isfinite(values)
        assert (np.isfinite(own[key]) == same).all(), key
        scale = np.abs(values[same]).max(initial=0.0)
        scale = energy if key in ("history_energy", "history_elastic") else scale
        scale = 1.0 if key == "history_energy_error" else scale
        assert (np.abs(own[key] - values)[same] <= 1e-11 * scale).all(), key


@pytest.mark.parametrize("name", cuda_scenes.CONTACT)
def test_contact_is_that_of_the_cpu(found, name):
    """Its kernels are those of the CPU, with their vectors split into scalars."""
    expected = cuda_scenes.run(name, "cpu")
    assert found[f"{name}/steps"] == expected["steps"]
    assert np.abs(expected["history_contact_force"]).max() > 0.0
    for key in ("position", "velocity", "history_kinetic", "history_elastic", "history_contact_force"):
        assert relative(found[f"{name}/{key}"], expected[key]) < 1e-11, key


@pytest.mark.parametrize("name", [*cuda_scenes.RUNS, *cuda_scenes.CONTACT])
def test_the_memory_of_a_run_is_foreseen(found, name):
    """At least what the arrays take, with the search for the stable step and one copy, and little more."""
    planned = plan((cuda_scenes.RUNS | cuda_scenes.CONTACT)[name]()[0])
    sizes = [domain_size(domain) for domain in planned.domains]
    beside = sum(size.search + size.transfer for size in sizes)
    assert found[f"{name}/memory"] <= plan_bytes(planned) <= 1.1 * found[f"{name}/memory"] + beside


def test_doctor_tells_of_the_device(found):
    lines = [str(line) for line in found["doctor"]]
    assert lines[0].startswith("1 device(s)" if not cuda_device.real() else "")
    assert "free; use --arch cuda" in lines[0]
    assert all("^3 boxes" in line and "bytes a cell" in line for line in lines[1:])


def test_metals_flow_in_their_run(found):
    work = found["forged/history_plastic_work"]
    assert work[-1] > 1e-3 * found["forged/history_kinetic"][0]


def test_threads_in_reversed_order_give_the_same_bits(found):
    """No thread reads what another one of its launch writes."""
    if cuda_device.real():
        pytest.skip("a real device runs its threads in its own order")
    names = thread_orders.compared(found)
    assert names == {*cuda_scenes.FORCES, *cuda_scenes.RUNS, *cuda_scenes.CONTACT}


def test_a_block_of_rows_launches_twice_a_step_and_copies_nothing(found):
    """But Taichi sends the arguments of each launch, without waiting."""
    if cuda_device.real():
        pytest.skip("calls of a real driver are not counted")
    calls = [line.split()[0] for line in str(found["calls"]).splitlines()]
    assert calls.count("launch") == 2 * DEVICE_ROWS
    assert set(calls) <= {"launch", "allocasync", "freeasync", "HtoDasync"}
    assert calls.count("HtoDasync") == DEVICE_ROWS


def test_the_benchmark_counts_the_calls_of_a_step(found):
    """Two kinds of cells and the nodes; once in a block the kept state, three sums and a copy to the host."""
    if cuda_device.real():
        pytest.skip("calls of a real driver are not counted")
    launches, copies, syncs, rows = found["bench"]
    assert rows == DEVICE_ROWS
    assert 3.0 < launches <= 3.0 + 12 / DEVICE_ROWS
    assert 0.0 < copies <= 2 / DEVICE_ROWS
    assert 0.0 < syncs <= 4 / DEVICE_ROWS


def test_a_search_for_the_stable_step_asks_the_device_once(found):
    """20 products of two bodies: their numbers come back at the end, in one copy."""
    if cuda_device.real():
        pytest.skip("calls of a real driver are not counted")
    calls = [line.split()[0] for line in str(found["search"]).splitlines()]
    assert calls.count("launch") > 20 * 3
    assert calls.count("DtoH") <= 2
    assert calls.count("HtoD") <= 2  # a copy to the host needs the place there
    assert calls.count("sync") <= 4


def test_registers_and_spills(found, folder):
    """No kernel of a step needs more registers than a thread has, and few of their values go to memory."""
    tool = cuda_device.register_tool()
    over: list[str] = []
    names = list(cuda_scenes.FORCES)  # in the order in which the worker compiles them
    for module in sorted(folder.glob("module_*.ptx")):
        count = module.read_text().count(".entry device_step")
        if not names or count != len(found[f"{names[0]}/kinds"]) + 1:
            continue
        name = names.pop(0)
        command = [sys.executable, str(tool), str(module)]
        report = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        rows = [line.replace("/", " ").split() for line in report.splitlines()]
        kinds = {f"kernel_{i}_": kind for i, kind in enumerate([*found[f"{name}/kinds"], "nodes"])}
        assert len(rows) == count
        for row in rows:
            kind = next(kind for part, kind in kinds.items() if part in row[0])
            registers, spills = int(row[1]), max(int(row[7]), int(row[8]))
            print(f"{kind:45} {registers:4} registers, {spills:5} B of spills")
            assert registers <= REGISTERS
            over += [kind] if spills > ABOVE.get(str(kind), SPILLS) else []
    assert not names
    assert not over
