"""Read Abaqus input files: nodes, elements, NSET, ELSET, SURFACE; meshio misplaces their sets.

A file has one part, in whose coordinates the mesh is read. Names ignore case, as in Abaqus.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...base.warning_kinds import MeshWarning, warn
from ..elements import ELEMENTS
from ..geometry import FloatArray, IntArray
from .content import FileMesh, MeshFileError

# element type pattern -> (meshio's word, corners)
_TYPES = [
    *((f"D?{element.abaqus}[A-Z]*", element.meshio, element.corners) for element in ELEMENTS.values()),
    (r"D?C3D10[A-Z]*", "tetra10", 10),
    (r"D?C3D15[A-Z]*", "wedge15", 15),
    (r"D?C3D20[A-Z]*", "hexahedron20", 20),
    (r"(S|STRI|R3D|M3D|SFM3D|CPS|CPE|DS)3[A-Z]*", "triangle", 3),
    (r"(S|R3D|M3D|SFM3D|CPS|CPE|DS)4[A-Z0-9]*", "quad", 4),
    (r"T[23]D2[A-Z]*|B[23]1[A-Z]*", "line", 2),
]
_FACES = {element.meshio: element.abaqus_faces for element in ELEMENTS.values()}
_SOLIDS = ", ".join(sorted(element.abaqus for element in ELEMENTS.values()))
MAXIMUM_IDS = 2**28  # in a generated set
_UNKNOWN = {"NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "INCLUDE"}


@dataclass
class _Section:
    keyword: str
    options: dict[str, str]
    rows: list[list[str]]

    def ids(self, sets: dict[str, IntArray]) -> IntArray:
        """Return the ids of a set's data lines: numbers, ranges (GENERATE) or names of earlier sets."""
        if "GENERATE" in self.options:
            ranges = [[int(word) for word in row if word] for row in self.rows]
            if any(abs(end) > MAXIMUM_IDS or r[2:3] == [0] for r in ranges for end in r[:2]):
                raise MeshFileError("a generated set runs over more ids than a mesh has; export it anew")
            return _joined([np.arange(r[0], r[1] + 1, r[2] if len(r) > 2 else 1) for r in ranges])
        words = [word for row in self.rows for word in row if word]
        return _joined(
            [np.array([int(w) for w in words if w.isdigit()])] + [_set(sets, w) for w in words if not w.isdigit()]
        )


@dataclass
class _Block:
    cell_type: str
    ids: IntArray
    rows: IntArray


def read_abaqus(path: Path) -> FileMesh:
    """Read cells and sets of an Abaqus input file.

    NSET and node surfaces become node sets; ELSET and SURFACE become face sets where they name faces or surface
    elements, and sets of their nodes where they name volume or line elements; ELSET of volume elements is a cell set
    too. Sets of Abaqus' own (_name) are left out.
    """
    node_ids: list[IntArray] = []
    points: list[FloatArray] = []
    blocks: list[_Block] = []
    nsets: dict[str, IntArray] = {}
    elsets: dict[str, IntArray] = {}
    surfaces: list[_Section] = []
    spelling: dict[str, str] = {}
    instances: list[dict[str, str]] = []
    for section in _sections(path):
        name = section.options.get("NAME" if section.keyword == "SURFACE" else section.keyword)
        key = (name or "").upper()
        if name:
            spelling.setdefault(key, name)
        if section.keyword in _UNKNOWN:
            raise MeshFileError(
                f"*{section.keyword} is not understood; export the mesh with all nodes and elements written out"
            )
        if section.keyword == "NODE":
            ids, xyz = _nodes(section)
            node_ids.append(ids)
            points.append(xyz)
            if "NSET" in section.options:
                _add(nsets, spelling, section.options["NSET"], ids)
        elif section.keyword == "ELEMENT":
            block = _elements(section)
            if block is not None:
                blocks.append(block)
                if "ELSET" in section.options:
                    _add(elsets, spelling, section.options["ELSET"], block.ids)
        elif section.keyword == "NSET" and name:
            if "ELSET" in section.options:
                chosen = _set(elsets, section.options["ELSET"])
                ids = _joined([b.rows[np.isin(b.ids, chosen)].reshape(-1) for b in blocks])
            else:
                ids = section.ids(nsets)
            _add(nsets, spelling, name, ids)
        elif section.keyword == "ELSET" and name:
            _add(elsets, spelling, name, section.ids(elsets))
        elif section.keyword == "SURFACE" and name:
            surfaces.append(section)
        elif section.keyword == "INSTANCE":
            instances.append(section.options)
            if any(word not in ("", "0", "0.") for row in section.rows for word in row):
                warn("the position of *INSTANCE is ignored; coordinates are the part's own", MeshWarning)
    _check_instances(instances)
    if not points or not blocks:
        raise MeshFileError("holds no nodes or no known elements; export the mesh with *NODE and *ELEMENT")

    labels = np.concatenate(node_ids)
    place = _Places(labels)
    content = FileMesh(np.concatenate(points), [(b.cell_type, place.of(b.rows)) for b in blocks])
    for key, ids in nsets.items():
        if len(ids) and not key.startswith("_"):
            content.node_sets[spelling[key]] = place.of(ids)
    _Places([i for b in blocks for i in b.ids.tolist()], "element")  # each id once
    for key, chosen in elsets.items():
        if not key.startswith("_"):
            inside = [np.isin(b.ids, chosen) for b in blocks]
            parts = [(b.cell_type, place.of(b.rows[mask])) for b, mask in zip(blocks, inside, strict=True)]
            _add_cells(content, spelling[key], parts)
            solid = [number for number, b in enumerate(blocks) if b.cell_type in _FACES and inside[number].any()]
            if solid:
                content.cell_sets[spelling[key]] = {number: np.flatnonzero(inside[number]) for number in solid}
    for section in surfaces:
        _add_surface(content, section, blocks, place, nsets, elsets)
    return content


def _check_instances(instances: list[dict[str, str]]) -> None:
    """Warn that several instances make one mesh. Raises `MeshFileError` if several instances share one part."""
    if len(instances) < 2:
        return
    names = " and ".join(repr(options.get("NAME", "")) for options in instances)
    parts = [options["PART"].upper() for options in instances if "PART" in options]
    remedy = "export each into a file of its own and make a Body of each"
    if len(set(parts)) < len(parts):
        raise MeshFileError(f"the instances {names} share a part, whose mesh is in the file once; {remedy}")
    warn(f"the instances {names} become one mesh, and so one body; {remedy}", MeshWarning)


class _Places:
    """Maps ids in the file to rows counted from 0."""

    def __init__(self, ids: IntArray | list[int], what: str = "node") -> None:
        self.order = np.argsort(ids, kind="stable")
        self.ranked = np.asarray(ids)[self.order]
        double = self.ranked[1:][self.ranked[1:] == self.ranked[:-1]]
        if len(double):
            raise MeshFileError(f"{what} {double[0]} is given twice; export one part with ids of its own")

    def of(self, ids: IntArray) -> IntArray:
        place = np.minimum(np.searchsorted(self.ranked, ids), len(self.ranked) - 1)
        missing = ids[self.ranked[place] != ids]
        if len(missing):
            raise MeshFileError(f"node {missing[0]} is used but not given; export the complete mesh")
        return self.order[place]


def _sections(path: Path) -> Iterator[_Section]:
    current: _Section | None = None
    keyword_goes_on = False
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        if line.startswith("**") or not line.strip():
            continue
        if line.startswith("*") or keyword_goes_on:
            words = [word.strip() for word in line.lstrip("*").split(",")]
            if not keyword_goes_on:
                if current is not None:
                    yield current
                current = _Section(" ".join(words.pop(0).upper().split()), {}, [])
            for word in filter(None, words):
                option, _, value = word.partition("=")
                assert current is not None
                current.options[option.strip().upper()] = value.strip().strip('"')
            keyword_goes_on = line.rstrip().endswith(",")
        elif current is not None:
            current.rows.append([word.strip() for word in line.split(",")])
    if current is not None:
        yield current


def _nodes(section: _Section) -> tuple[IntArray, FloatArray]:
    if section.options.get("SYSTEM", "R").upper() != "R":
        raise MeshFileError("nodes in cylindrical or spherical coordinates; export rectangular ones")
    ids = np.array([int(row[0]) for row in section.rows], dtype=np.int64)
    xyz = [[float(word or 0.0) for word in [*row[1:], "", "", ""][:3]] for row in section.rows]
    return ids, np.array(xyz, dtype=np.float64).reshape(-1, 3)


def _elements(section: _Section) -> _Block | None:
    """Return a block of elements; None for masses, springs and others that are no cells."""
    name = section.options.get("TYPE", "").upper()
    found = [(word, corners) for pattern, word, corners in _TYPES if re.fullmatch(pattern, name)]
    if not found:
        solid = "3D" in name and not name.startswith(("R", "M", "SF", "T", "CONN", "SPRING"))
        if solid or name.startswith(("SC6", "SC8", "CSS", "CCL")):
            raise MeshFileError(f"elements of type {name}; mesh with one of {_SOLIDS} alone")
        return None
    word, corners = found[0]
    numbers = np.array([int(w) for row in section.rows for w in row if w], dtype=np.int64)
    if len(numbers) % (corners + 1):
        if word == "line":  # beams may carry an orientation node
            return None
        raise MeshFileError(f"{name} elements with other than {corners} nodes; the file is cut or damaged")
    rows = numbers.reshape(-1, corners + 1)
    return _Block(word, rows[:, 0], rows[:, 1:])


def _add(sets: dict[str, IntArray], spelling: dict[str, str], name: str, ids: IntArray) -> None:
    key = name.upper()
    spelling.setdefault(key, name)
    sets[key] = _joined([sets[key], ids]) if key in sets else ids


def _set(sets: dict[str, IntArray], name: str) -> IntArray:
    if name.upper() not in sets:
        raise MeshFileError(f"set {name!r} is used before it is given; export the complete mesh")
    return sets[name.upper()]


def _joined(arrays: list[IntArray]) -> IntArray:
    return np.concatenate([np.zeros(0, dtype=np.int64), *arrays]).astype(np.int64)


def _add_cells(content: FileMesh, name: str, parts: list[tuple[str, IntArray]]) -> None:
    for cell_type, rows in parts:
        if len(rows) == 0:
            continue
        if cell_type in ("triangle", "quad"):
            content.face_sets.setdefault(name, []).append(rows)
        else:
            content.node_sets[name] = _joined([content.node_sets.get(name, rows[:0].reshape(-1)), rows.reshape(-1)])


def _add_surface(
    content: FileMesh,
    section: _Section,
    blocks: list[_Block],
    place: _Places,
    nsets: dict[str, IntArray],
    elsets: dict[str, IntArray],
) -> None:
    name = section.options["NAME"]
    if section.options.get("TYPE", "ELEMENT").upper() == "NODE":
        words = [row[0] for row in section.rows if row[0]]
        ids = _joined([np.array([int(w)]) if w.isdigit() else _set(nsets, w) for w in words])
        content.node_sets[name] = place.of(ids)
        return
    for row in section.rows:
        chosen = np.array([int(row[0])]) if row[0].isdigit() else _set(elsets, row[0])
        label = row[1].upper() if len(row) > 1 else ""
        for block in blocks:
            rows = place.of(block.rows[np.isin(block.ids, chosen)])
            if len(rows) == 0:
                continue
            table = _FACES.get(block.cell_type, ())
            if block.cell_type in ("triangle", "quad"):
                content.face_sets.setdefault(name, []).append(rows)
            elif re.fullmatch(r"S[1-6]", label) and int(label[1]) <= len(table):
                content.face_sets.setdefault(name, []).append(rows[:, table[int(label[1]) - 1]])
            else:
                warn(f"part of surface {name!r} is left out: no face {label or 'label'}", MeshWarning)
