"""Periodic bodies: nodes on opposite sides share their degrees of freedom; they are the images of one node.

The first image, the master, has the mass, load, contact and force of all; the others follow it. Cells, their forces and
their masses are those of a body with free sides. Sets of nodes name degrees of freedom: point masses, forces, springs
and probes count a node once, whichever of its images a set names, and however many. Momentum and energy count every
degree of freedom once; angular momentum, which a periodic body does not conserve, is that of the masters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..base.errors import InputError
from ..mesh.geometry import grid_planes
from ..mesh.mesh import Mesh
from .obstacles import Obstacle, Plane

MATCH = 1e-6  # distance of partners, and of images at the start, over the shortest edge
SAME_SPEED = 1e-6  # difference of velocities of images over the largest initial velocity
ACROSS = 1e-9  # largest component of an obstacle's unit normal along a periodic direction


@dataclass(frozen=True)
class Images:
    """Images of the nodes: master [n] of every node (itself without images); period [3] [m], 0 where not periodic."""

    master: np.ndarray
    period: np.ndarray

    @cached_property
    def followers(self) -> np.ndarray:
        """Images other than the masters."""
        return np.flatnonzero(self.master != np.arange(len(self.master)))

    @cached_property
    def members(self) -> np.ndarray:
        """Masters and followers."""
        return np.unique(np.concatenate([self.followers, self.master[self.followers]]))

    @cached_property
    def size(self) -> np.ndarray:
        """Number of images [n] that share the degrees of freedom of a node."""
        return np.bincount(self.master, minlength=len(self.master))[self.master]

    def followers_of(self, nodes: np.ndarray) -> np.ndarray:
        """Return the followers of the given masters."""
        return self.followers[np.isin(self.master[self.followers], nodes)]

    def with_images(self, nodes: np.ndarray) -> np.ndarray:
        """Return the nodes with all their images, ascending."""
        return np.flatnonzero(np.isin(self.master, self.master[nodes]))

    def once(self, nodes: np.ndarray) -> np.ndarray:
        """Return the masters of the nodes, each once, ascending."""
        return np.unique(self.master[nodes])

    def middle(self, nodes: np.ndarray, places: np.ndarray) -> np.ndarray:
        """Return the mean [3] of places [k, 3] of nodes [k]; images of one node count as one, at their mean."""
        masters, which, counts = np.unique(self.master[nodes], return_inverse=True, return_counts=True)
        return np.asarray((1.0 / (len(masters) * counts[which.reshape(-1)])) @ places)

    def follow(self, values: np.ndarray) -> np.ndarray:
        """Return values [n, ...] with those of the master at every image."""
        return np.asarray(values[self.master])

    def total(self, values: np.ndarray) -> np.ndarray:
        """Sum values [n, ...] to the masters; zero at the followers."""
        result = np.zeros_like(values)
        np.add.at(result, self.master, values)
        return result

    def shared(self, values: np.ndarray) -> np.ndarray:
        """Distribute values [n, ...] of the masters in equal shares to all images, which keeps the sum."""
        return self.follow(values) / self.size.reshape(-1, *[1] * (values.ndim - 1))

    def mean(self, values: np.ndarray, mass: np.ndarray) -> np.ndarray:
        """Average accelerations [n, 3] over images, weighted by mass [n]."""
        return self.follow(self.total(mass[:, None] * values) / np.maximum(self.total(mass), 1e-300)[:, None])

    def shortest(self, difference: np.ndarray) -> np.ndarray:
        """Reduce differences of positions [.., 3] [m] to those with the nearest repetition."""
        whole = np.where(self.period > 0.0, self.period, 1.0)
        return difference - self.period * np.round(difference / whole)

    def boundary(self, first: np.ndarray, special: np.ndarray) -> np.ndarray:
        """Return the boundary nodes: contact nodes `first`, their followers, other special nodes and images."""
        start = np.concatenate([first, self.followers_of(first)])
        rest = np.setdiff1d(np.union1d(special, self.members), start)
        return np.concatenate([start, rest]).astype(np.int64)

    def pairs(self, boundary: np.ndarray) -> np.ndarray:
        """Return (follower, master) as places in the list of boundary nodes [.., 2]."""
        row = np.full(len(self.master), -1)
        row[boundary] = np.arange(len(boundary))
        return np.stack([row[self.followers], row[self.master[self.followers]]], axis=1)

    def renumbered(self, node_order: np.ndarray, place: np.ndarray) -> Images:
        """Return the images in a numbering where node i is node_order[i] of this one, with its inverse place."""
        return Images(place[self.master[node_order]], self.period)

    def prescribed(self, components: np.ndarray, supports: object) -> np.ndarray:
        """Give prescribed components [n, 3] (NaN: free) of one image to all. Raises `InputError` if they differ."""
        low, high = np.full_like(components, np.nan), np.full_like(components, np.nan)
        np.fmin.at(low, self.master, components)
        np.fmax.at(high, self.master, components)
        if (low < high).any():
            remedy = "nodes that share their degrees of freedom (Body.periodic) are prescribed different velocities"
            raise InputError("Body.supports", supports, remedy)
        return self.follow(low)

    def agreed(self, field: str, given: object, values: np.ndarray, tolerance: float) -> np.ndarray:
        """Make values [n, 3] equal at all images. Raises `InputError` where they differ by more than rounding."""
        result = self.follow(values)
        if values.size and np.abs(result - values).max() > tolerance:
            node = int(np.abs(result - values).max(axis=1).argmax())
            remedy = f"nodes {self.master[node]} and {node} share their degrees of freedom (Body.periodic):"
            raise InputError(field, given, f"{remedy} give them the same, {values[node]} is not {result[node]}")
        return result


def images_of(mesh: Mesh, directions: str) -> Images:
    """Find the images of a mesh, periodic along the axes named. Raises `InputError` where opposite sides differ."""
    known = isinstance(directions, str) and directions and set(directions) <= set("xyz")
    if not known or len(set(directions)) != len(directions):
        raise InputError("Body.periodic", directions, "give distinct letters out of 'xyz', for example 'xy'")
    tolerance = MATCH * mesh.shortest_edge
    master, period = np.arange(mesh.node_count), np.zeros(3)
    for letter in directions:
        axis = "xyz".index(letter)
        partner = _partners(mesh, axis, tolerance)
        if partner is None:
            raise InputError(
                "Body.periodic",
                directions,
                f"the sides at the ends of {letter} do not match face by face (nodes within {tolerance:.3g} m); use a"
                " box mesh, or mesh opposite sides alike",
            )
        master = partner[master]
        period[axis] = np.ptp(mesh.nodes[:, axis])
    return Images(master, period)


def _partners(mesh: Mesh, axis: int, tolerance: float) -> np.ndarray | None:
    """Return the partner on the low side of every node on the high side, else the node; None if the sides differ."""
    along = mesh.nodes[:, axis]
    low, high = np.flatnonzero(along <= along.min() + tolerance), np.flatnonzero(along >= along.max() - tolerance)
    if len(low) != len(high):
        return None
    across = [other for other in range(3) if other != axis]
    both = np.concatenate([low, high])
    keys = [grid_planes(mesh.nodes[both, other], tolerance) for other in across]
    order = [np.lexsort((keys[1][part], keys[0][part])) for part in (slice(len(low)), slice(len(low), None))]
    low, high = low[order[0]], high[order[1]]
    if np.abs(mesh.nodes[low][:, across] - mesh.nodes[high][:, across]).max() > tolerance:
        return None
    partner = np.arange(mesh.node_count)
    partner[high] = low
    here, there = (_faces_within(mesh, side) for side in (low, high))
    return partner if len(here) and _corner_sets(here) == _corner_sets(partner[there]) else None


def _corner_sets(faces: np.ndarray) -> set[frozenset[int]]:
    return {frozenset(corners) for corners in faces.tolist()}


def _faces_within(mesh: Mesh, nodes: np.ndarray) -> np.ndarray:
    """Return the faces of the surface with all corners among the nodes."""
    faces = mesh.boundary_faces()
    return faces[np.isin(faces, nodes).all(axis=1)]


def check_contact(images: Images | None, mesh: Mesh, faces: np.ndarray, contact: object) -> None:
    """Refuse a contact set with faces on a periodic side, which is no surface. Raises `InputError`."""
    if images is not None and repeated_faces(images, mesh, faces).any():
        axes = " and ".join("xyz"[axis] for axis in np.flatnonzero(images.period))
        remedy = f"it has faces on the periodic sides along {axes}; name only the faces that can touch"
        raise InputError("Body.contact", contact, remedy)


def repeated_faces(images: Images, mesh: Mesh, faces: np.ndarray) -> np.ndarray:
    """Return which of the faces [k, 4|3] lie on periodic sides: [k]."""
    nodes = mesh.nodes
    result = np.zeros(len(faces), dtype=bool)
    tolerance = MATCH * mesh.shortest_edge
    for axis in np.flatnonzero(images.period):
        for end in (nodes[:, axis].min(), nodes[:, axis].max()):
            result |= (np.abs(nodes[faces][:, :, axis] - end) <= tolerance).all(axis=1)
    return result


def check_obstacles(images: Images, periodic: str | None, obstacles: Sequence[Obstacle]) -> None:
    """Refuse obstacles without the period of a body that could touch them. Raises `InputError`.

    This holds even if the scene found no contact faces: a body would fall through a wall that its periodic sides face.
    """
    for obstacle in obstacles:
        along = isinstance(obstacle, Plane) and np.abs(obstacle.normal[images.period > 0.0]).max() <= ACROSS
        if not along or obstacle.turns:
            remedy = "a periodic body can touch planes along its periodic directions only, which do not turn"
            raise InputError("Scene.obstacles", obstacle, f"{remedy} (Body.periodic = {periodic!r})")
