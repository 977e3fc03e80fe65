"""Rigid bodies that move freely: checked mass and inertia, principal axes, and parts of bodies that are rigid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import validate
from ..base.column_names import column_word
from ..base.errors import InputError

ROUNDING = 1e-9  # relative asymmetry of an inertia matrix, and excess of a moment over the sum of the others


def checked_inertia(field: str, value: Any) -> Any:
    """Return a moment of inertia as a number, three principal moments [3] or a matrix [3, 3] [kg m^2].

    Raises `InputError` for a matrix that is not symmetric, for moments that are not positive and for those that no
    body has: none exceeds the sum of the two others.
    """
    shape = validate.shape_of(field, value, "give a number, three principal moments or a symmetric matrix [3, 3]")
    if shape == ():
        return validate.number(field, value, low=0.0)
    given = validate.floats(field, value, (3,) if len(shape) == 1 else (3, 3))
    matrix = np.diag(given) if len(shape) == 1 else given
    if np.abs(matrix - matrix.T).max() > ROUNDING * np.abs(matrix).max():
        raise InputError(field, value, "give a symmetric matrix")
    moments = np.linalg.eigvalsh(matrix)
    if not moments[0] > 0.0:
        raise InputError(field, value, "give moments of inertia greater than 0 about every axis")
    if moments[2] > (moments[0] + moments[1]) * (1.0 + ROUNDING):
        raise InputError(field, value, "no body has it: a moment of inertia is at most the sum of the two others")
    return given


def inertia_matrix(given: Any, frame: np.ndarray) -> np.ndarray:
    """Return a checked inertia as a matrix [3, 3] in the world; frame: the axes (rows) of principal moments."""
    if np.ndim(given) == 2:
        return np.asarray(given)
    return np.asarray(frame.T @ np.diag(np.broadcast_to(given, 3)) @ frame)


def principal(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return principal moments [3] and right-handed principal axes (rows) [3, 3] of an inertia matrix.

    A matrix that is diagonal to rounding keeps the axes of the world, so that such bodies turn without their errors.
    """
    if np.abs(matrix - np.diag(np.diagonal(matrix))).max() <= 1e-14 * np.abs(matrix).max():
        return np.diagonal(matrix).copy(), np.eye(3)
    moments, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
    axes = vectors.T
    axes[2] = np.cross(axes[0], axes[1])
    return moments, axes


def point_inertia(masses: np.ndarray, arms: np.ndarray) -> np.ndarray:
    """Return the inertia matrix [3, 3] of point masses [n] at arms [n, 3] about the point of these."""
    squares = np.einsum("ni,ni->n", arms, arms)
    return np.asarray(np.sum(masses * squares) * np.eye(3) - np.einsum("n,ni,nj->ij", masses, arms, arms))


@dataclass(frozen=True, eq=False)
class RigidPart:
    """Part of a body that is rigid: the nodes of a face or node set keep their shape and move together.

    set: its name; mass [kg] of the rigid part itself, to which the masses of its nodes are added (0: these alone; None
    with `driven`); inertia [kg m^2] of that mass about its centre of mass: a number, three moments about x, y, z, or a
    symmetric matrix [3, 3], in the axes of the world at the start; None: that of the mass spread over the nodes as
    their own masses are; center [m]: its centre of mass at the start, None for that of the nodes; velocity [m/s] of the
    centre of mass and angular_velocity [rad/s] at the start, None: the rigid motion with the momentum and angular
    momentum of the nodes. driven: the motion is prescribed: velocity of `center` and angular_velocity are vectors or
    functions of time, None for 0, and the forces that it takes are those of a support.
    The nodes must not be contact nodes nor have supports. Raises `InputError`.
    """

    set: str
    mass: float | None = None
    inertia: Any = None
    center: Any = None
    velocity: Any = None
    angular_velocity: Any = None
    driven: bool = False

    def __post_init__(self) -> None:
        put = object.__setattr__
        if not isinstance(self.set, str):
            raise InputError("RigidPart.set", self.set, "give the name of a node or face set")
        validate.flag("RigidPart.driven", self.driven)
        if self.driven:
            for name in ("mass", "inertia"):
                if getattr(self, name) is not None:
                    raise InputError(f"RigidPart.{name}", getattr(self, name), "leave it out of a driven part")
        elif self.mass is None:
            raise InputError("RigidPart.mass", None, "give the mass [kg] beside that of the nodes, or driven=True")
        else:
            put(self, "mass", validate.number("RigidPart.mass", self.mass, low=0.0, strict=False))
        if self.inertia is not None:
            if self.mass == 0.0:
                raise InputError("RigidPart.inertia", self.inertia, "leave it out without a mass")
            put(self, "inertia", checked_inertia("RigidPart.inertia", self.inertia))
        if self.center is not None:
            put(self, "center", validate.vector("RigidPart.center", self.center))
        for name in ("velocity", "angular_velocity"):
            value = getattr(self, name)
            if callable(value):
                if not self.driven:
                    remedy = "a part that moves freely has an initial value; give a vector, or driven=True"
                    raise InputError(f"RigidPart.{name}", value, remedy)
            elif value is not None:
                put(self, name, validate.vector(f"RigidPart.{name}", value))

    @property
    def name(self) -> str:
        """Its set, for messages."""
        return self.set

    def column(self, body: str) -> str:
        """Return its name in the history; body: that of its body."""
        return column_word(f"{body}-{self.set}")

    @property
    def reference(self) -> Any:
        """The point [3] [m] that moves with `velocity`."""
        return self.center

    @property
    def frame(self) -> np.ndarray:
        """Its axes [3, 3] at the start, those of the world."""
        return np.eye(3)
