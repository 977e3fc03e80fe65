"""Slabs are pairs of parallel planes around a body in many directions: what is outside of one is not deep in it."""

from __future__ import annotations

import functools

import numpy as np

SLABS = 48


def within_slabs(nodes: np.ndarray, other: np.ndarray, deep: float) -> np.ndarray:
    """Return whether nodes [n, 3] are further than `deep` [m] inside the box and all slabs of a body, nodes [k, 3]."""
    found = ((nodes >= other.min(axis=0) + deep) & (nodes <= other.max(axis=0) - deep)).all(axis=1)
    if found.any():
        spans, own = other @ _slabs().T, nodes[found] @ _slabs().T
        found[found] = ((own >= spans.min(axis=0) + deep) & (own <= spans.max(axis=0) - deep)).all(axis=1)
    return np.asarray(found)


@functools.cache
def _slabs() -> np.ndarray:
    """Return the unit normals [SLABS, 3] of the slabs, on a spiral around half a sphere."""
    height = (np.arange(SLABS) + 0.5) / SLABS
    angle = np.pi * (1.0 + np.sqrt(5.0)) * np.arange(SLABS)
    radius = np.sqrt(1.0 - height**2)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)
