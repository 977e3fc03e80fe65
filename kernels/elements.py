"""Kinds of elements by name: what a kernel factory takes as its `kind`.

A force function answers [corner forces, energy, smallest det F - 1] for one cell, with the hourglass energy as a fourth
entry if the element has one (see `cells`, `reduced_hex`).
"""

from .cells import affine_hex_force, hex_force, tet_force
from .reduced_hex import reduced_force

CORNERS = {"hex8": 8, "hex8-affine": 8, "hex8-reduced": 8, "tet4": 4}
FORCES = {"hex8": hex_force, "hex8-affine": affine_hex_force, "hex8-reduced": reduced_force, "tet4": tet_force}
