"""Parts of an island that a thread takes one after another: packs of nodes, single nodes where threads share them."""

from ..contact.islands import first_pack
from ..engine import ti
from ..lanes import SWEEP_LANES as LANES
from ..language.threads import item, turns
from .neighbours import forces_at, neighbour_forces


@ti.func
def parts(contact: ti.template(), island):
    """Return how many parts of an island this thread takes: packs, or with several threads single nodes of packs."""
    count = first_pack(contact, island + 1) - first_pack(contact, island)
    if ti.static(contact.options.threads > 1):
        count = turns(contact, count * LANES)
    return count


@ti.func
def part_of(contact: ti.template(), system: ti.template(), island, turn):
    """Return the pack of a part, its first node and the count of its nodes, 0 where there is no such node."""
    pack, lane = first_pack(contact, island) + turn, 0
    if ti.static(contact.options.threads > 1):
        place = item(contact, turn)
        pack, lane = first_pack(contact, island) + place // LANES, place % LANES
    node = system.pack_start[pack] + lane
    count = system.pack_start[pack + 1] - node
    if ti.static(contact.options.threads > 1):
        count = ti.min(count, 1)
    return pack, node, count


@ti.func
def product_of(contact: ti.template(), system: ti.template(), pack, node, block: ti.template()):
    """Return the forces [N] that the motion of their neighbours causes at the nodes of a part, as lanes."""
    if ti.static(contact.options.threads > 1):
        alone = forces_at(system, pack, node - system.pack_start[pack], block)
        return [ti.Vector([alone[i]]) for i in range(block)]
    else:
        return neighbour_forces(system, pack, block)
