"""The subgrid friction layer: a thin sheared layer of metal at a sliding contact (METHOD 5, section 2 of the paper).

`solve` runs layers alone; `Layer` is the batch of cells with its state, to be advanced by whoever has velocity and
pressure. Importing this imports neither taichi nor matplotlib.
"""

from .layer import METHODS, Layer
from .metals import ALUMINIUM_6061, COPPER, METALS, STAINLESS_304, Metal
from .result import LayerResult, Side
from .solve import solve

__all__ = [
    "ALUMINIUM_6061",
    "COPPER",
    "METALS",
    "METHODS",
    "STAINLESS_304",
    "Layer",
    "LayerResult",
    "Metal",
    "Side",
    "solve",
]
