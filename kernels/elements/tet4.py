"""Linear tetrahedra: one point of weight 1/6, differences to corner 0 (Hughes, The Finite Element Method, ch. 3).

"tet4-stored" has A^-t of every cell, row by row, and D behind it in an array, so that the positions of the corners need
not be gathered and A not be inverted in every step: H = G A^-1, dW/dG = D P A^-t.
"""

from ..engine import ti
from ..language import tensor3
from ..language.point_memory import respond
from .bulk_viscosity import pressure_rate
from .points import dot, geometry, point_force
from .record import CellFunctions

STORED = 10  # A^-t and D


@ti.func
def tet_derivatives(corner):
    """Return the 3 derivatives of one component from its 4 corner values."""
    return [corner[1] - corner[0], corner[2] - corner[0], corner[3] - corner[0]]


@ti.func
def tet_corner_forces(q):
    """Return the 4 corner forces of one component from dW/dG [direction j]."""
    return [0.0 - q[0] - q[1] - q[2], q[0], q[1], q[2]]


@ti.func
def tet_force(x, u, weight, parameters, law: ti.template(), memory: ti.template()):
    """Return [corner forces dW/du as [component][corner], energy, det F - 1] of a tet4 from x[c][k], u[c][k]."""
    a = [tet_derivatives(x[c]) for c in range(3)]
    g = [tet_derivatives(u[c]) for c in range(3)]
    answer = point_force(g, geometry(a), parameters, law, memory, 0)
    share = weight * (1.0 / 6.0)
    force = [tet_corner_forces([share * answer[0][c][j] for j in range(3)]) for c in range(3)]
    return [force, share * answer[1], answer[2]]


@ti.func
def stored_tet_force(shape, u, weight, parameters, law: ti.template(), memory: ti.template()):
    """Return what `tet_force` returns; shape: A^-t and D of the cell."""
    inverse, d = [[shape[3 * c + j] for j in range(3)] for c in range(3)], shape[9]
    g = [tet_derivatives(u[c]) for c in range(3)]
    answer = respond(law, tensor3.product_transposed(g, inverse), parameters, memory, 0, d)
    share = weight * (1.0 / 6.0) * d
    stress = tensor3.product(answer[0], inverse)
    force = [tet_corner_forces([share * stress[c][j] for j in range(3)]) for c in range(3)]
    return [force, share * answer[1], answer[2]]


@ti.func
def tet_viscosity(x, u, v, half, speed, square):
    """Return [corner forces [component][corner], -q, V', rate, V at rest, t] of a tet4 as `hex8.hex_viscosity`."""
    a = [tet_derivatives(x[c]) for c in range(3)]
    g = [tet_derivatives(u[c]) for c in range(3)]
    w = [tet_derivatives(v[c]) for c in range(3)]
    reference = tensor3.determinant(a, tensor3.cofactor(a))
    now = [[a[c][j] + g[c][j] for j in range(3)] for c in range(3)]
    slopes = tensor3.cofactor(now)  # [component][corner - 1]; the slope of corner 0 is minus their sum
    middle = tensor3.cofactor([[now[c][j] - half * w[c][j] for j in range(3)] for c in range(3)])
    change = tensor3.dot(middle, w)
    sums = [slopes[c][0] + slopes[c][1] + slopes[c][2] for c in range(3)]
    largest = dot(sums, sums)
    square_sum = largest
    for j in ti.static(range(3)):
        column = [slopes[c][j] for c in range(3)]
        length = dot(column, column)
        square_sum += length
        largest = ti.max(largest, length)
    answer = pressure_rate(change, tensor3.determinant(now, slopes), reference, ti.sqrt(largest), speed, square)
    pressure = answer[0] * answer[1] * (1.0 / 6.0)
    force = [tet_corner_forces([pressure * slopes[c][j] for j in range(3)]) for c in range(3)]
    rates = [4.0 * answer[i] * square_sum for i in range(2, 4)]
    return [force, pressure, change, rates[0], (1.0 / 6.0) * reference, rates[1]]


@ti.func
def tet_centre(x, u):
    """Return H of a tet4 from its corners."""
    shape = geometry([tet_derivatives(x[c]) for c in range(3)])
    return tensor3.product_transposed([tet_derivatives(u[c]) for c in range(3)], shape[1])


TET4 = CellFunctions(4, tet_force, tet_force, tet_viscosity, tet_centre, points=1, share=1.0 / 6.0)
FUNCTIONS = {"tet4": TET4, "tet4-stored": TET4._replace(force=stored_tet_force, stored=STORED)}
