"""Islands: sets of contact nodes that no stiffness couples to other contact nodes.

The contact nodes of a body are one island. The static solve of an island has its own settings, residual and end, so
that its result is that of a run with this body alone, to rounding errors: the positions of all islands are relative to
one point among their nodes. One force pass over the contact cells serves all.
`islands` [i+1, ISLAND] holds where island i begins among the contact nodes, the packs of the sweeps,
the nodes without rows (behind the contact nodes in their list) and the contact blocks (lanes.py).
"""

from ..engine import ti
from ..lanes import ISLAND


@ti.func
def island_count(contact: ti.template()):
    """Return the number of islands."""
    return contact.islands.shape[0] // ISLAND - 1


@ti.func
def first_node(contact: ti.template(), island):
    """Return the first contact node of an island; its nodes end before the first node of the next island."""
    return contact.islands[ISLAND * island]


@ti.func
def first_pack(contact: ti.template(), island):
    """Return the first pack of an island in the order of the sweeps."""
    return contact.islands[ISLAND * island + 1]


@ti.func
def first_other(contact: ti.template(), island):
    """Return the first node of an island without rows."""
    return contact.islands[ISLAND * island + 2]


@ti.func
def node_count(contact: ti.template()):
    """Return the number of contact nodes of all islands."""
    return first_node(contact, island_count(contact))


@ti.func
def first_block(contact: ti.template(), island):
    """Return the first contact block of an island."""
    return contact.islands[ISLAND * island + 3]
