"""Loads of the boundary nodes where the threads of a block share them, as `loads.apply_loads` sets them on one thread.

A thread computes what the corners of a face get; another one adds up what a node gets, in the order of one thread.
`load_sources` holds the start of the list of every loaded node [NODES + 1], then the lists: the number of an entry, or
ENTRIES + 4 face + corner.
"""

from ..engine import ti
from ..lanes import GRAVITY
from ..language.entries import put_three, row, three
from ..language.threads import item, leader, meet, turns
from ..load_places import ENTRIES, ENTRY, FACE, FACES, FORCE, HEAD, NODE, NODES, STRIDE
from .boundary_nodes import weight
from .loads import corner_shares, head, put_three_from


@ti.func
def apply_shared_loads(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), number, pulled: ti.template()
):  # fmt: skip
    """Set the loads of the boundary nodes to those of row `number`, at the present positions.

    pulled: gravity is a function of time; it goes to body.params.
    """
    load = ti.static(boundary.load)
    entry_at = 3 * boundary.nodes.shape[0] + HEAD + NODE * head(boundary, NODES)
    face_at = entry_at + ENTRY * head(boundary, ENTRIES)
    row_at = face_at + FACE * head(boundary, FACES) + number * head(boundary, STRIDE)
    if ti.static(pulled):
        if leader(contact) == 1:
            put_three_from(body.params, GRAVITY, load, row_at)
    for turn in range(turns(contact, head(boundary, FACES))):
        i = item(contact, turn)
        at = face_at + FACE * i
        shares = corner_shares(body, load, at, load[row_at + int(load[at + 8])])
        for corner in ti.static(range(4)):
            put_three(boundary.load_shares, 12 * i + 3 * corner, shares[corner])
    meet(contact)
    if ti.static(pulled):
        for turn in range(turns(contact, boundary.nodes.shape[0])):
            s = item(contact, turn)
            put_three(load, 3 * s, weight(body, boundary, s))
        meet(contact)
    for turn in range(turns(contact, head(boundary, NODES))):
        apply_to_node(body, boundary, entry_at, row_at, item(contact, turn))
    meet(contact)


@ti.func
def apply_to_node(body: ti.template(), boundary: ti.template(), entry_at, row_at, j):
    """Set the load of loaded node j."""
    load = ti.static(boundary.load)
    entries = head(boundary, ENTRIES)
    force = ti.Vector.zero(ti.f64, 3)
    for place in range(boundary.load_sources[j], boundary.load_sources[j + 1]):
        source = boundary.load_sources[place]
        if source < entries:
            at = entry_at + ENTRY * source
            force += load[at + 1] * three(load, row_at + int(load[at + 2]))
        else:
            force += row(boundary.load_shares, source - entries)
    at = 3 * boundary.nodes.shape[0] + HEAD + NODE * j
    s = int(load[at])
    put_three(load, at + FORCE, force)
    put_three(load, 3 * s, weight(body, boundary, s) + force)
