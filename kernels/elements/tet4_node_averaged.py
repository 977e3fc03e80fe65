"""Linear tetrahedra with the volume change averaged at the nodes, for nearly incompressible bodies and plastic flow.

    W = sum over cells of V_e W_mu(F_e) + sum over volume nodes of V_a parameters[0]/2 th_a^2

with W_mu the law with parameters[0] = 0, e = J - 1 of a cell, w_e = 1 over the number of its corners that are volume
nodes, and sums over the cells round a node (Bonet and Burton, Commun. Numer. Meth. Engng 14, 437, 1998, as an energy):

    V_a = sum of w_e V_e,   th_a = sum of w_e V_e e_e / V_a,   p_e = parameters[0] sum over corners of w_e th_a

The force is the exact slope, P_e = dW_mu/dF + p_e cof F_e. A node that supports hold in all three components is no
volume node, and a cell without any averages over itself alone (w_e = 0). th_a alone has rough modes: it is never an
output. The linear law has e = tr H, and the cofactor at rest. The averages are made in cells/node_volumes.py.
"""

import taichi as ti

from ..language import tensor3
from .points import geometry, point_force
from .record import CellFunctions
from .tet4 import tet_centre, tet_corner_forces, tet_derivatives, tet_force, tet_viscosity


@ti.func
def tet_volume(x, u):
    """Return V (J - 1) of a tet4 from its corners, without cancellation."""
    a, g = [tet_derivatives(x[c]) for c in range(3)], [tet_derivatives(u[c]) for c in range(3)]
    m = tensor3.cofactor(g)
    change = tensor3.dot(tensor3.cofactor(a), g) + (tensor3.dot(a, m) + tensor3.determinant(g, m))
    return (1.0 / 6.0) * change


@ti.func
def linear_tet_volume(x, u):
    """Return V tr H of a tet4 from its corners."""
    a, g = [tet_derivatives(x[c]) for c in range(3)], [tet_derivatives(u[c]) for c in range(3)]
    return (1.0 / 6.0) * tensor3.dot(tensor3.cofactor(a), g)


@ti.func
def present_slopes(shape, a, g):
    """Return cof(dx/dr) of the present positions."""
    return tensor3.cofactor([[a[c][j] + g[c][j] for j in range(3)] for c in range(3)])


@ti.func
def slopes_at_rest(shape, a, g):
    """Return cof(dX/dr)."""
    return shape[0]


def make_force(volume, slopes_of):
    """Return the force function with this volume change V e, whose slope is the sum of these slopes over 6."""

    @ti.func
    def averaged_force(x, u, weight, parameters, law: ti.template(), memory: ti.template(), averages):
        """Return what `tet4.tet_force` returns; averages: w_e, and the sums of th_a and th_a^2 over the corners."""
        a, g = [tet_derivatives(x[c]) for c in range(3)], [tet_derivatives(u[c]) for c in range(3)]
        shape = geometry(a)
        without = [0.0] + [parameters[i] for i in range(1, len(parameters))]
        answer = point_force(g, shape, without, law, memory, 0)
        own = volume(x, u) * (6.0 / shape[2])
        alone = averages[0] == 0.0
        mean = ti.select(alone, own, averages[0] * averages[1])
        square = ti.select(alone, own * own, averages[0] * averages[2])
        slopes = slopes_of(shape, a, g)
        pressure = parameters[0] * mean
        share = weight * (1.0 / 6.0)
        force = [
            tet_corner_forces([share * (answer[0][c][j] + pressure * slopes[c][j]) for j in range(3)]) for c in range(3)
        ]
        return [force, share * (answer[1] + (0.5 * parameters[0]) * square * shape[2]), answer[2]]

    return averaged_force


@ti.func
def shear_step_force(x, d, weight, parameters, law: ti.template(), memory: ti.template()):
    """Return the forces of a step without its volume change: a viscosity of the volume of each cell would lock."""
    return tet_force(x, d, weight, [0.0, parameters[1]], law, memory)


FUNCTIONS = {
    "tet4-node-averaged": CellFunctions(
        4,
        make_force(tet_volume, present_slopes),
        shear_step_force,
        tet_viscosity,
        tet_centre,
        make_force(linear_tet_volume, slopes_at_rest),
        "node-averaged",
        points=1,
        averaged=True,
        volume=tet_volume,
        linear_volume=linear_tet_volume,
    )
}
