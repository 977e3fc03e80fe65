"""A mesh: nodes, cells of one or several kinds, named sets. Plain data, checked once, never changed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ..base.errors import InputError, hint
from ..base.validate import number, vector
from . import checks
from .elements import ELEMENTS, MIXED, Element
from .geometry import Blocks, FloatArray, IntArray, Surface, cell_volumes, shortest_edge, surface
from .late_rows import Rows
from .mixed_cells import in_rows, out_of_rows, repeats
from .parts import part_of
from .rotation import rotation_matrix

NO_SETS = (
    "this mesh has no sets; name physical groups where the mesh file is made, or add sets:"
    ' mesh.with_sets(node_sets={"top": numbers of nodes})'
)


@dataclass(frozen=True, eq=False, repr=False)
class Mesh:
    """An unstructured mesh of cells of one kind, or of several kinds that fit together face by face.

    nodes: [n, 3] coordinates [m]; cells: [m, 8|4|6] node ids, corners in VTK order; kind: "hex8", "tet4" or "wedge6"
    (a prism whose triangle 0, 1, 2 turns counter-clockwise seen from 3, 4, 5: so in gmsh, Abaqus and VTK 9.7).
    Cells of several kinds are a dict from kinds to such arrays, such as {"hex8": .., "wedge6": ..}, without `kind`,
    which then is "mixed". They are numbered block after block, and `cells` of such a mesh has rows of equal length,
    in which a shorter cell repeats its last corner; `blocks` has the cells of every kind apart.
    node_sets: name -> [k] node ids; face_sets: name -> [k, 4|3] node ids of faces that cells have, in any orientation;
    a triangle among quadrilaterals has one of its corners twice.
    A name may stand in both: its faces are then those of the face set, its nodes those of both.
    cell_sets: name -> [k] cell numbers, such as the regions of several materials (`Body.material`); they may overlap.

    The arrays are read-only copies (float64, int64) and numbering is the user's. Two meshes are equal only if they are
    the same object.

    The corners of cells that are mirrored as a whole (a negative Jacobian everywhere) are put into the right order,
    with a `MeshWarning`. Nodes of the boundary with equal coordinates get one too: only common nodes join cells.

    Raises `InputError` for anything the mechanics cannot use: wrong shapes, NaN, ids that are no nodes, a node named
    twice in a cell, double, tangled or flat cells, nodes of no cell, faces with more than two cells, faces of no cell,
    quadrilaterals that lie on the triangles of other cells, empty sets. A cell must have a positive Jacobian at its
    points of integration; at a corner it may be zero (wedge-like hexes with a flat corner), not negative.
    """

    nodes: FloatArray
    cells: IntArray
    kind: str = MIXED
    node_sets: Mapping[str, IntArray] = field(default_factory=dict)
    face_sets: Mapping[str, IntArray] = field(default_factory=dict)
    cell_sets: Mapping[str, IntArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        nodes = checks.checked_nodes(self.nodes)
        blocks = checks.checked_blocks(self.cells, self.kind, len(nodes))
        blocks = checks.turned_blocks(nodes, blocks)
        skin = checks.checked_surface(blocks, len(nodes))
        checks.warn_of_gaps(nodes, skin)
        node_sets = checks.checked_node_sets(self.node_sets, len(nodes))
        face_sets = checks.checked_face_sets(self.face_sets, blocks, len(nodes), skin)
        cell_sets = checks.checked_cell_sets(self.cell_sets, sum(len(cells) for _, cells in blocks))
        kind, cells = blocks[0]
        if len(blocks) > 1:
            kind, cells = MIXED, checks.read_only(in_rows(blocks))
        self.__dict__.update(contents(nodes, cells, kind, node_sets, face_sets, cell_sets), _surface=skin)

    readers: ClassVar[
        Any
    ]  # of meshes of other packages, and what draws a mesh: they stand above, the package sets them
    views: ClassVar[Any]

    @classmethod
    def from_meshio(cls, mesh: Any, scale: float = 1.0) -> Mesh:
        """Make a mesh of a `meshio.Mesh`.

        scale: factor on the coordinates. Volume cells are taken, those of second order as those of first order; cell
        sets of faces become face sets, those of volume cells cell sets, point sets node sets, and whole numbers of the
        cells such as "region" the cell sets "region-1" and so on, as `read_mesh` does. Sets are numbers counted from 0,
        cell sets by block with None for none; empty ones are left out with a `MeshWarning`.
        Raises `InputError` for what is no such mesh, for cells that a mesh cannot have and for sets of other things,
        such as masks.
        """
        made: Mesh = cls.readers.from_meshio(mesh, scale)
        return made

    @classmethod
    def from_pyvista(cls, grid: Any, scale: float = 1.0) -> Mesh:
        """Make a mesh of a grid of PyVista: a `pyvista.UnstructuredGrid`, or another one of volume cells.

        scale: factor on the coordinates. Whole numbers of the cells such as "region" become cell sets, as `read_mesh`
        does. Raises `InputError` for what is no such grid and for cells that a mesh cannot have.
        """
        made: Mesh = cls.readers.from_pyvista(grid, scale)
        return made

    def plot(self, sets: str | Iterable[str] = (), axes: Any = None) -> Any:
        """Draw the boundary with matplotlib; return the axes, in three dimensions.

        sets: names of sets whose faces have a colour and a place in the legend; axes: those to draw on, with the
        projection "3d", None = new ones. Raises `InputError` for an unknown set and for axes of another kind.
        """
        return self.views.plot_mesh(self, (sets,) if isinstance(sets, str) else tuple(sets), axes)

    def _repr_png_(self) -> bytes:
        """Return a picture for a notebook."""
        return bytes(self.views.mesh_picture(self))

    @cached_property
    def blocks(self) -> tuple[tuple[str, IntArray], ...]:
        """Kinds of cells, each with the nodes [m, corners] of its cells, in the order of the cell numbers."""
        return ((self.kind, self.cells),) if self.kind != MIXED else out_of_rows(self.cells)

    @property
    def cell_counts(self) -> tuple[tuple[str, int], ...]:
        """Kinds of cells with the number of cells of each, as `blocks` has them."""
        return tuple((kind, len(cells)) for kind, cells in self.blocks)

    @cached_property
    def repeated(self) -> npt.NDArray[np.bool_] | None:
        """Places [m, corners] in `cells` that repeat a corner; None for cells of one kind, which repeat none."""
        return None if self.kind != MIXED else checks.read_only(repeats(self.cells))

    @property
    def element(self) -> Element:
        """The element of its cells. Raises `InputError` if they are of several kinds."""
        if self.kind == MIXED:
            raise InputError("Mesh.kind", self.kind, "it has several elements; take them from Mesh.blocks")
        return ELEMENTS[self.kind]

    @property
    def node_count(self) -> int:
        """The number of nodes."""
        return len(self.nodes)

    @property
    def cell_count(self) -> int:
        """The number of cells."""
        return len(self.cells)

    @cached_property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest corner of the bounding box [m], each [3]."""
        return checks.read_only(self.nodes.min(axis=0)), checks.read_only(self.nodes.max(axis=0))

    @property
    def size(self) -> float:
        """Longest edge of the bounding box [m]."""
        low, high = self.bounds
        return float((high - low).max())

    @property
    def keeps_shape(self) -> bool:
        """Return whether rounding of its coordinates cannot have damaged its cells, where they are larger than that."""
        reach = max(float(np.abs(bound).max()) for bound in self.bounds)
        return bool(np.isfinite(reach) and reach <= 1e6 * self.size and 1e-60 < self.size < 1e60)

    @cached_property
    def shortest_edge(self) -> float:
        """The length of the shortest edge of its cells [m]. Raises `InputError` if two nodes of a cell coincide."""
        found = min(shortest_edge(self.nodes, cells) for _, cells in self.blocks)
        if found == 0.0:
            remedy = "move them apart, or mesh what is a prism with wedge6 cells"
            raise InputError("Mesh.cells", "an edge of length 0", f"two nodes of a cell are in one place; {remedy}")
        return found

    def nodes_at(self, numbers: IntArray) -> FloatArray:
        """Return the coordinates [.., 3] [m] of nodes of these numbers [..]. Raises `InputError` for others."""
        return np.asarray(self.nodes[checks.checked_numbers(numbers, self.node_count)])

    @property
    def node_rows(self) -> Rows:
        """`nodes`, for what reads some of them at a time: `LateRows` where the mesh makes them when they are read."""
        return self.nodes

    @property
    def cell_rows(self) -> Rows:
        """`cells`, likewise."""
        return self.cells

    def portions(self, name: str) -> Iterator[npt.NDArray[Any]]:
        """Yield the rows of "nodes" or "cells" in portions, as they are best read one after the other."""
        yield getattr(self, name)

    @property
    def cell_portions(self) -> Iterable[tuple[str, IntArray]]:
        """Kinds of cells, each with the nodes [k, corners] of a portion of them, in the order of the cell numbers."""
        return self.blocks

    def chosen_cells(self, numbers: npt.NDArray[np.integer]) -> Blocks:
        """Return kinds of cells, each with the nodes [k, corners] of those of these numbers, ascending; none without
        any."""
        found, first = [], 0
        for kind, rows in self.blocks:
            mine = numbers[(numbers >= first) & (numbers < first + len(rows))] - first
            first += len(rows)
            if len(mine):
                found.append((kind, rows[mine]))
        return tuple(found)

    def has_cells_of(self, other: Mesh) -> bool:
        """Return whether another mesh has the same cells, with the same nodes."""
        return self is other or np.array_equal(self.cells, other.cells)

    def release(self) -> None:
        """Forget arrays that can be made again; here there are none."""

    def cell_centres(self) -> FloatArray:
        """Return the mean of the corners of each cell [m, 3] [m]."""
        return np.concatenate([self.nodes[cells].mean(axis=1) for _, cells in self.blocks])

    def cell_volumes(self) -> FloatArray:
        """Volume of each cell [m^3], [m]."""
        return self._volumes

    def boundary_faces(self) -> IntArray:
        """Faces that belong to one cell only, [k, 4|3] node ids, corners counter-clockwise seen from outside.

        With kinds of cells that have both, a triangle has its last corner twice: [a, b, c, c].
        """
        return self._surface.faces

    def faces_of(self, names: str | Iterable[str]) -> IntArray:
        """Return the boundary faces of one or several named sets, [k, 4|3], outward, each once.

        A face set has its own faces, a node set the faces with all nodes in it. Inner faces of a set are left out: they
        cannot come into contact. Raises `InputError` for an unknown name and for a set on no boundary face.
        """
        found = [self._faces_of_one(name) for name in self._known_surfaces(names)]
        faces, first = np.unique(np.concatenate(found), return_index=True)
        return self._surface.faces[faces[np.argsort(first)]]

    def nodes_of(self, names: str | Iterable[str]) -> IntArray:
        """Return the sorted nodes [k] in one or several named sets. Raises `InputError` for an unknown name."""
        sets = [s[name] for name in self._known_surfaces(names) for s in (self.node_sets, self.face_sets) if name in s]
        return np.unique(np.concatenate([ids.reshape(-1) for ids in sets]))

    def with_sets(
        self,
        node_sets: Mapping[str, Any] | None = None,
        face_sets: Mapping[str, Any] | None = None,
        cell_sets: Mapping[str, Any] | None = None,
    ) -> Mesh:
        """Return the mesh with sets added or replaced; raises `InputError` as the constructor does."""
        new_nodes = checks.checked_node_sets({} if node_sets is None else node_sets, self.node_count)
        faces = {} if face_sets is None else face_sets
        blocks = () if isinstance(faces, Mapping) and not len(faces) else self.blocks
        new_faces = checks.checked_face_sets(faces, blocks, self.node_count, self._surface)
        new_cells = checks.checked_cell_sets({} if cell_sets is None else cell_sets, self.cell_count)
        merged = {**self.node_sets, **new_nodes}, {**self.face_sets, **new_faces}, {**self.cell_sets, **new_cells}
        return self._with(*merged)

    def _with(self, node_sets: Any, face_sets: Any, cell_sets: Any) -> Mesh:
        """Return the mesh with these checked sets."""
        mesh = Mesh.trusted(self.nodes, self.cells, self.kind, node_sets, face_sets, cell_sets)
        mesh.__dict__["_surface"] = self._surface
        return mesh

    def part(self, names: str | Iterable[str]) -> Mesh:
        """Return the mesh of the cells of one or several cell sets, with the nodes and sets that belong to them.

        Nodes and cells keep their order; sets without any of them are left out. So instances of an assembly become
        bodies of their own. Raises `InputError` for an unknown name.
        """

        def remedy() -> str:
            return f"use one of the cell sets of this mesh: {', '.join(self.cell_sets) or 'it has none'}"

        cells = [self.cell_sets[name] for name in self._known(names, self.cell_sets, remedy=remedy)]
        sets = self.node_sets, self.face_sets, self.cell_sets
        return Mesh(**part_of(self, *sets, np.unique(np.concatenate(cells))))

    def translated(self, offset: Any) -> Mesh:
        """Return the mesh moved by `offset` [m], three numbers."""
        return self._moved("offset", offset, self.nodes + vector("offset", offset))

    def rotated(self, rotation: Any, about: Any = (0.0, 0.0, 0.0)) -> Mesh:
        """Return the mesh turned about the point `about` [m].

        rotation: a rotation matrix [3, 3], or (axis, angle): a direction of any length, a right-handed angle [rad].
        """
        centre = vector("about", about)
        return self._moved("rotation", rotation, (self.nodes - centre) @ rotation_matrix(rotation).T + centre)

    def scaled(self, factor: float) -> Mesh:
        """Return the mesh with all coordinates multiplied by a positive factor."""
        return self._moved("factor", factor, self.nodes * number("factor", factor, low=0.0))

    def __repr__(self) -> str:
        names = ", ".join(dict.fromkeys([*self.face_sets, *self.node_sets, *self.cell_sets])) or "none"
        cells = " + ".join(f"{count} {kind}" for kind, count in self.cell_counts)
        return f"Mesh({cells} cells, {self.node_count} nodes, sets: {names})"

    def __reduce__(self) -> tuple[Any, ...]:
        sets = dict(self.node_sets), dict(self.face_sets), dict(self.cell_sets)
        return Mesh.trusted, (self.nodes, self.cells, self.kind, *sets)

    @classmethod
    def trusted(
        cls,
        nodes: FloatArray,
        cells: IntArray,
        kind: str,
        node_sets: Mapping[str, IntArray],
        face_sets: Mapping[str, IntArray],
        cell_sets: Mapping[str, IntArray] | None = None,
    ) -> Mesh:
        """Make a mesh from arrays known to be valid, without copies or checks; the arrays become read-only."""
        regions = {} if cell_sets is None else cell_sets
        for array in (nodes, cells, *node_sets.values(), *face_sets.values(), *regions.values()):
            checks.read_only(array)
        mesh = object.__new__(cls)
        mesh.__dict__.update(contents(nodes, cells, kind, node_sets, face_sets, regions))
        return mesh

    @cached_property
    def _surface(self) -> Surface:
        return surface(self.blocks, self.node_count)

    @cached_property
    def _volumes(self) -> FloatArray:
        volumes = [cell_volumes(self.nodes, cells, kind) for kind, cells in self.blocks]
        return checks.read_only(volumes[0] if len(volumes) == 1 else np.concatenate(volumes))

    def _known(self, names: str | Iterable[str], *known: Mapping[str, Any], remedy: Callable[[], str]) -> list[str]:
        """Return names as a list; known: sets, of which one must have each. Raises `InputError` with the remedy."""
        try:
            wanted = [names] if isinstance(names, str) else list(names)
        except TypeError as error:
            raise InputError("set", names, remedy()) from error
        if not wanted:
            raise InputError("set", names, remedy())
        for name in wanted:
            if not isinstance(name, str) or not any(name in sets for sets in known):
                raise InputError("set", name, hint(name, list(dict.fromkeys(chain(*known)))) + remedy())
        return wanted

    def _known_surfaces(self, names: str | Iterable[str]) -> list[str]:
        def remedy() -> str:
            known = ", ".join(dict.fromkeys([*self.face_sets, *self.node_sets]))
            return (
                f"use one of the sets of this mesh: {known}"
                if known
                else f'{NO_SETS}; contact="auto" or "all" needs none'
            )

        return self._known(names, self.face_sets, self.node_sets, remedy=remedy)

    def _faces_of_one(self, name: str) -> IntArray:
        skin = self._surface
        if name in self.face_sets:
            place = skin.find(self.face_sets[name], self.node_count)
            faces = place[place >= 0]
        else:
            inside = np.zeros(self.node_count, dtype=bool)
            inside[self.node_sets[name]] = True
            faces = np.flatnonzero(inside[skin.faces].all(axis=1))
        if len(faces) == 0:
            raise InputError("set", name, "holds no complete face of the boundary; name a set on the surface")
        return faces

    def _moved(self, name: str, value: Any, nodes: FloatArray) -> Mesh:
        """Return the cells at new positions; shapes are checked again only if rounding can have damaged them."""
        mesh = Mesh.trusted(nodes, self.cells, self.kind, self.node_sets, self.face_sets, self.cell_sets)
        mesh.__dict__["_surface"] = self._surface
        if not mesh.keeps_shape:
            try:
                checks.check_shapes(checks.checked_nodes(nodes), self.blocks)
            except InputError as error:
                raise InputError(name, value, "cells lose their shape in rounding; stay nearer the origin") from error
        return mesh


def contents(
    nodes: FloatArray,
    cells: IntArray,
    kind: str,
    node_sets: Mapping[str, IntArray],
    face_sets: Mapping[str, IntArray],
    cell_sets: Mapping[str, IntArray],
) -> dict[str, Any]:
    """Return what a mesh keeps of its arrays and sets, by name."""
    sets = {"node_sets": node_sets, "face_sets": face_sets, "cell_sets": cell_sets}
    sets = {name: MappingProxyType(dict(given)) for name, given in sets.items()}
    return {"nodes": nodes, "cells": cells, "kind": kind, **sets}
