"""Numbers of the friction layers of a GPU by their places in `layers` and `layer_lists` (layer_places.py)."""

from ..contact.islands import node_count
from ..engine import ti
from ..language.joint_lists import number_of_list
from ..layer_places import BATCHES, ENTRIES, ENTRY_OF, HEAD, NODE, SIZES, USED


@ti.func
def size(contact: ti.template(), which: ti.template()):
    """Return a number of SIZES of the lists."""
    return number_of_list(contact.layer_lists, SIZES, which)


@ti.func
def at_node(contact: ti.template(), number: ti.template(), k):
    """Return where a number of node k stands in `layers`."""
    return HEAD + number * node_count(contact) + k


@ti.func
def at_entry(contact: ti.template(), number: ti.template(), e):
    """Return where a number of entry e stands in `layers`."""
    return HEAD + NODE * node_count(contact) + number * size(contact, ENTRIES) + e


@ti.func
def of_node(contact: ti.template(), number: ti.template(), k):
    """Return a number of node k."""
    return contact.layers[at_node(contact, number, k)]


@ti.func
def set_node(contact: ti.template(), number: ti.template(), k, value):
    """Set a number of node k."""
    contact.layers[at_node(contact, number, k)] = value


@ti.func
def of_used(contact: ti.template(), number: ti.template(), k):
    """Return a number of the layer that node k uses; 0 where it uses none."""
    found, batch = 0.0, ti.cast(of_node(contact, USED, k), ti.i32)
    if batch >= 0:
        e = number_of_list(contact.layer_lists, ENTRY_OF, batch * node_count(contact) + k)
        found = contact.layers[at_entry(contact, number, e)]
    return found


@ti.func
def of_all(contact: ti.template(), number: ti.template(), k):
    """Return a number of all layers of node k together."""
    total = 0.0
    for batch in range(size(contact, BATCHES)):
        e = number_of_list(contact.layer_lists, ENTRY_OF, batch * node_count(contact) + k)
        if e >= 0:
            total += contact.layers[at_entry(contact, number, e)]
    return total
