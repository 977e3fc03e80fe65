"""Cauchy stress of every cell, for probes, maxima and frames: at its centre, with the pressure that the cell has.

    sigma = P F^t / J  (linear law: sigma = P)         one-point and fully integrated cells: P of the law
    sigma = P_mu F^t / J + p I                         cells with one volume change: P_mu of the law without its
                                                       volume part, p the pressure of the cell or the mean of its nodes

as in von_mises.py, whose norm of the stress comes with it. p is U' of the mean volume change in hexes with one volume
change (elements/hex8_mean_dilatation.py), and p_e in tetrahedra averaged at nodes (elements/tet4_node_averaged.py).
Of a law with a state the stress is the mean of the points of the cell (law_stress.py). Several states of a body, one
after the other in `u`, are computed in one launch.
"""

import functools

from .. import elements
from ..elements.tet4_node_averaged import averaged_volume
from ..engine import ti
from ..lanes import WIDTH
from ..language import tensor3
from ..language.arguments import ARRAY, INDEX
from ..language.compile_options import KEEP_VECTORS, compiled_with
from ..language.vectors import load
from ..materials import LAWS
from .law_stress import (
    cauchy,
    mean_change,
    mean_of_points,
    mean_trace,
    memory_of,
    plain_response,
    shape_response,
    small,
    takes_mean,
)
from .von_mises import equivalent

PARTS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))  # the six components of a stress
VON_MISES = len(PARTS)  # place of the von Mises norm behind them
NUMBERS = VON_MISES + 1
AVERAGES = 6  # numbers of a cell averaged at nodes: w_e, J_a - 1 of its corners, J - 1 of its own


@ti.func
def corner_of(values: ti.template(), connectivity: ti.template(), start, first, width: ti.template()):
    """Return a vector (3) of the nodes of one corner, each component a vector over the lanes."""
    node = [first + 3 * connectivity[start + lane] for lane in range(width)]
    return [ti.Vector([values[i + c] for i in node]) for c in range(3)]


@functools.cache
def make_cell_stress(kind: str, law: str):
    """Return the kernel of a kind of cell (`elements.FUNCTIONS`) with a law (`materials.LAWS`), memoised.

    cell_stress(rows, connectivity, position, parameters, u, state, averages, out): cells packed WIDTH wide as (pack,
    corner, lane); position [3n]; u [rows, 3n]; state [packs, points, numbers, width] of a law that has one; averages
    [rows, packs, AVERAGES, width] of cells averaged at nodes; out [rows, packs, NUMBERS, width] [Pa]: stress, von Mises
    norm.
    """
    corners, functions = elements.CORNERS[kind], elements.FUNCTIONS[kind]
    gradient_of, averaged, points = functions.gradient, functions.averaged, functions.points
    of_points = takes_mean(kind, law)
    mean_of = mean_of_points(kind, law) if of_points else None
    split = averaged or functions.tangent == "mean-dilatation"
    width, law_of, size = WIDTH, LAWS[law], len(LAWS[law].state)
    count = len(law_of.parameters) + law_of.rates
    stress_of = small if law_of.linear else cauchy
    change_of = mean_trace if law_of.linear else mean_change

    @ti.func
    def pressure_part(x, y, parameters, memory: ti.template(), averages: ti.template(), place):
        """Return U' and J - 1 of the cell."""
        if ti.static(averaged):
            part = [load(averages, place + i * width, width) for i in range(AVERAGES)]
            own = part[5]
            return [averaged_volume(law_of, own, parameters, [part[0], [part[1 + k] for k in range(4)]])[0], own]
        else:
            own = change_of(x, y)
            return [parameters[0] * own, own]

    @ti.func
    def stress_at(h, parameters, memory: ti.template(), answer: ti.template(), x, y, averages: ti.template(), place):
        """Return the stress of the cell; answer: of the law with its volume part."""
        if ti.static(split):
            part = pressure_part(x, y, parameters, memory, averages, place)
            shape = shape_response(law_of, h, parameters, memory, 0, part[0], part[1])
            return tensor3.plus_identity(stress_of(shape[0], h, shape[2]), part[0])
        else:
            return stress_of(answer[0], h, answer[2])

    @ti.func
    def stress_and_square(x, y, numbers, memory: ti.template(), averages: ti.template(), place):
        """Return the stress of the cell and 3/2 s:s of the one that von_mises.py shows."""
        if ti.static(of_points):
            mean = mean_of(x, y, numbers, memory)
            return [mean, equivalent(mean)]
        else:
            h = gradient_of(x, y)
            shown = [0.0] + [numbers[j] for j in range(1, count)] if averaged else numbers  # as in von_mises.py
            answer = plain_response(law_of, h, shown, memory, 0)
            stress = stress_at(h, numbers, memory, answer, x, y, averages, place)
            return [stress, equivalent(stress_of(answer[0], h, answer[2]))]

    @ti.kernel
    def cell_stress(rows: ti.i32, connectivity: INDEX, position: ARRAY, parameters: ARRAY, u: ARRAY, state: ARRAY,
                    averages: ARRAY, out: ARRAY):  # fmt: skip
        for i in range(rows * (connectivity.shape[0] // (corners * width))):
            packs = connectivity.shape[0] // (corners * width)
            pack = i % packs
            start, first = pack * (corners * width), (i // packs) * position.shape[0]
            at_rest = [corner_of(position, connectivity, start + k * width, 0, width) for k in range(corners)]
            moved = [corner_of(u, connectivity, start + k * width, first, width) for k in range(corners)]
            x = [[at_rest[k][c] for k in range(corners)] for c in range(3)]
            y = [[moved[k][c] for k in range(corners)] for c in range(3)]
            memory = ti.static(memory_of(state, pack, points, size, width) if size else None)
            numbers = [parameters[j] for j in range(count)]
            found = stress_and_square(x, y, numbers, memory, averages, i * (AVERAGES * width))
            stress, square = found[0], found[1]
            for lane in ti.static(range(width)):
                place = i * (NUMBERS * width) + lane
                for j, part in ti.static(enumerate(PARTS)):
                    out[place + j * width] = 0.5 * (stress[part[0]][part[1]][lane] + stress[part[1]][part[0]][lane])
                out[place + VON_MISES * width] = ti.sqrt(square[lane])

    return compiled_with(cell_stress, **KEEP_VECTORS)


@functools.cache
def make_volume_change(kind: str, law: str):
    """Return the kernel of V (J - 1) of cells averaged at nodes, memoised; arguments as those of `make_cell_stress`.

    volume_change(rows, connectivity, position, u, out): out [rows, packs, width] [m^3].
    """
    corners, functions, width = elements.CORNERS[kind], elements.FUNCTIONS[kind], WIDTH
    change_of = (LAWS[law].linear and functions.linear_volume) or functions.volume

    @ti.kernel
    def volume_change(rows: ti.i32, connectivity: INDEX, position: ARRAY, u: ARRAY, out: ARRAY):
        for i in range(rows * (connectivity.shape[0] // (corners * width))):
            packs = connectivity.shape[0] // (corners * width)
            start, first = (i % packs) * (corners * width), (i // packs) * position.shape[0]
            at_rest = [corner_of(position, connectivity, start + k * width, 0, width) for k in range(corners)]
            moved = [corner_of(u, connectivity, start + k * width, first, width) for k in range(corners)]
            x = [[at_rest[k][c] for k in range(corners)] for c in range(3)]
            y = [[moved[k][c] for k in range(corners)] for c in range(3)]
            change = change_of(x, y)
            for lane in ti.static(range(width)):
                out[i * width + lane] = change[lane]

    return compiled_with(volume_change, **KEEP_VECTORS)
