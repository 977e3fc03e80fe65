"""State of the quadrature points of laws with history: memory[pack][point][number][lane], 0 at the start.

A law reads the old state at every call. The new state is stored only in the force pass of a step ("commit"); measures,
products and trial passes do not change it. A law without state has no memory (None), at no cost.
"""

from typing import Any, NamedTuple

import taichi as ti


class PointMemory(NamedTuple):
    """The state of the cells of one pack.

    state: the array; start: place of number 0 of point 0 in lane 0; size: numbers per point; width: lanes; commit: 1 if
    the new state is stored.
    """

    state: Any
    start: Any
    size: int
    width: int
    commit: Any


@ti.func
def recall(memory: ti.template(), point):
    """Return the stored state of a point, each number a vector over the lanes."""
    first = point * (memory.size * memory.width)
    return [
        ti.Vector([memory.state[memory.start + first + i * memory.width + lane] for lane in range(memory.width)])
        for i in range(memory.size)
    ]


@ti.func
def respond(law: ti.template(), h, parameters, memory: ti.template(), point):
    """Return the result of a law at a point of the cell; its state is read and, if the pass commits, stored."""
    if ti.static(memory):
        answer = law(h, parameters, recall(memory, point))
        if memory.commit != 0:
            first = point * (memory.size * memory.width)
            for i, lane in ti.static(ti.ndrange(memory.size, memory.width)):
                memory.state[memory.start + first + i * memory.width + lane] = answer[3][i][lane]
        return answer
    else:
        return law(h, parameters)


@ti.func
def tangent_at(
    part: ti.template(), f, parameters, pressure, body: ti.template(), place, point, size: ti.template(),
    width: ti.template(),
):  # fmt: skip
    """Return the data of a part of the second derivative (`Tangent` of materials/law.py) at a point of one cell.

    place: number 0 of point 0 of the cell in `body.memory`; size: numbers of state per point; width: lanes of a pack.
    """
    if ti.static(size > 0):
        first = place + point * (size * width)
        return part.point(f, parameters, pressure, [body.memory[first + i * width] for i in range(size)])
    else:
        return part.point(f, parameters, pressure)
