"""Cells: from the corners of ONE cell to its internal corner forces, energy and smallest det F - 1.

Hex8, trilinear, 2x2x2 Gauss points at +-1/sqrt 3, VTK corner order. With s_j = +-1 a corner's r_j, the modes
(8 times the trilinear coefficients)

    c1 = sum s1 u,  c2, c3;  c12 = sum s1 s2 u,  c13, c23;  c123 = sum s1 s2 s3 u

give G = 8 du/dr, for example G_1 = c1 + c12 r2 + c13 r3 + c123 r2 r3; A = 8 dX/dr likewise, D = det A, and

    H = G A^-1 = G (cof A)^t / D,    dW_cell/dG = 1/512 P cof A,

and the corner forces follow by the transposed sums. Tet4: one point, differences to corner 0, weight 1/6.
(Hughes, The Finite Element Method, ch. 3; Flanagan and Belytschko 1981 for the modes.)

Written in plain arithmetic on nested lists [component][corner]: an entry may be a scalar (one cell) or a `ti.Vector`
of lanes (that many cells at once, one SIMD value of the machine). Nothing here knows of packs or arrays.
Unary minus and `ti.bit_cast` do not compile for vectors in Taichi 1.7.4: write 0.0 - a, use `tensor3.to_bits`.
Displacement differences to corners of the same cell come first, never sums of displacements (METHOD 6).
"""

import taichi as ti

from . import tensor3

GAUSS = 1.0 / 3.0**0.5


@ti.func
def hex_modes(u):
    """[c1, c2, c3, c12, c13, c23, c123] of one component from its 8 corner values, without sums of corner values."""
    a0, a1, a2, a3 = u[1] - u[0], u[2] - u[3], u[5] - u[4], u[6] - u[7]  # edges along r1, at (r2, r3) = --, +-, -+, ++
    b0, b1 = (u[3] - u[0]) + (u[2] - u[1]), (u[7] - u[4]) + (u[6] - u[5])  # along r2, at r3 = -, +
    c = ((u[4] - u[0]) + (u[5] - u[1])) + ((u[6] - u[2]) + (u[7] - u[3]))
    p0, p1, q0, q1 = a1 + a0, a3 + a2, a1 - a0, a3 - a2
    return [p1 + p0, b1 + b0, c, q1 + q0, p1 - p0, b1 - b0, q1 - q0]


@ti.func
def hex_corner_forces(m):
    """8 corner forces of one component from dW/d(mode), the transpose of `hex_modes`."""
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
def tet_derivatives(corner):
    """3 derivatives of one component from its 4 corner values."""
    return [corner[1] - corner[0], corner[2] - corner[0], corner[3] - corner[0]]


@ti.func
def tet_corner_forces(q):
    """4 corner forces of one component from dW/dG [direction j]."""
    return [0.0 - q[0] - q[1] - q[2], q[0], q[1], q[2]]


@ti.func
def geometry(a):
    """[cof A, cof A / det A, det A] of a[c][j] = dX_c/dr_j."""
    m = tensor3.cofactor(a)
    d = tensor3.determinant(a, m)
    return [m, tensor3.scaled(1.0 / d, m), d]


@ti.func
def point_force(g, shape, moduli, law: ti.template()):
    """One Gauss point: [dW/dG as [component][direction], energy, det F - 1].

    g[c][j] = du_c/dr_j, shape: its `geometry`; moduli times the point's weight (1/512 with A = 8 dX/dr, 1/6): stress
    and energy are linear in them.
    """
    answer = law(tensor3.product_transposed(g, shape[1]), moduli)
    return [tensor3.product(answer[0], shape[0]), shape[2] * answer[1], answer[2]]


@ti.func
def hex_gradients(c, r2, r3, r23):
    """G of one component at the two points (-+1/sqrt 3, r2, r3): [at -, at +], each [direction]."""
    first = c[0] + c[3] * r2 + (c[4] * r3 + c[6] * r23)
    second, slope2 = c[1] + c[5] * r3, (c[3] + c[6] * r3) * GAUSS
    third, slope3 = c[2] + c[5] * r2, (c[4] + c[6] * r2) * GAUSS
    return [[first, second - slope2, third - slope3], [first, second + slope2, third + slope3]]


@ti.func
def affine_gradients(c, r2, r3, r23):
    """The same for a parallelepiped: A is constant, and the compiler takes what follows from it out of the loop."""
    return [[c[0], c[1], c[2]], [c[0], c[1], c[2]]]


@ti.func
def hex_mode_forces(mode_x, mode_u, moduli, law: ti.template(), jacobian_of: ti.template()):
    """[dW/d(mode of u) as [component][mode], energy, smallest det F - 1] from the modes of x and u.

    Two points per turn of the loop: unrolled, the code outgrows the instruction cache and the compile time doubles.
    jacobian_of: A of one component at two points from its modes.
    """
    zero = mode_x[0][0] * 0.0
    mode_f = [[zero for _ in range(7)] for _ in range(3)]
    energy = zero
    change = zero + 1e300
    scaled = [modulus * (1.0 / 512.0) for modulus in moduli]
    for line in range(4):
        r2 = GAUSS * (2.0 * (line & 1) - 1.0)
        r3 = GAUSS * (2.0 * (line >> 1) - 1.0)
        r23 = r2 * r3
        g = [hex_gradients(mode_u[c], r2, r3, r23) for c in range(3)]
        a = [jacobian_of(mode_x[c], r2, r3, r23) for c in range(3)]
        lower, upper = geometry([a[c][0] for c in range(3)]), geometry([a[c][1] for c in range(3)])
        low = point_force([g[c][0] for c in range(3)], lower, scaled, law)
        high = point_force([g[c][1] for c in range(3)], upper, scaled, law)
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
def hex_points(x, u, moduli, law: ti.template(), jacobian_of: ti.template()):
    """[corner forces dW/du as [component][corner], energy, smallest det F - 1] of a hex8 from x[c][k], u[c][k]."""
    points = hex_mode_forces(
        [hex_modes(x[c]) for c in range(3)], [hex_modes(u[c]) for c in range(3)], moduli, law, jacobian_of
    )
    return [[hex_corner_forces(points[0][c]) for c in range(3)], points[1], points[2]]


def with_jacobian(force, jacobian_of):
    """The force function of an element from one that asks how to get A (`hex_gradients`, `affine_gradients`)."""

    @ti.func
    def force_of(x, u, moduli, law: ti.template()):
        return force(x, u, moduli, law, jacobian_of)

    return force_of


hex_force = with_jacobian(hex_points, hex_gradients)
affine_hex_force = with_jacobian(hex_points, affine_gradients)


@ti.func
def tet_force(x, u, moduli, law: ti.template()):
    """[corner forces dW/du as [component][corner], energy, det F - 1] of a tet4 from x[c][k], u[c][k]."""
    a = [tet_derivatives(x[c]) for c in range(3)]
    g = [tet_derivatives(u[c]) for c in range(3)]
    answer = point_force(g, geometry(a), [modulus * (1.0 / 6.0) for modulus in moduli], law)
    return [[tet_corner_forces(answer[0][c]) for c in range(3)], answer[1], answer[2]]
