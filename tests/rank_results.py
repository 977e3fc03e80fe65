"""Run scenes and save what they give: `[mpiexec -n P] python rank_results.py FOLDER NAME ...`; the first rank saves.

Scenes in `AGAIN` are run once more from their end.
"""

import sys
import warnings
from pathlib import Path

import numpy as np
from rank_scenes import PRESSURES, SCENES, SCHEMES

import tcontact as tc
from tcontact.device import ranks

AGAIN = ("layered", "metal")


def main(folder, names):
    """Save motion, forces, state of the metal, history and step of every scene; frames and fields in a folder each."""
    warnings.simplefilter("ignore")
    for name in names:
        out = Path(folder) / name
        options = {"scheme": SCHEMES.get(name, tc.CentralDifference()), "pressures": name in PRESSURES}
        result = tc.simulate(SCENES[name](), frames=3, fields="all", out=out, threads=1, **options)
        values = {"x": result.position, "v": result.velocity, "force": result.contact_node_force} | result.metals
        values |= {f"history {name}": column for name, column in result.history.items()}
        values |= {f"pressure {i}": record.pressure for i, record in enumerate(result.contact_pressures)}
        states = [block for body in result.points for block in body]
        values |= {f"points {i}": state for i, state in enumerate(states)}
        values |= {"limit": np.array(result.dt_limit), "dt": np.array(result.dt), "steps": np.array(result.steps)}
        if name in AGAIN:
            again = tc.simulate(SCENES[name](), initial=result, threads=1)
            values |= {"x again": again.position, "v again": again.velocity, "force again": again.contact_node_force}
        for quantity, one in result.maxima.items():
            values[f"maximum {quantity}"] = np.array([one.value, one.time, one.cell])
        if ranks.is_first_rank():
            np.savez(out / "values.npz", reason=np.array(result.reason), **values)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
