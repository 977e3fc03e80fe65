"""Pairs of bodies in a step on a GPU: what of a step is theirs, and when the host must build their rows anew.

    load       rows filled; force of the slaves, then of the masters; counts and loads of every pair
    friction   of the kick: one row after another, by one thread
    stale      rows that slipped too far, or surfaces that moved: the block of steps ends (A_ROWS)

One thread takes what goes from slave to master, one row after another (contact/pair_rows.py); all share the rest.
Within a block of steps the rows keep their faces and weights: nothing is searched, copied or waited for.
"""

from ..contact.pair_loads import apply_to_masters, count_pairs
from ..contact.pair_rows import fill_pair_rows, is_stale, press_all_masters
from ..engine import ti
from ..language.threads import leader
from ..pair_places import SQUEEZED
from ..static.chosen_rows import find_squeezed
from .device_control import A_ROWS, WANTS


@ti.func
def begin_pairs(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), system: ti.template()
):
    """Fill the rows of pairs, and note a node that is squeezed."""
    if ti.static(contact.options.coupled):
        fill_pair_rows(contact.coupling, contact, boundary, rows, body)
        if ti.static(rows.at.lift >= 0):
            find_squeezed(contact.coupling, contact, rows, system)


@ti.func
def press_pairs(body: ti.template(), contact: ti.template(), rows: ti.template()):
    """Let the forces of a penalty act on the masters too."""
    if ti.static(contact.options.coupled):
        press_all_masters(contact.coupling, body, contact, rows)


@ti.func
def load_pairs(body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template()):
    """Count the rows of every pair, and sum up the forces on masters."""
    if ti.static(contact.options.coupled):
        count_pairs(contact.coupling, contact, rows)
        apply_to_masters(contact.coupling, boundary, body, contact, rows, rows.at.force)


@ti.func
def look_at_pairs(
    body: ti.template(), lists: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(),
    fills: ti.template(),
):  # fmt: skip
    """Ask for new rows where the present ones are stale; fills: they are filled first, since nodes have moved."""
    if ti.static(contact.options.coupled):
        if ti.static(fills):
            fill_pair_rows(contact.coupling, contact, boundary, rows, body)
        stale = is_stale(contact.coupling, boundary, contact, rows, body)
        if leader(contact) == 1 and stale == 1:
            lists.control[WANTS] = A_ROWS


@ti.func
def squeezed(contact: ti.template()):
    """Return 1 if a node is squeezed, which the host must see."""
    found = 0
    if ti.static(contact.options.coupled):
        if contact.pair_values[SQUEEZED] != 0.0:
            found = 1
    return found
