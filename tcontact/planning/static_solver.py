"""Choose the solver of the static solve of a body: Gauss-Seidel sweeps, or MPRGP where they stall (METHOD 2).

MPRGP needs at most one obstacle, no friction in the massless components and no penalty; it solves alone, with any
number of obstacles, for bodies in contact with each other. Measured on one face of 32^3 hexahedra, one product takes as
long as 1.0 to 1.3 sweeps, so that both cost the same at poisson .45 with full removal (16 products, 21 sweeps); above
it the sweeps grow like 1/(1 - 2 poisson), the products like its root. With one volume change per cell this happens with
normal removal too, at a larger poisson. Contact cells much taller than wide have soft modes (sweeps at a ratio of 3,
10, 30, 100: 24, 93, 195, 559; products: 11 to 21).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..base.errors import InputError
from ..kernels.node_places import FRICTION_PLACES, PLACES
from ..scene.cell_blocks import AVERAGED, ROUNDING
from ..scene.contact_models import MasslessContact
from ..scene.friction_models import law_of
from ..scene.scene import Scene
from .body_plan import BodyPlan

FULL_POISSON = 0.45  # above it MPRGP solves with full removal
MEAN_POISSON = 0.49  # above it MPRGP solves with normal removal and one volume change per cell
# largest poisson at which the sweeps (False), or MPRGP (True), converge: with a mean dilatation with either removal,
# with volume changes averaged at nodes with full removal; with normal removal these have no limit
MAXIMUM_POISSON = {False: 0.499, True: 0.4999}
TALL = 4.0  # height over width of the contact cells above which MPRGP solves


@dataclass(frozen=True)
class StaticSolver:
    """The solver of a static solve (projected: one that needs no colours, else sweeps), the reason, and its name."""

    projected: bool
    reason: str
    name: str = ""

    def __str__(self) -> str:
        return f"{self.name or ('MPRGP' if self.projected else 'Gauss-Seidel sweeps')}: {self.reason}"


def static_solver(scene: Scene, body: BodyPlan) -> StaticSolver:
    """Choose the solver for massless contact nodes. Raises `InputError` if the one asked for does not apply."""
    model, contact = scene.contact, body.contact
    assert isinstance(model, MasslessContact)
    assert contact is not None
    paired = body.label in scene.paired_labels
    hindrance = _hindrance(scene, contact.block, paired)
    if model.solver == "projected-gradient" and hindrance:
        remedy = f"it does not solve for {hindrance}; leave it at 'auto'"
        raise InputError("MasslessContact.solver", model.solver, remedy)
    if paired:
        has_friction = scene.friction is not None and contact.block > 1
        return StaticSolver(
            True, "bodies in contact with each other", "accelerated projections" if has_friction else ""
        )
    if model.solver != "auto":
        return StaticSolver(model.solver == "projected-gradient", "asked for")
    if hindrance:
        return StaticSolver(False, f"there is {hindrance}")
    own = [block.own for block in body.contact_blocks]
    poisson = max((block.material.poisson for block in own), default=0.0)
    if contact.removal == "full" and poisson > FULL_POISSON + ROUNDING:
        return StaticSolver(True, f"poisson {poisson:.5g} with full removal")
    poisson = max((block.material.poisson for block in own if block.formulation == "mean-dilatation"), default=0.0)
    if poisson > MEAN_POISSON + ROUNDING:
        return StaticSolver(True, f"poisson {poisson:.5g} with one volume change per cell")
    tall = height_over_width(body)
    if tall > TALL:
        return StaticSolver(True, f"contact cells are {tall:.3g} times as tall as wide")
    return StaticSolver(False, "few will do")


def check_poisson(scene: Scene, body: BodyPlan) -> None:
    """Raise `InputError` where full removal makes the static solve of averaged volume changes ill-conditioned."""
    assert body.contact is not None
    own = [block.own for block in body.contact_blocks if block.own.formulation == AVERAGED]
    poisson = max((block.material.poisson for block in own), default=0.0)
    if body.contact.removal != "full" or not own:
        return
    limit = MAXIMUM_POISSON[static_solver(scene, body).projected]
    if poisson > limit + ROUNDING:
        remedy = f"{body.label} has poisson {poisson:.6g} and {AVERAGED!r}: use at most {limit:g} with full removal, or"
        remedy += " removal='normal' or PenaltyContact, which take any"
        raise InputError("MasslessContact.removal", "full", remedy)


def projected(scene: Scene, bodies: Iterable[BodyPlan]) -> bool:
    """Return whether MPRGP places the massless nodes of bodies that share a domain: they all have one solver."""
    massless = [body for body in bodies if body.contact is not None and body.contact.graph is not None]
    return any(static_solver(scene, body).projected for body in massless)


def response_components(scene: Scene, block: int, slots: int, coupled: bool, projects: bool) -> int:
    """Return the components of a contact node in `System.response` (kernels/node_places.py).

    block: its massless components; slots: its rows; coupled: its body is in a pair; projects: MPRGP solves.
    """
    if projects:
        places = PLACES[block]
        return (places.several_end if slots > 1 else places.coupled_end) if coupled else places.end
    in_lanes = block > 1 and slots == 1 and law_of(scene.friction) == "coulomb"
    return FRICTION_PLACES.end if in_lanes else block + 1


def _hindrance(scene: Scene, block: int, paired: bool) -> str:
    """Return what rules out MPRGP, or ""; paired: for a body in contact with others."""
    if len(scene.obstacles) > 1 and not paired:
        return "more than one obstacle"
    if scene.friction is not None and block > 1:
        return "friction in the static solve"
    model = scene.contact
    return "a penalty" if isinstance(model, MasslessContact) and model.penalty is not None else ""


def height_over_width(body: BodyPlan) -> float:
    """Return the median height over width of the contact cells; 0 if the static solve has no nodes.

    Height is the distance of contact nodes from the others, width that between contact nodes.
    """
    assert body.contact is not None
    found = []
    for block in body.contact_blocks:
        cells = block.rows[block.contact]
        named = cells if body.images is None else body.images.master[cells]
        massless = np.isin(named, body.contact.nodes)
        x = body.places[cells]
        away = np.linalg.norm(x[:, :, None] - x[:, None], axis=-1)
        away[:, np.arange(cells.shape[1]), np.arange(cells.shape[1])] = np.inf
        one, other = massless[:, :, None], massless[:, None]
        height = np.where(one & ~other, away, np.inf).min(axis=(1, 2))
        width = np.where(one & other, away, np.inf).min(axis=(1, 2))
        both = np.isfinite(height) & np.isfinite(width)
        found.append(height[both] / width[both])
    ratios = np.concatenate([np.zeros(0), *found])
    return float(np.median(ratios)) if len(ratios) else 0.0
