"""Probes: means over a set of a mesh that a run records at every step; and the quantities whose maxima it records."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..base import validate
from ..base.errors import InputError
from ..mesh.elements import ELEMENTS
from ..mesh.mesh import NO_SETS, Mesh
from .periodic import Images


class Quantity(NamedTuple):
    """What a probe measures: its unit, how many numbers it has, whether cells have it, and only those of metals."""

    unit: str
    size: int
    of_cells: bool = False
    of_metals: bool = False


QUANTITIES = {
    "displacement": Quantity("m", 3),
    "velocity": Quantity("m/s", 3),
    "acceleration": Quantity("m/s^2", 3),
    "position": Quantity("m", 3),
    "stress": Quantity("Pa", 6, of_cells=True),
    "von_mises": Quantity("Pa", 1, of_cells=True),
    "pressure": Quantity("Pa", 1, of_cells=True),
    "plastic_strain": Quantity("1", 1, of_cells=True, of_metals=True),
    "temperature": Quantity("K", 1, of_cells=True, of_metals=True),
}
MAXIMA = ("von_mises", "pressure", "plastic_strain")


@dataclass(frozen=True)
class Probe:
    """A mean over a set, recorded at every step: the history column `probe_<body>_<set>_<quantity>`.

    set: name of a set of the mesh; quantity: "displacement" [m], "velocity" [m/s], "acceleration" [m/s^2] or "position"
    [m], each 3 numbers: mean over the nodes of a node or face set, or of the cells of a cell set; "stress" [Pa] (Cauchy
    stress, 6 numbers in the order xx, yy, zz, xy, yz, xz), "von_mises" [Pa], "pressure" [Pa] (minus a third of the
    trace: positive in compression), and of metals "plastic_strain" [1] and "temperature" [K]: mean over the cells,
    weighted with their volume at rest, of a cell set, or over the cells that have a face of a face set or a node of a
    node set. A cell set goes first for the latter, a node or face set for the former, where several have the name. In a
    periodic body a node and its images count once, with the position of the first, and cells at any of them have it.

    All are values at the time of the row. Velocity is v = (v_before + v_after)/2 and acceleration (v_after - v_before)
    over the mean of the two steps, v_before and v_after those in the steps that end and start there; those of
    components without mass (contact nodes) are differences of displacements over the steps. Raises `InputError`.
    """

    set: str
    quantity: str

    def __post_init__(self) -> None:
        if not isinstance(self.set, str) or not self.set:
            raise InputError("Probe.set", self.set, "give the name of a set of the mesh")
        validate.choice("Probe.quantity", self.quantity, QUANTITIES)

    @property
    def facts(self) -> Quantity:
        """The record of its quantity."""
        return QUANTITIES[self.quantity]

    def nodes(self, mesh: Mesh, images: Images | None = None) -> np.ndarray:
        """Return the nodes [k] over which it takes the mean; masters if there are images."""
        if self.set in mesh.node_sets or self.set in mesh.face_sets:
            found = np.asarray(mesh.nodes_of(self.set))
        else:
            found = np.unique(mesh.cells[mesh.cell_sets[self.set]])
        return found if images is None else images.once(found)

    def cells(self, mesh: Mesh, images: Images | None = None) -> np.ndarray:
        """Return the cells [k] over which it takes the mean; of nodes those at any of their images."""
        if self.set in mesh.cell_sets:
            return np.unique(mesh.cell_sets[self.set])
        if self.set in mesh.face_sets:
            return cells_with_faces(mesh, mesh.face_sets[self.set])
        nodes = mesh.node_sets[self.set]
        return np.flatnonzero(np.isin(mesh.cells, nodes if images is None else images.with_images(nodes)).any(axis=1))


def cells_with_faces(mesh: Mesh, faces: np.ndarray) -> np.ndarray:
    """Return the cells [k] that have one of the faces [f, 4|3]."""
    wanted = {frozenset(face) for face in faces.tolist()}
    near, found, first = np.isin(mesh.cells, faces).sum(axis=1) >= 3, [], 0
    for kind, cells in mesh.blocks:
        for number in np.flatnonzero(near[first : first + len(cells)]):
            cell = cells[number].tolist()
            if any(frozenset(cell[corner] for corner in face) in wanted for face in ELEMENTS[kind].faces):
                found.append(first + int(number))
        first += len(cells)
    return np.array(found, dtype=np.int64)


def check_probes(probes: Sequence[Probe], mesh: Mesh, images: Images | None, blocks: Sequence[Any]) -> None:
    """Check the probes of a body with this mesh, these images and blocks of cells. Raises `InputError`."""
    metal = np.zeros(mesh.cell_count, dtype=bool)
    for block in blocks:
        metal[block.numbers] = block.material.plastic
    known, before = dict.fromkeys([*mesh.face_sets, *mesh.node_sets, *mesh.cell_sets]), set()
    for number, probe in enumerate(probes):
        field = f"Body.probes[{number}]"
        if probe.set not in known:
            have = f"use one of the sets of this mesh: {', '.join(known)}" if known else NO_SETS
            raise InputError(f"{field}.set", probe.set, have)
        found = probe.cells(mesh, images) if probe.facts.of_metals else np.zeros(0, dtype=np.int64)
        if not metal[found].all():
            remedy = (
                f"{int((~metal[found]).sum())} of {len(found)} cells of {probe.set!r} are of no metal, and have none;"
            )
            raise InputError(f"{field}.quantity", probe.quantity, f"{remedy} name a set of cells of a metal")
        if probe in before:
            raise InputError(field, probe, "is there twice; name it once")
        before.add(probe)


def checked_maxima(given: Any, plastic: bool) -> tuple[str, ...]:
    """Return the quantities whose maxima a scene records; plastic: it has a metal. Raises `InputError`."""
    named = validate.words("Scene.maxima", (given,) if isinstance(given, str) and given in MAXIMA else given, MAXIMA)
    if "plastic_strain" in named and not plastic:
        raise InputError("Scene.maxima", "plastic_strain", "the scene has no metal (ElastoPlastic); leave it out")
    if len(set(named)) < len(named):
        raise InputError("Scene.maxima", given, "a name is there twice; name it once")
    return named
