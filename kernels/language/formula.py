"""A strain energy with its first and second derivative, for numbers; what the kernels compute is checked against it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from .expressions import Derivative, NotPlain, values
from .traced_energy import SIDES, Strain, traced


class Formula:
    """The formula of energy(strain, **parameters) and its derivatives along H, as expressions.

    names: of the parameters. Raises `NotPlain` for a function that is no plain arithmetic.
    """

    def __init__(self, energy: Callable[..., Any], names: tuple[str, ...]) -> None:
        self.function, self.names = energy, names
        try:
            self.traced = traced(energy, names)
        except NotPlain:
            raise
        except Exception as error:
            raise NotPlain(f"it failed: {type(error).__name__}: {error}") from error
        graph, strain = self.traced.graph, self.traced.strain
        self.energy = self.traced.energy
        self.stress = graph.gradient(self.energy, strain)
        slopes = [Derivative(graph, {one: graph.of(1.0)}) for one in strain]
        self.tangent = [slope(stress) for stress in self.stress for slope in slopes]

    def at(self, what: list[Any], h: np.ndarray, given: Mapping[str, float]) -> np.ndarray:
        """Return expressions [..., k] at displacement gradients [..., 3, 3]."""
        symbols = {f"h{i}{j}": h[..., i, j] for i, j in SIDES}
        symbols |= {f"p{k}": np.float64(given[name]) for k, name in enumerate(self.names)}
        found = values(self.traced.graph, what, symbols)
        return np.stack([np.broadcast_to(one, h.shape[:-2]) for one in found], axis=-1)

    def direct(self, h: np.ndarray, given: Mapping[str, float]) -> np.ndarray:
        """Return what the function itself gives for displacement gradients [n, 3, 3]."""
        try:
            with np.errstate(all="ignore"):
                return np.array([complex(self.function(Strain(gradient=one), **given)) for one in h])
        except Exception as error:
            raise NotPlain(f"it failed for numbers: {type(error).__name__}: {error}") from error
