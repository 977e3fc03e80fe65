"""Hand on what the contact between bodies remembers, from the numbering of a domain to that of the user and back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...contact.pairs.pair_contact import PairContact
from ...results.pair_memory import PairMemory
from ...scene.scene import Scene
from .body_view import BodyView


def remembered(scene: Scene, states: Sequence[BodyView]) -> PairMemory | None:
    """Return what the pairs of a run remember; None without pairs. On several ranks the first one has them."""
    if not scene.body_pairs:
        return None
    counts = [body.mesh.node_count for body in scene.bodies]
    starts = np.concatenate([[0], np.cumsum(counts)])
    closed, built = np.full(starts[-1], np.nan), np.full((starts[-1], 3), np.nan)
    searched = built.copy()
    fast: tuple[int, ...] = ()
    steps = 0
    for domain in {id(state.state): state.state for state in states}.values():
        pairs = _pairs_of(domain)
        if pairs is None:
            continue
        fast, steps = fast + pairs.fast, pairs.built_ago
        whole, nodes = domain.whole_domain, domain.whole_nodes(pairs.nodes)
        for number, body, first, end in zip(
            whole.numbers, whole.bodies, whole.node_start[:-1], whole.node_start[1:], strict=True
        ):
            own = (nodes >= first) & (nodes < end)
            rows = starts[number] + body.node_order[nodes[own] - first]
            closed[rows], built[rows], searched[rows] = pairs.closed_gaps[own], pairs.built[own], pairs.searched[own]
    return PairMemory(closed, built, searched, fast, steps)


def go_on(domains: Sequence[Any], scene: Scene, memory: PairMemory | None) -> None:
    """Let the pairs of a new run go on with what those of another one remembered."""
    if memory is None:
        return
    ends = np.cumsum([body.mesh.node_count for body in scene.bodies])[:-1]
    given = np.split(np.column_stack([memory.closed, memory.built, memory.searched]), ends)
    for domain in domains:
        pairs = _pairs_of(domain)
        if pairs is not None:
            values = domain.started_with([given[number] for number in domain.whole_domain.numbers])[pairs.nodes]
            pairs.go_on(values[:, 0], values[:, 1:4], values[:, 4:], memory.fast, memory.steps)


def _pairs_of(domain: Any) -> PairContact | None:
    found: PairContact | None = None if domain.contact is None else domain.contact.pairs
    return found
