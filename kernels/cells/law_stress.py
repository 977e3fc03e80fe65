"""Cauchy stress of a law at a gradient, and its mean over the points of a cell whose law keeps a state.

    sigma = P F^t / J  (linear law: sigma = P),     <sigma> = sum_q J D w sigma_q / sum_q J D w  (+ p I)

each point q with its own state and gradient, D = det dX/dr and w its weight in the reference cell; in cells with one
volume change (elements/hex8_mean_dilatation.py) with the pressure p of the cell. Stresses on or within a yield surface
have a mean that is so, too, as the surface is convex. The gradient of the centre with a mean state has not.
"""

from .. import elements
from ..elements.hex8 import hex_modes, hex_slopes
from ..elements.hex8_mean_dilatation import along, mean_state
from ..engine import ti
from ..language import tensor3
from ..language.point_memory import PointMemory, recall
from ..materials import LAWS


@ti.func
def cauchy(piola, h, change):
    """Return P F^t / J."""
    turned = tensor3.product_transposed(piola, tensor3.plus_identity(h, 1.0))
    return tensor3.scaled(1.0 / (1.0 + change), turned)


@ti.func
def small(piola, h, change):
    """Return P, the only stress measure of the linear law."""
    return piola


@ti.func
def plain_response(law: ti.template(), h, parameters, memory: ti.template(), point):
    """Return the result of a law for the state of a point; nothing is stored or added up."""
    if ti.static(memory and law.plastic):
        return law.update(h, parameters, recall(memory, point), [])
    elif ti.static(memory):
        return law.update(h, parameters, recall(memory, point))
    else:
        return law.update(h, parameters)


@ti.func
def shape_response(law: ti.template(), h, parameters, memory: ti.template(), point, pressure, change):
    """Return the result of a law without its volume part, for the pressure and volume change of the cell."""
    if ti.static(memory and law.plastic):
        return law.update(h, parameters, recall(memory, point), [pressure, change])
    else:
        without = [0.0] + [parameters[i] for i in range(1, len(parameters))]
        return plain_response(law, h, without, memory, point)


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


def memory_of(state, pack, points: int, size: int, width: int) -> PointMemory:
    """Return the state of the cells of a pack in `state` [packs, points, numbers, width]; nothing is stored."""
    return PointMemory(state, pack * (points * size * width), size, width, 0)


def takes_mean(kind: str, law: str) -> bool:
    """Return whether the stress of a kind of cell with a law is the mean of its points."""
    return bool(LAWS[law].state) and elements.FUNCTIONS[kind].points > 1


def mean_of_points(kind: str, law: str):
    """Return the function of a kind of cell for the mean of the Cauchy stress with a law that keeps a state."""
    functions, law_of = elements.FUNCTIONS[kind], LAWS[law]
    points, split = functions.points, functions.tangent == "mean-dilatation"

    @ti.func
    def pressure_of(x, u, parameters, memory: ti.template()):
        """Return U' and J - 1 of the cell; zeros where every point has its own."""
        if ti.static(not split):
            return [x[0][0] * 0.0 for _ in range(2)]
        else:
            change = mean_change(x, u)
            if ti.static(law_of.plastic):
                return [law_of.plastic.volume(change, parameters, mean_state(memory))[0], change]
            else:
                return [parameters[0] * change, change]

    @ti.func
    def response(h, parameters, memory: ti.template(), point, own: ti.template()):
        if ti.static(split):
            return shape_response(law_of, h, parameters, memory, point, own[0], own[1])
        else:
            return plain_response(law_of, h, parameters, memory, point)

    @ti.func
    def mean_of(x, u, parameters, memory: ti.template()):
        """Return the stress [component][component] of a cell; x[c][k], u[c][k]: its corners."""
        zero = x[0][0] * 0.0
        own = pressure_of(x, u, parameters, memory)
        volume = zero
        total = [[zero for _ in range(3)] for _ in range(3)]
        for point in range(points):
            there = functions.point_gradient(x, u, point)
            answer = response(there[0], parameters, memory, point, own)
            stress = cauchy(answer[0], there[0], answer[2])
            share = there[1] * (1.0 + answer[2])
            volume += share
            for i, j in ti.static(ti.ndrange(3, 3)):
                total[i][j] += share * stress[i][j]
        return tensor3.plus_identity(tensor3.scaled(1.0 / volume, total), own[0])

    return mean_of
