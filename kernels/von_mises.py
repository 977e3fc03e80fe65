"""Von Mises stress at the centre of every cell, for frames and pictures.

    sigma = P F^t / J  (linear law: sigma = P),    s = sigma - tr(sigma)/3 I,    von Mises = sqrt(3/2 s:s)

with P of the law at the displacement gradient H of the cell centre, in one-point hexes at the mean gradient
(`reduced_hex`). At the centre of a hex the modes of the lines are 8 times the derivatives (`cells`).
"""

import functools

import taichi as ti

from . import laws, tensor3
from .arguments import ARRAY, INDEX
from .bundles import Body
from .cell_phase import gather
from .cells import geometry, hex_modes, tet_derivatives
from .compile_options import KEEP_VECTORS, compiled_with
from .lanes import WIDTHS
from .reduced_hex import mean_gradient


@ti.func
def hex_centre(x, u):
    """H at the centre of a hex8 from its corners x[c][k], u[c][k]."""
    mode_x, mode_u = [hex_modes(x[c]) for c in range(3)], [hex_modes(u[c]) for c in range(3)]
    shape = geometry([[mode_x[c][j] for j in range(3)] for c in range(3)])
    return tensor3.product_transposed([[mode_u[c][j] for j in range(3)] for c in range(3)], shape[1])


@ti.func
def hex_mean(x, u):
    """Mean H of a hex8 from its corners."""
    return mean_gradient([hex_modes(x[c]) for c in range(3)], [hex_modes(u[c]) for c in range(3)])[2]


@ti.func
def tet_centre(x, u):
    """H of a tet4 from its corners."""
    shape = geometry([tet_derivatives(x[c]) for c in range(3)])
    return tensor3.product_transposed([tet_derivatives(u[c]) for c in range(3)], shape[1])


GRADIENTS = {"hex8": (8, hex_centre), "hex8-reduced": (8, hex_mean), "tet4": (4, tet_centre)}


@ti.func
def cauchy(piola, h, change):
    """P F^t / J."""
    turned = tensor3.product_transposed(piola, tensor3.plus_identity(h, 1.0))
    return tensor3.scaled(1.0 / (1.0 + change), turned)


@ti.func
def small(piola, h, change):
    """The linear law knows one stress only."""
    return piola


@ti.func
def equivalent(stress):
    """3/2 s:s of a stress."""
    deviator = tensor3.plus_identity(stress, tensor3.trace(stress) * (0.0 - 1.0 / 3.0))
    return 1.5 * tensor3.dot(deviator, deviator)


@functools.cache
def make_von_mises(kind: str, law: str):
    """Kernel of a kind of gradient (`GRADIENTS`) with a law (`laws.LAWS`), memoised.

    von_mises(connectivity, position, moduli, u, stress_out): cells packed WIDTHS[kind] wide as (pack, corner, lane);
    position, u [3n]; stress_out [packs * width] [Pa].
    """
    corners, gradient_of = GRADIENTS[kind]
    width, law_of, count = WIDTHS[kind], laws.LAWS[law], laws.MODULI[law]
    stress_of = small if law.startswith("linear_elastic") else cauchy

    @ti.kernel
    def von_mises(connectivity: INDEX, position: ARRAY, moduli: ARRAY, u: ARRAY, stress_out: ARRAY):
        body = ti.static(Body(u=u, connectivity=connectivity, position=position, params=moduli))
        for pack in range(connectivity.shape[0] // (corners * width)):
            start = pack * (corners * width)
            corner = [gather(body, start + k * width, width) for k in range(corners)]
            x = [[corner[k][c] for k in range(corners)] for c in range(3)]
            y = [[corner[k][3 + c] for k in range(corners)] for c in range(3)]
            h = gradient_of(x, y)
            answer = law_of(h, [moduli[i] for i in range(count)])
            square = equivalent(stress_of(answer[0], h, answer[2]))
            for lane in ti.static(range(width)):
                stress_out[pack * width + lane] = ti.sqrt(square[lane])

    return compiled_with(von_mises, **KEEP_VECTORS)
