"""Raw rows: what a step measures, side by side, before the host makes a row of the history of it (columns.py).

Sums of the nodes and of the cells over all chunks, with the viscous ones if anything is viscous, then the whole of
`sums`.
"""

import taichi as ti

from ..columns import CELLS, NODE_SUMS, cell_groups, group_columns, group_size
from ..lanes import CHUNK_COUNT

START = {"sum": 0.0, "min": 1e300, "max": 0.0}
CELL_COMBINE = tuple(column.combine for column in group_columns("cells") for _ in range(column.size))


@ti.func
def over_chunks(sums: ti.template(), chunks, numbers, number, combine: ti.template(), start):
    """One number of all chunks together; numbers: of a chunk; combine: "sum", "min" or "max"."""
    total = start
    for chunk in range(chunks):
        value = sums[chunk * numbers + number]
        if ti.static(combine == "sum"):
            total += value
        elif ti.static(combine == "min"):
            total = ti.min(total, value)
        else:
            total = ti.max(total, value)
    return total


@ti.func
def log_row(
    raw: ti.template(), number, body: ti.template(), contact: ti.template(), viscous: ti.template(), cell_power
):
    """All sums of a row, side by side; cell_power [W]: of the viscosity of the contact cells."""
    place = number * row_width(contact, viscous)
    for j in ti.static(range(NODE_SUMS)):
        raw[place + j] = over_chunks(body.node_sums, body.node_sums.shape[0] // NODE_SUMS, NODE_SUMS, j, "sum", 0.0)
    place += NODE_SUMS
    numbers, chunks = ti.static(group_size(*cell_groups(viscous))), int(body.params[CHUNK_COUNT])
    for j, combine in ti.static(enumerate(CELL_COMBINE)):
        raw[place + j] = over_chunks(body.cell_sums, chunks, numbers, j, combine, START[combine])
    if ti.static(viscous or contact.options.viscous):
        power, fastest = cell_power, 0.0
        if ti.static(viscous):
            power = over_chunks(body.cell_sums, chunks, numbers, CELLS.viscous_power, "sum", cell_power)
            fastest = over_chunks(body.cell_sums, chunks, numbers, CELLS.viscous_rate, "max", 0.0)
        raw[place + CELLS.viscous_power], raw[place + CELLS.viscous_rate] = power, fastest
    place += ti.static(group_size(*cell_groups(viscous or contact.options.viscous)))
    for j in range(contact.sums.shape[0]):
        raw[place + j] = contact.sums[j]


@ti.func
def row_width(contact: ti.template(), viscous: ti.template()):
    """Numbers of a raw row."""
    return ti.static(NODE_SUMS + group_size(*cell_groups(viscous or contact.options.viscous))) + contact.sums.shape[0]
