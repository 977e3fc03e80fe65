"""The metals that meet in the friction layers of a scene: the sides of a layer are a body and what it slides on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.errors import InputError
from ..friction_layer.layer import METHODS
from ..friction_layer.metals import Metal
from .friction_models import FrictionLayer
from .metals import ElastoPlastic


@dataclass(frozen=True)
class LayerKind:
    """A kind of layer.

    metal: of the body with the contact nodes; partner: of the second side, None for one side; bodies: the second side
    is another body, not an obstacle; open_ends: whether the cells of the body on each side keep a temperature, so that
    heat flows between them and the far end of the layer; temperatures [K]: at which each side starts.
    """

    metal: Metal
    partner: Metal | None
    bodies: bool = False
    open_ends: tuple[bool, ...] = (False,)
    temperatures: tuple[float, ...] = ()

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
    own, warm, cold = metal_of(scene, index), _temperature(scene, index), scene.friction.initial_temperature
    keeps = keeps_heat(scene.bodies[index])
    found = {}
    for number, metal in enumerate(obstacle.metal for obstacle in scene.obstacles):
        sides = ((keeps, False), (warm, cold)) if metal is not None else ((keeps,), (warm,))
        found["obstacle", number] = LayerKind(own, metal, False, *sides)
    for master in (pair.master for pair in scene.pairs_at[index] if pair.slave == index):
        ends, starts = (keeps, keeps_heat(scene.bodies[master])), (warm, _temperature(scene, master))
        found["body", master] = LayerKind(own, metal_of(scene, master), True, ends, starts)
    return found


def keeps_heat(body: Any) -> bool:
    """Return whether all cells at the contact faces of a body keep a temperature."""
    return all(isinstance(one, ElastoPlastic) and one.specific_heat is not None for one in _touching(body))


def _touching(body: Any) -> list[Any]:
    """Return the materials of the cells at the contact faces of a body, of all cells where it has no such faces."""
    if len(body.blocks) == 1:
        return list(body.materials)
    at = np.zeros(body.mesh.node_count, dtype=bool)
    at[body.contact_nodes] = True
    return [block.material for block in body.blocks if at[block.cells].any()] or list(body.materials)


def warms_bodies(scene: Any) -> bool:
    """Return whether friction layers give heat to cells."""
    return any(any(kind.open_ends) for kind in all_kinds(scene, range(len(scene.bodies))))


def _temperature(scene: Any, index: int) -> float:
    """Return the temperature [K] at which the sides of layers of a body start: its highest, if its cells keep one.

    At the first touch they take that of the cells there (`HeatExchange`).
    """
    body = scene.bodies[index]
    if not keeps_heat(body):
        return float(scene.friction.initial_temperature)
    return float(max(one.initial_temperature for one in _touching(body)))


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
    for index, body in enumerate(scene.bodies):
        field = "Body.metal" if body.metal is not None else "FrictionLayer.material"
        _check_solid(field, metal_of(scene, index), _temperature(scene, index))
    for obstacle in scene.obstacles:
        if obstacle.metal is not None:
            _check_solid(f"{type(obstacle).__name__}.metal", obstacle.metal, model.initial_temperature)
    two = any(
        kind.partner is not None for index in range(len(scene.bodies)) for kind in kinds_of(scene, index).values()
    )
    if two and model.method != METHODS[0]:
        remedy = f"layers with two sides (obstacles with a metal, pairs of bodies) are solved by {METHODS[0]!r} only"
        raise InputError("FrictionLayer.method", model.method, remedy)


def _check_solid(field: str, metal: Metal, temperature: float) -> None:
    """Refuse a metal that is molten at the temperature [K] at which its layers start. Raises `InputError`."""
    if metal.melting_temperature <= temperature:
        remedy = f"it melts at {metal.melting_temperature:g} K and its layers start at {temperature:g} K; start below"
        raise InputError(field, metal, remedy)
