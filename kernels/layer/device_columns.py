"""Columns of the heat equation of friction layers for another step, on a GPU (tcontact/friction_layer/grid.py).

    C_i = c_i/dt + C below,   pivot_i = C_i + G_{i-1},   gain = c_i/dt / pivot,   link = G_i / pivot,
    back = G_{i-1} / pivot,   C below of node i-1 = G_{i-1} C_i / pivot,   Bq_0 = 1/pivot_0,   Bq_i = back_i Bq_{i-1}

c_i [J/(m^2 K)]: heat capacity, G_i [W/(m^2 K)]: conductance to the next node. A thread takes a side of a batch of
layers: as many threads as there are sides compute the columns of all layers.
"""

from ..engine import ti
from ..language.joint_lists import number_of_list
from ..language.threads import item, leader, meet, turns
from ..layer_places import BATCHES, POINTS, SIDES, SIZES, TABLES
from .layer1d_residual import BACK, GAIN, LINK, MATERIAL, NODE, ROOM, WARMTH
from .layer1d_step import SETTINGS

CONDUCTANCE, LENGTH = 1, 3  # behind the materials: g, and the step


@ti.func
def set_columns(contact: ti.template(), dt):
    """Set the columns of all layers for steps of dt [s], unless they are those."""
    tables = ti.static(contact.layer_tables)
    if tables[0] != dt:
        meet(contact)
        batches = number_of_list(contact.layer_lists, SIZES, BATCHES)
        for turn in range(turns(contact, 2 * batches)):
            batch, side = item(contact, turn) // 2, item(contact, turn) % 2
            if side < number_of_list(contact.layer_lists, SIDES, batch):
                set_side(contact, batch, side, dt)
        meet(contact)
        if leader(contact) == 1:
            tables[0] = dt
            for batch in range(batches):
                set_partition(contact, batch, dt)
        meet(contact)


@ti.func
def set_side(contact: ti.template(), batch, side, dt):
    """Set the columns of a side of a batch."""
    tables = ti.static(contact.layer_tables)
    points = number_of_list(contact.layer_lists, SIZES, POINTS)
    sides = number_of_list(contact.layer_lists, SIDES, batch)
    first = number_of_list(contact.layer_lists, TABLES, batch)
    column = first + NODE * points * side
    given = first + (NODE * points + MATERIAL) * sides + SETTINGS + 2 * points * side
    below = tables[given + 2 * (points - 1)]
    for turn in range(points):
        i = points - 1 - turn
        at, above = column + NODE * i, 0.0
        if i > 0:
            above = tables[given + 2 * (i - 1)]
        capacity = tables[given + 2 * i + 1] / dt
        own = capacity + below
        pivot = own + above
        tables[at + GAIN] = capacity / pivot
        tables[at + LINK] = tables[given + 2 * i] / pivot
        tables[at + BACK] = above / pivot
        below = above * own / pivot
        if i == 0:
            tables[at + WARMTH] = 1.0 / pivot
    warmth = tables[column + WARMTH]
    for i in range(points):
        at = column + NODE * i
        if i > 0:
            warmth = tables[at + BACK] * warmth
        tables[at + WARMTH] = warmth
        tables[at + ROOM] = ti.select(warmth > 1e-300, 1.0 / ti.max(warmth, 1e-300), 1e300)


@ti.func
def set_partition(contact: ti.template(), batch, dt):
    """Set the numbers of a batch that say how its heat is divided, and the step."""
    tables = ti.static(contact.layer_tables)
    points = number_of_list(contact.layer_lists, SIZES, POINTS)
    sides = number_of_list(contact.layer_lists, SIDES, batch)
    first = number_of_list(contact.layer_lists, TABLES, batch)
    settings = first + (NODE * points + MATERIAL) * sides
    resistance = 0.0
    for side in range(sides):
        resistance += tables[first + NODE * points * side + WARMTH]
    tables[settings + CONDUCTANCE] = 1.0 / (tables[settings + SETTINGS + 2 * points * sides] + resistance)
    tables[settings + LENGTH] = dt
