"""The passes before the force pass of cells whose volume change is averaged at nodes: changes, then averages.

    w_e V_e (J_e - 1) of the cells (over packs)   ->   th_a of the volume nodes (over the cells round each)

A measure of the static solve, in which only contact nodes move, takes the changes of the contact cells and the averages
of their corners, the "ring".
"""

import functools

from .. import elements
from ..engine import ti
from ..lanes import CONNECTIVITY, END_PACK, FIRST_PACK, LANE, SEGMENT, WIDTH
from ..language.vectors import load, store
from ..materials import LAWS
from ..volume_places import COUNT, RING_COUNT, SHARES
from .cell_phase import gather
from .node_averages import average, place


def volume_of(kind: str, law: str):
    """Return the function of the volume change of a kind of cell with a law; None if it is not averaged."""
    functions = elements.FUNCTIONS[kind]
    return (LAWS[law].linear and functions.linear_volume) or functions.volume


def make_block_changes(kind: str, law: str):
    """Return block_changes(body, first, end): it stores the changes of the cells in segments first .. end."""
    corners, width, change_of = elements.CORNERS[kind], WIDTH, volume_of(kind, law)

    @ti.func
    def block_changes(body: ti.template(), first, end):
        shares = place(body, SHARES)
        for segment in range(first, end):
            at = segment * SEGMENT
            for pack in range(body.segments[at + FIRST_PACK], body.segments[at + END_PACK]):
                start = body.segments[at + CONNECTIVITY] + pack * (corners * width)
                corner = [gather(body, start + k * width, width) for k in range(corners)]
                x = [[corner[k][c] for k in range(corners)] for c in range(3)]
                u = [[corner[k][3 + c] for k in range(corners)] for c in range(3)]
                lane = body.segments[at + LANE] + pack * width
                store(body.volumes, lane, load(body.volumes, shares + lane, width) * change_of(x, u), width)

    return block_changes


@functools.cache
def make_volume_phase(kinds: tuple[tuple[str, str], ...]):
    """Return volume_phase(first, end, body, stride, whole): changes of the cells in chunks first .. end, then averages.

    kinds, stride: as in cell_phase.py; whole: 1 for the averages of all volume nodes, 0 for those of the ring.
    """
    phases = {i: make_block_changes(*kind) for i, kind in enumerate(kinds) if volume_of(*kind)}
    count = len(kinds)

    @ti.func
    def volume_phase(first, end, body: ti.template(), stride: ti.template(), whole):
        for s in range((end - first) * stride):
            if s % stride == 0:
                table = (first + s // stride) * (count + 3)
                for i in ti.static(tuple(phases)):
                    phases[i](body, body.chunk_table[table + i], body.chunk_table[table + i + 1])
        for s in range((end - first) * stride):
            if s % stride == 0:
                part, parts = s // stride, end - first
                nodes = ti.select(whole == 1, place(body, COUNT), place(body, RING_COUNT))
                for i in range(part * nodes // parts, (part + 1) * nodes // parts):
                    average(body, i)

    return volume_phase
