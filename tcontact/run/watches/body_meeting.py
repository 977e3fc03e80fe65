"""Stop a run in which two bodies meet that are no pair in contact with each other.

Every pair of bodies has a clearance, a lower bound of the distance of their surfaces. Their relative motion reduces it,
and the next look comes before it can be 0, whatever moves in the scene or begins to (`pace.py`). Then it is measured
anew: by the boxes of both bodies, swept since the last look; where these overlap, by the surfaces, at so many places on
the way that neither moves by more than half a cell between two. A look costs little, and bodies whose boxes overlap,
such as a ball in a ring, may pass while their surfaces stay apart. Surfaces of periodic bodies have no sides, which
would cross where they pass through each other: their nodes are looked for inside the other body.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np

from ...mesh.triangle_distance import pieces_inside, smallest_distance, triangles_of, winding_number
from ...scene.body import Body
from ...scene.pairs import held_pairs, held_text, hindrance
from ...scene.scene import Scene
from ...schemes.explicit.body_view import BodyView
from ..guards import Stop
from ..watched import Run
from .pace import FARTHER, Pace, motions

RARELY = 64  # rows between looks at bodies that are far apart
SOON = 16  # rows until the next look for which a clearance is measured
TOUCH = 1e-6  # distance over the shortest edge of both surfaces below which they meet
MAXIMUM_PLACES = 1000  # maximum number of places on the way of one step
SAMPLES = 64  # most nodes of a periodic surface that are looked for inside another body
NO_PAIR = "pairs need the faces that meet in Body.contact of both bodies, both names in Scene.pairs, and explicit steps"


class Surface:
    """The outer faces of a body as triangles, from its state.

    nodes [k]: internal numbers of the surface nodes; triangles [m, 3]: rows of them, without sides that repeat;
    closed [m, 3]: with these; edge, mean_edge [m]: shortest and mean edge; period [m]: along x, y, z, 0 where nothing
    repeats.
    """

    def __init__(self, body: Body, state: BodyView) -> None:
        plan = state.plan
        every = body.mesh.boundary_faces()
        nodes = np.unique(every)
        self.nodes = plan.place[nodes]
        self.chosen = state.chosen(self.nodes)
        self.start = state.start_of(self.chosen)
        self.triangles = triangles_of(np.searchsorted(nodes, body.outer_faces))
        self.closed = triangles_of(np.searchsorted(nodes, every))
        corners = self.start[self.closed]
        lengths = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        self.edge, self.mean_edge = float(lengths.min()), float(lengths.mean())
        self.period = np.zeros(3) if body.images is None else np.array(body.images.period)

    def positions(self, state: BodyView) -> np.ndarray:
        """Return the present positions of the surface nodes [k, 3] [m]."""
        return np.asarray(self.start + state.latest_of(self.chosen))


def _unpaired(scene: Scene) -> list[tuple[int, int]]:
    """Return the numbers of two bodies each that are no pair in contact with each other."""
    paired = {frozenset((pair.first, pair.second)) for pair in scene.body_pairs}
    every = itertools.combinations(range(len(scene.bodies)), 2)
    return [bodies for bodies in every if frozenset(bodies) not in paired]


class BodyMeeting:
    """Looks for meetings of the bodies of a run."""

    ends_launches = True

    def __init__(self, run: Run) -> None:
        self._surfaces = [Surface(body, state) for body, state in zip(run.scene.bodies, run.states, strict=True)]
        self._pairs = np.array(_unpaired(run.scene))
        self._before = [surface.positions(state) for surface, state in zip(self._surfaces, run.states, strict=True)]
        self._clearance = np.zeros(len(self._pairs))
        self._pace = Pace(run, RARELY)
        self.due, self._seen, self._time = 0, -1, 0.0

    @staticmethod
    def of(run: Run) -> BodyMeeting | None:
        """Make the looks of a run; None if all its bodies are pairs, or may pass through each other."""
        return BodyMeeting(run) if run.scene.pairs is not None and _unpaired(run.scene) else None

    def look(self, run: Run, row: int, time: float, step: float) -> Stop | None:
        """Stop where two bodies have met since the last look."""
        now = [surface.positions(state) for surface, state in zip(self._surfaces, run.states, strict=True)]
        if not all(np.isfinite(there).all() for there in now):
            return None  # the guards stop at the next row
        rows, numbers = max(1, row - self._seen), self._pairs.T
        travel = self._travel(now)
        self._pace.follow(self._before, now, self._time, time + step, step)
        self._clearance -= travel
        for pair in np.flatnonzero(self._clearance <= 0.0):
            part = self._measure(int(pair), now, float(travel[pair]))
            if part is not None:
                if self._seen < 0 and part == 0:
                    how = "overlap or touch at the start"
                elif rows > 1:  # faster than foreseen, so that a time between both looks would be a guess
                    how = f"meet between t = {self._time:.6g} s and t = {time + step:.6g} s"
                else:
                    how = f"meet at t = {self._time + part * (time + step - self._time):.6g} s"
                return _met(run.scene, int(numbers[0, pair]), int(numbers[1, pair]), how)
        wait = float(np.floor(self._pace.rows(self._clearance, *numbers)).min())
        self.due = row + int(np.clip(wait, 1, min(RARELY, FARTHER * rows)))
        self._before, self._seen, self._time = now, row, time + step
        return None

    def _travel(self, now: list[np.ndarray]) -> np.ndarray:
        """Return the largest relative motion of the bodies of every pair since the last look [m]."""
        means, spreads = motions(self._before, now)
        first, second = self._pairs.T
        return np.asarray(spreads[first] + spreads[second] + np.linalg.norm(means[first] - means[second], axis=1))

    def _measure(self, pair: int, now: list[np.ndarray], travel: float) -> float | None:
        """Set the clearance of a pair, or return the part of the way since the last look at which they met."""
        first, second = (int(number) for number in self._pairs[pair])
        one, other = self._surfaces[first], self._surfaces[second]
        ways = [(self._before[number], now[number]) for number in (first, second)]
        common = 0.5 * sum((after - before).mean(axis=0) for before, after in ways)
        ways = [(before, after - common) for before, after in ways]
        boxes = [np.array([np.minimum(*way).min(axis=0), np.maximum(*way).max(axis=0)]) for way in ways]
        begin = self._seen < 0
        edge, mean = min(one.edge, other.edge), max(one.mean_edge, other.mean_edge)
        reach = float(np.clip(self._pace.way(first, second, SOON), 1e-3 * mean, mean))
        period = np.where(one.period > 0.0, one.period, other.period)
        apart = np.maximum(np.maximum(boxes[0][0] - boxes[1][1], boxes[1][0] - boxes[0][1]), 0.0)
        outside = float(np.linalg.norm(np.where(period > 0.0, 0.0, apart)))
        if outside > reach:
            self._clearance[pair] = outside
            return None
        places = int(np.clip(np.ceil(travel / (0.5 * edge)), 1, MAXIMUM_PLACES))

        def distance(part: float) -> float:
            there = [before + part * (after - before) for before, after in ways]
            found = reach
            for shift in _shifts(there, period, reach):
                found = smallest_distance(there[0][one.triangles] + shift, there[1][other.triangles], found)
                if begin and part == 0.0 and _nested(there[0] + shift, one.closed, there[1], other.closed):
                    return 0.0
            return found

        def entered(part: float) -> bool:
            there = [before + part * (after - before) for before, after in ways]
            return _inside(there[0], there[1], other, period) or _inside(there[1], there[0], one, period)

        free, near, repeats = 0.0, reach, bool(period.any())
        for part in np.arange(0 if begin else 1, places + 1) / places:
            near = distance(part)
            if near <= TOUCH * edge or (repeats and entered(part)):
                return _first(
                    lambda where: distance(where) <= TOUCH * edge or (repeats and entered(where)), free, float(part)
                )
            free = float(part)
        self._clearance[pair] = near
        return None


def _first(happened: Callable[[float], bool], before: float, after: float) -> float:
    """Return the place between two where a condition becomes true, by bisection to 1/256 of the way between them."""
    for _ in range(8):
        middle = 0.5 * (before + after)
        before, after = (before, middle) if happened(middle) else (middle, after)
    return after


def _met(scene: Scene, first: int, second: int, how: str) -> Stop:
    why = hindrance(scene) or NO_PAIR
    if (first, second) in held_pairs(scene):
        why = held_text(scene, first, second)
    text = f"bodies {scene.label(first)} and {scene.label(second)} {how}, and are no pair in contact; {why}; else move"
    text += " them apart, end the run before, or let them pass through each other with Scene(pairs=None)"
    return Stop("bodies-meet", text)


def _shifts(there: list[np.ndarray], period: np.ndarray, reach: float) -> list[np.ndarray]:
    """Return the whole periods [3] [m] by which the box of the first body comes within reach of the second's."""
    steps = []
    for axis in range(3):
        if period[axis] == 0.0:
            steps.append(np.zeros(1))
            continue
        low = there[1][:, axis].min() - reach - there[0][:, axis].max()
        high = there[1][:, axis].max() + reach - there[0][:, axis].min()
        steps.append(period[axis] * np.arange(np.ceil(low / period[axis]), np.floor(high / period[axis]) + 1.0))
    return [np.array(shift) for shift in itertools.product(*steps)]


def _inside(nodes: np.ndarray, other: np.ndarray, surface: Surface, period: np.ndarray) -> bool:
    """Return whether some of the nodes [n, 3] are inside another body, nodes [k, 3] of a surface, or an image of it."""
    low, high = other.min(axis=0), other.max(axis=0)
    length = np.where(period > 0.0, period, 1.0)
    near = nodes - np.where(period > 0.0, np.floor((nodes - low) / length), 0.0) * length
    near = near[((near >= low) & (near <= high)).all(axis=1)]
    near = near[:: -(-len(near) // SAMPLES)] if len(near) else near
    return any(winding_number(node, other[surface.closed]) > 0.5 for node in near)


def _nested(first: np.ndarray, own: np.ndarray, second: np.ndarray, other: np.ndarray) -> bool:
    """Return whether a piece of one body lies within the other: one node of a piece decides where no surfaces cut."""
    return any(
        True
        for points, triangles, around in ((first, own, second[other]), (second, other, first[own]))
        for _ in pieces_inside(points, triangles, around)
    )
