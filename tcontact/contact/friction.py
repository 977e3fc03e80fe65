"""Friction of the contact nodes: its arrays (METHOD 3)."""

from __future__ import annotations

import numpy as np

from ..device import arrays
from ..planning.body_plan import FRICTION_TERMS
from ..scene.friction_models import FrictionModel, RegularizedCoulomb, law_of
from .constraint_rows import ConstraintRows


class Friction:
    """Arrays of the friction of a domain; static_friction: friction acts in massless components too.

    laws: areas of the contact nodes and numbers of the laws (kernels/contact/friction_laws.py), None where all
    coefficients are constant.

    The subclass in `contact/layered_friction.py` also limits it by friction layers.
    """

    def __init__(self, model: FrictionModel, nodes: int, static_friction: bool, laws: np.ndarray | None = None) -> None:
        from ..kernels.contact import friction as names

        self.law = law_of(model)
        self.name = FRICTION_TERMS[type(model)]
        speed = model.slip_speed if isinstance(model, RegularizedCoulomb) else 1.0
        self.names, self.static_friction = names, static_friction
        rows = np.zeros((nodes, names.NODE))
        rows[:, names.LIMIT] = 1e300
        self.varied, self._nodes = laws is not None, slice(names.FIRST, names.FIRST + rows.size)
        self.data = arrays.put(np.concatenate([[speed, 0.0], rows.ravel(), np.zeros(0) if laws is None else laws]))
        self.rows: ConstraintRows

    def node(self, number: int) -> np.ndarray:
        """Return one number of every node [k], placed as in kernels/contact/friction.py."""
        return self.numbers(arrays.get(self.data))[:, number].copy()

    def numbers(self, data: np.ndarray) -> np.ndarray:
        """Return the part of the data that belongs to the contact nodes [k, NODE]."""
        return data[self._nodes].reshape(-1, self.names.NODE)

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of this term."""
        return [item for item in vars(self).values() if hasattr(item, "shape")]
