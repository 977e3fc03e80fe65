"""Springs in the numbering of a domain, and how fast the nodes at their ends can oscillate on them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.errors import InputError
from ..kernels.rigid_places import FREE
from ..scene.scene import Scene
from ..scene.springs import SceneSpring
from .body_plan import ContactPlan


class PlannedEnd(NamedTuple):
    """Boundary nodes [m] at an end of a spring with their weights [m]; mass [m] [kg]: their ordinary lumped mass."""

    nodes: np.ndarray
    weights: np.ndarray
    mass: np.ndarray


def spring_nodes(scene: Scene, index: int) -> np.ndarray:
    """Return the nodes of a body to which springs are fixed, in the user's numbering; followers by their masters."""
    parts = [nodes for _, nodes in _spring_ends(scene, index)]
    return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *parts]))


def _spring_ends(scene: Scene, index: int) -> list[tuple[str, np.ndarray]]:
    """Return label and nodes of every end of a spring at a body."""
    return [(spring.label, end.nodes) for spring in scene.springs for end in spring.ends if end.body == index]


def check_massless(scene: Scene, index: int, place: np.ndarray, contact: ContactPlan | None) -> None:
    """Refuse springs on massless contact nodes; place [n]: number of a node in the plan. Raises `InputError`."""
    if contact is None or contact.basis is None:
        return
    for label, nodes in _spring_ends(scene, index):
        if count := int(np.isin(place[nodes], contact.nodes).sum()):
            remedy = f"{count} of its {len(nodes)} nodes at this body are contact nodes without mass, on which springs"
            remedy += " cannot act; fix it to other nodes, leave them out of Body.contact, or use PenaltyContact"
            raise InputError(f"Scene.bodies[{index}].springs", label, remedy)


def planned_ends(domain: Any, spring: SceneSpring) -> list[PlannedEnd]:
    """Return the moving ends of a spring, one or two."""
    images = domain.images
    mass = domain.lumped if images is None else images.total(domain.lumped)
    found = []
    for end in spring.ends:
        if end.body is not None:
            number = domain.numbers.index(end.body)
            body = domain.bodies[number]
            nodes = np.sort(body.place[end.nodes])
            row = np.full(len(body.reference), -1)
            row[body.boundary] = np.arange(len(body.boundary))
            places = domain.boundary_place[number][row[nodes]]
            weights = np.full(len(nodes), 1.0 / len(nodes))
            found.append(PlannedEnd(places, weights, mass[nodes + domain.node_start[number]]))
    return found


def spring_rates(domain: Any) -> dict[int, float]:
    """Return for the bodies with springs a bound of omega^2 [1/s^2] of masses on all springs of the domain.

    sum_i k_i b_i b_i^T has the eigenvalues of [sqrt(k_i k_j) b_i.M^-1 b_j], with the weights b_i of the nodes, here as
    if all springs had one direction and pulled together. lambda(K + B) <= lambda(K) + lambda(B).
    """
    if not domain.springs:
        return {}
    count, alone = len(domain.boundary), part_of_nodes(domain) < 0
    weights, inverse = np.zeros((len(domain.springs), count)), np.zeros(count)
    for number, spring in enumerate(domain.springs):
        for end in planned_ends(domain, spring):
            weights[number, end.nodes] += end.weights * np.sqrt(spring.spring.stiffness)
            inverse[end.nodes] = alone[end.nodes] / end.mass
    of_nodes = np.einsum("is,s,js->ij", weights, inverse, weights)
    of_parts, most = _rates_at_parts(domain)
    together, apart = (float(np.linalg.eigvalsh(each).max()) for each in (of_nodes + of_parts, of_nodes))
    largest = min(together, apart + most)
    return {number: largest for spring in domain.springs for number in spring.bodies}


def _rates_at_parts(domain: Any) -> tuple[np.ndarray, float]:
    """Return what the rigid parts that move freely add to [sqrt(k_i k_j) b_i.M^-1 b_j] of all springs [s, s] [1/s^2].

    And the sum over the parts of the largest eigenvalue of each alone, with the directions of its arms: less where
    several springs are at one part, more where many parts have springs of their own.

    Forces along unit vectors d_i at the arm a_i and d_j at a_j give d_i.(s_i s_j/M + [a_i]^T I^-1 [a_j]) d_j with the
    sums s of the weights and [a] d = a x d: here the largest for all directions, which no turn of a part changes. A
    spring under the force F resists the turn of its arm with up to F a, as if the arm were longer by sqrt(1 + F/(k a)).
    F is that at the start, and at least k a: that of a spring which stretches by its arm.
    """
    springs = domain.springs
    carriers = [part_carriers(domain, spring) for spring in springs]
    stretch = [0.0 if each.spring.directions else np.linalg.norm(each.rest) - each.rest_length for each in springs]
    result, most = np.zeros((len(springs), len(springs))), 0.0
    for number, body in enumerate(domain.rigid):
        if body.kind != FREE or not len(body.nodes):
            continue
        here, moves = [], []  # springs at the part, the motion [6, 3] that a force gives it, of kinetic energy F^2/2
        root = np.linalg.inv(np.linalg.cholesky(body.inertia))
        for row, own in enumerate(carriers):
            for _, share, *arm in own[own[:, 0] == number]:
                length = max(float(np.linalg.norm(arm)), 1e-200)
                turn = root @ np.cross(np.eye(3), arm) * np.sqrt(1.0 + max(abs(stretch[row]) / length, 1.0))
                part = np.concatenate([share / np.sqrt(body.mass) * np.eye(3), turn])
                moves.append(np.sqrt(springs[row].spring.stiffness) * part)
                here.append(row)
        for row, move in zip(here, moves, strict=True):
            result[row, here] += np.linalg.norm(move.T @ np.stack(moves), 2, axis=(1, 2))
        most += float(np.linalg.norm(np.concatenate(moves, axis=1), 2)) ** 2 if moves else 0.0
    return result, most


def part_of_nodes(domain: Any) -> np.ndarray:
    """Return the number of the rigid body that carries each boundary node of a domain; -1 where none does."""
    found = np.full(len(domain.boundary), -1)
    for number, body in enumerate(domain.rigid):
        found[np.asarray(body.nodes, dtype=np.int64)] = number
    return found


def part_carriers(domain: Any, spring: SceneSpring) -> np.ndarray:
    """Return the rigid bodies that carry nodes at the ends of a spring: number, sum of weights, weighted arm [m, 5].

    Weights are negative at the first end. Arms [m] are those at t = 0.
    """
    signs = [2.0 * number - 1.0 for number, end in enumerate(spring.ends) if end.body is not None]
    ends = list(zip(signs, planned_ends(domain, spring), strict=True))
    found = []
    for number, body in enumerate(domain.rigid):
        row = np.full(len(domain.boundary), -1)
        row[np.asarray(body.nodes, dtype=np.int64)] = np.arange(len(body.nodes))
        if any((row[end.nodes] >= 0).any() for _, end in ends):
            sums = np.zeros(4)
            for sign, end in ends:
                here = row[end.nodes] >= 0
                weights = sign * end.weights[here]
                sums[0] += weights.sum()
                sums[1:] += weights @ np.asarray(body.arms)[row[end.nodes[here]]]
            found.append([number, *sums])
    return np.array(found).reshape(-1, 5)
