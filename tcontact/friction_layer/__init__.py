"""The subgrid friction layer: a thin sheared layer of metal at a sliding contact (METHOD 5, section 2 of the paper).

How it works. Under the surface lies a layer a few micrometres thick. The slip heats it, heat is conducted inwards,
and its strength falls with temperature and grows with plastic strain; the lowest strength over the depth bounds the
shear stress, and that stress is what heats: one implicit scalar equation a step, which a bracketed Newton method
always solves (`kernels/layer/`). `metals` has the constants, `layer` a batch of layers with their state, and
`contact/layered_friction.py` puts one under every contact node of a scene.

`solve` runs layers alone; `Layer` is a batch of layers with its state, which its caller advances by velocity and
pressure. Importing this imports neither taichi nor matplotlib.
"""

from .layer import METHODS, Layer
from .metals import ALUMINIUM_6061, COPPER, METALS, STAINLESS_304, Metal
from .result import LayerResult, Side
from .solution import solve
from .state import LayerState

__all__ = [
    "ALUMINIUM_6061",
    "COPPER",
    "METALS",
    "METHODS",
    "STAINLESS_304",
    "Layer",
    "LayerResult",
    "LayerState",
    "Metal",
    "Side",
    "solve",
]
