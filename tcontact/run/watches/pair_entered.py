"""Tell of a body of a pair that has entered the other one with faces that are not in the contact sets of both.

Contact holds a surface node on a face of the other body if both are in the contact sets and look at each other. A node
deeper inside than a part of an edge is not held by contact if the face of the other body next to it is no contact face,
or if none of the contact faces at the node looks at that face: the body has turned since its contact faces were chosen.
Of a body with contact="auto" a face that was not chosen need not enter: it is told of where it looks at the other body
and comes as near as contact needs it, since an edge of which one face alone is in contact makes energy out of nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...mesh.triangle_distance import near_boxes, point_to_triangle, winding_number
from ...scene.body import Body
from ...scene.meeting import FACING, area_vectors, unit
from ..watched import Run
from .body_meeting import Surface
from .slabs import within_slabs

DEEP = 0.1  # depth over the mean edge of the finer surface up to which faces that touch or are pressed may be uneven
REACH = 1.0  # the same up to which the face next to a node is looked for; deeper nodes stop a run (pair_overlap.py)
TIED = 1e-9  # faces further away than the nearest one by so much of the distance are as near
REMEDY = "name the faces that meet in Body.contact of both, or give contact='all', their whole surfaces"


class Touchable:
    """Which parts of the surface of a body can touch something.

    touching [m]: whether the triangles `Surface.closed` are of contact faces; loose [k]: whether surface nodes have a
    face that is none.
    """

    def __init__(self, body: Body, surface: Surface) -> None:
        every = body.mesh.boundary_faces()
        _, number = np.unique(np.concatenate([every, body.contact_faces]), axis=0, return_inverse=True)
        number = number.reshape(-1)
        own = np.isin(number[: len(every)], number[len(every) :])
        second = own[every[:, -1] != every[:, -2]] if every.shape[1] == 4 else own[:0]  # see triangles_of
        self.touching = np.concatenate([own, second])
        self.loose = np.zeros(len(surface.nodes), dtype=bool)
        self.loose[surface.closed[~self.touching]] = True


class PairEntered:
    """Looks for nodes of a body of a pair that are inside the other one where contact does not hold them."""

    def __init__(self, run: Run, surfaces: Sequence[Surface]) -> None:
        self._surfaces = surfaces
        paired = {number for pair in run.scene.body_pairs for number in (pair.first, pair.second)}
        self._touchable = {number: Touchable(run.scene.bodies[number], surfaces[number]) for number in paired}
        self._met: list[str] = []
        self._told: set[tuple[int, int]] = set()

    @property
    def found(self) -> str:
        """Which bodies it has warned of, with the remedy, for messages about what follows; "" for none."""
        return f"{', '.join(self._met)} with faces that are not in their contact sets: {REMEDY}" if self._met else ""

    def look(self, run: Run, one: int, other: int, now: Sequence[np.ndarray], time: float) -> None:
        """Warn where a node of a body is inside another one; now: present positions [k, 3] of every surface."""
        if (one, other) in self._told:
            return
        edge = min(self._surfaces[number].mean_edge for number in (one, other))
        labels = [run.scene.label(number) for number in (one, other)]
        found, when = self._deepest(one, other, now, edge), f"at t = {time:.6g} s"
        if found is not None:
            place, depth = found
            given = [_given(run.scene.bodies[number]) for number in (one, other)]
            text = (
                f"a node of body {labels[0]} at {_at(place)} is {depth:.3g} m inside body {labels[1]} {when}, where no"
            )
            text += f" contact holds it: only the faces in Body.contact touch anything, {given[0]} of {labels[0]} and"
            text += f" {given[1]} of {labels[1]}; {REMEDY}"
        elif run.scene.bodies[one].finds_contact and (near := self._came(one, other, now, edge)) is not None:
            text = (
                f"a face of body {labels[0]} that contact='auto' did not choose at the start meets body {labels[1]} at"
            )
            text += f" {_at(near)} {when}, and does not touch it; {REMEDY}"
        else:
            return
        self._told |= {(one, other), (other, one)}
        self._met.append(f"{labels[0]} met {labels[1]}")
        run.warn(text)

    def _came(self, one: int, other: int, now: Sequence[np.ndarray], edge: float) -> np.ndarray | None:
        """Return a place [3] where a face of a body that is no contact face looks at the other one and is as near."""
        mine, corners = (now[number][self._surfaces[number].closed] for number in (one, other))
        mine = mine[~self._touchable[one].touching]
        pairs, _ = near_boxes(mine, corners, DEEP * edge)
        normals, others = (unit(area_vectors(triangles)) for triangles in (mine, corners))
        first, second = pairs[np.einsum("ki,ki->k", normals[pairs[:, 0]], others[pairs[:, 1]]) < FACING].T
        for points, triangles in ((mine[first], corners[second]), (corners[second], mine[first])):
            for corner in range(3):
                near = point_to_triangle(points[:, corner], triangles) <= DEEP * edge
                if near.any():
                    return np.asarray(points[near.argmax(), corner])
        return None

    def _deepest(self, one: int, other: int, now: Sequence[np.ndarray], edge: float) -> tuple[np.ndarray, float] | None:
        """Return position [3] and depth [m] of the deepest node that contact does not hold; edge [m]: to compare it."""
        mine, theirs = self._touchable[one], self._touchable[other]
        if mine.touching.all() and theirs.touching.all():
            return None
        chosen = np.flatnonzero(within_slabs(now[one], now[other], DEEP * edge))
        corners = now[other][self._surfaces[other].closed]
        chosen = _may_be_free(chosen, mine, theirs, now[one], corners, REACH * edge)
        points = now[one][chosen]
        pairs, _ = near_boxes(points[:, None], corners, REACH * edge)
        if not len(pairs):
            return None
        which, triangle = pairs.T
        apart = point_to_triangle(points[which], corners[triangle])
        nearest = np.full(len(points), np.inf)
        np.minimum.at(nearest, which, apart)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        behind = np.einsum("ki,ki->k", normals[triangle], points[which] - corners[triangle, 0]) < 0.0
        tied = (apart <= (1.0 + TIED) * nearest[which]) & behind
        own = now[one][self._surfaces[one].closed]
        for node in np.argsort(-nearest):
            if not DEEP * edge < nearest[node] <= REACH * edge:
                continue
            faces = triangle[tied & (which == node)]
            if not len(faces) or self._held(one, int(chosen[node]), own, normals[faces], theirs.touching[faces]):
                continue
            if winding_number(points[node], corners) > 0.5:
                return points[node], float(nearest[node])
        return None

    def _held(self, one: int, node: int, own: np.ndarray, normals: np.ndarray, touching: np.ndarray) -> bool:
        """Return whether contact holds a node of a body at one of the faces of the other body that are next to it.

        own [m, 3, 3]: present triangles of the body; normals [p, 3], touching [p]: of these faces, any length.
        """
        mine = self._touchable[one]
        if not mine.loose[node]:
            return bool(touching.any())
        around = own[mine.touching & (self._surfaces[one].closed == node).any(axis=1)]
        directions = np.cross(around[:, 1] - around[:, 0], around[:, 2] - around[:, 0])
        lengths = np.linalg.norm(directions, axis=1)[:, None] * np.linalg.norm(normals, axis=1)
        return bool(((directions @ normals.T < FACING * lengths) & touching).any())


def _may_be_free(
    chosen: np.ndarray, mine: Touchable, theirs: Touchable, nodes: np.ndarray, corners: np.ndarray, reach: float
) -> np.ndarray:
    """Return those of the chosen nodes that have, or come within reach [m] of, a face that is no contact face."""
    loose = mine.loose[chosen]
    inner = chosen[~loose]
    if len(inner) and not theirs.touching.all():
        pairs, _ = near_boxes(nodes[inner][:, None], corners[~theirs.touching], reach)
        loose[np.flatnonzero(~loose)[np.unique(pairs[:, 0])]] = True
    return np.asarray(chosen[loose])


def _at(place: np.ndarray) -> str:
    """Return a place [3] [m] in words."""
    return f"({', '.join(f'{part:.4g}' for part in place)})"


def _given(body: Body) -> str:
    """Return the sets of the contact of a body as a user gave them."""
    names = [*(body.contact or ())]
    return repr(names[0] if len(names) == 1 else names)
