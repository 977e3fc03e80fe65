"""Which bodies may come near each other, and how far they can come: found from numbers of each body, once.

Faces of two bodies are compared (meeting.py) only if the boxes around the centres of their faces are near enough,

    distance <= 1.5 (|v_1 - c_1| + |v_2 - c_1| + w_1 + w_2 + |g| T + l_1 + l_2) T + e_1 + e_2 + r_1 + r_2,

with the initial velocities v and their means c, the largest speeds w that supports and springs prescribe, the speeds l
that loads give in the duration T, gravity g, the shortest edges e and the radii r of the largest faces.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from .body import Body
from .meeting import Faces, facing
from .reach import speed_by_loads

SLACK = 1.5  # factor on the way of two bodies, for waves that add to their speed
ROUNDING = 1e-9  # relative to the distance, by which boxes count as nearer than they are


class Movement(NamedTuple):
    """Numbers of the start of a body: mean [3] and largest difference from it of its velocities [m/s].

    driven, loads [m/s]: speeds that supports with springs, and loads, can give it; edge [m]: its shortest edge.
    """

    mean: np.ndarray
    spread: float
    driven: float
    loads: float
    edge: float


class Approach:
    """The bodies of a scene on their way to each other.

    outer: bodies that find their contact faces come with all outer faces, not with those found so far.
    """

    def __init__(self, scene: Any, outer: bool, before: Approach | None = None) -> None:
        """Take the bodies of a scene; before: what is known of them with other faces."""
        self.bodies: tuple[Body, ...] = scene.bodies
        self.duration, self.outer = float(scene.duration), outer
        self.fall: float = scene.largest_gravity * scene.duration if before is None else before.fall
        self._movements: dict[int, Movement] = {} if before is None else before._movements
        self._faces: dict[int, Faces] = {}

    def movement(self, index: int) -> Movement:
        """Return the numbers of the motion of a body."""
        if index not in self._movements:
            body = self.bodies[index]
            mean = body.initial_velocity.mean(axis=0)
            driven, loads = body.driven_speed(self.duration), speed_by_loads(body, self.duration)
            spread = _largest(body.initial_velocity, mean)
            self._movements[index] = Movement(mean, spread, driven, loads, body.mesh.shortest_edge)
        return self._movements[index]

    def faces(self, index: int) -> Faces:
        """Return the faces of a body that are compared with those of others."""
        if index not in self._faces:
            body = self.bodies[index]
            found = body.outer_faces if self.outer and body.finds_contact else body.contact_faces
            self._faces[index] = Faces(body.initial_at(found))
        return self._faces[index]

    def meeting(self, first: int, second: int) -> np.ndarray:
        """Return for every face of the first body whether it may meet one of the second, see `meeting.py`."""
        faces = self.faces(first), self.faces(second)
        if not len(faces[0]) or not len(faces[1]):
            return np.zeros(len(faces[0]), dtype=bool)
        one, other = self.movement(first), self.movement(second)
        speed = one.spread + _largest(self.bodies[second].initial_velocity, one.mean)
        speed += one.driven + other.driven
        fall = self.fall + (one.loads + other.loads)
        return facing(*faces, SLACK * (speed + fall) * self.duration, one.edge + other.edge)

    @cached_property
    def _boxes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Lowest and highest centres of faces [b, 3], sums of what adds to the reach [b], mean velocities [b, 3].

        A body without faces is nowhere. Last come those with faces [b].
        """
        there = [number for number in range(len(self.bodies)) if len(self.faces(number))]
        low, high = np.full((len(self.bodies), 3), np.inf), np.full((len(self.bodies), 3), -np.inf)
        reach, means = np.zeros(len(self.bodies)), np.zeros((len(self.bodies), 3))
        for number in there if len(there) > 1 else ():
            move, faces = self.movement(number), self.faces(number)
            low[number], high[number] = faces.box
            speeds = move.spread + move.driven + move.loads
            reach[number] = SLACK * speeds * self.duration + move.edge + faces.largest
            means[number] = move.mean
        return low, high, reach, means, np.array(there if len(there) > 1 else (), dtype=np.int64)

    def near(self, index: int) -> list[int]:
        """Return the numbers of the other bodies, ascending, whose faces a body may meet, judged by their boxes."""
        low, high, reach, means, there = self._boxes
        if index not in there:
            return []
        with np.errstate(invalid="ignore", over="ignore"):  # speeds without a bound
            apart = np.maximum(low[there] - high[index], low[index] - high[there]).clip(0.0)
            size = np.abs([low[index], high[index]]).max() + np.abs([low[there], high[there]]).max()
            distance = np.linalg.norm(apart, axis=1) * (1.0 - ROUNDING) - ROUNDING * ROUNDING * size
            between = np.linalg.norm(means[there] - means[index], axis=1)
            way = reach[there] + reach[index] + SLACK * (between + self.fall) * self.duration
            near = there[~(distance > way * (1.0 + ROUNDING))]
        return [int(number) for number in near if number != index]


def _largest(velocities: np.ndarray, mean: np.ndarray) -> float:
    """Return the largest difference [m/s] of velocities [n, 3] from a mean [3]."""
    return float(np.linalg.norm(velocities - mean, axis=1).max())
