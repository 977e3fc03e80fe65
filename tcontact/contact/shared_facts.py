"""What a rank that shares a contact has from the whole domain beside its part of the contact lists."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from ..planning.domain import Domain
from ..planning.islands import islands_of
from ..planning.partition.domain_part import DomainPart
from ..scene.scene import Scene
from .pairs.surfaces import Surface, surfaces_of
from .solve_settings import solve_settings


class WholeContact:
    """The contact of a domain of all ranks, which has its cells."""

    def __init__(self, scene: Scene, domain: Domain) -> None:
        self.scene, self.domain = scene, domain

    @cached_property
    def _settings(self) -> np.ndarray:
        return solve_settings(self.scene, self.domain, islands_of(self.domain))

    @cached_property
    def _surfaces(self) -> list[Surface]:
        return surfaces_of(self.domain)

    def add_to(self, part: DomainPart) -> None:
        """Give a part the settings of the static solve and the surfaces of pairs, where its rank shares the contact."""
        own = part.domain
        if own.shared is None or not len(own.shared.nodes):
            return
        if own.shared.graph is not None:
            own.settings = self._settings[list(own.shared.islands)]
        if own.pairs:
            own.surfaces = [self._placed(one, part) for one in self._surfaces]

    def _placed(self, surface: Surface, part: DomainPart) -> Surface:
        """Return a surface in the numbering of a part, which has all its nodes."""
        body = part.domain.numbers.index(self.domain.numbers[surface.body])
        faces, nodes = (np.searchsorted(part.nodes, own) for own in (surface.faces, surface.nodes))
        return replace(surface, body=body, faces=faces, nodes=nodes)
