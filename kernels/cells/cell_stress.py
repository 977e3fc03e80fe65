"""Cauchy stress of every cell, for probes, maxima and frames: at its centre, with the pressure that the cell has.

    sigma = P F^t / J  (linear law: sigma = P)         one-point and fully integrated cells: P of the law
    sigma = P_mu F^t / J + p I                         cells with one volume change: P_mu of the law without its
                                                       volume part, p the pressure of the cell or the mean of its nodes

as in von_mises.py, whose norm of the stress comes with it. p is U' of the mean volume change in hexes with one volume
change (elements/hex8_mean_dilatation.py), and p_e in tetrahedra averaged at nodes (elements/tet4_node_averaged.py).
Several states of a body, one after the other in `u`, are computed in one launch.
"""

import functools

from .. import elements
from ..elements.hex8 import hex_modes, hex_slopes
from ..elements.hex8_mean_dilatation import along
from ..elements.tet4_node_averaged import averaged_volume
from ..engine import ti
from ..lanes import WIDTH
from ..language import tensor3
from ..language.arguments import ARRAY, INDEX
from ..language.compile_options import KEEP_VECTORS, compiled_with
from ..language.point_memory import PointMemory, recall
from ..language.vectors import load
from ..materials import LAWS
from .von_mises import cauchy, equivalent, plain_response, small

PARTS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))  # the six components of a stress
VON_MISES = len(PARTS)  # place of the von Mises norm behind them
NUMBERS = VON_MISES + 1
AVERAGES = 6  # numbers of a cell averaged at nodes: w_e, J_a - 1 of its corners, J - 1 of its own


@ti.func
def corner_of(values: ti.template(), connectivity: ti.template(), start, first, width: ti.template()):
    """Return a vector (3) of the nodes of one corner, each component a vector over the lanes."""
    node = [first + 3 * connectivity[start + lane] for lane in range(width)]
    return [ti.Vector([values[i + c] for i in node]) for c in range(3)]


@ti.func
def mean_change(x, u):
    """Return the mean of J - 1 over a hexahedron, without cancellation."""
    mode_x, mode_u = [hex_modes(x[c]) for c in range(3)], [hex_modes(u[c]) for c in range(3)]
    rest = hex_slopes(mode_x)
    now = hex_slopes([[mode_x[c][m] + mode_u[c][m] for m in range(7)] for c in range(3)])
    return 0.5 * ((along(rest[1], mode_u) + along(now[1], mode_u)) - hex_slopes(mode_u)[0]) / rest[0]


@ti.func
def mean_trace(x, u):
    """Return the mean of tr H over a hexahedron."""
    mode_x, mode_u = [hex_modes(x[c]) for c in range(3)], [hex_modes(u[c]) for c in range(3)]
    rest = hex_slopes(mode_x)
    return along(rest[1], mode_u) / rest[0]


@ti.func
def shape_response(law: ti.template(), h, parameters, memory: ti.template(), pressure, change):
    """Return the result of a law without its volume part, for the pressure and volume change of the cell."""
    if ti.static(memory and law.plastic):
        return law.update(h, parameters, recall(memory, 0), [pressure, change])
    else:
        without = [0.0] + [parameters[i] for i in range(1, len(parameters))]
        return plain_response(law, h, without, memory)


@ti.func
def pressure_of_change(law: ti.template(), change, parameters, memory: ti.template()):
    """Return U' [Pa] of the volume change of a cell; positive in tension."""
    if ti.static(memory and law.plastic):
        return law.plastic.volume(change, parameters, recall(memory, 0))[0]
    else:
        return parameters[0] * change


@functools.cache
def make_cell_stress(kind: str, law: str):
    """Return the kernel of a kind of cell (`elements.FUNCTIONS`) with a law (`materials.LAWS`), memoised.

    cell_stress(rows, connectivity, position, parameters, u, state, averages, out): cells packed WIDTH wide as (pack,
    corner, lane); position [3n]; u [rows, 3n]; state [packs, numbers, width] of a law that has one; averages [rows,
    packs, AVERAGES, width] of cells averaged at nodes; out [rows, packs, NUMBERS, width] [Pa]: stress, von Mises norm.
    """
    corners, functions = elements.CORNERS[kind], elements.FUNCTIONS[kind]
    gradient_of, averaged = functions.gradient, functions.averaged
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
            return [pressure_of_change(law_of, own, parameters, memory), own]

    @ti.func
    def stress_at(h, parameters, memory: ti.template(), answer: ti.template(), x, y, averages: ti.template(), place):
        """Return the stress of the cell; answer: of the law with its volume part."""
        if ti.static(split):
            part = pressure_part(x, y, parameters, memory, averages, place)
            shape = shape_response(law_of, h, parameters, memory, part[0], part[1])
            return tensor3.plus_identity(stress_of(shape[0], h, shape[2]), part[0])
        else:
            return stress_of(answer[0], h, answer[2])

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
            h = gradient_of(x, y)
            memory = ti.static(PointMemory(state, pack * (size * width), size, width, 0) if size else None)
            numbers = [parameters[j] for j in range(count)]
            shown = [0.0] + [parameters[j] for j in range(1, count)] if averaged else numbers  # as in von_mises.py
            answer = plain_response(law_of, h, shown, memory)
            square = equivalent(stress_of(answer[0], h, answer[2]))
            stress = stress_at(h, numbers, memory, answer, x, y, averages, i * (AVERAGES * width))
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
