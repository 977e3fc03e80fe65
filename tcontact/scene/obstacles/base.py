"""The base class of rigid obstacles: a place, a frame, a prescribed motion and a gap."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...base import validate
from ...base.errors import InputError
from ...friction_layer.metals import checked_metal
from ..friction_models import FrictionModel
from ..rigid import checked_inertia, inertia_matrix


@dataclass(frozen=True, eq=False, kw_only=True)
class Obstacle:
    """A rigid obstacle that rests, moves as prescribed or moves freely; use one of its shapes (`Plane`, ...).

    name: for messages and results, or None; velocity [m/s] of its reference point and angular_velocity [rad/s], in
    world axes about that point: a vector, a callable(t) -> [3], or None for an obstacle at rest. A callable is called
    from t = 0 until up to one step after the duration, where the last row lies. metal: a `friction_layer.Metal`, in
    which the `FrictionLayer` of what slides on the obstacle has a second side: conduction then divides the heat
    between both. None: the layer has one side, and its heat_share divides it. Other friction does not use it.
    friction: the model on this obstacle in place of `Scene.friction` (`NoFriction`: none); None takes `Scene.friction`.
    mass [kg]: the obstacle moves freely, under contact forces, friction and gravity; its reference point is then its
    centre of mass, and velocity and angular_velocity, vectors, are those of the start. None: it moves as prescribed.
    inertia [kg m^2] of a free one about its centre of mass: a number, three moments about its own axes (of a plane or
    cylinder the third one is about its normal or axis, of a block they are about `Box.axes`), or a symmetric matrix
    [3, 3] in the axes of the world at t = 0; None: that of the homogeneous solid (balls and blocks only).
    Obstacles do not touch each other, whether they move or not.
    Gaps are signed distances, open positive; normals point from the obstacle into the body.
    Raises `InputError`.
    """

    name: str | None = None
    velocity: Any = None
    angular_velocity: Any = None
    metal: Any = None
    friction: FrictionModel | None = None
    mass: float | None = None
    inertia: Any = None
    shape: ClassVar[str] = ""

    def __post_init__(self) -> None:
        kind = type(self).__name__
        if self.name is not None:
            if not isinstance(self.name, str) or not self.name:
                raise InputError(f"{kind}.name", self.name, "give a non-empty string or None")
            if "/" in self.name or not self.name.isprintable():  # columns of history and result files have the name
                raise InputError(f"{kind}.name", self.name, "leave out '/' and characters that cannot be printed")
        checked_metal(f"{kind}.metal", self.metal)
        if self.friction is not None and not isinstance(self.friction, FrictionModel):
            remedy = "give a model such as tcontact.Coulomb(0.3) or NoFriction(), or None for Scene.friction"
            raise InputError(f"{kind}.friction", self.friction, remedy)
        for field in ("velocity", "angular_velocity"):
            value = getattr(self, field)
            if value is not None and not isinstance(value, Callable):  # type: ignore[arg-type]
                object.__setattr__(self, field, validate.vector(f"{kind}.{field}", value))
        if self.mass is not None:
            object.__setattr__(self, "mass", validate.number(f"{kind}.mass", self.mass, low=0.0))
            for field in ("velocity", "angular_velocity"):
                if callable(getattr(self, field)):
                    remedy = "with a mass it is the initial value: give a vector, or leave the mass out"
                    raise InputError(f"{kind}.{field}", getattr(self, field), remedy)
        if self.inertia is not None:
            if self.mass is None:
                raise InputError(
                    f"{kind}.inertia", self.inertia, "give a mass too, with which the obstacle moves freely"
                )
            object.__setattr__(self, "inertia", checked_inertia(f"{kind}.inertia", self.inertia))

    @property
    def free(self) -> bool:
        """Return whether it moves freely, with a mass of its own."""
        return self.mass is not None

    def inertia_about_center(self) -> np.ndarray:
        """Return the inertia [3, 3] [kg m^2] of a free obstacle in the world at t = 0. Raises `InputError`."""
        with np.errstate(over="ignore", invalid="ignore"):  # refused below
            given = self.solid_inertia() if self.inertia is None else self.inertia
        if given is None:
            remedy = "only balls and blocks have one of their own; give it, about the reference point"
            raise InputError(f"{type(self).__name__}.inertia", None, remedy)
        if not np.isfinite(given).all():
            remedy = "its moment of inertia is too large for a number; look at the units of mass and size"
            raise InputError(f"{type(self).__name__}.mass", self.mass, remedy)
        return inertia_matrix(given, self.frame)

    def solid_inertia(self) -> Any:
        """Return the inertia of the homogeneous solid shape as `inertia` gives it; None without one."""
        return None

    @property
    def moves(self) -> bool:
        """Return whether it moves freely, or a velocity or angular velocity other than zero is prescribed."""
        return self.turns or _not_zero(self.velocity)

    @property
    def turns(self) -> bool:
        """Return whether it moves freely, or an angular velocity other than zero is prescribed."""
        return self.free or _not_zero(self.angular_velocity)

    @property
    def reference(self) -> np.ndarray:
        """The point [3] that moves with `velocity`, at t = 0 [m]."""
        raise NotImplementedError

    @property
    def frame(self) -> np.ndarray:
        """Local axes in the world at t = 0, rows [3, 3]."""
        return np.eye(3)

    @property
    def parameters(self) -> tuple[float, ...]:
        """Numbers of the shape in local coordinates, at most eight."""
        return ()

    @property
    def grid(self) -> np.ndarray | None:
        """Sampled distance and gradient [nx, ny, nz, 4], or None for shapes with a formula."""
        return None

    def local(self, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return gap [n] [m] and unit normal [n, 3] at local coordinates [n, 3]."""
        raise NotImplementedError

    def gap(self, positions: np.ndarray) -> np.ndarray:
        """Return the signed distance [n] [m] of positions [n, 3] at t = 0, open positive."""
        return self.local(self._local_coordinates(positions))[0]

    def normal_at(self, positions: np.ndarray) -> np.ndarray:
        """Return the unit normal [n, 3] from the obstacle into the body at positions [n, 3] at t = 0."""
        return np.asarray(self.local(self._local_coordinates(positions))[1] @ self.frame)

    def normals_at(self, positions: np.ndarray) -> np.ndarray:
        """Return the unit normals [n, m, 3] at positions [n, 3] at t = 0: several at an edge, then rows of zeros."""
        return self.normal_at(positions)[:, None]

    def _local_coordinates(self, positions: np.ndarray) -> np.ndarray:
        return np.asarray((np.asarray(positions, dtype=np.float64) - self.reference) @ self.frame.T)


def _not_zero(rate: Any) -> bool:
    return callable(rate) or (rate is not None and bool(rate.any()))


def direction(field: str, value: Any, remedy: str) -> np.ndarray:
    """Return a vector of non-zero length as a read-only unit vector [3]."""
    given = validate.vector(field, value)
    largest = float(np.abs(given).max())
    if largest == 0.0:
        raise InputError(field, value, remedy)
    if not 1e-100 < largest < 1e100:  # its squares would overflow
        given = given / largest
    length = float(np.linalg.norm(given))
    # a unit vector stays as it is, to the bit, so that a copied or reloaded vector is normalised only once
    unit = np.array(given) if abs(length - 1.0) <= 4.0 * np.finfo(float).eps else np.asarray(given / length)
    unit.setflags(write=False)
    return unit


def axes_around(third: np.ndarray) -> np.ndarray:
    """Return right-handed unit axes in rows [3, 3], the third one given."""
    first = np.eye(3)[np.argmin(np.abs(third))]
    first = first - third * (first @ third)
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(third, first), third])


def unit_or(vectors: np.ndarray, spare: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return lengths [n] and unit vectors [n, 3]; `spare` [3] where the length is zero."""
    length = np.linalg.norm(vectors, axis=1)
    safe = np.where(length > 0.0, length, 1.0)
    return length, np.where(length[:, None] > 0.0, vectors / safe[:, None], spare)


def flag(field: str, value: Any) -> None:
    """Return True or False."""
    if not isinstance(value, (bool, np.bool_)):
        raise InputError(field, value, "give True or False")
