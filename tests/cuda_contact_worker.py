"""What the tests of contact on CUDA run in a process of its own: python cuda_contact_worker.py OUT.npz."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import cuda_contact_scenes
import pytest
import stopped_runs
import tiers
from thread_orders import both_orders

import tcontact as tc
from tcontact.device import runtime
from tcontact.kernels.lanes import DEVICE_ROWS
from tcontact.planning import device_blocks
from tcontact.schemes.explicit.device_contact import DeviceContactSteps
from tcontact.schemes.explicit.device_sweeps import DeviceSweeps


def state_of(name: str):
    """Return the state of a scene at its start, and its first step [s]."""
    state, step = cuda_contact_scenes.state_of(name), cuda_contact_scenes.STEPS.get(name, 2e-5)
    state.begin_contact(step)
    return state, step


def calls_of_a_block(name: str) -> dict[str, np.ndarray]:
    """Return what the driver is asked for by the launches of a block of a scene, not its first; "" without a log.

    named: arrays that the launches of a step, of the start and of a pass name.
    """
    log = Path(os.environ.get("FAKE_CUDA_LOG", os.devnull))
    state, step = state_of(name)
    kicks = step / 2, step / 2, step
    state.advance(*kicks, 0.0, (step, step), 2)
    device, lengths = state.device, []
    end = "_settle" if isinstance(device, DeviceContactSteps) else "_read"
    setattr(device, end, watched(getattr(device, end), lambda: lengths.append(log.stat().st_size)))
    # obstacles are placed, and functions of time asked, before a block
    device.advance = watched(device.advance, lambda: lengths.append(log.stat().st_size))
    state.advance(*kicks, 2 * step, (step, step), DEVICE_ROWS)
    text = log.read_bytes() if log.is_file() else b""
    named = [len(part) for part in device._parts]
    return {f"{name}/calls": np.array(text[lengths[0] : lengths[1]].decode()), f"{name}/named": np.array(named)}


def watched(call, note):
    """Return the call with a note before it."""

    def noted(*given):
        note()
        return call(*given)

    return noted


def short_of_passes() -> dict[str, np.ndarray]:
    """Return a run in which every step offers one pass, and how often the device had to be asked for its blocks."""
    asked: list[int] = []
    take, settle = DeviceContactSteps.take, DeviceContactSteps._settle

    def few(self, *given):
        self.passes = 1
        return take(self, *given)

    DeviceContactSteps.take = few
    DeviceContactSteps._settle = lambda self: (asked.append(1), settle(self))[1]
    found = cuda_contact_scenes.run("full", "cuda")
    DeviceContactSteps.take, DeviceContactSteps._settle = take, settle
    return found | {"asked": np.array(len(asked))}


def resumed() -> np.ndarray:
    """Return whether a run with friction layers that goes on from each of its checkpoints leaves the same bits."""
    scene, scheme = cuda_contact_scenes.SCENES["baked"]()
    folder, found = Path(tempfile.mkdtemp()), []
    options = {"arch": "cuda", "progress": False, "frames": 5}
    with pytest.MonkeyPatch.context() as patch:
        whole, copies = stopped_runs.copied(patch, folder, scene, scheme, 13, **options)
    for path in copies.values():
        stopped_runs.same(whole, tc.resume(path, scene, scheme, arch="cuda"))
        stopped_runs.same_files(folder / "whole", path)
        found.append(True)
    shutil.rmtree(folder)
    return np.array(found)


def gone_on(name: str) -> dict[str, np.ndarray]:
    """Return the elastic energy [J] and plastic work [J] at the end of a run and in the first row of one that goes on.

    plastic: of the end of the first run, then of the first row of the second one; elastic: the same.
    """
    scene, scheme = cuda_contact_scenes.SCENES[name]()
    first = tc.simulate(scene, scheme, arch="cuda", progress=False)
    second = tc.simulate(scene, scheme, arch="cuda", progress=False, initial=first)
    names = {"elastic": "elastic", "plastic": "plastic_work"}
    return {
        f"gone-on/{key}": np.array([first.history[column][-1], second.history[column][0]])
        for key, column in names.items()
    }


def by_several_blocks(name: str) -> dict[str, np.ndarray]:
    """Return a run whose few nodes several blocks of threads take, and how many sweeps were launched one by one.

    named: arrays that launches of sweeps and of the end of a pass name.
    """
    limits = device_blocks.MANY_NODES, device_blocks.MANY_SWEPT
    device_blocks.MANY_NODES = device_blocks.MANY_SWEPT = 1
    swept: list[int] = []
    named: list[list[int]] = []
    offer = DeviceSweeps.offer

    def noted(self, *given):
        swept.append(self.offered[0])
        named.append([len(part) for part in self._arrays])
        offer(self, *given)

    DeviceSweeps.offer = noted
    found = cuda_contact_scenes.run(name, "cuda")
    device_blocks.MANY_NODES, device_blocks.MANY_SWEPT = limits
    DeviceSweeps.offer = offer
    return found | {"swept": np.array(sum(swept)), "named": np.array(named[:1])}


def main(out: str) -> None:
    """Run everything and store it."""
    runtime.start("cuda")
    found = runs(cuda_contact_scenes.SCENES)
    for name in cuda_contact_scenes.COUNTED:
        found |= calls_of_a_block(name)
    for name in cuda_contact_scenes.SHARED:
        found |= {f"shared-{name}/{key}": value for key, value in by_several_blocks(name).items()}
    if tiers.long():
        found |= gone_on("forged")
    found |= {f"short/{key}": value for key, value in short_of_passes().items()}
    if tiers.slow():
        found["resumed"] = resumed()
    found |= both_orders(lambda: runs(cuda_contact_scenes.REVERSED))
    np.savez(out, **found)


def runs(names: Iterable[str]) -> dict[str, np.ndarray]:
    """Return searches for the stable step and runs of scenes."""
    found = {}
    for name in cuda_contact_scenes.SEARCHED:
        words = (f"search/{name}/class", f"search/{name}/damped")
        found |= dict(zip(words, map(np.array, cuda_contact_scenes.damped_steps(name)), strict=True))
    for name in names:
        found |= {f"{name}/{key}": value for key, value in cuda_contact_scenes.run(name, "cuda").items()}
    return found


if __name__ == "__main__":
    main(sys.argv[1])
