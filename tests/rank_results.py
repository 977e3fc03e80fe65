"""Run scenes and save what they give: `[mpiexec -n P] python rank_results.py FOLDER NAME ...`; the first rank saves.

Scenes in `AGAIN` are run once more from their end. With `--cuda` before the folder each rank has a GPU.
"""

import sys
import warnings
from pathlib import Path

import cuda_contact_scenes
import numpy as np
from rank_scenes import APART, CONTACT_RANKS, PRESSURES, SCENES, SCHEMES

import tcontact as tc
from tcontact.device import arrays, ranks
from tcontact.device.exchange import Exchange
from tcontact.planning.partition.domain_part import cut_domain
from tcontact.run import rank_run
from tcontact.schemes.explicit.rank_state import RankState

AGAIN = ("layered", "metal", "pair")
MOTION = ("x", "v", "force")


STATES = []  # of the ranks of the run, in their order


class Watched(RankState):
    """The state of a rank, which is kept to look at its copies of nodes."""

    def __init__(self, *given):
        STATES.append(self)
        super().__init__(*given)

    def forget(self):
        """Keep what a run forgets at its end."""


def scene_of(name):
    """Return a scene and its scheme; those that ranks on CPUs do not run are of cuda_contact_scenes.py."""
    if name in SCENES:
        return SCENES[name](), SCHEMES.get(name, tc.CentralDifference())
    return getattr(cuda_contact_scenes, name)()


def by_bodies(domain, _scene, ranks, _contact=None):
    """A cut that gives the bodies to the ranks in turn."""
    counts = [body.body.mesh.cell_count for body in domain.bodies]
    return np.repeat(np.arange(len(counts)) % ranks, counts).astype(np.int32)


def unequal_copies():
    """Return how many nodes have copies of other bits on some rank, and how many ranks have contact nodes."""
    wrong, contact = 0, 0
    for state in STATES:
        motion = np.stack([arrays.get(values).reshape(-1, 3) for values in (state.u, state.v)], axis=1)
        own = {node: motion[at].tobytes() for at, node in enumerate(state.part.nodes.tolist())}
        known = {}
        for one in state.team.comm.allgather(own):
            wrong += sum(known.setdefault(node, bits) != bits for node, bits in one.items())
        contact += sum(state.team.comm.allgather(state.contact is not None))
    return wrong, contact


def end_of(result):
    """Return the values of nodes and cells at the end of a run, which the first rank has."""
    if not ranks.is_first_rank():
        return {}
    values = dict(zip(MOTION, (result.position, result.velocity, result.contact_node_force), strict=True))
    states = [block for body in result.points for block in body]
    return values | result.metals | {f"points {i}": state for i, state in enumerate(states)}


def main(folder, names, arch="cpu"):
    """Save motion, forces, state of the metal, history and step of every scene; frames and fields in a folder each."""
    warnings.simplefilter("ignore")
    for name in names:
        out = Path(folder) / name
        STATES.clear()
        before = Exchange.all_messages
        scene, scheme = scene_of(name)
        options = {"scheme": scheme, "pressures": name in PRESSURES, "arch": arch}
        options["contact_ranks"] = CONTACT_RANKS.get(name) if arch == "cpu" else None
        rank_run.cut_domain = by_bodies if name in APART else cut_domain
        result = tc.simulate(scene, frames=3, fields="all", out=out, threads=1, **options)
        values = end_of(result)
        values |= {f"history {name}": column for name, column in result.history.items()}
        values |= {f"pressure {i}": record.pressure for i, record in enumerate(result.contact_pressures)}
        values |= {"limit": np.array(result.dt_limit), "dt": np.array(result.dt), "steps": np.array(result.steps)}
        copies, contact = unequal_copies()
        told = {"copies": np.array(copies), "touching": np.array(contact)}
        told["messages"] = np.array(Exchange.all_messages - before)
        if name in AGAIN:
            again = tc.simulate(scene_of(name)[0], initial=result, threads=1, arch=arch)
            values |= {f"{quantity} again": value for quantity, value in end_of(again).items() if quantity in MOTION}
        for quantity, one in result.maxima.items():
            values[f"maximum {quantity}"] = np.array([one.value, one.time, one.cell])
        if ranks.is_first_rank():
            np.savez(out / "values.npz", reason=np.array(result.reason), **values)
            np.savez(out / "ranks.npz", **told)


rank_run.RankState = Watched
if __name__ == "__main__":
    on_gpus = sys.argv[1] == "--cuda"
    folder, *names = sys.argv[1 + on_gpus :]
    main(folder, names, "cuda" if on_gpus else "cpu")
