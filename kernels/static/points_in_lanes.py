"""Stiffness between the contact nodes of a cell, all points of integration at once: one point per lane.

    A_ab = sum over points q of w_q det(dX/dr) [(G_a . T G_b) I + c1 b x a + c2 a x b (+ (G_a . G_b) R)],   a = M G_a

This is the sum over the points that surface_tangent.py states, for elements with as many points as a pack has lanes and
laws whose tangent has a form (`tangent_form` of materials/law.py). The law gives its numbers point by point; all else
is done for the points together, in 0.4 of the time.
"""

from ..engine import ti
from ..lanes import WIDTH
from ..language.entries import row
from ..language.point_memory import tangent_at
from ..language.vectors import MASK

FORM, REST = 20, 29  # numbers of a form without and with R: M, T, c1, c2, R


@ti.func
def zeros():
    """Return 0 in every lane."""
    return ti.Vector([0.0 for _ in range(WIDTH)])


@ti.func
def gradient(pairs: ti.template(), gradients, corners: ti.template(), a):
    """Return the gradient (3) of the shape function of corner a at the points."""
    first = (3 * (gradients + a)) & MASK
    return [ti.Vector([pairs.shape_gradients[first + 3 * corners * q + j] for q in range(WIDTH)]) for j in range(3)]


@ti.func
def slopes_of(body: ti.template(), pairs: ti.template(), first, gradients, corners: ti.template()):
    """Return dX/dr [3][3] and du/dr [3][3] at the points of the cell whose corners start at first."""
    jacobian = [[zeros() for _ in range(3)] for _ in range(3)]
    slope = [[zeros() for _ in range(3)] for _ in range(3)]
    origin = row(body.u, pairs.cell_nodes[first])
    for a in range(corners):
        node = pairs.cell_nodes[first + a]
        x, moved = row(body.position, node), row(body.u, node) - origin
        g = gradient(pairs, gradients, corners, a)
        for i, j in ti.static(ti.ndrange(3, 3)):
            jacobian[i][j] += x[i] * g[j]
            slope[i][j] += moved[i] * g[j]
    return [jacobian, slope]


@ti.func
def numbers_of(
    part: ti.template(), f, parameters, pressure, body: ti.template(), place, size: ti.template(), rest: ti.template()
):
    """Return the numbers of the form at the points, [M, T, c1, c2, R] row by row; f [3][3]: F in lanes."""
    found = [zeros() for _ in range(REST if rest else FORM)]
    for q in range(WIDTH):
        here = ti.Matrix([[f[i][j][q] for j in range(3)] for i in range(3)])
        data = tangent_at(part, here, parameters, pressure, body, place, q, size, WIDTH)
        for i, j in ti.static(ti.ndrange(3, 3)):
            found[3 * i + j][q] = data[0][i, j]
            found[9 + 3 * i + j][q] = data[1][i, j]
            if ti.static(rest):
                found[FORM + 3 * i + j][q] = data[4][i, j]
        found[18][q] = data[2]
        found[19][q] = data[3]
    return found


@ti.func
def put_three(local: ti.template(), place, vectors):
    """Store three vectors over the lanes one after another."""
    first = (3 * WIDTH * place) & MASK
    for j, lane in ti.static(ti.ndrange(3, WIDTH)):
        local[first + WIDTH * j + lane] = vectors[j][lane]


@ti.func
def get_three(local: ti.template(), place):
    """Return three vectors over the lanes."""
    first = (3 * WIDTH * place) & MASK
    return [ti.Vector([local[first + WIDTH * j + lane] for lane in range(WIDTH)]) for j in range(3)]


@ti.func
def inner(a, b):
    """Return the product of two vectors (3)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@ti.func
def times(matrix, first: ti.template(), vector):
    """Return the product of a matrix, row by row from `first` on, and a vector (3)."""
    return [inner([matrix[first + 3 * i + j] for j in range(3)], vector) for i in range(3)]


@ti.func
def pair_value(numbers, ga, gb, a, b, rest: ti.template()):
    """Return the integral A_ab [3, 3] over the points."""
    same = inner(ga, times(numbers, 9, gb))
    both = inner(ga, gb)
    value = ti.Matrix.zero(ti.f64, 3, 3)
    for i, j in ti.static(ti.ndrange(3, 3)):
        entry = numbers[18] * b[i] * a[j] + numbers[19] * a[i] * b[j]
        if ti.static(i == j):
            entry += same
        if ti.static(rest):
            entry += both * numbers[FORM + 3 * i + j]
        value[i, j] = entry.sum()
    return value
