"""One-point hexahedra: uniform gradient, and a stiffness against the hourglass modes it does not see.

With the modes x_m = (x1, x2, x3, x12, x13, x23, x123) of the reference corners and u_m of the displacements (`cells`),
the volume V = D/64 and the mean gradient H = 1/V int grad u dV of a hex with any corners are

    D = x1.s1 + (x12.(x2 x x23) + x13.(x23 x x3))/3,    H = 1/D sum over m of u_m s_m^t,    s_m = dD/dx_m:
    s1 = x2 x x3 + x12 x x13/3,   s2 = x3 x x1 + x23 x x12/3,   s3 = x1 x x2 + x13 x x23/3,
    s12 = (x2 x x23 + x13 x x1)/3,   s13 = (x23 x x3 + x1 x x12)/3,   s23 = (x3 x x13 + x12 x x2)/3,   s123 = 0

(b_k = V grad N_k = dV/dx_k of Flanagan and Belytschko, Int. J. Numer. Meth. Engng 17, 679, 1981, sorted by modes.) This
is the exact integral, not the gradient at the centre: sums of b_k over the cells of an inner node vanish on distorted
meshes too, so patches carry uniform stress. What H does not see, in each of the four modes a = 12, 13, 23, 123:

    q_a = u_a - H x_a = sum over k of gamma_ak u_k,   W_cell = V W(H) + kappa/2 sum over a of |q_a|^2,
    kappa = HOURGLASS (lam + 2 mu) (b:b) / (8 V),     b:b = sum over k of |b_k|^2

All of it lives in the reference state: q is zero for every linear field, finite rotations too, and turns with the body.
(With Mooney-Rivlin's bulk and M, lam + 2 mu at small strains is bulk + 2 M.)
HOURGLASS is the stiffness of an hourglass mode of unit length over (lam + 2 mu) (b:b)/V, the usual bound on that of the
modes which H sees (kappa gamma gamma^t, gamma.gamma = 8 in a brick). For cubes and Poisson's ratio 0.3, 1/12 gives an
hourglass mode the energy of pure bending. With 0.05 a cantilever of 1, 2, 4 cubes in thickness is 39, 7, 1 % too soft
(full hexes: 56, 16, 5 % too stiff); with cells longer than thick it is too stiff, like full hexes but less. The stable
step is that of full hexes or more up to about 0.1; 1/3 costs 5 %, 1/2 costs 20 %. Smaller values cost the static solve
sweeps (0.02: a third more, 0.01: twice as many).
"""

import taichi as ti

from .cells import hex_corner_forces, hex_modes

HOURGLASS = 0.05


@ti.func
def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


@ti.func
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@ti.func
def plus(a, b):
    return [a[0] + b[0], a[1] + b[1], a[2] + b[2]]


@ti.func
def hex_slopes(mode_x):
    """[D, [s1, s2, s3, s12, s13, s23]] of a hex8 from the modes of its corners, each s a vector [component]."""
    p1, p2, p3, p12, p13, p23 = [[mode_x[c][m] for c in range(3)] for m in range(6)]
    r12, r13, r23 = [[(1.0 / 3.0) * p[c] for c in range(3)] for p in (p12, p13, p23)]
    first, second = cross(p2, r23), cross(r23, p3)
    slopes = [
        plus(cross(p2, p3), cross(p12, r13)),
        plus(cross(p3, p1), cross(p23, r12)),
        plus(cross(p1, p2), cross(p13, r23)),
        plus(first, cross(r13, p1)),
        plus(second, cross(p1, r12)),
        plus(cross(p3, r13), cross(r12, p2)),
    ]
    d = dot(p1, slopes[0]) + (dot(p12, first) + dot(p13, second))
    return [d, slopes]


@ti.func
def mean_gradient(mode_x, mode_u):
    """[D, slopes s_m, H] of a hex8 from the modes of its corners and of their displacements."""
    geometry = hex_slopes(mode_x)
    d, slopes = geometry[0], geometry[1]
    inverse = 1.0 / d
    turned = [[slopes[m][j] for m in range(6)] for j in range(3)]
    return [d, slopes, [[inverse * six(mode_u[c], turned[j]) for j in range(3)] for c in range(3)]]


@ti.func
def reduced_force(x, u, moduli, law: ti.template()):
    """[corner forces dW/du as [component][corner], energy, det F - 1 of the mean gradient, hourglass energy] of a hex8.

    x[c][k], u[c][k] as for `cells.hex_points`; the energy includes the hourglass energy.
    """
    mode_x = [hex_modes(x[c]) for c in range(3)]
    mode_u = [hex_modes(u[c]) for c in range(3)]
    gradient = mean_gradient(mode_x, mode_u)
    d, slopes, h = gradient[0], gradient[1], gradient[2]
    inverse = 1.0 / d
    scaled = [modulus * (1.0 / 64.0) for modulus in moduli]
    answer = law(h, scaled)

    square = dot(slopes[0], slopes[0]) + dot(slopes[1], slopes[1]) + dot(slopes[2], slopes[2])
    square += dot(slopes[3], slopes[3]) + dot(slopes[4], slopes[4]) + dot(slopes[5], slopes[5])
    kappa = HOURGLASS * (scaled[0] + 2.0 * scaled[1]) * square * inverse
    q = [[mode_u[c][3 + a] - dot(h[c], [mode_x[j][3 + a] for j in range(3)]) for a in range(4)] for c in range(3)]
    hourglass = 0.5 * kappa * (four(q[0], q[0]) + (four(q[1], q[1]) + four(q[2], q[2])))
    share = kappa * inverse
    twist = [[mode_x[j][3 + a] for a in range(4)] for j in range(3)]
    stress = [[answer[0][c][j] - share * four(q[c], twist[j]) for j in range(3)] for c in range(3)]
    mode_f = [
        [dot(stress[c], slopes[m]) for m in range(3)]
        + [dot(stress[c], slopes[3 + a]) + kappa * q[c][a] for a in range(3)]
        + [kappa * q[c][3]]
        for c in range(3)
    ]
    return [[hex_corner_forces(mode_f[c]) for c in range(3)], d * answer[1] + hourglass, answer[2], hourglass]


@ti.func
def four(a, b):
    return (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])


@ti.func
def six(a, b):
    """Sum of products of the first six."""
    return (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) + (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])
