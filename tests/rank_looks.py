"""What looks at whole bodies fetch from other ranks: `mpiexec -n P python rank_looks.py`; the first rank reports.

Two bodies that are no pair fall past each other onto a sphere, one of them spins; their nodes are followed, and the
angles they turn by.
"""

import warnings

import numpy as np
from rank_scenes import block

import tcontact as tc
from tcontact.device import ranks
from tcontact.device.lead import Lead
from tcontact.run.watches import body_meeting, normal_watch, path_watch

warnings.simplefilter("ignore")
sphere = tc.Sphere((0.05, 0.04, -0.3), 0.299)


def spinning(x):
    """Velocity of a body that turns about the y axis as it falls."""
    return np.cross((0.0, 400.0, 0.0), x - np.array([0.05, 0.04, 0.06])) + np.array([1.0, 0.5, -8.0])


bodies = [
    block("neo", counts=(9, 8, 11), velocity=spinning, contact="zmin"),
    block("neo", counts=(7, 7, 7), at=(0.2, 0.0, 0.05)),
]
scene = tc.Scene(bodies, [sphere], 6e-4, contact=tc.MasslessContact(removal="normal"))
nodes = sum(body.mesh.node_count for body in bodies)
surface = max(len(np.unique(body.mesh.boundary_faces())) for body in bodies)
seen, looks, equal = [], [], []


def counted(collected):
    """Note how many rows come at a time."""

    def called(self, read, counts, *given):
        seen.append(int(np.sum(counts)))
        return collected(self, read, counts, *given)

    return called


def compared(look):
    """Compare what a look reads with the whole body, in another order too."""

    def called(self, run, *given):
        before = len(seen)
        found = look(self, run, *given)
        looks.append((type(self).__name__, max(seen[before:], default=0)))
        for state in run.states:
            for nodes in (np.arange(0, state.plan.node_count, 7), np.array([5, 0, 3]), np.zeros(0, dtype=int)):
                chosen = state.chosen(nodes)
                equal.append(np.array_equal(state.latest_of(chosen), state.latest()[nodes]))
                start = state.plan.body.mesh.nodes[state.plan.node_order[nodes]]
                equal.append(np.array_equal(state.start_of(chosen), start))
        return found

    return called


Lead.collected = counted(Lead.collected)
for kind in (body_meeting.BodyMeeting, normal_watch.NormalWatch, path_watch.PathWatch):
    kind.look = compared(kind.look)
result = tc.simulate(scene, scheme=tc.CentralDifference(cfl=0.5), threads=1)
if ranks.is_first_rank():
    print("kinds", len({name for name, _ in looks}))
    print("most", max(count for name, count in looks if name == "NormalWatch"), normal_watch.SAMPLES)
    print("others", max(count for _, count in looks), surface, nodes)
    print("equal", len(equal), sum(equal))
    print("touched", int(np.abs(result.history["contact_force"]).max() > 0.0))
    print("told", sum("starts to turn by 0.24 rad" in text for text in result.warnings))
