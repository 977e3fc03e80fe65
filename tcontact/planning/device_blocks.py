"""How many blocks of threads of a GPU share the contact nodes of a domain (kernels/step/device_blocks.py)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..kernels.lanes import BLOCK_NUMBERS, BLOCK_THREADS, DEVICE_BLOCK
from .domain import Domain
from .islands import Island

if TYPE_CHECKING:
    from ..kernels.language.bundles import ContactOptions

MANY_SWEPT = 4096  # contact nodes from which the launches of a sweep take less time than its work on one block
MANY_NODES = 1024  # contact nodes from which several blocks are faster than one, which needs fewer launches
MOST_BLOCKS = 128  # about the processors of a large device


def contact_blocks(domain: Domain, options: ContactOptions) -> int:
    """Return the number of blocks, a power of two; 1 for few nodes, and for terms that one block alone takes.

    These are friction of which the static solve is a part, whose coefficient varies or which layers limit, obstacles
    that move, pairs of bodies, springs, loads and supports that functions of time move.
    """
    assert domain.contact is not None
    friction = options.static_friction or options.varied or options.layered
    moves = options.posed or options.free or options.coupled or options.model != "massless"
    if friction or moves or domain.driven or domain.springs or domain.loaded:
        return 1
    return blocks_of(len(domain.contact.nodes))


def blocks_of(nodes: int) -> int:
    """Return the number of blocks for so many contact nodes."""
    if nodes < MANY_NODES:
        return 1
    return min(max(2, 1 << (-(-nodes // DEVICE_BLOCK) - 1).bit_length()), MOST_BLOCKS)


def sweep_colours(domain: Domain, islands: Sequence[Island], blocks: int, options: ContactOptions) -> int:
    """Return the most colours of an island whose sweeps are launched colour by colour; 0 where one block makes them.

    MPRGP runs on one block.
    """
    assert domain.contact is not None
    assert domain.contact.graph is not None
    if blocks == 1 or options.projected or len(domain.contact.nodes) < MANY_SWEPT:
        return 0
    starts = [*(island.nodes.start for island in islands), len(domain.contact.nodes)]
    counts = np.diff(np.searchsorted(domain.contact.graph.colour_start, starts))
    return int(counts.max()) if counts.max() <= BLOCK_NUMBERS else 0


def scratch(blocks: int) -> int:
    """Return how many numbers the threads of one or several blocks need to combine values."""
    return (BLOCK_NUMBERS + 1) * max(BLOCK_THREADS, blocks * DEVICE_BLOCK)


def partial_numbers(width: int, islands: int, colours: int) -> int:
    """Return how many numbers every block leaves for others in a launch; width: sums of a row."""
    return width + islands + 1 + max(5, colours) * islands
