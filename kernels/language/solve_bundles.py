"""The bundles of the static solve, as those of bundles.py."""

from typing import NamedTuple

from ..lanes import SWEEP_LANES
from .arguments import Array, Index
from .joint_lists import JointList


class System(NamedTuple):
    """Linear problem K_KK d = right + lambda nu of the static solve (tcontact/planning/sweep_order.py).

    A pack is up to LANES nodes of one colour, one per lane. pack_start [packs+1]: its first node; lane_start [packs+1]:
    its first entry off the diagonal of K_KK; column [entries, lanes], values [entries, block, block, lanes];
    inverse [block, block, k]: of the diagonal blocks, stiffness [k]: their trace; right, increment [block, k]; gaps
    [slots, k], normals [slots, block, k]: of all rows, beside pairs of those that enter (static/chosen_rows.py);
    response [block+1, k]: D^-1 n and 1/(n D^-1 n + e) of nodes with one row without friction, else [block, k]: right
    side less the forces from the neighbours; for MPRGP see node_places.py. Behind `increment` stand two vectors of
    earlier sweeps. colours (of threads that share the loops): first colour of each island [islands+1], then the first
    pack of each colour [colours+1]. The node is the last index, so that the lanes of a pack are contiguous; arrays are
    LANES - 1 nodes longer than needed. settings, stats [islands, ..]: static/control.py; sweep_state [islands, ..]: of
    sweeps that are launched one by one (static/sweeps.py).
    """

    lane_start: Index = None
    pack_start: Index = None
    column: Index = None
    values: Array = None
    inverse: Array = None
    stiffness: Array = None
    right: Array = None
    gaps: Array = None
    normals: Array = None
    response: Array = None
    increment: Array = None
    settings: Array = None
    stats: Array = None
    colours: Index = None
    sweep_state: Array = None

    @property
    def lanes(self) -> int:
        """Return how many nodes the functions of a pack take at once: one where threads share the nodes."""
        return SWEEP_LANES if self.colours is None else 1

    @property
    def lane_numbers(self) -> list[int]:
        """Return the numbers of these lanes."""
        return list(range(self.lanes))


class Pairs(NamedTuple):
    """Stiffness between pairs of contact nodes of a cell, and its assembly (tcontact/planning/contact_graph.py).

    blocks: contact blocks, numbers as in lanes.py; for each cell_nodes [c, corners], shape_gradients [q, corners, 3],
    with the weights [q] behind those of all blocks; start [c+1]: first pair of a cell; corners, nodes [p, 2] and values
    [p, block, block] of a pair. row_start [k+1]: first entry of a row of K_KK; entries [e+1, 2]: first pair of an entry
    in entry_pairs (-1 - p: the transpose of pair p), and place of the entry in System.values.
    """

    blocks: Index = None
    cell_nodes: Index = None
    shape_gradients: Array = None
    start: Index = None
    corners: Index = None
    nodes: Index = None
    values: Array = None
    row_start: Index = None
    entries: Index = None
    entry_pairs: Index = None


PAIR_LISTS = ("blocks", "cell_nodes", "start", "corners", "nodes", "row_start", "entries", "entry_pairs")


class JointPairs(NamedTuple):
    """`Pairs` with its lists of whole numbers, PAIR_LISTS, in one array, for kernels of too many arguments."""

    lists: Index = None
    shape_gradients: Array = None
    values: Array = None

    def __getattr__(self, name: str) -> JointList:
        """Return one of the lists."""
        if name not in PAIR_LISTS:
            raise AttributeError(name)
        return JointList(self.lists, PAIR_LISTS.index(name))
