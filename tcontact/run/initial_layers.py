"""The friction layers of another run in the terms of the scene that starts with them.

A body has a layer for every kind of what it may slide on (scene/layer_metals.py). Each of them goes on as one layer of
the same kind, where there is one; else as that on the same partner, else on one of the same metal. Where the metal of
the partner is another one, the body's own side goes on and the partner's side starts new. What a body is, or was as a
master, stays: its metal is that of the run before.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from ..base.errors import InputError
from ..friction_layer import LayerState
from ..friction_layer.grid import depths
from ..results.result import Result
from ..scene.friction_models import FrictionLayer
from ..scene.layer_metals import LayerKind, kinds_of, metal_of
from ..scene.scene import Scene

On = dict[LayerKind, set[tuple[str, str]]]  # what each layer of a body is on: ("obstacle" or "body", its name)
PROFILES = ("rise", "growth", "hardening", "carried")  # of `Layer.state`


def layers_of(scene: Scene, initial: Result) -> tuple[LayerState | None, ...]:
    """Return the friction layers of another run with which this one starts, by the kinds of this scene.

    Raises `InputError` if they do not fit.
    """
    model = scene.friction
    if not isinstance(model, FrictionLayer):
        return ()
    depth = depths(model.points, model.grading, model.thickness)
    for index, layers in enumerate(initial.layers):
        if layers is None:
            continue
        if not (np.isfinite(layers.temperature).all() and np.isfinite(layers.plastic_strain).all()):
            raise InputError(
                "initial", initial.reason, "its friction layers are not finite; start from a run that finished"
            )
        if not layers.fits(metal_of(scene, index), depth):
            remedy = "its friction layers are of another metal or other depths; give the FrictionLayer of that run"
            raise InputError("initial", initial, f"{remedy} (material, points, grading, thickness)")
    return tuple(
        None if layers is None else _in_terms_of(scene, initial.scene, index, layers)
        for index, layers in enumerate(initial.layers)
    )


def _in_terms_of(scene: Scene, before: Scene, index: int, layers: LayerState) -> LayerState:
    """Return the layers of a body with the kinds that they have in this scene. Raises `InputError`."""
    stored = _stored_kinds(before, index, layers)
    holding = {kind for place, kind in enumerate(stored) if _holds(layers, place, kind)}
    _check_masters(scene, before, index, holding)
    found = _successors(scene, before, index, stored, holding)
    internal = dict(layers.internal)
    for place, old in enumerate(stored):
        new = found.get(old)
        if new is None or (new.partner, new.bodies) == (old.partner, old.bodies):
            continue
        for name in PROFILES:
            if f"{place}/{name}" in internal:
                internal[f"{place}/{name}"] = internal[f"{place}/{name}"][:, : len(layers.depth)]
        internal[f"{place}/own"] = np.array(True)
    return replace(layers, internal=internal, kinds=tuple(found.get(old) for old in stored))


def _stored_kinds(before: Scene, index: int, layers: LayerState) -> list[LayerKind]:
    """Return the kinds of the stored layers; a state of an earlier version says them in part, the scene the rest."""
    if layers.kinds:
        return list(layers.kinds)
    left, found = list(_on(before, index)), []
    for partner in layers.partners:
        kind = next(kind for kind in left if (kind.partner, kind.bodies) == partner)
        left.remove(kind)
        found.append(kind)
    return found


def _on(scene: Scene, index: int) -> On:
    """Return what each layer of a body is on, by the names of obstacles and bodies."""
    found: On = {}
    for (what, number), kind in kinds_of(scene, index).items():
        name = scene.obstacle_label(number) if what == "obstacle" else str(number)
        found.setdefault(kind, set()).add((what, name))
    return found


def _holds(layers: LayerState, place: int, kind: LayerKind) -> bool:
    """Return whether stored layers differ from new ones."""
    rise, growth, base = (layers.internal[f"{place}/{name}"] for name in ("rise", "growth", "base"))
    starts = np.repeat(kind.temperatures, len(layers.depth)) - base
    return bool(growth.any() or (rise != starts).any())


def _check_masters(scene: Scene, before: Scene, index: int, holding: set[LayerKind]) -> None:
    """Refuse other metals of masters, and masters that are slaves now, whose sides are in layers of this body.

    Raises `InputError`.
    """
    now = kinds_of(scene, index)
    for key, old in kinds_of(before, index).items():
        what, number = key
        if what != "body" or old not in holding:
            continue
        there, slave = scene.label(number), scene.label(index)
        if key in now and now[key].partner != old.partner:
            field = "Body.metal" if scene.bodies[number].metal is not None else "FrictionLayer.material"
            remedy = f"{there} had another metal in the run of initial, which left its side of the friction layers of"
            raise InputError(field, now[key].partner, f"{remedy} {slave}; give the metal of that run")
        if ("body", index) in kinds_of(scene, number):
            remedy = f"the friction layers between {slave} and {there} are those of {slave}, the slave in that run;"
            raise InputError("initial", slave, f'{remedy} give Pair(slave="{slave}")')


def _successors(
    scene: Scene, before: Scene, index: int, stored: list[LayerKind], holding: set[LayerKind]
) -> dict[LayerKind, LayerKind]:
    """Return the layer of this scene as which each stored layer goes on, none twice; some may have none.

    holding: the stored layers that differ from new ones. Raises `InputError` where layers would become one or several.
    """
    then, now = _on(before, index), _on(scene, index)
    found: dict[LayerKind, LayerKind] = {}
    left = list(now)

    def match(fits: Callable[[LayerKind, LayerKind], bool]) -> None:
        for old in stored:
            new = None if old in found else next((kind for kind in left if fits(old, kind)), None)
            if new is not None:
                found[old] = new
                left.remove(new)

    def meets(old: LayerKind, new: LayerKind) -> bool:
        return not then.get(old, set()).isdisjoint(now[new])

    def alike(old: LayerKind, new: LayerKind) -> bool:
        return (old.partner, old.bodies) == (new.partner, new.bodies)

    match(lambda old, new: old == new)
    match(lambda old, new: alike(old, new) and meets(old, new))
    match(lambda old, new: alike(old, new) and not new.bodies)
    match(meets)
    for old in stored:
        rest = left if old in found else now
        several = [new for new in rest if old in holding and meets(old, new)]
        if several:
            on = set().union(then[old], *(now[new] for new in several))
            names = " and ".join(sorted(_names(scene, on)))
            remedy = f"the friction layers of {scene.label(index)} on {names} are one in that run or in this one and"
            remedy += " several in the other; give obstacles the metals of that run, and new ones names or last places"
            raise InputError("initial", names, remedy)
    match(lambda old, new: True)
    return found


def _names(scene: Scene, on: Iterable[tuple[str, str]]) -> list[str]:
    """Return the names of obstacles and bodies for messages."""
    return [scene.label(int(name)) if what == "body" else name for what, name in on]
