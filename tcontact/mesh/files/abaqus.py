"""Read Abaqus input files: nodes, elements, NSET, ELSET, SURFACE, instances; meshio misplaces their sets.

A file without instances is one part. With them it is an assembly: every instance is a copy of its part, moved and
turned, whose numbers and names hold within it. Names ignore case, as in Abaqus.
"""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import numpy as np

from ...base.warning_kinds import MeshWarning, warn
from ..elements import ELEMENTS
from ..geometry import IntArray
from .abaqus_assembly import Assembly
from .abaqus_scope import STRIDE, Facing, joined
from .abaqus_sections import read_sections
from .content import FileMesh, MeshFileError
from .second_order import SECOND_ORDER

_FACES = {element.meshio: element.abaqus_faces for element in ELEMENTS.values()}
_FACES |= {name: _FACES[first] for name, first in SECOND_ORDER.items() if first in _FACES}
_SURFACE_CELLS = ("triangle", "quad", "triangle6", "quad8", "quad9")


def read_abaqus(path: Path) -> FileMesh:
    """Read cells and sets of an Abaqus input file.

    NSET and node surfaces become node sets; ELSET and SURFACE become face sets where they name faces or surface
    elements, and sets of their nodes where they name volume or line elements; ELSET of volume elements is a cell set
    too. Names of NSET, ELSET and SURFACE are apart in Abaqus: a node set is that of the NSET or else of the node
    surface of its name, and of an ELSET only without these. Sets of Abaqus' own (_name) are left out, and those without
    an element that is read with a warning. Every instance and every part of an instance is a cell set; a set of
    an instance is called INSTANCE.SET if the assembly or another instance has one of that name. Ties and other
    constraints are not read.
    """
    assembly = Assembly()
    assembly.read(read_sections(path))
    if not assembly.points or not any(len(block.ids) for block in assembly.blocks):
        raise MeshFileError("holds no nodes or no known elements; export the mesh with *NODE and *ELEMENT")
    place = _Places(assembly, "node", assembly.node_ids)
    elements = _Places(assembly, "element", [block.ids for block in assembly.blocks])  # each once
    _tell_doubles(assembly, elements)
    blocks = [(block.cell_type, place.of(block.rows)) for block in assembly.blocks]
    content = FileMesh(np.concatenate(assembly.points), blocks)
    names = _names(assembly)
    surfaces = [(_surface_name(surface, assembly, names), surface) for surface in assembly.facing()]
    taken = _add_node_sets(content, assembly, place, names, surfaces)
    _add_element_sets(content, assembly, elements, names, taken)
    for name, surface in surfaces:
        _add_faces(content, assembly, surface, elements, name)
    _add_instances(content, assembly)
    return content


class _Places:
    """Maps numbers in the file to rows counted from 0."""

    def __init__(self, assembly: Assembly, what: str, ids: list[IntArray]) -> None:
        self.assembly, self.what = assembly, what
        given = joined(ids)
        self.order = np.argsort(given, kind="stable")
        self.ranked = given[self.order]
        double = self.ranked[1:][self.ranked[1:] == self.ranked[:-1]]
        if len(double):
            raise MeshFileError(f"{self.label(double[0])} is given twice; export one part with ids of its own")

    def of(self, ids: IntArray, user: str = "") -> IntArray:
        """Return the rows of numbers. Raises `MeshFileError` for those that are not given; user: what names them."""
        place = np.minimum(np.searchsorted(self.ranked, ids), len(self.ranked) - 1)
        missing = ids[self.ranked[place] != ids]
        if len(missing):
            where = f"{user}: " if user else ""
            raise MeshFileError(f"{where}{self.label(missing[0])} is used but not given; export the complete mesh")
        return self.order[place]

    def label(self, number: int) -> str:
        """Return a number as the file has it."""
        instance, own = divmod(int(number), STRIDE)
        owner = f" of instance {self.assembly.instances[instance - 1].name!r}" if instance else ""
        return f"{self.what} {own}{owner}"


def _names(assembly: Assembly) -> dict[str, str]:
    """Return what the sets of the file are called in the mesh, by their keys; those of Abaqus' own have no name."""
    keys = {*assembly.nsets, *assembly.elsets, *(section.name.upper() for section in assembly.surfaces)}
    keys |= {surface.name.upper() for surface in assembly.placed}
    short = {key: assembly.short.get(key, assembly.spelling.get(key, key)) for key in keys}
    counts = Counter(name.upper() for name in short.values())
    return {
        key: name if counts[name.upper()] == 1 or key not in assembly.short else assembly.spelling[key]
        for key, name in short.items()
        if not name.startswith("_")
    }


def _surface_name(surface: Facing, assembly: Assembly, names: dict[str, str]) -> str:
    """Return what a surface is called in the mesh: as it is written, with its instance where that is needed."""
    short = assembly.short.get(surface.name.upper(), surface.name)
    ambiguous = names.get(surface.name.upper(), surface.name).upper() == surface.name.upper()
    return surface.name if ambiguous else surface.name[-len(short) :]


def _add_node_sets(
    content: FileMesh,
    assembly: Assembly,
    place: _Places,
    names: dict[str, str],
    surfaces: list[tuple[str, Facing]],
) -> set[str]:
    """Add NSET, and node surfaces whose name no NSET has; return the names of both."""
    taken = {names[key] for key in assembly.nsets if key in names}
    for key, ids in assembly.nsets.items():
        if len(ids) and key in names:
            content.node_sets[names[key]] = place.of(ids, f"node set {assembly.spelling[key]!r}")
        elif key in names:
            warn(f"node set {names[key]!r} is left out: it is empty", MeshWarning)
    of_nodes: dict[str, IntArray] = {}
    for name, own in surfaces:
        if own.nodes is not None:  # a name that is given again adds to what it has
            of_nodes[name] = joined([of_nodes.get(name, own.nodes[:0]), place.of(own.nodes, f"surface {name!r}")])
    for name, rows in of_nodes.items():
        if name not in taken:
            content.node_sets[name] = rows
        elif not np.array_equal(np.unique(rows), np.unique(content.node_sets.get(name, rows[:0]))):
            warn(f"surface {name!r} is left out: a node set has its name and other nodes; rename it", MeshWarning)
    return taken | of_nodes.keys()


def _add_element_sets(
    content: FileMesh, assembly: Assembly, elements: _Places, names: dict[str, str], taken: set[str]
) -> None:
    """Add ELSET; warn of those without an element that is read. taken: names of node sets that are complete."""
    for key, chosen in assembly.elsets.items():
        if key in names:
            _tell_unknown(assembly, elements, chosen, f"element set {assembly.spelling[key]!r}")
            name, inside = names[key], [np.isin(block.ids, chosen) for block in assembly.blocks]
            parts = [rows[mask] for (_, rows), mask in zip(content.blocks, inside, strict=True)]
            _add_cells(content, name, parts, name in taken)
            _add_region(content, name, [np.flatnonzero(mask) for mask in inside])
            if not any(map(len, parts)):
                warn(f"element set {name!r} is left out: {_loss(assembly, chosen)}", MeshWarning)


def _add_cells(content: FileMesh, name: str, parts: list[IntArray], taken: bool) -> None:
    """Add elements by block to the face sets or, those of other dimensions, with their nodes to the node sets.

    taken: whether an NSET or a node surface has the name, whose nodes are then its own alone.
    """
    for (cell_type, _), rows in zip(content.blocks, parts, strict=True):
        if len(rows) == 0:
            continue
        if cell_type in _SURFACE_CELLS:
            content.face_sets.setdefault(name, []).append(rows)
        elif not taken:
            content.node_sets[name] = joined([content.node_sets.get(name, rows[:0].reshape(-1)), rows.reshape(-1)])


def _add_region(content: FileMesh, name: str, parts: list[IntArray]) -> None:
    """Add the volume elements among the elements by block to the cell sets."""
    solid = {
        number: cells
        for number, ((cell_type, _), cells) in enumerate(zip(content.blocks, parts, strict=True))
        if cell_type in _FACES and len(cells)
    }
    if solid:
        content.cell_sets[name] = solid


def _tell_doubles(assembly: Assembly, elements: _Places) -> None:
    """Warn of elements of kinds that are not read with the number of a cell, for which sets then stand."""
    for kind, ids in assembly.others:
        double = ids[np.isin(ids, elements.ranked)]
        if len(double):
            text = f"{elements.label(double[0])} is given twice, as a cell and as {kind}"
            warn(f"{text}: sets that name it hold the cell; give the {kind} elements other numbers", MeshWarning)


def _tell_unknown(assembly: Assembly, elements: _Places, chosen: IntArray, user: str) -> None:
    """Warn of elements that the file does not give; user: what names them."""
    known = np.concatenate([elements.ranked, *(ids for _, ids in assembly.others)])
    missing = chosen[~np.isin(chosen, known)]
    if len(missing):
        text = f"{user} names {len(missing)} elements that the file does not give, first {elements.label(missing[0])}"
        warn(f"{text}: they are left out", MeshWarning)


def _loss(assembly: Assembly, chosen: IntArray) -> str:
    """Return why a set of elements holds none that are read: it is empty, or they are of kinds that are no cells."""
    kinds = sorted({kind for kind, ids in assembly.others if np.isin(ids, chosen).any()})
    return f"its elements ({', '.join(kinds)}) are no cells that are read" if kinds else "it is empty"


def _add_faces(content: FileMesh, assembly: Assembly, surface: Facing, elements: _Places, name: str) -> None:
    for chosen, label in surface.faces:
        _tell_unknown(assembly, elements, chosen, f"surface {name!r}")
        if not any(np.isin(block.ids, chosen).any() for block in assembly.blocks):
            warn(f"part of surface {name!r} is left out: {_loss(assembly, chosen)}", MeshWarning)
        for block, (cell_type, rows) in zip(assembly.blocks, content.blocks, strict=True):
            rows = rows[np.isin(block.ids, chosen)]
            if len(rows) == 0:
                continue
            table = _FACES.get(cell_type, ())
            if cell_type in _SURFACE_CELLS:
                content.face_sets.setdefault(name, []).append(rows)
            elif re.fullmatch(r"S[1-6]", label) and int(label[1]) <= len(table):
                content.face_sets.setdefault(name, []).append(rows[:, table[int(label[1]) - 1]])
            else:
                warn(f"part of surface {name!r} is left out: no face {label or 'label'}", MeshWarning)


def _add_instances(content: FileMesh, assembly: Assembly) -> None:
    """Add a cell set for every instance and every part, unless a set of the file has that name."""
    taken = {name.upper() for name in (*content.node_sets, *content.face_sets, *content.cell_sets)}
    owners = [block.ids[0] // STRIDE if len(block.ids) else -1 for block in assembly.blocks]
    regions: dict[str, list[int]] = {}
    for number, instance in enumerate(assembly.instances, 1):
        regions[instance.name] = [number]
    for number, instance in enumerate(assembly.instances, 1):
        if instance.part.upper() not in {other.name.upper() for other in assembly.instances}:
            regions.setdefault(assembly.spelling_of_part(instance.part), []).append(number)
    for name, members in regions.items():
        if name.upper() not in taken:
            parts = [
                np.arange(len(block.ids) if owner in members else 0)
                for owner, block in zip(owners, assembly.blocks, strict=True)
            ]
            _add_region(content, name, parts)
