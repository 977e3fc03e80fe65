"""Sweeps of the static solve on a GPU by several blocks of threads, a launch for every colour (static/sweeps.py).

    decide        one block: whether a sweep follows, and how; extrapolation of an accelerated pair
    colour        one for every colour: its nodes

The host offers sweeps by what the last block of rows needed, some in one launch; those that are not needed do nothing,
and a pass that needs more goes on with those of the next one. After the sweeps of a pass:

    decide        as above
    longest       longest increment d
    move          x_K += B d
    conclude      one block: whether another pass follows
"""

import functools

from ..contact.islands import island_count
from ..engine import ti
from ..lanes import BLOCK_THREADS, DEVICE_BLOCK, SWEEPS_AT_ONCE
from ..language.bundles import ContactOptions
from ..language.compile_options import LEAVE_TO_LLVM, compiled_with
from ..language.signatures import Signature, kernel_of
from ..language.threads import leader, meet, over_blocks, put_sums
from ..static.control import DONE, STATS, TODO, goals
from ..static.solve import conclude
from ..static.sweeps import (
    clear,
    decide_sweep,
    extrapolate,
    longest_increment,
    move_by,
    note_sweep,
    note_sweeps,
    part_of_move,
    reversed_direction,
    started,
    sweep_colour,
)
from ..sweep_places import ACCELERATED, BACKWARD, FACTOR, OMEGA, RUNNING, STATE
from .device_control import A_PASS, COUNTED_PASSES, MOST_SWEEPS, PASSES, SOLVING, SWEPT, WANTS, end_pass, takes_pass

DUE = 2.0  # value of the state RUNNING before the first sweep, and where a pass has no more launches for the next one


@ti.func
def state_of(system: ti.template(), island):
    """Return the state [STATE] of the sweeps of an island."""
    return ti.Vector([system.sweep_state[island * STATE + i] for i in range(STATE)])


@ti.func
def keep_state(system: ti.template(), island, state: ti.template()):
    """Keep the state of the sweeps of an island."""
    for i in ti.static(range(STATE)):
        system.sweep_state[island * STATE + i] = state[i]


@ti.func
def solve_place(contact: ti.template(), number):
    """Return the place in `partial` of a number of the static solve, behind those of a row."""
    return contact.sums.shape[0] + island_count(contact) + 1 + number


@ti.func
def begin_island(contact: ti.template(), system: ti.template(), island):
    """Begin the sweeps of an island, if they are to do."""
    if system.stats[island * STATS + TODO] != DONE:
        clear(contact, system, island)
    if leader(contact) == 1:
        state = started(system, island)
        state[RUNNING] = ti.select(system.stats[island * STATS + TODO] != DONE, DUE, 0.0)
        keep_state(system, island, state)


@ti.func
def sweeps_now(lists: ti.template(), system: ti.template(), island):
    """Return 1 if a sweep of an island is being made, else 0."""
    own = lists.control[SOLVING] == 1.0 and system.sweep_state[island * STATE + RUNNING] == 1.0
    return ti.select(own, 1, 0)


def make_decide(blocks: int, colours: int, last: bool):
    """Return decide(lists, contact, system), a launch of one block.

    colours: the most that an island has; last: no sweep is launched after it in this pass.
    """

    @ti.func
    def decide(lists: ti.template(), contact: ti.template(), system: ti.template()):
        ti.loop_config(block_dim=BLOCK_THREADS)
        for _ in range(BLOCK_THREADS):
            if lists.control[WANTS] == A_PASS:
                running = 0
                for island in range(island_count(contact)):
                    state = state_of(system, island)
                    if state[RUNNING] == 1.0:
                        found = over_blocks(contact, solve_place(contact, island * colours), blocks, ("max",) * colours)
                        defect = 0.0
                        for c in ti.static(range(colours)):
                            defect = ti.max(defect, found[c])
                        turned = False
                        if state[ACCELERATED] == 1.0 and state[BACKWARD] == 1.0:
                            turned = reversed_direction(contact, system, island)
                        note_sweep(system, island, state, defect, turned)
                    meet(contact)
                    if state[RUNNING] > 0.0:
                        minimum, aim, accepted = goals(system.stats, system.settings, island)
                        decide_sweep(system, island, state, minimum, aim, accepted)
                        if state[RUNNING] == 1.0:
                            running = 1
                            if ti.static(last):
                                state[RUNNING] = DUE
                        if leader(contact) == 1:
                            keep_state(system, island, state)
                    if ti.static(not last):
                        if state[RUNNING] == 1.0 and state[ACCELERATED] == 1.0 and state[BACKWARD] == 0.0:
                            extrapolate(contact, system, island, state[FACTOR])
                if leader(contact) == 1:
                    lists.control[SOLVING] = 1.0 * running
                    if ti.static(not last):
                        swept = lists.control[SWEPT] + running
                        lists.control[SWEPT] = swept
                        place = MOST_SWEEPS + ti.min(ti.cast(lists.control[PASSES], ti.i32), COUNTED_PASSES - 1)
                        lists.control[place] = ti.max(lists.control[place], swept)

    return decide


@functools.cache
def make_device_sweep(signature: Signature, options: ContactOptions, blocks: int, colours: int):
    """Return the kernel of SWEEPS_AT_ONCE sweeps over all islands that need them, memoised.

    blocks: of threads; colours: the most that an island has.
    """
    decide = make_decide(blocks, colours, False)

    @ti.func
    def colour(number: ti.template(), lists: ti.template(), contact: ti.template(), system: ti.template()):
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(blocks * DEVICE_BLOCK):
            for island in range(island_count(contact)):
                if sweeps_now(lists, system, island) == 1:
                    team = ti.static(contact.at_place(blocks, t))
                    defect = 0.0
                    if number < system.colours[island + 1] - system.colours[island]:
                        omega = system.sweep_state[island * STATE + OMEGA]
                        backward = ti.cast(system.sweep_state[island * STATE + BACKWARD], ti.i32)
                        defect = sweep_colour(team, None, system, island, number, omega, backward)
                    put_sums(team, None, [solve_place(contact, island * colours + number)], [defect], ("max",))

    @ti.func
    def device_sweep(lists: ti.template(), contact: ti.template(), system: ti.template()):
        for _ in ti.static(range(SWEEPS_AT_ONCE)):
            decide(lists, contact, system)
            for number in ti.static(range(colours)):
                colour(number, lists, contact, system)

    return compiled_with(kernel_of(device_sweep, signature, options=options), **LEAVE_TO_LLVM)


@functools.cache
def make_device_end(signature: Signature, options: ContactOptions, blocks: int, colours: int):
    """Return the kernel that ends a pass whose sweeps have ended, memoised; the arguments are those above."""
    decide = make_decide(blocks, colours, True)

    @ti.func
    def longest(lists: ti.template(), contact: ti.template(), system: ti.template()):
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(blocks * DEVICE_BLOCK):
            if takes_pass(lists) == 1:
                team = ti.static(contact.at_place(blocks, t))
                for island in range(island_count(contact)):
                    if system.stats[island * STATS + TODO] != DONE:
                        length = longest_increment(team, system, island)
                        put_sums(team, None, [solve_place(contact, island)], [length], ("max",))

    @ti.func
    def move(body: ti.template(), lists: ti.template(), contact: ti.template(), system: ti.template()):
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(blocks * DEVICE_BLOCK):
            if takes_pass(lists) == 1:
                team = ti.static(contact.at_place(blocks, t))
                for island in range(island_count(contact)):
                    if system.stats[island * STATS + TODO] != DONE:
                        length = over_blocks(team, solve_place(contact, island), blocks, ("max",))[0]
                        move_by(body.u, team, system, island, part_of_move(system, island, length))

    @ti.func
    def close(lists: ti.template(), contact: ti.template(), system: ti.template()):
        ti.loop_config(block_dim=BLOCK_THREADS)
        for _ in range(BLOCK_THREADS):
            if takes_pass(lists) == 1:
                meet(contact)
                if leader(contact) == 1:
                    for island in range(island_count(contact)):
                        if system.stats[island * STATS + TODO] != DONE:
                            note_sweeps(system, island, state_of(system, island))
                        conclude(contact, system, island)
                    end_pass(lists, system, 0)

    @ti.func
    def device_end(body: ti.template(), lists: ti.template(), contact: ti.template(), system: ti.template()):
        decide(lists, contact, system)
        longest(lists, contact, system)
        move(body, lists, contact, system)
        close(lists, contact, system)

    return compiled_with(kernel_of(device_end, signature, options=options), **LEAVE_TO_LLVM)
