"""The search for the stable step of a body of a run."""

from __future__ import annotations

from typing import Any

from ..planning.body_plan import BodyPlan
from ..planning.closed_springs import spring_areas
from ..planning.pressure_rates import PressureRate
from ..scene.contact_models import PenaltyContact
from ..schemes.explicit.damped_step import ViscousForce
from ..schemes.explicit.stable_step import StableStep


def body_search(run: Any, plan: BodyPlan, viscous_force: ViscousForce | None = None) -> StableStep:
    """Return the search of a body; run: its scene, plan and scheme; viscous_force: of its contact cells."""
    scene, contact = run.scene, run.scene.contact
    stiffness = contact.stiffness if isinstance(contact, PenaltyContact) and not run.scheme.implicit else None
    springs = spring_areas(run.planned.bodies, scene.body_pairs, plan) if stiffness else None
    number = next(number for number, body in enumerate(run.planned.bodies) if body is plan)
    rate = max(domain.spring_rates.get(number, 0.0) for domain in run.planned.domains)
    pressure = PressureRate.of(plan, float(scene.duration))
    return StableStep(plan, scene.obstacles, stiffness, viscous_force, springs, rate, pressure)
