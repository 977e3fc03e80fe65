"""Numbers of the threads of a launch combined by a fixed tree: those of every thread, of FOLDERS threads, of one.

They stand in `partial` [number, thread]; the order of the sums is always the same, whatever the device.
"""

from ..engine import ti
from ..lanes import DEVICE_BLOCK
from ..language.arguments import ARRAY
from ..language.threads import fold

FOLDERS = 256  # threads of the second stage


@ti.func
def fold_threads(partial: ti.template(), t, combine: ti.template(), threads: ti.template()):
    """Combine the values of every FOLDERS-th of `threads` threads into those of thread t, "sum", "min" or "max"."""
    for k in ti.static(range(len(combine))):
        partial[k * threads + t] = fold(partial, k * threads + t, FOLDERS, threads // FOLDERS, combine[k])


def make_fold(threads: int, combine: tuple[str, ...]):
    """Return fold_numbers(partial, numbers, place), which completes the numbers from `place` on; combine: of each."""

    @ti.kernel
    def fold_numbers(partial: ARRAY, numbers: ARRAY, place: ti.i32):
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(FOLDERS):
            fold_threads(partial, t, combine, threads)
        for _ in range(1):
            for k in ti.static(range(len(combine))):
                numbers[place + k] = fold(partial, k * threads, 1, FOLDERS, combine[k])

    return fold_numbers
