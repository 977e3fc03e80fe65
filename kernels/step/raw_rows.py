"""Raw rows: the numbers that a step measures, from which the host computes a row of the history (columns.py).

A row holds the sums over the nodes, those over the cells (with viscosity also the viscous ones, with metals the plastic
ones), then all of `sums`.
"""

from ..columns import CELLS, NODE_SUMS, cell_groups, group_columns, group_size
from ..engine import ti
from ..lanes import CHUNK_COUNT

START = {"sum": 0.0, "min": 1e300, "max": 0.0}
CELL_COMBINE = tuple(column.combine for column in group_columns("cells") for _ in range(column.size))
FLOW_COMBINE = tuple(column.combine for column in group_columns("plastic") for _ in range(column.size))


@ti.func
def over_chunks(sums: ti.template(), chunks, numbers, number, combine: ti.template(), start):
    """Return a number combined over all chunks; numbers: count per chunk; combine: "sum", "min" or "max"."""
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
    raw: ti.template(), number, body: ti.template(), contact: ti.template(), viscous: ti.template(), cell_power,
    plastic: ti.template(),
):  # fmt: skip
    """Write raw row `number`; cell_power [W]: power dissipated by the viscosity of the contact cells."""
    place = number * row_width(contact, viscous, plastic)
    for j in ti.static(range(NODE_SUMS)):
        raw[place + j] = over_chunks(body.node_sums, body.node_sums.shape[0] // NODE_SUMS, NODE_SUMS, j, "sum", 0.0)
    place += NODE_SUMS
    numbers, chunks = ti.static(group_size(*cell_groups(viscous, plastic))), int(body.params[CHUNK_COUNT])
    for j, combine in ti.static(enumerate(CELL_COMBINE)):
        raw[place + j] = over_chunks(body.cell_sums, chunks, numbers, j, combine, START[combine])
    if ti.static(viscous or contact.options.viscous):
        power, fastest = cell_power, 0.0
        if ti.static(viscous):
            power = over_chunks(body.cell_sums, chunks, numbers, CELLS.viscous_power, "sum", cell_power)
            fastest = over_chunks(body.cell_sums, chunks, numbers, CELLS.viscous_rate, "max", 0.0)
        raw[place + CELLS.viscous_power], raw[place + CELLS.viscous_rate] = power, fastest
    place += ti.static(group_size(*cell_groups(viscous or contact.options.viscous)))
    if ti.static(plastic):
        first = ti.static(group_size(*cell_groups(viscous)))
        for j, combine in ti.static(enumerate(FLOW_COMBINE)):
            raw[place + j] = over_chunks(body.cell_sums, chunks, numbers, first + j, combine, START[combine])
        place += ti.static(len(FLOW_COMBINE))
    for j in range(contact.sums.shape[0]):
        raw[place + j] = contact.sums[j]


@ti.func
def row_width(contact: ti.template(), viscous: ti.template(), plastic: ti.template()):
    """Return how many numbers a raw row has."""
    groups = ti.static(cell_groups(viscous or contact.options.viscous, plastic))
    return ti.static(NODE_SUMS + group_size(*groups)) + contact.sums.shape[0]
