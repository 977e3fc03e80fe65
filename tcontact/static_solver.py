"""Which solver the static solve of a body takes: Gauss-Seidel sweeps, or MPRGP where they would stall (METHOD 2).

MPRGP needs at most one obstacle, no friction in the massless components and no penalty. Measured on one face of 32^3
hexahedra, a product of it takes as long as 1.0 to 1.3 sweeps, so that both cost the same at poisson .45 with full
removal (16 products, 21 sweeps); beyond it the sweeps grow like 1/(1 - 2 poisson), the products like its root. One
volume change per cell couples the nodes of normal removal in the same way, later; and cells much taller than wide have
a mode that is as soft as they are tall (sweeps at a ratio of 3, 10, 30, 100: 24, 93, 195, 559; products: 11 to 21).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .contact_models import MasslessContact
from .errors import InputError

if TYPE_CHECKING:
    from .plan import BodyPlan
    from .scene import Scene

FULL_POISSON = 0.45  # with full removal MPRGP takes over above it
MEAN_POISSON = 0.49  # with normal removal and one volume change per cell
ROUNDING = 1e-9  # of a Poisson's ratio that is computed from other moduli
TALL = 4.0  # height over width of the contact cells above which MPRGP takes over


@dataclass(frozen=True)
class StaticSolver:
    """Whether MPRGP solves instead of the sweeps, and why."""

    projected: bool
    reason: str

    def __str__(self) -> str:
        return f"{'MPRGP' if self.projected else 'Gauss-Seidel sweeps'}: {self.reason}"


def static_solver(scene: Scene, body: BodyPlan) -> StaticSolver:
    """The solver of a body with massless contact nodes; `InputError` where the scene asks for one that cannot do it."""
    model, contact = scene.contact, body.contact
    assert isinstance(model, MasslessContact)
    assert contact is not None
    hindrance = _hindrance(scene, contact.block)
    if model.solver == "projected-gradient" and hindrance:
        remedy = f"it does not solve for {hindrance}; leave it at 'auto'"
        raise InputError("MasslessContact.solver", model.solver, remedy)
    if model.solver != "auto":
        return StaticSolver(model.solver == "projected-gradient", "asked for")
    if hindrance:
        return StaticSolver(False, f"there is {hindrance}")
    poisson = body.body.material.poisson
    if contact.removal == "full" and poisson > FULL_POISSON + ROUNDING:
        return StaticSolver(True, f"poisson {poisson:.5g} with full removal")
    if body.body.formulation == "mean-dilatation" and poisson > MEAN_POISSON + ROUNDING:
        return StaticSolver(True, f"poisson {poisson:.5g} with one volume change per cell")
    tall = height_over_width(body)
    if tall > TALL:
        return StaticSolver(True, f"contact cells are {tall:.3g} times as tall as wide")
    return StaticSolver(False, "few will do")


def _hindrance(scene: Scene, block: int) -> str:
    """What MPRGP cannot solve for, "" if there is nothing."""
    if len(scene.obstacles) > 1:
        return "more than one obstacle"
    if scene.friction is not None and block > 1:
        return "friction in the static solve"
    model = scene.contact
    return "a penalty" if isinstance(model, MasslessContact) and model.penalty is not None else ""


def height_over_width(body: BodyPlan) -> float:
    """Median over the contact cells of the distance of their contact nodes from the others, over that among them."""
    assert body.contact is not None
    assert body.contact.graph is not None
    cells = body.cells[body.contact.graph.cells]
    named = cells if body.images is None else body.images.master[cells]
    massless = np.isin(named, body.contact.nodes)
    x = body.reference[cells]
    away = np.linalg.norm(x[:, :, None] - x[:, None], axis=-1)
    away[:, np.arange(cells.shape[1]), np.arange(cells.shape[1])] = np.inf
    one, other = massless[:, :, None], massless[:, None]
    height = np.where(one & ~other, away, np.inf).min(axis=(1, 2))
    width = np.where(one & other, away, np.inf).min(axis=(1, 2))
    both = np.isfinite(height) & np.isfinite(width)
    return float(np.median(height[both] / width[both])) if both.any() else 0.0
