"""Nodes, elements and sets of an Abaqus part or assembly, in whose scope numbers and names hold."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ...base.warning_kinds import MeshWarning, warn
from ..elements import ELEMENTS
from ..geometry import FloatArray, IntArray
from .abaqus_sections import Section
from .content import MeshFileError

_FLAT = "(S|R3D|M3D|SFM3D|CPS|CPE|DS)"
# element type pattern -> (meshio's word, nodes)
_TYPES = [
    *((f"D?{element.abaqus}[A-Z]*", element.meshio, element.corners) for element in ELEMENTS.values()),
    (r"D?C3D10[A-Z]*", "tetra10", 10),
    (r"D?C3D15[A-Z]*", "wedge15", 15),
    (r"D?C3D20[A-Z]*", "hexahedron20", 20),
    (r"D?C3D27[A-Z]*", "hexahedron27", 27),
    (rf"({_FLAT}|STRI)3[A-Z]*", "triangle", 3),
    (rf"{_FLAT}4[A-Z0-9]*", "quad", 4),
    (rf"STRI65|{_FLAT}6[A-Z]*", "triangle6", 6),
    (rf"{_FLAT}8[A-Z0-9]*", "quad8", 8),
    (rf"{_FLAT}9[A-Z0-9]*", "quad9", 9),
    (r"T[23]D2[A-Z]*|B[23]1[A-Z]*", "line", 2),
]
_SOLIDS = ", ".join(sorted(element.abaqus for element in ELEMENTS.values()))
MAXIMUM_IDS = 2**28  # in a generated set
MAXIMUM_OTHER = 4  # numbers on a line of an element that is no cell, such as a beam with a node for its orientation
STRIDE = 2**32  # numbers of an instance start at a multiple of it, above every number that a file may give


class Block(NamedTuple):
    """Elements of one type [m], in meshio's words, and their nodes [m, k]."""

    cell_type: str
    ids: IntArray
    rows: IntArray


class Facing(NamedTuple):
    """A surface: its nodes if it is one of nodes, else elements with the label of their face."""

    name: str
    nodes: IntArray | None
    faces: list[tuple[IntArray, str]]


@dataclass
class Scope:
    """What the sections of a part, an instance or the assembly define.

    others: elements of kinds that are no cells, such as masses: the type and their numbers;
    nsets, elsets: by name in capitals; spelling: names as written, by those in capitals; offsets: first number of the
    instances that stand in this scope, whose sets are called INSTANCE.SET.
    """

    node_ids: list[IntArray] = field(default_factory=list)
    points: list[FloatArray] = field(default_factory=list)
    blocks: list[Block] = field(default_factory=list)
    others: list[tuple[str, IntArray]] = field(default_factory=list)
    nsets: dict[str, IntArray] = field(default_factory=dict)
    elsets: dict[str, IntArray] = field(default_factory=dict)
    surfaces: list[Section] = field(default_factory=list)
    spelling: dict[str, str] = field(default_factory=dict)
    offsets: dict[str, int] = field(default_factory=dict)

    def take(self, section: Section) -> None:
        """Add what a section defines; sections of other keywords are passed over."""
        name = section.name
        instance = section.options.get("INSTANCE", "")
        if section.keyword == "NODE":
            ids, points = _nodes(section)
            self.node_ids.append(ids)
            self.points.append(points)
            self._add(self.nsets, section.options.get("NSET", ""), ids)
        elif section.keyword == "ELEMENT":
            block = _elements(section)
            ids = _first_numbers(section) if block is None else block.ids
            if block is None:
                self.others.append((section.options.get("TYPE", "").upper(), ids))
            else:
                self.blocks.append(block)
            self._add(self.elsets, section.options.get("ELSET", ""), ids)
        elif section.keyword == "NSET" and "ELSET" in section.options:
            chosen = self.chosen(self.elsets, section.options["ELSET"], instance)
            nodes = joined([b.rows[np.isin(b.ids, chosen)].reshape(-1) for b in self.blocks])
            if len(chosen) and not len(nodes):
                reason = f"element set {section.options['ELSET']!r}, none of whose elements is read"
                warn(f"node set {name!r} is left out: it takes the nodes of {reason}", MeshWarning)
                return
            self._add(self.nsets, name, nodes)
        elif section.keyword in ("NSET", "ELSET"):
            sets = self.nsets if section.keyword == "NSET" else self.elsets
            self._add(sets, name, self._ids(section, sets, instance))
        elif section.keyword == "SURFACE" and name:
            self.surfaces.append(section)

    def facing(self) -> list[Facing]:
        """Return the surfaces, with the numbers of their elements or nodes."""
        found = []
        for section in self.surfaces:
            if "COMBINE" in section.options:
                remedy = "export the surfaces that it is made of, or a set of its nodes"
                raise MeshFileError(f"surface {section.name!r} combines others (COMBINE); {remedy}")
            rows = [row for row in section.rows if row[0]]
            if section.options.get("TYPE", "ELEMENT").upper() == "NODE":
                nodes = joined([self.chosen(self.nsets, row[0]) for row in rows])
                found.append(Facing(section.name, nodes, []))
            else:
                faces = [(self.chosen(self.elsets, row[0]), row[1].upper() if len(row) > 1 else "") for row in rows]
                found.append(Facing(section.name, None, faces))
        return found

    def chosen(self, sets: dict[str, IntArray], word: str, instance: str = "") -> IntArray:
        """Return the numbers that a word means: a number or a set, both also of an instance, as in Part-1-1.top."""
        key = word.upper()
        if instance and instance.upper() not in self.offsets:
            raise MeshFileError(f"instance {instance!r} is used but not given; export the complete mesh")
        if word.isdigit():
            return np.array([_checked(int(word)) + self.offsets.get(instance.upper(), 0)])
        within = f"{instance.upper()}.{key}"
        owner, _, rest = key.rpartition(".")
        if within in sets:
            return sets[within]
        if key in sets:
            return sets[key]
        if owner in self.offsets and rest.isdigit():
            return np.array([_checked(int(rest)) + self.offsets[owner]])
        raise MeshFileError(f"set {word!r} is used before it is given; export the complete mesh")

    def _ids(self, section: Section, sets: dict[str, IntArray], instance: str) -> IntArray:
        """Return the numbers of a set's data lines: numbers, ranges (GENERATE) or names of earlier sets."""
        start = int(self.chosen(sets, "0", instance)[0])
        if "GENERATE" not in section.options:
            numbers = [_checked(int(word)) + start for word in section.words if word.isdigit()]
            named = [self.chosen(sets, word, instance) for word in section.words if not word.isdigit()]
            return joined([np.array(numbers, dtype=np.int64), *named])
        ranges = [[int(word) for word in row if word] for row in section.rows]
        if any(not 0 <= end <= MAXIMUM_IDS for r in ranges for end in r[:2]) or any(r[2:3] == [0] for r in ranges):
            raise MeshFileError("a generated set runs over more ids than a mesh has; export it anew")
        steps = [r[2] if len(r) > 2 else 1 for r in ranges]
        ends = [r[1] + (1 if step > 0 else -1) for r, step in zip(ranges, steps, strict=True)]
        return joined([start + np.arange(r[0], e, step) for r, e, step in zip(ranges, ends, steps, strict=True)])

    def _add(self, sets: dict[str, IntArray], name: str, ids: IntArray) -> None:
        key = name.upper()
        if key:
            self.spelling.setdefault(key, name)
            sets[key] = joined([sets[key], ids]) if key in sets else ids


def joined(arrays: list[IntArray]) -> IntArray:
    """Return numbers one after another, none for no arrays."""
    return np.concatenate([np.zeros(0, dtype=np.int64), *arrays]).astype(np.int64)


def _checked(number: int) -> int:
    """Return the number of a node or element."""
    if not 0 <= number < STRIDE:
        raise MeshFileError(f"the number {number} is none that a node or element may have; the file is damaged")
    return number


def _nodes(section: Section) -> tuple[IntArray, FloatArray]:
    if section.options.get("SYSTEM", "R").upper() != "R":
        raise MeshFileError("nodes in cylindrical or spherical coordinates; export rectangular ones")
    ids = np.array([_checked(int(row[0])) for row in section.rows], dtype=np.int64)
    xyz = [[_decimal(word) for word in [*row[1:], "", "", ""][:3]] for row in section.rows]
    return ids, np.array(xyz, dtype=np.float64).reshape(-1, 3)


def _decimal(word: str) -> float:
    """Return a number that may have an exponent as Fortran writes it, 1.0D-3; 0 where there is none."""
    return float(word.upper().replace("D", "E") or 0.0)


def _elements(section: Section) -> Block | None:
    """Return a block of elements; None for masses, springs and others that are no cells."""
    name = section.options.get("TYPE", "").upper()
    found = [(word, corners) for pattern, word, corners in _TYPES if re.fullmatch(pattern, name)]
    if not found:
        solid = "3D" in name and not name.startswith(("R", "M", "SF", "T", "CONN", "SPRING"))
        if solid or name.startswith(("SC6", "SC8", "CSS", "CCL")):
            raise MeshFileError(f"elements of type {name}; mesh with one of {_SOLIDS} alone")
        return None
    word, corners = found[0]
    numbers = np.array([_checked(int(w)) for w in section.words], dtype=np.int64)
    if len(numbers) % (corners + 1):
        if word == "line":  # beams may carry an orientation node
            return None
        raise MeshFileError(f"{name} elements with other than {corners} nodes; the file is cut or damaged")
    rows = numbers.reshape(-1, corners + 1)
    return Block(word, rows[:, 0], rows[:, 1:])


def _first_numbers(section: Section) -> IntArray:
    """Return the numbers of elements that are no cells, the first on each line.

    A long line with a comma at its end goes on in the next, unless all end so.
    """
    rows = section.rows
    goes_on = [False, *(len(row) > MAXIMUM_OTHER and not row[-1] and bool(rows[-1][-1]) for row in rows[:-1])]
    words = [row[0] for row, continued in zip(rows, goes_on, strict=False) if not continued]
    return np.array([_checked(int(word)) for word in words if word.isdigit()], dtype=np.int64)
