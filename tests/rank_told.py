"""What ranks are told: `mpiexec -n P python rank_told.py FOLDER`; each rank writes FOLDER/told.RANK, a line a kind.

Warnings that a script turns into errors, those that the first rank finds alone, starts that differ, folders of runs
that have ended, damaged checkpoints and those with values that a run does not have.
"""

import errno
import shutil
import sys
import warnings
from pathlib import Path

import numpy as np
from mpi4py import MPI
from rank_resumed import CHECKPOINT, stop_in_step_6
from rank_scenes import block, normal

import tcontact as tc
from tcontact.device import ranks
from tcontact.results.files.checkpoint_heads import place_of
from tcontact.run.checkpoint import store
from tcontact.schemes.explicit.state import DomainState

OWN = MPI.COMM_WORLD.Get_rank()


def caught(act, kind=tc.InputError):
    """Return the error of a call, "" without."""
    try:
        act()
    except kind as error:
        return str(error)
    return ""


def spun():
    """A body that spins at the start of a normal removal: the first rank alone looks at whole bodies."""
    body = block(counts=(3, 3, 6), contact="zmin", velocity=lambda x: np.cross((0.0, 150.0, 0.0), x) - (0.0, 0.0, 12.0))
    return tc.Scene([body], [tc.Plane()], 3e-3, contact=tc.MasslessContact(removal="normal"))


def bounced():
    """A penalty on nodes with mass that gains energy: a warning at the end of the run."""
    body = block("neo", counts=(3, 3, 6), contact="zmin", velocity=(1.0, 0.0, -45.0))
    return tc.Scene([body], [tc.Plane()], 3e-3, contact=tc.PenaltyContact(stiffness=2e10))


def damaged(folder):
    """Write over some bytes of the newest checkpoint of the last rank."""
    path = store.read_all(place_of(folder, MPI.COMM_WORLD.Get_size() - 1))[0][0].path
    content = bytearray(path.read_bytes())
    content[len(content) // 2 : len(content) // 2 + 64] = b"x" * 64
    path.write_bytes(content)


def with_another_value(folder):
    """Add a value that no run has to both checkpoints of the last rank."""
    place = place_of(folder, MPI.COMM_WORLD.Get_size() - 1)
    for one in store.read_all(place)[0]:
        one.path.unlink()
        store.write(place, one.head, one.values | {"domains.0.unheard": 1.0}, one.found)


def full(*_given):
    """Fail as a full disk does."""
    raise OSError(errno.ENOSPC, "No space left on device")


def main(folder):
    """Do everything on all ranks."""
    told = {}
    warnings.simplefilter("ignore")
    told["kept"] = "; ".join(text[:60] for text in tc.simulate(spun()).warnings)
    with warnings.catch_warnings():
        warnings.simplefilter("error", tc.RotationWarning)
        told["at once"] = caught(lambda: tc.simulate(spun()), tc.RotationWarning)
        warnings.simplefilter("error", tc.EnergyWarning)
        told["at the end"] = caught(lambda: tc.simulate(bounced(), out=folder / "bounced"), tc.EnergyWarning)
        warnings.simplefilter("error", RuntimeWarning)
        told["in time"] = caught(lambda: tc.simulate(normal(), tc.CentralDifference(dt=1.7e-4)), RuntimeWarning)
    mine = tc.simulate(tc.Scene([block(velocity=(0.0, 0.0, 1.0 + OWN))], duration=1e-4), comm=MPI.COMM_SELF)
    told["start"] = caught(lambda: tc.simulate(tc.Scene([block()], duration=1e-4), initial=mine))
    tc.simulate(normal(), out=folder / "ended", frames=2)
    told["ended"] = caught(lambda: tc.resume(folder / "ended", normal()))
    written = store.write
    if OWN == 1:
        store.write = full
    told["full"] = "; ".join(tc.simulate(normal(), out=folder / "full", checkpoint=CHECKPOINT).warnings)
    store.write = written
    original = stop_in_step_6("signalled")
    told["message"] = tc.simulate(normal(), out=folder / "stopped", frames=2, checkpoint=CHECKPOINT).message
    DomainState.advance = original
    if ranks.is_first_rank():
        shutil.copytree(folder / "stopped", folder / "other")
        with_another_value(folder / "other")
        damaged(folder / "stopped")
    MPI.COMM_WORLD.Barrier()
    told["unheard"] = caught(lambda: tc.resume(folder / "other", normal()))
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        told["resumed"] = tc.resume(folder / "stopped", normal()).reason
    told["damaged"] = "; ".join(str(one.message) for one in seen if "damaged" in str(one.message))
    lines = [f"{name}: {text}" for name, text in told.items()]
    Path(f"{folder}/told.{OWN}").write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
