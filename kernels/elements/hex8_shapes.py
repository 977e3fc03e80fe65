"""Shapes of hexahedra: how displacements of a cell become H at its points, and the stresses forces on its modes.

Each shape is a `CellShape`. With the modes of `hex8_modes` and the coordinates r of the points, +-1/sqrt 3:

    any cell          H = G (cof A)^t / D,     dW/dG = P cof A,     A of each point
    parallelepiped    H = G B^t,               dW/dG = D P B,       B = cof A / D of the cell
    box (A diagonal)  the modes c_1/a_1, c_12/(a_1 a_2), .. are those of H itself in the coordinates a_1 r_1, ..

In a box P therefore gives D times the forces on these modes, and the points need no products of matrices.
"""

from typing import Any, NamedTuple

import taichi as ti

from ..language import tensor3
from .hex8_modes import GAUSS, four_gradients, hex_modes


class CellShape(NamedTuple):
    """Functions of a shape of cells.

    of_cell(x) -> data from the corners x[c][k]; modes(data, modes of u) -> the modes that `pull` understands;
    coordinates(data) -> [r1, r2, r3] of the point where all are positive; maps(data, r1, r2, r3) -> data of the points
    at (-r1, r2, r3) and (r1, r2, r3); pull(g, map) -> H; push(P, map) -> Q, whose moments are the forces on the modes
    but for forces(data, share, moments), times 512 share; volume(map) -> D, even: D is the same at all points, and Q
    and the energies are summed without it.
    """

    of_cell: Any
    modes: Any
    coordinates: Any
    maps: Any
    pull: Any
    push: Any
    volume: Any
    forces: Any
    even: bool = True


@ti.func
def modes_of_cell(x):
    return [hex_modes(x[c]) for c in range(3)]


@ti.func
def same_modes(data, modes):
    return modes


@ti.func
def unit_coordinates(data):
    return [GAUSS, GAUSS, GAUSS]


@ti.func
def maps_of_points(data, r1, r2, r3):
    a = [four_gradients(data[c], r1, r2, r3) for c in range(3)]
    return [cofactors([a[c][k] for c in range(3)]) for k in range(4)]


@ti.func
def cofactors(a):
    """Return [cof A, D]."""
    m = tensor3.cofactor(a)
    return [m, tensor3.determinant(a, m)]


@ti.func
def pull_any(g, mapped):
    return tensor3.scaled(1.0 / mapped[1], tensor3.product_transposed(g, mapped[0]))


@ti.func
def push_any(p, mapped):
    return tensor3.product(p, mapped[0])


@ti.func
def volume_of_map(mapped):
    return mapped[1]


@ti.func
def equal_shares(data, share, moments):
    return [[share * moments[c][m] for m in range(7)] for c in range(3)]


ANY = CellShape(
    modes_of_cell,
    same_modes,
    unit_coordinates,
    maps_of_points,
    pull_any,
    push_any,
    volume_of_map,
    equal_shares,
    even=False,
)


@ti.func
def edges_of_cell(x):
    """Return [cof A / D, D] of a parallelepiped."""
    shape = cofactors([[4.0 * (x[c][k] - x[c][0]) for k in (1, 3, 4)] for c in range(3)])
    return [tensor3.scaled(1.0 / shape[1], shape[0]), shape[1]]


@ti.func
def same_maps(data, r1, r2, r3):
    return [data, data, data, data]


@ti.func
def pull_affine(g, mapped):
    return tensor3.product_transposed(g, mapped[0])


@ti.func
def shares_of_volume(data, share, moments):
    return equal_shares(data, share * data[1], moments)


PARALLELEPIPED = CellShape(
    edges_of_cell,
    same_modes,
    unit_coordinates,
    same_maps,
    pull_affine,
    push_any,
    volume_of_map,
    shares_of_volume,
)


@ti.func
def lengths_of_cell(x):
    """Return [a, 1/a, D] of a box, a the diagonal of A."""
    a = [4.0 * (x[c][k] - x[c][0]) for c, k in ((0, 1), (1, 3), (2, 4))]
    volume = a[0] * a[1] * a[2]
    inverse = 1.0 / volume
    return [a, volume, [inverse * (a[1] * a[2]), inverse * (a[2] * a[0]), inverse * (a[0] * a[1])], inverse]


@ti.func
def modes_per_length(data, modes):
    b = data[2]
    scales = [b[0], b[1], b[2], b[0] * b[1], b[0] * b[2], b[1] * b[2], data[3]]
    return [[scales[m] * modes[c][m] for m in range(7)] for c in range(3)]


@ti.func
def own_coordinates(data):
    return [GAUSS * data[0][0], GAUSS * data[0][1], GAUSS * data[0][2]]


@ti.func
def unchanged(g, mapped):
    return g


@ti.func
def shares_of_faces(data, share, moments):
    a = [share * data[0][j] for j in range(3)]
    scales = [a[1] * data[0][2], a[2] * data[0][0], a[0] * data[0][1], a[2], a[1], a[0], share]
    return [[scales[m] * moments[c][m] for m in range(7)] for c in range(3)]


BOX = CellShape(
    lengths_of_cell,
    modes_per_length,
    own_coordinates,
    same_maps,
    unchanged,
    unchanged,
    volume_of_map,
    shares_of_faces,
)
