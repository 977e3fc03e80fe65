"""Prisms with two triangles: corner forces, energy and smallest det F - 1 of one cell from its corners.

Linear in the triangle (r, s) and along t in [0, 1], with 3 points of the triangle (exact to degree 2) times 2 of Gauss;
VTK corner order, r towards corner 1 and s towards corner 2. With the differences

    p = u1 - u0,  q = u2 - u0,  d = u3 - u0,  P = (u4 - u3) - p,  Q = (u5 - u3) - q

G = du/dr has the columns p + P t, q + Q t and d + P r + Q s; A = dX/dr likewise. The two levels t share their first two
columns, the three points of the triangle their third (`points` has the rest). The volume V = D/2 of a prism with any
corners is a cubic of the differences of its corners. With those at half height, p' = p + P/2 and q' = q + Q/2, and
m = d + (P + Q)/3 between the centres of the triangles,

    D = a.m,   a = p' x q' + P x Q/12,   s_p = q' x m,   s_q = m x p',   s_d = a,
    s_P = a/3 + s_p/2 + Q x m/12,   s_Q = a/3 + s_q/2 + m x P/12,   s = dD/d(difference)

(Hughes, The Finite Element Method, ch. 3; triangle rule of Strang and Fix.)
"""

from ..engine import ti
from ..language import tensor3
from .bulk_viscosity import pressure_rate
from .points import cross, dot, geometry, plus, point_force
from .record import CellFunctions

LEVELS = (0.5 - 0.5 / 3.0**0.5, 0.5 + 0.5 / 3.0**0.5)  # t of the Gauss points
WEIGHT = 1.0 / 12.0  # of every point: a sixth of the triangle's area of 1/2


@ti.func
def wedge_differences(u):
    """Return [p, q, d, P, Q] of one component from its 6 corner values."""
    p, q = u[1] - u[0], u[2] - u[0]
    return [p, q, u[3] - u[0], (u[4] - u[3]) - p, (u[5] - u[3]) - q]


@ti.func
def wedge_corner_forces(m):
    """Return the 6 corner forces of one component from dW/d(difference), by the transpose of `wedge_differences`."""
    p, q = m[0] - m[3], m[1] - m[4]
    last = m[3] + m[4]
    return [0.0 - (p + q + m[2]), p, q, m[2] - last, m[3], m[4]]


@ti.func
def wedge_gradient(m, r, s, t):
    """Return G [direction] of one component at a point."""
    return [m[0] + m[3] * t, m[1] + m[4] * t, m[2] + (m[3] * r + m[4] * s)]


@ti.func
def wedge_force(x, u, weight, parameters, law: ti.template(), memory: ti.template()):
    """Return [corner forces dW/du as [component][corner], energy, smallest det F - 1] of a wedge6.

    x[c][k], u[c][k]: its corners. The loop takes two points at a time, one at each level.
    """
    mode_x, mode_u = [wedge_differences(x[c]) for c in range(3)], [wedge_differences(u[c]) for c in range(3)]
    zero = x[0][0] * 0.0
    mode_f = [[zero for _ in range(5)] for _ in range(3)]
    energy = zero
    change = zero + 1e300
    for place in range(3):
        r = 1.0 / 6.0 + 0.5 * (place & 1)
        s = 1.0 / 6.0 + 0.5 * (place >> 1)
        for level in ti.static(range(2)):
            t = ti.static(LEVELS[level])
            shape = geometry([wedge_gradient(mode_x[c], r, s, t) for c in range(3)])
            g = [wedge_gradient(mode_u[c], r, s, t) for c in range(3)]
            point = point_force(g, shape, parameters, law, memory, 3 * level + place)
            energy += point[1]
            change = ti.min(change, point[2])
            for c in ti.static(range(3)):
                along = point[0][c]
                mode_f[c][0] += along[0]
                mode_f[c][1] += along[1]
                mode_f[c][2] += along[2]
                mode_f[c][3] += along[0] * t + along[2] * r
                mode_f[c][4] += along[1] * t + along[2] * s
    share = weight * WEIGHT
    force = [wedge_corner_forces([share * mode_f[c][m] for m in range(5)]) for c in range(3)]
    return [force, share * energy, change]


@ti.func
def combined(a, share, b):
    """Return a + share b of vectors [component]."""
    return [a[c] + share * b[c] for c in range(3)]


@ti.func
def wedge_slopes(mode_x):
    """Return [D, [s_p, s_q, s_d, s_P, s_Q]] of a wedge6 from the differences of its corners, s as [component]."""
    p, q, d, p_rise, q_rise = [[mode_x[c][k] for c in range(3)] for k in range(5)]
    p_mid, q_mid = combined(p, 0.5, p_rise), combined(q, 0.5, q_rise)
    m = combined(d, 1.0 / 3.0, plus(p_rise, q_rise))
    a = combined(cross(p_mid, q_mid), 1.0 / 12.0, cross(p_rise, q_rise))
    first, second = cross(q_mid, m), cross(m, p_mid)
    third = [(1.0 / 3.0) * a[c] for c in range(3)]
    first_rise = combined(combined(third, 0.5, first), 1.0 / 12.0, cross(q_rise, m))
    second_rise = combined(combined(third, 0.5, second), 1.0 / 12.0, cross(m, p_rise))
    return [dot(a, m), [first, second, a, first_rise, second_rise]]


@ti.func
def wedge_viscosity(x, u, v, half, speed, square):
    """Return [corner forces [component][corner], -q, V', rate, V at rest, t] of a wedge6 as `hex8.hex_viscosity`.

    The height h is the shortest of the triangle at half height and of the cell between its two triangles.
    """
    mode_x, mode_u = [wedge_differences(x[c]) for c in range(3)], [wedge_differences(u[c]) for c in range(3)]
    mode_v = [wedge_differences(v[c]) for c in range(3)]
    reference = wedge_slopes(mode_x)[0]
    now = wedge_slopes([[mode_x[c][k] + mode_u[c][k] for k in range(5)] for c in range(3)])
    slopes = now[1]
    corner = [wedge_corner_forces([slopes[k][c] for k in range(5)]) for c in range(3)]
    back = [[mode_x[c][k] + (mode_u[c][k] - half * mode_v[c][k]) for k in range(5)] for c in range(3)]
    middle = wedge_slopes(back)[1]
    change, square_sum = 0.0 * reference, 0.0 * reference
    for k in ti.static(range(5)):
        change += dot(middle[k], [mode_v[c][k] for c in range(3)])
    for c, k in ti.static(ti.ndrange(3, 6)):
        square_sum += corner[c][k] * corner[c][k]
    outer = plus(slopes[0], slopes[1])
    largest = ti.max(ti.max(dot(slopes[0], slopes[0]), dot(slopes[1], slopes[1])), dot(outer, outer))
    largest = ti.max(largest, dot(slopes[2], slopes[2]))
    answer = pressure_rate(change, now[0], reference, ti.sqrt(largest), speed, square)
    pressure = answer[0] * answer[1] * 0.5
    force = [[pressure * corner[c][k] for k in range(6)] for c in range(3)]
    rates = [6.0 * answer[i] * square_sum for i in range(2, 4)]
    return [force, pressure, change, rates[0], 0.5 * reference, rates[1]]


@ti.func
def wedge_centre(x, u):
    """Return H at the centre of a wedge6 from its corners x[c][k], u[c][k]."""
    third = 1.0 / 3.0
    shape = geometry([wedge_gradient(wedge_differences(x[c]), third, third, 0.5) for c in range(3)])
    g = [wedge_gradient(wedge_differences(u[c]), third, third, 0.5) for c in range(3)]
    return tensor3.product_transposed(g, shape[1])


@ti.func
def wedge_point_gradient(x, u, point):
    """Return [H, D times the weight] of a point of a wedge6 from its corners x[c][k], u[c][k]."""
    place, level = point % 3, point // 3
    r, s = 1.0 / 6.0 + 0.5 * (place & 1), 1.0 / 6.0 + 0.5 * (place >> 1)
    t = ti.static(LEVELS[0]) + ti.static(LEVELS[1] - LEVELS[0]) * level
    shape = geometry([wedge_gradient(wedge_differences(x[c]), r, s, t) for c in range(3)])
    g = [wedge_gradient(wedge_differences(u[c]), r, s, t) for c in range(3)]
    return [tensor3.product_transposed(g, shape[1]), WEIGHT * shape[2]]


FUNCTIONS = {
    "wedge6": CellFunctions(
        6,
        wedge_force,
        wedge_force,
        wedge_viscosity,
        wedge_centre,
        points=6,
        share=WEIGHT,
        point_gradient=wedge_point_gradient,
    )
}
