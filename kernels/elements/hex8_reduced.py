"""One-point hexahedra: mean gradient, and a stiffness against the hourglass modes, which it does not contain.

With the modes u_m of the displacements (`hex8`) and the slopes s_m = dD/dx_m of the volume V = D/64 of a hex with any
corners, the mean gradient H = 1/V int grad u dV is

    H = 1/D sum over m of u_m s_m^t

(b_k = V grad N_k = dV/dx_k of Flanagan and Belytschko, Int. J. Numer. Meth. Engng 17, 679, 1981, sorted by modes.) This
is the exact integral, not the gradient at the centre: sums of b_k over the cells of an inner node vanish on distorted
meshes too, so patches carry uniform stress. H does not contain the four hourglass modes a = 12, 13, 23, 123:

    q_a = u_a - H x_a = sum over k of gamma_ak u_k,   W_cell = V W(H) + kappa/2 sum over a of |q_a|^2,
    kappa = HOURGLASS (lam + 2 mu) (b:b) / (8 V),     b:b = sum over k of |b_k|^2

The hourglass part is measured in the reference state: q is 0 for every linear field, also finite rotations.
(lam + 2 mu at small strains is the modulus of the law, materials/law.py; implicit steps have the same number from
`Material.wave_modulus`, for registered laws that of the stiffest plane wave.)
HOURGLASS is the stiffness of an hourglass mode of unit length over (lam + 2 mu) (b:b)/V, the usual bound on that of the
modes which H sees (kappa gamma gamma^t, gamma.gamma = 8 in a brick). For cubes and Poisson's ratio 0.3, 1/12 gives an
hourglass mode the energy of pure bending. With 0.05 a cantilever of 1, 2, 4 cubes in thickness is 39, 7, 1 % too soft
(full hexes: 56, 16, 5 % too stiff); with cells longer than thick it is too stiff, like full hexes but less. The stable
step is that of full hexes or more up to about 0.1; 1/3 costs 5 %, 1/2 costs 20 %. Smaller values cost the static solve
sweeps (0.02: a third more, 0.01: twice as many).

In plastic flow an elastic hourglass stiffness locks as full integration does. It is reduced to the secant modulus of
the committed plastic strain, Y/(Y + 3 mu ep) times the elastic one, which never grows; what its energy loses as a point
commits is dissipated ("hourglass_work" of the history).
"""

from ..engine import ti
from ..language import tensor3
from ..language.point_memory import RELEASED, recall, respond
from .hex8 import hex_corner_forces, hex_modes, hex_slopes, hex_viscosity
from .points import dot
from .record import CellFunctions

HOURGLASS = 0.05
STORED = 10  # of a parallelepiped: s_m/D and D
SOFTEST = 0.01  # of the hourglass stiffness in plastic flow; 1e-4 leaves static solves unconverged


@ti.func
def reduced_force(x, u, weight, parameters, law: ti.template(), memory: ti.template()):
    """Return [corner forces dW/du as [component][corner], energy, det F - 1, hourglass energy] of a one-point hex8.

    x[c][k], u[c][k] as for `hex8.hex_points`; det F is that of the mean gradient; energy includes hourglass energy.
    """
    mode_x = [hex_modes(x[c]) for c in range(3)]
    mode_u = [hex_modes(u[c]) for c in range(3)]
    gradient = mean_gradient(mode_x, mode_u)
    d, slopes, h = gradient[0], gradient[1], gradient[2]
    inverse = 1.0 / d
    softening = stiffness_ratio(law, parameters, memory)  # before the point stores its new state
    answer = respond(law, h, parameters, memory, 0, d)

    square = dot(slopes[0], slopes[0]) + dot(slopes[1], slopes[1]) + dot(slopes[2], slopes[2])
    square += dot(slopes[3], slopes[3]) + dot(slopes[4], slopes[4]) + dot(slopes[5], slopes[5])
    kappa = HOURGLASS * law.modulus(parameters) * square * inverse
    q = [[mode_u[c][3 + a] - dot(h[c], [mode_x[j][3 + a] for j in range(3)]) for a in range(4)] for c in range(3)]
    hourglass = 0.5 * kappa * (four(q[0], q[0]) + (four(q[1], q[1]) + four(q[2], q[2])))
    kappa *= softening
    if ti.static(memory and law.plastic):
        softer = softened(law, answer[3], parameters)
        memory.tally[RELEASED] = memory.tally[RELEASED] + (softening - softer) * hourglass
        hourglass *= softer
    turned = kappa * inverse
    twist = [[mode_x[j][3 + a] for a in range(4)] for j in range(3)]
    share = weight * (1.0 / 64.0)
    kept = share * kappa
    stress = [[share * (answer[0][c][j] - turned * four(q[c], twist[j])) for j in range(3)] for c in range(3)]
    mode_f = [
        [dot(stress[c], slopes[m]) for m in range(3)]
        + [dot(stress[c], slopes[3 + a]) + kept * q[c][a] for a in range(3)]
        + [kept * q[c][3]]
        for c in range(3)
    ]
    force = [hex_corner_forces(mode_f[c]) for c in range(3)]
    return [force, share * (d * answer[1] + hourglass), answer[2], share * hourglass]


@ti.func
def affine_reduced_force(shape, u, weight, parameters, law: ti.template(), memory: ti.template()):
    """Return what `reduced_force` returns for a parallelepiped, whose modes 12, 13, 23, 123 and their slopes are 0.

    shape: s_m/D as [component][m], then D.
    """
    over, d = [[shape[3 * c + m] for m in range(3)] for c in range(3)], shape[9]
    mode_u = [hex_modes(u[c]) for c in range(3)]
    h = tensor3.product_transposed([[mode_u[c][m] for m in range(3)] for c in range(3)], over)
    softening = stiffness_ratio(law, parameters, memory)  # before the point stores its new state
    answer = respond(law, h, parameters, memory, 0, d)
    kappa = HOURGLASS * law.modulus(parameters) * d * tensor3.dot(over, over)
    q = [[mode_u[c][3 + a] for a in range(4)] for c in range(3)]
    hourglass = 0.5 * kappa * (four(q[0], q[0]) + (four(q[1], q[1]) + four(q[2], q[2])))
    kappa *= softening
    if ti.static(memory and law.plastic):
        softer = softened(law, answer[3], parameters)
        memory.tally[RELEASED] = memory.tally[RELEASED] + (softening - softer) * hourglass
        hourglass *= softer
    share = weight * (1.0 / 64.0)
    scale, kept = share * d, share * kappa
    stress = tensor3.product(answer[0], over)
    force = [
        hex_corner_forces([scale * stress[c][m] for m in range(3)] + [kept * q[c][a] for a in range(4)])
        for c in range(3)
    ]
    return [force, share * (d * answer[1] + hourglass), answer[2], share * hourglass]


@ti.func
def stiffness_ratio(law: ti.template(), parameters, memory: ti.template()):
    """Return `softened` for the stored state, 1 for a law without plastic flow."""
    if ti.static(memory and law.plastic):
        return softened(law, recall(memory, 0), parameters)
    else:
        return 1.0


@ti.func
def softened(law: ti.template(), state, parameters):
    """Return the ratio of the hourglass stiffness to the elastic one: that of the secant moduli, at least SOFTEST."""
    ratio = law.plastic.secant(state, parameters)
    return ti.max(ratio, 0.0 * ratio + SOFTEST)


@ti.func
def mean_gradient(mode_x, mode_u):
    """Return [D, slopes s_m, H] of a hex8 from the modes of its corners and of their displacements."""
    geometry = hex_slopes(mode_x)
    d, slopes = geometry[0], geometry[1]
    inverse = 1.0 / d
    turned = [[slopes[m][j] for m in range(6)] for j in range(3)]
    return [d, slopes, [[inverse * six(mode_u[c], turned[j]) for j in range(3)] for c in range(3)]]


@ti.func
def four(a, b):
    """Return the sum of four products."""
    return (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])


@ti.func
def six(a, b):
    """Return the sum of the first six products."""
    return (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) + (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])


@ti.func
def hex_mean(x, u):
    """Return the mean H of a hex8 from its corners."""
    return mean_gradient([hex_modes(x[c]) for c in range(3)], [hex_modes(u[c]) for c in range(3)])[2]


REDUCED = CellFunctions(
    8, reduced_force, reduced_force, hex_viscosity, hex_mean, tangent="reduced", points=1, share=1.0 / 64.0
)
FUNCTIONS = {
    "hex8-reduced": REDUCED,
    "hex8-reduced-affine": REDUCED._replace(force=affine_reduced_force, stored=STORED),
}
