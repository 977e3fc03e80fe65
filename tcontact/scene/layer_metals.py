"""The metals that meet in the friction layers of a scene: the sides of a layer are a body and what it slides on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..base.errors import InputError
from ..friction_layer.layer import METHODS
from ..friction_layer.metals import Metal
from .friction_models import FrictionLayer


@dataclass(frozen=True)
class LayerKind:
    """A kind of layer.

    metal: of the body with the contact nodes; partner: of the second side, None for one side; bodies: the second side
    is another body, not an obstacle.
    """

    metal: Metal
    partner: Metal | None
    bodies: bool = False

    @property
    def metals(self) -> tuple[Metal, ...]:
        """The metals of its sides."""
        return (self.metal,) if self.partner is None else (self.metal, self.partner)


def metal_of(scene: Any, index: int) -> Metal:
    """Return the metal of a body in the friction layers of a scene."""
    return scene.bodies[index].metal or scene.friction.material


def kinds_of(scene: Any, index: int) -> dict[tuple[str, int], LayerKind]:
    """Return the layer of the contact nodes of a body for everything that they may slide on.

    The keys are ("obstacle", its number), and ("body", number) of the masters of the body.
    """
    own = metal_of(scene, index)
    found = {("obstacle", n): LayerKind(own, obstacle.metal) for n, obstacle in enumerate(scene.obstacles)}
    masters = [pair.master for pair in scene.body_pairs if pair.slave == index]
    return found | {("body", master): LayerKind(own, metal_of(scene, master), True) for master in masters}


def all_kinds(scene: Any, bodies: Sequence[int]) -> dict[LayerKind, list[int]]:
    """Return the kinds of layers of some bodies of a scene, each with the numbers of the bodies that have it."""
    found: dict[LayerKind, list[int]] = {}
    for index in bodies:
        for kind in dict.fromkeys(kinds_of(scene, index).values()):
            found.setdefault(kind, []).append(index)
    return found


def check_metals(scene: Any) -> None:
    """Refuse metals that start molten, and methods that do not solve two sides. Raises `InputError`."""
    model = scene.friction
    if not isinstance(model, FrictionLayer):
        return
    owners = [("Body.metal", body) for body in scene.bodies]
    owners += [(f"{type(obstacle).__name__}.metal", obstacle) for obstacle in scene.obstacles]
    for field, owner in owners:
        if owner.metal is not None and owner.metal.melting_temperature <= model.initial_temperature:
            remedy = f"it melts at {owner.metal.melting_temperature:g} K and the layers start at"
            raise InputError(field, owner.metal, f"{remedy} {model.initial_temperature:g} K; start below")
    two = any(
        kind.partner is not None for index in range(len(scene.bodies)) for kind in kinds_of(scene, index).values()
    )
    if two and model.method != METHODS[0]:
        remedy = f"layers with two sides (obstacles with a metal, pairs of bodies) are solved by {METHODS[0]!r} only"
        raise InputError("FrictionLayer.method", model.method, remedy)
