"""Forces, tangent blocks and energy of the cells of a body over a time step (METHOD 4).

Points, weights and shape gradients are computed once with numpy and stored; a one-point hex has the mean gradient of
its cell and the hourglass stiffness of kernels/elements/hex8_reduced.py, a quadratic energy of corotated differences.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from ....device import arrays
from ....device.launch import Prepared
from ....mesh.elements import HEX_CORNERS, shape_functions
from ....scene.cell_blocks import BodyBlock
from .sparsity import Sparsity, sparsity_of


@dataclass(frozen=True)
class Points:
    """Integration points: gradients [m, q, corners, 3] [1/m], weights [m, q] [m^3], hourglass stiffness [m, a, a]."""

    gradients: np.ndarray
    weights: np.ndarray
    stiffness: np.ndarray | None = None


def points_of(block: BodyBlock, reference: np.ndarray, cells: np.ndarray) -> Points:
    """Compute the integration points of cells [m, corners] at reference positions [n, 3]."""
    _values, slopes, weights = shape_functions(block.kind)
    corners = reference[cells]
    jacobian = np.einsum("mad,qac->mqdc", corners - corners[:, :1], slopes, optimize=True)
    gradients = np.einsum("qac,mqcd->mqad", slopes, np.linalg.inv(jacobian), optimize=True)
    volumes = weights * np.linalg.det(jacobian)
    if block.formulation != "reduced":
        return Points(gradients, volumes)
    volume = volumes.sum(axis=1)
    mean = np.einsum("mq,mqad->mad", volumes, gradients, optimize=True) / volume[:, None, None]
    from ....kernels.elements.hex8_reduced import HOURGLASS

    r = HEX_CORNERS
    modes = np.stack([r[:, 0] * r[:, 1], r[:, 0] * r[:, 2], r[:, 1] * r[:, 2], r.prod(axis=1)])  # [4, a]
    twist = np.einsum("ha,mad->mhd", modes, corners - corners[:, :1])
    gammas = modes - np.einsum("mhd,mad->mha", twist, mean)
    kappa = HOURGLASS * block.material.wave_modulus * volume * (mean**2).sum(axis=(1, 2)) / 8.0
    return Points(mean[:, None], volume[:, None], kappa[:, None, None] * np.einsum("mha,mhb->mab", gammas, gammas))


class Cells:
    """Forces and tangents of cells [m, corners] of a block over a step, by a rule of kernels/cells/implicit_rules.py.

    unknowns: nodes that have rows in the tangent, None = all. Arrays of points are shared by all rules.
    """

    def __init__(
        self, block: BodyBlock, reference: np.ndarray, cells: np.ndarray, unknowns: np.ndarray | None = None
    ) -> None:
        from ....kernels.cells import implicit_cells

        self.block, self.kernels = block, implicit_cells
        self.count, self.corners = cells.shape
        self.nodes = len(reference)
        points = points_of(block, reference, cells)
        self.per_cell = points.weights.shape[1]
        self.volume = points.weights.sum(axis=1)
        self.mean = block.formulation == "mean-dilatation"
        parameters = np.array(block.material.parameters)
        self.bulk = float(parameters[0]) if self.mean else 0.0
        if self.mean:
            parameters[0] = 0.0
        self.parameters = arrays.put(parameters)
        self.sparsity: Sparsity = sparsity_of(cells, self.nodes, unknowns)
        self.connectivity = arrays.put(cells.astype(np.int32))
        self.gradients = arrays.put(points.gradients)
        self.weights = arrays.put(points.weights)
        self.hourglass = points.stiffness is not None
        self.stiffness = arrays.put(np.zeros(1) if points.stiffness is None else points.stiffness)
        count = self.count * self.per_cell
        self.stress = arrays.zeros(9 * count)
        self.tangent = arrays.zeros(81 * count)
        self.measures = arrays.zeros(2 * count)
        self.slopes = arrays.zeros(18 * count if self.mean else 1)
        self.pressures = arrays.zeros(2 * self.count if self.mean else 1)
        self.change = arrays.zeros(self.count if self.mean else 1)
        self.corner_force = arrays.zeros(3 * self.corners * self.count)
        self.total = arrays.zeros(3 * self.nodes)
        self.u0, self.d = arrays.zeros(3 * self.nodes), arrays.zeros(3 * self.nodes)
        lists = self.sparsity
        self.slots, self.order = (arrays.put(item.astype(np.int32)) for item in (lists.slots, lists.order))
        self.node_starts = arrays.put(lists.node_starts.astype(np.int32))
        self.node_corners = arrays.put(lists.node_corners.astype(np.int32))
        self.blocks = arrays.zeros(9 * len(lists.columns))
        self._rules: dict[str, Any] = {}
        self._prepared: dict[str, Prepared] = {}

    def _points(self, rule: str) -> Any:
        from ....kernels.cells.implicit_points import make_points

        if rule not in self._rules:
            self._rules[rule] = Prepared(make_points(self.block.material.law, rule, self.mean))
        return self._rules[rule]

    def _launch(self, name: str, *arguments: Any) -> None:
        if name not in self._prepared:
            self._prepared[name] = Prepared(getattr(self.kernels, name))
        self._prepared[name](*arguments)

    def evaluate(self, rule: str, u0: np.ndarray, d: np.ndarray, tangents: bool = False, chi: float = 0.0) -> None:
        """Evaluate the points for a step from u0 to u0 + d, both [n, 3] [m]."""
        arrays.set_values(self.u0, u0)
        arrays.set_values(self.d, d)
        if self.mean:
            self._pressures(u0, d)
        self._points(rule)(
            self.corners, self.per_cell, int(tangents), float(chi), self.parameters,
            self.connectivity, self.gradients, self.weights, self.u0, self.d, self.pressures,
            self.stress, self.tangent, self.measures, self.slopes,
        )  # fmt: skip

    def _pressures(self, u0: np.ndarray, d: np.ndarray) -> None:
        levels = []
        linear = int(self.block.material.linear)
        where = arrays.zeros(3 * self.nodes)
        for u in (u0, u0 + d):
            arrays.set_values(where, u)
            self._launch(
                "dilatations", self.corners, self.per_cell, linear,
                self.connectivity, self.gradients, self.weights, where, self.change,
            )  # fmt: skip
            levels.append(np.array(arrays.get(self.change)))
        self._dilatation = levels[1]
        arrays.set_values(self.pressures, self.bulk * np.stack(levels, axis=1))

    def force(self, level: float) -> np.ndarray:
        """Return nodal forces [n, 3] [N] of the last evaluation; level: 1 for end values, 1/2 for those of mid-step."""
        self._launch(
            "cell_forces", self.corners, self.per_cell, float(level), int(self.hourglass),
            self.connectivity, self.gradients, self.stress, self.stiffness, self.u0, self.d, self.corner_force,
        )  # fmt: skip
        self._launch("node_sums", self.node_starts, self.node_corners, self.corner_force, self.total)
        return np.array(arrays.get(self.total)).reshape(-1, 3)

    def magnitude(self) -> float:
        """Return the largest force of a corner of a cell [N] in the last `force`, the scale of residuals."""
        return float(np.abs(arrays.get(self.corner_force)).max())

    def tangent_blocks(self, factor: float, level: float) -> np.ndarray:
        """Return blocks [b, 3, 3] of factor times d force/d u1 of the last evaluation with tangents."""
        arrays.set_values(self.blocks, np.zeros(9 * len(self.sparsity.columns)))
        starts = self.sparsity.colour_starts
        for begin, end in pairwise(starts):
            self._launch(
                "tangent_blocks", self.corners, self.per_cell, int(begin), int(end), float(factor),
                float(level if self.hourglass else 0.0), float(self.bulk), self.order, self.slots, self.gradients,
                self.weights, self.tangent, self.slopes, self.stiffness, self.blocks,
            )  # fmt: skip
        return np.array(arrays.get(self.blocks)).reshape(-1, 3, 3)

    def energy(self, u1: np.ndarray) -> tuple[float, float, float]:
        """Return elastic energy [J], smallest det F and hourglass energy [J] of the last evaluation, at u1."""
        measures = arrays.get(self.measures).reshape(-1, 2)
        elastic, against = float(measures[:, 0].sum()), 0.0
        if self.mean:
            elastic += 0.5 * self.bulk * float(self.volume @ self._dilatation**2)
        if self.hourglass:
            corners = u1[arrays.get(self.connectivity).reshape(-1, self.corners)]
            corners = corners - corners[:, :1]
            stiffness = arrays.get(self.stiffness).reshape(-1, self.corners, self.corners)
            against = 0.5 * float(np.einsum("mai,mab,mbi->", corners, stiffness, corners, optimize=True))
        return elastic + against, 1.0 + float(measures[:, 1].min()), against

    def owned(self) -> list[arrays.Array]:
        """Return its arrays."""
        return [item for item in vars(self).values() if hasattr(item, "shape")]
