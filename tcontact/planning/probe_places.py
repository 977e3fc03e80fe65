"""Nodes and cells of the probes of a body, with their weights in the means.

    <q> = sum_i w_i q_i,       w_i = 1/k of k nodes, images counted once, V_i/sum_j V_j of cells

Where several ranks have parts of a body, each adds what its own cells, and the nodes that it counts, have of the sum.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..mesh.mesh import Mesh
from ..scene.body import Body
from ..scene.periodic import Images
from ..scene.probes import Probe


@dataclass(frozen=True, eq=False)
class ProbePlace:
    """What a probe takes its mean over.

    items [k]: nodes of the mesh, or its cells, by what the probe measures; weights [k]: theirs in the mean.
    """

    probe: Probe
    items: np.ndarray
    weights: np.ndarray

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Return the mean of values [rows, k, ..] of its items; of a part of a body, its share of the mean."""
        weights = self.weights.reshape(-1, *(1,) * (values.ndim - 2))
        return np.asarray(np.ascontiguousarray(values * weights).sum(axis=1))  # the same bits for any number of rows

    def part(self, numbers: np.ndarray, counted: np.ndarray) -> ProbePlace:
        """Return what a part of the mesh has of it.

        numbers: of the nodes or cells of the part in the mesh, ascending; counted: whether the part counts each.
        """
        place = np.minimum(np.searchsorted(numbers, self.items), max(len(numbers) - 1, 0))
        here = (numbers[place] == self.items) & counted[place] if len(numbers) else np.zeros(len(place), dtype=bool)
        return replace(self, items=place[here], weights=self.weights[here])


def probe_places(body: Body) -> tuple[ProbePlace, ...]:
    """Return the places of the probes of a body."""
    return tuple(_place(probe, body.mesh, body.images) for probe in body.probes)


def _place(probe: Probe, mesh: Mesh, images: Images | None) -> ProbePlace:
    if probe.facts.of_cells:
        items = probe.cells(mesh, images)
        volumes = mesh.cell_volumes()[items]
        return ProbePlace(probe, items, volumes / volumes.sum())
    items = probe.nodes(mesh, images)
    return ProbePlace(probe, items, np.full(len(items), 1.0 / len(items)))
