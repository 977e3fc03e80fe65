"""Nodes of which other ranks have copies: each sum over nodes counts one of the copies.

    sum_i counted_i q_i,   counted_i = 1 for one copy of node i, 0 for the others

Without other ranks `contact.counted` is None, and nothing of this is left when a kernel is compiled.
"""

from ..engine import ti


@ti.func
def counted(contact: ti.template(), s):
    """Return 1.0 if the sums of this rank count boundary node s, else 0.0."""
    share = 1.0
    if ti.static(contact.copied):
        share = contact.counted[s]
    return share
