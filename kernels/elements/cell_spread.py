"""Spread of a cell: its volume v and the slopes b_k = dv/dx_k at its corners, which bound its largest frequency.

A cell of one point with the modulus M of plane waves, the density rho and corner masses rho V/corners has

    omega^2 <= M/rho  corners Lambda/(v V),    Lambda: of  sum over k of b_k b_k^t

with the trace for Lambda; with its largest eigenvalue, plane waves across the cell have about this frequency, and so
has a regular mesh of such cells. V: volume at rest. (Flanagan and Belytschko 1981; `hex8` has the slopes by modes.)

Each function takes the corners x[c][k] and returns [v, vectors] with  sum of w w^t = corners sum over k of b_k b_k^t.
"""

from ..engine import ti
from ..language import tensor3
from .hex8 import hex_modes, hex_slopes
from .tet4 import tet_derivatives
from .wedge6 import wedge_corner_forces, wedge_differences, wedge_slopes


@ti.func
def hex_spread(x):
    """Return the spread of a hex8."""
    d, slopes = hex_slopes([hex_modes(x[c]) for c in range(3)])
    return [(1.0 / 64.0) * d, [[0.125 * slopes[m][c] for c in range(3)] for m in range(6)]]


@ti.func
def tet_spread(x):
    """Return the spread of a tet4."""
    a = [tet_derivatives(x[c]) for c in range(3)]
    slopes = tensor3.cofactor(a)
    third = 1.0 / 3.0
    outer = [third * (slopes[c][0] + slopes[c][1] + slopes[c][2]) for c in range(3)]
    vectors = [[third * slopes[c][j] for c in range(3)] for j in range(3)]
    return [(1.0 / 6.0) * tensor3.determinant(a, slopes), vectors + [outer]]


@ti.func
def wedge_spread(x):
    """Return the spread of a wedge6."""
    d, slopes = wedge_slopes([wedge_differences(x[c]) for c in range(3)])
    corner = [wedge_corner_forces([slopes[m][c] for m in range(5)]) for c in range(3)]
    return [0.5 * d, [[0.5 * 6.0**0.5 * corner[c][k] for c in range(3)] for k in range(6)]]


SPREADS = {4: tet_spread, 6: wedge_spread, 8: hex_spread}  # by the number of corners
