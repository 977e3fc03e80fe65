"""The operations and bytes that the benchmark's model of a step assumes are those that the machine code executes."""

import os
import re
import subprocess
import sys

import cuda_device
import pytest
from conftest import SHORT

from tcontact.lab.bench import device_model
from tcontact.lab.bench.blocks import block
from tcontact.mesh.elements import ELEMENTS
from tcontact.planning.device_memory import cells_of
from tcontact.planning.device_traffic import traffic
from tcontact.planning.planning import plan
from tcontact.scene.scene import Scene

REASON = "a real device does not count" if cuda_device.real() else cuda_device.missing()
pytestmark = [pytest.mark.cuda, pytest.mark.skipif(bool(REASON), reason=REASON)]
KINDS = ("hex8", "hex8-distorted", "tet4")
SIZE = 4
STEP = """
import sys
from tcontact.cells.device_force import DeviceForce
from tcontact.device import arrays, runtime
from tcontact.lab.bench.blocks import block
from tcontact.planning.planning import plan
from tcontact.scene.scene import Scene
runtime.start("cuda")
for kind in sys.argv[2:]:
    (domain,) = plan(Scene(block(kind, "neo-hookean", int(sys.argv[1])).bodies, [], 1e-3)).domains
    force = DeviceForce(domain)
    force.advance(*(arrays.zeros(3 * len(domain.reference)) for _ in range(2)), 0.0, 0.0, 0.0)
"""
LINE = re.compile(r"device_step\w*_kernel_\d+_range_for: f64 [a-z/]+ (\d+), div/sqrt (\d+), .* stored (\d+)")


@pytest.fixture(scope="module")
def launches(tmp_path_factory):
    """Operations, divisions and stored bytes of the launches of a step: the cells, then the nodes, of every kind."""
    folder = tmp_path_factory.mktemp("counts")
    environment = {name: value for name, value in os.environ.items() if name not in SHORT}  # compiled as for a user
    environment |= {"FAKE_CUDA_DIR": str(folder), "FAKE_CUDA_COUNT": "1"}
    command = ["sh", str(cuda_device.FAKE), sys.executable, "-c", STEP, str(SIZE), *KINDS]
    environment["PYTHONPATH"] = os.pathsep.join([str(cuda_device.ROOT), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    found = [tuple(map(int, line.groups())) for line in map(LINE.match, done.stderr.splitlines()) if line]
    assert len(found) == 2 * len(KINDS)
    return {kind: found[2 * i : 2 * i + 2] for i, kind in enumerate(KINDS)}


@pytest.mark.parametrize("kind", KINDS)
def test_operations_are_counted(launches, kind):
    cells = device_model.model(kind, "neo-hookean", SIZE)["cells"]
    (quick, slow, _), (of_nodes, divisions, _) = launches[kind]
    counted = device_model.COUNTS[device_model.VARIANTS[kind]][device_model.LAWS.index("neo-hookean")]
    assert counted == (round(quick / cells), round(slow / cells))
    corners = cells * ELEMENTS[kind.partition("-")[0]].corners * device_model.CORNER_OPERATIONS
    per_node = (of_nodes - corners + device_model.DIVISION * divisions) / (SIZE + 1) ** 3
    assert 0.0 <= per_node - device_model.NODE_OPERATIONS < 20.0  # the sums over the cells of few nodes are in it


@pytest.mark.parametrize("kind", KINDS)
def test_bytes_written_are_those_that_are_stored(launches, kind):
    (domain,) = plan(Scene(block(kind, "neo-hookean", SIZE).bodies, [], 1e-3)).domains
    moved = traffic(cells_of(domain), len(domain.reference))
    (_, _, of_cells), (_, _, of_nodes) = launches[kind]
    assert of_cells == moved.cells_written
    assert of_nodes == pytest.approx(moved.nodes_written, rel=0.1)  # and the first stage of the sums over the cells
