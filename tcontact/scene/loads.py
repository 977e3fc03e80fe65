"""Loads on the surface of a body: pressure that follows the faces, traction and force."""

from __future__ import annotations

import inspect
import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base import validate
from ..base.errors import FunctionError, InputError
from ..mesh.mesh import Mesh
from .call_record import CallRecord
from .periodic import Images, repeated_faces
from .time_functions import TimeFunction

COMPONENTS = {"pressure": 1, "traction": 3, "force": 3}  # of a value
PLACES = ("x", "position", "positions", "point", "points")  # names of a first parameter that is the place
TIMES = ("t", "time")  # names of a second parameter that is the time


@dataclass(frozen=True, eq=False)
class Load:
    """A load on a named set of a body: one of pressure, traction and force.

    set: name of a face set, for a force also of a node set; pressure [Pa]: pushes into the body, along the normals of
    the deformed faces, on their present areas; traction [Pa]: three numbers, force per area at rest, in a fixed
    direction; force [N]: three numbers, the total on the set, shared over faces by their areas at rest and over nodes
    equally, of a periodic body over those that are not repeated. Each is constant or a function of time f(t). A
    pressure or traction may also be a function of time and place, f(t, x) -> [k] or [k, 3], with x [k, 3] [m] the
    centres at rest of the k faces of the set; its parameters may stand in the other order if the first is called x,
    position(s) or point(s), or the second t or time. A force may also be an own one,
    f(positions, velocities, time) -> [k, 3] [N], a force on every node of the set (of a periodic body on those that are
    not repeated) for their present positions [k, 3] and velocities [k, 3], those of half a step before: it is called in
    every step, in a launch of its own, which is slow for small bodies, and a few times before the run. Parameters with
    a default are left out of count. Several loads on one set add up. The faces of a set are those on the surface.
    Raises `InputError`.
    """

    set: str
    pressure: Any = None
    traction: Any = None
    force: Any = None

    def __post_init__(self) -> None:
        if not isinstance(self.set, str):
            raise InputError("Load.set", self.set, "give the name of a face or node set")
        given = [name for name in COMPONENTS if getattr(self, name) is not None]
        if len(given) != 1:
            remedy = "give one of pressure, traction and force; several loads on one set add up"
            raise InputError("Load", given or None, remedy)
        field = f"Load.{self.kind}"
        if callable(self.value):
            counts = (1, 3) if self.kind == "force" else (1, 2)
            if len(self._parameters) not in counts:
                other = "(positions, velocities, time)" if self.kind == "force" else "(t, x)"
                raise InputError(field, self.value, f"give a function of (t), or of {other}")
        elif self.kind == "pressure":
            validate.keep(self, field)
        else:
            object.__setattr__(self, self.kind, validate.vector(field, self.value))

    @property
    def kind(self) -> str:
        """Return "pressure", "traction" or "force"."""
        return next(name for name in COMPONENTS if getattr(self, name) is not None)

    @property
    def value(self) -> Any:
        """Return the pressure, traction or force as it was given."""
        return getattr(self, self.kind)

    @property
    def varies(self) -> bool:
        """Return whether it is a function."""
        return callable(self.value)

    @property
    def placed(self) -> bool:
        """Return whether it is a function of time and place."""
        return self.varies and len(self._parameters) == 2

    @property
    def own(self) -> bool:
        """Return whether it is a force that depends on positions and velocities."""
        return self.varies and len(self._parameters) == 3

    @property
    def _parameters(self) -> tuple[str, ...]:
        try:
            found = inspect.signature(self.value).parameters.values()
        except (TypeError, ValueError):  # functions of C do not tell
            return ("t",)
        positional = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
        needed = [one.name for one in found if one.kind in positional and one.default is one.empty]
        return tuple(needed) or ("t",)

    def faces(self, mesh: Mesh) -> np.ndarray:
        """Return its faces [k, 4], outward; a triangle has its last corner twice. Raises `InputError` for node sets."""
        if self.set in mesh.node_sets and self.set not in mesh.face_sets:
            remedy = f"is a set of nodes, and a {self.kind} acts on faces: name a face set, or give force="
            raise InputError("Load.set", self.set, remedy)
        found = self._within(lambda: mesh.faces_of(self.set))
        return found if found.shape[1] == 4 else found[:, [0, 1, 2, 2]]

    def on_nodes(self, mesh: Mesh) -> bool:
        """Return whether it is shared over nodes, not over faces."""
        return self.own or (self.kind == "force" and self.set not in mesh.face_sets)

    def nodes(self, mesh: Mesh, images: Images | None = None) -> np.ndarray:
        """Return the nodes [k] of its set; masters if there are images. Raises `InputError`."""
        found = self._within(lambda: mesh.nodes_of(self.set))
        if not len(found):
            raise InputError("Load.set", self.set, "holds no nodes; name a set that does")
        return found if images is None else images.once(found)

    def _within(self, find: Callable[[], np.ndarray]) -> np.ndarray:
        try:
            return find()
        except InputError as error:
            raise InputError("Load.set", self.set, error.remedy) from error

    def check(self, mesh: Mesh, images: Images | None, velocity: np.ndarray) -> None:
        """Check set and functions on a body, these at t = 0; velocity [n, 3]: at the start. Raises `InputError`."""
        if self.on_nodes(mesh):
            nodes = self.nodes(mesh, images)
        elif repeated_faces(images, mesh, self.faces(mesh)).any() if images is not None else not len(self.faces(mesh)):
            raise InputError("Load.set", self.set, "it has faces on periodic sides, which are no surface")
        if self.own:
            self.own_force(mesh.nodes_at(nodes), velocity[nodes], 0.0)
        else:
            self.function(mesh).at(np.zeros(1))

    def function(self, mesh: Mesh) -> TimeFunction:
        """Return its values as a function of time: one set of components, or one for each face."""
        field, components = f"Load.{self.kind} on {self.set!r}", COMPONENTS[self.kind]
        if not self.placed:
            return TimeFunction(field, self.value, components)
        first, second = self._parameters
        swapped = first in PLACES or second in TIMES
        return PlaceFunction(field, self.value, mesh.nodes_at(self.faces(mesh)), components, swapped)

    def own_force(self, positions: np.ndarray, velocities: np.ndarray, time: float) -> np.ndarray:
        """Call an own force; returns [k, 3] [N]. Raises `FunctionError`."""
        field = f"Load.force on {self.set!r}"
        try:
            given = np.array(self.value(positions, velocities, time), dtype=np.float64)
        except Exception as error:
            raise FunctionError(field, self.value, f"the callable failed at t = {time:.9g}: {error}") from error
        if given.shape != positions.shape or not np.isfinite(given).all():
            got = np.array2string(given, threshold=6)
            remedy = f"it gave {got} at t = {time:.9g}; return finite numbers of shape {list(positions.shape)}"
            raise FunctionError(field, self.value, remedy)
        return given

    def by_time(self, mesh: Mesh, images: Images | None) -> Load:
        """Return the load with a function of time alone, whose values tell functions of other parameters apart."""
        if self.placed:
            function = self.function(mesh)
            changed: dict[str, Any] = {self.kind: lambda t: checksum(function.at(np.array([t])))}
            return replace(self, **changed)
        if self.own:
            nodes = mesh.nodes_at(self.nodes(mesh, images))
            return replace(self, force=lambda t: checksum(self.own_force(nodes, np.zeros_like(nodes), t)))
        return self


class PlaceFunction(TimeFunction):
    """A function of time and place, at the centres of faces with corners [k, 4, 3] [m]; swapped: place comes first.

    Its values at a time are those of all faces one after the other; the record keeps their checksums.
    """

    def __init__(self, field: str, value: Any, corners: np.ndarray, components: int, swapped: bool) -> None:
        super().__init__(field, value, len(corners) * components)
        self.record = CallRecord(1)
        triangles = (corners[:, 2] == corners[:, 3]).all(axis=1)[:, None]
        self.points = np.where(triangles, corners[:, :3].mean(axis=1), corners.mean(axis=1))
        self.points.setflags(write=False)
        self.shape = (len(corners),) if components == 1 else (len(corners), components)
        self.swapped = swapped

    def _given(self, time: float) -> Any:
        arguments = (self.points, time) if self.swapped else (time, self.points)
        given = np.asarray(self.value(*arguments))
        if given.shape != self.shape:
            raise ValueError(f"it gave an array of shape {list(given.shape)}; return {list(self.shape)}")
        return given.reshape(-1)

    def _kept(self, values: np.ndarray) -> np.ndarray:
        return np.array([checksum(row) for row in values]).reshape(-1, 1)


def checksum(values: np.ndarray) -> float:
    """Return a number that tells arrays apart."""
    return float(zlib.crc32(np.ascontiguousarray(values, dtype=np.float64).tobytes()))
