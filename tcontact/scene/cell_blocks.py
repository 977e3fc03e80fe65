"""The blocks of a body: its cells of one kind and one material, which have one element and one law in the kernels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..base import validate
from ..base.errors import InputError
from ..mesh.elements import ELEMENTS, Element
from ..mesh.late_rows import Rows
from ..mesh.mesh import Mesh
from .materials import LAWS, Material

AVERAGED = "node-averaged"  # formulation of cells whose volume change is averaged at nodes
ROUNDING = 1e-9  # error of a Poisson's ratio computed from other moduli
ONE_MATERIAL = "give a material, for example tcontact.NeoHookean(...), or a dict from names of cell sets to materials"


@dataclass(frozen=True, eq=False)
class BodyBlock:
    """The cells of a body with one element and one material.

    kind: of its cells; formulation: theirs; numbers [m]: of its cells in the mesh, ascending, or the slice of these;
    region: name of their cell set, None if the body has one material.
    """

    kind: str
    formulation: str
    material: Material
    numbers: np.ndarray | slice
    mesh: Mesh
    region: str | None = None

    @property
    def cells(self) -> np.ndarray:
        """The nodes [m, corners] of its cells."""
        return self._region if self.region is not None else dict(self.mesh.blocks)[self.kind]

    @property
    def rows(self) -> Rows:
        """`cells`, for what reads some of them at a time, see `Mesh.cell_rows`."""
        alone = self.region is None and len(self.mesh.cell_counts) == 1
        return self.mesh.cell_rows if alone else self.cells

    @property
    def count(self) -> int:
        """Number of its cells."""
        return self.numbers.stop - self.numbers.start if isinstance(self.numbers, slice) else len(self.numbers)

    @cached_property
    def _region(self) -> np.ndarray:
        first = 0
        for kind, rows in self.mesh.blocks:
            if kind == self.kind:
                break
            first += len(rows)
        return np.asarray(rows[self.numbers - first])  # type: ignore[operator]

    @property
    def facts(self) -> Element:
        """The record of their kind."""
        return ELEMENTS[self.kind]

    @property
    def element(self) -> str:
        """Name of the element in the kernels: the kind, with the formulation if not "full"."""
        return self.kind if self.formulation == "full" else f"{self.kind}-{self.formulation}"


def checked_material(material: Any, mesh: Mesh) -> Any:
    """Return the material, or a copy of the dict of materials by cell set. Raises `InputError`."""
    if isinstance(material, Material):
        return material
    if not isinstance(material, Mapping):
        raise InputError("Body.material", material, ONE_MATERIAL)
    if not material:
        raise InputError("Body.material", "empty dict", ONE_MATERIAL)
    have = ", ".join(map(repr, mesh.cell_sets)) or "none"
    for name, one in material.items():
        if not isinstance(name, str) or name not in mesh.cell_sets:
            remedy = f"names no cell set of the mesh; it has {have} (add sets with Mesh.with_sets(cell_sets=...))"
            raise InputError("Body.material", name, remedy)
        if not isinstance(one, Material):
            raise InputError(f"Body.material[{name!r}]", one, "give a material, for example tcontact.NeoHookean(...)")
    times = np.zeros(mesh.cell_count, dtype=np.int64)
    for name in material:
        before = times.copy()
        times[mesh.cell_sets[name]] += 1
        double = np.flatnonzero((times > 1) & (before > 0))
        if len(double):
            others = [other for other in material if other != name and double[0] in mesh.cell_sets[other]]
            remedy = f"{len(double)} of its cells, the first one {double[0]}, are also in {others[0]!r}; give every"
            remedy += " cell one material: take them out of one of the sets"
            raise InputError(f"Body.material[{name!r}]", name, remedy)
    missing = np.flatnonzero(times == 0)
    if len(missing):
        remedy = f"{len(missing)} of {mesh.cell_count} cells, the first one {missing[0]}, are in none of these sets;"
        remedy += f" the mesh has {have}: name further ones, or add one with Mesh.with_sets(cell_sets=...)"
        raise InputError("Body.material", [*material], remedy)
    return dict(material)


def suited_formulation(mesh: Mesh, material: Any) -> str | None:
    """Return the formulation of a body that names none; None if each material of tetrahedra has its own.

    Full integration locks in plastic flow, that of tetrahedra above poisson 0.4 too.
    """
    given = [*material.values()] if isinstance(material, Mapping) else [material]
    kinds = [ELEMENTS[kind] for kind, _ in mesh.cell_counts]
    if len(kinds) == 1 and AVERAGED in kinds[0].formulations:
        names = {_averaged_or_full(kinds[0], one) for one in given}
        return names.pop() if len(names) == 1 else None
    can = any("mean-dilatation" in kind.formulations for kind in kinds)
    if can and any(one.plastic for one in given) and all(one.volumetric for one in given):
        return "mean-dilatation"
    return "full"


def _averaged_or_full(element: Element, material: Material) -> str:
    locks = material.plastic or material.poisson > element.formulations["full"].locks + ROUNDING
    return AVERAGED if locks and material.volumetric and material.barotropic else "full"


def blocks_of(mesh: Mesh, material: Any, formulation: Any) -> tuple[BodyBlock, ...]:
    """Return the blocks of a body, kind after kind and material after material; `formulation` where a kind has it.

    formulation: None for what suits each material of tetrahedra. Raises `InputError` for a formulation that no kind of
    the mesh has, or that a law does not have.
    """
    kinds = [ELEMENTS[kind] for kind, _ in mesh.cell_counts]
    if formulation is not None:
        _check_formulation(formulation, kinds)
    regions = material.items() if isinstance(material, Mapping) else [(None, material)]
    found, first = [], 0
    for kind, count in mesh.cell_counts:
        for region, one in regions:
            numbers: np.ndarray | slice = slice(first, first + count)
            if region is not None:
                inside = mesh.cell_sets[region]
                numbers = inside[(inside >= first) & (inside < first + count)]
            own = formulation if formulation in ELEMENTS[kind].formulations else "full"
            if formulation is None:
                own = _averaged_or_full(ELEMENTS[kind], one)
            if isinstance(numbers, slice) or len(numbers):
                found.append(BodyBlock(kind, own, one, numbers, mesh, region))
        first += count
    for block in found:
        if block.formulation in ("mean-dilatation", AVERAGED) and not block.material.volumetric:
            raise InputError(
                "Body.formulation",
                formulation,
                f"{type(block.material).__name__} has no part that is of the volume change alone; use"
                f" {', '.join(law.__name__ for law in LAWS.values() if law.volumetric)}, or leave it at 'full'",
            )
        if block.formulation == AVERAGED and not block.material.barotropic:
            remedy = "its pressure depends on the heat of a cell, and a node averages the volume change alone; use"
            raise InputError("Body.formulation", formulation, f"{remedy} hexahedra, or pressure='bulk' or 'barrier'")
    return tuple(found)


def _check_formulation(formulation: Any, kinds: list[Element]) -> None:
    """Raise `InputError` for a formulation that these kinds of cells do not have."""
    known = dict.fromkeys(name for element in ELEMENTS.values() for name in element.formulations)
    validate.choice("Body.formulation", formulation, known)
    if not any(formulation in element.formulations for element in kinds):
        there = [kind for kind, element in ELEMENTS.items() if formulation in element.formulations]
        names = dict.fromkeys(name for element in kinds for name in element.formulations)
        remedy = f"{' and '.join(element.kind for element in kinds)} cells have {', '.join(map(repr, names))} alone;"
        remedy += f" leave it at 'full', or mesh the body with {' or '.join(there)}"
        raise InputError("Body.formulation", formulation, remedy)
    if formulation == AVERAGED and len(kinds) > 1:
        remedy = "it averages over tetrahedra alone; leave it out, or mesh the body with tet4"
        raise InputError("Body.formulation", formulation, remedy)
