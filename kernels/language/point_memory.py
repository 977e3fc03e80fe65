"""State of the quadrature points of laws with history: memory[pack][point][number][lane], 0 at the start.

A law reads the old state at every call. The new state is stored only in the force pass of a step ("commit"); measures,
products and trial passes do not change it. A law without state has no memory (None), at no cost. Of a law with plastic
flow the points of a cell add up what they dissipate in `tally`.
"""

from typing import Any, NamedTuple

from ..engine import ti
from ..lanes import STEP
from .precision import single


class PointMemory(NamedTuple):
    """The state of the cells of one pack.

    state: the array; start: place of number 0 of point 0 in lane 0; size: numbers per point; width: lanes; commit: 1 if
    the new state is stored; pressure: of the cell [U', mean of J - 1], [] where every point has its own; tally: of a
    law with plastic flow dissipated energy, largest plastic strain and temperature rise of the points, energy that
    hourglass modes let go. single: the memory is that of one cell, in the lane where `start` is, and its numbers are
    scalars.
    """

    state: Any
    start: Any
    size: int
    width: int
    commit: Any
    pressure: Any = ()
    tally: Any = None
    single: bool = False


WORK, STRAIN, WARMING, RELEASED = range(4)  # numbers of `tally`


@ti.func
def recall(memory: ti.template(), point):
    """Return the stored state of a point, in the precision of the caller.

    Each number is a vector over the lanes, or of a single cell a scalar.
    """
    first = point * (memory.size * memory.width)
    if ti.static(memory.single):
        return [memory.state[memory.start + first + i * memory.width] for i in range(memory.size)]
    elif ti.static(single()):  # the compiler has no cast of vectors
        kept = lanes_of(memory, first)
        return [ti.Vector([ti.cast(kept[i][lane], ti.f32) for lane in range(memory.width)]) for i in range(memory.size)]
    else:
        return lanes_of(memory, first)


@ti.func
def lanes_of(memory: ti.template(), first):
    """Return the numbers of a point, each a vector over the lanes; first: place of the first one behind `start`."""
    return [
        ti.Vector([memory.state[memory.start + first + i * memory.width + lane] for lane in range(memory.width)])
        for i in range(memory.size)
    ]


@ti.func
def any_above_zero(a):
    """Return whether a number, or any lane of a vector, is above 0."""
    if ti.static(a.is_tensor()):
        return a.max() > 0.0
    else:
        return a > 0.0


@ti.func
def respond(law: ti.template(), h, parameters, memory: ti.template(), point, volume):
    """Return the result of a law at a point of the cell; its state is read and, if the pass commits, stored.

    volume: of the point, in the unit in which the element sums up energies.
    """
    if ti.static(memory and law.plastic):
        answer = law.update(h, parameters, recall(memory, point), memory.pressure)
        memory.tally[WORK] = memory.tally[WORK] + volume * answer[4]
        for j, number in ti.static(((STRAIN, law.plastic.strain), (WARMING, law.plastic.warming))):
            memory.tally[j] = ti.max(memory.tally[j], answer[3][number])
        if ti.static(law.plastic.always):
            store(memory, point, answer[3])
        elif any_above_zero(answer[4]):  # else the state is the old one, bit for bit
            store(memory, point, answer[3])
        return answer
    elif ti.static(memory):
        answer = law.update(h, parameters, recall(memory, point))
        store(memory, point, answer[3])
        return answer
    else:
        return law.update(h, parameters)


@ti.func
def store(memory: ti.template(), point, new):
    """Store the new state of a point if the pass commits."""
    if memory.commit != 0:
        first = point * (memory.size * memory.width)
        for i in ti.static(range(memory.size)):
            if ti.static(memory.single):
                memory.state[memory.start + first + i * memory.width] = new[i]
            else:
                for lane in ti.static(range(memory.width)):
                    memory.state[memory.start + first + i * memory.width + lane] = new[i][lane]


@ti.func
def heat_points(law: ti.template(), parameters, memory: ti.template(), points: ti.template(), rise):
    """Raise the stored temperature of all points of the cell by `rise` [K]; return the largest temperature rise."""
    hottest = 0.0 * rise
    for point in range(points):
        new = law.plastic.heated(recall(memory, point), parameters, rise)
        hottest = ti.max(hottest, new[0])
        first = memory.start + (point * memory.size + law.plastic.warming) * memory.width
        for i in ti.static(range(len(new))):
            for lane in ti.static(range(memory.width)):
                memory.state[first + i * memory.width + lane] = new[i][lane]
    return hottest


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


@ti.func
def constants_of(body: ti.template(), place, law: ti.template()):
    """Return the parameters of a law from `place` of `params` on, and the step behind them if it depends on rates."""
    if ti.static(law.rates):
        return [body.params[place + i] for i in range(len(law.parameters))] + [body.params[STEP]]
    else:
        return [body.params[place + i] for i in range(len(law.parameters))]


@ti.func
def mean_of_points(
    body: ti.template(), place, number, size: ti.template(), width: ti.template(), points: ti.template()
):
    """Return the mean over the points of a cell of one number of the state; place: see `tangent_at`."""
    total = 0.0
    for point in range(points):
        total += body.memory[place + (point * size + number) * width]
    return total / points
