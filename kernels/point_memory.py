"""What the quadrature points of a law with state keep from step to step: state[pack][point][number][lane].

`old` is read at every call of the law; `new` is stored only where the pass commits, that is in the step pass: measures,
products and trial passes leave the state as it is. A law without state has no memory (None): no array, no cost.
"""

from typing import Any, NamedTuple

import taichi as ti


class PointMemory(NamedTuple):
    """The state of the cells of one pack.

    state: the array; start: place of number 0 of point 0 in every lane; size: numbers a point; width: lanes;
    commit: whether `new` is stored.
    """

    state: Any
    start: Any
    size: int
    width: int
    commit: Any


@ti.func
def respond(law: ti.template(), h, parameters, memory: ti.template(), point):
    """Return the answer of a law at a point of the cell, with its state read and, if the pass commits, stored."""
    if ti.static(memory):
        first = point * (memory.size * memory.width)
        old = [
            ti.Vector([memory.state[start + (first + i * memory.width)] for start in memory.start])
            for i in range(memory.size)
        ]
        answer = law(h, parameters, old)
        if memory.commit != 0:
            for i in ti.static(range(memory.size)):
                for lane in ti.static(range(memory.width)):
                    memory.state[memory.start[lane] + (first + i * memory.width)] = answer[3][i][lane]
        return answer
    else:
        return law(h, parameters)
