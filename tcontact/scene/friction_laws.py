"""The laws of friction of a scene by partner: every obstacle and every pair of bodies may have its own."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.errors import InputError
from ..kernels import lanes as at
from .friction_models import Coulomb, FrictionModel, FrictionTable, NoFriction, coefficient_of

AT_ONCE = 1e300  # decay [s/m] of a coefficient that is kinetic as soon as a node slips
UNLIMITED = 1e300  # shear stress [Pa] of a law without a limit


def joint_friction(scene: Any) -> FrictionModel | None:
    """Return the friction of a scene: its own, or a law with the coefficient 0 if only obstacles or pairs have some.

    `Coulomb` and `FrictionTable` go together. Raises `InputError` for other laws that differ in more than the
    coefficient.
    """
    friction = None if isinstance(scene.friction, NoFriction) else scene.friction
    own_laws = [(type(obstacle).__name__, obstacle.friction) for obstacle in scene.obstacles]
    own_laws += [("Pair", pair.friction) for pair in scene.pairs] if isinstance(scene.pairs, tuple) else []
    own_laws = [(name, own) for name, own in own_laws if own is not None and not isinstance(own, NoFriction)]
    if own_laws and coefficient_of(friction) == 0.0:
        friction = _kind(own_laws[0][1])
    for name, own in own_laws:
        if _kind(own) != _kind(friction):
            remedy = "Coulomb and FrictionTable go together, other laws in a scene differ in their coefficient only;"
            raise InputError(f"{name}.friction", own, f"{remedy} elsewhere it is {friction}")
    return friction


def _kind(model: Any) -> FrictionModel:
    """Return a law without friction of the kind of a law; laws of one kind can be in one scene."""
    if isinstance(model, Coulomb | FrictionTable | NoFriction):
        return Coulomb(0.0)
    return dataclasses.replace(model, coefficient=0.0)


def law_of_obstacle(scene: Any, index: int) -> FrictionModel | None:
    """Return the law of friction on an obstacle: its own or that of the scene."""
    own = scene.obstacles[index].friction
    return scene.friction if own is None else own


def laws_in_use(scene: Any) -> list[FrictionModel | None]:
    """Return the laws of all obstacles and all pairs of bodies."""
    return [law_of_obstacle(scene, i) for i in range(len(scene.obstacles))] + [p.friction for p in scene.body_pairs]


def is_constant(model: FrictionModel | None) -> bool:
    """Return whether a law is a coefficient alone."""
    return not isinstance(model, FrictionTable) and not (
        isinstance(model, Coulomb) and (model.coefficient is None or model.limit is not None)
    )


def varies(scene: Any) -> bool:
    """Return whether coefficients of rows change during a run: with slip speed, pressure or the nearest obstacles."""
    laws = laws_in_use(scene)
    several = len(scene.obstacles) > at.MAXIMUM_SLOTS and len({coefficient_of(law) for law in laws}) > 1
    return several or not all(map(is_constant, laws))


def row_coefficients(scene: Any, slots: int) -> np.ndarray:
    """Return the coefficient [slots] of every row of a node, of the first obstacles and then of the scene."""
    found = np.full(slots, coefficient_of(scene.friction))
    several = min(len(scene.obstacles), at.MAXIMUM_SLOTS)
    own = [coefficient_of(law_of_obstacle(scene, index)) for index in range(several)]
    found[: len(own)] = own
    return found


def law_data(scene: Any, pairs: Sequence[Any], areas: np.ndarray) -> np.ndarray | None:
    """Return the areas [k] [m^2] of contact nodes and the laws of pairs and obstacles; None if no coefficient varies.

    The numbers stand as in kernels/contact/friction_laws.py: areas, records of the laws, tables.
    """
    if not varies(scene):
        return None
    laws = [pair.friction for pair in pairs]
    laws += [law_of_obstacle(scene, index) for index in range(len(scene.obstacles))]
    return np.concatenate([areas, law_numbers(laws)])


def law_numbers(laws: Sequence[FrictionModel | None]) -> np.ndarray:
    """Return the records of laws, then their tables."""
    records, tables = np.zeros((len(laws), at.FRICTION_LAW)), [np.zeros(0)]
    start = records.size
    for record, law in zip(records, laws, strict=True):
        speeds, pressures, values = (0.0,), (0.0,), ((coefficient_of(law),),)
        record[at.SHEAR_LIMIT] = UNLIMITED
        if isinstance(law, FrictionTable):
            speeds, pressures, values = law.speeds, law.pressures, law.coefficients
        elif isinstance(law, Coulomb):
            record[at.SHEAR_LIMIT] = UNLIMITED if law.limit is None else law.limit
            if law.coefficient is None:
                record[at.JUMP] = law.static - law.kinetic  # type: ignore[operator]
                record[at.DECAY] = AT_ONCE if law.decay is None else law.decay
                values = ((float(law.kinetic),),)  # type: ignore[arg-type]
        record[at.TABLE], record[at.SPEEDS], record[at.PRESSURES] = start, len(speeds), len(pressures)
        tables.append(np.concatenate([speeds, pressures, np.ravel(values)]))
        start += len(tables[-1])
    return np.concatenate([records.reshape(-1), *tables])
