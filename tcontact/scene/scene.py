"""A scene as plain, validated data: bodies, supports, obstacles, loads. Nothing is allocated or started here."""

from __future__ import annotations

import copy
import warnings
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from ..base import validate
from ..base.column_names import column_word
from ..base.errors import FunctionError, InputError
from .approach import Approach
from .body import Body
from .connections import connected
from .contact_models import ContactModel, ImpulseContact, MasslessContact, PenaltyContact
from .dissipation import BulkViscosity, Damping
from .friction_laws import joint_friction, laws_in_use
from .friction_models import FrictionLayer, FrictionModel, coefficient_of
from .layer_metals import check_metals
from .obstacles import Obstacle
from .pairs import BodyPair, Pair, checked_pairs, hindrance, pairs_of
from .periodic import check_obstacles
from .probes import Probe, checked_maxima
from .reach import SAMPLES, with_reached_faces
from .rigid_motion import EndBefore
from .springs import SceneSpring, springs_of, with_spring_speeds
from .time_functions import TimeFunction

OF_PAIRS = ("pairs_at", "paired_labels", "groups")  # what a scene knows once it has its pairs
REPR_LINES = 6  # bodies, and obstacles, that the text of a scene names


class OverlapWarning(UserWarning):
    """Two bodies of a scene that are no pair in contact with each other may touch."""


@dataclass(frozen=True, eq=False)
class Scene:
    """Bodies, obstacles and loads over a time span; terms left at None do not exist in the run.

    bodies: one or more `Body`; obstacles: `Plane`, `Sphere`, `Cylinder`, `Box` or `Sdf`, one or several;
    duration [s] > 0: a run ends with the first step that reaches it, which may end after it (a
    run of a duration below one step does that step); gravity [m/s^2]: vector, function of time f(t) -> [3], or None;
    contact: how contact is resolved, or None to let bodies pass through obstacles; damping: `MassDamping` or None;
    viscosity: `BulkViscosity` or None;
    friction: `Coulomb`, `FrictionTable`, `RegularizedCoulomb`, `FrictionLayer` or None, for all obstacles and pairs
    without their own; if only these have some, it becomes such a law with the coefficient 0; pairs: which bodies touch
    each other: "auto" (those whose contact faces may meet), a list of `Pair`, or None to let bodies pass through each
    other. Where two bodies meet that are no pair, a run stops (`Result.reason` "bodies-meet") unless pairs is None.
    maxima: names out of "von_mises", "pressure" and, with a metal, "plastic_strain": the history has the largest of all
    cells at every row (`von_mises_max`, `pressure_max`, `plastic_strain_max`), and `Result.maxima` that of all steps.
    Raises `InputError`.
    """

    bodies: Sequence[Body]
    obstacles: Sequence[Obstacle] = ()
    duration: float = 0.0
    gravity: Any = None
    contact: ContactModel | None = field(default_factory=MasslessContact)
    friction: FrictionModel | None = None
    damping: Damping | None = None
    viscosity: BulkViscosity | None = None
    pairs: str | Sequence[Pair] | None = "auto"
    maxima: Sequence[str] = ()
    body_pairs: tuple[BodyPair, ...] = field(default=(), init=False)
    springs: tuple[SceneSpring, ...] = field(default=(), init=False)
    end_before: EndBefore | None = field(default=None, init=False)  # where a run goes on from another one
    views: ClassVar[Any]  # draws a scene; it stands above, so the package sets it

    def __post_init__(self) -> None:
        bodies = (self.bodies,) if isinstance(self.bodies, Body) else self.bodies
        if not isinstance(bodies, Sequence) or not bodies or not all(isinstance(body, Body) for body in bodies):
            raise InputError("Scene.bodies", self.bodies, "give a list of one or more tcontact.Body")
        object.__setattr__(self, "bodies", tuple(bodies))
        obstacles = (self.obstacles,) if isinstance(self.obstacles, Obstacle) else self.obstacles
        if not isinstance(obstacles, Sequence) or not all(isinstance(obstacle, Obstacle) for obstacle in obstacles):
            raise InputError(
                "Scene.obstacles", self.obstacles, "give a list of obstacles, for example tcontact.Plane(...)"
            )
        object.__setattr__(self, "obstacles", tuple(obstacles))
        validate.keep(self, "Scene.duration", low=0.0)
        if callable(self.gravity):
            self.gravity_function.at(np.zeros(1))
        elif self.gravity is not None:
            object.__setattr__(self, "gravity", validate.vector("Scene.gravity", self.gravity))
        if self.contact is not None and not isinstance(self.contact, (MasslessContact, PenaltyContact, ImpulseContact)):
            raise InputError(
                "Scene.contact", self.contact, "give MasslessContact, PenaltyContact, ImpulseContact or None"
            )
        if self.damping is not None and not isinstance(self.damping, Damping):
            raise InputError("Scene.damping", self.damping, "give tcontact.MassDamping(rate) or None")
        if self.viscosity is not None and not isinstance(self.viscosity, BulkViscosity):
            raise InputError(
                "Scene.viscosity", self.viscosity, "give tcontact.BulkViscosity(linear, quadratic) or None"
            )
        if self.friction is not None and not isinstance(self.friction, FrictionModel):
            remedy = "give Coulomb, FrictionTable, RegularizedCoulomb, FrictionLayer or None"
            raise InputError("Scene.friction", self.friction, remedy)
        object.__setattr__(self, "pairs", checked_pairs(self.pairs))
        object.__setattr__(self, "friction", joint_friction(self))
        object.__setattr__(self, "maxima", checked_maxima(self.maxima, self.plastic))
        _check_names("Body.name", "bodies", self.bodies, self.label)
        self._check_probes()
        self._check_part_names()
        _check_names("Obstacle.name", "obstacles", self.obstacles, self.obstacle_label)
        object.__setattr__(self, "springs", tuple(springs_of(self)))
        object.__setattr__(self, "bodies", with_spring_speeds(self.bodies, self.springs))
        within = self.obstacles if self.contact is not None else (), self.duration, self.largest_gravity
        outer = Approach(self, outer=True)
        reached = self.faces_of_others(outer)
        named = zip(self.bodies, reached, strict=True)
        object.__setattr__(self, "bodies", tuple(with_reached_faces(body, *within, faces) for body, faces in named))
        object.__setattr__(self, "body_pairs", pairs_of(self, Approach(self, outer=False, before=outer)))
        check_metals(self)
        self._check_free()
        if self.contact is not None:
            for index, body in enumerate(self.bodies):
                self._check_start(index, body)
                if body.images is not None and body.contact is not None:
                    check_obstacles(body.images, body.periodic, self.obstacles)
        if self.obstacles and self.contact is None:
            warnings.warn("the scene has obstacles but contact=None: bodies pass through them", stacklevel=3)
        elif self.obstacles and all(body.contact is None for body in self.bodies):
            warnings.warn("the scene has obstacles but no Body.contact: bodies pass through them", stacklevel=3)
        elif self.friction is not None and not self.obstacles and not self.body_pairs:
            warnings.warn("the scene has friction but no obstacles or pairs: it has no effect", stacklevel=3)
        if self.pairs is None and len(self.bodies) > 1:
            warnings.warn("the scene has pairs=None: its bodies pass through each other", OverlapWarning, stacklevel=3)
        self._check_bodies_apart()

    @property
    def gravity_function(self) -> TimeFunction:
        """Return gravity [3] [m/s^2] as a function of time."""
        return TimeFunction("Scene.gravity", self.gravity, 3)

    @property
    def largest_gravity(self) -> float:
        """Return the largest size of gravity over the duration [m/s^2]; infinite for a function that fails."""
        try:
            samples = SAMPLES if callable(self.gravity) else 1
            values = self.gravity_function.at(np.linspace(0.0, float(self.duration), samples))
        except FunctionError:  # the run stops where it fails
            return np.inf
        return float(np.linalg.norm(values, axis=1).max())

    @property
    def touching(self) -> bool:
        """Return whether contact can occur: a contact model, a body with a contact set and something to touch."""
        there = bool(self.obstacles or self.body_pairs)
        return there and self.contact is not None and any(body.touches for body in self.bodies)

    def for_scheme(self, implicit: bool) -> Scene:
        """Return the scene as a scheme runs it: with pairs="auto" implicit steps stop where two bodies meet."""
        if not implicit or self.pairs != "auto":
            return self
        scene = copy.copy(self)
        for name in OF_PAIRS:
            scene.__dict__.pop(name, None)
        object.__setattr__(scene, "body_pairs", ())
        return scene

    @cached_property
    def pairs_at(self) -> tuple[tuple[BodyPair, ...], ...]:
        """The pairs of each body, in the order of `body_pairs`."""
        found: list[list[BodyPair]] = [[] for _ in self.bodies]
        for pair in self.body_pairs:
            for number in (pair.first, pair.second):
                found[number].append(pair)
        return tuple(tuple(pairs) for pairs in found)

    @cached_property
    def paired_labels(self) -> frozenset[str]:
        """The names of the bodies that are in contact with others."""
        return frozenset(self.label(number) for number, pairs in enumerate(self.pairs_at) if pairs)

    @cached_property
    def groups(self) -> tuple[tuple[int, ...], ...]:
        """For each body the numbers of all bodies that pairs connect to it, with itself, ascending."""
        return connected(len(self.bodies), ((pair.first, pair.second) for pair in self.body_pairs))

    def starting(self, index: int) -> Body:
        """Return body `index` as it starts: with the motion of its end in another run where one goes on from that."""
        body = self.bodies[index]
        return body if self.end_before is None else self.end_before.motions[index].given_to(body)

    def can_touch(self, index: int) -> bool:
        """Return whether body `index` can touch an obstacle or another body."""
        there = bool(self.obstacles) or bool(self.pairs_at[index])
        return there and self.bodies[index].touches and self.touching

    @property
    def plastic(self) -> bool:
        """Return whether a body is of a metal that flows plastically."""
        return any(material.plastic for body in self.bodies for material in body.materials)

    @property
    def largest_friction(self) -> float:
        """Return the largest coefficient of friction, of obstacles and of pairs of bodies; 0 without friction."""
        return max(map(coefficient_of, laws_in_use(self) or [self.friction]))

    @property
    def rigid_mass(self) -> float:
        """Return the mass [kg] of the obstacles that move freely, and that of rigid parts beside their nodes."""
        parts = [part.mass or 0.0 for body in self.bodies for part in body.rigid_parts]
        return sum(obstacle.mass or 0.0 for obstacle in self.obstacles) + sum(parts)

    @property
    def moving(self) -> bool:
        """Return whether an obstacle moves."""
        return any(obstacle.moves for obstacle in self.obstacles)

    @property
    def tracked(self) -> bool:
        """Return whether the history has forces and moments of the obstacles: of several, or of one that moves."""
        return len(self.obstacles) > 1 or self.moving

    def obstacle_label(self, index: int) -> str:
        """Return the name of an obstacle for messages and results."""
        return self.obstacles[index].name or f"obstacle-{index}"

    def _check_free(self) -> None:
        """Refuse what obstacles that move freely do not have. Raises `InputError`."""
        if not any(obstacle.free for obstacle in self.obstacles):
            return
        without = "obstacles that move freely (mass=) have"
        if isinstance(self.contact, ImpulseContact):
            raise InputError("Scene.contact", self.contact, f"{without} no impulse contact; use MasslessContact")
        if isinstance(self.friction, FrictionLayer):
            raise InputError("Scene.friction", self.friction, f"{without} no friction layers; use Coulomb")

    def faces_of_others(self, approach: Approach) -> list[np.ndarray | None]:
        """Return for every outer face of each body with contact="auto" whether it may meet another one of its pairs.

        None for other bodies, and where bodies are not in contact with each other.
        """
        result: list[np.ndarray | None] = [None] * len(self.bodies)
        if self.pairs is None or hindrance(self):
            return result
        partners: dict[str, set[str]] = {}
        for pair in () if isinstance(self.pairs, str) else self.pairs:
            partners.setdefault(pair.first, set()).add(pair.second)
            partners.setdefault(pair.second, set()).add(pair.first)
        places = {self.label(index): index for index in range(len(self.bodies))}
        for index, body in enumerate(self.bodies):
            if not body.finds_contact:
                continue
            named = partners.get(self.label(index), set())
            others = [places[name] for name in named if name in places]
            found = np.zeros(len(body.outer_faces), dtype=bool)
            for other in approach.near(index) if isinstance(self.pairs, str) else others:
                found |= approach.meeting(index, other)
            result[index] = found
        return result

    def _check_start(self, index: int, body: Body) -> None:
        if not body.touches:
            return
        edge = body.mesh.shortest_edge
        gives_way = isinstance(self.contact, PenaltyContact) or getattr(self.contact, "penalty", None) is not None
        # a body in equilibrium with a penalty is displaced into the obstacle, though by less than a cell
        allowed = (1.0 if gives_way and body.displacement is not None else 1e-6) * edge
        for number, obstacle in enumerate(self.obstacles):
            gap = np.concatenate([obstacle.gap(places) for places in body.initial_portions()])
            node = int(np.argmin(gap))
            if gap[node] < -allowed:
                raise InputError(
                    f"Scene.bodies[{index}]",
                    float(gap[node]),
                    f"node {node} starts {-gap[node]:.6g} inside obstacle {self.obstacle_label(number)} (allowed:"
                    f" {allowed:.3g}); move the body or the obstacle apart",
                )

    def _check_bodies_apart(self) -> None:
        boxes = [body.initial_bounds for body in self.bodies]
        low, high = (np.array([box[end] for box in boxes]) for end in (0, 1))
        paired = {frozenset((pair.first, pair.second)) for pair in self.body_pairs}
        for first in range(len(boxes)):
            lowest, highest = np.maximum(low[first], low[first + 1 :]), np.minimum(high[first], high[first + 1 :])
            for second in (first + 1 + np.flatnonzero((lowest <= highest).all(axis=1))).tolist():
                if {first, second} not in paired:
                    warnings.warn(
                        f"bodies {self.label(first)} ({_between(*boxes[first])}) and {self.label(second)}"
                        f" ({_between(*boxes[second])}) overlap in their bounding boxes and are no pair in contact with"
                        " each other: move one of them (mesh.translated), or let faces that look at each other be"
                        " contact faces of both (Body(contact=...))",
                        OverlapWarning,
                        stacklevel=4,
                    )

    def probe_column(self, index: int, probe: Probe) -> str:
        """Return the history column of a probe of body `index`."""
        return column_word(f"probe_{self.label(index)}_{probe.set}_{probe.quantity}")

    def _check_probes(self) -> None:
        """Refuse two probes with one column, as of the body "a" with the set "b_c" and "a_b" with "c"."""
        columns: dict[str, str] = {}
        for index, body in enumerate(self.bodies):
            for probe in body.probes:
                name = self.probe_column(index, probe)
                if name in columns:
                    remedy = f"has the column of a probe of {columns[name]!r}; rename the body or the set"
                    raise InputError(f"Scene.bodies[{index}].probes", name, remedy)
                columns[name] = self.label(index)

    def _check_part_names(self) -> None:
        """Refuse two rigid parts with one name in the history, as two probes."""
        owners: dict[str, str] = {}
        for index, body in enumerate(self.bodies):
            for part in body.rigid_parts:
                name = part.column(self.label(index))
                if name in owners:
                    remedy = f"so is a rigid part of {owners[name]!r} called in the history; rename the body or the set"
                    raise InputError(f"Scene.bodies[{index}].rigid_parts", name, remedy)
                owners[name] = self.label(index)

    def __repr__(self) -> str:
        """Return a few lines: the bodies, the obstacles and the settings."""
        lines = [f"Scene of {self.duration:g} s"]
        lines += [f"  {self.label(number)}: {body!r}" for number, body in enumerate(self.bodies[:REPR_LINES])]
        if len(self.bodies) > REPR_LINES:
            lines.append(f"  and {len(self.bodies) - REPR_LINES} more bodies")
        shapes = [f"{one.name + ' ' if one.name else ''}{type(one).__name__}" for one in self.obstacles]
        more = f" and {len(shapes) - REPR_LINES} more" if len(shapes) > REPR_LINES else ""
        lines += [f"  obstacles: {', '.join(shapes[:REPR_LINES])}{more}"] if shapes else []
        given = {"contact": self.contact if self.touching else None, "friction": self.friction,
                 "damping": self.damping, "viscosity": self.viscosity}  # fmt: skip
        shown = [f"{name} {type(value).__name__}" for name, value in given.items() if value is not None]
        shown += ["gravity"] if self.gravity is not None else []
        return "\n".join([*lines, *(["  " + ", ".join(shown)] if shown else [])])

    def _repr_png_(self) -> bytes:
        """Return a picture of the start for a notebook."""
        return bytes(self.views.scene_picture(self))

    def label(self, index: int) -> str:
        """Return the name of a body for messages and results."""
        return self.bodies[index].name or f"body-{index}"


def _check_names(field: str, owners: str, named: Sequence[Any], label: Callable[[int], str]) -> None:
    names = Counter(one.name for one in named if one.name is not None)
    for name, count in names.items():
        if count > 1:
            raise InputError(field, name, f"used by several {owners}; give each its own name")
    for index, one in enumerate(named):
        if one.name is None and label(index) in names:
            raise InputError(field, label(index), f"so is number {index} called, which has no name; give it one")


def _between(low: np.ndarray, high: np.ndarray) -> str:
    """Return where a box is in words."""
    return ", ".join(f"{axis} {low[i]:.4g} to {high[i]:.4g}" for i, axis in enumerate("xyz")) + " m"
