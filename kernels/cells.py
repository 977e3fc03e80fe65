"""Cells: from the corners of ONE cell to its internal corner forces, energy and smallest det F - 1.

Hex8, trilinear, 2x2x2 Gauss points, unit coordinates r in [0,1]^3, VTK corner order. The derivative of a component along
r_j is constant along r_j and takes only 4 values at the 8 Gauss points: differences over the 4 edges along r_j,
interpolated in the two other directions. With G = du/dr, A = dX/dr, D = det A and weight 1/8 per point,

    H = G A^-1 = G (cof A)^t / D,    dW_cell/dG = 1/8 P cof A,

and the corner forces follow by the transposed interpolation and differences (the interpolation is symmetric).
Tet4: one point, edge differences to corner 0, weight 1/6 (Hughes, The Finite Element Method, ch. 3).

Written in plain arithmetic on nested lists [component][corner]: an entry may be a scalar (one cell) or a `ti.Vector` of
lanes (that many cells at once, which Taichi hands to the machine as a SIMD value). Nothing here knows of packs or arrays.
Displacement differences to corners of the same cell, never total displacements (METHOD 6).
"""

import taichi as ti

from . import tensor3

CORNERS = {"hex8": 8, "tet4": 4}
POINTS = {"hex8": 8, "tet4": 1}
HEX_SIGNS = ((-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1))
LERP = 0.5 - 0.5 / 3.0**0.5  # Gauss points of the unit interval: LERP and 1 - LERP

# edges along r_j as (from, to) corners; edge number = low bit of the first other coordinate + 2 * the second
HEX_EDGES = (
    ((0, 1), (3, 2), (4, 5), (7, 6)),
    ((0, 3), (1, 2), (4, 7), (5, 6)),
    ((0, 4), (1, 5), (3, 7), (2, 6)),
)
# points (bits r0 + 2 r1 + 4 r2) on the lines along r_j
HEX_LINE_POINTS = (
    ((0, 1), (2, 3), (4, 5), (6, 7)),
    ((0, 2), (1, 3), (4, 6), (5, 7)),
    ((0, 4), (1, 5), (2, 6), (3, 7)),
)
# lines [direction j] of each point
HEX_LINES = tuple((p >> 1, (p & 1) + 2 * (p >> 2), p & 3) for p in range(8))


@ti.func
def interpolate(a):
    """Bilinear interpolation of 4 values to the 4 Gauss lines; its matrix is symmetric."""
    s0 = LERP * (a[1] - a[0])
    s1 = LERP * (a[3] - a[2])
    b0, b1, b2, b3 = a[0] + s0, a[1] - s0, a[2] + s1, a[3] - s1
    t0 = LERP * (b2 - b0)
    t1 = LERP * (b3 - b1)
    return [b0 + t0, b1 + t1, b2 - t0, b3 - t1]


@ti.func
def hex_derivatives(corner):
    """12 derivatives of one component from its 8 corner values: [direction j][line]."""
    return [interpolate([corner[e[1]] - corner[e[0]] for e in HEX_EDGES[j]]) for j in range(3)]


@ti.func
def hex_corner_forces(line):
    """8 corner forces of one component from the sums over each line's points of dW/dG: [direction j][line]."""
    a = interpolate(line[0])
    b = interpolate(line[1])
    c = interpolate(line[2])
    return [
        0.0 - a[0] - b[0] - c[0],
        a[0] - b[1] - c[1],
        a[1] + b[1] - c[3],
        b[0] - a[1] - c[2],
        c[0] - a[2] - b[2],
        a[2] + c[1] - b[3],
        a[3] + b[3] + c[3],
        b[2] + c[2] - a[3],
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
def point_force(g, a, lam, mu, law: ti.template()):
    """One Gauss point: [dW/dG as [component][direction], energy, det F - 1].

    g[c][j] = du_c/dr_j, a[c][j] = dX_c/dr_j; lam, mu times the point's weight in unit coordinates (1/8, 1/6): stress and
    energy are linear in them. A variant with stored geometry replaces the three lines that use a.
    """
    m = tensor3.cofactor(a)
    d = tensor3.determinant(a, m)
    h = tensor3.scaled(1.0 / d, tensor3.product_transposed(g, m))
    answer = law(h, lam, mu)
    return [tensor3.product(answer[0], m), d * answer[1], answer[2]]


@ti.func
def hex_force(x, u, lam, mu, law: ti.template()):
    """[corner forces dW/du as [component][corner], energy, smallest det F - 1] of a hex8 from x[c][k], u[c][k]."""
    dx = [hex_derivatives(x[c]) for c in range(3)]
    du = [hex_derivatives(u[c]) for c in range(3)]
    point = [
        point_force(
            [[du[c][j][HEX_LINES[p][j]] for j in range(3)] for c in range(3)],
            [[dx[c][j][HEX_LINES[p][j]] for j in range(3)] for c in range(3)],
            0.125 * lam,
            0.125 * mu,
            law,
        )
        for p in range(8)
    ]
    energy = point[0][1]
    change = point[0][2]
    for p in ti.static(range(1, 8)):
        energy += point[p][1]
        change = ti.min(change, point[p][2])
    sums = [
        [[point[p[0]][0][c][j] + point[p[1]][0][c][j] for p in HEX_LINE_POINTS[j]] for j in range(3)] for c in range(3)
    ]
    return [[hex_corner_forces(sums[c]) for c in range(3)], energy, change]


@ti.func
def tet_force(x, u, lam, mu, law: ti.template()):
    """[corner forces dW/du as [component][corner], energy, det F - 1] of a tet4 from x[c][k], u[c][k]."""
    a = [tet_derivatives(x[c]) for c in range(3)]
    g = [tet_derivatives(u[c]) for c in range(3)]
    answer = point_force(g, a, lam * (1.0 / 6.0), mu * (1.0 / 6.0), law)
    return [[tet_corner_forces(answer[0][c]) for c in range(3)], answer[1], answer[2]]


FORCES = {"hex8": hex_force, "tet4": tet_force}
