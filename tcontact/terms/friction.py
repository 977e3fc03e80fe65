"""Friction of the contact nodes: what the kernels keep for it (METHOD 3)."""

from __future__ import annotations

import numpy as np

from .. import arrays
from ..friction_models import FrictionModel, RegularizedCoulomb, law_of


class Friction:
    """Arrays of the friction of one body; `stays`: it acts in massless components too.

    With friction layers they also limit it: `terms/friction_layer.py`.
    """

    name = "friction"

    def __init__(self, model: FrictionModel, nodes: int, slots: int, stays: bool) -> None:
        self.law = law_of(model)
        speed = model.slip_speed if isinstance(model, RegularizedCoulomb) else 1.0
        self.settings = arrays.put(np.array([model.coefficient, speed, 0.0]))
        self.pressing = arrays.zeros(nodes * slots)
        self.limit, self.sliding = arrays.put(np.full(nodes, 1e300)), arrays.zeros(2 * nodes)
        self.rubbed = arrays.zeros(2 * nodes)
        count = nodes * slots * 3 if stays else 1
        self.traction, self.before = arrays.zeros(count), arrays.zeros(count)
        self.slip, self.directions = arrays.zeros(count), arrays.zeros(count)
        self.origin = arrays.zeros(3 * nodes if stays else 1)

    def owned(self) -> list[arrays.Array]:
        """Arrays of this term."""
        return [item for item in vars(self).values() if hasattr(item, "shape")]
