"""Shapes of hexahedra: how displacements of a cell become H at its points, and stresses there forces on its modes.

Each shape is a `CellShape`. With modes, G and A as in `hex8_modes` and `hex8`, D = det A and the coordinates r of the
points, +-1/sqrt 3:

    any cell          H = G (cof A)^t / D,     dW/dG = P cof A,     A of each point
    parallelepiped    H = G B^t,               dW/dG = D P B,       B = cof A / D of the cell
    box (A diagonal)  the modes c1/a1, c12/(a1 a2), .. c123/D are those of H itself in the coordinates a1 r1, ..

In a box the points need no products of matrices: the forces on the modes c are those that P gives on the modes of H,
times D/a1, D/(a1 a2), .. 1. Edges of parallelepipeds are those at the first corner.
"""

from typing import Any, NamedTuple

from ..engine import ti
from ..language import tensor3
from .hex8_modes import GAUSS, gradients_at, hex_gradients, hex_modes, hex_plane


class CellShape(NamedTuple):
    """Functions of the cells of a shape.

    of_cell(x) -> data from the corners x[c][k]; modes(data, modes of u) -> the modes that give g by `hex_gradients` in
    coordinates(data) -> [r1, r2, r3] of the point where all are positive; level(data, r1, r3) -> data of the points at
    r3; maps(data, level, r1, r2) -> those of the points at (-r1, r2) and (r1, r2) there; pull(g, map) -> H;
    push(P, map) -> Q, whose sums over the points, forces(data, share, sums), are 512 share times the forces on the
    modes of u; map[1] is D; even: it is the same at all points, and Q and the energies are summed without it. Point by
    point (hex8_points.py) map_at(data, r) -> the map of a point; moments(data, share, forces) -> the sums of forces.
    """

    of_cell: Any
    modes: Any
    coordinates: Any
    level: Any
    maps: Any
    pull: Any
    push: Any
    forces: Any
    even: bool
    map_at: Any
    moments: Any


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
def planes(data, r1, r3):
    return [hex_plane(data[c], r1, r3) for c in range(3)]


@ti.func
def maps_of_points(data, level, r1, r2):
    a = [hex_gradients(level[c], data[c], r1, r2) for c in range(3)]
    return [cofactors([a[c][0] for c in range(3)]), cofactors([a[c][1] for c in range(3)])]


@ti.func
def map_of_point(data, r):
    return cofactors([gradients_at(data[c], r) for c in range(3)])


@ti.func
def cofactors(a):
    """Return [cof A, D]."""
    m = tensor3.cofactor(a)
    return [m, tensor3.determinant(a, m)]


@ti.func
def pull_any(g, mapped):
    return tensor3.scaled(1.0 / mapped[1], tensor3.product_transposed(g, mapped[0]))


@ti.func
def push(p, mapped):
    return tensor3.product(p, mapped[0])


@ti.func
def equal_shares(data, share, moments):
    return [[share * moments[c][m] for m in range(7)] for c in range(3)]


@ti.func
def over_share(data, share, forces):
    scale = 1.0 / share
    return [[scale * forces[c][m] for m in range(7)] for c in range(3)]


ANY = CellShape(
    modes_of_cell,
    same_modes,
    unit_coordinates,
    planes,
    maps_of_points,
    pull_any,
    push,
    equal_shares,
    even=False,
    map_at=map_of_point,
    moments=over_share,
)


@ti.func
def edges_of_cell(x):
    """Return [cof A / D, D] of a parallelepiped."""
    shape = cofactors([[4.0 * (x[c][k] - x[c][0]) for k in (1, 3, 4)] for c in range(3)])
    return [tensor3.scaled(1.0 / shape[1], shape[0]), shape[1]]


@ti.func
def no_level(data, r1, r3):
    return data


@ti.func
def same_maps(data, level, r1, r2):
    return [data, data]


@ti.func
def same_map(data, r):
    return data


@ti.func
def pull_affine(g, mapped):
    return tensor3.product_transposed(g, mapped[0])


@ti.func
def shares_of_volume(data, share, moments):
    return equal_shares(data, share * data[1], moments)


@ti.func
def over_volume(data, share, forces):
    return over_share(data, share * data[1], forces)


PARALLELEPIPED = CellShape(
    edges_of_cell,
    same_modes,
    unit_coordinates,
    no_level,
    same_maps,
    pull_affine,
    push,
    shares_of_volume,
    even=True,
    map_at=same_map,
    moments=over_volume,
)


@ti.func
def lengths_of_cell(x):
    """Return [a, D, 1/a, 1/D] of a box, a the diagonal of A."""
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
def lengths(data):
    return [GAUSS * data[0][0], GAUSS * data[0][1], GAUSS * data[0][2]]


@ti.func
def unchanged(g, mapped):
    return g


@ti.func
def shares_of_faces(data, share, moments):
    a = [share * data[0][j] for j in range(3)]
    scales = [a[1] * data[0][2], a[2] * data[0][0], a[0] * data[0][1], a[2], a[1], a[0], share]
    return [[scales[m] * moments[c][m] for m in range(7)] for c in range(3)]


@ti.func
def over_faces(data, share, forces):
    b, scale = data[2], 1.0 / share
    scales = [b[1] * b[2], b[2] * b[0], b[0] * b[1], b[2], b[1], b[0], 1.0]
    return [[scale * scales[m] * forces[c][m] for m in range(7)] for c in range(3)]


BOX = CellShape(
    lengths_of_cell,
    modes_per_length,
    lengths,
    no_level,
    same_maps,
    unchanged,
    unchanged,
    shares_of_faces,
    even=True,
    map_at=same_map,
    moments=over_faces,
)
