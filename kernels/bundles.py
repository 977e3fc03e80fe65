"""The arrays of a step under names, in bundles that functions pass on; signatures.py makes kernel signatures of them.

A field is annotated by what it is: Array (float64), Index (int32), Shared (one Array for all bundles that name it), or
anything else for a compile-time option. The host fills the same bundles; a field that a scene does not have is None.
"""

from typing import Any, NamedTuple

from .arguments import Array, Index, Shared


class Body(NamedTuple):
    """Force pass (cell_phase.py, node_phase.py): index arrays of packs, reference position, mass, state and sums.

    memory [pack, point, number, lane]: what the points of a law with state keep (point_memory.py); None for other
    laws.
    """

    u: Array = None
    v: Array = None
    connectivity: Index = None
    chunk_table: Index = None
    segments: Index = None
    corner_rows: Index = None
    node_info: Index = None
    position: Array = None
    mass: Array = None
    params: Array = None
    rows: Array = None
    special_force: Array = None
    node_sums: Array = None
    cell_sums: Array = None
    memory: Array = None


class Listed(NamedTuple):
    """Boundary nodes, the contact nodes first: node [s], mass and inverse tensors [s, 6], load [s, 3] = f_ext.

    sums: of all parts of a step but the force pass, as placed in lanes.py; the other bundles have the same array.
    """

    nodes: Index = None
    mass: Array = None
    inverse_mass: Array = None
    load: Array = None
    sums: Shared = None


class Supported(NamedTuple):
    """Prescribed components: place in the list of boundary nodes, axis, velocity [m/s]; sums: reaction, power."""

    slots: Index = None
    axes: Index = None
    speeds: Array = None
    sums: Shared = None


class Touching(NamedTuple):
    """Contact nodes k and obstacles.

    obstacles, motion, near [k, slots], reference [k, 3] as in obstacles.py; all_nodes, all_reference: the whole contact
    set; give [k]: penalty stiffness kappa A_k, or its inverse for massless nodes (0 = exact); force [k, 3]: the contact
    force; active [k]: bit mask of the obstacles that hold a massless node; basis [k, 3, block]: its massless
    components; last [k, block]: their displacement one level back; heirs: boundary nodes that take what the static
    solve leaves unbalanced, those of node k at heirs[k] .. heirs[k + 1]; friction: as in friction.py, its settings and
    what it keeps for every node; traces: what it keeps for every node and slot; kinds: what the kernel was made for.
    """

    nodes: Index = None
    obstacles: Array = None
    motion: Array = None
    near: Index = None
    reference: Array = None
    all_nodes: Index = None
    all_reference: Array = None
    give: Array = None
    force: Array = None
    sums: Shared = None
    basis: Array = None
    active: Index = None
    last: Array = None
    heirs: Index = None
    friction: Array = None
    traces: Array = None
    kinds: Any = None


class Kinds(NamedTuple):
    """Compile-time choices of contact: block (massless components a node), slots (obstacles that can hold one at a
    time), shapes of the obstacles, whether they move, whether their loads are summed up, friction ("", "coulomb" or
    "regularized"), layered: whether friction layers limit it, kicked: whether it acts on components with mass,
    viscous: whether the contact cells are, projected: whether MPRGP solves instead of the sweeps (mprgp.py)."""

    block: int = 1
    slots: int = 1
    shapes: tuple[str, ...] = ("plane",)
    moving: bool = False
    tracked: bool = False
    friction: str = ""
    layered: bool = False
    kicked: bool = False
    viscous: bool = False
    projected: bool = False

    @property
    def static_friction(self) -> bool:
        """Whether friction is part of the static solve."""
        return bool(self.friction) and self.block > 1

    @property
    def curved(self) -> bool:
        """Whether a gap is not linear in the position."""
        return self.shapes != ("plane",)


class System(NamedTuple):
    """The linear problem K_KK d = right + lambda nu, stored for sweeps over lanes of nodes (tcontact/sweep_order.py).

    corner_rows: force rows of the cell corners of node k at corner_rows[k] .. corner_rows[k + 1], with viscous contact
    cells of every boundary node, of which the contact nodes are the first; pack_start [packs+1]: nodes of a pack;
    lane_start [packs+1]: its entries; column [entries, lanes], values [entries, block, block, lanes];
    inverse [block, block, k] of the diagonal blocks, stiffness [k]: their trace; right, increment [block, k];
    gaps [slots, k], normals [slots, block, k]; push [block+1, k]: D^-1 n and 1/(n D^-1 n + e) of a single obstacle,
    with several or friction [block, k]: what the neighbours leave to a node, and behind it what MPRGP needs
    (node_places.py); behind increment stand two of earlier sweeps. The node comes last, so that the lanes of a pack are
    neighbours, and there is room for LANES - 1 more.
    settings and stats: static_control.py.
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
    push: Array = None
    increment: Array = None
    settings: Array = None
    stats: Array = None


class Pairs(NamedTuple):
    """Stiffness between the contact nodes of a cell, and where it goes in the system (tcontact/contact_graph.py).

    blocks: the contact blocks, numbered as in lanes.py; of each cell_nodes [c, corners], shape_gradients
    [q, corners, 3], weights [q]; start [c+1], corners, nodes [p, 2],
    values [p, block, block]; row_start [k+1], entry_start [e+1], entry_pairs, entry_place [e].
    """

    blocks: Index = None
    cell_nodes: Index = None
    shape_gradients: Array = None
    weights: Array = None
    start: Index = None
    corners: Index = None
    nodes: Index = None
    values: Array = None
    row_start: Index = None
    entry_start: Index = None
    entry_pairs: Index = None
    entry_place: Index = None


class Launch(NamedTuple):
    """One launch of the serial driver (serial_step.py): control, raw_out [rows, width] as in raw_rows.py.

    viscous_cells: data of viscous contact cells (cell_viscosity.py); images: of a periodic body (images.py).
    """

    viscous_cells: Array = None
    images: Index = None
    control: Array = None
    raw_out: Array = None
