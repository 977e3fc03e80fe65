"""The explicit step on a GPU: one launch over the cells of every kind, a thread per cell, one over the nodes.

    f_i = dW/du_i,   a = g - f/m,   v_n = v + kick_before a,   v <- v_n + kick_after a,   u <- u + drift v

(METHOD 2, as in internal_force.py.) The item of each loop is a function of one cell (cells/device_cells.py) or of one
node (nodes/device_nodes.py). A loop has a fixed number of threads, known at compile time, of which each takes items at
the distance of this number: a loop of a length known only at run time costs a further launch. The sums of a step are
completed later (device_ledger.py), and what changes from step to step is an argument: within a block of rows the host
only launches. Results do not depend on the order in which threads run.
"""

import functools

from ..cells.device_cells import CELL_NUMBERS, FLOW_NUMBERS, make_device_cell
from ..columns import NODE_SUMS, cell_groups, group_columns
from ..engine import ti
from ..lanes import CHUNK_BITS, DEVICE_BLOCK, END_LANE, FIRST_LANE, PART, PART_CELLS
from ..language.compile_options import LEAVE_TO_LLVM, compiled_with
from ..language.signatures import Signature, kernel_of
from ..language.threads import combined, turns_of
from ..materials import LAWS
from ..nodes.device_nodes import moved_node, node_force, step_numbers
from .device_control import row_of, takes_step
from .device_ledger import NODE_COMBINE, cell_combine, fold_partial_sums, starts

STEPS = ("before", "kick_before", "kick_after", "drift", "gravity_x", "gravity_y", "gravity_z")


def make_loops(kinds: tuple[tuple[str, str], ...], threads: int, damped: str, bounded: bool, pulled: bool = False):
    """Return cell_loop(i, row, commit, before, body, lists), over the cells of kind i, and node_loop(row, steps, body,
    lists), as functions of a kernel.

    bounded: there are boundary nodes, whose force is stored in special_force; row is then the number of a step that is
    offered (device_control.py); pulled: gravity is a function of time. The other arguments: see `make_device_step`.
    """
    cells = [make_device_cell(kind, law) for kind, law in kinds]
    flowing = [LAWS[law].plastic is not None for _, law in kinds]
    limiting = [not LAWS[law].linear for _, law in kinds]
    judged = limiting if any(limiting) else [True] * len(kinds)
    columns = [column.name for column in group_columns(*cell_groups(False, any(flowing)))]
    combine = cell_combine(any(flowing))
    begin, numbers, head = starts(combine), NODE_SUMS + len(combine), len(kinds) + 1
    # of each kind of cells the numbers of a cell that enter, and where they stand in the row
    names = [CELL_NUMBERS + (FLOW_NUMBERS if flows else ()) for flows in flowing]
    entering = [
        [(k, columns.index(name)) for k, name in enumerate(own) if judges or name != "jacobian_min"]
        for own, judges in zip(names, judged)
    ]

    @ti.func
    def cells_of_thread(
        i: ti.template(), t, row, commit: ti.template(), before: ti.template(), body: ti.template(),
        lists: ti.template(),
    ):  # fmt: skip
        if ti.static(i == 0):
            if row > 0:
                fold_partial_sums(lists, t, row - 1, 0, NODE_COMBINE, numbers, threads)
        at = head + PART * lists.parts[i]
        end = lists.parts[head + PART * (lists.parts[i + 1] - 1) + END_LANE]
        sums = [begin[k] for k in range(len(begin))]
        if ti.static(i > 0):
            for k in ti.static(range(len(begin))):
                sums[k] = lists.partial_sums[(NODE_SUMS + k) * threads + t]
        for turn in range(turns_of(t, threads, end)):
            lane = t + turn * threads
            while lane >= lists.parts[at + END_LANE]:
                at += PART
            cell = lane - lists.parts[at + FIRST_LANE]
            if cell < lists.parts[at + PART_CELLS]:
                answer = cells[i](body, lists, at, cell, before, commit)
                for k, place in ti.static(entering[i]):
                    value = answer[k]
                    if ti.static(columns[place] == "jacobian_min"):
                        value += 1.0
                    sums[place] = combined(sums[place], value, combine[place])
        for k in ti.static(range(len(begin))):
            lists.partial_sums[(NODE_SUMS + k) * threads + t] = sums[k]

    @ti.func
    def nodes_of_thread(t, row, steps: ti.template(), body: ti.template(), lists: ti.template()):
        fold_partial_sums(lists, t, row, NODE_SUMS, combine, numbers, threads)
        numbers_of_step = step_numbers(body, steps, pulled)
        sums = [0.0 for _ in range(NODE_SUMS)]
        for turn in range(turns_of(t, threads, body.mass.shape[0])):
            node = t + turn * threads
            force = node_force(lists, node)
            place = 0  # of a boundary node, from 1 on
            if ti.static(bounded):
                place = body.node_info[node] >> (2 * CHUNK_BITS)
            if place > 0:
                if ti.static(bounded):
                    for d in ti.static(range(3)):
                        body.special_force[3 * (place - 1) + d] = force[d]
            else:
                moved = moved_node(body, node, force, numbers_of_step, damped)
                for k in ti.static(range(NODE_SUMS)):
                    sums[k] += moved[k]
        for k in ti.static(range(NODE_SUMS)):
            lists.partial_sums[k * threads + t] = sums[k]

    @ti.func
    def cell_loop(
        i: ti.template(), row: ti.template(), commit: ti.template(), before: ti.template(), body: ti.template(),
        lists: ti.template(),
    ):  # fmt: skip
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(threads):
            if ti.static(bounded):
                if takes_step(lists) == 1:
                    cells_of_thread(i, t, row_of(lists, row), commit, before, body, lists)
            else:
                cells_of_thread(i, t, row, commit, before, body, lists)

    @ti.func
    def node_loop(row: ti.template(), steps: ti.template(), body: ti.template(), lists: ti.template()):
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(threads):
            if ti.static(bounded):
                if takes_step(lists) == 1:
                    nodes_of_thread(t, row_of(lists, row), steps, body, lists)
            else:
                nodes_of_thread(t, row, steps, body, lists)

    return cell_loop, node_loop


@functools.cache
def make_device_step(
    kinds: tuple[tuple[str, str], ...], signature: Signature, threads: int, damped: str = ""
):  # fmt: skip
    """Return the step kernel of a GPU for kinds of cells (element, law), memoised.

    step(row, commit, *STEPS, *arrays of a `bundles.Body` and a `DeviceLists`): row: number of the row in its block;
    commit: 1 if points store their new state; before [s]: the step that ends at the present state; then as above.
    threads: of each loop; damped: name of the damping law (damping.py). All nodes are ordinary ones.
    """
    cell_loop, node_loop = make_loops(kinds, threads, damped, False)

    # arguments of the kernel are passed on as they are: a copy of one would be made by a launch of its own
    @ti.func
    def device_step(
        row: ti.template(), commit: ti.template(), before: ti.template(), kick_before: ti.template(),
        kick_after: ti.template(), drift: ti.template(), g0: ti.template(), g1: ti.template(), g2: ti.template(),
        body: ti.template(), lists: ti.template(),
    ):  # fmt: skip
        for i in ti.static(range(len(kinds))):
            cell_loop(i, row, commit, before, body, lists)
        node_loop(row, ti.static([kick_before, kick_after, drift, g0, g1, g2]), body, lists)

    return compiled_with(kernel_of(device_step, signature, ("row", "commit"), STEPS), **LEAVE_TO_LLVM)
