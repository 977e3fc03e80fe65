"""Pairs of bodies that can touch each other: which they are, and which body of a pair is the slave (METHOD 7).

A total order of the bodies decides (`slaves`). The lower one of a pair is the slave: its contact nodes get the
constraint rows.
"""

from __future__ import annotations

import graphlib
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..base import validate
from ..base.column_names import column_word
from ..base.errors import InputError
from .approach import Approach
from .contact_models import MasslessContact, PenaltyContact
from .friction_models import FrictionModel, coefficient_of
from .slaves import held, places_of

HELD_REMEDY = "leave the held nodes out of Body.contact"


@dataclass(frozen=True)
class Pair:
    """Two bodies that can touch each other, by name (`Body.name`, or "body-0", "body-1", ...).

    first, second: the names; forces in the history act on the first one. friction: the model between these two bodies
    in place of `Scene.friction` (`NoFriction`: none); None takes `Scene.friction`. slave: the name of the body
    whose contact nodes get the constraint rows; None chooses the one that is curved or sharp where the other is flat
    with coarser faces than that curvature, else the softer one, then the one with the smaller faces.
    initial_gap: "as-meshed", or "closed": gaps and overlaps at the start below h^2 kappa / 8 (h: size of a face, kappa:
    curvature of the surface), which come from flat faces on curved surfaces, count as closed. Raises `InputError`.
    """

    first: str
    second: str
    friction: FrictionModel | None = None
    slave: str | None = None
    initial_gap: str = "as-meshed"

    def __post_init__(self) -> None:
        for field in ("first", "second"):
            name = getattr(self, field)
            if not isinstance(name, str) or not name:
                raise InputError(f"Pair.{field}", name, "give the name of a body, for example 'body-0'")
        if self.first == self.second:
            remedy = "contact of a body with itself is not modelled: name two bodies"
            raise InputError("Pair.second", self.second, remedy)
        if self.friction is not None and not isinstance(self.friction, FrictionModel):
            remedy = "give a model such as tcontact.Coulomb(0.3), or None for Scene.friction"
            raise InputError("Pair.friction", self.friction, remedy)
        if self.slave is not None and not (isinstance(self.slave, str) and self.slave in (self.first, self.second)):
            raise InputError("Pair.slave", self.slave, f"give {self.first!r}, {self.second!r} or None")
        validate.choice("Pair.initial_gap", self.initial_gap, ("as-meshed", "closed"))

    @property
    def name(self) -> str:
        """The name of the pair in the history."""
        return column_word(f"{self.first}-{self.second}")


@dataclass(frozen=True)
class BodyPair:
    """A pair by the numbers of its bodies in the scene; forces in the history act on `first`.

    friction: the model between the two, None for none.
    """

    name: str
    first: int
    second: int
    slave: int
    initial_gap: str = "as-meshed"
    friction: FrictionModel | None = None

    @property
    def coefficient(self) -> float:
        """The largest coefficient of friction, 0 without any."""
        return coefficient_of(self.friction)

    @property
    def master(self) -> int:
        """The body that is not the slave."""
        return self.first + self.second - self.slave


def checked_pairs(given: Any) -> Any:
    """Return "auto", None or a tuple of `Pair`. Raises `InputError` for anything else and for a pair named twice."""
    if given is None or (isinstance(given, str) and given == "auto"):
        return given
    pairs = (given,) if isinstance(given, Pair) else given
    if isinstance(pairs, str) or not isinstance(pairs, Sequence) or not all(isinstance(pair, Pair) for pair in pairs):
        remedy = "give 'auto' (bodies touch where they meet), a list of tcontact.Pair, or None (in a scene file"
        raise InputError("Scene.pairs", given, f'{remedy} "none") to let bodies pass through each other')
    seen: set[frozenset[str]] = set()
    for pair in pairs:
        bodies = frozenset((pair.first, pair.second))
        if bodies in seen:
            raise InputError("Scene.pairs", pair.name, "name each pair once")
        seen.add(bodies)
    return tuple(pairs)


def hindrance(scene: Any) -> str:
    """Return what rules out contact between the bodies of a scene, or ""."""
    if not isinstance(scene.contact, MasslessContact | PenaltyContact):
        return "contact between bodies needs contact=MasslessContact() or PenaltyContact(stiffness)"
    if getattr(scene.contact, "penalty", None) is not None:
        return "contact between bodies has no penalty without mass: leave MasslessContact.penalty at None"
    if getattr(scene.contact, "solver", "auto") == "gauss-seidel":
        return "contact between bodies is solved by projected gradients: leave MasslessContact.solver at 'auto'"
    if any(body.images is not None for body in scene.bodies):
        return "contact between bodies is not available for periodic bodies"
    return ""


def pairs_of(scene: Any, approach: Approach) -> tuple[BodyPair, ...]:
    """Return the pairs of bodies of a scene that are in contact with each other; approach: of their contact faces.

    With "auto" these are the bodies whose contact faces may meet; none where something rules out contact between
    bodies: a run then stops where bodies meet. The approach is that of the start, which may be the end of another run.
    Raises `InputError` for a list with pairs that cannot be.
    """
    if scene.pairs is None or (scene.pairs == "auto" and len(scene.bodies) < 2):
        return ()
    why_not, fixed = hindrance(scene), [held(body) for body in scene.bodies]
    found = []
    if scene.pairs == "auto":
        if why_not:
            return ()
        everyone = range(len(scene.bodies))
        near = [(first, second) for first in everyone for second in approach.near(first) if second > first]
        meeting = [(first, second) for first, second in near if approach.meeting(first, second).any()]
        places = places_of(scene.bodies, meeting)
        for first, second in meeting:
            slave = min(first, second, key=places.__getitem__)
            if not fixed[slave]:  # else both are, see `held_pairs`
                name = column_word(f"{scene.label(first)}-{scene.label(second)}")
                found.append(BodyPair(name, first, second, slave, friction=scene.friction))
        _check_pair_names(found)
        return tuple(found)
    labels = {scene.label(index): index for index in range(len(scene.bodies))}
    for pair in scene.pairs:
        for field in ("first", "second"):
            name = getattr(pair, field)
            if name not in labels:
                raise InputError(f"Pair.{field}", name, f"use one of the bodies: {', '.join(labels)}")
            if not scene.bodies[labels[name]].touches:
                raise InputError(f"Pair.{field}", name, "it has no contact faces: give its Body.contact")
        if why_not:
            raise InputError("Scene.pairs", pair.name, why_not)
    both = [(labels[pair.first], labels[pair.second]) for pair in scene.pairs]
    open_ones = [numbers for pair, numbers in zip(scene.pairs, both, strict=True) if pair.slave is None]
    places = places_of(scene.bodies, open_ones)
    for pair, (first, second) in zip(scene.pairs, both, strict=True):
        slave = min(first, second, key=places.__getitem__) if pair.slave is None else labels[pair.slave]
        if fixed[slave]:
            remedy = "supports hold some of its contact nodes, which cannot be slaves:"
            remedy += "" if fixed[first] and fixed[second] else " make the other body the slave, or"
            raise InputError("Pair.slave", scene.label(slave), f"{remedy} {HELD_REMEDY}")
        friction = scene.friction if pair.friction is None else pair.friction
        found.append(BodyPair(pair.name, first, second, slave, pair.initial_gap, friction))
    _check_pair_names(found)
    _check_order(found, list(labels))
    return tuple(found)


def held_pairs(scene: Any) -> list[tuple[int, int]]:
    """Return the numbers of two bodies each that pairs="auto" leaves out though their contact faces may meet.

    Supports hold contact nodes of both, so that neither can be the slave.
    """
    if scene.pairs != "auto" or hindrance(scene):
        return []
    fixed = [number for number, body in enumerate(scene.bodies) if held(body)]
    approach = Approach(scene, outer=False)
    both = [(first, second) for first in fixed for second in approach.near(first) if second > first]
    return [pair for pair in both if pair[1] in fixed and approach.meeting(*pair).any()]


def held_text(scene: Any, first: int, second: int) -> str:
    """Return in words why two bodies of `held_pairs` are no pair, with the remedy."""
    names = f"{scene.label(first)} and {scene.label(second)}"
    return f"supports hold contact nodes of both {names}, so that neither can be the slave: {HELD_REMEDY}"


def _check_pair_names(pairs: Sequence[BodyPair]) -> None:
    """Refuse two pairs of one name, such as "a" with "b-c" and "a-b" with "c": their columns would be one."""
    for name, count in Counter(pair.name for pair in pairs).items():
        if count > 1:
            raise InputError("Scene.pairs", name, "two pairs have this name in the history: rename a body")


def _check_order(pairs: Sequence[BodyPair], labels: Sequence[str]) -> None:
    """Refuse slaves that go round in a circle, such as A of B, B of C, C of A."""
    above: dict[int, set[int]] = {}
    for pair in pairs:
        above.setdefault(pair.slave, set()).add(pair.master)
    try:
        graphlib.TopologicalSorter(above).prepare()
    except graphlib.CycleError as error:
        start = next(body for body in above if _reaches(above, body, body))
        remedy = "the slaves of the pairs go round in a circle; leave one None"
        raise InputError("Pair.slave", labels[start], remedy) from error


def _reaches(above: dict[int, set[int]], start: int, end: int) -> bool:
    """Return whether steps from slaves to their masters lead from one body to another."""
    reached: set[int] = set()
    front = set(above[start])
    while front:
        reached |= front
        front = set().union(*(above.get(body, set()) for body in front)) - reached
    return end in reached


def slave_order(pairs: Sequence[BodyPair], count: int) -> list[int]:
    """Return a place for every body such that the slave of every pair comes before its master."""
    place = [0] * count
    for _ in range(count):
        before = list(place)
        for pair in pairs:
            place[pair.master] = max(place[pair.master], place[pair.slave] + 1)
        if place == before:
            break
    return place
