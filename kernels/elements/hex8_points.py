"""Hexahedra point by point, for threads with few registers: each thread of a GPU has a cell of its own.

What `hex8.hex_mode_forces` computes for two points at a time, with sums by planes and levels, is computed here for one
point after the other from the modes alone. With G of `hex8_modes` and Q = dW/dG at a point r the forces on modes are

    dW/dc1 = Q1,   dW/dc12 = Q1 r2 + Q2 r1,   dW/dc123 = Q1 r2 r3 + Q2 r3 r1 + Q3 r1 r2,   and so on.

A thread keeps the modes of position, displacement and force (63 numbers) and what one point needs.
"""

from ..engine import ti
from ..language.point_memory import respond
from .hex8_modes import gradients_at


@ti.func
def point_answer(g, mapped, parameters, law: ti.template(), memory: ti.template(), point, shape: ti.template()):
    """Return [Q, energy, det F - 1] of one Gauss point of weight 1 (hex8_shapes.py)."""
    answer = respond(law, shape.pull(g, mapped), parameters, memory, point, mapped[1])
    if ti.static(shape.even):
        return [shape.push(answer[0], mapped), answer[1], answer[2]]
    else:
        return [shape.push(answer[0], mapped), mapped[1] * answer[1], answer[2]]


@ti.func
def signs_of(point):
    """Return s_j = +-1 of the corner that a point stands next to."""
    return [2.0 * i - 1.0 for i in ((point ^ (point >> 1)) & 1, (point >> 1) & 1, point >> 2)]


@ti.func
def mode_forces_by_points(
    x, mode_u, share, parameters, law: ti.template(), memory: ti.template(), shape: ti.template(), start
):
    """Return what `hex8.hex_mode_forces` returns; start: forces on the modes of u to which they are added."""
    data = shape.of_cell(x)
    modes, half = shape.modes(data, mode_u), shape.coordinates(data)
    moments = shape.moments(data, share, start)
    energy = x[0][0] * 0.0
    change = energy + 1e300
    for point in range(8):
        sign = signs_of(point)
        r = [half[j] * sign[j] for j in range(3)]
        mapped = shape.map_at(data, r)
        g = [gradients_at(modes[c], r) for c in range(3)]
        answer = point_answer(g, mapped, parameters, law, memory, point, shape)
        energy += answer[1]
        change = ti.min(change, answer[2])
        for c in ti.static(range(3)):
            q = answer[0][c]
            across = q[0] * r[1] + q[1] * r[0]
            moments[c][0] += q[0]
            moments[c][1] += q[1]
            moments[c][2] += q[2]
            moments[c][3] += across
            moments[c][4] += q[0] * r[2] + q[2] * r[0]
            moments[c][5] += q[1] * r[2] + q[2] * r[1]
            moments[c][6] += across * r[2] + q[2] * (r[0] * r[1])
    if ti.static(shape.even):
        energy *= data[1]
    return [shape.forces(data, share, moments), share * energy, change]
