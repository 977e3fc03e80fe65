"""What the tests of CUDA run in a process of its own: python cuda_worker.py OUT.npz; Taichi cannot be started twice."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import cuda_scenes
from thread_orders import both_orders

import tcontact as tc
from tcontact.cells.device_force import DeviceForce
from tcontact.commands.devices import cuda_lines
from tcontact.device import arrays, runtime
from tcontact.kernels.lanes import DEVICE_ROWS
from tcontact.lab.bench.driver_calls import calls_of_a_block as calls_per_step
from tcontact.planning.planning import plan
from tcontact.schemes.explicit.device_stable_step import stable_steps
from tcontact.schemes.explicit.stable_step import StableStep


def calls_of_a_block() -> str:
    """Return what the driver is asked for in a block of rows after the first one, where a log of it exists."""
    log = Path(os.environ.get("FAKE_CUDA_LOG", os.devnull))
    scene, _scheme = cuda_scenes.crushed()
    (domain,) = plan(scene).domains
    force, u, v = DeviceForce(domain), *(arrays.zeros(3 * len(domain.reference)) for _ in range(2))
    force.advance(u, v, 0.0, 0.0, 0.0)
    before = log.stat().st_size
    for row in range(DEVICE_ROWS):
        force.advance(u, v, 1e-6, 1e-6, 2e-6, before=2e-6, row=row)
    return log.read_bytes()[before:].decode() if log.is_file() else ""


def calls_of_the_bench() -> list[float]:
    """Return launches, copies and syncs of a step in a block as the benchmark counts them; empty without a log."""
    scene, scheme = cuda_scenes.tumbling()
    planned = plan(scene)
    zero = [body.initial_displacement for body in scene.bodies]
    (state,) = scheme.states(scene, planned, zero, [body.initial_velocity for body in scene.bodies])
    found = calls_per_step(state, 1e-6) or {}
    return [found[kind] for kind in ("launches", "copies", "syncs", "rows") if found]


def calls_of_a_search() -> str:
    """Return what the driver is asked for in a search for the stable step after another one."""
    log = Path(os.environ.get("FAKE_CUDA_LOG", os.devnull))
    (domain,) = plan(cuda_scenes.tumbling()[0]).domains
    force, u = DeviceForce(domain), arrays.zeros(3 * len(domain.reference))
    search = stable_steps(force.without_boundary(), [StableStep(body, [], None) for body in domain.bodies])
    for _ in range(2):
        before = log.stat().st_size
        search.estimate(u)
    return log.read_bytes()[before:].decode() if log.is_file() else ""


def main(out: str) -> None:
    """Run everything and store it."""
    runtime.start("cuda")
    found = {"calls": np.array(calls_of_a_block()), "doctor": np.array(cuda_lines())}
    found["search"] = np.array(calls_of_a_search())
    found["bench"] = np.array(calls_of_the_bench())
    found |= runs()
    found |= both_orders(runs)
    np.savez(out, **found)


def runs() -> dict[str, np.ndarray]:
    """Return forces, rates, searches for the stable step and runs."""
    found: dict[str, np.ndarray] = {}
    for name, make in cuda_scenes.FORCES.items():
        (domain,) = plan(tc.Scene(make(), [], 1e-3, contact=None)).domains
        found[f"{name}/kinds"] = np.array([" ".join(kind) for kind in domain.kinds])
        found[f"{name}/rates"] = cuda_scenes.rates(DeviceForce, make())
        found[f"{name}/force"], found[f"{name}/sums"] = cuda_scenes.forces(DeviceForce, make())
    for name in cuda_scenes.RUNS:
        found[f"{name}/stable_steps"] = cuda_scenes.stable_steps_of(name)
    for name in (*cuda_scenes.RUNS, *cuda_scenes.CONTACT):
        found |= {f"{name}/{key}": value for key, value in cuda_scenes.run(name, "cuda").items()}
    return found


if __name__ == "__main__":
    main(sys.argv[1])
