"""Massless contact nodes before and after the static solve: prediction, and contact force of the step (METHOD 2).

    x_K^{n+1} ~ x_K^n + (x_K^n - x_K^{n-1}) + g dt^2,   then moved out of obstacles
    lambda_k = max(0, nu . (f_k(x^n) - f_ext,k))   where the constraint is active

The static residual in the history is, over F_ref, the largest force that is unbalanced, that exceeds the friction
limit, or that would remove a remaining overlap. Forces that the static solve leaves unbalanced are applied to the nodes
that carry the mass of the contact node, like its loads: momentum is conserved at any residual.
"""

from ..columns import SUMS
from ..contact.constraint_rows import normal_of, set_number, set_vector, sum_of_rows, vector_of
from ..contact.islands import first_node, island_count, node_count
from ..contact.local_contact import multipliers
from ..contact.pair_rows import entry, is_slave, pair_row, press_masters
from ..engine import ti
from ..language.counted import counted
from ..language.entries import row
from ..language.threads import item, item_between, leader, meet, over_threads, put_sums, turns, turns_between
from ..pair_places import ROWS, SLAVES
from .control import F_REF, LEFT, LINEAR, SETTINGS, STALE, STATS, SWEEPS, TOLERANCE
from .massless_node import along, balance, constraint_violation, constraints, in_space, largest, segment
from .sliding import friction_limit

# the last solve of a step is not measured before the next step: a tangent that left more than this ratio of the
# tolerance there is renewed, since what it leaves grows from step to step
CLOSE_TO_TOLERANCE = 0.25


@ti.func
def predict(body: ti.template(), contact: ti.template(), ratio, fall):
    """Predict x_K = x_K^n + (x_K^n - x_K^{n-1}) ratio + fall in the massless components.

    fall = g dt^2 makes the prediction exact in free flight. `displacement_before` becomes the displacement x_K^n.
    """
    for turn in range(turns(contact, node_count(contact))):
        predict_node(body, contact, ratio, fall, item(contact, turn))
    meet(contact)


@ti.func
def predict_node(body: ti.template(), contact: ti.template(), ratio, fall, k):
    """Predict the massless components of node k."""
    block = ti.static(contact.options.block)
    now = along(contact, k, row(body.u, contact.nodes[k]))
    step = ratio * (now - segment(contact.displacement_before, k, block)) + along(contact, k, fall)
    move_node(body, contact, k, in_space(contact, k, step))
    for j in ti.static(range(block)):
        contact.displacement_before[k * block + j] = now[j]


@ti.func
def move_out(body: ti.template(), contact: ti.template(), rows: ti.template()):
    """Move the predicted nodes out of the obstacles they overlap, by the shortest displacement."""
    for turn in range(turns(contact, node_count(contact))):
        move_node_out(body, contact, rows, item(contact, turn))
    meet(contact)


@ti.func
def move_node_out(body: ti.template(), contact: ti.template(), rows: ti.template(), k):
    """Move node k until no row of it has a negative gap."""
    block, slots = ti.static(contact.options.block, contact.options.slots)
    normals, gaps = constraints(contact, rows, k, block, slots)
    if gaps.min() < 0.0:
        free = ti.Vector.zero(ti.f64, block)
        identity = ti.Matrix.identity(ti.f64, block)
        lengths = multipliers(free, normals, gaps, identity, 0.0, slots)
        move_node(body, contact, k, in_space(contact, k, normals.transpose() @ lengths))


@ti.func
def move_node(body: ti.template(), contact: ti.template(), k, step):
    """Add a step [3] to the displacement of node k."""
    for j in ti.static(range(3)):
        place = 3 * contact.nodes[k] + j
        body.u[place] = body.u[place] + step[j]


@ti.func
def massless_load(
    body: ti.template(),
    boundary: ti.template(),
    contact: ti.template(),
    rows: ti.template(),
    coupling: ti.template(),
    system: ti.template(),
):
    """Set the force of every row from the force pass of the step; sum up penalty energy, residual and sweeps.

    Slaves of pairs come first, before their masters, which the force of their rows acts on too.
    """
    energy, worst, sweeps = 0.0, 0.0, 0.0
    for island in range(island_count(contact)):
        energy, residual = load_of_island(body, boundary, contact, rows, coupling, system, island, energy)
        residual = over_threads(contact, [residual], ("max",))[0]
        worst = ti.max(worst, note_remaining(contact, system, island, residual))
        sweeps = ti.max(sweeps, system.stats[island * STATS + SWEEPS])
    if ti.static(contact.options.threads > 1):
        meet(contact)
        energy = over_threads(contact, [energy], ("sum",))[0]
        receive_shares(body, boundary, contact)
    contact.sums[SUMS.contact] = energy
    contact.sums[SUMS.static_residual] = worst
    contact.sums[SUMS.sweeps] = sweeps


@ti.func
def share_load(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), system: ti.template()
):
    """Set the force of every row by several blocks of threads.

    A later launch adds the shares that nodes receive; the residual [N] of each island stands behind the sums.
    """
    energy = 0.0
    for island in range(island_count(contact)):
        energy, residual = load_of_island(body, boundary, contact, rows, None, system, island, energy)
        put_sums(contact, None, [contact.sums.shape[0] + island], [residual], ("max",))
    put_sums(contact, None, (SUMS.contact,), [energy], ("sum",))


@ti.func
def load_of_island(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), coupling: ti.template(),
    system: ti.template(), island, energy,
):  # fmt: skip
    """Set the row forces of an island; return `energy` with that of its penalty [J], and the residual [N].

    Both are those of the nodes of this thread.
    """
    total, residual = energy, 0.0
    slaves = 0
    if ti.static(contact.options.coupled and contact.options.threads == 1):
        slaves = coupling.lists[ROWS]
    elif ti.static(contact.options.coupled):  # one thread takes the slaves, one after another
        meet(contact)
        if leader(contact) == 1:
            for back in range(coupling.lists[ROWS]):
                r = coupling.lists[ROWS] - 1 - back
                k = entry(coupling, SLAVES, r)
                stored, left = massless_load_node(body, boundary, contact, rows, system, k)
                total += stored
                residual = ti.max(residual, left)
                force = vector_of(rows, pair_row(rows, k), rows.at.force)
                press_masters(coupling, body.special_force, r, force)
        meet(contact)
    begin = first_node(contact, island) - slaves
    for turn in range(turns_between(contact, begin, first_node(contact, island + 1))):
        k = item_between(contact, begin, turn)
        r, comes = first_node(contact, island) - 1 - k, 1
        if ti.static(contact.options.coupled):
            if r >= 0:
                k = entry(coupling, SLAVES, r)
            else:
                comes = ti.select(is_slave(coupling, k), 0, 1)
        if comes == 1:
            stored, left = massless_load_node(body, boundary, contact, rows, system, k)
            total += counted(contact, k) * stored
            residual = ti.max(residual, left)
            if ti.static(contact.options.coupled):
                if r >= 0:
                    force = vector_of(rows, pair_row(rows, k), rows.at.force)
                    press_masters(coupling, body.special_force, r, force)
    return total, residual


@ti.func
def note_remaining(contact: ti.template(), system: ti.template(), island, residual):
    """Return the residual [N] of an island over its force scale; it renews the tangent where this is large."""
    remaining = residual / ti.max(system.stats[island * STATS + F_REF], 1e-300)
    if ti.static(not contact.options.coupled):
        left_unmeasured = system.settings[island * SETTINGS + LEFT] > 0.0
        if left_unmeasured and system.settings[island * SETTINGS + LINEAR] == 0.0:
            stale = remaining > CLOSE_TO_TOLERANCE * system.settings[island * SETTINGS + TOLERANCE]
            if stale and leader(contact) == 1:
                system.stats[island * STATS + STALE] = 1.0
    return remaining


@ti.func
def receive_shares(body: ti.template(), boundary: ti.template(), contact: ti.template()):
    """Add to every boundary node the shares that it receives, in the order of the contact nodes."""
    for turn in range(turns(contact, boundary.nodes.shape[0])):
        s = item(contact, turn)
        for i in range(contact.residual_donors[s], contact.residual_donors[s + 1]):
            for j in ti.static(range(3)):
                share = contact.residual_shares[3 * contact.residual_donors[i] + j]
                body.special_force[3 * s + j] = body.special_force[3 * s + j] + share
    meet(contact)


@ti.func
def massless_load_node(
    body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(), system: ti.template(), k
):
    """Set the row forces of node k; return the energy of its penalty [J] and its largest unbalanced force [N]."""
    block, slots = ti.static(contact.options.block, contact.options.slots)
    normals, gaps = constraints(contact, rows, k, block, slots)
    out_of_balance = along(contact, k, row(body.special_force, k) - row(boundary.load, k))
    if ti.static(contact.options.static_friction):
        out_of_balance = out_of_balance - along(contact, k, sum_of_rows(rows, k, rows.at.traction))
    pressing, rest = balance(out_of_balance, normals, contact.active[k], block, slots)
    off = system.stiffness[k] * constraint_violation(contact, rows, k, gaps, pressing, slots)
    energy = 0.0
    for p in ti.static(range(slots)):
        r = k * slots + p
        force = ti.Vector.zero(ti.f64, 3)
        if pressing[p] > 0.0:
            force = pressing[p] * normal_of(rows, r)
            if ti.static(contact.options.static_friction):
                friction = vector_of(rows, k * slots + p, rows.at.traction)
                off = ti.max(off, friction.norm() - friction_limit(contact, rows, k, p, pressing))
                force += friction
            energy += 0.5 * contact.compliance[k] * pressing[p] * pressing[p]
        elif ti.static(contact.options.static_friction):
            rest += along(contact, k, vector_of(rows, k * slots + p, rows.at.traction))
        set_vector(rows, r, rows.at.force, force)
        if ti.static(rows.at.pressing >= 0):
            set_number(rows, k * slots + p, rows.at.pressing, pressing[p])
    begin, end = contact.residual_receivers[k], contact.residual_receivers[k + 1]
    share = in_space(contact, k, rest)
    if ti.static(not contact.options.shared):
        share = share / ti.max(1.0, float(end - begin))
    if ti.static(contact.options.threads > 1 or contact.options.shared):  # the receivers add up the shares afterwards
        for j in ti.static(range(3)):
            contact.residual_shares[3 * k + j] = share[j]
    elif largest(share) > 0.0:  # where only normal components are massless, a closed node leaves nothing
        for i in range(begin, end):
            for j in ti.static(range(3)):
                place = 3 * contact.residual_receivers[i] + j
                body.special_force[place] = body.special_force[place] + share[j]
    return energy, ti.max(largest(rest), off)
