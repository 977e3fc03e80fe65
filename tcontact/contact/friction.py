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
    coefficients are constant; recorded: slip and work of every node are summed up, for frames
    (kernels/contact/friction_record.py).

    The subclass in `contact/layered_friction.py` also limits it by friction layers.
    """

    def __init__(
        self,
        model: FrictionModel,
        nodes: int,
        static_friction: bool,
        laws: np.ndarray | None = None,
        recorded: bool = False,
    ) -> None:
        from ..kernels.contact import friction as names
        from ..kernels.contact.friction_record import RECORD

        self.law = law_of(model)
        self.name = FRICTION_TERMS[type(model)]
        speed = model.slip_speed if isinstance(model, RegularizedCoulomb) else 1.0
        self.names, self.static_friction = names, static_friction
        rows = np.zeros((nodes, names.NODE))
        rows[:, names.LIMIT] = 1e300
        self.varied, self.recorded = laws is not None, recorded
        self._nodes = slice(names.FIRST, names.FIRST + rows.size)
        self._record = RECORD * nodes * recorded
        further = np.zeros(0) if laws is None else laws
        parts = [np.array([speed, 0.0]), rows.ravel(), further, np.zeros(self._record)]
        self.data = arrays.put(np.concatenate(parts))
        self.rows: ConstraintRows

    def node(self, number: int) -> np.ndarray:
        """Return one number of every node [k], placed as in kernels/contact/friction.py."""
        return self.numbers(arrays.get(self.data))[:, number].copy()

    def numbers(self, data: np.ndarray) -> np.ndarray:
        """Return the part of the data that belongs to the contact nodes [k, NODE]."""
        return data[self._nodes].reshape(-1, self.names.NODE)

    @property
    def record_width(self) -> int:
        """Return how many numbers of the record a node has; the record stands at the end of the data."""
        from ..kernels.contact.friction_record import RECORD

        return RECORD * self.recorded

    def record(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the slip path [k] [m] and the friction work [k] [J] of every node up to the last row."""
        from ..kernels.contact.friction_record import DONE, RECORD, SLIP

        data = arrays.get(self.data)
        rows = np.array(data[len(data) - self._record :]).reshape(-1, RECORD)
        return rows[:, SLIP], rows[:, DONE]

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of this term."""
        return [item for item in vars(self).values() if hasattr(item, "shape")]
