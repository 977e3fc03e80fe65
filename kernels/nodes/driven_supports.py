"""Supports that functions of time drive: components with a given displacement D at every time level (METHOD 1).

    w^{n+1/2} = (D^{n+1} - D^n)/dt,   a_p = (w^{n+1/2} - w^{n-1/2})/(k0 + k1)

A prescribed component has u^n = D^n, v^n = w^{n-1/2} + k0 a_p and v^{n+1/2} = w^{n+1/2}. Where a mass tensor couples it
with free components, these feel the inertia of its acceleration: M^+ acts on f_ext - f - M a_p.
`supports.components` holds 3 * boundary node + axis of all components, then for each the number of its axis in the
table or -1, then the number of these axes; `supports.speeds` holds the velocities of all components, the displacements
[m] that add to D, then the table: for each level of a launch and each axis the numbers below.
"""

from ..engine import ti
from ..lanes import DRIFT, DRIVEN_AXIS
from ..language.threads import item, meet, turns
from .boundary_nodes import component_count, symmetric

SPEED, ACCELERATION, NEXT_SPEED, NEXT_DISPLACEMENT = range(DRIVEN_AXIS)  # v^n, a_p, v^{n+1/2}, D^{n+1}


@ti.func
def table_place(supports: ti.template(), i, number):
    """Return where the numbers of component i begin at level `number` of a launch; -1 if no function drives it."""
    count = component_count(supports)
    axis, axes = supports.components[count + i], supports.components[2 * count]
    return ti.select(axis >= 0, 2 * count + DRIVEN_AXIS * (number * axes + axis), -1)


@ti.func
def accelerate(
    body: ti.template(), boundary: ti.template(), supports: ti.template(), contact: ti.template(), number
):  # fmt: skip
    """Set driven components to v^n, and add the inertia of their acceleration to special_force.

    The components of a node, which stand one after the other, are taken by one thread.
    """
    count = component_count(supports)
    for turn in range(turns(contact, count)):
        first = item(contact, turn)
        if ti.static(contact.options.threads > 1):
            same = 1
            if first > 0:
                same = ti.select(supports.components[first - 1] // 3 == supports.components[first] // 3, 0, 1)
            for i in range(first, ti.min(first + 3 * same, count)):
                if supports.components[i] // 3 == supports.components[first] // 3:
                    accelerate_component(body, boundary, supports, i, number)
        else:
            accelerate_component(body, boundary, supports, first, number)
    meet(contact)


@ti.func
def accelerate_component(body: ti.template(), boundary: ti.template(), supports: ti.template(), i, number):
    """Do so with one component, if a function drives it."""
    place = table_place(supports, i, number)
    if place >= 0:
        s, axis = supports.components[i] // 3, supports.components[i] % 3
        mass = symmetric(boundary.mass, s)
        for j in ti.static(range(3)):
            for k in ti.static(range(3)):
                if k == axis:
                    inertia = mass[j, k] * supports.speeds[place + ACCELERATION]
                    body.special_force[3 * s + j] = body.special_force[3 * s + j] + inertia
        speed = supports.speeds[place + SPEED]
        supports.speeds[i] = speed
        body.v[3 * boundary.nodes[s] + axis] = speed


@ti.func
def move_on(
    body: ti.template(), boundary: ti.template(), supports: ti.template(), contact: ti.template(), number
):  # fmt: skip
    """Set driven components to v^{n+1/2} and u^{n+1}, unless no step follows."""
    count = component_count(supports)
    for turn in range(turns(contact, count)):
        i = item(contact, turn)
        place = table_place(supports, i, number)
        if place >= 0 and body.params[DRIFT] != 0.0:
            s, axis = supports.components[i] // 3, supports.components[i] % 3
            component = 3 * boundary.nodes[s] + axis
            body.v[component] = supports.speeds[place + NEXT_SPEED]
            body.u[component] = supports.speeds[count + i] + supports.speeds[place + NEXT_DISPLACEMENT]
    meet(contact)
