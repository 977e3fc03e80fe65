"""Von Mises stress at the centre of every cell, for output.

    sigma = P F^t / J  (linear law: sigma = P),    s = sigma - tr(sigma)/3 I,    von Mises = sqrt(3/2 s:s)

with P of the law, for the mean state of the points of a law that has one, at the displacement gradient H of the cell
centre, in one-point hexes the mean one (elements/).
"""

import functools

from .. import elements
from ..engine import ti
from ..lanes import WIDTH
from ..language import tensor3
from ..language.arguments import ARRAY, INDEX
from ..language.bundles import Body
from ..language.compile_options import KEEP_VECTORS, LEAVE_TO_LLVM, compiled_with
from ..language.point_memory import PointMemory, recall
from ..materials import LAWS
from .cell_phase import gather


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
def equivalent(stress):
    """Return 3/2 s:s of a stress."""
    deviator = tensor3.plus_identity(stress, tensor3.trace(stress) * (0.0 - 1.0 / 3.0))
    return 1.5 * tensor3.dot(deviator, deviator)


@ti.func
def plain_response(law: ti.template(), h, parameters, memory: ti.template()):
    """Return the result of a law for the state of the cell; nothing is stored or added up."""
    if ti.static(memory and law.plastic):
        return law.update(h, parameters, recall(memory, 0), [])
    elif ti.static(memory):
        return law.update(h, parameters, recall(memory, 0))
    else:
        return law.update(h, parameters)


@functools.cache
def make_von_mises(kind: str, law: str):
    """Return the kernel of a kind of cell (`elements.FUNCTIONS`) with a law (`materials.LAWS`), memoised.

    von_mises(connectivity, position, parameters, u, state, stress_out): cells packed WIDTH wide as (pack, corner,
    lane); position, u [3n]; state [packs, numbers, width] of a law that has one; stress_out [packs * width] [Pa].
    """
    corners, gradient_of = elements.CORNERS[kind], elements.FUNCTIONS[kind].gradient
    width, law_of, size = WIDTH, LAWS[law], len(LAWS[law].state)
    count = len(law_of.parameters) + law_of.rates
    stress_of = small if LAWS[law].linear else cauchy

    @ti.kernel
    def von_mises(connectivity: INDEX, position: ARRAY, parameters: ARRAY, u: ARRAY, state: ARRAY, stress_out: ARRAY):
        body = ti.static(Body(u=u, connectivity=connectivity, position=position, params=parameters))
        for pack in range(connectivity.shape[0] // (corners * width)):
            start = pack * (corners * width)
            corner = [gather(body, start + k * width, width) for k in range(corners)]
            x = [[corner[k][c] for k in range(corners)] for c in range(3)]
            y = [[corner[k][3 + c] for k in range(corners)] for c in range(3)]
            h = gradient_of(x, y)
            memory = ti.static(PointMemory(state, pack * (size * width), size, width, 0) if size else None)
            answer = plain_response(law_of, h, [parameters[i] for i in range(count)], memory)
            square = equivalent(stress_of(answer[0], h, answer[2]))
            for lane in ti.static(range(width)):
                stress_out[pack * width + lane] = ti.sqrt(square[lane])

    return compiled_with(von_mises, **KEEP_VECTORS, **LEAVE_TO_LLVM)
