"""Warn of removal="normal" with bodies or walls that turn, before the run and as soon as one has turned."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...base.errors import FunctionError
from ...base.warning_kinds import RotationWarning
from ...mesh.geometry import joined
from ...planning.removal import SPINS
from ...planning.rotation import angle, rotation, spin, turns_freely
from ...scene.contact_models import MasslessContact
from ...scene.obstacles import Obstacle
from ...scene.obstacles.motion import Motion
from ..guards import Stop
from ..watched import Run

TURNED = np.radians(5.0)  # rotation of a body or a wall since the start
SLIGHT = np.radians(0.1)  # rotation below which nothing turns
OFTEN, RARELY = 8, 32  # rows between looks, for fast and for slow rotation
SAMPLES = 512  # largest number of nodes for the rotation of a body
TIMES = 65  # times at which the motion of a wall is checked before the run
REMEDY = (
    "normal removal takes mass along the normals of the start and loses angular momentum where they turn:"
    " use removal='full'; where full removal does not converge, as for poisson near 1/2, a finer mesh loses"
    " less, as its cell size squared"
)


class NormalWatch:
    """Checks the rotation of bodies with normal removal and of the walls.

    Bodies that their supports keep from turning are left out: what looks like a rotation there is a change of shape.
    Only rotations that tilt the normal count, if all obstacles are planes of one direction: a body that spins about it
    keeps its normals. A launch of many rows ends at a look while a body or a wall is turning.
    """

    def __init__(self, run: Run, numbers: list[int]) -> None:
        self.due, self._seen, self._far, self._warned = OFTEN, 0, 0.0, False
        self.ends_launches = True
        contact = run.states[numbers[0]].plan.contact
        self._normal = _common_normal(run.scene.obstacles)
        if run.scene.body_pairs and contact is not None and contact.basis is not None:
            self._normal = contact.basis[0, :, 0]  # one direction serves all bodies in contact
        self._numbers = [n for n in numbers if turns_freely(run.scene.bodies[n])]
        self._chosen, self._reference, self._start, self._mass = [], [], [], []
        for number in self._numbers:
            state = run.states[number]
            picked = np.arange(0, state.plan.node_count, -(-state.plan.node_count // SAMPLES))
            self._chosen.append(state.chosen(picked))
            self._reference.append(state.start_of(self._chosen[-1]))
            self._start.append(self._reference[-1] + state.latest_of(self._chosen[-1]))
            self._mass.append(state.plan.lumped[picked])
        self._motions = [Motion(one) for one in run.scene.obstacles if one.turns and not one.free]
        self._free = [one for one in run.scene.obstacles if one.free]

    @staticmethod
    def of(run: Run) -> NormalWatch | None:
        """Make the watch of a run, None if no body has normal removal. Warns of prescribed rotations and spins."""
        contacts = [state.plan.contact for state in run.states]
        chosen = [i for i, contact in enumerate(contacts) if contact is not None and contact.removal == "normal"]
        if not chosen or not isinstance(run.scene.contact, MasslessContact):
            return None
        watch = NormalWatch(run, chosen)
        watch._warn_before(run)
        return watch

    def _warn_before(self, run: Run) -> None:
        duration = run.scene.duration
        for number in self._numbers:
            state, body = run.states[number], run.scene.bodies[number]
            if state.starts_as_one():  # without a spin
                continue
            nodes = joined([*body.mesh.portions("nodes")]) + state.plan.to_user(state.latest())
            mass = state.plan.to_user(state.plan.lumped)
            turns = spin(body, state.plan.to_user(state.start_velocity), nodes, mass)
            if self._normal is not None:
                turns = turns - (turns @ self._normal) * self._normal
            far = float(np.linalg.norm(turns)) * duration
            if far > SPINS:
                text = f"{state.plan.label} has removal='normal' and starts to turn by {far:.3g} rad in the duration"
                run.warn(f"{text}; {REMEDY}", RotationWarning)
        for obstacle in run.scene.obstacles:
            if obstacle.turns and not obstacle.free:
                try:
                    far = _wall_angle(Motion(obstacle), np.linspace(0.0, duration, TIMES))
                except FunctionError:  # the run stops there; until then the looks warn
                    continue
                if far > SPINS:
                    text = f"the {obstacle.shape} {obstacle.name or ''}".rstrip()
                    text += f" turns by {np.degrees(far):.3g} degrees under removal='normal'"
                    run.warn(f"{text}; {REMEDY}", RotationWarning)

    def look(self, run: Run, row: int, time: float, step: float) -> Stop | None:
        """Warn once when a body or a wall has turned."""
        self.due = row + RARELY
        if self._warned:
            return None
        furthest = 0.0
        for who, far in self._angles(run, time + step):
            if not np.isfinite(far):
                return None  # the guards stop at the next row
            if far > TURNED:
                self._warn(run, who, far, time + step)
                self.ends_launches = False
                return None
            furthest = max(furthest, far)
        rate = (furthest - self._far) / max(1, row - self._seen)
        wait = RARELY if rate <= 0.0 else 0.5 * (TURNED - furthest) / rate
        self.due = row + int(np.clip(wait, OFTEN, RARELY))
        self._seen, self._far = row, furthest
        self.ends_launches = furthest > SLIGHT
        return None

    def _angles(self, run: Run, time: float) -> Iterator[tuple[str, float]]:
        """Return name and angle [rad] of every body with normal removal and of every wall that turns."""
        lists = self._numbers, self._chosen, self._reference, self._start, self._mass
        for number, chosen, reference, start, mass in zip(*lists, strict=True):
            state = run.states[number]
            now = reference + state.latest_of(chosen)
            far = angle(rotation(start, now, mass), self._normal) if np.isfinite(now).all() else np.nan
            yield state.plan.label, far
        for obstacle in self._free:
            frame = run.states[self._numbers[0] if self._numbers else 0].pose(obstacle)[1]
            yield obstacle.name or f"the {obstacle.shape}", _turned(obstacle, frame[None])
        for motion in self._motions:
            yield motion.obstacle.name or f"the {motion.obstacle.shape}", _wall_angle(motion, np.array([time]))

    def _warn(self, run: Run, who: str, far: float, time: float) -> None:
        self._warned = True
        text = f"{who} has turned by {np.degrees(far):.2g} degrees at t = {time:.6g} s under removal='normal'"
        run.warn(f"{text}; {REMEDY}", RotationWarning)


def _common_normal(obstacles: Sequence[Obstacle]) -> np.ndarray | None:
    """Return the common direction of planes; None for other obstacles and for planes of several directions."""
    if not obstacles or not all(obstacle.shape == "plane" for obstacle in obstacles):
        return None
    normals = np.array([obstacle.frame[2] for obstacle in obstacles])
    across = np.linalg.norm(np.cross(normals, normals[0]), axis=1)
    return np.asarray(normals[0]) if across.max() < 1e-6 else None


def _wall_angle(motion: Motion, times: np.ndarray) -> float:
    """Return the largest angle [rad] by which a wall's surface has turned at the times [s] since the start.

    A plane and a cylinder turn with their axis alone, a sphere does not.
    """
    if motion.obstacle.shape == "sphere":
        return 0.0
    return _turned(motion.obstacle, motion.poses(times)[1])


def _turned(obstacle: Obstacle, frames: np.ndarray) -> float:
    """Return the largest angle [rad] between the surface of an obstacle at the start and in frames [m, 3, 3]."""
    shape, start = obstacle.shape, obstacle.frame
    if shape == "sphere":
        return 0.0
    if shape in ("plane", "cylinder"):
        return max(float(np.arccos(np.clip(frame[2] @ start[2], -1.0, 1.0))) for frame in frames)
    return max(angle(frame.T @ start) for frame in frames)
