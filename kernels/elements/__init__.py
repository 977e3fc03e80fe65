"""Kinds of cells by name, which a kernel factory takes as its `kind`: one file an element, with its `FUNCTIONS`."""

from ..materials import LAWS
from . import hex8, hex8_mean_dilatation, hex8_reduced, tet4

FUNCTIONS = hex8.FUNCTIONS | hex8_reduced.FUNCTIONS | hex8_mean_dilatation.FUNCTIONS | tet4.FUNCTIONS
CORNERS = {kind: functions.corners for kind, functions in FUNCTIONS.items()}


def force_of(kind: str, law: str):
    """Return the force function of a kind of cell with a law; some kinds have one of their own for the linear law."""
    functions = FUNCTIONS[kind]
    return (LAWS[law].linear and functions.linear_force) or functions.force
