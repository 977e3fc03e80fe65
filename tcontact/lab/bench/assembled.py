"""The linear force as a product with an assembled sparse matrix (SciPy CSR), as it is computed without kernels."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import numpy as np

from ...planning.body_plan import BodyPlan
from . import reference

MOST_CELLS = 40**3  # assembling more takes too much memory


def possible(law: str, kind: str, cells: int) -> bool:
    """Tell whether there is such a matrix and room for it."""
    return law == "linear" and kind == "hex8" and cells <= MOST_CELLS and find_spec("scipy") is not None


def stiffness(plan: BodyPlan) -> Any:
    """Return K [3n, 3n] in CSR of a body whose cells all have one shape; internal numbering."""
    from scipy import sparse

    material, cells = plan.body.material, plan.cells
    lame = (material.lame_lambda, material.lame_mu)
    one = reference.cell_stiffness(plan.body.mesh.kind, lame, plan.reference[cells[0]])
    places = (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), -1).astype(np.int32)
    width = places.shape[1]
    rows, columns = np.repeat(places, width, axis=1).ravel(), np.tile(places, (1, width)).ravel()
    size = 3 * len(plan.reference)
    matrix = sparse.coo_matrix((np.tile(one.ravel(), len(cells)), (rows, columns)), shape=(size, size)).tocsr()
    matrix.sort_indices()
    return matrix


def size_in_bytes(matrix: Any) -> int:
    """Return the bytes of its three arrays."""
    return matrix.data.nbytes + matrix.indices.nbytes + matrix.indptr.nbytes
