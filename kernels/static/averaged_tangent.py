"""Stiffness between contact nodes of volume changes that are averaged at nodes (elements/tet4_node_averaged.py).

    A_kl += sum over volume nodes of parameters[0]/V_a c_ak x c_al,   c_ak = sum over cells of k and a of w_e dv_e/du_k

Contact nodes without a common cell are coupled by a volume node between them. `store_spread` stores w_e dv_e/du of the
corners of a contact cell when its tangent is renewed, `sum_members` makes of them the c_ak in the massless directions,
and `averaged_entry` the stiffness of an entry of K_KK. Lists and numbers: volume_places.py.
"""

from ..cells.node_averages import place
from ..contact.islands import first_node
from ..elements.tet4_node_averaged import of_volume
from ..engine import ti
from ..volume_places import (
    BLOCKS,
    CHANGES,
    CORNERS,
    MEMBERS,
    PRODUCTS,
    SHARES,
    SLOPE,
    SLOPES,
    SPREADS,
    TERMS,
)
from .massless_node import basis_of


@ti.func
def cell_pressure(
    body: ti.template(), pairs: ti.template(), number, own, first, law: ti.template(), parameters: ti.template()
):
    """Return the sum over the corners of contact cell `own` of contact block `number` of w_e U'(J_a).

    first: start of its corners. It has volume nodes: its contact nodes are not held in all components.
    """
    block = place(body, BLOCKS) + 2 * number
    shift, share = body.volume_lists[block], share_of(body, number, own)
    total = 0.0
    for k in range(CORNERS):
        change = body.volumes[place(body, CHANGES) + shift + pairs.cell_nodes[first + k]]
        total += share * of_volume(law, change, parameters)[0]
    return total


@ti.func
def share_of(body: ti.template(), number, own):
    """Return w_e of contact cell `own` of contact block `number`."""
    return body.volumes[place(body, SHARES) + body.volume_lists[place(body, BLOCKS) + 2 * number + 1] + own]


@ti.func
def store_spread(body: ti.template(), number, own, cell, slopes):
    """Store w_e dv/du of the corners of a contact cell; slopes [3 * corner + axis]: dv/du."""
    share = share_of(body, number, own)
    for i in range(3 * CORNERS):
        body.volumes[place(body, SPREADS) + 3 * CORNERS * cell + i] = share * slopes[i]


@ti.func
def sum_members(body: ti.template(), contact: ti.template(), island):
    """Set c_ak of all members of an island in the massless directions of their contact nodes."""
    block = ti.static(contact.options.block)
    for k in range(first_node(contact, island), first_node(contact, island + 1)):
        b = basis_of(contact.basis, k, block)
        for m in range(body.volume_lists[place(body, MEMBERS) + k], body.volume_lists[place(body, MEMBERS) + k + 1]):
            total = ti.Vector.zero(ti.f64, 3)
            for i in range(body.volume_lists[place(body, TERMS) + m], body.volume_lists[place(body, TERMS) + m + 1]):
                at = place(body, SPREADS) + 3 * body.volume_lists[i]
                total += ti.Vector([body.volumes[at + j] for j in range(3)])
            along = b.transpose() @ total
            for j in ti.static(range(block)):
                body.volumes[place(body, SLOPES) + SLOPE * m + j] = along[j]


@ti.func
def averaged_entry(body: ti.template(), e, block: ti.template()):
    """Return what the averages add to entry e of K_KK [block, block]."""
    total = ti.Matrix.zero(ti.f64, block, block)
    first = body.volume_lists[place(body, PRODUCTS) + e]
    for i in range((body.volume_lists[place(body, PRODUCTS) + e + 1] - first) // 2):
        left = place(body, SLOPES) + SLOPE * body.volume_lists[first + 2 * i]
        right = place(body, SLOPES) + SLOPE * body.volume_lists[first + 2 * i + 1]
        for p, q in ti.static(ti.ndrange(block, block)):
            total[p, q] += body.volumes[left + SLOPE - 1] * (body.volumes[left + p] * body.volumes[right + q])
    return total
