"""A long run on several ranks, which ends early: `mpiexec -n P python rank_ends.py FOLDER [fails]`.

Every rank writes its process number first; with "fails" the second rank raises an error of its own in step 20, while
its launcher looks away for a second, as on a busy machine.
"""

import os
import signal
import subprocess
import sys
from pathlib import Path

folder = Path(sys.argv[1])
rank = os.environ.get("PMI_RANK") or os.environ["OMPI_COMM_WORLD_RANK"]
(folder / f"pid-{rank}").write_text(str(os.getpid()), encoding="utf-8")

from rank_scenes import block  # noqa: E402 - the numbers go first

import tcontact as tc  # noqa: E402
from tcontact.schemes.explicit.rank_state import RankState  # noqa: E402


def look_away(number):
    """Stop a process for a second."""
    os.kill(number, signal.SIGSTOP)
    silent = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    subprocess.Popen(["sh", "-c", f"sleep 1; kill -CONT {number}"], start_new_session=True, **silent)


contact = tc.MasslessContact()
scene = tc.Scene([block(contact="zmin")], [tc.Plane()], 100.0, gravity=(0.0, 0.0, -9.81), contact=contact)
if "fails" in sys.argv and rank == "1":
    original, calls = RankState.advance, []

    def advance(self, *given, **stop_at):
        calls.append(1)
        if len(calls) == 20:
            look_away(os.getppid())
            raise RuntimeError("this rank alone")
        return original(self, *given, **stop_at)

    RankState.advance = advance
(folder / f"ready-{rank}").touch()
result = tc.simulate(scene, out=folder / "run", frames=1000, threads=1)
os.write(1, f"reason {result.reason}\n".encode())  # whole, between the lines of the other ranks
