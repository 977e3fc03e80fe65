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


class Boundary(NamedTuple):
    """Boundary nodes, the contact nodes first: node [s], mass and inverse tensors [s, 6], load [s, 3] = f_ext.

    sums: of all parts of a step but the force pass, as placed in columns.py; the other bundles have the same array.
    """

    nodes: Index = None
    mass: Array = None
    inverse_mass: Array = None
    load: Array = None
    sums: Shared = None


class Supports(NamedTuple):
    """Prescribed components: place in the list of boundary nodes, axis, velocity [m/s]; sums: reaction, power."""

    slots: Index = None
    axes: Index = None
    speeds: Array = None
    sums: Shared = None


class Contact(NamedTuple):
    """Contact nodes k and what acts on them; nothing here knows what they touch (constraint_rows.py does).

    nodes [k + m]: the contact nodes, and behind them the m other nodes of the contact set, whose gaps no row knows;
    reference [k + m, 3] [m]: their positions at rest, from a point among them; islands: islands.py; force [k, 3] [N]:
    the contact force; penalty_stiffness [k] [N/m]: kappa A_k of nodes with mass; compliance [k] [m/N]: its inverse for
    massless nodes, 0 for the exact constraint. Massless nodes also have active [k]: bit mask of the rows that hold
    them; basis [k, 3, block]: their massless components; displacement_before [k, block]: of these, one level back;
    residual_receivers: boundary nodes that take what the static solve leaves unbalanced, those of node k at
    residual_receivers[k] .. residual_receivers[k + 1]. friction: settings and numbers of every node (friction.py);
    options: what the kernel is made for.
    """

    nodes: Index = None
    islands: Index = None
    reference: Array = None
    compliance: Array = None
    penalty_stiffness: Array = None
    force: Array = None
    sums: Shared = None
    basis: Array = None
    active: Index = None
    displacement_before: Array = None
    residual_receivers: Index = None
    friction: Array = None
    options: Any = None


class Obstacles(NamedTuple):
    """Rigid obstacles (obstacles.py); candidates [k, slots]: the one that each row of a contact node stands for."""

    records: Array = None
    motion: Array = None
    candidates: Index = None
    options: Any = None


class RowPlaces(NamedTuple):
    """Places of the numbers of a constraint row in `values` [rows, width]; -1: no term of the scene asks for it.

    gap [m]; size_squared [m^2] of the lengths that it is a difference of; normal (3) into the body; velocity (3) [m/s]
    of the partner where the node touches it, now, and mean_velocity (3) over the step that led here; force (3) [N] on
    the node, without kick_friction (3) [N], which comes with a kick. Friction: its coefficient; pressing [N]: lambda;
    in the static solve traction (3) [N] now and traction_before (3) a step ago, slip (3) [m] since then at the last
    measure.
    """

    gap: int
    normal: int
    force: int
    size_squared: int
    velocity: int
    mean_velocity: int
    coefficient: int
    pressing: int
    kick_friction: int
    traction: int
    traction_before: int
    slip: int
    width: int


class Rows(NamedTuple):
    """Constraint rows r = k * slots + p of the contact nodes (constraint_rows.py): values [rows, width]."""

    values: Array = None
    options: Any = None

    @property
    def at(self) -> RowPlaces:
        """Where the numbers of a row stand."""
        return self.options.row_places

    @property
    def exist(self) -> bool:
        """Whether there are rows."""
        return self.values is not None


class ContactOptions(NamedTuple):
    """Compile-time choices of contact: model ("massless", "penalty", "impulse", "gaps" or ""), block (massless
    components a node), slots (obstacles that can hold one at a time), shapes of the obstacles, whether they move,
    whether their loads are summed up, friction ("", "coulomb" or "regularized"), layered: whether friction layers limit
    it, kicked: whether it acts on components with mass, viscous: whether the contact cells
    are, projected: whether MPRGP solves instead of the sweeps."""

    model: str = ""
    block: int = 1
    slots: int = 1
    shapes: tuple[str, ...] = ("plane",)
    moving: bool = False
    tracked: bool = False
    friction: str = ""
    layered: bool = False
    kick_friction: bool = False
    viscous: bool = False
    projected: bool = False

    @property
    def static_friction(self) -> bool:
        """Whether friction is part of the static solve."""
        return bool(self.friction) and self.block > 1

    @property
    def row_places(self) -> RowPlaces:
        """Where the numbers of a constraint row stand; what nothing reads has no place."""
        friction, solved = self.friction != "", self.static_friction
        kicked = friction and self.kick_friction
        sizes = {
            "gap": 1,
            "normal": 3,
            "force": 3,
            "size_squared": self.model == "massless",
            "velocity": 3 * (self.moving and (kicked or self.model == "impulse")),
            "mean_velocity": 3 * (self.moving and solved),
            "coefficient": friction,
            "pressing": friction,
            "kick_friction": 3 * kicked,
            "traction": 3 * solved,
            "traction_before": 3 * solved,
            "slip": 3 * solved,
        }
        places, width = {}, 0
        for name, size in sizes.items():
            places[name] = width if size else -1
            width += size
        return RowPlaces(**places, width=width)


class System(NamedTuple):
    """The linear problem K_KK d = right + lambda nu, stored for sweeps over lanes of nodes
    (tcontact/planning/sweep_order.py).

    pack_start [packs+1]: nodes of a pack; lane_start [packs+1]: its entries; column [entries, lanes],
    values [entries, block, block, lanes];
    inverse [block, block, k] of the diagonal blocks, stiffness [k]: their trace; right, increment [block, k];
    gaps [slots, k], normals [slots, block, k]; response [block+1, k]: D^-1 n and 1/(n D^-1 n + e) of a single
    row, with several or friction [block, k]: what the neighbours leave to a node; behind increment stand two of earlier
    sweeps. The node comes last, so that the lanes of a pack are neighbours, and there is room for LANES - 1 more.
    settings and stats [islands, ..]: static_control.py.
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


class Pairs(NamedTuple):
    """Stiffness between the contact nodes of a cell, and where it goes in the system
    (tcontact/planning/contact_graph.py).

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
