"""Contact on CUDA: threads step the boundary nodes as the CPU does, without waiting within a block of rows."""

import subprocess
import sys
from pathlib import Path

import cuda_contact_scenes
import cuda_device
import numpy as np
import pytest
import thread_orders

import tcontact as tc
from tcontact.kernels.lanes import DEVICE_ROWS
from tcontact.planning.planning import plan
from tcontact.schemes.explicit.device_memory import domain_size, plan_bytes
from tcontact.schemes.explicit.device_step import steps_on_device

REASON = cuda_device.missing()
pytestmark = [pytest.mark.cuda, pytest.mark.skipif(bool(REASON), reason=REASON)]
WORKER = Path(__file__).resolve().parent / "cuda_contact_worker.py"
REGISTERS, SPILLS = 255, 64  # of a thread; bytes, stores and loads each
STACK = 1280  # bytes of a thread: most where nodes with several walls are solved, else the corners of a cell
REASONS = {"crushed": "inverted-cell", "sagged": "not-converged"}
ABOVE = {"device_layers": 400}  # spills [B]: a layer with two sides keeps the constants of two metals
CLOSE = 1e-11
PAIR = "up-low"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("cuda")


@pytest.fixture(scope="module")
def found(folder):
    """What the device computed (cuda_contact_worker.py)."""
    return cuda_device.results(folder, worker=WORKER)


def scale_of(key, values, expected):
    """Return what a difference is relative to: the largest value, of quantities that vanish that of their kind."""
    if key in ("history_static_residual", "history_energy_error", "history_layer_error"):
        return 1.0
    if key == "history_angular_momentum":
        return max(np.abs(expected["history_momentum"]).max() * 0.2, np.abs(values).max())
    if key in ("history_contact_force", "history_impulse") and f"history_pair_force:{PAIR}" in expected:
        size = np.abs(expected[f"history_pair_force:{PAIR}"]).max()  # forces between bodies cancel out
        return size * (expected["history_time"][-1] if key == "history_impulse" else 1.0)
    largest = np.abs(values).max(initial=0.0)
    if key == "history_gap_min":  # a difference of positions, with their rounding error
        return max(largest, np.finfo(float).eps / CLOSE * np.abs(expected["position"]).max())
    return largest


@pytest.mark.parametrize("name", cuda_contact_scenes.SCENES)
def test_runs_are_those_of_the_cpu(found, name):
    """Positions, velocities, forces of the nodes, every column: 1e-11; the same steps and the same end."""
    scene, _scheme = cuda_contact_scenes.SCENES[name]()
    assert all(steps_on_device(scene, domain, "cuda") for domain in plan(scene).domains)
    expected = cuda_contact_scenes.run(name, "cpu")
    compare(found, name, name, expected)
    if name in cuda_contact_scenes.SHARED:  # several blocks of threads
        compare(found, f"shared-{name}", name, expected)
        assert found[f"shared-{name}/swept"] > 0
        # as one block takes: the CPU may take some more or fewer at rounding level
        assert (found[f"shared-{name}/history_sweeps"] == found[f"{name}/history_sweeps"]).all()


def compare(found, own_name, name, expected):
    """Compare a run of the device with that of the CPU."""
    assert found[f"{own_name}/steps"] == expected["steps"]
    assert found[f"{own_name}/reason"] == expected["reason"] == REASONS.get(name, "finished")
    assert name == "held" or np.abs(expected["history_contact_force"]).max() > 0.0
    for key, values in expected.items():
        if key in ("steps", "reason", "memory", "history_sweeps"):  # a sweep more or less at rounding level
            continue
        own, same = found[f"{own_name}/{key}"], np.isfinite(values)
        assert own.shape == values.shape, key
        assert (np.isfinite(own) == same).all(), key
        assert (np.abs(own - values)[same] <= CLOSE * scale_of(key, values[same], expected)).all(), key


@pytest.mark.parametrize("name", cuda_contact_scenes.RUBBING)
def test_friction_takes_energy(found, name):
    """Without it these runs would agree too."""
    work = found[f"{name}/history_friction_work"]
    assert work[-1] > 1e-3 * found[f"{name}/history_kinetic"][0]


def test_what_is_not_on_the_device_steps_on_the_kernels_of_the_cpu():
    """Friction layers that warm the cells behind them."""
    block = cuda_contact_scenes.block(cells=3)
    layer = {"material": cuda_contact_scenes.METAL, "friction": tc.FrictionLayer(), "formulation": "mean-dilatation"}
    scene, _scheme = cuda_contact_scenes.thrown(block, **layer)
    assert not any(steps_on_device(scene, domain, "cuda") for domain in plan(scene).domains)
    assert (
        "with arch='cuda' on the kernels of the CPU, slowly: friction layers that warm cells" in plan(scene).describe()
    )


@pytest.mark.parametrize("name", [name for name in ("slowed", "forged") if name in cuda_contact_scenes.SCENES])
def test_viscous_cells_take_energy(found, name):
    """They are there in scenes of friction with normal removal that say nothing of them."""
    work = found[f"{name}/history_viscous_work"]
    assert (np.diff(work) >= -1e-9 * work[-1]).all()
    assert work[-1] > 1e-5 * found[f"{name}/history_kinetic"][0]


@pytest.mark.parametrize("name", cuda_contact_scenes.SEARCHED)
def test_stable_steps_with_viscous_cells_are_those_of_the_cpu(found, name):
    """The vectors of the search stay on the device; the next search starts from the mode of the one before.

    With momenta that move nothing the step of the leaning block was wrong by half in the third search.
    """
    assert found[f"search/{name}/class"] == "DeviceStableSteps"
    kind, expected = cuda_contact_scenes.damped_steps(name)
    assert kind == "StableSteps"
    difference = np.abs(found[f"search/{name}/damped"] / expected - 1.0).max(axis=1)
    assert (difference <= cuda_contact_scenes.SEARCHES[name]).all()


def test_steps_that_are_short_of_passes_take_those_of_the_next(found):
    """Runs in which every step offers one pass have the same bits, though most steps need two or more."""
    blocks = -(-int(found["full/steps"]) // DEVICE_ROWS)
    assert found["short/asked"] > 2 * blocks
    for key, values in found.items():
        name, _, column = key.partition("/")
        if name == "full" and column != "memory":
            assert np.array_equal(found[f"short/{column}"], values, equal_nan=values.dtype == float), column


@pytest.mark.slow
def test_runs_with_layers_go_on_from_checkpoints(found):
    """With the same bits, and frames with the fields of the layers."""
    assert len(found["resumed"]) >= 2
    assert found["resumed"].all()


@pytest.mark.long
def test_a_metal_that_goes_on_from_another_run_does_not_flow_in_its_first_row(found):
    """The rate at which it flowed last is not known there, and its strength without it would be smaller. Its viscous
    contact cells have no force there, which moves the massless nodes a little."""
    before, here = found["gone-on/elastic"]
    assert here == pytest.approx(before, rel=1e-4)
    before, here = found["gone-on/plastic"]
    assert before > 0.0
    assert here < 1e-9 * before


def test_threads_in_reversed_order_give_the_same_bits(found):
    """Those that wait for each other are not reversed: test_cuda_races.py watches them."""
    if cuda_device.real():
        pytest.skip("a real device runs its threads in its own order")
    searches = {"search"} if cuda_contact_scenes.SEARCHED else set()
    assert thread_orders.compared(found) == searches | set(cuda_contact_scenes.REVERSED)


@pytest.mark.parametrize("name", cuda_contact_scenes.COUNTED)
def test_a_block_of_rows_launches_three_times_a_step_and_twice_a_pass(found, name):
    """Once for every kind of cells, once for the nodes and once for the boundary nodes; again for the viscous contact
    cells of every kind; where there are friction layers again for the boundary nodes, and for every kind of layers.
    Several blocks of threads take two launches more, three with supports, and four more a pass. A block of rows copies
    nothing to the host and never waits; its state is copied on the device at first, in less than a launch a step."""
    if cuda_device.real():
        pytest.skip("calls of a real driver are not counted")
    lines = str(found[f"{name}/calls"]).splitlines()
    assert {line.split()[0] for line in lines} <= {"launch", "allocasync", "freeasync", "HtoDasync"}
    names = [line.split()[1] for line in lines if line.startswith("launch")]
    parts = ("device_contact_step", "device_pass", "device_layers")
    steps, passes, layers = (sum(part in name for name in names) for part in parts)
    (domain,) = plan(cuda_contact_scenes.SCENES[name]()[0]).domains
    kinds, shared, layered = len(domain.kinds), name == "paved", name == "baked"
    assert steps == (kinds * (1 + domain.viscous_cells) + (5 if shared else 2) + layered) * DEVICE_ROWS
    assert layers == 2 * layered * DEVICE_ROWS
    of_pass = (kinds + (5 if shared else 1)) * DEVICE_ROWS
    assert passes % of_pass == 0
    assert 1 <= passes // of_pass <= 4 or (passes == 0 and name == "repelled")
    assert sum("copy_" in name for name in names) == len(names) - steps - passes - layers < DEVICE_ROWS


@pytest.mark.parametrize("name", [name for name in cuda_contact_scenes.COUNTED if name != "repelled"])
def test_launches_name_few_arrays(found, name):
    """The host takes microseconds for each; those of boundary nodes, contact and the static solve stand in two. Without
    a static solve, as with a penalty, they stand alone."""
    step, start, one = found[f"{name}/named"]
    assert max(step, start) <= 18
    assert one <= 10  # a pass


@pytest.mark.parametrize("name", cuda_contact_scenes.SHARED)
def test_sweeps_name_still_fewer(found, name):
    """A launch of sweeps names the two joint arrays alone, the end of a pass the displacements too."""
    (named,) = found[f"shared-{name}/named"]
    assert (named == (2, 3)).all()


@pytest.mark.parametrize("name", cuda_contact_scenes.SCENES)
def test_the_memory_of_a_run_is_foreseen(found, name):
    """At least what the arrays take, with the search for the stable step and one copy, and little more."""
    planned = plan(cuda_contact_scenes.SCENES[name]()[0])
    sizes = [domain_size(domain) for domain in planned.domains]
    beside = sum(size.search + size.transfer for size in sizes)
    assert found[f"{name}/memory"] <= plan_bytes(planned) <= 1.1 * found[f"{name}/memory"] + beside


def test_registers_and_spills(found, folder):
    """The block of threads keeps its values in registers, but for the corners of a cell in the tangent."""
    tool = cuda_device.register_tool()
    parts = ("device_contact_step", "device_pass", "device_start", "device_layers")
    kept, most, over = dict.fromkeys(parts, 0), np.zeros(2, dtype=int), []
    for module in sorted(folder.glob("module_*.ptx")):
        part = next((part for part in parts if f".entry {part}" in module.read_text()), "")
        if not part:
            continue
        kept[part] += 1
        command = [sys.executable, str(tool), str(module)]
        report = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        for row in (line.replace("/", " ").split() for line in report.splitlines()):
            registers, stack, spills = int(row[1]), int(row[4]), max(int(row[7]), int(row[8]))
            print(f"{row[0]:55} {registers:4} registers, {stack:4} B of stack, {spills:5} B of spills")
            most = np.maximum(most, (registers, stack))
            over += [row[0]] if spills > ABOVE.get(part, SPILLS) else []
    assert all(kept.values())
    assert (most <= (REGISTERS, STACK)).all(), most
    assert not over
