"""Shape rates: how far the present shape of the cells of each block raises their largest frequency.

    rate = largest over the cells of  corners Lambda/(v V)   [1/m^2],   omega about wave speed sqrt(rate)

Lambda is the largest eigenvalue of the sum of b_k b_k^t (elements/cell_spread.py), v the present volume and V that at
rest. With an equation of state that stiffens (materials/mie_grueneisen.py) the rate grows with J U'' + 4/3 mu over
K + 4/3 mu. Each cell has two rates, at x + u and, to foresee the next one, at x + u + ahead (u - u_before). Cells of
linear laws, whose frequencies do not change, are left out.

With q = tr A/3, A/q - I = p S, tr S^2 = 6, the largest eigenvalue of A is q (1 + p (1 + y)), where y >= 0 is the root
of y^3 + 3 y^2 = 2 + det S; from y = sqrt((2 + det S)/3), which is too large, two Newton steps give it to 1e-4.

`rates`: [ahead, then for each chunk and block its rate now and its rate ahead].
"""

import functools
from typing import NamedTuple

from .. import elements
from ..elements.cell_spread import SPREADS
from ..engine import ti
from ..lanes import CHUNK_COUNT, CONNECTIVITY, END_PACK, FIRST_PACK, GRAIN, MATERIAL, SEGMENT, WIDTH
from ..language import tensor3
from ..language.arguments import Array
from ..language.compile_options import KEEP_VECTORS, LEAVE_TO_LLVM, compiled_with
from ..language.point_memory import constants_of
from ..language.signatures import Signature, kernel_of
from ..materials import LAWS
from .cell_phase import gather, gather_velocity

FLATTEST = 1e-9  # smallest ratio of volume to reference volume used here


class Shape(NamedTuple):
    """Array of the kernel besides those of the body: rates, as above."""

    rates: Array = None


@ti.func
def rate_of(spread, rest):
    """Return the rate of a cell from its spread and its volume at rest."""
    volume, vectors = spread[0], spread[1]
    a = [[vectors[0][i] * vectors[0][j] for j in range(3)] for i in range(3)]
    for m in ti.static(range(1, len(vectors))):
        for i, j in ti.static(ti.ndrange(3, 3)):
            a[i][j] += vectors[m][i] * vectors[m][j]
    q = (1.0 / 3.0) * tensor3.trace(a)
    s = tensor3.plus_identity(tensor3.scaled(1.0 / q, a), 0.0 * q - 1.0)
    square = (1.0 / 6.0) * tensor3.dot(s, s)
    p = ti.sqrt(square)
    det = tensor3.determinant(s, tensor3.cofactor(s)) / ti.max(square * p, 1e-30)
    w = ti.min(ti.max(2.0 + det, 0.0 * q), 0.0 * q + 4.0)
    y = ti.sqrt((1.0 / 3.0) * w)
    for _ in ti.static(range(2)):
        y = ti.max(y - (y * y * (y + 3.0) - w) / (3.0 * y * (y + 2.0) + 1e-30), 0.0 * q)
    return 0.5 * q * (4.0 + p * (1.0 + y)) / (ti.max(volume, FLATTEST * rest) * rest)


@ti.func
def stiffening(law: ti.template(), jacobian, parameters):
    """Return the modulus of plane waves at J over that at rest of a metal whose equation of state stiffens it."""
    change = ti.max(jacobian, FLATTEST) - 1.0
    slope = law.plastic.volume(change, parameters, [0.0 * change for _ in range(len(law.state))])[2]
    rest = law.modulus(parameters)
    return (rest + (1.0 + change) * slope - parameters[0]) / rest


def make_block_rates(kind: str, law: str):
    """Return block_rates(body, shape, place, first_material, size, first, end) for cells of a kind and law in a chunk.

    place: of the rates of block 0 in this chunk; first_material, size: place of the first material in `params`, and
    how many numbers each has, which tell the number of the block; first, end: segments.
    """
    corners, width = elements.CORNERS[kind], WIDTH
    spread_of, law_of = SPREADS[corners], LAWS[law]
    stiffens = law_of.plastic is not None and law_of.plastic.always

    @ti.func
    def block_rates(body: ti.template(), shape: ti.template(), place, first_material, size, first, end):
        ahead = shape.rates[0]
        for segment in range(first, end):
            at = segment * SEGMENT
            now_most = ti.Vector([0.0 for _ in range(width)])
            next_most = ti.Vector([0.0 for _ in range(width)])
            for pack in range(body.segments[at + FIRST_PACK], body.segments[at + END_PACK]):
                start = body.segments[at + CONNECTIVITY] + pack * (corners * width)
                corner = [gather(body, start + k * width, width) for k in range(corners)]
                before = [gather_velocity(body, start + k * width, width) for k in range(corners)]
                moved = [[ahead * (corner[k][3 + c] - before[k][c]) for k in range(corners)] for c in range(3)]
                rest = spread_of([[corner[k][c] for k in range(corners)] for c in range(3)])[0]
                for look in range(2):  # now, and ahead
                    y = [
                        [corner[k][c] + corner[k][3 + c] + look * moved[c][k] for k in range(corners)] for c in range(3)
                    ]
                    here = spread_of(y)
                    rate = rate_of(here, rest)
                    if ti.static(stiffens):
                        parameters = constants_of(body, body.segments[at + MATERIAL], law_of)
                        rate = rate * stiffening(law_of, here[0] / rest, parameters)
                    if look == 0:
                        now_most = ti.max(now_most, rate)
                    else:
                        next_most = ti.max(next_most, rate)
            own = place + 2 * ((body.segments[at + MATERIAL] - first_material) // size)
            shape.rates[own] = ti.max(shape.rates[own], now_most.max())
            shape.rates[own + 1] = ti.max(shape.rates[own + 1], next_most.max())

    return block_rates


@functools.cache
def make_shape_rates(kinds: tuple[tuple[str, str], ...], signature: Signature):
    """Return the kernel shape_rates(first_material, size, blocks, *arrays of a `bundles.Body` and a `Shape`), memoised.

    kinds: of cells (element, law); blocks: number of blocks; `rates` is 0 before, but for `ahead`. The displacement
    u_before takes the place of v.
    """
    count = len(kinds)
    functions, deforming = (
        [make_block_rates(kind, law) for kind, law in kinds],
        [not LAWS[law].linear for _, law in kinds],
    )

    @ti.func
    def shape_rates(first_material, size, blocks, body: ti.template(), shape: ti.template()):
        for s in range(int(body.params[CHUNK_COUNT]) * GRAIN):
            if s % GRAIN == 0:
                chunk = s // GRAIN
                table, place = chunk * (count + 3), 1 + 2 * blocks * chunk
                for i in ti.static(range(count)):
                    if ti.static(deforming[i]):
                        first, end = body.chunk_table[table + i], body.chunk_table[table + i + 1]
                        functions[i](body, shape, place, first_material, size, first, end)

    made = kernel_of(shape_rates, signature, ("first_material", "size", "blocks"))
    return compiled_with(made, **KEEP_VECTORS, **LEAVE_TO_LLVM)
