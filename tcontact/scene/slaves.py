"""Which body of a pair is the slave, whose contact nodes get the constraint rows (METHOD 7).

A total order of the bodies decides, the lower one of a pair is the slave: bodies with held contact nodes come last;
then by stiffness (lambda + 2 mu of the material, over that of the softest body) in powers of 2, by the mean area of a
contact face, by the place in the scene. A body that bends where its partner is flat and coarse (`bends`) goes before
it all the same, at the cost of more products in the static solve.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ..base.errors import InputError
from .bends import Skin, bent_one
from .body import Body
from .contact_models import MasslessContact
from .meeting import area_vectors

STIFF = 4.0  # stiffness of a slave over that of its master above which a run warns
PRODUCTS, MORE = 25.0, 34.0  # products of a static solve with a soft slave, and more for every factor of 10 (measured)
LEAST = float(np.finfo(float).tiny)  # [Pa], where processors take smaller numbers for 0


def places_of(bodies: Sequence[Body], pairs: Iterable[tuple[int, int]]) -> list[int]:
    """Return the place of every body in the order of slaves, the first one is slave of all others.

    pairs: numbers of the two bodies of those pairs whose slave is not given. Bodies keep their order but for those that
    bend, which go before their partners.
    """
    keys = _keys(bodies)
    before = _bent_before(bodies, pairs)
    order: list[int] = []
    met: set[int] = set()
    for body in sorted(range(len(bodies)), key=keys.__getitem__):
        waiting = [body]
        while waiting:  # those that go before it come first, those that go before them before these
            ahead = [one for one in before.get(waiting[-1], ()) if one not in met and one not in waiting]
            if ahead:
                waiting.append(min(ahead, key=keys.__getitem__))
                continue
            done = waiting.pop()
            if done not in met:
                met.add(done)
                order.append(done)
    place = {body: number for number, body in enumerate(order)}
    return [place[body] for body in range(len(bodies))]


def _keys(bodies: Sequence[Body]) -> list[tuple[bool, int, float, int]]:
    """Return the key of every body in the order by stiffness and size of faces.

    Nodes that supports hold in all components cannot be slaves: bodies with such contact nodes come last.
    """
    softest = min(stiffness(body) for body in bodies)
    for index, body in enumerate(bodies):
        if not np.isfinite(stiffness(body)):
            raise InputError(
                f"Scene.bodies[{index}].material", body.material, "its stiffness overflows; look at the units"
            )
    keys = []
    for index, body in enumerate(bodies):
        power = round(float(np.log2(max(stiffness(body), LEAST)) - np.log2(max(softest, LEAST))))
        keys.append((held(body), power, mean_area(body), index))
    return keys


def _bent_before(bodies: Sequence[Body], pairs: Iterable[tuple[int, int]]) -> dict[int, list[int]]:
    """Return for every body the partners that bend where it is flat, without those that cannot be slaves."""
    skins: dict[int, Skin] = {}
    before: dict[int, list[int]] = {}
    for both in pairs:
        bent = bent_of(bodies, both, skins)
        if bent is not None and not held(bodies[bent]):
            before.setdefault(sum(both) - bent, []).append(bent)
    return before


def bent_of(bodies: Sequence[Body], both: tuple[int, int], skins: dict[int, Skin]) -> int | None:
    """Return the number of the body of two that bends beside the other one, or None; skins: those made so far."""
    for number in both:
        if number not in skins:
            skins[number] = Skin(bodies[number])
    bent = bent_one(*(skins[number] for number in both))
    return None if bent is None else both[bent]


def slave_warnings(scene: Any) -> list[str]:
    """Return a warning for every pair whose slave was named and is the wrong one.

    It is if it is flat where its master, which could be the slave, bends; else if it is much stiffer than its master,
    whose faces are no larger and which does not hold its nodes, and does not bend itself.
    """
    found = []
    named = {frozenset((pair.first, pair.second)) for pair in _listed(scene) if pair.slave is not None}
    skins: dict[int, Skin] = {}
    for pair in scene.body_pairs:
        slave, master = scene.label(pair.slave), scene.label(pair.master)
        one, other = scene.bodies[pair.slave], scene.bodies[pair.master]
        if frozenset((slave, master)) not in named or held(other):
            continue
        bent = bent_of(scene.bodies, (pair.slave, pair.master), skins)
        ratio = stiffness(one) / stiffness(other)
        if bent == pair.master:
            found.append(
                f"the slave {slave} of the pair {pair.name} is flat and its faces are coarse where its master {master}"
                f" is curved or sharp: rows press where nothing touches, or too late; leave Pair.slave at None or make"
                f" {master} the slave"
            )
        elif isinstance(scene.contact, MasslessContact) and ratio > STIFF and bent is None:
            if mean_area(other) > mean_area(one):
                continue
            products = PRODUCTS + MORE * np.log10(ratio)
            found.append(
                f"the slave {slave} of the pair {pair.name} is {ratio:.3g} times stiffer than its master {master}:"
                f" expect about {products:.0f} products a step in the static solve instead of {PRODUCTS:.0f}; leave"
                f" Pair.slave at None or make {master} the slave"
            )
    return found


def _listed(scene: Any) -> Sequence[Any]:
    """Return the pairs that a scene lists."""
    return () if scene.pairs is None or isinstance(scene.pairs, str) else scene.pairs


def stiffness(body: Body) -> float:
    """Return the largest lambda + 2 mu [Pa] of the materials of a body."""
    return max(material.lame_lambda + 2.0 * material.lame_mu for material in body.materials)


def held(body: Body) -> bool:
    """Return whether supports hold a contact node of the body in all components."""
    return bool(np.isfinite(body.prescribed[body.contact_nodes]).all(axis=1).any())


def mean_area(body: Body) -> float:
    """Return the mean area [m^2] of the contact faces of a body, to 6 digits; 0 without any."""
    if not body.touches:
        return 0.0
    return float(f"{np.linalg.norm(area_vectors(body.initial_at(body.contact_faces)), axis=1).mean():.6g}")
