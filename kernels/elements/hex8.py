"""Hexahedra: corner forces, energy and smallest det F - 1 of one cell from its corners.

Trilinear, 2x2x2 Gauss points at +-1/sqrt 3, VTK corner order. With s_j = +-1 a corner's r_j, the modes
(8 times the trilinear coefficients)

    c1 = sum s1 u,  c2, c3;  c12 = sum s1 s2 u,  c13, c23;  c123 = sum s1 s2 s3 u

give G = 8 du/dr, for example G_1 = c1 + c12 r2 + c13 r3 + c123 r2 r3; A = 8 dX/dr likewise, D = det A, and

    H = G A^-1 = G (cof A)^t / D,    dW_cell/dG = 1/512 P cof A,

and the corner forces follow by the transposed sums (`points`).
(Hughes, The Finite Element Method, ch. 3; Flanagan and Belytschko 1981 for the modes.)

The volume V = D/64 of a hex with any corners is a cubic of the modes x1 .. x123 of its corners, s_m = dD/dx_m:

    D = x1.s1 + (x12.(x2 x x23) + x13.(x23 x x3))/3
    s1 = x2 x x3 + x12 x x13/3,   s2 = x3 x x1 + x23 x x12/3,   s3 = x1 x x2 + x13 x x23/3,
    s12 = (x2 x x23 + x13 x x1)/3,   s13 = (x23 x x3 + x1 x x12)/3,   s23 = (x3 x x13 + x12 x x2)/3,   s123 = 0
"""

import taichi as ti

from ..language import tensor3
from .bulk_viscosity import pressure_rate
from .points import cross, dot, geometry, plus, point_force, with_jacobian
from .record import CellFunctions

GAUSS = 1.0 / 3.0**0.5


@ti.func
def hex_modes(u):
    """Return [c1, c2, c3, c12, c13, c23, c123] of one component from differences of its 8 corner values."""
    a0, a1, a2, a3 = u[1] - u[0], u[2] - u[3], u[5] - u[4], u[6] - u[7]  # edges along r1, at (r2, r3) = --, +-, -+, ++
    b0, b1 = (u[3] - u[0]) + (u[2] - u[1]), (u[7] - u[4]) + (u[6] - u[5])  # along r2, at r3 = -, +
    c = ((u[4] - u[0]) + (u[5] - u[1])) + ((u[6] - u[2]) + (u[7] - u[3]))
    p0, p1, q0, q1 = a1 + a0, a3 + a2, a1 - a0, a3 - a2
    return [p1 + p0, b1 + b0, c, q1 + q0, p1 - p0, b1 - b0, q1 - q0]


@ti.func
def hex_corner_forces(m):
    """Return 8 corner forces of one component from dW/d(mode), by the transpose of `hex_modes`."""
    p0, p1, q0, q1 = m[0] - m[4], m[0] + m[4], m[3] - m[6], m[3] + m[6]
    a0, a1, a2, a3 = p0 - q0, p0 + q0, p1 - q1, p1 + q1
    b0, b1 = m[1] - m[5], m[1] + m[5]
    low, high = b0 + m[2], b1 + m[2]  # r2 and r3 forces where their signs agree
    across, down = b0 - m[2], b1 - m[2]  # and where they differ
    return [
        0.0 - a0 - low,
        a0 - low,
        a1 + across,
        across - a1,
        0.0 - a2 - down,
        a2 - down,
        a3 + high,
        high - a3,
    ]


@ti.func
def hex_gradients(c, r2, r3, r23):
    """Return G of one component at the two points (-+1/sqrt 3, r2, r3): [at -, at +], each [direction]."""
    first = c[0] + c[3] * r2 + (c[4] * r3 + c[6] * r23)
    second, slope2 = c[1] + c[5] * r3, (c[3] + c[6] * r3) * GAUSS
    third, slope3 = c[2] + c[5] * r2, (c[4] + c[6] * r2) * GAUSS
    return [[first, second - slope2, third - slope3], [first, second + slope2, third + slope3]]


@ti.func
def affine_gradients(c, r2, r3, r23):
    """Return A of one component of a parallelepiped at two points; it is constant, and the compiler makes use of it."""
    return [[c[0], c[1], c[2]], [c[0], c[1], c[2]]]


@ti.func
def hex_mode_forces(mode_x, mode_u, parameters, law: ti.template(), memory: ti.template(), jacobian_of: ti.template()):
    """Return [dW/d(mode of u) as [component][mode], energy, smallest det F - 1] from the modes of x and u; times 512.

    The loop takes two points at a time: unrolled, the code outgrows the instruction cache and the compile time doubles.
    jacobian_of: function of A of one component at two points, from its modes.
    """
    zero = mode_x[0][0] * 0.0
    mode_f = [[zero for _ in range(7)] for _ in range(3)]
    energy = zero
    change = zero + 1e300
    for line in range(4):
        r2 = GAUSS * (2.0 * (line & 1) - 1.0)
        r3 = GAUSS * (2.0 * (line >> 1) - 1.0)
        r23 = r2 * r3
        g = [hex_gradients(mode_u[c], r2, r3, r23) for c in range(3)]
        a = [jacobian_of(mode_x[c], r2, r3, r23) for c in range(3)]
        lower, upper = geometry([a[c][0] for c in range(3)]), geometry([a[c][1] for c in range(3)])
        side, first_point = line & 1, 4 * (line >> 1)  # points in the order of the corners they stand next to
        low = point_force([g[c][0] for c in range(3)], lower, parameters, law, memory, first_point + 3 * side)
        high = point_force([g[c][1] for c in range(3)], upper, parameters, law, memory, first_point + 1 + side)
        energy += low[1] + high[1]
        change = ti.min(change, ti.min(low[2], high[2]))
        for c in ti.static(range(3)):
            first = high[0][c][0] + low[0][c][0]
            second, slope2 = high[0][c][1] + low[0][c][1], (high[0][c][1] - low[0][c][1]) * GAUSS
            third, slope3 = high[0][c][2] + low[0][c][2], (high[0][c][2] - low[0][c][2]) * GAUSS
            twist = first * r2 + slope2
            mode_f[c][0] += first
            mode_f[c][1] += second
            mode_f[c][2] += third
            mode_f[c][3] += twist
            mode_f[c][4] += first * r3 + slope3
            mode_f[c][5] += second * r3 + third * r2
            mode_f[c][6] += twist * r3 + slope3 * r2
    return [mode_f, energy, change]


@ti.func
def hex_points(x, u, weight, parameters, law: ti.template(), memory: ti.template(), jacobian_of: ti.template()):
    """Return [corner forces dW/du as [component][corner], energy, smallest det F - 1] of a hex8.

    x[c][k], u[c][k]: reference position and displacement of its corners; jacobian_of: see `hex_mode_forces`.
    """
    points = hex_mode_forces(
        [hex_modes(x[c]) for c in range(3)], [hex_modes(u[c]) for c in range(3)], parameters, law, memory, jacobian_of
    )
    share = weight * (1.0 / 512.0)
    force = [hex_corner_forces([share * points[0][c][m] for m in range(7)]) for c in range(3)]
    return [force, share * points[1], points[2]]


hex_force = with_jacobian(hex_points, hex_gradients)
affine_hex_force = with_jacobian(hex_points, affine_gradients)


@ti.func
def hex_slopes(mode_x):
    """Return [D, [s1, s2, s3, s12, s13, s23]] of a hex8 from the modes of its corners, each s a vector [component]."""
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
def hex_viscosity(x, u, v, speed, square):
    """Return [corner forces [component][corner], -q, V', rate, V at rest, t] of a hex8, q per reference density.

    t: the rate with the quadratic part twice; -q and V' are scaled such that their product is the power. speed: c1 c,
    square: c2^2.
    """
    mode_x = [hex_modes(x[c]) for c in range(3)]
    mode_u = [hex_modes(u[c]) for c in range(3)]
    mode_v = [hex_modes(v[c]) for c in range(3)]
    reference = hex_slopes(mode_x)[0]
    now = hex_slopes([[mode_x[c][m] + mode_u[c][m] for m in range(7)] for c in range(3)])
    slopes = now[1]
    change = dot(slopes[0], [mode_v[c][0] for c in range(3)])
    square_sum = dot(slopes[0], slopes[0])
    largest = square_sum
    for m in ti.static(range(1, 6)):
        change += dot(slopes[m], [mode_v[c][m] for c in range(3)])
        length = dot(slopes[m], slopes[m])
        square_sum += length
        if ti.static(m < 3):
            largest = ti.max(largest, length)
    answer = pressure_rate(change, now[0], reference, 4.0 * ti.sqrt(largest), speed, square)
    pressure = answer[0] * answer[1] * (1.0 / 64.0)
    zero = pressure * 0.0
    mode_f = [[pressure * slopes[m][c] for m in range(6)] + [zero] for c in range(3)]
    rates = [64.0 * answer[i] * square_sum for i in range(2, 4)]
    force = [hex_corner_forces(mode_f[c]) for c in range(3)]
    return [force, pressure, change, rates[0], (1.0 / 64.0) * reference, rates[1]]


@ti.func
def hex_centre(x, u):
    """Return H at the centre of a hex8 from its corners x[c][k], u[c][k]."""
    mode_x, mode_u = [hex_modes(x[c]) for c in range(3)], [hex_modes(u[c]) for c in range(3)]
    shape = geometry([[mode_x[c][j] for j in range(3)] for c in range(3)])
    return tensor3.product_transposed([[mode_u[c][j] for j in range(3)] for c in range(3)], shape[1])


FUNCTIONS = {
    "hex8": CellFunctions(8, hex_force, hex_force, hex_viscosity, hex_centre),
    "hex8-affine": CellFunctions(8, affine_hex_force, hex_force, hex_viscosity, hex_centre),
}
