"""Table of columns: every number that a step measures and every column of the history. It is plain data.

Each number belongs to a group. The numbers of a group follow one another in the order of the table, in the sums of the
kernels and in a raw row (raw_rows.py), and are named: `sums[SUMS.sweeps]`, `node_sums[chunk * NODE_SUMS +
NODES.kinetic]`. A vector takes three places. By these names tcontact/planning/measured.py makes measured rows of raw
rows, and tcontact/run/history.py the history; a column that two groups measure is the sum of both.

    nodes, cells     sums of every chunk of the force pass; with bulk viscosity `viscous` follows `cells`, then with
                     metals `plastic`
    boundary ... friction   sums of the other parts of a step: `contact` from the contact load, `gaps` from gaps and
                     static solve
    rigid, free, part   sums over the rigid bodies that move, and pose of each obstacle and each part among them
    loads, obstacle  power of all obstacles, and load on each of them, if their loads are measured
    applied          loads other than gravity, and gravity where it is a function of time
    springs          energy, work and force of springs
    pair             loads and rows of each pair of bodies, behind all others
    host, layers, pairs, sensors   numbers that the host measures
"""

from collections import namedtuple
from typing import NamedTuple

# parts of a scene without which some columns do not exist
FRICTION, LAYERS, DAMPED, VISCOUS = "friction", "friction layers", "damping", "viscosity"
LOADS, HOURGLASS = "several or moving obstacles", "one-point hexes"
SPRINGS = "springs"
PAIRED, PLASTIC, PLASTIC_HOURGLASS = "pairs of bodies", "metals", "one-point hexes of metals"
HEATED = "friction layers of metals"
APPLIES, PULLED = "loads", "gravity as a function of time"
MISES_MAXIMUM, PRESSURE_MAXIMUM = "maxima of von Mises stress", "maxima of pressure"
PROBED = "probes"  # columns of their own, which tcontact/planning/measured.py makes
RIGID_BODIES, FREE_OBSTACLES, RIGID_PARTS = "rigid bodies that move", "obstacles that move freely", "rigid parts"
INFINITE, NAN = float("inf"), float("nan")
UNREACHED = 1e300  # gap of kernels where there is nothing to touch; the history has infinity there
RAW_ONLY = "raw-only"  # never in the history: the host computes another column from the number


class Column(NamedTuple):
    """One quantity. `groups` measure it, or `integral_of` names the measured column whose integral over time it is.

    term: the part of a scene without which it does not exist; combine: how the values of chunks, and of bodies, are
    combined; absent: its value for a body without the groups; rule: integration rule (tcontact/run/history.py);
    energy: "stored", "supplied" or "dissipated" in the energy balance; impulse: it is part of the momentum balance;
    shown: it is a column of the history.
    """

    name: str
    unit: str
    text: str
    size: int = 1
    groups: tuple[str, ...] = ()
    term: str = ""
    combine: str = "sum"
    absent: float = 0.0
    integral_of: str = ""
    rule: str = "trapezoid"
    energy: str = ""
    impulse: bool = False
    shown: bool = True


COLUMNS = (  # the columns of the history in their order, then what is measured for them
    Column("time", "s", "time of the row", 1, ("host",), combine="first"),
    Column("kinetic", "J", "kinetic energy", 1, ("nodes", "boundary", "rigid"), energy="stored"),
    Column("elastic", "J", "elastic energy of the cells", 1, ("cells",), energy="stored"),
    Column("contact", "J", "energy of the contact penalty", 1, ("contact",), energy="stored"),
    Column("friction_work", "J", "work done against friction so far", integral_of="friction_before", rule="kicks",
           energy="dissipated"),
    Column("external_work", "J", "work of loads, supports and moving obstacles so far", energy="supplied"),
    Column("energy", "J", "energy that is stored, less what was supplied, plus what was dissipated"),
    Column("energy_error", "1", "change of `energy` since the start, over the largest kinetic + elastic energy"),
    Column("contact_force", "N", "contact force on the bodies", 3, ("contact",)),
    Column("impulse", "N s", "impulse of the contact force so far", 3, integral_of="contact_force", impulse=True),
    Column("support_force", "N", "reaction of the supports", 3, ("support",)),
    Column("support_impulse", "N s", "impulse of the supports so far", 3, integral_of="support_force", impulse=True),
    Column("momentum", "kg m/s", "momentum", 3, ("nodes", "boundary", "rigid")),
    Column("angular_momentum", "kg m^2/s", "angular momentum about the origin", 3,
           ("nodes", "boundary", "rigid")),
    Column("gap_min", "m", "smallest gap of the contact set; negative: overlap; inf: nothing near", 1, ("gaps",), "",
           "min", INFINITE),
    Column("contact_nodes", "1", "number of nodes with a contact force", 1, ("contact",)),
    Column("sweeps", "1", "sweeps or products (MPRGP) of the static solve, or iterations of an implicit step", 1,
           ("gaps",), combine="max"),
    Column("static_residual", "1", "unbalanced force of the static solve, relative", 1, ("contact",), "", "max"),
    Column("hourglass", "J", "part of `elastic` in hourglass modes", 1, ("cells",), HOURGLASS),
    Column("damping_work", "J", "energy dissipated by damping so far", 1, (), DAMPED, integral_of="kinetic",
           energy="dissipated"),
    Column("damping_impulse", "N s", "impulse of the damping force so far", 3, (), DAMPED, integral_of="momentum",
           impulse=True),
    Column("viscous_work", "J", "energy dissipated by viscosity so far", 1, (), VISCOUS, integral_of="viscous_power",
           rule="step", energy="dissipated"),
    Column("plastic_work", "J", "energy dissipated by plastic flow so far", 1, (), PLASTIC,
           integral_of="plastic_step", rule="sum", energy="dissipated"),
    Column("plastic_heat", "J", "part of `plastic_work` that became heat", 1, (), PLASTIC, integral_of="heat_step",
           rule="sum"),
    Column("hourglass_work", "J", "energy dissipated as hourglass modes softened in plastic flow", 1, (),
           PLASTIC_HOURGLASS, integral_of="hourglass_step", rule="sum", energy="dissipated"),
    Column("spring_energy", "J", "elastic energy of the springs", 1, ("springs",), SPRINGS, energy="stored"),
    Column("spring_work", "J", "energy dissipated by the dashpots of springs so far", 1, (), SPRINGS,
           integral_of="spring_before", rule="kicks", energy="dissipated"),
    Column("spring_force", "N", "force of springs to the ground and to points", 3, ("springs",), SPRINGS),
    Column("spring_impulse", "N s", "impulse of that force so far", 3, (), SPRINGS, integral_of="spring_force",
           impulse=True),
    Column("temperature_max", "K", "highest temperature of a metal", 1, ("plastic",), PLASTIC, "max"),
    Column("plastic_strain_max", "1", "largest plastic strain", 1, ("plastic",), PLASTIC, "max"),
    Column("applied_force", "N", "force of the loads, without gravity", 3, ("applied",), APPLIES),
    Column("applied_impulse", "N s", "impulse of the loads so far", 3, (), APPLIES, integral_of="applied_force",
           impulse=True),
    Column("applied_work", "J", "work of the loads so far, part of `external_work`", 1, (), APPLIES,
           integral_of="applied_step", rule="sum"),
    Column("gravity_impulse", "N s", "impulse of gravity so far", 3, (), PULLED, integral_of="gravity_force",
           impulse=True),
    Column("von_mises_max", "Pa", "largest von Mises stress of a cell", 1, ("sensors",), MISES_MAXIMUM, "max"),
    Column("pressure_max", "Pa", "largest pressure of a cell", 1, ("sensors",), PRESSURE_MAXIMUM, "max", -INFINITE),
    Column("obstacle_force", "N", "force of the bodies on this obstacle", 3, ("obstacle",), LOADS),
    Column("obstacle_moment", "N m", "moment of that force about the point of the obstacle", 3, ("obstacle",), LOADS),
    Column("obstacle_position", "m", "centre of mass of this free obstacle", 3, ("free",), FREE_OBSTACLES),
    Column("obstacle_rotation", "rad", "rotation vector of this free obstacle since the start, at most pi long", 3,
           ("free",), FREE_OBSTACLES),
    Column("obstacle_velocity", "m/s", "velocity of the centre of mass of this free obstacle", 3, ("free",),
           FREE_OBSTACLES),
    Column("obstacle_angular_velocity", "rad/s", "angular velocity of this free obstacle", 3, ("free",),
           FREE_OBSTACLES),
    Column("part_position", "m", "centre of mass of this rigid part", 3, ("part",), RIGID_PARTS),
    Column("part_rotation", "rad", "rotation vector of this rigid part since the start, at most pi long", 3,
           ("part",), RIGID_PARTS),
    Column("part_velocity", "m/s", "velocity of the centre of mass of this rigid part", 3, ("part",), RIGID_PARTS),
    Column("part_angular_velocity", "rad/s", "angular velocity of this rigid part", 3, ("part",), RIGID_PARTS),
    Column("rigid_force", "N", "contact force on all free obstacles", 3, ("rigid",), RIGID_BODIES),
    Column("rigid_impulse", "N s", "impulse of the contact force on all free obstacles so far", 3, (), RIGID_BODIES,
           integral_of="rigid_force", impulse=True),
    Column("pair_force", "N", "force on the first body of this pair", 3, ("pair",), PAIRED),
    Column("pair_moment", "N m", "moment of that force about the origin", 3, ("pair",), PAIRED),
    Column("pair_gap_min", "m", "smallest gap of a row of this pair; inf: no row", 1, ("pair",), PAIRED, "min",
           INFINITE),
    Column("pair_rows", "1", "constraint rows of this pair", 1, ("pair",), PAIRED),
    Column("pair_pressed", "1", "constraint rows of this pair with a force", 1, ("pair",), PAIRED),
    Column("pair_rebuilds", "1", "times that the rows of all pairs were built so far", 1, ("pairs",), PAIRED),
    Column("solver_products", "1", "products of the static solve of pairs", 1, ("pairs",), PAIRED, "max"),
    Column("layer_heat", "J", "heat in the friction layers", 1, ("layers",), LAYERS),
    Column("obstacle_heat", "J", "heat that went from the friction layers into the obstacles so far", 1, ("layers",),
           LAYERS),
    Column("body_heat", "J", "heat that went from the friction layers into the cells of the bodies so far", 1,
           ("layers",), HEATED),
    Column("layer_temperature_max", "K", "hottest surface of a friction layer", 1, ("layers",), LAYERS, "max"),
    Column("layer_shear_min", "Pa", "lowest shear stress of a sliding layer", 1, ("layers",), LAYERS, "fmin", NAN),
    Column("layer_error", "1", "estimated error of a layer step, in stress and surface temperature", 1, ("layers",),
           LAYERS, "max"),
    Column("layer_substeps", "1", "layer steps in a mechanical step", 1, ("layers",), LAYERS, "max"),
    Column("mass_displacement", "kg m", "sum of m u over the ordinary nodes", 3, ("nodes",), RAW_ONLY, shown=False),
    Column("applied_step", "J", "work of the loads in the step before", 1, ("applied",), APPLIES, shown=False),
    Column("applied_kick", "J", "kinetic energy that the loads give nodes at rest in half a step", 1, ("applied",),
           APPLIES, shown=False),
    Column("gravity", "m/s^2", "gravity of the level", 3, ("applied",), RAW_ONLY, shown=False),
    Column("half_step", "s", "half the step that ended at the level", 1, ("applied",), RAW_ONLY, shown=False),
    Column("gravity_kick", "J", "the same for gravity", 1, ("host",), PULLED, shown=False),
    Column("gravity_force", "N", "gravity times mass", 3, ("host",), PULLED, shown=False),
    Column("gravity_power", "W", "power of gravity", 1, ("host",), PULLED, shown=False),
    Column("gravity_work", "J", "work of gravity so far", 1, (), PULLED, integral_of="gravity_power", shown=False),
    Column("load_work", "J", "work of the dead loads", 1, ("boundary", "rigid"), shown=False),
    Column("support_power", "W", "power of the supports", 1, ("support",), shown=False),
    Column("support_work", "J", "work of the supports so far", integral_of="support_power", shown=False),
    Column("jacobian_min", "1", "smallest det F", 1, ("cells",), "", "min", shown=False),
    Column("rigid_rate", "1/s^2", "square of the largest frequency of a rigid body on its contact cells", 1,
           ("rigid",), RIGID_BODIES, "max", shown=False),
    Column("viscous_power", "W", "power dissipated in the step before", 1, ("viscous",), VISCOUS, shown=False),
    Column("viscous_rate", "1/s", "largest rate of a viscous cell", 1, ("viscous",), VISCOUS, "max", shown=False),
    Column("plastic_step", "J", "plastic work of the step before", 1, ("plastic",), PLASTIC, shown=False),
    Column("heat_step", "J", "heat of plastic flow of that step", 1, ("plastic",), PLASTIC, shown=False),
    Column("hourglass_step", "J", "energy let go by hourglass modes", 1, ("plastic",), PLASTIC_HOURGLASS, shown=False),
    Column("friction_before", "J", "work of friction up to the row", 1, ("friction",), FRICTION, shown=False),
    Column("friction_after", "J", "work of friction in the kick after it", 1, ("friction",), FRICTION, shown=False),
    Column("spring_before", "J", "work of dashpots up to the row", 1, ("springs",), SPRINGS, shown=False),
    Column("spring_after", "J", "work of dashpots in the kick after it", 1, ("springs",), SPRINGS, shown=False),
    Column("obstacle_power", "W", "power of the obstacles on the bodies", 1, ("loads",), LOADS, shown=False),
    Column("obstacle_work", "J", "work of obstacles so far", 1, (), LOADS, integral_of="obstacle_power", shown=False),
)  # fmt: skip


SHARED = ("boundary", "support", "contact", "gaps")  # groups of `sums`; only bodies with contact have the last two


def group_columns(*groups: str) -> list[Column]:
    """Return the columns of these groups, one group after the other."""
    return [column for group in groups for column in COLUMNS if group in column.groups]


def group_size(*groups: str) -> int:
    """Return how many numbers the groups have."""
    return sum(column.size for column in group_columns(*groups))


def places(*groups: str, start: int = 0):
    """Return the first place of every column, as attributes, in an array that holds these groups from `start` on."""
    columns = group_columns(*groups)
    starts = [start + sum(column.size for column in columns[:number]) for number in range(len(columns))]
    return namedtuple("Places", [column.name for column in columns])(*starts)


def cell_groups(viscous: bool, plastic: bool = False) -> tuple[str, ...]:
    """Return the groups that every chunk has in `cell_sums`."""
    return ("cells", *(("viscous",) if viscous else ()), *(("plastic",) if plastic else ()))


def loads_place(friction: bool) -> int:
    """Return where the loads of obstacles begin in `sums`: power of all, then force and moment on each of them."""
    return group_size(*SHARED, *(("friction",) if friction else ()))


def raw_places(viscous: bool, plastic: bool = False):
    """Return the first place of every column in a raw row, as attributes of `nodes`, `cells` and `shared`."""
    groups = cell_groups(viscous, plastic)
    cells, shared = NODE_SUMS, NODE_SUMS + group_size(*groups)
    parts = NODES, places(*groups, start=cells), places(*SHARED, "friction", start=shared)
    return namedtuple("RawPlaces", "nodes cells shared")(*parts)


# places in `node_sums` and `cell_sums` of a chunk, and how many numbers a chunk has
NODES, NODE_SUMS = places("nodes"), group_size("nodes")
CELLS, CELL_SUMS = places("cells", "viscous"), group_size("cells")
# places in `sums`, which the other parts of a step share: of each column, and of the first number of each group
SUMS = places(*SHARED, "friction")
FIRST = namedtuple("First", SHARED)(*(group_size(*SHARED[:number]) for number in range(len(SHARED))))
# places within one group, and how many numbers it has
BOUNDARY, BOUNDARY_SUMS = places("boundary"), group_size("boundary")
SUPPORT, SUPPORT_SUMS = places("support"), group_size("support")
CONTACT = places("contact")
OBSTACLE_LOAD, OBSTACLE_LOADS = places("obstacle"), group_size("obstacle")
RIGID, RIGID_SUMS = places("rigid"), group_size("rigid")
ROW_POSE, ROW_POSE_SIZE = places("free"), group_size("free")
PAIR_LOAD, PAIR_LOADS = places("pair"), group_size("pair")
APPLIED = places("applied")
SPRING, SPRING_SUMS = places("springs"), group_size("springs")
