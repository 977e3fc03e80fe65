"""How the bodies of a scene are grouped into domains, which take their steps together."""

from __future__ import annotations

from ..base.errors import InputError
from ..scene.connections import connected
from ..scene.contact_models import MasslessContact
from ..scene.pairs import BodyPair
from ..scene.scene import Scene
from ..scene.springs import SceneSpring
from .body_plan import BodyPlan
from .domain import Domain
from .rigid import free_obstacles
from .static_solver import projected, static_solver


def _can_touch(body: BodyPlan) -> bool:
    return body.contact is not None and len(body.contact.nodes) > 0


def domains_of(scene: Scene, bodies: tuple[BodyPlan, ...]) -> tuple[Domain, ...]:
    """Group the bodies into domains: one for each number of massless components and solver of the static solve.

    These choose different kernels. Bodies that pairs or springs connect have a domain of their own; bodies that cannot
    touch anything join the first domain. Obstacles that move freely feel all bodies at once: those that can touch
    something share a domain then, with all that springs connect to them.
    """
    moving = free_obstacles(scene)
    groups: dict[tuple[int, ...], list[int]] = {}
    alone = []
    links = [*((pair.first, pair.second) for pair in scene.body_pairs), *(spring.bodies for spring in scene.springs)]
    joined_bodies = connected(len(bodies), links)
    first_ones = {together[0]: together for together in joined_bodies}
    touching = {first: any(_can_touch(bodies[one]) for one in together) for first, together in first_ones.items()}
    paired = {first: any(scene.pairs_at[one] for one in together) for first, together in first_ones.items()}
    for number, body in enumerate(bodies):
        together = joined_bodies[number]
        if moving and touching[together[0]]:
            groups.setdefault((-1,), []).append(number)
            continue
        if len(together) > 1 and (paired[together[0]] or touching[together[0]]):
            groups.setdefault((-1, together[0]), []).append(number)
            continue
        if body.contact is None or not len(body.contact.nodes):
            alone.append(number)
            continue
        massless = body.contact.graph is not None
        kind = body.contact.block if massless else 0, int(massless and static_solver(scene, body).projected)
        groups.setdefault(kind, []).append(number)
    if moving:
        _check_shared(scene, [bodies[number] for number in groups.get((-1,), [])])
    numbers = list(groups.values()) or [[]]
    numbers[0] = sorted(numbers[0] + alone)
    home = {number: place for place, group in enumerate(numbers) for number in group}
    pairs: list[list[BodyPair]] = [[] for _ in numbers]
    springs: list[list[SceneSpring]] = [[] for _ in numbers]
    for pair in scene.body_pairs:
        pairs[home[pair.first]].append(pair)
    for spring in scene.springs:
        for place in {home[number] for number in spring.bodies}:
            springs[place].append(spring)
    domains = tuple(
        Domain(
            tuple(bodies[number] for number in group),
            tuple(group),
            tuple(pairs[place]),
            tuple(springs[place]),
            () if place else moving,
        )
        for place, group in enumerate(numbers)
    )
    for domain, key in zip(domains, groups, strict=False):  # without any group there is one domain, without contact
        massless = isinstance(scene.contact, MasslessContact)
        domain.projected = massless and (bool(key[1]) if key[0] >= 0 else projected(scene, domain.bodies))
    return domains


def _check_shared(scene: Scene, bodies: list[BodyPlan]) -> None:
    """Refuse obstacles that move freely between bodies that do not fit into one domain. Raises `InputError`."""
    model = scene.contact
    massless = [body for body in bodies if body.contact is not None and body.contact.graph is not None]
    if not scene.body_pairs and len({static_solver(scene, body).projected for body in massless}) > 1:
        remedy = "bodies that touch an obstacle that moves freely share a static solver; use 'gauss-seidel'"
        raise InputError("MasslessContact.solver", getattr(model, "solver", None), remedy)
    kicked = any(body.inverses[: len(body.contact.nodes)].any() for body in bodies if body.contact is not None)
    if scene.body_pairs and scene.friction is not None and kicked:
        remedy = "friction of obstacles that move freely beside pairs of bodies needs MasslessContact(removal='full')"
        raise InputError("Scene.contact", model, f"{remedy} without supports on contact nodes")
