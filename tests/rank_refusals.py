"""Errors of one rank alone that a script catches: `mpiexec -n P python rank_refusals.py FOLDER`.

Each rank writes FOLDER/told.RANK, a line a kind. The folder `locked` there is one in which another process runs.
"""

import re
import sys
from pathlib import Path

from rank_scenes import block

import tcontact as tc
from tcontact.device import ranks

OWN = ranks.launched()[1]


def caught(act):
    """Return the error of a call, "" without."""
    try:
        act()
    except tc.InputError as error:
        return re.sub(" at 0x[0-9a-f]+", "", str(error))  # a function stands elsewhere on each rank
    return ""


def drifting(time):
    """Return a pull that is another one whenever it is asked for."""
    drifting.count += 1
    return (0.0, 0.0, float(drifting.count))


drifting.count = 0


def main(folder):
    """Let the second rank alone give what is wrong, and then all of them a run that is well."""
    last = OWN == 1
    scene = tc.Scene([block(counts=(2, 2, 2))], duration=1e-4)
    pulled = tc.Scene(scene.bodies, duration=1e-4, gravity=drifting if last else (0.0, 0.0, 1.0))
    opened = "an opened result"
    asked = {
        "locked": lambda: tc.simulate(scene, threads=1, out=folder / "locked", frames=2),
        "frames": lambda: tc.simulate(scene, threads=1, frames=-1 if last else 3),
        "scene": lambda: tc.simulate(None if last else scene, threads=1),
        "scheme": lambda: tc.simulate(scene, "no scheme" if last else "central-difference", threads=1),
        "checkpoint": lambda: tc.simulate(scene, threads=1, checkpoint=1.0 if last else None),
        "initial": lambda: tc.simulate(scene, threads=1, initial=opened if last else None),
        "gravity": lambda: tc.simulate(pulled, threads=1),
        "threads": lambda: tc.simulate(scene, threads=0 if last else 1),
        "resumed": lambda: tc.resume(folder / "nowhere" if last else folder, scene, threads=1),
    }
    told = {name: caught(act) for name, act in asked.items()}
    result = tc.simulate(scene, threads=1)
    told["well"] = result.reason
    told["notebook"] = "" if ranks.is_first_rank() else f"{result._repr_html_()} {result._repr_png_()}"
    lines = [f"{name}: {text}" for name, text in told.items()]
    Path(f"{folder}/told.{OWN}").write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
