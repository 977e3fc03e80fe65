"""Stop a run in which a contact node has passed through a thin obstacle, so that its contact was missed.

A node deeper than the middle of an obstacle leaves it on the far side, and one that moves further than its thickness in
a step never meets it. So the path of every contact node between two looks is followed as a straight line in the axes of
the obstacle, from both ends by steps as long as the gap (sphere tracing): contact was missed if the normals where the
path enters and where it leaves, or ends inside, are opposite. A path around a convex edge misses no contact. Between
two looks no node moves by more than a quarter of the thickness, or there is a look after every step. Planes, and shells
around the bodies, have no far side. An obstacle that slips between two contact nodes is not seen: it has to be wider
than their distance.
"""

from __future__ import annotations

import numpy as np

from ...base.errors import FunctionError
from ...scene.contact_models import PenaltyContact
from ...scene.obstacles import Obstacle
from ...scene.obstacles.motion import Motion
from ...scene.obstacles.thickness import half_thickness_of_grid
from ...schemes.explicit.body_view import BodyView
from ..guards import Stop
from ..watched import Run
from .pace import NodePace

RARELY = 256  # rows between looks for nodes that are slow or far from the obstacle
SURFACE = 1e-6  # gap over half the thickness that counts as closed
OPPOSITE = -0.1  # cosine between the normals at entry and exit below which a node has passed through
FAR = 0.25  # motion over the thickness in a step, and between looks
SAMPLES = 9  # samples of a function of time until the next look
TRACED = 100  # maximum number of steps of the search for a surface


def half_thickness(obstacle: Obstacle) -> float:
    """Return the smallest depth [m] of an obstacle's middle; infinite without a far side."""
    if obstacle.shape in ("sphere", "cylinder"):
        radius, side = obstacle.parameters
        return radius if side > 0.0 else np.inf
    if obstacle.shape == "box":
        return min(obstacle.parameters)
    if obstacle.grid is not None:
        return half_thickness_of_grid(obstacle.grid, obstacle.parameters[3])
    return np.inf


class Crossing:
    """Positions of the contact nodes of a body at the last look, in the axes of an obstacle.

    entry [k, 3]: normal at which a node inside has entered, 0 for nodes outside.
    """

    def __init__(self, state: BodyView, obstacle: Obstacle, half: float, dt: float) -> None:
        contact = state.plan.contact
        assert contact is not None
        self.nodes = contact.nodes
        self.chosen = state.chosen(self.nodes)
        self.reference = state.start_of(self.chosen)
        self.obstacle, self.half = obstacle, half
        self.motion = Motion(obstacle, dt) if obstacle.moves and not obstacle.free else None
        self.before = self.positions(state, 0.0)
        gap, normal = obstacle.local(self.before)
        self.entry = np.where((gap < -SURFACE * self.half)[:, None], normal, 0.0)

    def positions(self, state: BodyView, time: float) -> np.ndarray:
        """Return the positions of the nodes [k, 3] [m] in the axes of the obstacle at the time [s]."""
        now = self.reference + state.latest_of(self.chosen)
        if self.obstacle.free:
            point, frame = state.pose(self.obstacle)
            return np.asarray((now - point) @ frame.T)
        if self.motion is None:
            return np.asarray((now - self.obstacle.reference) @ self.obstacle.frame.T)
        points, frames, _velocities, _spins = self.motion.poses(np.array([time]))
        return np.asarray((now - points[0]) @ frames[0].T)

    def speed_to_come(self, times: np.ndarray) -> float:
        """Return the largest speed [m/s] of the obstacle near the nodes at the times [s]; 0 without functions of time.

        It is infinite where a function fails: the next look then comes after the next row.
        """
        motion = self.motion
        if motion is None or not (motion.velocity.varies or motion.spin.varies):
            return 0.0
        arm = float(np.linalg.norm(self.before, axis=1).max())
        try:
            speeds, spins = (np.linalg.norm(rate.at(times), axis=1) for rate in (motion.velocity, motion.spin))
        except FunctionError:
            return float("inf")
        return float((speeds + arm * spins).max())

    def follow(self, now: np.ndarray) -> tuple[int | None, float, float]:
        """Follow the nodes to their present positions [k, 3] in the obstacle's axes.

        Returns the number of a node that has passed through, or None; the largest motion [m]; and the motion [m]
        allowed until the next look.
        """
        travel = np.linalg.norm(now - self.before, axis=1)
        gap, normal = self.obstacle.local(now)
        surface = SURFACE * self.half
        inside = gap < -surface
        # the surface is `gap` away: a node that has moved less has been outside all the way
        picked = np.flatnonzero((gap < 1.5 * travel + surface) | inside | self.entry.any(axis=1))
        missed = None
        if len(picked):
            entered = self.entry[picked]
            new = ~entered.any(axis=1)
            entered[new] = self._first_normal(self.before[picked[new]], now[picked[new]])
            left = np.where(inside[picked, None], normal[picked], 0.0)
            out = ~inside[picked] & entered.any(axis=1)
            left[out] = self._first_normal(now[picked[out]], self.before[picked[out]])
            through = np.einsum("ni,ni->n", entered, left) < OPPOSITE
            if through.any():
                missed = int(picked[np.flatnonzero(through)[0]])
            self.entry[picked] = np.where(inside[picked, None], entered, 0.0)
        self.before = now
        allowed = max(float(gap.min()), 2.0 * FAR * self.half)
        return missed, float(travel.max()), allowed

    def _first_normal(self, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        """Return the normals [n, 3] where the paths from start to end [n, 3] first meet the surface, else 0."""
        length = np.linalg.norm(end - start, axis=1)
        along = (end - start) / np.maximum(length, 1e-300)[:, None]
        surface = SURFACE * self.half
        done, found = np.zeros(len(start)), np.zeros_like(start)
        looking = np.arange(len(start))
        for _ in range(TRACED):
            gap, normal = self.obstacle.local(start[looking] + done[looking, None] * along[looking])
            there = gap <= surface
            found[looking[there]] = normal[there]
            done[looking] += np.maximum(gap, surface)
            looking = looking[~there & (done[looking] <= length[looking])]
            if not len(looking):
                break
        return found


class PathWatch:
    """Checks for contact nodes that have passed through an obstacle."""

    ends_launches = True

    def __init__(self, run: Run, halves: list[float]) -> None:
        self.due, self._seen = 0, -1
        self._pace = NodePace(run, RARELY)
        self._thin = [number for number, half in enumerate(halves) if np.isfinite(half)]
        self._crossings = [
            [Crossing(state, run.scene.obstacles[number], halves[number], run.dt) for number in self._thin]
            if state.plan.contact is not None and len(state.plan.contact.nodes)
            else []
            for state in run.states
        ]

    @staticmethod
    def of(run: Run) -> PathWatch | None:
        """Make the looks of a run; None without contact or without an obstacle that has a far side."""
        if not run.scene.touching:
            return None
        halves = [half_thickness(obstacle) for obstacle in run.scene.obstacles]
        return PathWatch(run, halves) if np.isfinite(halves).any() else None

    def look(self, run: Run, row: int, time: float, step: float) -> Stop | None:
        """Stop where a node has passed through an obstacle since the last look."""
        rows, largest = max(1, row - self._seen), 0.0
        ahead: list[tuple[float, float]] = []
        for state, crossings in zip(run.states, self._crossings, strict=True):
            for number, crossing in zip(self._thin, crossings, strict=False):
                now = crossing.positions(state, time + step)
                if not np.isfinite(now).all():
                    return None  # the guards stop at the next row
                missed, travel, allowed = crossing.follow(now)
                if missed is not None:
                    node = int(state.plan.node_order[crossing.nodes[missed]])
                    name = run.scene.obstacle_label(number)
                    what = f"node {node} of {state.plan.label} passed through {crossing.obstacle.shape} {name}"
                    what += f" at t = {time + step:.6g} s"
                    return Stop("missed-contact", f"{what}; {_remedy(run, crossing, travel / rows)}")
                largest = max(largest, travel)
                ahead.append((allowed, crossing.speed_to_come(times_to_come(run, time, step))))
        self._pace.follow(largest, time + step, step)
        wait = min((self._pace.rows(allowed, step, faster) for allowed, faster in ahead), default=float(RARELY))
        self.due, self._seen = row + max(1, int(min(wait, self._pace.most(rows, RARELY)))), row
        return None


def times_to_come(run: Run, time: float, step: float) -> np.ndarray:
    """Return times [s] until the next look, none after the end of the run, where functions need not exist."""
    return np.minimum(time + step + step * np.linspace(0.0, RARELY, SAMPLES), max(run.scene.duration, time))


def _remedy(run: Run, crossing: Crossing, travel: float) -> str:
    """Return the remedy; travel [m]: motion of the fastest node in a step."""
    thickness = 2.0 * crossing.half
    found = []
    if travel > FAR * thickness:
        found.append(f"use dt={FAR * thickness / travel * run.dt:.3g} or less")
    contact = run.scene.contact
    if isinstance(contact, PenaltyContact) or getattr(contact, "penalty", None) is not None:
        found.append("use a larger contact stiffness, or MasslessContact without a penalty")
    thicker = f"make the obstacle at least {max(travel / FAR, 2.0 * thickness):.3g} m thick"
    now = f"nodes move by {travel:.3g} m in a step and the obstacle is {thickness:.3g} m thick"
    return f"{now}: {'; '.join([*found, thicker])}"
