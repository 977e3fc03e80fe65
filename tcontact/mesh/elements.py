"""Elements: one record holds all facts of a kind of cell; its forces are in kernels/elements/.

Corners are in VTK's order. The corners of a face turn counter-clockwise seen from outside a cell whose volume is
positive, so that its normal points outward.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import permutations

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
Corners = tuple[int, ...]

SLANTED = 2.0**0.5  # edge of a cube over the shortest height of the tetrahedra or prisms that it is cut into


@dataclass(frozen=True)
class Formulation:
    """A way to integrate the forces of a cell.

    integration: description for cells of any shape; affine, box: the same for parallelepipeds and for boxes along the
    axes, if the kernels make use of these; small: largest number of cells for which one thread is faster than several:
    its pass then takes about 0.35 ms, as much as starting other threads for the two loops of a pass and for the contact
    cells would cost;
    locks: Poisson's ratio above which the cells are too stiff (locking.py).
    """

    integration: str
    small: int
    affine: str | None = None
    box: str | None = None
    locks: float = 1.0


@dataclass(frozen=True, eq=False)
class Element:
    """A kind of cell.

    kind: its name; plural: its plural in messages; reference [a, 3]: corners of the reference cell; shape: from points
    [q, 3] there to the shape functions [q, a] and their gradients [q, a, 3]; points [q, 3], weights [q]: the
    integration points of force and mass; product_points, product_weights: those for products of shape
    functions, None for the same. faces, edges: their corners; mirror: the order of the corners of the same cell with
    the opposite orientation; spans: three pairs of sets of corners, whose centres span a parallelepiped that is the
    cell or contains it, with enough alternatives for all heights of the cell; in_box: cells into which a hexahedron is
    cut. formulations: by name, "full" first; order: the remedy for corners in a wrong order; spacing: edge over
    shortest height of a cell of even shape; relaxation: factor of the sweeps of the static solve, best at nu = .3.
    Files: vtk: number of VTK's type; xdmf: name and number; meshio: name; abaqus: type, and abaqus_faces: S1, S2, ...
    """

    kind: str
    plural: str
    reference: FloatArray
    shape: Callable[[FloatArray], tuple[FloatArray, FloatArray]]
    points: FloatArray
    weights: FloatArray
    faces: tuple[Corners, ...]
    edges: tuple[tuple[int, int], ...]
    mirror: Corners
    spans: tuple[tuple[tuple[Corners, Corners], ...], ...]
    in_box: tuple[Corners, ...]
    formulations: Mapping[str, Formulation]
    vtk: int
    xdmf: tuple[str, int]
    meshio: str
    abaqus: str
    abaqus_faces: tuple[Corners, ...]
    order: str = "list its corners in VTK order"
    spacing: float = 1.0
    relaxation: float = 1.0
    product_points: FloatArray | None = None
    product_weights: FloatArray | None = None

    @property
    def corners(self) -> int:
        """Number of corners."""
        return len(self.reference)

    @cached_property
    def face_table(self) -> npt.NDArray[np.int64]:
        """Corners [faces, 4|3] of the faces; among quadrilaterals a triangle repeats its last corner."""
        width = max(map(len, self.faces))
        return np.array([face + face[-1:] * (width - len(face)) for face in self.faces])

    @cached_property
    def rule(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Shape functions [q, a], their gradients [q, a, 3] and weights [q] at the integration points."""
        return (*self.shape(self.points), self.weights)

    @cached_property
    def product_rule(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Values as in `rule` at points exact for products of two shape functions of an affine cell."""
        if self.product_points is None or self.product_weights is None:
            return self.rule
        return (*self.shape(self.product_points), self.product_weights)


def shape_functions(kind: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return values [q, corners], reference gradients [q, corners, 3], weights [q] at a cell's integration points."""
    return ELEMENTS[kind].rule


HEX_CORNERS = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float
)
GAUSS = 1.0 / np.sqrt(3.0)


def _hex_shape(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return trilinear functions on [-1, 1]^3."""
    factors = 1.0 + points[:, None, :] * HEX_CORNERS[None]  # [q, a, 3]
    gradients = np.empty((len(points), 8, 3))
    for axis, (one, two) in enumerate(((1, 2), (0, 2), (0, 1))):
        gradients[:, :, axis] = HEX_CORNERS[:, axis] * factors[:, :, one] * factors[:, :, two] / 8.0
    return factors.prod(axis=2) / 8.0, gradients


_EVERY_POINT = "Jacobian of every Gauss point recomputed"
_ONE_JACOBIAN = "one Jacobian per cell, recomputed"
_THREE_EDGES = "boxes along the axes, their edges recomputed"
_ONE_CHANGE = ", one volume change per cell"

HEX8 = Element(
    kind="hex8",
    plural="hexahedra",
    reference=HEX_CORNERS,
    shape=_hex_shape,
    points=GAUSS * HEX_CORNERS,
    weights=np.ones(8),
    faces=((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    edges=((0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 5), (2, 6), (3, 7), (4, 5), (5, 6), (6, 7), (7, 4)),
    mirror=(4, 5, 6, 7, 0, 1, 2, 3),
    spans=((((1, 2, 5, 6), (0, 3, 4, 7)), ((2, 3, 6, 7), (0, 1, 4, 5)), ((4, 5, 6, 7), (0, 1, 2, 3))),),
    in_box=((0, 1, 2, 3, 4, 5, 6, 7),),
    formulations={
        "full": Formulation(_EVERY_POINT, 4096, _ONE_JACOBIAN, _THREE_EDGES, locks=0.45),
        "reduced": Formulation("mean gradient recomputed", 8192, "one stored Jacobian per cell"),
        "mean-dilatation": Formulation(
            _EVERY_POINT + _ONE_CHANGE, 4096, _ONE_JACOBIAN + _ONE_CHANGE, _THREE_EDGES + _ONE_CHANGE
        ),
    },
    vtk=12,
    xdmf=("Hexahedron", 9),
    meshio="hexahedron",
    abaqus="C3D8",
    abaqus_faces=((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
    relaxation=1.1,
)


def _tet_shape(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return linear functions on the tetrahedron with three unit edges at the origin."""
    gradient = np.array([[-1, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    values = np.concatenate([1.0 - points.sum(axis=1, keepdims=True), points], axis=1)
    return values, np.repeat(gradient[None], len(points), axis=0)


def _freudenthal() -> tuple[Corners, ...]:
    """Return six tetrahedra in a hexahedron: the paths along three edges from corner 0 to corner 6."""
    paths: list[Corners] = []
    for path in permutations(range(3)):
        steps = np.cumsum([np.zeros(3, dtype=int), *np.eye(3, dtype=int)[list(path)]], axis=0)
        a, b, c, d = (int(4 * z + (0, 1, 3, 2)[x + 2 * y]) for x, y, z in steps)
        even = np.linalg.det(np.eye(3)[list(path)]) > 0.0
        paths.append((a, b, c, d) if even else (a, b, d, c))
    return tuple(paths)


TET4 = Element(
    kind="tet4",
    plural="tetrahedra",
    reference=np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float),
    shape=_tet_shape,
    points=np.full((1, 3), 0.25),
    weights=np.array([1.0 / 6.0]),
    product_points=np.full((4, 3), (5.0 - 5.0**0.5) / 20.0) + np.eye(4)[:, 1:] / 5.0**0.5,
    product_weights=np.full(4, 1.0 / 24.0),
    faces=((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
    edges=((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
    mirror=(0, 1, 3, 2),
    spans=((((1,), (0,)), ((2,), (0,)), ((3,), (0,))), (((2,), (3,)), ((1,), (3,)), ((0,), (3,)))),
    in_box=_freudenthal(),
    formulations={
        "full": Formulation(_ONE_JACOBIAN, 20000, locks=0.4),
        "node-averaged": Formulation(_ONE_JACOBIAN + ", volume change averaged at the nodes", 12500),
    },
    spacing=SLANTED,
    vtk=10,
    xdmf=("Tetrahedron", 6),
    meshio="tetra",
    abaqus="C3D4",
    abaqus_faces=((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    relaxation=1.3,
)


def _wedge_shape(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return linear functions of the triangle (r, s), r to corner 1, s to corner 2, times those of [-1, 1]."""
    r, s, t = points.T
    zero, one = np.zeros_like(r), np.ones_like(r)
    triangle = np.stack([1.0 - r - s, r, s], axis=1)
    slopes = np.stack([np.stack([-one, one, zero], axis=1), np.stack([-one, zero, one], axis=1)], axis=2)
    values, gradients = [], []
    for sign in (-1.0, 1.0):
        share = 0.5 * (1.0 + sign * t)[:, None]
        values.append(share * triangle)
        gradients.append(np.concatenate([share[:, None] * slopes, 0.5 * sign * triangle[:, :, None]], axis=2))
    return np.concatenate(values, axis=1), np.concatenate(gradients, axis=1)


WEDGE6 = Element(  # VTK has had this order, that of gmsh and Abaqus, only for some versions
    kind="wedge6",
    plural="prisms",
    reference=np.array([[0, 0, -1], [1, 0, -1], [0, 1, -1], [0, 0, 1], [1, 0, 1], [0, 1, 1]], dtype=float),
    shape=_wedge_shape,
    points=np.array([[r, s, t * GAUSS] for t in (-1, 1) for r, s in ((1 / 6, 1 / 6), (2 / 3, 1 / 6), (1 / 6, 2 / 3))]),
    weights=np.full(6, 1.0 / 6.0),
    faces=((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    edges=((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
    mirror=(0, 2, 1, 3, 5, 4),
    spans=(
        (((1, 4), (0, 3)), ((2, 5), (0, 3)), ((3, 4, 5), (0, 1, 2))),
        (((0, 3), (1, 4)), ((2, 5), (1, 4)), ((3, 4, 5), (0, 1, 2))),
    ),
    in_box=((0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7)),
    formulations={"full": Formulation(_EVERY_POINT, 5800, locks=0.4)},
    spacing=SLANTED,
    vtk=13,
    xdmf=("Wedge", 8),
    meshio="wedge",
    abaqus="C3D6",
    relaxation=1.2,
    abaqus_faces=((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    order="list the corners 0 1 2 of a triangle counter-clockwise as seen from the other triangle, and 3 4 5 opposite"
    " them (gmsh, Abaqus and VTK now; some versions of VTK had them clockwise)",
)

ELEMENTS = {element.kind: element for element in (HEX8, TET4, WEDGE6)}
FORMULATIONS = {  # by the names of `Body.element`
    element.kind if name == "full" else f"{element.kind}-{name}": formulation
    for element in ELEMENTS.values()
    for name, formulation in element.formulations.items()
}
BY_CORNERS = {element.corners: element for element in ELEMENTS.values()}
MIXED = "mixed"  # kind of a mesh with cells of several kinds


def face_corners(kind: str) -> tuple[int, ...]:
    """Return how many corners the faces of a kind of mesh can have, ascending; a mixed one has triangles and quads."""
    elements = ELEMENTS.values() if kind == MIXED else [ELEMENTS[kind]]
    return tuple(sorted({len(face) for element in elements for face in element.faces}))
