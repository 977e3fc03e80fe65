"""Numbers on the device that decide what the launches of a block of steps do, so that the host need not look.

The host offers steps and passes of the static solve; the device takes an offer if it is its turn. A step is taken where
the last solve has ended (WANTS = NOTHING), a pass where one goes on (A_PASS). A solve that needs more passes than one
step offers takes those of the next step, whose own launches then do nothing. A solve that did not converge (A_LOOK)
lets nothing more happen. A step with friction layers waits for them between its load and its kick (A_LAYER); where they
take two layer steps one after the other, the second one takes the launches of the next step. Where the host must build
the rows of pairs of bodies anew (A_ROWS), nothing happens before that. Behind these numbers stand the sums of the
boundary nodes and the numbers of the layers, a row for every step of the block.
"""

from ..engine import ti
from ..static.control import CONVERGED, MEASURE, NEXT, any_island

# what is next; steps taken in this block; 1: the next pass is the first one of its step; passes of this step so far
WANTS, TAKEN, FIRST, PASSES = 0, 1, 2, 3
# of sweeps that are launched one by one: 1 while a solve makes them; those of this pass; from MOST_SWEEPS on the most
# of the first pass of a step in this block, of the second one, and so on; the last number is that of all further ones
SOLVING, SWEPT, MOST_SWEEPS = 4, 5, 6
COUNTED_PASSES = 4
# from SOLVES on the solves of this block that took one pass, two passes, and so on; the last number is all longer ones
SOLVES = MOST_SWEEPS + COUNTED_PASSES
COUNTED_SOLVES = 8
DEVICE_CONTROL = SOLVES + COUNTED_SOLVES
NOTHING, A_PASS, A_LOOK, A_LAYER, A_ROWS = 0.0, 1.0, 2.0, 3.0, 4.0


@ti.func
def begin_counts(lists: ti.template()):
    """Count solves and sweeps from 0: a block of steps begins."""
    for i in ti.static(range(MOST_SWEEPS, DEVICE_CONTROL)):
        lists.control[i] = 0.0


@ti.func
def takes_step(lists: ti.template()):
    """Return 1 if the device takes the step that is offered, else 0."""
    return ti.select(lists.control[WANTS] == NOTHING, 1, 0)


@ti.func
def row_of(lists: ti.template(), offer):
    """Return the row of the step that is taken; offer: its number among those offered in this block."""
    return ti.select(offer == 0, 0, ti.cast(lists.control[TAKEN], ti.i32))


@ti.func
def want_pass(lists: ti.template()):
    """Ask for the passes of a static solve."""
    lists.control[WANTS] = A_PASS
    lists.control[FIRST] = 1.0
    lists.control[PASSES] = 0.0


@ti.func
def want_layers(lists: ti.template(), offer):
    """Ask for a step of the friction layers; offer: number of the step that waits for it."""
    lists.control[WANTS] = A_LAYER
    if offer == 0:
        lists.control[TAKEN] = 0.0
        begin_counts(lists)


@ti.func
def takes_pass(lists: ti.template()):
    """Return 1 if the device takes the pass that is offered, else 0."""
    own = lists.control[WANTS] == A_PASS and lists.control[SOLVING] == 0.0
    return ti.select(own, 1, 0)


@ti.func
def end_pass(lists: ti.template(), system: ti.template(), squeezed):
    """Note the end of a pass, and what follows; squeezed: 1 if a node is, which the host must see."""
    passes = lists.control[PASSES] + 1.0
    lists.control[FIRST] = 0.0
    lists.control[PASSES] = passes
    lists.control[SWEPT] = 0.0
    if any_island(system.stats, NEXT, MEASURE) == 0:
        lists.control[SOLVES + ti.min(ti.cast(passes, ti.i32), COUNTED_SOLVES) - 1] += 1.0
        failed = ti.max(any_island(system.stats, CONVERGED, 0.0), squeezed)
        lists.control[WANTS] = ti.select(failed == 1, A_LOOK, NOTHING)
