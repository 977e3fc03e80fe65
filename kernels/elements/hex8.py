"""Hexahedra: corner forces, energy and smallest det F - 1 of one cell from its corners.

Trilinear, 2x2x2 Gauss points at +-1/sqrt 3, VTK corner order. With the modes of `hex8_modes` G = 8 du/dr,
A = 8 dX/dr likewise, D = det A, and

    H = G A^-1 = G (cof A)^t / D,    dW_cell/dG = 1/512 P cof A,

which boxes and parallelepipeds simplify (`hex8_shapes`); the corner forces follow by the transposed sums.

The volume V = D/64 of a hex with any corners is a cubic of the modes x1 .. x123 of its corners, s_m = dD/dx_m:

    D = x1.s1 + (x12.(x2 x x23) + x13.(x23 x x3))/3
    s1 = x2 x x3 + x12 x x13/3,   s2 = x3 x x1 + x23 x x12/3,   s3 = x1 x x2 + x13 x x23/3,
    s12 = (x2 x x23 + x13 x x1)/3,   s13 = (x23 x x3 + x1 x x12)/3,   s23 = (x3 x x13 + x12 x x2)/3,   s123 = 0
"""

from ..engine import ti
from ..language import tensor3
from .bulk_viscosity import pressure_rate
from .hex8_modes import GAUSS, gradients_at, hex_corner_forces, hex_gradients, hex_modes, hex_plane
from .hex8_points import mode_forces_by_points, point_answer, signs_of
from .hex8_shapes import ANY, BOX, PARALLELEPIPED
from .points import cross, dot, geometry, of_shape, plus
from .record import CellFunctions


@ti.func
def hex_mode_forces(x, mode_u, share, parameters, law: ti.template(), memory: ti.template(), shape: ti.template()):
    """Return [dW/d(mode of u) as [component][mode], energy, smallest det F - 1] from the corners x and the modes of u.

    Forces and energy are multiplied by 512 share. shape: of the cell (hex8_shapes.py).
    The loop takes two points at a time: unrolled, the code outgrows the instruction cache and the compile time doubles.
    """
    data = shape.of_cell(x)  # data[1] is D of a cell of an even shape
    modes, half = shape.modes(data, mode_u), shape.coordinates(data)
    zero = x[0][0] * 0.0
    moments = [[zero for _ in range(7)] for _ in range(3)]
    energy = zero
    change = zero + 1e300
    r1 = half[0]
    rise = [[zero for _ in range(2)] for _ in range(3)]
    for level in range(2):
        r3 = half[2] * (2.0 * level - 1.0)
        plane = [hex_plane(modes[c], r1, r3) for c in range(3)]
        layer = shape.level(data, r1, r3)
        sums = [[zero for _ in range(3)] for _ in range(3)]
        for side in range(2):
            r2 = half[1] * (2.0 * side - 1.0)
            g = [hex_gradients(plane[c], modes[c], r1, r2) for c in range(3)]
            maps = shape.maps(data, layer, r1, r2)
            point = 4 * level  # points in the order of the corners they stand next to
            low = point_answer([g[c][0] for c in range(3)], maps[0], parameters, law, memory, point + 3 * side, shape)
            high = point_answer([g[c][1] for c in range(3)], maps[1], parameters, law, memory, point + 1 + side, shape)
            energy += low[1] + high[1]
            change = ti.min(change, ti.min(low[2], high[2]))
            for c in ti.static(range(3)):
                first = high[0][c][0] + low[0][c][0]
                third, slope = high[0][c][2] + low[0][c][2], high[0][c][2] - low[0][c][2]
                sums[c][0] += first
                sums[c][1] += high[0][c][1] + low[0][c][1]
                sums[c][2] += first * r2 + (high[0][c][1] - low[0][c][1]) * r1
                moments[c][2] += third
                moments[c][5] += third * r2
                rise[c][0] += slope
                rise[c][1] += slope * r2
        for c in ti.static(range(3)):
            moments[c][0] += sums[c][0]
            moments[c][1] += sums[c][1]
            moments[c][3] += sums[c][2]
            moments[c][4] += sums[c][0] * r3
            moments[c][5] += sums[c][1] * r3
            moments[c][6] += sums[c][2] * r3
    for c in ti.static(range(3)):
        moments[c][4] += rise[c][0] * r1
        moments[c][6] += rise[c][1] * r1
    if ti.static(shape.even):
        energy *= data[1]
    return [shape.forces(data, share, moments), share * energy, change]


@ti.func
def hex_points(x, u, weight, parameters, law: ti.template(), memory: ti.template(), shape: ti.template()):
    """Return [corner forces dW/du as [component][corner], energy, smallest det F - 1] of a hex8.

    x[c][k], u[c][k]: reference position and displacement of its corners; shape: see `hex_mode_forces`.
    """
    mode_u = [hex_modes(u[c]) for c in range(3)]
    points = hex_mode_forces(x, mode_u, weight * (1.0 / 512.0), parameters, law, memory, shape)
    return [[hex_corner_forces(points[0][c]) for c in range(3)], points[1], points[2]]


@ti.func
def hex_by_points(x, u, weight, parameters, law: ti.template(), memory: ti.template(), shape: ti.template()):
    """Return what `hex_points` returns, point by point (hex8_points.py)."""
    mode_u = [hex_modes(u[c]) for c in range(3)]
    zero = [[0.0 for _ in range(7)] for _ in range(3)]
    points = mode_forces_by_points(x, mode_u, weight * (1.0 / 512.0), parameters, law, memory, shape, zero)
    return [[hex_corner_forces(points[0][c]) for c in range(3)], points[1], points[2]]


@ti.func
def hex_point_gradient(x, u, point):
    """Return [H, D/512] of a point of a hex8 from its corners x[c][k], u[c][k]."""
    sign = signs_of(point)
    r = [GAUSS * sign[j] for j in range(3)]
    shape = geometry([gradients_at(hex_modes(x[c]), r) for c in range(3)])
    g = [gradients_at(hex_modes(u[c]), r) for c in range(3)]
    return [tensor3.product_transposed(g, shape[1]), (1.0 / 512.0) * shape[2]]


hex_force = of_shape(hex_points, ANY)
affine_hex_force = of_shape(hex_points, PARALLELEPIPED)
box_hex_force = of_shape(hex_points, BOX)


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
def hex_viscosity(x, u, v, half, speed, square):
    """Return [corner forces [component][corner], -q, V', rate, V at rest, t] of a hex8, q per reference density.

    t: the rate with the quadratic part twice; -q and V' are scaled such that their product is the power. speed: c1 c,
    square: c2^2; half: half of the step [s] in which v is the velocity.
    """
    mode_x = [hex_modes(x[c]) for c in range(3)]
    mode_u = [hex_modes(u[c]) for c in range(3)]
    mode_v = [hex_modes(v[c]) for c in range(3)]
    reference = hex_slopes(mode_x)[0]
    now = hex_slopes([[mode_x[c][m] + mode_u[c][m] for m in range(7)] for c in range(3)])
    slopes = now[1]
    middle = hex_slopes([[mode_x[c][m] + (mode_u[c][m] - half * mode_v[c][m]) for m in range(7)] for c in range(3)])[1]
    change = dot(middle[0], [mode_v[c][0] for c in range(3)])
    square_sum = dot(slopes[0], slopes[0])
    largest = square_sum
    for m in ti.static(range(1, 6)):
        change += dot(middle[m], [mode_v[c][m] for c in range(3)])
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
    "hex8" + name: CellFunctions(
        8,
        force,
        hex_force,
        hex_viscosity,
        hex_centre,
        thread_force=of_shape(hex_by_points, shape),
        thread_step_force=of_shape(hex_by_points, ANY),
        point_gradient=hex_point_gradient,
    )
    for name, force, shape in (
        ("", hex_force, ANY),
        ("-affine", affine_hex_force, PARALLELEPIPED),
        ("-box", box_hex_force, BOX),
    )
}
