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
CONTACT = """
import dataclasses, sys
import numpy as np
import tcontact as tc
from tcontact.device import runtime
from tcontact.lab.bench.blocks import block
from tcontact.planning.planning import plan
from tcontact.schemes.explicit import state
runtime.start("cuda")
state.Joint = lambda: None  # places in joint arrays, which all threads read alike, are not counted
scene = block("hex8", "neo-hookean", int(sys.argv[1]), "normal")
falling = dataclasses.replace(scene.bodies[0], velocity=(0.0, 0.0, -3.0))
scene = dataclasses.replace(scene, bodies=[falling], friction=tc.Coulomb(0.2) if sys.argv[2] == "friction" else None)
start = [falling.initial_displacement], [falling.initial_velocity]
(domain,) = tc.CentralDifference().states(scene, plan(scene), *start)
dt = 0.4 * 0.1 / int(sys.argv[1]) / np.sqrt(13.5e6 / 1000.0)
domain.begin_contact(dt)
for row in range(8):
    domain.advance(dt / 2, dt / 2, dt, row * dt, (dt, dt), 1)
"""
SPREAD = """
from tcontact.planning import device_blocks
device_blocks.MANY_NODES = device_blocks.MANY_SWEPT = 1
"""
PLATE = """
box = tc.box_mesh(size=(0.1, 0.1, 0.2 / int(sys.argv[1])), cells=(int(sys.argv[1]), int(sys.argv[1]), 2))
body = tc.Body(box, tc.NeoHookean(1e7, 0.3, 1000.0), contact=["zmin"])
scene = tc.Scene([body], [tc.Plane()], 1e-3, contact=tc.MasslessContact(removal="normal"))
"""
LINE = re.compile(r"device_step\w*_kernel_\d+_range_for: f64 [a-z/]+ (\d+), div/sqrt (\d+), .* stored (\d+)")
BLOCK = re.compile(r"(device_\w+)_c\w+_kernel_(\d)_range_for: .* loaded (\d+) stored (\d+) local (\d+)")


def counted(folder, program, *arguments):
    """Return what a program in a process of its own says of its launches, line by line."""
    environment = {name: value for name, value in os.environ.items() if name not in SHORT}  # compiled as for a user
    environment |= {"FAKE_CUDA_DIR": str(folder), "FAKE_CUDA_COUNT": "1"}
    command = ["sh", str(cuda_device.FAKE), sys.executable, "-c", program, *arguments]
    environment["PYTHONPATH"] = os.pathsep.join([str(cuda_device.ROOT), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stderr.splitlines()


@pytest.fixture(scope="module")
def launches(tmp_path_factory):
    """Operations, divisions and stored bytes of the launches of a step: the cells, then the nodes, of every kind."""
    lines = counted(tmp_path_factory.mktemp("counts"), STEP, str(SIZE), *KINDS)
    found = [tuple(map(int, line.groups())) for line in map(LINE.match, lines) if line]
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


def test_bytes_of_the_one_block_are_those_of_the_model(tmp_path):
    """The bytes of the boundary nodes, and of passes that solve or find no more to do; friction and viscous cells."""
    model = device_model.CONTACT["friction, viscous cells"]
    lines = [line for line in map(BLOCK.match, counted(tmp_path, CONTACT, str(SIZE), "friction")) if line]
    last = {
        name: max(int(line[2]) for line in lines if line[1] == name) for name in ("device_contact_step", "device_pass")
    }
    found = {name: [] for name in last}
    for line in lines:
        if line[1] in last and int(line[2]) == last[line[1]]:
            found[line[1]].append(sum(map(int, line.groups()[2:])))
    nodes = (SIZE + 1) ** 2
    boundary, solving, judging = (part.moved * nodes + part.moved_once for part in model[:3])
    assert found["device_contact_step"][-1] == pytest.approx(boundary, rel=0.03)
    passes = [moved for moved in found["device_pass"] if moved > 0.5 * judging][4:]  # without those that find tangents
    assert max(passes) == pytest.approx(solving, rel=0.1)
    assert min(passes) == pytest.approx(judging, rel=0.1)


def test_bytes_of_several_blocks_are_those_of_the_model(tmp_path):
    """The bytes of the boundary nodes and of a sweep, by the launches of several blocks; a plate, with few cells."""
    plate = CONTACT.replace('scene = block("hex8", "neo-hookean", int(sys.argv[1]), "normal")', PLATE)
    size, model = 16, device_model.SPREAD["frictionless"]
    found: dict[tuple[str, int], int] = {}
    for line in map(BLOCK.match, counted(tmp_path, SPREAD + plate, str(size), "")):
        if line:
            place = line[1], int(line[2])
            found[place] = max(found.get(place, 0), sum(map(int, line.groups()[2:])))
    nodes = (size + 1) ** 2  # of four blocks
    parts = {"device_contact_step": (model.boundary, (2, 3)), "device_sweep": (model.sweep, (1, 2, 3, 4))}
    for name, (part, launches) in parts.items():
        moved = sum(found[name, number] for number in launches)
        assert moved == pytest.approx(part.moved * nodes + part.by_block * 4, rel=0.05), name
    assert found["device_sweep", 0] == pytest.approx(model.sweep.once, rel=0.05)
