"""Configurations of the benchmark: one for every process, and the rows it has to give."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from ...mesh.elements import ELEMENTS, FORMULATIONS
from ...scene import materials

UNCOMPARED = ("tet4-node-averaged",)  # takes several passes over the cells, and the plain step that it needs has one
SHAPES = ("hex8-skew", "hex8-turned", "hex8-distorted")  # hex8 is timed on boxes along the axes
KINDS = (*SHAPES, *(name for name in FORMULATIONS if name not in UNCOMPARED))
LAWS = tuple(materials.LAWS)
CONTACTS = ("none", "normal", "full")


@dataclass(frozen=True)
class Configuration:
    """Task of one process: a cube of size^3 hexes (six tets or two prisms for each), with and without contact in turns.

    kind: of KINDS, hex8 = boxes along the axes, hex8-turned = boxes turned about one, hex8-skew = parallelepipeds,
    hex8-distorted = inner nodes moved, hex8-reduced = one-point hexes, hex8-mean-dilatation = one volume change per
    hex; contacts: of "none", "normal" and "full" (removal of the massless contact on one face); threads: CPU threads;
    precision: "f64" or "mixed"; steps: per batch, None = chosen; seconds: time budget; batches: at least so many of
    each kind of work.
    """

    kind: str
    law: str
    size: int
    threads: int
    contacts: tuple[str, ...] = ("none",)
    arch: str = "cpu"
    precision: str = "f64"
    steps: int | None = None
    seconds: float = 10.0
    batches: int = 5

    @property
    def element(self) -> str:
        """Name of the element, whatever the shape of its cells."""
        return "hex8" if self.kind in SHAPES else self.kind

    @property
    def cells(self) -> int:
        """Number of cells."""
        return self.size**3 * len(ELEMENTS[self.kind.partition("-")[0]].in_box)

    def row(self, contact: str) -> dict[str, Any]:
        """Return the columns that name a row."""
        names = ("kind", "law", "size", "threads", "arch", "precision")
        return {name: getattr(self, name) for name in names} | {"cells": self.cells, "contact": contact}

    def failed(self, reason: str) -> list[dict[str, Any]]:
        """Return a row for every contact that could not be measured."""
        return [self.row(contact) | {"ok": False, "reason": reason} for contact in self.contacts]

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for the process that measures."""
        return asdict(self)

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Configuration:
        """Return the configuration of `to_dict`, by way of JSON too."""
        return cls(**{**data, "contacts": tuple(data["contacts"])})


def grid(
    kinds: Sequence[str], laws: Sequence[str], sizes: Sequence[int], threads: Sequence[int], **options: Any
) -> list[Configuration]:
    """Return all combinations, threads running fastest."""
    return [
        Configuration(kind, law, size, count, **options)
        for kind in kinds
        for law in laws
        for size in sizes
        for count in threads
    ]
