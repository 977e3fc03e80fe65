"""Shape rates on a GPU: those of shape_rate.py with a thread per cell, over the parts of device_step.py.

The largest rate of a block is found with atomic maxima, whose order does not matter; a thread asks for one only where
its own cells exceed what stands there.
"""

import functools

from .. import elements
from ..elements.cell_spread import SPREADS
from ..engine import ti
from ..lanes import (
    DEVICE_BLOCK,
    END_LANE,
    FIRST_LANE,
    PART,
    PART_CELLS,
    PART_CONNECTIVITY,
    PART_MATERIAL,
    WIDTH,
)
from ..language.compile_options import LEAVE_TO_LLVM, compiled_with
from ..language.point_memory import constants_of
from ..language.signatures import Signature, kernel_of
from ..language.threads import turns_of
from ..materials import LAWS
from .shape_rate import rate_of, stiffening


def make_cell_rates(kind: str, law: str):
    """Return cell_rates(body, shape, lists, at, cell) -> rates of a cell of a kind and law now and ahead.

    at: its part in `lists.parts`; cell: its number there.
    """
    corners, law_of = elements.CORNERS[kind], LAWS[law]
    spread_of, stiffens = SPREADS[corners], law_of.plastic is not None and law_of.plastic.always

    @ti.func
    def cell_rates(body: ti.template(), shape: ti.template(), lists: ti.template(), at, cell):
        start = lists.parts[at + PART_CONNECTIVITY] + (cell // WIDTH) * (corners * WIDTH) + cell % WIDTH
        node = [3 * body.connectivity[start + k * WIDTH] for k in range(corners)]
        x = [[body.position[i + c] for i in node] for c in range(3)]
        u = [[body.u[i + c] for i in node] for c in range(3)]
        before = [[body.v[i + c] for i in node] for c in range(3)]
        rest = spread_of(x)[0]
        rates = [0.0, 0.0]
        for look in range(2):  # now, and ahead
            further = look * shape.rates[0]
            y = [[x[c][k] + u[c][k] + further * (u[c][k] - before[c][k]) for k in range(corners)] for c in range(3)]
            here = spread_of(y)
            rate = rate_of(here, rest)
            if ti.static(stiffens):
                parameters = constants_of(body, lists.parts[at + PART_MATERIAL], law_of)
                rate *= stiffening(law_of, here[0] / rest, parameters)
            if look == 0:
                rates[0] = rate
            else:
                rates[1] = rate
        return rates

    return cell_rates


@functools.cache
def make_device_shape_rates(kinds: tuple[tuple[str, str], ...], signature: Signature, threads: int):
    """Return the kernel of `shape_rate.make_shape_rates` for arrays with `DeviceLists` and one chunk, memoised.

    threads: of each loop, of which each takes cells at the distance of this number.
    """
    head = len(kinds) + 1
    cells = [make_cell_rates(kind, law) for kind, law in kinds]
    deforming = [not LAWS[law].linear for _, law in kinds]

    @ti.func
    def put_maximum(shape: ti.template(), place, rates):
        for look in ti.static(range(2)):
            if rates[look] > shape.rates[place + look]:
                ti.atomic_max(shape.rates[place + look], rates[look])

    @ti.func
    def kind_loop(
        i: ti.template(), first_material: ti.template(), size: ti.template(), body: ti.template(),
        lists: ti.template(), shape: ti.template(),
    ):  # fmt: skip
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(threads):
            at = head + PART * lists.parts[i]
            end = lists.parts[head + PART * (lists.parts[i + 1] - 1) + END_LANE]
            most = [0.0, 0.0]
            for turn in range(turns_of(t, threads, end)):
                lane = t + turn * threads
                while lane >= lists.parts[at + END_LANE]:
                    put_maximum(shape, 1 + 2 * ((lists.parts[at + PART_MATERIAL] - first_material) // size), most)
                    most[0], most[1] = 0.0, 0.0
                    at += PART
                cell = lane - lists.parts[at + FIRST_LANE]
                if cell < lists.parts[at + PART_CELLS]:
                    rates = cells[i](body, shape, lists, at, cell)
                    for look in ti.static(range(2)):
                        most[look] = ti.max(most[look], rates[look])
            put_maximum(shape, 1 + 2 * ((lists.parts[at + PART_MATERIAL] - first_material) // size), most)

    @ti.func
    def shape_rates(
        first_material: ti.template(), size: ti.template(), blocks: ti.template(), body: ti.template(),
        lists: ti.template(), shape: ti.template(),
    ):  # fmt: skip
        for i in ti.static(range(len(kinds))):
            if ti.static(deforming[i]):
                kind_loop(i, first_material, size, body, lists, shape)

    made = kernel_of(shape_rates, signature, ("first_material", "size", "blocks"))
    return compiled_with(made, **LEAVE_TO_LLVM)
