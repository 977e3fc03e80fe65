"""Loops that threads share, and values combined over these threads by a fixed tree.

    for turn in range(turns(contact, count)):
        i = item(contact, turn)

`contact.options.threads` = n threads take items t, t + n, t + 2 n, ... of thread t. With one thread, as on the CPU, the
loop is an ordinary one, and nothing of this is left when it is compiled. `meet` lets all threads wait for each other:
it stands behind every loop whose results other threads read. What a single thread stores is stored by the `leader`.

All threads have to call `meet` and `over_threads`, which return the same in each of them: conditions round these calls
depend on such values, or on what the leader has stored before the threads met.

Threads of several blocks (`options.blocks`, `at_place`) cannot wait for each other: `meet` does nothing, a thread reads
what another one has stored in a later launch, and the items of one number belong to one thread. `put_sums` leaves the
values of every block, which a later launch of one block combines (`over_blocks`, `folded`). Of a part of the items,
such as the nodes of an island, each thread takes those that it takes of all (`turns_between`, `item_between`).
"""

from ..engine import ti
from ..lanes import BLOCK_NUMBERS


@ti.func
def turns_of(t, threads: ti.template(), count):
    """Return how many of `count` items thread t of so many takes: items t, t + threads, t + 2 threads, ..."""
    return (count - t + ti.static(threads - 1)) // threads


@ti.func
def turns(contact: ti.template(), count):
    """Return how many of `count` items this thread takes."""
    own = count
    if ti.static(contact.options.threads > 1):
        own = turns_of(thread(contact), ti.static(contact.options.threads), count)
    return own


@ti.func
def item(contact: ti.template(), turn):
    """Return the number of the item that this thread takes in a turn."""
    own = turn
    if ti.static(contact.options.threads > 1):
        own = thread(contact) + turn * ti.static(contact.options.threads)
    return own


@ti.func
def turns_between(contact: ti.template(), begin, end):
    """Return how many of the items begin .. end this thread takes."""
    own = 0
    if ti.static(contact.options.blocks > 1):
        own = ti.max(0, turns(contact, end) - turns(contact, begin))
    else:
        own = turns(contact, end - begin)
    return own


@ti.func
def item_between(contact: ti.template(), begin, turn):
    """Return the number of the item from `begin` on that this thread takes in a turn."""
    own = 0
    if ti.static(contact.options.blocks > 1):
        own = item(contact, turns(contact, begin) + turn)
    else:
        own = begin + item(contact, turn)
    return own


@ti.func
def leader(contact: ti.template()):
    """Return 1 for the thread that stores what is stored once, else 0."""
    leads = 1
    if ti.static(contact.options.threads > 1):
        leads = ti.select(thread(contact) == 0, 1, 0)
    return leads


@ti.func
def meet(contact: ti.template()):
    """Let the threads of the one block wait for each other."""
    if ti.static(contact.options.threads > 1 and contact.options.blocks == 1):
        ti.simt.block.sync()


@ti.func
def thread(contact: ti.template()):
    """Return the number of this thread."""
    if ti.static(contact.placed):
        return contact.place
    else:
        return ti.cast(ti.simt.block.global_thread_idx(), ti.i32)  # without the cast it compares with no number


@ti.func
def over_threads(contact: ti.template(), values, combine: ti.template()):
    """Return each of a list of values combined over the threads: "sum", "min" or "max", at most BLOCK_NUMBERS."""
    ti.static_assert(contact.options.blocks == 1, "several blocks of threads have no common value within a launch")
    result = [values[k] for k in range(len(combine))]
    if ti.static(contact.options.threads > 1):
        found = over_block(contact, values, combine)
        for k in ti.static(range(len(combine))):
            result[k] = found[k]
    return result


@ti.func
def over_block(contact: ti.template(), values, combine: ti.template()):
    """Return each of a list of values combined over the threads of this block, of which there is one or several.

    The threads store their values; a group of threads for each number combines those of threads j, j + groups, ...;
    then every thread combines these. `contact.shared` has room for both stages, of every block.
    """
    groups = ti.static(contact.options.groups)
    first = fold_in_groups(contact, values, combine)
    result = [values[k] for k in range(len(combine))]
    for k, how in ti.static(enumerate(combine)):
        result[k] = fold(contact.shared, first + k * groups, 1, groups, how)
    return result


@ti.func
def fold_in_groups(contact: ti.template(), values, combine: ti.template()):
    """Take the first two stages of `over_block`; return where the values of the groups begin in `shared`."""
    threads, groups = ti.static(contact.options.block_threads, contact.options.groups)
    t, first = thread(contact), 0
    if ti.static(contact.options.blocks > 1):
        first = t // threads * ti.static(BLOCK_NUMBERS * (threads + groups))
        t = t % threads
    second = first + ti.static(BLOCK_NUMBERS * threads)
    for k in ti.static(range(len(combine))):
        contact.shared[first + k * threads + t] = values[k]
    ti.simt.block.sync()
    for k, how in ti.static(enumerate(combine)):
        if t // groups == k:
            start = first + k * threads + t % groups
            contact.shared[second + t] = fold(contact.shared, start, groups, threads // groups, how)
    ti.simt.block.sync()
    return second


@ti.func
def put_sums(
    contact: ti.template(), sums: ti.template(), places: ti.template(), values: ti.template(), combine: ti.template()
):  # fmt: skip
    """Set sums[places[k]] to values combined over the threads; of several blocks it sets partial[places[k], block]."""
    if ti.static(contact.options.blocks > 1):
        groups = ti.static(contact.options.groups)
        first = fold_in_groups(contact, values, combine)
        if thread(contact) % ti.static(contact.options.block_threads) == 0:
            for k, how in ti.static(enumerate(combine)):
                total = fold(contact.shared, first + k * groups, 1, groups, how)
                contact.partial[partial_place(contact, places[k])] = total
    else:
        totals = over_threads(contact, values, combine)
        for k in ti.static(range(len(combine))):
            sums[places[k]] = totals[k]


@ti.func
def so_far(contact: ti.template(), sums: ti.template(), place):
    """Return for one thread of every block what `put_sums` has left at a place before, 0 for the others."""
    found = 0.0
    if ti.static(contact.options.blocks > 1):
        if thread(contact) % ti.static(contact.options.block_threads) == 0:
            found = contact.partial[partial_place(contact, place)]
    else:
        found = ti.select(leader(contact) == 1, sums[place], 0.0)
    return found


@ti.func
def partial_place(contact: ti.template(), number):
    """Return the place in `partial` of a number of the block of this thread."""
    block = thread(contact) // ti.static(contact.options.block_threads)
    return number * ti.static(contact.options.blocks) + block


@ti.func
def over_blocks(contact: ti.template(), first, blocks: ti.template(), combine: ti.template()):
    """Return numbers first, first + 1, ... of `partial` combined, by the threads of one block; at most as many blocks.

    Several blocks each do the same. A number that no block has set must not be asked for.
    """
    t = thread(contact) % ti.static(contact.options.block_threads)
    values = [0.0 for _ in range(len(combine))]
    for k, how in ti.static(enumerate(combine)):
        own = contact.partial[(first + k) * blocks + ti.min(t, blocks - 1)]
        values[k] = ti.select(t < blocks, own, 0.0) if ti.static(how == "sum") else own
    return over_block(contact, values, combine)


@ti.func
def folded(contact: ti.template(), number, blocks: ti.template(), combine: ti.template()):
    """Return a number of `partial` combined by one thread."""
    return fold(contact.partial, number * blocks, 1, blocks, combine)


@ti.func
def largest_of(contact: ti.template(), value):
    """Return the largest value of all threads."""
    return over_threads(contact, [value], ("max",))[0]


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
