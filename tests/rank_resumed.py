"""Runs that stop and go on: `mpiexec -n P python rank_resumed.py FOLDER MODE SCENE..`.

MODE: whole, killed, signalled, resumed; torn: the last rank is killed when the first one has written its second
checkpoint and it has not; torn-again: so is it when the run goes on. With `--cuda` before the folder each rank has a
GPU.
"""

import os
import signal
import sys
import time
import warnings
from pathlib import Path

import numpy as np
from rank_scenes import CONTACT_RANKS, SCENES

import tcontact as tc
from tcontact.device import ranks
from tcontact.device.leaves import leaves
from tcontact.results.files.checkpoint_heads import FILES, head_of
from tcontact.results.files.vtkhdf import ResultData
from tcontact.run.checkpoint import contents, store
from tcontact.schemes.explicit.state import DomainState

STOPS = {"killed": signal.SIGKILL, "signalled": signal.SIGTERM}
CHECKPOINT = tc.Checkpoint(every_steps=3)
FIELDS = {"varied": "all"}  # of the others: what frames hold without asking
RECORDED = ("slip_distance", "friction_work")


def stop_in_step_6(mode):
    """Let the last rank, or the only process, kill or signal itself in step 6; return the original step."""
    original, steps = DomainState.advance, []

    def advance(self, *given, **stop_at):
        steps.append(1)
        if len(steps) == 6 and ranks.launched()[1] == ranks.launched()[0] - 1:
            os.kill(os.getpid(), STOPS[mode])
        return original(self, *given, **stop_at)

    DomainState.advance = advance
    return original


def tear_second_checkpoint(folder):
    """Let the last rank kill itself before it writes the second checkpoint, after row 3, when the first rank has."""
    write, begun = store.write, time.time()

    def written(path):
        return path.exists() and path.stat().st_mtime > begun and head_of(path)["row"] > 3

    def torn(place, head, *given):
        if head["row"] > 3 and not ranks.is_first_rank():
            while not any(written(folder / name) for name in FILES):
                time.sleep(0.02)
            os.kill(os.getpid(), signal.SIGKILL)
        return write(place, head, *given)

    store.write = torn


def watch_paths():
    """Fail a checkpoint that holds a path which the new run did not have: nobody could go on from it."""
    known, prints, collect = set(), contents.prints, contents.collect

    def of_new(run):
        known.clear()
        known.update(leaf.path for leaf in leaves(run))
        return prints(run)

    def of_present(run, new):
        late = {leaf.path for leaf in leaves(run)} - known
        assert not late, f"these attributes appear during a run: {sorted(late)}"
        return collect(run, new)

    contents.prints, contents.collect = of_new, of_present


def main(folder, mode, *names, arch="cpu"):
    """Run, stop or resume the scenes; the first rank saves the values of each."""
    warnings.simplefilter("ignore")
    watch_paths()
    for name in names:
        scene, own = SCENES[name](), Path(folder) / name
        original = stop_in_step_6(mode) if mode in STOPS else DomainState.advance
        if mode.startswith("torn"):
            tear_second_checkpoint(own)
        if mode in ("resumed", "torn-again"):
            result = tc.resume(own, scene, threads=1, arch=arch, checkpoint=CHECKPOINT)
        else:
            options = {"frames": 5, "threads": 1, "checkpoint": CHECKPOINT, "arch": arch, "fields": FIELDS.get(name)}
            shared = CONTACT_RANKS.get(name) if arch == "cpu" else None
            result = tc.simulate(scene, out=own, contact_ranks=shared, **options)
        DomainState.advance = original
        if ranks.is_first_rank():
            if mode == "resumed":
                print(name, *result.warnings, sep="|")
            values = {"x": result.position, "v": result.velocity, "force": result.contact_node_force}
            for quantity, one in result.maxima.items():
                values[f"maximum {quantity}"] = np.array([one.value, one.time, one.cell])
            if name in FIELDS and mode not in STOPS:
                last = ResultData.open(own / "result.vtkhdf").frame(-1)
                values |= {f"recorded {field}": np.sort(last.point_data[field]) for field in RECORDED}
            np.savez(own / f"{mode}.npz", reason=np.array(result.reason), **values, **result.history)


if __name__ == "__main__":
    on_gpus = sys.argv[1] == "--cuda"
    main(*sys.argv[1 + on_gpus :], arch="cuda" if on_gpus else "cpu")
