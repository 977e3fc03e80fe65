"""Kinds of elements by name: what a kernel factory takes as its `kind`.

A force function answers [corner forces, energy, smallest det F - 1] for one cell, with the hourglass energy as a fourth
entry if the element has one (see `cells`, `reduced_hex`, `mean_dilatation`).
"""

from .cells import affine_hex_force, hex_force, tet_force
from .mean_dilatation import affine_linear_mean_force, affine_mean_force, linear_mean_force, mean_force
from .reduced_hex import reduced_force

MEAN = ("hex8-mean-dilatation", "hex8-mean-dilatation-affine")
CORNERS = {"hex8": 8, "hex8-affine": 8, "hex8-reduced": 8, "tet4": 4} | dict.fromkeys(MEAN, 8)
FORCES = {
    "hex8": hex_force,
    "hex8-affine": affine_hex_force,
    "hex8-reduced": reduced_force,
    "hex8-mean-dilatation": mean_force,
    "hex8-mean-dilatation-affine": affine_mean_force,
    "tet4": tet_force,
}
LINEAR_FORCES = {
    "hex8-mean-dilatation": linear_mean_force,
    "hex8-mean-dilatation-affine": affine_linear_mean_force,
}


def force_of(kind: str, law: str):
    """The force function of an element with a law; some elements have one of their own for the linear law."""
    linear = law.startswith("linear_elastic")
    return LINEAR_FORCES.get(kind, FORCES[kind]) if linear else FORCES[kind]
