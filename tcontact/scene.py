"""A scene as plain, validated data: bodies, supports, obstacles, loads. Nothing is allocated or started here."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from . import validate
from .contact_models import ContactModel, ImpulseContact, MasslessContact, PenaltyContact
from .dissipation import BulkViscosity, Damping
from .elements import ELEMENTS
from .errors import InputError
from .friction_models import Coulomb, FrictionLayer, FrictionModel, RegularizedCoulomb
from .materials import Material
from .mesh import Mesh
from .mesh_geometry import shortest_edge
from .obstacles import Obstacle
from .periodic import MATCH, SAME_SPEED, Images, check_contact, check_obstacles, images_of, repeated_faces
from .reach import with_reached_faces


class OverlapWarning(UserWarning):
    """Two bodies of a scene may touch; contact between bodies is not modelled."""


@dataclass(frozen=True)
class Support:
    """Held or driven displacement components of a named set.

    set: name of a node or face set of the mesh; axes: letters out of "xyz"; velocity [m/s]: one number for all named
    axes or one per axis (0 = held). Raises `InputError`.
    """

    set: str
    axes: str
    velocity: float | Sequence[float] = 0.0

    def __post_init__(self) -> None:
        if not isinstance(self.set, str):
            raise InputError("Support.set", self.set, "give the name of a node or face set")
        known = isinstance(self.axes, str) and self.axes and set(self.axes) <= set("xyz")
        if not known or len(set(self.axes)) != len(self.axes):
            raise InputError("Support.axes", self.axes, "give distinct letters out of 'xyz', for example 'z' or 'xy'")
        if not validate.shape_of("Support.velocity", self.velocity, "give one number, or one for each axis"):
            validate.number("Support.velocity", self.velocity)
        else:
            validate.floats("Support.velocity", self.velocity, (len(self.axes),))

    @property
    def components(self) -> dict[int, float]:
        """Prescribed velocity [m/s] by axis number."""
        speeds = np.broadcast_to(np.asarray(self.velocity, dtype=float), (len(self.axes),))
        return {"xyz".index(axis): float(speed) for axis, speed in zip(self.axes, speeds, strict=True)}


Nodal = Any  # a vector, an array [n, 3] or a callable(nodes [n, 3]) -> [n, 3]


@dataclass(frozen=True, eq=False)
class Body:
    """A deformable body: mesh, material, how it starts and what it may touch.

    velocity [m/s]: a vector, an array [n, 3] or a callable(nodes) -> [n, 3]; contact: name(s) of the sets that can
    touch an obstacle, "auto" for the outer faces that may meet one of the scene's (see `reach`; a set of that name goes
    first), or None for a body that passes through; supports: held and driven components; formulation: "full"
    integration; or hexahedra with "mean-dilatation": one volume change per cell, for poisson near 1/2 (not with
    `StVenantKirchhoff`), or "reduced": one point, the mean gradient, and a stiffness against hourglassing;
    displacement [m]: where the nodes start, from the mesh as its unstrained state, given like velocity (None = there);
    supported components too are held or driven from where it puts them, and contact nodes without mass are put in
    equilibrium before the first row, so that the strain energy of their cells may be less than that of the field given;
    periodic: letters out of "xyz": along these axes the nodes of opposite sides, which match face by face like those of
    a box mesh, share their degrees of freedom.
    Raises `InputError` (unknown sets, a contact set on no face, conflicting supports, wrong shapes, NaN, ...).
    """

    mesh: Mesh
    material: Material
    velocity: Nodal = (0.0, 0.0, 0.0)
    contact: str | Sequence[str] | None = None
    supports: Sequence[Support] = ()
    name: str | None = None
    formulation: str = "full"
    periodic: str | None = None
    displacement: Nodal | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.mesh, Mesh):
            raise InputError("Body.mesh", self.mesh, "give a tcontact.Mesh (box_mesh, read_mesh or Mesh)")
        if not isinstance(self.material, Material):
            raise InputError("Body.material", self.material, "give a material, for example tcontact.NeoHookean(...)")
        known = dict.fromkeys(name for element in ELEMENTS.values() for name in element.formulations)
        validate.choice("Body.formulation", self.formulation, known)
        if self.formulation not in self.mesh.element.formulations:
            there = [kind for kind, element in ELEMENTS.items() if self.formulation in element.formulations]
            remedy = f"{self.mesh.kind} cells have {', '.join(map(repr, self.mesh.element.formulations))} alone;"
            remedy += f" leave it at 'full', or mesh the body with {' or '.join(there)}"
            raise InputError("Body.formulation", self.formulation, remedy)
        if self.formulation == "mean-dilatation" and not self.material.volumetric:
            raise InputError(
                "Body.formulation",
                self.formulation,
                f"{type(self.material).__name__} has no part that is of the volume change alone; use NeoHookean,"
                " MooneyRivlin or LinearElastic, or leave it at 'full'",
            )
        if self.name is not None and (not isinstance(self.name, str) or not self.name):
            raise InputError("Body.name", self.name, "give a non-empty string or None")
        if self.contact is not None:
            names = [self.contact] if isinstance(self.contact, str) else self.contact
            if not isinstance(names, Sequence) or not names or not all(isinstance(name, str) for name in names):
                raise InputError("Body.contact", self.contact, "give a set name, a list of set names, or None")
            object.__setattr__(self, "contact", tuple(names))
            if not self.finds_contact:
                self.mesh.faces_of(names)
        check_contact(self.images, self.mesh, self.contact_faces, self.contact)
        supports = (self.supports,) if isinstance(self.supports, Support) else self.supports
        if not isinstance(supports, Sequence) or not all(isinstance(support, Support) for support in supports):
            raise InputError("Body.supports", self.supports, "give a list of tcontact.Support")
        object.__setattr__(self, "supports", tuple(supports))
        self.prescribed  # noqa: B018 - conflicts are found here
        self.initial_velocity  # noqa: B018 - wrong shapes are found here
        self.initial_displacement  # noqa: B018 - and here

    @property
    def element(self) -> str:
        """Kind of the cells as their forces are computed: that of the mesh, with the formulation if not "full"."""
        return self.mesh.kind if self.formulation == "full" else f"{self.mesh.kind}-{self.formulation}"

    @property
    def finds_contact(self) -> bool:
        """Whether its contact faces are found by the scene it is put into."""
        return self.contact == ("auto",) and not {"auto"} & {*self.mesh.node_sets, *self.mesh.face_sets}

    @property
    def touches(self) -> bool:
        """Whether it has faces that can touch an obstacle."""
        return self.contact is not None and len(self.contact_faces) > 0

    @property
    def outer_faces(self) -> np.ndarray:
        """Faces [k, 4|3] of the surface, oriented outward, but for sides that repeat."""
        faces = self.mesh.boundary_faces()
        return faces if self.images is None else faces[~repeated_faces(self.images, self.mesh, faces)]

    @cached_property
    def contact_faces(self) -> np.ndarray:
        """Faces [k, 4|3] that can touch an obstacle, oriented outward; with "auto" only in a scene's own bodies."""
        if self.contact is None or self.finds_contact:
            return np.zeros((0, self.mesh.element.face_table.shape[1]), dtype=np.int64)
        return self.mesh.faces_of(list(self.contact))

    @cached_property
    def images(self) -> Images | None:
        """Which nodes share their degrees of freedom; None unless the body is periodic."""
        return None if self.periodic is None else images_of(self.mesh, self.periodic)

    @cached_property
    def contact_nodes(self) -> np.ndarray:
        """Nodes [k] of the contact faces with all that share with them, ascending."""
        nodes = np.unique(self.contact_faces)
        return nodes if self.images is None else self.images.with_images(nodes)

    @cached_property
    def prescribed(self) -> np.ndarray:
        """Prescribed velocity components [n, 3] [m/s]; NaN where the component is free."""
        result = np.full((self.mesh.node_count, 3), np.nan)
        for support in self.supports:
            nodes = self.mesh.nodes_of(support.set)
            for axis, speed in support.components.items():
                present = result[nodes, axis]
                if (np.isfinite(present) & (present != speed)).any():
                    raise InputError(
                        "Body.supports", support, "another support prescribes the same components with another velocity"
                    )
                result[nodes, axis] = speed
        if self.images is not None:
            result = self.images.prescribed(result, self.supports)
        if result.size and np.isfinite(result).all():
            raise InputError(
                "Body.supports", self.supports, "every component is prescribed; leave something free to move"
            )
        return result

    @cached_property
    def initial_velocity(self) -> np.ndarray:
        """Initial velocity [n, 3] [m/s], supports included."""
        result = self._nodal("Body.velocity", self.velocity)
        fixed = np.isfinite(self.prescribed)
        result[fixed] = self.prescribed[fixed]
        if self.images is not None:
            tolerance = SAME_SPEED * float(np.abs(result).max())
            result = self.images.agreed("Body.velocity", self.velocity, result, tolerance)
        result.setflags(write=False)
        return result

    @cached_property
    def initial_displacement(self) -> np.ndarray:
        """Initial displacement [n, 3] [m]."""
        result = self._nodal("Body.displacement", (0.0, 0.0, 0.0) if self.displacement is None else self.displacement)
        if self.images is not None:
            tolerance = MATCH * shortest_edge(self.mesh.nodes, self.mesh.cells)
            result = self.images.agreed("Body.displacement", self.displacement, result, tolerance)
        result.setflags(write=False)
        return result

    @property
    def initial_nodes(self) -> np.ndarray:
        """Where the nodes start [n, 3] [m]."""
        return np.asarray(self.mesh.nodes + self.initial_displacement)

    def _nodal(self, field: str, given: Nodal) -> np.ndarray:
        """A vector, an array or a callable as an array [n, 3] of its own."""
        value = given
        if isinstance(value, Callable):  # type: ignore[arg-type]
            try:
                value = value(np.array(self.mesh.nodes))
            except Exception as error:
                raise InputError(field, given, f"the callable failed: {error}") from error
        count = self.mesh.node_count
        given_shape = validate.shape_of(field, value, f"give a vector [3], an array [{count}, 3] or a callable")
        shape = (3,) if len(given_shape) == 1 else (count, 3)
        return np.array(np.broadcast_to(validate.floats(field, value, shape), (count, 3)))


@dataclass(frozen=True, eq=False)
class Scene:
    """Bodies, obstacles and loads over a time span; terms left at None do not exist in the run.

    bodies: one or more `Body`; obstacles: `Plane`, `Sphere`, `Cylinder`, `Box` or `Sdf`, one or several;
    duration [s] > 0; gravity: vector [m/s^2] or None; contact: how contact is resolved, or None to let bodies
    pass through obstacles; damping: `MassDamping` or None; viscosity: `BulkViscosity` or None; friction: `Coulomb`,
    `RegularizedCoulomb`, `FrictionLayer` or None; pairs: which bodies touch each other: contact between bodies is not
    modelled yet, so "auto" stops a run where two of them meet (`Result.reason` "bodies-meet"), and None lets them pass
    through each other.
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
    pairs: str | None = "auto"

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
        validate.number("Scene.duration", self.duration, low=0.0)
        if self.gravity is not None:
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
        if self.friction is not None and not isinstance(self.friction, (Coulomb, RegularizedCoulomb, FrictionLayer)):
            raise InputError("Scene.friction", self.friction, "give Coulomb, RegularizedCoulomb, FrictionLayer or None")
        if self.pairs is not None and not (isinstance(self.pairs, str) and self.pairs == "auto"):
            remedy = (
                "contact between bodies is not modelled yet: give 'auto' to stop where two bodies meet, or None (in"
                ' a scene file "none") to let them pass through each other'
            )
            raise InputError("Scene.pairs", self.pairs, remedy)
        _check_names("Body.name", "bodies", self.bodies, self.label)
        _check_names("Obstacle.name", "obstacles", self.obstacles, self.obstacle_label)
        within = self.obstacles if self.contact is not None else (), self.duration, self.gravity
        object.__setattr__(self, "bodies", tuple(with_reached_faces(body, *within) for body in self.bodies))
        if self.contact is not None:
            for index, body in enumerate(self.bodies):
                self._check_start(index, body)
                if body.images is not None and body.contact is not None:
                    check_obstacles(body.images, body.periodic, self.obstacles)
        if self.obstacles and self.contact is None:
            warnings.warn("the scene has obstacles but contact=None: bodies pass through them", stacklevel=3)
        elif self.obstacles and all(body.contact is None for body in self.bodies):
            warnings.warn("the scene has obstacles but no Body.contact: bodies pass through them", stacklevel=3)
        elif self.friction is not None and not self.obstacles:
            warnings.warn("the scene has friction but no obstacles: nothing rubs", stacklevel=3)
        if self.pairs is None and len(self.bodies) > 1:
            warnings.warn("the scene has pairs=None: its bodies pass through each other", OverlapWarning, stacklevel=3)
        self._check_bodies_apart()

    @property
    def touching(self) -> bool:
        """Whether anything can touch: obstacles, a contact model and a body with a contact set."""
        return bool(self.obstacles) and self.contact is not None and any(body.touches for body in self.bodies)

    @property
    def moving(self) -> bool:
        """Whether an obstacle moves."""
        return any(obstacle.moves for obstacle in self.obstacles)

    @property
    def tracked(self) -> bool:
        """Whether the history holds forces and moments of the obstacles: of several, or of one that moves."""
        return len(self.obstacles) > 1 or self.moving

    def obstacle_label(self, index: int) -> str:
        """Name of an obstacle for messages and results."""
        return self.obstacles[index].name or f"obstacle-{index}"

    def _check_start(self, index: int, body: Body) -> None:
        if not body.touches:
            return
        edge = shortest_edge(body.mesh.nodes, body.mesh.cells)
        gives_way = isinstance(self.contact, PenaltyContact) or getattr(self.contact, "penalty", None) is not None
        # a body in equilibrium with a penalty is displaced into the obstacle, though by less than a cell
        allowed = (1.0 if gives_way and body.displacement is not None else 1e-6) * edge
        for number, obstacle in enumerate(self.obstacles):
            gap = obstacle.gap(body.initial_nodes)
            node = int(np.argmin(gap))
            if gap[node] < -allowed:
                raise InputError(
                    f"Scene.bodies[{index}]",
                    float(gap[node]),
                    f"node {node} starts {-gap[node]:.6g} inside obstacle {self.obstacle_label(number)} (allowed:"
                    f" {allowed:.3g}); move the body or the obstacle apart",
                )

    def _check_bodies_apart(self) -> None:
        boxes = [(body.initial_nodes.min(axis=0), body.initial_nodes.max(axis=0)) for body in self.bodies]
        for first in range(len(boxes)):
            for second in range(first + 1, len(boxes)):
                low = np.maximum(boxes[first][0], boxes[second][0])
                high = np.minimum(boxes[first][1], boxes[second][1])
                if (low <= high).all():
                    warnings.warn(
                        f"bodies {self.label(first)} and {self.label(second)} overlap in their bounding boxes;"
                        " contact between bodies is not modelled",
                        OverlapWarning,
                        stacklevel=4,
                    )

    def label(self, index: int) -> str:
        """Name of a body for messages and results."""
        return self.bodies[index].name or f"body-{index}"


def _check_names(field: str, owners: str, named: Sequence[Any], label: Callable[[int], str]) -> None:
    names = [one.name for one in named if one.name is not None]
    for name in names:
        if names.count(name) > 1:
            raise InputError(field, name, f"used by several {owners}; give each its own name")
    for index, one in enumerate(named):
        if one.name is None and label(index) in names:
            raise InputError(field, label(index), f"so is number {index} called, which has no name; give it one")
