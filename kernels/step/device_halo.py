"""Forces of the boundary nodes that other ranks have copies of, between the GPU and the host, which has the messages.

    staged = (f_i of the shared nodes i, what is next on the device)        gather_shared
    f_i = sum over the ranks with a copy of node i                           scatter_shared

The host adds the parts of all ranks between the two (tcontact/device/exchange.py).
"""

from ..engine import ti
from ..lanes import MOST_THREADS
from ..language.arguments import ARRAY, INDEX
from ..language.threads import turns_of
from .device_control import WANTS


@ti.kernel
def gather_shared(force: ARRAY, rows: INDEX, control: ARRAY, first: ti.i32, staged: ARRAY):
    """Put the force of the boundary nodes `rows` into `staged`, behind them what is next; control: from `first` on."""
    for t in range(MOST_THREADS):
        count = rows.shape[0]
        if t == 0:
            staged[3 * count] = control[first + WANTS]
        for turn in range(turns_of(t, MOST_THREADS, count)):
            i = t + turn * MOST_THREADS
            for j in ti.static(range(3)):
                staged[3 * i + j] = force[3 * rows[i] + j]


@ti.kernel
def scatter_shared(force: ARRAY, rows: INDEX, staged: ARRAY):
    """Set the force of the boundary nodes `rows` to that in `staged`."""
    for t in range(MOST_THREADS):
        for turn in range(turns_of(t, MOST_THREADS, rows.shape[0])):
            i = t + turn * MOST_THREADS
            for j in ti.static(range(3)):
                force[3 * rows[i] + j] = staged[3 * i + j]
