"""The rigid obstacle of any shape: a signed distance sampled on a regular grid."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from ...base import stages, validate
from ...base.errors import InputError
from .base import Obstacle, unit_or
from .distance_check import check_distance
from .interpolation import interpolate
from .surface import surface_arrays
from .surface_distance import sample_surface
from .thin_parts import check_thickness

NODES = 4  # minimum number of nodes along an axis
MAXIMUM_NODES = 2**26  # maximum number of nodes: 2 GiB of distance and gradient


@dataclass(frozen=True, eq=False)
class Sdf(Obstacle):
    """A rigid obstacle given by its signed distance, positive outside, on a grid of nodes.

    distance [m]: array [nx, ny, nz] or callable(points [n, 3]) -> [n]; gradient: array [nx, ny, nz, 3], callable
    (points [n, 3]) -> [n, 3] or None for central differences; origin: node [0, 0, 0] of the grid in the world [m];
    spacing: between nodes, the same along all axes [m] > 0; nodes: along x, y, z, only needed for a callable;
    center: the point it turns about [m], None for the middle of the grid; surface: (points [k, 3], triangles [m, 3])
    for pictures, or None.
    Distance and gradient are interpolated trilinearly, the gradient then normalised; beyond the grid both
    continue linearly from its nearest point: a lower bound of the distance to a body within the grid, and positive.
    Implicit schemes interpolate the distance cubically, with the contact force along its gradient (`cubic.py`). A part
    thinner than the spacing may lie between the nodes and be lost: only `from_surface` can detect that. Raises
    `InputError`, also for fewer than four nodes along an axis and for numbers that are not finite.
    """

    distance: Any = None
    gradient: Any = None
    origin: Any = (0.0, 0.0, 0.0)
    spacing: float = 0.0
    nodes: Any = None
    center: Any = None
    surface: Any = field(default=None, repr=False, kw_only=True)
    shape: ClassVar[str] = "sdf"

    def __post_init__(self) -> None:
        super().__post_init__()
        put = object.__setattr__
        put(self, "origin", validate.vector("Sdf.origin", self.origin))
        put(self, "spacing", validate.number("Sdf.spacing", self.spacing, low=0.0))
        count = self._count()
        put(self, "nodes", count)
        if self.center is None:
            put(self, "center", self.origin + 0.5 * self.spacing * (np.array(count) - 1))
        put(self, "center", validate.vector("Sdf.center", self.center))
        if self.surface is not None:
            put(self, "surface", surface_arrays(self.surface))
        if self.free:
            self.inertia_about_center()
        lines = [start + self.spacing * np.arange(n) for start, n in zip(self.origin, count, strict=True)]
        points = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
        grid = np.empty((*count, 4))
        grid[..., 0] = _sampled("Sdf.distance", self.distance, points, count)
        if self.gradient is None:
            for axis in range(3):
                grid[..., 1 + axis] = np.gradient(grid[..., 0], self.spacing, axis=axis, edge_order=2)
        else:
            grid[..., 1:] = _sampled("Sdf.gradient", self.gradient, points, (*count, 3))
        grid.setflags(write=False)
        put(self, "_grid", grid)

    def __getstate__(self) -> dict[str, Any]:
        """Return what copies and other processes make the obstacle of: values at the nodes, no functions of them."""
        state = dict(self.__dict__)
        if callable(self.distance) or callable(self.gradient):
            state |= {"distance": self.grid[..., 0], "gradient": self.grid[..., 1:]}
        return state

    def _count(self) -> tuple[int, int, int]:
        """Return the number of nodes along x, y, z."""
        count, remedy = self.nodes, f"give three whole numbers of at least {NODES}: the nodes along x, y, z"
        if not callable(self.distance):
            sampled = validate.shape_of("Sdf.distance", self.distance, "give a callable, or an array [nx, ny, nz]")
            if len(sampled) != 3 or min(sampled) < NODES:
                remedy = f"give a callable, or an array [nx, ny, nz] of at least {NODES} nodes along each axis"
                raise InputError("Sdf.distance", self.distance, remedy)
            if count is not None and (validate.shape_of("Sdf.nodes", count, remedy) != (3,) or tuple(count) != sampled):
                raise InputError("Sdf.nodes", count, f"leave it out, or give {sampled} as the distance has it")
            count = sampled
        if validate.shape_of("Sdf.nodes", count, remedy) != (3,):
            raise InputError("Sdf.nodes", count, remedy)
        x, y, z = (validate.whole("Sdf.nodes", n, NODES) for n in count)
        if x * y * z > MAXIMUM_NODES:
            raise InputError("Sdf.nodes", (x, y, z), f"more than {MAXIMUM_NODES} nodes; take a larger spacing")
        return x, y, z

    @classmethod
    def from_surface(
        cls,
        surface: str | os.PathLike[str] | tuple[Any, Any],
        cells: int = 64,
        margin: float | None = None,
        *,
        scale: float = 1.0,
        **options: Any,
    ) -> Sdf:
        """Make an obstacle of the solid within a closed surface of triangles.

        surface: path of an STL, OBJ or PLY file, or (points [k, 3] [m], triangles [m, 3]); cells: of the grid along
        the longest side of the solid; margin: of the grid around the solid [m], None for four cells; scale: factor
        on the coordinates, 1e-3 for millimetres; options: name, velocity, angular_velocity, center, mass, inertia.
        Raises `InputError` for a file that cannot be read, for a surface that is open, or oriented both ways, and where
        a part is too thin for the grid (`thin_parts.py`). Edges are rounded by about a cell, slots narrower than a cell
        are closed.
        """
        stages.say("sampling a surface")
        distance, gradient, origin, spacing, triangles = sample_surface(surface, cells, margin, scale)
        made = cls(distance, gradient, origin, spacing, surface=triangles, **options)
        check_thickness(triangles, made.grid, made.origin, made.spacing, cells)
        return made

    @classmethod
    def from_function(cls, distance: Any, low: Any, high: Any, cells: int = 64, **options: Any) -> Sdf:
        """Make an obstacle of any shape from a function that gives its signed distance.

        distance: callable(points [n, 3]) -> [n] [m], positive outside; low, high: corners [3] [m] of the box in which
        it is sampled; cells: of the grid along the longest side; options: those of `Sdf` but the grid, such as gradient
        (a callable too), name, velocity and center.

            def torus(points):
                x, y, z = points.T
                return np.hypot(np.hypot(x, y) - 0.3, z) - 0.1

            ring = tc.Sdf.from_function(torus, (-0.5, -0.5, -0.2), (0.5, 0.5, 0.2), cells=80)

        Only values at the nodes count: scene files and pickles hold these, not the function. The box holds the solid
        with a few cells around it; where the solid ends at the box it goes on linearly. The error falls with the square
        of the spacing, but at edges, which are rounded by about a cell, and parts thinner than the spacing may be lost.
        Near its surface the gradient of a distance has length 1: a function that has another one gives gaps that are
        too large or too small by that factor, of which a `RuntimeWarning` tells. Raises `InputError` for values that
        are no finite numbers, and if the box has no node inside the solid or none outside.
        """
        validate.whole("Sdf.cells", cells, NODES - 1)
        low, high = validate.vector("Sdf.low", low), validate.vector("Sdf.high", high)
        if not (high > low).all():
            raise InputError("Sdf.high", high.tolist(), f"every component must be above that of low = {low.tolist()}")
        if not callable(distance):
            raise InputError("Sdf.distance", distance, "give a function of points [n, 3] that returns distances [n]")
        spacing = float((high - low).max()) / cells
        nodes = np.maximum(np.ceil((high - low) / spacing - 1e-9).astype(np.int64) + 1, NODES)
        origin = 0.5 * (low + high) - 0.5 * spacing * (nodes - 1)
        made = cls(distance, origin=origin, spacing=spacing, nodes=nodes.tolist(), **options)
        check_distance(distance, made.grid, spacing)
        return made

    @property
    def reference(self) -> np.ndarray:
        """Reference point [3] [m], about which it turns."""
        return np.asarray(self.center)

    @property
    def parameters(self) -> tuple[float, ...]:
        """Node [0, 0, 0] in local coordinates (3) [m]; spacing [m]; nodes along x, y, z."""
        start = self.origin - self.center
        return (*(float(x) for x in start), float(self.spacing), *(float(n) for n in self.nodes))

    @property
    def grid(self) -> np.ndarray:
        """Distance [m] and its gradient at the nodes [nx, ny, nz, 4]."""
        return np.asarray(self._grid)  # type: ignore[attr-defined]

    def local(self, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return gap [n] [m] and unit normal [n, 3] at local coordinates [n, 3]."""
        gap, gradient = interpolate(self.grid, np.array(self.parameters[:3]), self.spacing, positions)
        return gap, unit_or(gradient, np.array([0.0, 0.0, 1.0]))[1]


def _sampled(name: str, given: Any, points: np.ndarray, wanted: tuple[int, ...]) -> np.ndarray:
    """Return values at the nodes of the grid, from an array or a callable."""
    value = given
    if isinstance(value, Callable):  # type: ignore[arg-type]
        try:
            value = np.asarray(value(points), dtype=np.float64)
        except Exception as error:
            raise InputError(name, given, f"the callable failed: {error}") from error
        if value.shape != (len(points), *wanted[3:]):
            asked = [len(points), *wanted[3:]]
            raise InputError(name, given, f"it returned shape {list(value.shape)} for {asked[0]} points; give {asked}")
        value = value.reshape(wanted)
    return validate.floats(name, value, wanted)
