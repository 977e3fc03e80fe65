"""Linear tetrahedra with the volume change averaged at the nodes, for nearly incompressible bodies and plastic flow.

    W = sum over cells of V_e [W_mu(F_e) + q/4 e^4] + sum over volume nodes of V_a U(J_a)

with W_mu the law without its volume part U (parameters[0]/2 (J - 1)^2), e = J - 1 of a cell, w_e = 1 over the number
of its corners that are volume nodes, and sums over the cells round a node (Bonet and Burton, Commun. Numer. Meth. Engng
14, 437, 1998, as an energy):

    V_a = sum of w_e V_e,   J_a - 1 = sum of w_e V_e e / V_a,   p_e = sum over corners of w_e U'(J_a) + q e^3

The force is the exact slope, P_e = dW_mu/dF + p_e cof F_e. A node that supports hold in all three components is no
volume node, and a cell without any averages over itself alone (w_e = 0). U'(J_a) has rough modes: only p_e is shown,
and enters the yield stress. Metals have q = 0.2 mu (GUARD), which keeps single cells from collapsing in strong flow
and vanishes with the strain; elastic laws need none. The linear law has e = tr H, and the cofactor at rest. The
averages are made in cells/node_volumes.py.
"""

from ..engine import ti
from ..language import tensor3
from .points import geometry, point_force
from .record import CellFunctions
from .tet4 import tet_centre, tet_corner_forces, tet_derivatives, tet_force, tet_viscosity

GUARD = 0.2


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


@ti.func
def of_volume(law: ti.template(), change, parameters):
    """Return [U', U] of J - 1 of a volume node."""
    if ti.static(law.plastic):
        found = law.plastic.volume(change, parameters, [])
        return [found[0], found[1]]
    else:
        return [parameters[0] * change, (0.5 * parameters[0]) * (change * change)]


@ti.func
def averaged_volume(law: ti.template(), own, parameters, averages):
    """Return [p_e, volume energy per V_e] of a cell whose J - 1 is `own`; averages: w_e, and J_a - 1 of the corners."""
    alone = averages[0] == 0.0
    share = ti.select(alone, 0.25, averages[0])
    pressure, energy = 0.0 * own, 0.0 * own
    for k in ti.static(range(4)):
        part = of_volume(law, ti.select(alone, own, averages[1][k]), parameters)
        pressure += share * part[0]
        energy += share * part[1]
    if ti.static(law.plastic):
        guard = GUARD * parameters[1] * own * own
        pressure += guard * own
        energy += 0.25 * guard * own * own
    return [pressure, energy]


@ti.func
def shape_response(g, shape, parameters, law: ti.template(), memory: ti.template(), pressure, own):
    """Return what `point_force` returns, for the law without its volume part; own: J - 1 of the cell."""
    if ti.static(memory and law.plastic):
        within = ti.static(memory._replace(pressure=[pressure, own]))
        return point_force(g, shape, parameters, law, within, 0)
    else:
        without = [0.0] + [parameters[i] for i in range(1, len(parameters))]
        return point_force(g, shape, without, law, memory, 0)


def make_force(volume, slopes_of):
    """Return the force function with this volume change V e, whose slope is the sum of these slopes over 6."""

    @ti.func
    def averaged_force(x, u, weight, parameters, law: ti.template(), memory: ti.template(), averages):
        """Return what `tet4.tet_force` returns; averages: `averages_of` (cells/node_averages.py)."""
        a, g = [tet_derivatives(x[c]) for c in range(3)], [tet_derivatives(u[c]) for c in range(3)]
        shape = geometry(a)
        own = volume(x, u) * (6.0 / shape[2])
        volumetric = averaged_volume(law, own, parameters, averages)
        answer = shape_response(g, shape, parameters, law, memory, volumetric[0], own)
        slopes = slopes_of(shape, a, g)
        share = weight * (1.0 / 6.0)
        force = [
            tet_corner_forces([share * (answer[0][c][j] + volumetric[0] * slopes[c][j]) for j in range(3)])
            for c in range(3)
        ]
        return [force, share * (answer[1] + volumetric[1] * shape[2]), answer[2]]

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
        share=1.0 / 6.0,
        averaged=True,
        volume=tet_volume,
        linear_volume=linear_tet_volume,
    )
}
