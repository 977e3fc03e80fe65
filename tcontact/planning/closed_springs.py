"""Springs that stand for the closed penalty of pairs of bodies in the stable step of each body.

A row couples a slave's node s with masters m by a spring k A_s. For any theta > 0 it stores at most as much as two
springs that each have one of the bodies at rest,

    (a_s - a_m)^2 <= (1 + theta) a_s^2 + (1 + 1/theta) a_m^2,

and theta = w_m/w_s makes both as fast as the two masses between the spring, w_s + w_m; w: largest area over mass of a
contact node. A master's node has its own area, or that of a larger slave's node upon it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..scene.pairs import BodyPair
from .body_plan import BodyPlan


def spring_areas(bodies: Sequence[BodyPlan], pairs: Sequence[BodyPair], body: BodyPlan) -> np.ndarray | None:
    """Return the area [k] [m^2] of the spring at every contact node of a body; None if it is in no pair."""
    found = None
    for pair in pairs:
        slave, master = bodies[pair.slave], bodies[pair.master]
        if body is not slave and body is not master:
            continue
        assert slave.contact is not None
        assert master.contact is not None
        areas = slave.contact.areas, np.maximum(master.contact.areas, slave.contact.areas.max())
        rates = [_rate(one, part) for one, part in zip((slave, master), areas, strict=True)]
        mine = 0 if body is slave else 1
        springs = areas[mine] * (1.0 + rates[1 - mine] / rates[mine])
        found = springs if found is None else np.maximum(found, springs)
    return found


def _rate(body: BodyPlan, areas: np.ndarray) -> float:
    assert body.contact is not None
    return float((areas / body.lumped[body.contact.nodes]).max())
