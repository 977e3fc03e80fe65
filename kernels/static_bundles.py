"""The arrays of the static solve under names: kernels list them as arguments, functions pass them on in two bundles."""

from typing import Any, NamedTuple


class Nodes(NamedTuple):
    """The massless contact nodes k = 0.. and what acts on them.

    nodes [k]; basis [k, 3, block]; planes, near [k, slots], reference [k, 3] (planes.py); u [n, 3]; load [k, 3] = f_ext;
    compliance [k] = 1/(kappa A), 0 = exact; active [k]: bit mask of the planes that hold the node.
    """

    nodes: Any
    basis: Any
    planes: Any
    near: Any
    reference: Any
    u: Any
    load: Any
    compliance: Any
    active: Any


class System(NamedTuple):
    """The linear problem K_KK d = right + lambda nu, stored for sweeps over lanes of nodes (tcontact/sweep_order.py).

    corner_start [k+1], corner_rows: force rows of the cell corners of a node; rows: force rows of the contact cells;
    lane_start [packs+1], lane_node [packs, lanes], column [entries, lanes], values [entries, block, block, lanes];
    inverse [k, block, block] of the diagonal blocks, stiffness [k]: their trace; right, increment [k, block];
    gaps [k, slots], normals [k, slots, block]; push [k, block+1]: D^-1 n and 1/(n D^-1 n + e) of a single plane.
    """

    corner_start: Any
    corner_rows: Any
    rows: Any
    lane_start: Any
    lane_node: Any
    column: Any
    values: Any
    inverse: Any
    stiffness: Any
    settings: Any
    right: Any
    gaps: Any
    normals: Any
    push: Any
    increment: Any
    stats: Any
