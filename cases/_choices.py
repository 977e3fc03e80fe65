"""Choices that the cases share: laws and ways to resolve contact by name; refusals of values that must be positive."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Literal

import tcontact as tc
from tcontact.mesh.elements import ELEMENTS
from tcontact.scene.materials import LAWS

Kind = Literal[tuple(ELEMENTS)]
Formulation = Literal["full", "reduced", "mean-dilatation"]
Law = Literal[tuple(LAWS)]
Contact = Literal["massless", "penalty", "impulse"]
ContactBetween = Literal["massless", "penalty"]
Removal = Literal["auto", "normal", "full"]


def material(law: Law, young: float, poisson: float, density: float) -> tc.Material:
    """Return the material of the named law. Raises `InputError`."""
    if law not in LAWS:
        raise tc.InputError("law", law, "use one of " + ", ".join(LAWS))
    return LAWS[law].of(young, poisson, density)


def contact_model(
    contact: Contact,
    *,
    removal: Removal,
    penalty: float | None,
    unit: float,
    depth: int,
    sweeps: int,
    tolerance: float | None,
    cell_viscosity: float | None = None,
) -> tc.MasslessContact | tc.PenaltyContact | tc.ImpulseContact:
    """Return the contact model of a name; penalty in multiples of unit = E/h [N/m^3]. Raises `InputError`."""
    if contact == "massless":
        stiffness = None if penalty is None else penalty * unit
        return tc.MasslessContact(removal, stiffness, depth, sweeps, tolerance, cell_viscosity)
    if contact == "penalty":
        return tc.PenaltyContact(stiffness=(10.0 if penalty is None else penalty) * unit)
    if contact == "impulse":
        return tc.ImpulseContact()
    raise tc.InputError("contact", contact, "use one of massless, penalty, impulse")


def with_penalty(scene: tc.Scene, contact: ContactBetween, penalty: float | None) -> tc.Scene:
    """Return a scene of massless contact between bodies with the contact of a name, a penalty on ordinary mass.

    penalty: in multiples of young/h of the slave (h: its shortest edge), None = 10. Raises `InputError`.
    """
    if contact == "penalty":
        unit = slave_stiffness(scene)
        return replace(scene, contact=tc.PenaltyContact(stiffness=(10.0 if penalty is None else penalty) * unit))
    if contact != "massless":
        raise tc.InputError("contact", contact, "use one of massless, penalty")
    if penalty is not None:
        raise tc.InputError("penalty", penalty, "contact=massless has none between bodies: give contact=penalty")
    return scene


def slave_stiffness(scene: tc.Scene) -> float:
    """Return young/h [N/m^3] of the slave of the first pair of a scene, h its shortest edge."""
    slave = scene.bodies[scene.body_pairs[0].slave]
    return slave.material.young / slave.mesh.shortest_edge


def beside_penalties(scene: Callable[..., tc.Scene], parameters: dict[str, object]) -> dict[str, tc.Scene]:
    """Return the scene of a case with massless nodes, and with the penalty given or with 1 and 10 young/h."""
    given = parameters.get("penalty")
    rest = {name: value for name, value in parameters.items() if name not in ("contact", "penalty")}
    found = {"massless": scene(**rest)}
    for penalty in (1.0, 10.0) if given is None else (given,):
        found[f"penalty {penalty:g} E/h"] = scene(**rest, contact="penalty", penalty=penalty)
    return found


def positive(**values: float | None) -> None:
    """Refuse the first parameter that is given and not above 0, or not finite, by its name. Raises `InputError`."""
    for name, value in values.items():
        if value is not None and not value > 0:
            raise tc.InputError(name, value, "must be greater than 0")
        if value == float("inf"):
            raise tc.InputError(name, value, "give a finite number")


def not_negative(**values: float) -> None:
    """Refuse the first parameter that is below 0 or not finite, by its name. Raises `InputError`."""
    for name, value in values.items():
        if not 0.0 <= value < float("inf"):
            raise tc.InputError(name, value, "give a number of at least 0")


def is_exact(scene: tc.Scene) -> bool:
    """Tell whether contact is the exact constraint on nodes without mass."""
    return isinstance(scene.contact, tc.MasslessContact) and scene.contact.penalty is None


def cells_of(mesh: tc.Mesh) -> int:
    """Return the number of cells of a box mesh as the user counts them: hexes, or the boxes that other cells fill."""
    return len(mesh.cells) // len(mesh.element.in_box)
