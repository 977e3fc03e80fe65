"""A body: mesh, material or materials, start, supports and contact faces."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..base import validate
from ..base.errors import InputError
from ..friction_layer.metals import Metal, checked_metal
from ..mesh.mesh import Mesh
from .cell_blocks import BodyBlock, blocks_of, checked_material, suited_formulation
from .loads import Load
from .materials import Material
from .periodic import MATCH, SAME_SPEED, Images, check_contact, images_of, repeated_faces
from .probes import Probe, check_probes
from .rigid import RigidPart
from .springs import PointMass, Spring
from .supports import Prescribed, Support

Materials = Any  # a Material, or a dict from names of cell sets to materials
Nodal = Any  # a vector, an array [n, 3] or a callable(nodes [n, 3]) -> [n, 3]
PARTS = {  # fields of a body that are one or several objects of a class
    "supports": Support,
    "loads": Load,
    "point_masses": PointMass,
    "springs": Spring,
    "probes": Probe,
    "rigid_parts": RigidPart,
}


@dataclass(frozen=True, eq=False)
class Body:
    """A deformable body: mesh, material, start, supports and contact faces.

    material: one for all cells, or a dict from names of cell sets of the mesh to materials, such as
    {"core": steel, "skin": rubber}, with every cell in exactly one of these sets;
    velocity [m/s]: a vector, an array [n, 3] or a callable(nodes) -> [n, 3]; contact: name(s) of the sets that can
    touch an obstacle or another body, "auto" for the outer faces that may meet one of the scene's in its duration as
    the body stands at the start (see `reach`; a body that turns later needs "all"), "all" for its whole surface (sets
    of these names go first), or None for a body that passes through; supports: held and driven components;
    formulation: "full" integration; tetrahedra with "node-averaged": volume changes averaged at the nodes, for poisson
    near 1/2 (not with `StVenantKirchhoff`); hexahedra with "mean-dilatation": one volume change per cell, for the same,
    or "reduced": one point, the mean gradient, and a stiffness against hourglassing; in a mesh of several kinds those
    that have one of the latter two take it, the others are integrated fully; None: what suits the material,
    "mean-dilatation" for hexahedra of a metal, "node-averaged" for a mesh of tetrahedra of a metal or above poisson 0.4
    (not with `MieGrueneisen`), else "full";
    displacement [m]: start of the nodes relative to the mesh, which is unstrained, given like velocity (None = 0);
    supported components are held or driven from there, and massless contact nodes are brought to equilibrium before
    the first row, so that the strain energy of their cells may be less than that of the field given;
    rigid_parts: sets of nodes that keep their shape and move as rigid bodies, freely or driven (`RigidPart`);
    metal: a `friction_layer.Metal` for its side of friction layers, None for the one of `FrictionLayer`;
    loads: pressures, tractions and forces on named sets (`Load`);
    periodic: letters out of "xyz": along these axes the nodes of opposite sides, which match face by face like those of
    a box mesh, share their degrees of freedom; a set of nodes that names several of one node names it once;
    point_masses, springs: masses and springs on sets of nodes;
    probes: `Probe`s, means over sets that the history records.
    Raises `InputError` (unknown sets, a contact set on no face, conflicting supports, wrong shapes, NaN, ...).
    """

    mesh: Mesh
    material: Materials
    velocity: Nodal = (0.0, 0.0, 0.0)
    contact: str | Sequence[str] | None = None
    supports: Sequence[Support] = ()
    name: str | None = None
    formulation: str | None = None
    periodic: str | None = None
    displacement: Nodal | None = None
    metal: Metal | None = None
    loads: Sequence[Load] = ()
    point_masses: Sequence[PointMass] = ()
    springs: Sequence[Spring] = ()
    probes: Sequence[Probe] = ()
    rigid_parts: Sequence[RigidPart] = ()

    def __repr__(self) -> str:
        """Return a line: mesh, material, set that can touch, and what else the body has."""
        law = self.material
        known = (
            type(law).__name__
            if isinstance(law, Material)
            else ", ".join(f"{k} {type(v).__name__}" for k, v in law.items())
        )
        found = [f"{self.mesh.cell_count} {self.mesh.kind} cells, {self.mesh.node_count} nodes", known]
        found += [f"contact {', '.join(self.contact)}"] if self.contact else []
        many = {"supports": self.supports, "loads": self.loads, "springs": self.springs, "probes": self.probes,
                "point masses": self.point_masses, "rigid parts": self.rigid_parts}  # fmt: skip
        found += [f"{len(parts)} {name}" for name, parts in many.items() if parts]
        return f"Body({'; '.join(found)})"

    def __post_init__(self) -> None:
        if not isinstance(self.mesh, Mesh):
            raise InputError("Body.mesh", self.mesh, "give a tcontact.Mesh (box_mesh, read_mesh or Mesh)")
        object.__setattr__(self, "material", checked_material(self.material, self.mesh))
        checked_metal("Body.metal", self.metal)
        if self.formulation is None:
            object.__setattr__(self, "formulation", suited_formulation(self.mesh, self.material))
        self.blocks  # noqa: B018 - unknown formulations are found here
        if self.name is not None and (not isinstance(self.name, str) or not self.name):
            raise InputError("Body.name", self.name, "give a non-empty string or None")
        if self.name is not None and "\0" in self.name:  # files would keep what is before it
            raise InputError("Body.name", self.name, "leave out the null character")
        if self.name is not None and not self.name.isprintable():  # files and pictures could not hold it
            raise InputError("Body.name", self.name, "leave out characters that cannot be printed")
        if self.contact is not None:
            names = [self.contact] if isinstance(self.contact, str) else self.contact
            if not isinstance(names, Sequence) or not names or not all(isinstance(name, str) for name in names):
                raise InputError(
                    "Body.contact", self.contact, "give a set name, a list of set names, 'auto', 'all' or None"
                )
            object.__setattr__(self, "contact", tuple(names))
            if not (self.finds_contact or self.touches_all_over):
                self.mesh.faces_of(names)
        check_contact(self.images, self.mesh, self.contact_faces, self.contact)
        for name, kind in PARTS.items():
            object.__setattr__(self, name, validate.parts(f"Body.{name}", getattr(self, name), kind))
        for name in ("supports", "rigid_parts", "point_masses", "springs"):
            self._check_sets(name)
        self.prescribed  # noqa: B018 - conflicts are found here
        self.tied  # noqa: B018 - and here
        self.initial_velocity  # noqa: B018 - wrong shapes are found here
        self.initial_displacement  # noqa: B018 - and here
        for load in self.loads:
            load.check(self.mesh, self.images, self.initial_velocity)
        check_probes(self.probes, self.mesh, self.images, self.blocks)

    def _check_sets(self, name: str) -> None:
        """Refuse parts of one kind, such as "springs", that name a set which the mesh does not have."""
        for number, part in enumerate(getattr(self, name)):
            try:
                self.mesh.nodes_of(part.set)
            except InputError as error:
                remedy = error.remedy if self.name is None else f"no such set of {self.name}; {error.remedy}"
                raise InputError(f"Body.{name}[{number}].set", part.set, remedy) from error

    @cached_property
    def blocks(self) -> tuple[BodyBlock, ...]:
        """Its cells by kind and material."""
        return blocks_of(self.mesh, self.material, self.formulation)

    @property
    def element(self) -> str:
        """Names of its elements: the kind of the cells, with the formulation if not "full"."""
        return " + ".join(dict.fromkeys(block.element for block in self.blocks))

    @property
    def materials(self) -> tuple[Material, ...]:
        """The materials of its blocks."""
        return tuple(block.material for block in self.blocks)

    @property
    def linear(self) -> bool:
        """Return whether all its laws are linear."""
        return all(material.linear for material in self.materials)

    @property
    def wave_speed(self) -> float:
        """The largest dilatational wave speed of its materials [m/s]."""
        return max(material.wave_speed for material in self.materials)

    @property
    def mass(self) -> float:
        """Its mass [kg], from the reference volumes of the cells, with the point masses."""
        added = sum(point.mass for point in self.point_masses)
        if isinstance(self.material, Material):
            return self.material.density * float(self.mesh.cell_volumes().sum()) + added
        volumes = self.mesh.cell_volumes()
        return sum(block.material.density * float(volumes[block.numbers].sum()) for block in self.blocks) + added

    @property
    def finds_contact(self) -> bool:
        """Return whether the scene finds its contact faces."""
        return self._contact_is("auto")

    @property
    def touches_all_over(self) -> bool:
        """Return whether its whole surface can touch something."""
        return self._contact_is("all")

    def _contact_is(self, word: str) -> bool:
        """Return whether `contact` is a word that no set of the mesh has as its name."""
        return self.contact == (word,) and word not in self.mesh.node_sets and word not in self.mesh.face_sets

    @property
    def touches(self) -> bool:
        """Return whether it has faces that can touch an obstacle or another body."""
        return self.contact is not None and len(self.contact_faces) > 0

    @property
    def outer_faces(self) -> np.ndarray:
        """Faces [k, 4|3] of the surface, oriented outward, without periodic sides."""
        faces = self.mesh.boundary_faces()
        return faces if self.images is None else faces[~repeated_faces(self.images, self.mesh, faces)]

    @cached_property
    def contact_faces(self) -> np.ndarray:
        """Faces [k, 4|3] that can touch something, oriented outward; with "auto" only in a scene's own bodies."""
        if self.contact is None or self.finds_contact:
            return self.mesh.boundary_faces()[:0]
        if self.touches_all_over:
            return self.outer_faces
        return self.mesh.faces_of(list(self.contact))

    @cached_property
    def images(self) -> Images | None:
        """Nodes that share their degrees of freedom; None unless the body is periodic."""
        return None if self.periodic is None else images_of(self.mesh, self.periodic)

    @cached_property
    def contact_nodes(self) -> np.ndarray:
        """Nodes [k] of the contact faces with all their images, ascending."""
        nodes = np.unique(self.contact_faces)
        return nodes if self.images is None else self.images.with_images(nodes)

    @property
    def driven(self) -> tuple[Support, ...]:
        """The supports that functions of time drive."""
        return tuple(support for support in self.supports if support.varies)

    def driven_speed(self, duration: float) -> float:
        """Return the largest speed [m/s] that functions of time prescribe, and that springs can give; 0 without."""
        return max((support.largest_speed(duration) for support in self.driven), default=0.0) + self.spring_speed

    @cached_property
    def spring_speed(self) -> float:
        """The speed [m/s] that the energy of springs at the start can give it; a scene knows it of its own bodies."""
        return 0.0

    @cached_property
    def motions(self) -> tuple[np.ndarray, tuple[tuple[Support, Prescribed], ...]]:
        """The motion of every prescribed component: its number [n, 3], NaN where it is free, and the motions."""
        if not self.supports:
            return np.broadcast_to(np.nan, (self.mesh.node_count, 3)), ()
        result = np.full((self.mesh.node_count, 3), np.nan)
        found: dict[tuple[Any, ...], int] = {}
        motions: list[tuple[Support, Prescribed]] = []
        for support in self.supports:
            nodes = self.mesh.nodes_of(support.set)
            for motion in support.motions():
                number = found.setdefault(motion.key, len(motions))
                if number == len(motions):
                    motions.append((support, motion))
                present = result[nodes, motion.axis]
                if (np.isfinite(present) & (present != number)).any():
                    remedy = "another support prescribes the same components with another velocity or displacement"
                    raise InputError("Body.supports", support, remedy)
                result[nodes, motion.axis] = number
        if self.images is not None:
            result = self.images.prescribed(result, self.supports)
        if result.size and np.isfinite(result).all():
            raise InputError(
                "Body.supports", self.supports, "every component is prescribed; leave something free to move"
            )
        return result, tuple(motions)

    @cached_property
    def prescribed(self) -> np.ndarray:
        """Prescribed velocity components [n, 3] [m/s] at t = 0; NaN where the component is free."""
        return self._of_motions([motion.speed for _, motion in self.motions[1]])

    @cached_property
    def given_displacement(self) -> np.ndarray:
        """Displacement [n, 3] [m] at t = 0 of components whose displacement supports prescribe; NaN elsewhere."""
        places = [motion.displacement for _, motion in self.motions[1]]
        return self._of_motions([np.nan if place is None else place for place in places])

    def _of_motions(self, values: list[float]) -> np.ndarray:
        """Return a value of each motion at its components [n, 3], NaN where they are free."""
        if np.isnan(values).all():
            return np.broadcast_to(np.nan, (self.mesh.node_count, 3))
        return np.array([*values, np.nan])[np.nan_to_num(self.motions[0], nan=-1.0).astype(int)]

    @cached_property
    def tied(self) -> np.ndarray:
        """Whether nodes [n] belong to a rigid part."""
        result = np.zeros(self.mesh.node_count, dtype=bool)
        for part in self.rigid_parts:
            nodes = self.mesh.nodes_of(part.set)
            if self.images is not None:
                raise InputError("Body.rigid_parts", part.set, "a periodic body has no rigid parts")
            if result[nodes].any():
                raise InputError("Body.rigid_parts", part.set, "another rigid part has some of its nodes")
            if np.isfinite(self.prescribed[nodes]).any():
                remedy = "supports hold some of its nodes; leave these out, or use RigidPart(driven=True)"
                raise InputError("Body.rigid_parts", part.set, remedy)
            if np.isin(nodes, self.contact_nodes).any():
                remedy = "some of its nodes are contact nodes; leave their faces out of Body.contact"
                raise InputError("Body.rigid_parts", part.set, remedy)
            result[nodes] = True
        if len(result) and result.all():
            raise InputError("Body.rigid_parts", self.rigid_parts, "every node is rigid; leave something free to move")
        return result

    @cached_property
    def initial_velocity(self) -> np.ndarray:
        """Initial velocity [n, 3] [m/s], supports included."""
        result = self._nodal("Body.velocity", self.velocity)
        if not self.supports and not result.flags.writeable:
            return result
        result = np.array(result)
        fixed = np.isfinite(self.prescribed)
        result[fixed] = self.prescribed[fixed]
        if self.images is not None:
            tolerance = SAME_SPEED * float(np.abs(result).max())
            result = self.images.agreed("Body.velocity", self.velocity, result, tolerance)
        result.setflags(write=False)
        return result

    @cached_property
    def initial_displacement(self) -> np.ndarray:
        """Initial displacement [n, 3] [m], supports included."""
        result = self._nodal("Body.displacement", (0.0, 0.0, 0.0) if self.displacement is None else self.displacement)
        given = self.given_displacement
        if np.isnan(given[:1]).all() and given.strides[0] == 0 and not result.flags.writeable:
            return result
        result = np.array(result)
        result[np.isfinite(given)] = given[np.isfinite(given)]
        if self.images is not None:
            tolerance = MATCH * self.mesh.shortest_edge
            result = self.images.agreed("Body.displacement", self.displacement, result, tolerance)
        result.setflags(write=False)
        return result

    @property
    def initial_nodes(self) -> np.ndarray:
        """Positions of the nodes at the start [n, 3] [m]."""
        return np.asarray(self.mesh.nodes + self.initial_displacement if self.starts_displaced else self.mesh.nodes)

    @property
    def starts_displaced(self) -> bool:
        """Return whether nodes may start elsewhere than in the mesh."""
        return self.displacement is not None or bool(self.supports)

    def initial_at(self, numbers: np.ndarray) -> np.ndarray:
        """Return the positions [.., 3] [m] at the start of nodes of these numbers [..]."""
        places = self.mesh.nodes_at(numbers)
        return np.asarray(places + self.initial_displacement[numbers] if self.starts_displaced else places)

    def initial_portions(self) -> Iterator[np.ndarray]:
        """Yield `initial_nodes` in portions, of which a mesh that makes its nodes when they are read keeps none."""
        first = 0
        for places in self.mesh.portions("nodes"):
            last = first + len(places)
            yield places + self.initial_displacement[first:last] if self.starts_displaced else places
            first = last

    @property
    def initial_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest corner [3] [m] of the box of the nodes at the start."""
        if not self.starts_displaced:
            return self.mesh.bounds
        boxes = [(places.min(axis=0), places.max(axis=0)) for places in self.initial_portions()]
        low, high = zip(*boxes, strict=True)
        return np.min(low, axis=0), np.max(high, axis=0)

    def _nodal(self, field: str, given: Nodal) -> np.ndarray:
        """Return a vector, an array or the values of a callable as an array [n, 3]; a vector as a read-only view."""
        value = given
        if isinstance(value, Callable):  # type: ignore[arg-type]
            try:
                value = value(np.array(self.mesh.nodes))
            except Exception as error:
                raise InputError(field, given, f"the callable failed: {error}") from error
        count = self.mesh.node_count
        given_shape = validate.shape_of(field, value, f"give a vector [3], an array [{count}, 3] or a callable")
        shape = (3,) if len(given_shape) == 1 else (count, 3)
        found = validate.floats(field, value, shape)
        return np.broadcast_to(np.array(found), (count, 3)) if shape == (3,) and count > 1 else np.array(found)
