"""Integrals over the part that two faces have in common, seen along the normal of the first one (METHOD 7).

The corners of both faces are projected into the plane of the slave face; the master face is clipped by the slave face
(Sutherland and Hodgman 1974), the polygon divided into triangles around its middle, and each triangle integrated with
3 points (exact for polynomials of degree 2). Triangles from a corner would leave a polygon of three corners with 3
points, on which the 4 shape functions of a quadrilateral are not independent. The results are:

    integral of N_s N_s^t,  integral of N_s N_m^t,  area,  smallest distance |gap| and gap N_m . z_m - N_s . z_s

The distance is also taken at the corners of the polygon, where inclined faces come near each other first; the gaps of
the corners have a result of their own.

A face has 4 corners; a triangle has its last corner twice, and its shape functions are those of 3 corners. The local
coordinates of a point in a quadrilateral come from Newton's method.
"""

import functools

from ..engine import ti
from ..lanes import GRAIN
from ..language.arguments import ARRAY, INDEX
from ..language.entries import three
from ..pair_places import (
    COMMON_AREA,
    CORNER_GAP,
    DISTANCE,
    INTEGRALS,
    MASTER_PRODUCTS,
    POINT_GAP,
    SLAVE_PRODUCTS,
)

CORNERS = 10  # of a clipped polygon, at most: 8, and room for rounding errors
SLIVER = 1e-12  # area in common over the area of the slave face below which a pair of faces has none
NEWTON = 12  # iterations of the inverse map, at most
DONE = 1e-14  # change of the local coordinates at which they end
FAR = 1e300


@ti.func
def bilinear(a, b):
    """Return the shape functions [4] of a quadrilateral at (a, b) in [-1, 1]^2."""
    return 0.25 * ti.Vector(
        [(1.0 - a) * (1.0 - b), (1.0 + a) * (1.0 - b), (1.0 + a) * (1.0 + b), (1.0 - a) * (1.0 + b)]
    )


@ti.func
def shape_values(x, y, px, py, triangle):
    """Return the shape functions [4] of a face with corners (x, y) [4] in the plane at a point (px, py) of it."""
    result = ti.Vector([0.0, 0.0, 0.0, 0.0])
    if triangle == 1:
        area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])
        second = ((px - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (py - y[0])) / area
        third = ((x[1] - x[0]) * (py - y[0]) - (px - x[0]) * (y[1] - y[0])) / area
        result = ti.Vector([1.0 - second - third, second, third, 0.0])
    else:
        a, b = 0.0, 0.0
        for _ in range(NEWTON):
            n = bilinear(a, b)
            rest_x, rest_y = px - n.dot(x), py - n.dot(y)
            along_a = 0.25 * ti.Vector([b - 1.0, 1.0 - b, 1.0 + b, 0.0 - 1.0 - b])
            along_b = 0.25 * ti.Vector([a - 1.0, 0.0 - 1.0 - a, 1.0 + a, 1.0 - a])
            xa, xb, ya, yb = along_a.dot(x), along_b.dot(x), along_a.dot(y), along_b.dot(y)
            determinant = xa * yb - xb * ya
            step_a = (rest_x * yb - xb * rest_y) / determinant
            step_b = (xa * rest_y - rest_x * ya) / determinant
            a += step_a
            b += step_b
            if not ti.abs(step_a) + ti.abs(step_b) > DONE:
                break
        result = bilinear(a, b)
    return result


@ti.func
def clipped(sx, sy, mx, my, slave_corners, master_corners):
    """Return the corners [CORNERS] in x and y of the common polygon, and their number; both faces counter-clockwise."""
    px, py = ti.Vector([0.0 for _ in range(CORNERS)]), ti.Vector([0.0 for _ in range(CORNERS)])
    count = master_corners
    for i in range(master_corners):
        px[i], py[i] = mx[i], my[i]
    for edge in range(slave_corners):
        following = ti.select(edge + 1 == slave_corners, 0, edge + 1)
        ex, ey = sx[following] - sx[edge], sy[following] - sy[edge]
        qx, qy = px, py
        kept = 0
        for i in range(count):
            j = ti.select(i + 1 == count, 0, i + 1)
            here = ex * (py[i] - sy[edge]) - ey * (px[i] - sx[edge])
            there = ex * (py[j] - sy[edge]) - ey * (px[j] - sx[edge])
            if here >= 0.0 and kept < CORNERS:
                qx[kept], qy[kept] = px[i], py[i]
                kept += 1
            if (here >= 0.0) != (there >= 0.0) and kept < CORNERS:
                part = here / (here - there)
                qx[kept], qy[kept] = px[i] + part * (px[j] - px[i]), py[i] + part * (py[j] - py[i])
                kept += 1
        px, py, count = qx, qy, kept
    return px, py, count


@ti.func
def integrate(slaves: ti.template(), masters: ti.template(), results: ti.template(), e, f, place):
    """Set the integrals of slave face e and master face f, whose corners are slaves [.., 4, 3], masters [.., 4, 3]."""
    for i in range(INTEGRALS):
        results[place + i] = 0.0
    results[place + DISTANCE], results[place + POINT_GAP], results[place + CORNER_GAP] = FAR, FAR, FAR
    s = [three(slaves, 12 * e + 3 * i) for i in range(4)]
    m = [three(masters, 12 * f + 3 * i) for i in range(4)]
    slave_triangle = ti.select((s[3] - s[2]).norm_sqr() == 0.0, 1, 0)
    master_triangle = ti.select((m[3] - m[2]).norm_sqr() == 0.0, 1, 0)
    centre = 0.25 * (s[0] + s[1] + s[2] + s[3])
    across = (s[2] - s[0]).cross(s[3] - s[1])
    normal = across / across.norm()
    first = s[1] - s[0]
    first = first - normal.dot(first) * normal
    first = first / first.norm()
    second = normal.cross(first)
    sx, sy, sz = ti.Vector([0.0] * 4), ti.Vector([0.0] * 4), ti.Vector([0.0] * 4)
    mx, my, mz = ti.Vector([0.0] * 4), ti.Vector([0.0] * 4), ti.Vector([0.0] * 4)
    for i in ti.static(range(4)):
        sx[i], sy[i], sz[i] = first.dot(s[i] - centre), second.dot(s[i] - centre), normal.dot(s[i] - centre)
        mx[i], my[i], mz[i] = first.dot(m[i] - centre), second.dot(m[i] - centre), normal.dot(m[i] - centre)
    # seen from outside the slave the corners of the master run clockwise: in reverse they do not
    corners = 4 - master_triangle
    rx, ry = ti.Vector([0.0] * 4), ti.Vector([0.0] * 4)
    for i in range(corners):
        rx[i], ry[i] = mx[corners - 1 - i], my[corners - 1 - i]
    px, py, count = clipped(sx, sy, rx, ry, 4 - slave_triangle, corners)
    area, middle_x, middle_y = 0.0, 0.0, 0.0
    for i in range(count):
        j = ti.select(i + 1 == count, 0, i + 1)
        area += 0.5 * ((px[i] - px[0]) * (py[j] - py[0]) - (px[j] - px[0]) * (py[i] - py[0]))
        middle_x += px[i] / count
        middle_y += py[i] / count
    if area > SLIVER * 0.5 * across.norm():
        distance, gap, corner_gap = FAR, FAR, FAR
        for i in range(count):
            j = ti.select(i + 1 == count, 0, i + 1)
            x1, y1, x2, y2 = px[i] - middle_x, py[i] - middle_y, px[j] - middle_x, py[j] - middle_y
            at_slave = shape_values(sx, sy, px[i], py[i], slave_triangle)
            at_master = shape_values(mx, my, px[i], py[i], master_triangle)
            at_corner = at_master.dot(mz) - at_slave.dot(sz)
            distance, corner_gap = ti.min(distance, ti.abs(at_corner)), ti.min(corner_gap, at_corner)
            share = (x1 * y2 - x2 * y1) / 6.0
            for q in range(3):
                first_part = ti.select(q == 1, 4.0, 1.0) / 6.0
                second_part = ti.select(q == 2, 4.0, 1.0) / 6.0
                x = middle_x + first_part * x1 + second_part * x2
                y = middle_y + first_part * y1 + second_part * y2
                at_slave = shape_values(sx, sy, x, y, slave_triangle)
                at_master = shape_values(mx, my, x, y, master_triangle)
                for a, b in ti.static(ti.ndrange(4, 4)):
                    own, other = place + SLAVE_PRODUCTS + 4 * a + b, place + MASTER_PRODUCTS + 4 * a + b
                    results[own] = results[own] + share * at_slave[a] * at_slave[b]
                    results[other] = results[other] + share * at_slave[a] * at_master[b]
                between = at_master.dot(mz) - at_slave.dot(sz)
                distance, gap = ti.min(distance, ti.abs(between)), ti.min(gap, between)
        results[place + COMMON_AREA] = area
        results[place + DISTANCE] = distance
        results[place + POINT_GAP] = gap
        results[place + CORNER_GAP] = corner_gap


@functools.cache
def make_clipping():
    """Return the kernel clip(count, slaves, masters, pairs, results), memoised.

    It integrates pairs of faces (e, f) = pairs [count, 2] in parallel; results [count, INTEGRALS]: pair_places.py.
    """

    @ti.kernel
    def clip(count: ti.i32, slaves: ARRAY, masters: ARRAY, pairs: INDEX, results: ARRAY):
        for s in range(((count + 15) // 16) * GRAIN):
            if s % GRAIN == 0:
                first = 16 * (s // GRAIN)
                for p in range(first, ti.min(first + 16, count)):
                    integrate(slaves, masters, results, pairs[2 * p], pairs[2 * p + 1], p * INTEGRALS)

    return clip
