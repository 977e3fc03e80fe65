"""Modes of hexahedra: sums and differences of the values at the 8 corners, and the gradients that they give.

Trilinear, VTK corner order. With s_j = +-1 a corner's r_j, the modes (8 times the trilinear coefficients)

    c1 = sum s1 u,  c2, c3;  c12 = sum s1 s2 u,  c13, c23;  c123 = sum s1 s2 s3 u

give G = 8 du/dr, for example G_1 = c1 + c12 r2 + c13 r3 + c123 r2 r3.
(Hughes, The Finite Element Method, ch. 3; Flanagan and Belytschko 1981 for the modes.)
"""

from ..engine import ti

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
def hex_plane(c, r1, r3):
    """Return of one component, at a level r3, what `hex_gradients` needs: G_1 and its slope along r2, G_2 at -+r1."""
    first, slope, second = c[0] + c[4] * r3, c[3] + c[6] * r3, c[1] + c[5] * r3
    twist = slope * r1
    return [first, slope, second - twist, second + twist]


@ti.func
def hex_gradients(plane, c, r1, r2):
    """Return G of one component at (-r1, r2) and (r1, r2) of the level of `plane`, each [direction]."""
    first, third, slope = plane[0] + plane[1] * r2, c[2] + c[5] * r2, (c[4] + c[6] * r2) * r1
    return [[first, plane[2], third - slope], [first, plane[3], third + slope]]


@ti.func
def gradients_at(c, r):
    """Return G of one component at a point r from its modes."""
    return [
        c[0] + c[3] * r[1] + (c[4] + c[6] * r[1]) * r[2],
        c[1] + c[3] * r[0] + (c[5] + c[6] * r[0]) * r[2],
        c[2] + c[4] * r[0] + (c[5] + c[6] * r[0]) * r[1],
    ]
