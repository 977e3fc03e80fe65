"""Put the instances of an Abaqus assembly in place: copies of parts, moved and turned, with numbers of their own."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...base.errors import InputError
from ...base.warning_kinds import MeshWarning, warn
from ..geometry import FloatArray
from ..rotation import rotation_matrix
from .abaqus_scope import STRIDE, Block, Facing, Scope
from .abaqus_sections import Section
from .content import MeshFileError


@dataclass
class Instance:
    """An instance: its name, its part, the data lines that move and turn it, and what its own sections define."""

    name: str
    part: str
    rows: list[list[str]]
    own: Scope = field(default_factory=Scope)

    def moved(self, points: FloatArray) -> FloatArray:
        """Return points [n, 3] after the translation of a line of three numbers, then the turn of a line of seven.

        The seven are two points on the axis and the angle in degrees, right-handed from the first to the second.
        """
        for row in self.rows:
            numbers = np.array([float(word) for word in row if word])
            if len(numbers) == 3:
                points = points + numbers
            elif len(numbers) == 7:
                first, second, angle = numbers[:3], numbers[3:6], numbers[6]
                try:
                    turn = rotation_matrix(((second - first).tolist(), float(np.radians(angle))))
                except InputError as error:
                    raise MeshFileError(f"instance {self.name!r} turns about no axis; {error}") from error
                points = (points - first) @ turn.T + first
            elif len(numbers):
                remedy = "give three numbers that move it and seven that turn it, each on a line"
                raise MeshFileError(f"instance {self.name!r} has a line of {len(numbers)} numbers; {remedy}")
        return points


@dataclass
class Assembly(Scope):
    """The scope of a whole file. short: names of sets within their instance, by their keys INSTANCE.SET here."""

    parts: dict[str, Scope] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)
    instances: list[Instance] = field(default_factory=list)
    placed: list[Facing] = field(default_factory=list)
    short: dict[str, str] = field(default_factory=dict)

    def read(self, sections: list[Section]) -> None:
        """Take all sections; without instances, those of parts stand here."""
        has_instances = any(section.keyword == "INSTANCE" for section in sections)
        current: Scope = self
        instance: Instance | None = None
        for section in sections:
            if has_instances and section.keyword.removeprefix("END ") in ("PART", "INSTANCE", "ASSEMBLY"):
                if instance is not None:
                    self._place(instance)
                current, instance = self, None
                if section.keyword == "PART":
                    current = self._part(section.name)
                elif section.keyword == "INSTANCE":
                    instance = Instance(section.name, section.options.get("PART", ""), section.rows)
                    current = instance.own
            else:
                current.take(section)
        if instance is not None:
            self._place(instance)
        if len(self.instances) > 1:
            names = " and ".join(repr(one.name) for one in self.instances)
            remedy = "for a body of each, take its cells by mesh.part(name)"
            warn(f"the instances {names} become one mesh, and so one body; {remedy}", MeshWarning)

    def facing(self) -> list[Facing]:
        """Return the surfaces of the instances and of the assembly."""
        return [*self.placed, *super().facing()]

    def spelling_of_part(self, name: str) -> str:
        """Return the name of a part as it was given."""
        return self.names.get(name.upper(), name)

    def _part(self, name: str) -> Scope:
        if name.upper() in self.parts:
            raise MeshFileError(f"part {name!r} is given twice; export the model anew")
        self.names[name.upper()] = name
        return self.parts.setdefault(name.upper(), Scope())

    def _place(self, instance: Instance) -> None:
        """Copy nodes, elements and sets of the part and of the instance itself into this scope."""
        key = instance.name.upper()
        if key in self.offsets:
            raise MeshFileError(f"instance {instance.name!r} is given twice; export the model anew")
        if instance.part.upper() not in self.parts and not instance.own.blocks:
            raise MeshFileError(f"instance {instance.name!r} is of part {instance.part!r}, which is not in the file")
        self.instances.append(instance)
        start = self.offsets[key] = STRIDE * len(self.instances)
        for scope in (self.parts.get(instance.part.upper(), Scope()), instance.own):
            self.node_ids += [start + ids for ids in scope.node_ids]
            self.points += [instance.moved(points) for points in scope.points]
            self.blocks += [Block(name, start + ids, start + rows) for name, ids, rows in scope.blocks]
            self.others += [(kind, start + ids) for kind, ids in scope.others]
            for mine, given in ((self.nsets, scope.nsets), (self.elsets, scope.elsets)):
                for name, ids in given.items():
                    self._call(instance, scope.spelling[name])
                    self._add(mine, f"{instance.name}.{scope.spelling[name]}", start + ids)
            for surface in scope.facing():
                nodes = None if surface.nodes is None else start + surface.nodes
                faces = [(start + ids, label) for ids, label in surface.faces]
                self.placed.append(Facing(self._call(instance, surface.name), nodes, faces))

    def _call(self, instance: Instance, name: str) -> str:
        """Return what a set of an instance is called here."""
        whole = f"{instance.name}.{name}"
        self.short[whole.upper()] = name
        self.spelling.setdefault(whole.upper(), whole)
        return whole
