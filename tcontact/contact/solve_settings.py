"""The settings of a static solve (METHOD 2): when it has converged, and how far it goes for that."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..mesh.geometry import shortest_edge
from ..planning.domain import Domain
from ..planning.islands import Island
from ..scene.contact_models import MasslessContact
from ..scene.scene import Scene

TOLERANCE = 1e-4  # of the static residual, unless the user sets one
AIM = 1e-6  # residual that further sweeps aim at
LEFT = 1e-5  # share of the residual of a nonlinear law that the last use of a tangent may leave
METAL_LEFT = 3e-7  # the same of a metal: a point that begins to flow leaves up to 20 times as much as expected
POLISHING_SWEEPS = 60  # maximum below the tolerance, and per linearisation of a nonlinear law
MAXIMUM_SWEEPS = 500  # after which the solve of a linear law has not converged
LINEARISATIONS = 4  # a nonlinear law has this many times as many
PAIR_SOLVES = 3  # linear problems of a step with pairs of bodies, at most
METAL_SOLVES = 8  # the same with a metal, whose tangent changes within a step as fronts pass
REACH = 0.1  # largest move of a node per linearisation of a nonlinear law, over the shortest edge of the contact cells
STEP_LENGTH = 1.9  # of a projected step, times the bound of the largest eigenvalue; below 2 it converges
MINIMUM_FORCE = 1e-6  # F_ref is at least this times (lambda + 2 mu) times the mean area weight


def tolerance_of(scene: Scene) -> float:
    """Return the tolerance of the static residual over F_ref."""
    model = scene.contact
    assert isinstance(model, MasslessContact)
    return TOLERANCE if model.tolerance is None else model.tolerance


def solve_settings(scene: Scene, domain: Domain, islands: Sequence[Island]) -> np.ndarray:
    """Return the settings [islands, SETTINGS] of the static solve, in the order of kernels/static/control.py.

    Where ranks share the contact, domain and islands are those of all of them.
    """
    return np.stack([_settings(scene, domain, island) for island in islands])


def _settings(scene: Scene, domain: Domain, island: Island) -> np.ndarray:
    """Return the settings [SETTINGS] of an island."""
    from ..kernels.materials import LAWS
    from ..kernels.static import control as names

    contact, model = domain.contact, scene.contact
    blocks = [block for body in island.bodies for block in body.contact_blocks]
    materials = [block.own.material for block in blocks]
    materials = materials or [material for body in island.bodies for material in body.body.materials]
    graphs = [(body, body.contact.graph) for body in island.bodies if body.contact and body.contact.graph]
    assert isinstance(model, MasslessContact)
    assert contact is not None
    flat = all(obstacle.shape == "plane" for obstacle in scene.obstacles) and not island.coupled
    linear = flat and all(material.linear for material in materials)
    softest = [
        max(block.own.material.lame_lambda + 2.0 * block.own.material.lame_mu for block in body.contact_blocks)
        for body in island.bodies
        if body.contact_blocks
    ]
    stiffness = min(softest, default=0.0)
    settings = np.zeros(names.SETTINGS)
    settings[names.MINIMUM_SWEEPS] = model.sweeps
    settings[names.POLISHING_SWEEPS] = POLISHING_SWEEPS
    settings[names.MAXIMUM_SWEEPS] = MAXIMUM_SWEEPS if linear else POLISHING_SWEEPS
    settings[names.MAXIMUM_IN_ALL] = LINEARISATIONS * MAXIMUM_SWEEPS
    settings[names.AIM] = AIM if model.tolerance is None else model.tolerance
    settings[names.TOLERANCE] = tolerance_of(scene)
    metals = any(material.plastic for material in materials)
    settings[names.LEFT] = (METAL_LEFT if metals else LEFT) if model.tolerance is None else 0.0
    settings[names.MAXIMUM_SOLVES] = (METAL_SOLVES if metals else PAIR_SOLVES) if island.coupled else 0.0
    settings[names.REACH] = 1e300
    settings[names.LINEAR] = 1.0 if linear else 0.0
    settings[names.REFUSES] = 1.0 if any(LAWS[material.law].refusal for material in materials) else 0.0
    exact = model.penalty is None and scene.friction is None and island.removal == "full"
    elements = [block.own.facts for block in blocks or island.body.blocks]
    settings[names.RELAXATION] = min(element.relaxation for element in elements) if exact else 1.0
    settings[names.MINIMUM_FORCE] = 1.0  # no node: any reference of its residual, which is 0
    if graphs:
        if not linear:
            edges = [
                shortest_edge(body.reference, block.cells[block.contact])
                for body in island.bodies
                for block in body.contact_blocks
            ]
            settings[names.REACH] = REACH * min(edges)
        settings[names.MINIMUM_FORCE] = MINIMUM_FORCE * stiffness * float(contact.areas[island.nodes].mean())
        settings[names.STEP_LENGTH] = STEP_LENGTH / max(graph.corners_together for _, graph in graphs)
    return settings
