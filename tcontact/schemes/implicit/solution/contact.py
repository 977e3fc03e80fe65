"""Contact of a body in an implicit step: its nodes, their obstacles, penalty or exact contact (METHOD 4)."""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np

from ....planning.body_plan import BodyPlan
from ....scene.contact_models import MasslessContact, PenaltyContact
from ....scene.scene import Scene
from .exact import ExactContact
from .penalty import PenaltyForce
from .surfaces import Curved, Flat, Passage, Round, surface_of

ROUNDING = 1e-13  # gaps below this share of the size of the body are closed


class StepContact:
    """Contact of the nodes [k] with the obstacles over a step.

    penalty is None for exact contact; exact is None for a penalty and where supports hold all nodes; held [k, 3, 3]:
    projector on the components that contact cannot move.
    """

    def __init__(self, scene: Scene, plan: BodyPlan, held: np.ndarray) -> None:
        assert plan.contact is not None
        assert scene.contact is not None
        self.nodes = plan.contact.nodes
        self.reference = plan.reference[self.nodes]
        self.all_nodes, self.all_reference = plan.contact.all_nodes, plan.reference[plan.contact.all_nodes]
        self.size = float(np.ptp(plan.reference, axis=0).max())
        self.surfaces: list[Flat | Round | Curved] = [surface_of(item, self.size) for item in scene.obstacles]
        model = scene.contact
        per_area = model.stiffness if isinstance(model, PenaltyContact) else getattr(model, "penalty", None)
        self.massless = isinstance(model, MasslessContact) and len(self.nodes) > 0
        self.penalty = None if per_area is None else PenaltyForce(self.surfaces, per_area * plan.contact.areas)
        self.exact: ExactContact | None = None
        if per_area is None and len(self.nodes):  # if supports hold every contact node, only gaps are measured
            self.exact = ExactContact(np.eye(3) - held[self.nodes], len(self.surfaces))

    def moved_along(self, held: np.ndarray) -> StepContact:
        """Return the same contact of nodes of which some components more are held; held [k, 3, 3]: projector on them.

        Its forces balance the residual in the free components alone: along a normal that is not one of these, a part
        would be left that no motion of the nodes can balance.
        """
        found = copy(self)
        if found.exact is not None:
            found.exact = ExactContact(np.eye(3) - held, len(self.surfaces))
        return found

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape of contact forces: obstacles, nodes, components."""
        return len(self.surfaces), len(self.nodes), 3

    def passages(self, u0: np.ndarray, d: np.ndarray) -> list[Passage]:
        """Return the passages of the contact nodes at every obstacle from u0 to u0 + d [n, 3]."""
        x0 = self.reference + u0[self.nodes]
        return [surface.passage(x0, x0 + d[self.nodes]) for surface in self.surfaces]

    def along(self, u0: np.ndarray, d: np.ndarray, level: float) -> list[Passage]:
        """Return passages from u0 to u0 + d [n, 3] whose normals are those of a level between, as in u0 + level d."""
        x0, move = self.reference + u0[self.nodes], d[self.nodes]
        middles = [surface.at(x0 + level * move) for surface in self.surfaces]
        ends = middles if level == 1.0 else [surface.at(x0 + move) for surface in self.surfaces]
        pairs = zip(ends, middles, strict=True)
        return [replace(end, normal=middle.normal, turning=level * middle.turning) for end, middle in pairs]

    def ends(self, u: np.ndarray) -> list[Passage]:
        """Return passages with the gaps and normals of one level u [n, 3]."""
        x = self.reference + u[self.nodes]
        return [surface.at(x) for surface in self.surfaces]

    def at(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return penalty forces [p, k, 3] and tangent [k, 3, 3] at one level."""
        assert self.penalty is not None
        return self.penalty.at(self.reference + u[self.nodes])

    def closed(self, unbalanced: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return forces [p, k, 3] of exact contact at u [n, 3] that balance the residual [n, 3]."""
        assert self.exact is not None
        passages = self.ends(u)
        self.exact.balance(unbalanced[self.nodes], passages, self.tolerance)
        return self.exact.force(passages)

    def conserving(self, u0: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return conserving penalty forces [p, k, 3] and tangent [k, 3, 3] of a step."""
        assert self.penalty is not None
        x0 = self.reference + u0[self.nodes]
        return self.penalty.conserving(x0, x0 + d[self.nodes])

    def loads(self, force: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return force [N] and moment [N m] about its reference point on every obstacle [p, 6], contact at u [n, 3]."""
        x = self.reference + u[self.nodes]
        arms = [x - surface.obstacle.reference for surface in self.surfaces]
        moments = [-np.cross(arm, part).sum(axis=0) for arm, part in zip(arms, force, strict=True)]
        return np.concatenate([-force.sum(axis=1), np.array(moments)], axis=1)

    def energy(self, u: np.ndarray) -> float:
        """Return the penalty energy [J]."""
        return 0.0 if self.penalty is None else self.penalty.energy(self.reference + u[self.nodes])[0]

    def gap_min(self, u: np.ndarray) -> float:
        """Return the smallest gap [m] of the contact set."""
        x = self.all_reference + u[self.all_nodes]
        return float(min(surface.gap(x).min() for surface in self.surfaces))

    @property
    def tolerance(self) -> float:
        """Gap [m] that counts as closed."""
        return ROUNDING * self.size
