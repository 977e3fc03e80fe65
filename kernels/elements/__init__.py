"""Elements by name, the `kind` of kernel factories; each element is one file with its `FUNCTIONS`."""

from ..materials import LAWS
from . import hex8, hex8_mean_dilatation, hex8_reduced, tet4, tet4_node_averaged, wedge6

FUNCTIONS = {}
for element in (hex8, hex8_reduced, hex8_mean_dilatation, tet4, tet4_node_averaged, wedge6):
    FUNCTIONS |= element.FUNCTIONS
CORNERS = {kind: functions.corners for kind, functions in FUNCTIONS.items()}
# elements that compute the same cells from positions, of those that read stored shapes
UNSTORED = {"tet4-stored": "tet4", "hex8-reduced-affine": "hex8-reduced"}


def force_of(kind: str, law: str):
    """Return the force function of a kind of cell with a law; some kinds have one of their own for the linear law."""
    functions = FUNCTIONS[kind]
    return (LAWS[law].linear and functions.linear_force) or functions.force


def step_force_of(kind: str, thread: bool = False):
    """Return the force function of a step of a kind of cell (record.py); thread: for a thread with its own cell."""
    functions = FUNCTIONS[UNSTORED.get(kind, kind)]
    return (thread and functions.thread_step_force) or functions.step_force


def thread_force_of(kind: str, law: str):
    """Return the force function for a thread with a cell of its own; some kinds have one that needs few registers."""
    functions = FUNCTIONS[kind]
    return (LAWS[law].linear and functions.linear_thread_force) or functions.thread_force or force_of(kind, law)
