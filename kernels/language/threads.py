"""Loops that the threads of one block share, and values combined over these threads by a fixed tree.

    for turn in range(turns(contact, count)):
        i = item(contact, turn)

`contact.options.threads` = n threads take items t, t + n, t + 2 n, ... of thread t. With one thread, as on the CPU, the
loop is an ordinary one, and nothing of this is left when it is compiled. `meet` lets all threads wait for each other:
it stands behind every loop whose results other threads read. What a single thread stores is stored by the `leader`.

All threads have to call `meet` and `over_threads`, which return the same in each of them: conditions round these calls
depend on such values, or on what the leader has stored before the threads met.
"""

from ..engine import ti
from ..lanes import BLOCK_NUMBERS, BLOCK_THREADS, GROUPS


@ti.func
def turns(contact: ti.template(), count):
    """Return how many of `count` items this thread takes."""
    own = count
    if ti.static(contact.options.threads > 1):
        own = (count - thread() + ti.static(contact.options.threads - 1)) // ti.static(contact.options.threads)
    return own


@ti.func
def item(contact: ti.template(), turn):
    """Return the number of the item that this thread takes in a turn."""
    own = turn
    if ti.static(contact.options.threads > 1):
        own = thread() + turn * ti.static(contact.options.threads)
    return own


@ti.func
def leader(contact: ti.template()):
    """Return 1 for the thread that stores what is stored once, else 0."""
    leads = 1
    if ti.static(contact.options.threads > 1):
        leads = ti.select(thread() == 0, 1, 0)
    return leads


@ti.func
def meet(contact: ti.template()):
    """Let the threads of the block wait for each other."""
    if ti.static(contact.options.threads > 1):
        ti.simt.block.sync()


@ti.func
def thread():
    """Return the number of this thread; there is one block."""
    return ti.cast(ti.simt.block.global_thread_idx(), ti.i32)  # without the cast it compares with no number


@ti.func
def over_threads(contact: ti.template(), values, combine: ti.template()):
    """Return each of a list of values combined over the threads: "sum", "min" or "max", at most BLOCK_NUMBERS.

    The threads store their values; GROUPS threads for each number combine those of threads j, j + GROUPS, ...; then
    every thread combines these. `contact.shared` has room for both stages.
    """
    result = [values[k] for k in range(len(combine))]
    if ti.static(contact.options.threads > 1):
        t, first = thread(), ti.static(BLOCK_NUMBERS * BLOCK_THREADS)
        for k in ti.static(range(len(combine))):
            contact.shared[k * BLOCK_THREADS + t] = values[k]
        meet(contact)
        for k, how in ti.static(enumerate(combine)):
            if t // GROUPS == k:
                start = k * BLOCK_THREADS + t % GROUPS
                contact.shared[first + t] = fold(contact.shared, start, GROUPS, BLOCK_THREADS // GROUPS, how)
        meet(contact)
        for k, how in ti.static(enumerate(combine)):
            result[k] = fold(contact.shared, first + k * GROUPS, 1, GROUPS, how)
    return result


@ti.func
def largest_of(contact: ti.template(), value):
    """Return the largest value of all threads."""
    return over_threads(contact, [value], ("max",))[0]


@ti.func
def smallest_of(contact: ti.template(), value):
    """Return the smallest value of all threads."""
    return over_threads(contact, [value], ("min",))[0]


@ti.func
def sum_of(contact: ti.template(), value):
    """Return the sum of the values of all threads."""
    return over_threads(contact, [value], ("sum",))[0]


@ti.func
def combined(a, b, combine: ti.template()):
    """Return two values combined: "sum", "min" or "max"."""
    if ti.static(combine == "sum"):
        return a + b
    elif ti.static(combine == "min"):
        return ti.min(a, b)
    else:
        return ti.max(a, b)


@ti.func
def fold(values: ti.template(), first, stride, count, combine: ti.template()):
    """Return `count` values combined, from place `first` on, `stride` apart."""
    total = values[first]
    for i in range(1, count):
        total = combined(total, values[first + i * stride], combine)
    return total
