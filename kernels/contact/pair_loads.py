"""Loads of the pairs of bodies: the forces of their rows on the masters, and the sums that the history shows.

A row with the force F on its slave acts with -P_sm F on its masters. The force on the first body of a pair is the sum
of P_sm F over its rows and the masters of the other body, with the opposite sign where the first body is the master.
"""

from ..columns import PAIR_LOAD, PAIR_LOADS, SUMS, UNREACHED
from ..engine import ti
from ..language.counted import counted
from ..language.entries import row
from ..language.threads import leader, meet
from ..pair_places import FIRST_ENTRY, MASTERS, PAIRS, ROWS, SIDES, SLAVES
from .constraint_rows import number_of, vector_of
from .islands import node_count
from .pair_rows import entry, pair_row, weight


@ti.func
def count_pairs(coupling: ti.template(), contact: ti.template(), rows: ti.template()):
    """Set the loads of every pair to 0, and count its rows, those that press, and the smallest gap."""
    meet(contact)
    if leader(contact) == 1:
        count_rows(coupling, contact, rows)


@ti.func
def count_rows(coupling: ti.template(), contact: ti.template(), rows: ti.template()):
    """Count the rows of every pair by one thread; the forces on masters that are no contact nodes start from 0."""
    for place in range(3 * node_count(contact), contact.force.shape[0]):
        contact.force[place] = 0.0
    pairs = coupling.lists[PAIRS]
    start = contact.sums.shape[0] - pairs * PAIR_LOADS
    for p in range(pairs):
        for j in ti.static(range(PAIR_LOADS)):
            contact.sums[start + p * PAIR_LOADS + j] = 0.0
        contact.sums[start + p * PAIR_LOADS + PAIR_LOAD.pair_gap_min] = UNREACHED
    for r in range(coupling.lists[ROWS]):
        k = entry(coupling, SLAVES, r)
        own = pair_row(rows, k)
        gap, pressed = number_of(rows, own, rows.at.gap), vector_of(rows, own, rows.at.force).norm() > 0.0
        last = -1
        for i in range(entry(coupling, FIRST_ENTRY, r), entry(coupling, FIRST_ENTRY, r + 1)):
            side = entry(coupling, SIDES, i)
            if side != last:
                at = start + (side >> 1) * PAIR_LOADS
                gap_place, rows_place = at + PAIR_LOAD.pair_gap_min, at + PAIR_LOAD.pair_rows
                contact.sums[gap_place] = ti.min(contact.sums[gap_place], gap)
                contact.sums[rows_place] = contact.sums[rows_place] + counted(contact, k)
                if pressed:
                    place = at + PAIR_LOAD.pair_pressed
                    contact.sums[place] = contact.sums[place] + counted(contact, k)
            last = side


@ti.func
def apply_to_masters(
    coupling: ti.template(),
    boundary: ti.template(),
    body: ti.template(),
    contact: ti.template(),
    rows: ti.template(),
    place: ti.template(),
):
    """Add the forces of the rows on the masters to the contact forces and to the loads of every pair.

    The loads are the force on the first body of a pair and its moment about the origin. place: rows.at.force, or
    rows.at.kick_friction.
    """
    meet(contact)
    if leader(contact) == 1:
        press_masters_of_rows(coupling, boundary, body, contact, rows, place)
    meet(contact)


@ti.func
def press_masters_of_rows(
    coupling: ti.template(), boundary: ti.template(), body: ti.template(), contact: ti.template(), rows: ti.template(),
    place: ti.template(),
):  # fmt: skip
    """Add the forces of the rows on the masters by one thread."""
    start = contact.sums.shape[0] - coupling.lists[PAIRS] * PAIR_LOADS
    on_masters = ti.Vector.zero(ti.f64, 3)
    for r in range(coupling.lists[ROWS]):
        k = entry(coupling, SLAVES, r)
        force, share = vector_of(rows, pair_row(rows, k), place), counted(contact, k)
        slave = row(body.position, boundary.nodes[k]) + row(body.u, boundary.nodes[k])
        for i in range(entry(coupling, FIRST_ENTRY, r), entry(coupling, FIRST_ENTRY, r + 1)):
            m, side = entry(coupling, MASTERS, i), entry(coupling, SIDES, i)
            part = weight(coupling, i) * force
            on_masters += share * part
            if m < contact.force.shape[0] // 3:  # held ones are no contact nodes
                for j in ti.static(range(3)):
                    contact.force[3 * m + j] = contact.force[3 * m + j] - part[j]
            at = start + (side >> 1) * PAIR_LOADS
            master = row(body.position, boundary.nodes[m]) + row(body.u, boundary.nodes[m])
            moment = slave.cross(part)
            if side & 1 == 1:
                part, moment = 0.0 - part, 0.0 - master.cross(part)
            for j in ti.static(range(3)):
                force_place, moment_place = at + PAIR_LOAD.pair_force + j, at + PAIR_LOAD.pair_moment + j
                contact.sums[force_place] = contact.sums[force_place] + share * part[j]
                contact.sums[moment_place] = contact.sums[moment_place] + share * moment[j]
    for j in ti.static(range(3)):
        contact.sums[SUMS.contact_force + j] = contact.sums[SUMS.contact_force + j] - on_masters[j]
