"""Bound what loads, driven supports and moving obstacles can do to the bodies of a run in the rows to come.

A look sees how bodies have moved, not what will set them going: functions of time are asked for that. A traction t on
faces gives the material behind them the speed |t| / (density wave speed) at once, and the body the acceleration
|t| area / mass; a force that nodes share equally accelerates the lightest of them most. An own force, which depends on
positions and velocities, and a function that fails have no bound.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...base.errors import FunctionError
from ...planning.body_plan import BodyPlan
from ...scene.body import Body
from ...scene.loads import Load
from ...scene.obstacles.motion import Rate
from ...scene.time_functions import TimeFunction
from ..watched import Run

UNBOUNDED = 1e100  # speed [m/s] and acceleration [m/s^2] that stand for no bound


class Drive(NamedTuple):
    """A function of time and what it does: speed and acceleration over the largest size of its values.

    size: number of components that belong together; derived: the speed is that of its values as displacements.
    """

    function: TimeFunction
    speed: float
    acceleration: float
    size: int
    derived: bool = False

    def at(self, times: np.ndarray) -> np.ndarray:
        """Return the bounds of speed [m/s] and acceleration [m/s^2] at times [m] [s]. Raises `FunctionError`."""
        values = self.function.at(times if self.function.varies or self.derived else times[:1])
        if self.derived:
            steps = np.diff(times)
            values = np.diff(values, axis=0)[steps > 0.0] / steps[steps > 0.0, None]
        largest = float(np.linalg.norm(values.reshape(-1, self.size), axis=1).max(initial=0.0))
        return np.array([self.speed * largest, self.acceleration * largest])


class Drives:
    """The drives of all bodies of a run, and its obstacles that move as prescribed if these are asked for.

    rows: the most that lie between two looks. Each function is asked about twice as many at a time.
    fastest, strongest: largest speed [m/s] that a load or a support gives at once, and acceleration [m/s^2], in the
    rows to come; obstacle [m/s]: largest speed of an obstacle then.
    """

    def __init__(self, run: Run, rows: int, obstacles: bool) -> None:
        scene = run.scene
        self._rows = rows
        self._end, self._unbounded = float(scene.duration), False
        self._of_body: list[list[Drive]] = []
        for body, state in zip(scene.bodies, run.states, strict=True):
            own = [load.own for load in body.loads]
            self._unbounded |= any(own)
            found = [_of_load(body, load, state.plan) for load in body.loads if not load.own]
            found += [
                Drive(support.function(), 1.0, 0.0, len(support.axes), support.kind == "displacement")
                for support in body.driven
            ]
            self._of_body.append(found)
        self._always = max((body.spring_speed for body in scene.bodies), default=0.0)
        self._gravity = scene.largest_gravity
        moving = [one for one in scene.obstacles if one.moves and not one.free] if obstacles else []
        self._rates = [tuple(Rate(one, name) for name in ("velocity", "angular_velocity")) for one in moving]
        self._known, self._step = -np.inf, 0.0
        self.fastest, self.strongest, self.obstacle = 0.0, 0.0, 0.0

    @property
    def some(self) -> bool:
        """Whether anything drives a body."""
        return self._unbounded or any(self._of_body) or self._always > 0.0 or self._gravity > 0.0

    def ask(self, time: float, step: float, arm: float = 0.0) -> None:
        """Ask about the rows from a time [s] on; step [s]: between them; arm [m]: from obstacles to bodies, at most."""
        if time + self._rows * step <= self._known and step <= self._step:
            return
        self._known, self._step = time + 2 * self._rows * step, step
        times = np.unique(np.minimum(time + step * np.arange(2 * self._rows + 1), max(time, self._end)))
        try:
            bounds = [sum((drive.at(times) for drive in found), np.zeros(2)) for found in self._of_body]
            speed, acceleration = np.max(bounds, axis=0)
            self.obstacle = 0.0
            for velocity, spin in self._rates:
                parts = [np.linalg.norm(rate.at(times), axis=1) for rate in (velocity, spin)]
                self.obstacle = max(self.obstacle, float((parts[0] + arm * parts[1]).max()))
        except FunctionError:  # the run stops where it fails
            speed, acceleration, self.obstacle = UNBOUNDED, UNBOUNDED, UNBOUNDED if self._rates else 0.0
        self.fastest = min(float(speed) + self._always, UNBOUNDED)
        self.strongest = UNBOUNDED if self._unbounded else min(float(acceleration) + self._gravity, UNBOUNDED)


def _of_load(body: Body, load: Load, plan: BodyPlan) -> Drive:
    """Return the drive of a load that is no own force; plan: that of the body."""
    function, size = load.function(body.mesh), 1 if load.kind == "pressure" else 3
    if load.on_nodes(body.mesh):
        nodes = plan.place[load.nodes(body.mesh)]
        return Drive(function, 0.0, 1.0 / (len(nodes) * float(plan.lumped[nodes].min())), size)
    corners = body.mesh.nodes_at(load.faces(body.mesh))
    across = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    area = 0.5 * float(np.linalg.norm(across, axis=1).sum())
    stiffness = min(material.density * material.wave_speed for material in body.materials)
    over = area if load.kind == "force" else 1.0  # from its values to tractions
    return Drive(function, 1.0 / (stiffness * over), area / (over * body.mass), size)
