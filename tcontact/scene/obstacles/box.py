"""The rigid rectangular block."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...base import validate
from ...base.errors import InputError
from ...kernels.lanes import LEVEL
from .base import Obstacle, unit_or


@dataclass(frozen=True, eq=False)
class Box(Obstacle):
    """A solid rigid block.

    center: [m], the point it turns about; size: full lengths along its own axes [3] [m] > 0; axes: rotation matrix
    whose rows are these axes in the world, None for x, y, z.
    The gap is the exact distance; the normal at an edge or a corner comes from the nearest point of the surface,
    inside the block from the nearest face. In explicit steps a node that a step would take into the block is held by
    the face through which it came, and slides over the seam to a block or plane of the same height. Put the edges of a
    punch between lines of nodes: a node that begins on an edge slips past it as soon as the body bulges, and the force
    lacks the nodes under the edges. inertia: three moments are about `axes`. Raises `InputError`.
    """

    center: Any = (0.0, 0.0, 0.0)
    size: Any = (1.0, 1.0, 1.0)
    axes: Any = None
    shape: ClassVar[str] = "box"

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "center", validate.vector("Box.center", self.center))
        object.__setattr__(self, "size", validate.vector("Box.size", self.size))
        if not (self.size > 0.0).all():
            raise InputError("Box.size", self.size.tolist(), "give three lengths greater than 0")
        if self.axes is not None:
            object.__setattr__(self, "axes", validate.floats("Box.axes", self.axes, (3, 3)))
            if np.abs(self.axes @ self.axes.T - np.eye(3)).max() > 1e-9 or np.linalg.det(self.axes) < 0.0:
                raise InputError("Box.axes", self.axes.tolist(), "give orthogonal unit rows that are right-handed")
        if self.free:
            self.inertia_about_center()

    def solid_inertia(self) -> np.ndarray | None:
        """Return m (b^2 + c^2)/12 about each of its axes."""
        squares = self.size**2
        return None if self.mass is None else self.mass / 12.0 * (squares.sum() - squares)

    @property
    def reference(self) -> np.ndarray:
        """The centre [3] [m]."""
        return np.asarray(self.center)

    @property
    def frame(self) -> np.ndarray:
        """The axes given [3, 3], in rows."""
        return np.eye(3) if self.axes is None else np.asarray(self.axes)

    @property
    def parameters(self) -> tuple[float, ...]:
        """Half sizes [m]."""
        return tuple(float(length) / 2.0 for length in self.size)

    def local(self, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return gap [n] [m] and unit normal [n, 3] at local coordinates [n, 3]."""
        beyond = np.abs(positions) - np.array(self.parameters)
        side = np.where(positions < 0.0, -1.0, 1.0)
        away, outward = unit_or(side * np.maximum(beyond, 0.0), np.zeros(3))
        nearest = np.argmax(beyond, axis=1)
        rows = np.arange(len(positions))
        inward = np.zeros_like(beyond)
        inward[rows, nearest] = side[rows, nearest]
        outside = away > 0.0
        return np.where(outside, away, beyond[rows, nearest]), np.where(outside[:, None], outward, inward)

    def normals_at(self, positions: np.ndarray) -> np.ndarray:
        """Return the unit normals [n, m, 3] as for all obstacles; on an edge or a corner those of all its faces."""
        normals = super().normals_at(positions)
        place = self._local_coordinates(positions)
        beyond, near = np.abs(place) - np.array(self.parameters), LEVEL * max(self.parameters)
        level = np.abs(beyond) <= near
        on_edge = (beyond.max(axis=1) <= near) & (level.sum(axis=1) > 1)
        if not on_edge.any():
            return normals
        faces = np.where(level, np.where(place < 0.0, -1.0, 1.0), 0.0)[:, :, None] * self.frame
        first = np.concatenate([normals, np.zeros((len(normals), 2, 3))], axis=1)
        return np.where(on_edge[:, None, None], faces, first)
