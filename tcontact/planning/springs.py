"""Springs in the numbering of a domain, and how fast the nodes at their ends can oscillate on them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.errors import InputError
from ..kernels.rigid_places import FREE
from ..scene.scene import Scene
from .body_plan import ContactPlan
from .spring_eigenvalues import Shares, largest_eigenvalue


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


def planned_ends(domain: Any) -> list[list[PlannedEnd]]:
    """Return the moving ends, one or two, of every spring of a domain."""
    if not domain.springs:
        return []
    mass = domain.lumped if domain.images is None else domain.images.total(domain.lumped)
    numbers = {body: number for number, body in enumerate(domain.numbers)}
    rows: dict[int, np.ndarray] = {}  # of bodies with springs: number of each node among the boundary nodes
    result = []
    for spring in domain.springs:
        found: list[PlannedEnd] = []
        for end in spring.ends:
            if end.body is None:
                continue
            number = numbers[end.body]
            body = domain.bodies[number]
            if number not in rows:
                rows[number] = np.full(len(body.reference), -1)
                rows[number][body.boundary] = np.arange(len(body.boundary))
            nodes = np.sort(body.place[end.nodes])
            places = domain.boundary_place[number][rows[number][nodes]]
            weights = np.full(len(nodes), 1.0 / len(nodes))
            found.append(PlannedEnd(places, weights, mass[nodes + domain.node_start[number]]))
        result.append(found)
    return result


def spring_rates(domain: Any) -> dict[int, float]:
    """Return for the bodies with springs a bound of omega^2 [1/s^2] of masses on all springs of the domain.

    sum_i k_i b_i b_i^T has the eigenvalues of [sqrt(k_i k_j) b_i.M^-1 b_j], with the weights b_i of the nodes, here as
    if all springs had one direction and pulled together. lambda(K + B) <= lambda(K) + lambda(B).
    """
    if not domain.springs:
        return {}
    alone, ends = part_of_nodes(domain) < 0, planned_ends(domain)
    parts = [(number, end) for number, own in enumerate(ends) for end in own]
    springs = np.repeat([number for number, _ in parts], [len(end.nodes) for _, end in parts])
    nodes = np.concatenate([end.nodes for _, end in parts])
    stiffness = np.sqrt([spring.spring.stiffness for spring in domain.springs])
    weights = np.concatenate([end.weights for _, end in parts]) * stiffness[springs]
    inverse = alone[nodes] / np.concatenate([end.mass for _, end in parts])
    used, nodes = np.unique(nodes, return_inverse=True)
    at_nodes = Shares(springs, nodes.reshape(-1), weights * np.sqrt(inverse), len(domain.springs), len(used))
    at_parts, most = _rates_at_parts(domain)
    largest = largest_eigenvalue(at_nodes)
    if at_parts:
        largest = min(largest_eigenvalue(at_nodes, at_parts), largest + most)
    return {number: largest for spring in domain.springs for number in spring.bodies}


def _rates_at_parts(domain: Any) -> tuple[list[tuple[np.ndarray, np.ndarray]], float]:
    """Return what the rigid parts that move freely add to [sqrt(k_i k_j) b_i.M^-1 b_j] of all springs [1/s^2].

    That is for each part with springs the numbers [m] of these and the terms [m, m]. And the sum over the parts of the
    largest eigenvalue of each alone, with the directions of its arms: less where several springs are at one part, more
    where many parts have springs of their own.

    Forces along unit vectors d_i at the arm a_i and d_j at a_j give d_i.(s_i s_j/M + [a_i]^T I^-1 [a_j]) d_j with the
    sums s of the weights and [a] d = a x d: here the largest for all directions, which no turn of a part changes. A
    spring under the force F resists the turn of its arm with up to F a, as if the arm were longer by sqrt(1 + F/(k a)).
    F is that at the start, and at least k a: that of a spring which stretches by its arm.
    """
    springs = domain.springs
    at: dict[int, list[tuple[int, np.ndarray]]] = {}  # springs with sum of weights and arm, by the number of the part
    for row, own in enumerate(part_carriers(domain)):
        for carrier in own:
            at.setdefault(int(carrier[0]), []).append((row, carrier[1:]))
    result, most = [], 0.0
    for number in sorted(at):
        body = domain.rigid[number]
        if body.kind != FREE or not len(body.nodes):
            continue
        moves = []  # the motion [6, 3] that a force on each spring gives to the part, of kinetic energy F^2/2
        root = np.linalg.inv(np.linalg.cholesky(body.inertia))
        for row, (share, *arm) in at[number]:
            spring = springs[row]
            stretch = 0.0 if spring.spring.directions else np.linalg.norm(spring.rest) - spring.rest_length
            length = max(float(np.linalg.norm(arm)), 1e-200)
            turn = root @ np.cross(np.eye(3), arm) * np.sqrt(1.0 + max(abs(stretch) / length, 1.0))
            part = np.concatenate([share / np.sqrt(body.mass) * np.eye(3), turn])
            moves.append(np.sqrt(spring.spring.stiffness) * part)
        terms = np.array([np.linalg.norm(move.T @ np.stack(moves), 2, axis=(1, 2)) for move in moves])
        result.append((np.array([row for row, _ in at[number]]), terms))
        most += float(np.linalg.norm(np.concatenate(moves, axis=1), 2)) ** 2
    return result, most


def part_of_nodes(domain: Any) -> np.ndarray:
    """Return the number of the rigid body that carries each boundary node of a domain; -1 where none does."""
    found = np.full(len(domain.boundary), -1)
    for number, body in enumerate(domain.rigid):
        found[np.asarray(body.nodes, dtype=np.int64)] = number
    return found


def part_carriers(domain: Any) -> list[np.ndarray]:
    """Return for every spring the rigid bodies that carry nodes at its ends: number, sum of weights, arm [m, 5].

    Weights are negative at the first end. Arms [m] are weighted, and those at t = 0.
    """
    part, arms = part_of_nodes(domain), np.zeros((len(domain.boundary), 3))
    for body in domain.rigid:
        if len(body.nodes):
            arms[np.asarray(body.nodes, dtype=np.int64)] = body.arms
    result = []
    for spring, planned in zip(domain.springs, planned_ends(domain), strict=True):
        signs = [2.0 * number - 1.0 for number, end in enumerate(spring.ends) if end.body is not None]
        found = []
        for number in sorted({int(one) for end in planned for one in part[end.nodes] if one >= 0}):
            sums = np.zeros(4)
            for sign, end in zip(signs, planned, strict=True):
                here = part[end.nodes] == number
                weights = sign * end.weights[here]
                sums[0] += weights.sum()
                sums[1:] += weights @ arms[end.nodes[here]]
            found.append([number, *sums])
        result.append(np.array(found).reshape(-1, 5))
    return result
