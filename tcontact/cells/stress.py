"""Von Mises stress of a body, one value per cell: at its centre, in one-point hexes from the mean gradient."""

from __future__ import annotations

import numpy as np

from ..base.errors import InputError
from ..device import arrays
from ..device.launch import Prepared
from ..planning.packing import WIDTH, pack_cells
from ..results.frame_fields import NO_STRESS
from ..scene.body import Body


class VonMises:
    """Computes the von Mises norm of the Cauchy stress of a body for any displacement.

    It is made only where it is shown: it compiles its own kernel and keeps connectivity, positions, displacement and
    result, 24 (tet4), 32 (wedge6) or 40 (hex8) bytes a cell and 48 a node. Taichi must be running (`runtime.start`).
    Raises `InputError` for a law that the kernels do not have.
    """

    def __init__(self, body: Body) -> None:
        from ..kernels.cells.von_mises import make_von_mises
        from ..kernels.materials import LAWS

        mesh, law = body.mesh, body.material.law
        if law not in LAWS:
            raise InputError("material.law", law, f"the kernels know {', '.join(LAWS)}")
        if LAWS[law].state:
            raise InputError("material.law", law, NO_STRESS)
        kind = body.element
        packs = pack_cells(mesh.cells, mesh.node_count, WIDTH)
        self._count = mesh.cell_count
        self._kernel = Prepared(make_von_mises(kind, law))
        self._connectivity = arrays.put(packs.connectivity)
        self._position = arrays.put(mesh.nodes)
        self._parameters = arrays.put(np.array(body.material.parameters))
        self._u = arrays.zeros(3 * mesh.node_count)
        self._stress = arrays.zeros(packs.lanes)

    def __call__(self, displacement: np.ndarray) -> np.ndarray:
        """Return the stress [m] [Pa] at a displacement [n, 3] [m] of the user; the next call overwrites it."""
        arrays.set_values(self._u, displacement)
        self._kernel(self._connectivity, self._position, self._parameters, self._u, self._stress)
        return arrays.get(self._stress)[: self._count]
