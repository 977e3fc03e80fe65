"""Friction of the contact nodes: what the kernels keep for it (METHOD 3)."""

from __future__ import annotations

import numpy as np

from .. import arrays
from ..friction_models import FrictionModel, RegularizedCoulomb, law_of
from ..plan import FRICTION_TERMS
from .constraint_rows import ConstraintRows


class Friction:
    """Arrays of the friction of one body; `stays`: it acts in massless components too.

    With friction layers they also limit it: `terms/friction_layer.py`.
    """

    def __init__(self, model: FrictionModel, nodes: int, stays: bool) -> None:
        from ..kernels import friction as names

        self.law = law_of(model)
        self.name = FRICTION_TERMS[type(model)]
        speed = model.slip_speed if isinstance(model, RegularizedCoulomb) else 1.0
        self.names, self.stays = names, stays
        rows = np.zeros((nodes, names.NODE))
        rows[:, names.LIMIT] = 1e300
        self.data = arrays.put(np.concatenate([[speed, 0.0], rows.ravel()]))
        self.rows: ConstraintRows

    def node(self, number: int) -> np.ndarray:
        """A number of every node [k], as placed in kernels/friction.py."""
        rows = arrays.get(self.data)[self.names.FIRST :].reshape(-1, self.names.NODE)
        return rows[:, number].copy()

    def owned(self) -> list[arrays.Array]:
        """Arrays of this term."""
        return [item for item in vars(self).values() if hasattr(item, "shape")]
