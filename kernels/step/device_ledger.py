"""Sums of a step over all threads of a GPU, by fixed trees: the same bits in whatever order the threads run.

In a step every thread stores one value of every number, `partial_sums` [number, thread]. One launch later FOLD of them
each are combined, value j with j + m, j + 2m, .. (m = threads/FOLD), which leaves m values in the ledger of the block:

    ledger = [row, number, m]    then [row, number, FOLD]    then [row, number]

The other two stages are taken for all rows of a block at once, when the host asks for them. Nothing waits for a sum
within a block, and nothing is added with atomics.
"""

import functools

from ..columns import NODE_SUMS, cell_groups, group_columns
from ..engine import ti
from ..lanes import DEVICE_BLOCK, DEVICE_ROWS, FOLD
from ..language.signatures import Signature, kernel_of
from ..language.threads import fold
from .raw_rows import START

NODE_COMBINE = ("sum",) * NODE_SUMS


def cell_combine(plastic: bool) -> tuple[str, ...]:
    """Return how each number of the cells is combined."""
    return tuple(column.combine for column in group_columns(*cell_groups(False, plastic)) for _ in range(column.size))


def ledger_places(threads: int, numbers: int) -> tuple[int, int, int]:
    """Return where the second and the third stage of the sums begin in `ledger`, and its size."""
    second = DEVICE_ROWS * numbers * (threads // FOLD)
    third = second + DEVICE_ROWS * numbers * FOLD
    return second, third, third + DEVICE_ROWS * numbers


@ti.func
def fold_partial_sums(
    lists: ti.template(), thread, row, first: ti.template(), combine: ti.template(), numbers: ti.template(),
    threads: ti.template(),
):  # fmt: skip
    """Take the first stage of some numbers of a row: those from `first` on, as many as `combine` has."""
    left = ti.static(threads // FOLD)
    number, j = thread // left, thread % left
    for own, how in ti.static(enumerate(combine)):
        if number == own:
            total = fold(lists.partial_sums, (first + own) * threads + j, left, FOLD, how)
            lists.ledger[(row * numbers + first + own) * left + j] = total


@functools.cache
def make_ledger(signature: Signature, plastic: bool, threads: int):
    """Return the kernel that completes the sums of a block of steps, memoised.

    ledger(rows, *arrays of a `bundles.DeviceLists`) leaves [rows, numbers], nodes then cells, in the third stage.
    """
    combine = NODE_COMBINE + cell_combine(plastic)
    numbers, left = len(combine), threads // FOLD
    second, third, _size = ledger_places(threads, numbers)
    stages = DEVICE_ROWS * numbers

    @ti.func
    def ledger(rows, lists: ti.template()):
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(threads):  # the sums over the nodes of the last row, which no step has taken
            fold_partial_sums(lists, t, rows - 1, 0, NODE_COMBINE, numbers, threads)
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(stages * FOLD):
            place, j = t // FOLD, t % FOLD
            if place < rows * numbers:
                for own, how in ti.static(enumerate(combine)):
                    if place % numbers == own:
                        lists.ledger[second + t] = fold(lists.ledger, place * left + j, FOLD, left // FOLD, how)
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for place in range(stages):
            if place < rows * numbers:
                for own, how in ti.static(enumerate(combine)):
                    if place % numbers == own:
                        lists.ledger[third + place] = fold(lists.ledger, second + place * FOLD, 1, FOLD, how)

    return kernel_of(ledger, signature, ("rows",))


def starts(combine: tuple[str, ...]) -> tuple[float, ...]:
    """Return the values with which a thread starts."""
    return tuple(START[how] for how in combine)
