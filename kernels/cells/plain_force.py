"""Plain force kernel, the reference of the benchmark: one cell per iteration, with atomic adds.

Per Gauss point A = dX/dr, H = du/dr A^-1, then P of the law and dW/du = sum w D (P A^-t) dN/dr.
It shares the law with the step kernel, but not the cell function: derivatives along an edge line are differences of
corner values interpolated to the 4 Gauss lines, which is 1.7 times as fast as sums over corners. Of several
formulations without packs and lanes this was the fastest.
"""

import functools

from .. import elements
from ..elements.points import geometry, point_force
from ..engine import ti
from ..lanes import MATERIALS
from ..language.arguments import ARRAY, INDEX
from ..materials import LAWS

LERP = 0.5 - 0.5 / 3.0**0.5  # Gauss points of the unit interval: LERP and 1 - LERP

# edges along r_j as (from, to) corners; edge and line number = low bit of the first other coordinate + 2 * the second
EDGES = (
    ((0, 1), (3, 2), (4, 5), (7, 6)),
    ((0, 3), (1, 2), (4, 7), (5, 6)),
    ((0, 4), (1, 5), (3, 7), (2, 6)),
)
# edge lines through each point (bits r0 + 2 r1 + 4 r2), per direction, and the two points on each line
LINES = tuple((p >> 1, (p & 1) + 2 * (p >> 2), p & 3) for p in range(8))
POINTS = tuple(tuple(tuple(p for p in range(8) if LINES[p][j] == line) for line in range(4)) for j in range(3))


@ti.func
def interpolate(a):
    """Interpolate 4 edge values bilinearly to the 4 Gauss lines; the matrix of this is symmetric."""
    s0 = LERP * (a[1] - a[0])
    s1 = LERP * (a[3] - a[2])
    b0, b1, b2, b3 = a[0] + s0, a[1] - s0, a[2] + s1, a[3] - s1
    t0 = LERP * (b2 - b0)
    t1 = LERP * (b3 - b1)
    return [b0 + t0, b1 + t1, b2 - t0, b3 - t1]


@ti.func
def hex_force(x, u, parameters, law: ti.template()):
    """Return the corner forces [component][corner] of a hex8, with all 8 points written out."""
    dx = [[interpolate([x[c][e[1]] - x[c][e[0]] for e in EDGES[j]]) for j in range(3)] for c in range(3)]
    du = [[interpolate([u[c][e[1]] - u[c][e[0]] for e in EDGES[j]]) for j in range(3)] for c in range(3)]
    point = [
        point_force(
            [[du[c][j][LINES[p][j]] for j in range(3)] for c in range(3)],
            geometry([[dx[c][j][LINES[p][j]] for j in range(3)] for c in range(3)]),
            parameters,
            law,
            None,
            p,
        )[0]
        for p in range(8)
    ]
    force = [[0.0 for _ in range(8)] for _ in range(3)]
    for c, j in ti.static(ti.ndrange(3, 3)):
        edge = interpolate([point[p[0]][c][j] + point[p[1]][c][j] for p in POINTS[j]])
        for e in ti.static(range(4)):
            force[c][EDGES[j][e][0]] -= 0.125 * edge[e]
            force[c][EDGES[j][e][1]] += 0.125 * edge[e]
    return force


def forces_alone(whole):
    """Return a function of the corner forces [component][corner] of an element, without its energy."""

    @ti.func
    def force_of(x, u, parameters, law: ti.template()):
        return whole(x, u, 1.0, parameters, law, None)[0]

    return force_of


@functools.cache
def make_plain_force(kind: str, law: str):
    """Return the plain force kernel of a kind of cell with a law, memoised.

    plain_force(connectivity [cells*corners], position, params as for the step kernel, u, force_out) adds dW/du.
    """
    corners = elements.CORNERS[kind]
    force_of = hex_force if kind == "hex8" else forces_alone(elements.force_of(kind, law))
    law_of, count = LAWS[law], len(LAWS[law].parameters)

    @ti.kernel
    def plain_force(connectivity: INDEX, position: ARRAY, params: ARRAY, u: ARRAY, force_out: ARRAY):
        for cell in range(connectivity.shape[0] // corners):
            node = [3 * connectivity[cell * corners + k] for k in range(corners)]
            x = [[position[i + c] for i in node] for c in range(3)]
            y = [[u[i + c] for i in node] for c in range(3)]
            force = force_of(x, y, [params[MATERIALS + i] for i in range(count)], law_of)
            for k, c in ti.static(ti.ndrange(corners, 3)):
                force_out[node[k] + c] += force[c][k]

    return plain_force
