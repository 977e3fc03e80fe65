"""Who has what of a run: `mpiexec -n P python rank_memory.py FOLDER`; the first rank reports.

All ranks refuse to make all nodes or cells of a box, and those other than the first to plan; where these write no
frames also those of the mesh of their part, which their plan has: the run ends if they try. With "alone" as a second
word the last rank asks for the values of all ranks while the others start a run; with "shared" all ranks share contacts
that sweeps and MPRGP solve, with a penalty and of a pair, for whose cut the first one makes all cells.
"""

import sys
import warnings
import weakref
from pathlib import Path

import numpy as np
from rank_scenes import SCENES, block

import tcontact as tc
from tcontact.device import ranks
from tcontact.mesh.box_arrays import BoxMesh
from tcontact.mesh.late_rows import LateRows
from tcontact.mesh.ordered_mesh import OrderedMesh
from tcontact.planning import planning
from tcontact.run import rank_run

warnings.simplefilter("ignore")
first, last = ranks.is_first_rank(), ranks.launched()[1] == ranks.launched()[0] - 1


def refuse(*_given, **_named):
    """Fail where a rank makes what it shall not have."""
    raise AssertionError("a rank has a whole mesh, or one other than the first a whole plan")


cells, forces, alive = [], [], []


class State(rank_run.RankState):
    """Notes how many cells whole bodies have while the state of a rank is made, and its force pass."""

    def __init__(self, scene, part, *given):
        cells.append(sum(len(body.rows) for body in part.whole.bodies) if first else 0)
        super().__init__(scene, part, *given)
        forces.append(weakref.ref(self.internal_force))


class Whole(rank_run.WholeBodies):
    """Notes how many force passes are there when whole bodies are made at the end."""

    def __init__(self, *given):
        alive.append(sum(force() is not None for force in forces))
        super().__init__(*given)


rank_run.RankState, rank_run.WholeBodies, rank_run.LARGE = State, Whole, 0
sharing = sys.argv[2:] == ["shared"]
if not (first and sharing):
    BoxMesh.nodes = BoxMesh.cells = LateRows.whole = property(refuse)
if not first:
    planning._plan_body = refuse
if sharing:
    for name in ("normal", "rubber", "pressed", "crossed"):
        found = tc.simulate(SCENES[name](), threads=1, contact_ranks=3).on_all_ranks()
        if first:
            print(name, found.ok, found.history["contact_nodes"].max())
    told = tc.simulate(SCENES["layered"](), threads=1, contact_ranks=2).warnings
    if first:
        print("told", *(text for text in told if text.startswith("contact_ranks")))
    sys.exit()

mesh = tc.box_mesh((0.1, 0.08, 0.12), (4, 3, 5)).translated((0.0, 0.0, 1e-4)).with_sets(cell_sets={"low": [0, 1]})
body = tc.Body(mesh, tc.NeoHookean(2.3e7, 0.27, 1350.0), velocity=(1.0, 0.5, -8.0), contact="zmin")
other = block(at=(0.5, 0.0, 0.0), counts=(3, 3, 3), velocity=(0.0, 0.0, 0.0))
scene = tc.Scene([body, other], [tc.Plane()], 1e-3, contact=tc.MasslessContact(), gravity=(0.0, 0.0, -9.81))
result = tc.simulate(scene, frames=3, fields="all", out=Path(sys.argv[1]) / "run", threads=1, pressures=True)
if sys.argv[2:] == ["alone"] and last:
    result.on_all_ranks()
said = ""
try:
    result.position
except tc.InputError as error:
    said = str(error)
if not first:
    OrderedMesh.nodes = OrderedMesh.cells = property(refuse)
again = tc.simulate(scene, initial=result.reversed(), threads=1)
whole = result.on_all_ranks()
told = whole.position.sum(), whole.velocity.sum(), whole.steps, whole.ok, len(whole.contact_pressures)
everyone = ranks.communicator().gather((said, told, result.history["energy"][-1]))
noted = ranks.communicator().gather((len(cells), len(alive), max(cells), max(alive)))
if first:
    print("refused", sum("Result.position = 'on rank " in said for said, *_ in everyone))
    print("remedy", everyone[1][0].partition("or call ")[2])
    print("alike", len({told for _, told, _ in everyone}), len({energy for *_, energy in everyone}))
    there = [one.position[one.nodes_of(scene.label(1))] for one in (whole, again)]  # it has fallen, and climbs back
    start = other.mesh.nodes_at(np.arange(other.mesh.node_count))
    fallen, missing = (np.abs(place - start).max() for place in there)
    print("back", missing / fallen)
    print("noted", *np.max(noted, axis=0))
