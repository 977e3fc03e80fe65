"""The step of one node on a GPU, where each thread takes a node: its force, the kick and the drift.

    f = sum of its corner forces in a fixed order,   a = g - f/m  (with damping: damping.py)
    v_n = v + kick_before a,   v <- v_n + kick_after a,   u <- u + drift v

Step sizes and gravity are arguments of the launch, so that no number has to be copied to the device between steps.
"""

from typing import Any, NamedTuple

from ..engine import ti
from ..lanes import DAMPING, FREE, GRAVITY, WIDTH
from .damping import damped_acceleration


class StepNumbers(NamedTuple):
    """The numbers of a step at the places of `params` (lanes.py) up to the constants of the damping law."""

    params: Any


@ti.func
def step_numbers(body: ti.template(), steps: ti.template(), pulled: ti.template()):
    """Return the numbers of a step as a list in the order of `params`; steps: kicks, drift and gravity.

    pulled: gravity is a function of time, which stands in `params`.
    """
    given = ti.static(GRAVITY if pulled else DAMPING)
    return [steps[i] for i in range(given)] + [body.params[i] for i in range(given, FREE)]


@ti.func
def first_of_corner(place):
    """Return where component 0 of the force of a corner stands, from its place in `connectivity`.

    Components are WIDTH numbers apart.
    """
    lane = place & (WIDTH - 1)
    return 3 * (place - lane) + lane


@ti.func
def node_force(lists: ti.template(), node):
    """Return the sum of the corner forces (3) of a node, in the order of its list."""
    force = [0.0, 0.0, 0.0]
    for entry in range(lists.node_corners[node], lists.node_corners[node + 1]):
        first = first_of_corner(lists.node_corners[entry])
        for d in ti.static(range(3)):
            force[d] += lists.corner_forces[first + d * WIDTH]
    return force


@ti.func
def moved_node(body: ti.template(), node, force, numbers: ti.template(), damped: ti.template()):
    """Kick and drift an ordinary node; return its NODE_SUMS (columns.py): kinetic energy, momentum, spin, mass u.

    numbers: `step_numbers`; damped: name of the damping law, "" without.
    """
    step = ti.static(StepNumbers(numbers))
    kick_before, kick_after, drift = numbers[0], numbers[1], numbers[2]
    m = body.mass[node]
    inverse = 1.0 / m
    p, x, moved = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
    kinetic = 0.0
    for d in ti.static(range(3)):
        old = body.v[3 * node + d]
        acceleration = damped_acceleration(damped, step, numbers[3 + d] - force[d] * inverse, old)
        middle = old + kick_before * acceleration
        new = old + (kick_before + kick_after) * acceleration
        here = body.u[3 * node + d]
        body.v[3 * node + d] = new
        body.u[3 * node + d] = ti.select(drift == 0.0, here, here + drift * new)
        p[d] = m * middle
        x[d] = body.position[3 * node + d] + here
        moved[d] = m * here
        kinetic += 0.5 * p[d] * middle
    spin = [x[1] * p[2] - x[2] * p[1], x[2] * p[0] - x[0] * p[2], x[0] * p[1] - x[1] * p[0]]
    return [kinetic] + p + spin + moved
