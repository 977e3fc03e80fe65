"""Point masses on sets of nodes, and springs with dashpots from a set to the ground, a point or another set."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..base import validate
from ..base.errors import InputError

SHORT = 1e-9  # length at the start over the size of the mesh below which a spring has no direction


@dataclass(frozen=True)
class PointMass:
    """A mass fixed to a set of nodes, in equal shares.

    set: name of a node or face set of the mesh; mass [kg] > 0: its sum over the nodes. In a periodic body a node with
    all its images has one share. Raises `InputError`.
    """

    set: str
    mass: float

    def __post_init__(self) -> None:
        _check_set("PointMass.set", self.set)
        validate.keep(self, "PointMass.mass", low=0.0)


@dataclass(frozen=True)
class Spring:
    """A linear spring with a dashpot from a set of nodes to the ground, a point or another set.

    It acts on the mean position of the nodes of the set; its force is shared equally by them, in a periodic body by a
    node and its images as one, which start at the mean of the places that the set names. set: name of a node or
    face set; stiffness [N/m]; damping [N s/m]; to: None = the ground, where the mean position starts; a point (x, y, z)
    [m]; the name of another set of the body; or ("body", "set") of another body. axes: letters out of "xyz" along which
    it acts on relative displacements, free of force at the start; None: "xyz" to the ground, otherwise along the line
    between both ends, with the force stiffness (length - rest_length); rest_length [m]: None = the length at the start.
    Raises `InputError`.
    """

    set: str
    stiffness: float
    damping: float = 0.0
    to: Any = None
    axes: str | None = None
    rest_length: float | None = None

    def __post_init__(self) -> None:
        _check_set("Spring.set", self.set)
        for field in ("stiffness", "damping"):
            validate.keep(self, f"Spring.{field}", low=0.0, strict=False)
        if self.stiffness == 0.0 and self.damping == 0.0:
            raise InputError("Spring.stiffness", self.stiffness, "the damping is 0 too; give one of the two")
        words = isinstance(self.to, (list, tuple)) and len(self.to) == 2 and all(isinstance(w, str) for w in self.to)
        if words:
            object.__setattr__(self, "to", tuple(self.to))
        elif self.to is not None and not isinstance(self.to, str):
            remedy = "give None, the name of a set, a pair of names ('body', 'set') or a point (x, y, z)"
            if validate.shape_of("Spring.to", self.to, remedy) != (3,):
                raise InputError("Spring.to", self.to, remedy)
            object.__setattr__(self, "to", tuple(validate.vector("Spring.to", self.to).tolist()))
        known = self.axes is None or (isinstance(self.axes, str) and self.axes and set(self.axes) <= set("xyz"))
        if not known or len(set(self.axes or "")) != len(self.axes or ""):
            raise InputError("Spring.axes", self.axes, "give distinct letters out of 'xyz', for example 'z' or 'xy'")
        if self.rest_length is not None:
            validate.keep(self, "Spring.rest_length", low=0.0, strict=False)
            if self.directions:
                remedy = "a spring along axes is free of force at the start; leave it out, or axes, and give to"
                raise InputError("Spring.rest_length", self.rest_length, remedy)

    @property
    def directions(self) -> str:
        """Return the axes along which it acts; empty for the line between its ends."""
        return self.axes or ("xyz" if self.to is None else "")


class End(NamedTuple):
    """An end of a spring: number of its body (None: fixed), its nodes [m], and its place [3] [m] in the mesh.

    Nodes of periodic bodies are masters; the place is that of the images which the set names.
    start [3] [m]: place at the start.
    """

    body: int | None
    nodes: np.ndarray
    place: np.ndarray
    start: np.ndarray


class SceneSpring(NamedTuple):
    """A spring of a scene with its name in messages and its ends."""

    label: str
    spring: Spring
    ends: tuple[End, End]

    @property
    def bodies(self) -> set[int]:
        """Return the numbers of the bodies at its ends."""
        return {end.body for end in self.ends if end.body is not None}

    @property
    def grounded(self) -> bool:
        """Return whether its second end is fixed."""
        return self.ends[1].body is None

    @property
    def rest(self) -> np.ndarray:
        """Return the vector between its ends [3] [m] at the start."""
        return self.ends[1].start - self.ends[0].start

    @property
    def rest_length(self) -> float:
        """Return the length [m] at which it has no force, along the line between its ends."""
        given = self.spring.rest_length
        return float(np.linalg.norm(self.rest)) if given is None else given


def springs_of(scene: Any) -> Iterator[SceneSpring]:
    """Yield the springs of all bodies. Raises `InputError` for unknown bodies and sets, and lines of length 0."""
    labels = {scene.label(at): at for at in range(len(scene.bodies))}
    for index, body in enumerate(scene.bodies):
        for number, spring in enumerate(body.springs):
            field = f"Scene.bodies[{index}].springs[{number}]"
            first = _end(scene, index, spring.set, f"{field}.set")
            other = spring.to
            if isinstance(other, str):
                second = _end(scene, index, other, f"{field}.to")
            elif other is None or isinstance(other[0], float):
                place = first.start if other is None else np.array(other)
                second = End(None, np.zeros(0, dtype=np.int64), place, place)
            else:
                if other[0] not in labels:
                    raise InputError(f"{field}.to", other, f"no such body; use one of {', '.join(labels)}")
                second = _end(scene, labels[other[0]], other[1], f"{field}.to")
            found = SceneSpring(f"{scene.label(index)}-{spring.set}", spring, (first, second))
            if not spring.directions and np.linalg.norm(found.rest) <= SHORT * body.mesh.size:
                remedy = "both ends start at one place, so that the line between them has no direction; give axes"
                raise InputError(f"{field}.axes", spring.axes, remedy)
            yield found


def with_spring_speeds(bodies: Sequence[Any], springs: Sequence[SceneSpring]) -> tuple[Any, ...]:
    """Return the bodies, those at springs with energy at the start with the speed [m/s] that it can give them."""
    result = list(bodies)
    at: list[list[SceneSpring]] = [[] for _ in bodies]
    for spring in springs:
        for index in spring.bodies if not spring.spring.directions else ():
            at[index].append(spring)
    for index, (body, own) in enumerate(zip(bodies, at, strict=True)):
        stretch = [(spring.spring.stiffness, np.linalg.norm(spring.rest) - spring.rest_length) for spring in own]
        twice = sum(stiffness * length**2 for stiffness, length in stretch)
        if twice > 0.0:
            result[index] = copy.copy(body)
            result[index].__dict__["spring_speed"] = float(np.sqrt(twice / body.mass))
    return tuple(result)


def _end(scene: Any, index: int, name: str, field: str) -> End:
    """Return the end of a spring at a set of a body. Raises `InputError` with the field that names the set."""
    body = scene.bodies[index]
    try:
        nodes, images = body.mesh.nodes_of(name), body.images
    except InputError as error:
        raise InputError(field, name, f"no such set of {scene.label(index)}; {error.remedy}") from error
    places, starts = body.mesh.nodes_at(nodes), body.initial_at(nodes)
    if images is None:
        return End(index, nodes, places.mean(axis=0), starts.mean(axis=0))
    return End(index, images.once(nodes), images.middle(nodes, places), images.middle(nodes, starts))


def _check_set(field: str, name: Any) -> None:
    if not isinstance(name, str):
        raise InputError(field, name, "give the name of a node or face set")
