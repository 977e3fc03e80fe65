"""Which mass the contact nodes of a metal lose: no inertia holds a layer without mass that is pressed out sideways.

With full removal the contact layer of a metal flows away from under the pressure of an impact, as a jet; a bar at
227 m/s diverges. What counts is m = rho v^2/Y with the normal speed v of the impact and the yield stress Y; at
m = 0.08 the foot of a bar is 1.6 % wider than with normal removal. That one keeps the mass across the normal and has no
such limit: along the normal of planes of one direction, else along the normals of the contact faces themselves.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..base.errors import FunctionError, InputError
from ..scene.body import Body
from ..scene.meeting import area_vectors
from ..scene.metals import ElastoPlastic
from ..scene.obstacles import Obstacle
from ..scene.obstacles.motion import Rate
from ..scene.reach import SAMPLES, within_reach
from ..scene.scene import Scene

SLOW = 0.1  # largest m with full removal
ONE_SIDE = np.cos(np.radians(45.0))  # faces around a node that lean by less share one normal


def check_full(scene: Scene, index: int, normal: bool = True) -> None:
    """Refuse full removal of a metal at an impact too fast for it; normal: whether the other one is possible.

    Raises `InputError`.
    """
    share = impact_number(scene, index)
    if share > SLOW:
        raise InputError(
            "MasslessContact.removal",
            "full",
            f"{scene.label(index)} is a metal that meets others with rho v^2/Y = {share:.3g}: above {SLOW:g} its"
            " contact nodes would flow out sideways, as they have no mass; "
            + ("use removal='normal'" if normal else "turn the contact faces to one direction, or use PenaltyContact"),
        )


def fast_metal(scene: Scene, numbers: Sequence[int]) -> bool:
    """Return whether one of these bodies is a metal in an impact that is too fast for full removal."""
    return any(impact_number(scene, number) > SLOW for number in numbers)


def keeps_normals(scene: Scene, numbers: Sequence[int]) -> bool:
    """Return whether bodies keep their normal removal as metals: after a fast impact in this run or in the one before.

    That one is the run from whose end this one starts, and all the bodies with these numbers had normal removal there.
    """
    if removal_before(scene, numbers) == "normal" and any(contact_metals(scene.bodies[number]) for number in numbers):
        return True
    return fast_metal(scene, numbers)


def removal_before(scene: Scene, numbers: Sequence[int]) -> str | None:
    """Return the removal that bodies with these numbers had in the run from whose end this one starts.

    A body without massless contact there does not count. None if there is no such run, or not one removal.
    """
    if scene.end_before is None:
        return None
    known = {scene.end_before.removal[number] for number in numbers} - {None}
    return known.pop() if len(known) == 1 else None


def contact_metals(body: Body) -> list[ElastoPlastic]:
    """Return the metals of the cells at the contact nodes of a body."""
    blocks = [block for block in body.blocks if isinstance(block.material, ElastoPlastic)]
    if len(blocks) < len(body.blocks):
        touching = np.zeros(body.mesh.node_count, dtype=bool)
        touching[body.contact_nodes] = True
        blocks = [block for block in blocks if touching[block.cells].any()]
    return [block.material for block in blocks if isinstance(block.material, ElastoPlastic)]


def impact_number(scene: Scene, index: int) -> float:
    """Return m = rho v^2/Y of a body, with its largest normal speed v against what it may meet.

    It is 0 where no metal is at its contact nodes.
    """
    metals = contact_metals(scene.bodies[index])
    if not metals:
        return 0.0
    speed = impact_speed(scene, index)
    return max(metal.density * speed * speed / metal.hardening.yield_stress for metal in metals)


def impact_speed(scene: Scene, index: int) -> float:
    """Return the largest speed [m/s] at which contact nodes approach obstacles or other bodies, a fall included."""
    body = scene.starting(index)
    nodes = body.contact_nodes
    start, velocity = body.initial_nodes[nodes], body.initial_velocity[nodes]
    pull = scene.largest_gravity
    outward = own_normals(body)[:, 0]
    driven = body.driven_speed(scene.duration)
    fastest = driven
    for number in within_reach(body, scene.obstacles, scene.duration, scene.largest_gravity):
        obstacle = scene.obstacles[number]
        normals = obstacle.normal_at(start)
        towards = np.einsum("ki,ki->k", velocity, outward) * (np.einsum("ki,ki->k", velocity, normals) < 0.0)
        towards = np.maximum(towards, -np.einsum("ki,ki->k", velocity, normals))
        fall = min(pull * scene.duration, np.sqrt(2.0 * pull * max(0.0, float(obstacle.gap(start).min(initial=0.0)))))
        towards = driven + towards
        fastest = max(fastest, float(towards.max(initial=0.0)) + _pushed(obstacle, start, normals, scene) + fall)
    for pair in scene.pairs_at[index]:
        other = scene.starting(pair.second if index == pair.first else pair.first)
        towards = np.einsum("ki,ki->k", velocity - other.initial_velocity.mean(axis=0), outward)
        fastest = max(fastest, driven + float(towards.max(initial=0.0)) + other.driven_speed(scene.duration))
    return fastest


def _pushed(obstacle: Obstacle, positions: np.ndarray, normals: np.ndarray, scene: Scene) -> float:
    """Return the largest speed [m/s] of a moving obstacle along its normals at positions [k, 3], at least 0."""
    if not obstacle.moves:
        return 0.0
    times = np.linspace(0.0, scene.duration, SAMPLES)
    try:
        along = Rate(obstacle, "velocity").at(times) @ normals.T
        turning = Rate(obstacle, "angular_velocity").at(times) @ np.cross(positions - obstacle.reference, normals).T
    except FunctionError:  # the run stops where the function fails
        return 0.0
    return max(0.0, float((along + turning).max(initial=0.0)))


def own_normals(body: Body) -> np.ndarray:
    """Return the unit outward normals [k, 3, 3] of the contact faces at every contact node, up to three, then zeros.

    Faces that lean by less than 45 degrees towards the sum of those before them share one: the normal of a smooth
    surface, and one for every side of an edge or a corner.
    """
    faces, nodes = body.contact_faces, body.contact_nodes
    areas = area_vectors(body.initial_nodes[faces])
    result = np.zeros((len(nodes), 3, 3))
    place = np.full(body.mesh.node_count, -1)
    place[nodes] = np.arange(len(nodes))
    around: list[list[int]] = [[] for _ in nodes]
    for number, face in enumerate(place[faces]):
        for node in dict.fromkeys(face.tolist()):
            around[node].append(number)
    for node, numbers in enumerate(around):
        sums: list[np.ndarray] = []
        for number in numbers:
            area = areas[number]
            lean = [float(area @ total) / float(np.linalg.norm(area) * np.linalg.norm(total)) for total in sums]
            if lean and max(lean) > ONE_SIDE:
                best = int(np.argmax(lean))
                sums[best] = sums[best] + area
            elif len(sums) < 3:
                sums.append(area)
        for side, total in enumerate(sums):
            result[node, side] = total / np.linalg.norm(total)
    return result
