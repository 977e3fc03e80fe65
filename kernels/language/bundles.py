"""Bundles: the named arrays of a step, grouped by what they describe; signatures.py makes kernel signatures from them.

The annotation of a field says what it is: Array (float64), Index (int32), Shared (one Array for all bundles with this
field); any other annotation marks a compile-time option. The host fills the same bundles; a field that a scene does not
have is None. In the shapes below n are nodes, s boundary nodes, k contact nodes, r constraint rows, p pairs.
"""

from typing import Any, NamedTuple

from ..lanes import BLOCK_NUMBERS, DEVICE_BLOCK
from .arguments import Array, Index, Shared


class Body(NamedTuple):
    """Arrays of the force pass (cell_phase.py, node_phase.py).

    u, v [n, 3] [m, m/s]; connectivity, chunk_table, segments: packed cells (cell_phase.py); corner_rows: force rows of
    contact cells at each boundary node; node_info [n]: chunks and boundary number of a node (lanes.py); position [n, 3]
    [m] at rest, behind it the stored shapes [pack, number, lane] of cells (elements/record.py); mass [n] [kg]; params:
    lanes.py; rows: force rows [.., 3]; special_force [s, 3]: internal less contact force; node_sums, cell_sums:
    columns.py; memory [pack, point, number, lane]: state of the quadrature points
    (point_memory.py); volume_lists, volumes: of cells whose volume change is averaged at nodes (node_volumes.py);
    bulk_viscosity: of metals in contact cells: their first lane, displacements [s, 3] of the massless nodes at the last
    time level, rate of every lane over the step times the density (viscous_tangent.py).
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
    volume_lists: Index = None
    volumes: Array = None
    bulk_viscosity: Array = None

    @property
    def averaged(self) -> bool:
        """Return whether some cells have their volume change averaged at nodes."""
        return self.volumes is not None

    @property
    def viscous_metal(self) -> bool:
        """Return whether bulk viscosity acts in contact cells of metals."""
        return self.bulk_viscosity is not None


class DeviceLists(NamedTuple):
    """Arrays of steps on a GPU beside those of the body (kernels/step/device_step.py).

    parts: for every kind of cells its first part, then the end of all, then the parts (lanes.py); node_corners: start
    of the corners of every node [n + 1], then the places of these corners in `connectivity`, ascending;
    corner_forces [pack, corner, component, lane]; partial_sums [number, thread] of one step; ledger: sums of the rows
    of a block of steps in stages (device_ledger.py). With contact: contact_parts: as parts, of the contact cells alone;
    control: what the device does next, and the sums of the boundary nodes of every row (step/device_control.py).
    """

    parts: Index = None
    node_corners: Index = None
    corner_forces: Array = None
    partial_sums: Array = None
    ledger: Array = None
    contact_parts: Index = None
    control: Array = None


class Boundary(NamedTuple):
    """Boundary nodes, the contact nodes first: nodes [s], mass and inverse tensors [s, 6], load [s, 3] = f_ext.

    Behind f_ext stand the data of loads other than constant gravity, if there are any (load_places.py).
    Behind the mass tensors stand the numbers of springs, if there are any (nodes/springs.py).
    Where threads share the loads (nodes/shared_loads.py): load_sources: what acts on each loaded node; load_shares
    [faces, 4, 3] [N]: of the corners of the faces under a pressure.
    sums: sums of all parts of a step except the force pass, at the places of columns.py; all bundles share this array.
    """

    nodes: Index = None
    mass: Array = None
    inverse_mass: Array = None
    load: Array = None
    load_sources: Index = None
    load_shares: Array = None
    sums: Shared = None


class Supports(NamedTuple):
    """Prescribed components: 3 * boundary node + axis, velocity [m/s]; sums: reaction and power.

    driven: functions of time drive some of them, whose table is behind these numbers (nodes/driven_supports.py).
    """

    components: Index = None
    speeds: Array = None
    sums: Shared = None
    driven: Any = None


class LayerOptions(NamedTuple):
    """Compile-time options of friction layers that a GPU steps (layer/device_layers.py).

    plain: all have one side; several: some nodes may slide on several metals.
    """

    plain: bool = True
    several: bool = False


class LayerCells(NamedTuple):
    """State of the friction layers of a batch (layer/layer1d.py), and the room in which they are solved."""

    rise: Array = None
    growth: Array = None
    hardening: Array = None
    carried: Array = None
    cells: Array = None
    scratch: Array = None


class Coupling(NamedTuple):
    """Rows of pairs of bodies (pair_rows.py): lists and values, with the places of pair_places.py."""

    lists: Index = None
    values: Array = None


class Contact(NamedTuple):
    """Contact nodes and their forces; the partners in contact appear only in constraint rows (constraint_rows.py).

    nodes [k + m]: the contact nodes, then the m nodes of the contact set that have no rows; reference [k + m, 3] [m]:
    positions at rest, relative to a point among them; islands: islands.py; force [k, 3] [N]: contact force;
    penalty_stiffness [k] [N/m]: kappa A_k of nodes with mass; compliance [k] [m/N]: its inverse for massless nodes, 0
    for the exact constraint; friction: settings and numbers of every node (friction.py); options: ContactOptions.
    Of massless nodes only: active [k]: bit mask of the rows in contact; basis [k, 3, block]: massless directions;
    displacement_before [k, block]: in these, at the last time level; residual_receivers: the boundary nodes on which
    the unbalanced force of the static solve acts, those of node k at residual_receivers[k] .. residual_receivers[k+1].
    Where threads share the loops: shared: values of every thread (threads.py); residual_donors: the transposed list,
    the contact nodes whose share acts on boundary node s at residual_donors[s] .. residual_donors[s+1];
    residual_shares [k, 3] [N]: of each receiver of node k; of several blocks of threads also partial [number, block]:
    sums of every block; place: number of the thread. Where other ranks have copies of nodes: counted [s]: 1.0 for the
    boundary nodes that the sums of this rank count, else 0.0 (counted.py); residual_shares [k, 3] [N]: of all receivers
    of node k together. Where a GPU steps friction layers: layers, layer_lists, layer_tables: layer_places.py; pairs of
    bodies: pair_lists, pair_values: as in `Coupling`.
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
    shared: Array = None
    residual_donors: Index = None
    residual_shares: Array = None
    counted: Array = None
    partial: Array = None
    place: Any = None
    layers: Array = None
    layer_lists: Index = None
    layer_tables: Array = None
    pair_lists: Index = None
    pair_values: Array = None
    options: Any = None

    @property
    def coupling(self) -> Coupling:
        """Return the rows of pairs of bodies that a GPU steps."""
        return Coupling(self.pair_lists, self.pair_values)

    @property
    def copied(self) -> bool:
        """Return whether other ranks have copies of its nodes."""
        return self.counted is not None

    @property
    def placed(self) -> bool:
        """Return whether the number of the thread is given."""
        return self.place is not None

    def at_place(self, blocks: int, place: Any) -> "Contact":
        """Return the bundle for a thread of a launch of several blocks."""
        options = self.options._replace(threads=blocks * DEVICE_BLOCK, blocks=blocks)
        return self._replace(options=options, place=place)


class Obstacles(NamedTuple):
    """Rigid obstacles (obstacles.py); candidates [k, slots]: the obstacle of each constraint row."""

    records: Array = None
    motion: Array = None
    candidates: Index = None
    options: Any = None


class Rigid(NamedTuple):
    """Rigid bodies that move freely or carry nodes (rigid_places.py): values; ties [t, 2]: body and boundary node."""

    values: Array = None
    ties: Index = None
    sums: Shared = None

    @property
    def exist(self) -> bool:
        """Return whether there are rigid bodies."""
        return self.values is not None

    @property
    def tied(self) -> bool:
        """Return whether nodes move with some of them."""
        return self.ties is not None


class RowPlaces(NamedTuple):
    """Places of the numbers of a constraint row in `values` [r, width]; -1: the scene does not need this number.

    gap [m]; size_squared [m^2]: square of the lengths whose difference the gap is; normal (3) into the body; velocity
    (3) [m/s]: of the partner at the node, now; mean_velocity (3): over the last step; force (3) [N]: on the node,
    without kick_friction (3) [N], the friction of the kick. With friction: coefficient; pressing [N]: lambda. With
    friction in the static solve: traction (3) [N]: friction force now; traction_before (3): one step before; slip (3)
    [m]: since then. Rows of pairs beside those of obstacles: lift (3), motion of the slave for a unit normal motion of
    its masters, in its massless components. Where the coefficient varies (friction_laws.py): shear_limit [N]: largest
    friction of the law; slip_speed [m/s] of the step before; law: number of the law of the partner. With blocks as
    obstacles: face: number of that at which the node is (obstacle_shapes.py).
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
    lift: int
    shear_limit: int
    slip_speed: int
    law: int
    face: int
    width: int


class Rows(NamedTuple):
    """Constraint rows r = k * slots + p of the contact nodes (constraint_rows.py): values [r, width]."""

    values: Array = None
    options: Any = None

    @property
    def at(self) -> RowPlaces:
        """Return the places of the numbers of a row."""
        return self.options.row_places

    @property
    def exist(self) -> bool:
        """Return whether there are rows."""
        return self.values is not None


class ContactOptions(NamedTuple):
    """Compile-time options of contact.

    model: "massless", "penalty", "impulse", "gaps" or ""; block: massless components of a node; slots: rows of a node;
    shapes: of the obstacles; moving: they move; tracked: their loads are summed up; friction: "", "coulomb" or
    "regularized"; layered: friction layers limit it; kick_friction: it acts on components with mass; viscous: the
    contact cells are viscous; projected: MPRGP solves instead of the sweeps; coupled: bodies are in contact with each
    other; plain: the basis of every massless node is the identity; varied: the
    coefficients of friction of the rows change in the run; recorded: slip and friction work of every node are summed up
    for frames (friction_record.py); free: some obstacles move freely; posed: the host places others for every step;
    threads: that share the loops (threads.py), in so many blocks; shared: ranks share the static solve, whose phases
    the host launches (step/rank_solve.py); layers: of friction layers that a GPU steps.
    """

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
    coupled: bool = False
    plain: bool = False
    varied: bool = False
    recorded: bool = False
    free: bool = False
    posed: bool = False
    threads: int = 1
    blocks: int = 1
    shared: bool = False
    layers: LayerOptions | None = None

    @property
    def block_threads(self) -> int:
        """Return the threads of a block."""
        return self.threads // self.blocks

    @property
    def groups(self) -> int:
        """Return how many threads of a block combine the values of one number."""
        return self.block_threads // BLOCK_NUMBERS

    @property
    def obstacle_slots(self) -> int:
        """Return how many rows of a node are those of obstacles; the last one of a body in pairs belongs to these."""
        return self.slots - 1 if self.coupled else self.slots

    @property
    def bounds(self) -> int:
        """Return the largest number of rows that bound a node in one linear problem."""
        return 1 if self.static_friction else min(self.slots, self.block)

    @property
    def static_friction(self) -> bool:
        """Return whether friction is part of the static solve."""
        return bool(self.friction) and self.block > 1

    @property
    def friction_in_lanes(self) -> bool:
        """Return whether sweeps solve the friction of several nodes at once: with one row each, by Coulomb's law."""
        one = self.slots == 1 and self.threads == 1
        return self.static_friction and one and self.friction == "coulomb" and not self.coupled

    @property
    def row_places(self) -> RowPlaces:
        """Return the places of the numbers of a constraint row; numbers that no kernel reads have none."""
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
            "lift": 3 * (self.coupled and self.slots > 1 and not solved and self.model == "massless"),
            "shear_limit": self.varied,
            "slip_speed": self.varied,
            "law": self.varied,
            "face": "box" in self.shapes,
        }
        places, width = {}, 0
        for name, size in sizes.items():
            places[name] = width if size else -1
            width += size
        return RowPlaces(**places, width=width)


class RankLaunch(NamedTuple):
    """Arrays of a phase of a static solve that ranks share (step/rank_solve.py): see rank_phases.py.

    viscous_cells: as in `Launch`.
    """

    control: Array = None
    measured: Array = None
    viscous_cells: Array = None


class Launch(NamedTuple):
    """Arrays of one launch of the serial kernel (serial_step.py): control, raw_out [rows, width] (raw_rows.py).

    viscous_cells: data of viscous contact cells (cell_viscosity.py); images: of a periodic body (images.py); samples:
    motion of the nodes that probes and maxima need (samples.py).
    """

    viscous_cells: Array = None
    images: Index = None
    samples: Array = None
    control: Array = None
    raw_out: Array = None

    @property
    def sampled(self) -> bool:
        """Return whether the rows of a launch leave samples."""
        return self.samples is not None
