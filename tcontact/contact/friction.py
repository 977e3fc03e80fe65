"""Friction of the contact nodes: its arrays (METHOD 3)."""

from __future__ import annotations

import numpy as np

from ..device import arrays
from ..planning.body_plan import FRICTION_TERMS
from ..scene.friction_models import FrictionModel, RegularizedCoulomb, law_of
from .constraint_rows import ConstraintRows


class Friction:
    """Arrays of the friction of a domain; static_friction: friction acts in massless components too.

    The subclass in `contact/layered_friction.py` also limits it by friction layers.
    """

    def __init__(self, model: FrictionModel, nodes: int, static_friction: bool) -> None:
        from ..kernels.contact import friction as names

        self.law = law_of(model)
        self.name = FRICTION_TERMS[type(model)]
        speed = model.slip_speed if isinstance(model, RegularizedCoulomb) else 1.0
        self.names, self.static_friction = names, static_friction
        rows = np.zeros((nodes, names.NODE))
        rows[:, names.LIMIT] = 1e300
        self.data = arrays.put(np.concatenate([[speed, 0.0], rows.ravel()]))
        self.rows: ConstraintRows

    def node(self, number: int) -> np.ndarray:
        """Return one number of every node [k], placed as in kernels/contact/friction.py."""
        rows = arrays.get(self.data)[self.names.FIRST :].reshape(-1, self.names.NODE)
        return rows[:, number].copy()

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of this term."""
        return [item for item in vars(self).values() if hasattr(item, "shape")]
