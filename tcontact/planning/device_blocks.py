"""How many blocks of threads of a GPU share the contact nodes of a domain (kernels/step/device_blocks.py)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..kernels.lanes import BLOCK_THREADS
from .domain import Domain

if TYPE_CHECKING:
    from ..kernels.language.bundles import ContactOptions

MANY_NODES = 1024  # contact nodes from which several blocks are faster than one, which needs fewer launches
MOST_BLOCKS = 128  # about the processors of a large device


def contact_blocks(domain: Domain, options: ContactOptions) -> int:
    """Return the number of blocks, a power of two; 1 for few nodes, and for terms that one block alone takes.

    These are friction of which the static solve is a part or whose coefficient varies, friction layers, obstacles that
    move, springs, loads and supports that functions of time move.
    """
    assert domain.contact is not None
    count = len(domain.contact.nodes)
    rubbing = options.static_friction or options.varied or options.layered
    alone = rubbing or options.posed or options.free or options.model != "massless"
    if count < MANY_NODES or alone or domain.driven or domain.springs or domain.loaded or domain.pairs:
        return 1
    return min(1 << (-(-count // BLOCK_THREADS) - 1).bit_length(), MOST_BLOCKS)


def partial_numbers(width: int, islands: int) -> int:
    """Return how many numbers every block leaves for others in a launch; width: sums of a row."""
    return max(width + islands + 1, 5 * islands)
