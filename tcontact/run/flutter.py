"""Warn of bodies that slide with so much friction that flutter takes some of it (METHOD 3).

With a Poisson's ratio near 1/2 a sliding face flutters whatever its contact nodes have of their mass: the contact force
swings about its mean, and the body slides faster than friction lets it. Below that only nodes that keep their
tangential mass do, in spite of the viscosity of their cells.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..scene.friction_models import FLUTTERS, FLUTTERS_SOFT
from ..scene.scene import Scene

SLID = 0.05  # work of friction over the largest energy above which a body slides


def flutter(scene: Scene, bodies: Sequence[Any]) -> str:
    """Return what to warn of if the bodies slide, "" without; bodies: their plans."""
    coefficient = scene.largest_friction
    touching = [plan for plan in bodies if plan.contact is not None]
    poisson = max((law.poisson for plan in touching for law in plan.body.materials), default=0.0)
    limit = min((mu for nu, mu in FLUTTERS_SOFT if poisson >= nu), default=float("inf"))
    if coefficient >= limit:
        return (
            f"flutter: what slides with a friction coefficient of {coefficient:g} and poisson {poisson:.4g} (from"
            f" {limit:g} on there) may swing between hard pressing and none, and lose some of its friction; look at"
            " contact_force in the history, and compare with a smaller coefficient or poisson"
        )
    if coefficient >= FLUTTERS and any(plan.contact.removal == "normal" for plan in touching):
        return (
            f"flutter: nodes that keep their tangential mass and slide with a friction coefficient of {coefficient:g}"
            f" (from {FLUTTERS:g} on) lose some of their friction; compare with MasslessContact(removal='full')"
        )
    return ""
