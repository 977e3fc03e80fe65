"""Von Mises stress of every cell, for output.

    sigma = P F^t / J  (linear law: sigma = P),    s = sigma - tr(sigma)/3 I,    von Mises = sqrt(3/2 s:s)

with P of the law at the displacement gradient H of the cell centre, in one-point hexes the mean one (elements/). Of a
law with a state sigma is the mean of the points of the cell (law_stress.py).
"""

import functools

from .. import elements
from ..engine import ti
from ..lanes import WIDTH
from ..language import tensor3
from ..language.arguments import ARRAY, INDEX
from ..language.bundles import Body
from ..language.compile_options import KEEP_VECTORS, LEAVE_TO_LLVM, compiled_with
from ..materials import LAWS
from .cell_phase import gather
from .law_stress import cauchy, mean_of_points, memory_of, plain_response, small, takes_mean


@ti.func
def equivalent(stress):
    """Return 3/2 s:s of a stress."""
    deviator = tensor3.plus_identity(stress, tensor3.trace(stress) * (0.0 - 1.0 / 3.0))
    return 1.5 * tensor3.dot(deviator, deviator)


@functools.cache
def make_von_mises(kind: str, law: str):
    """Return the kernel of a kind of cell (`elements.FUNCTIONS`) with a law (`materials.LAWS`), memoised.

    von_mises(connectivity, position, parameters, u, state, stress_out): cells packed WIDTH wide as (pack, corner,
    lane); position, u [3n]; state [packs, points, numbers, width] of a law that has one; stress_out [packs * width]
    [Pa].
    """
    functions = elements.FUNCTIONS[kind]
    corners, points, gradient_of = functions.corners, functions.points, functions.gradient
    width, law_of, size = WIDTH, LAWS[law], len(LAWS[law].state)
    of_points = takes_mean(kind, law)
    mean_of = mean_of_points(kind, law) if of_points else None
    count = len(law_of.parameters) + law_of.rates
    stress_of = small if LAWS[law].linear else cauchy

    @ti.func
    def stress_at(x, y, numbers, memory: ti.template()):
        if ti.static(of_points):
            return mean_of(x, y, numbers, memory)
        else:
            h = gradient_of(x, y)
            answer = plain_response(law_of, h, numbers, memory, 0)
            return stress_of(answer[0], h, answer[2])

    @ti.kernel
    def von_mises(connectivity: INDEX, position: ARRAY, parameters: ARRAY, u: ARRAY, state: ARRAY, stress_out: ARRAY):
        body = ti.static(Body(u=u, connectivity=connectivity, position=position, params=parameters))
        for pack in range(connectivity.shape[0] // (corners * width)):
            start = pack * (corners * width)
            corner = [gather(body, start + k * width, width) for k in range(corners)]
            x = [[corner[k][c] for k in range(corners)] for c in range(3)]
            y = [[corner[k][3 + c] for k in range(corners)] for c in range(3)]
            memory = ti.static(memory_of(state, pack, points, size, width) if size else None)
            square = equivalent(stress_at(x, y, [parameters[i] for i in range(count)], memory))
            for lane in ti.static(range(width)):
                stress_out[pack * width + lane] = ti.sqrt(square[lane])

    return compiled_with(von_mises, **KEEP_VECTORS, **LEAVE_TO_LLVM)
