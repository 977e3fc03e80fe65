"""Record of friction: slip path and friction work of every contact node since the start, for frames that hold them.

At its end `friction` (friction.py) has for every contact node its slip path [m] and the work of its friction [J] up to
the time level, then what the last kick adds to both in the step that starts there. With friction in the static solve
the slip is that of its steps. A node with several rows has the longest slip of those with a force.
"""

from ..engine import ti
from ..language.threads import item, turns
from .islands import node_count

RECORD = 4
SLIP, DONE, NEXT_SLIP, NEXT_WORK = range(RECORD)


@ti.func
def record_place(contact: ti.template(), k, number: ti.template()):
    """Return where a number of the record of node k stands in `friction`."""
    return contact.friction.shape[0] + RECORD * (k - node_count(contact)) + number


@ti.func
def begin_kick(contact: ti.template()):
    """Add what the last kick left for the step that has ended."""
    for turn in range(turns(contact, node_count(contact))):
        k = item(contact, turn)
        record_step(
            contact, k, contact.friction[record_place(contact, k, NEXT_SLIP)],
            contact.friction[record_place(contact, k, NEXT_WORK)],
        )  # fmt: skip
        contact.friction[record_place(contact, k, NEXT_SLIP)] = 0.0
        contact.friction[record_place(contact, k, NEXT_WORK)] = 0.0


@ti.func
def record_step(contact: ti.template(), k, slip, work):
    """Add slip [m] and work [J] of the step that ends at the time level."""
    path, done = record_place(contact, k, SLIP), record_place(contact, k, DONE)
    contact.friction[path] = contact.friction[path] + slip
    contact.friction[done] = contact.friction[done] + work


@ti.func
def record_kick(contact: ti.template(), k, early, late, slip):
    """Add the work [J] of a kick, before and after the time level; slip [m]: in the step that starts there."""
    record_step(contact, k, 0.0, early)
    path, work = record_place(contact, k, NEXT_SLIP), record_place(contact, k, NEXT_WORK)
    contact.friction[work] = contact.friction[work] + late
    contact.friction[path] = ti.max(contact.friction[path], slip)
