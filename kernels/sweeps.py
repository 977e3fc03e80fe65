"""Projected block Gauss-Seidel over the contact nodes, several nodes of one colour at a time (METHOD 2).

    d_k <- d_k + omega (D_k^-1 (r_k - sum_j K_kj d_j) - d_k),  then onto  g_k + n_k . d_k + e lambda_k >= 0
    in the norm of D_k

Over-relaxation omega in [1, 2) keeps the convergence of the projected method for symmetric positive K (Cryer 1971).
The defect of a sweep is the largest change of a node times its stiffness: the residual before its update, so it is on
the safe side of the residual that is left.
"""

import taichi as ti

from .lanes import SWEEP_LANES as LANES
from .local_contact import multipliers
from .massless_node import basis_of, block_of, segment, settle
from .static_control import (
    AIM,
    BEFORE,
    CONTRACTION,
    F_REF,
    LAST_SWEEP,
    LEAST_SWEEPS,
    LINEAR,
    MOST_SWEEPS,
    POLISHING_SWEEPS,
    REACH,
    RELAXATION,
    RESIDUAL,
    ROUNDING,
    SWEEPS,
    TODO,
    TOLERANCE,
)
from .static_friction import update_sliding
from .vectors import MASK

STALLED = 0.7  # sweeps that leave more than this share of a residual that may be rounding have met it
FORCING = 0.3  # of the residual that the law's nonlinearity will leave anyway
FEWEST = 2  # sweeps of a linearisation


@ti.func
def prepare(touching: ti.template(), system: ti.template(), block: ti.template()):
    """push: D^-1 n and 1/(n D^-1 n + e) of every node, for a single obstacle."""
    for k in range(touching.nodes.shape[0]):
        normal = segment(system.normals, k, block)
        push = block_of(system.inverse, k, block) @ normal
        give = normal.dot(push) + touching.give[k]
        for j in ti.static(range(block)):
            system.push[k * (block + 1) + j] = push[j]
        system.push[k * (block + 1) + block] = ti.select(give > 0.0, 1.0 / ti.max(give, 1e-300), 0.0)


@ti.func
def update(touching: ti.template(), system: ti.template(), k, rest, block: ti.template(), slots: ti.template()):
    """The node's own contact problem, solved exactly for the given rest = r_k - sum_j K_kj d_j; returns the defect."""
    old = segment(system.increment, k, block)
    flexible = block_of(system.inverse, k, block)
    free = old + system.settings[RELAXATION] * (flexible @ rest - old)
    d = free
    mask = 0
    if ti.static(slots == 1):
        violation = 0.0 - system.gaps[k]
        for j in ti.static(range(block)):
            violation -= system.normals[k * block + j] * free[j]
        pressing = ti.max(0.0, violation) * system.push[k * (block + 1) + block]
        if pressing > 0.0:
            mask = 1
        for j in ti.static(range(block)):
            d[j] = free[j] + pressing * system.push[k * (block + 1) + j]
    else:
        normals = ti.Matrix(
            [
                [system.normals[(k * slots + p) * block + j] for j in ti.static(range(block))]
                for p in ti.static(range(slots))
            ]
        )
        gaps = ti.Vector([system.gaps[k * slots + p] for p in ti.static(range(slots))])
        if (gaps + normals @ free).min() < 0.0:
            pressing = multipliers(free, normals, gaps, flexible, touching.give[k], slots)
            d = free + flexible @ (normals.transpose() @ pressing)
            for p in ti.static(range(slots)):
                if pressing[p] > 0.0:
                    mask += 1 << p
    return settle(touching, system, k, d, mask, block)


@ti.func
def sweep_once(touching: ti.template(), system: ti.template(), block: ti.template(), slots: ti.template()):
    """One pass over the nodes, colour by colour; returns the largest defect [N]."""
    defect = 0.0
    for pack in range(system.lane_start.shape[0] - 1):
        zero = ti.Vector([0.0 for _ in range(LANES)])
        rest = [zero for _ in range(block)]
        for entry in range(system.lane_start[pack], system.lane_start[pack + 1]):
            # the masks tell the compiler that further indices cannot overflow: whole vectors are loaded
            here = (entry * LANES) & MASK
            there = [(block * system.column[here + lane]) & MASK for lane in range(LANES)]
            start = (entry * block * block * LANES) & MASK
            for j in ti.static(range(block)):
                moved = ti.Vector([system.increment[i + j] for i in there])
                for i in ti.static(range(block)):
                    first = (i * block + j) * LANES
                    rest[i] += ti.Vector([system.values[start + (first + lane)] for lane in range(LANES)]) * moved
        for lane in ti.static(range(LANES)):
            k = system.lane_node[pack * LANES + lane]
            if k >= 0:
                own = ti.Vector([system.right[k * block + i] - rest[i][lane] for i in range(block)])
                if ti.static(slots == 1 and not touching.kinds.static_friction):
                    defect = ti.max(defect, update(touching, system, k, own, block, slots))
                else:
                    for i in ti.static(range(block)):
                        system.push[k * block + i] = own[i]
        if ti.static(slots > 1 or touching.kinds.static_friction):  # too much code for a copy per lane
            for lane in range(LANES):
                k = system.lane_node[pack * LANES + lane]
                if k >= 0:
                    own = segment(system.push, k, block)
                    if ti.static(touching.kinds.static_friction):
                        defect = ti.max(defect, update_sliding(touching, system, k, own, block, slots))
                    else:
                        defect = ti.max(defect, update(touching, system, k, own, block, slots))
    return defect


@ti.func
def sweep(touching: ti.template(), system: ti.template(), block: ti.template(), slots: ti.template()):
    """Sweeps until the linearised problem is solved as far as it is worth; stats[SWEEPS] counts them.

    Down to the tolerance a solve may take MOST_SWEEPS, on to the smaller aim only POLISHING_SWEEPS: where compression
    makes K_KK lose definiteness, endless sweeps would follow the unstable mode.
    """
    stats, settings = ti.static(system.stats, system.settings)
    for i in range(touching.nodes.shape[0] * block):
        system.increment[i] = 0.0
    if ti.static(slots == 1 and not touching.kinds.static_friction):
        prepare(touching, system, block)
    least, aim = settings[LEAST_SWEEPS], settings[AIM]
    if settings[LINEAR] == 0.0:
        if stats[TODO] == LAST_SWEEP:
            least = ti.max(FEWEST, least - stats[SWEEPS])
        else:
            least = ti.select(stats[SWEEPS] == 0.0, 0.5 * least, 1.0 * FEWEST)
            aim = ti.max(aim, FORCING * stats[CONTRACTION] * stats[RESIDUAL])
    bound = ti.max(settings[TOLERANCE], stats[ROUNDING])
    done, residual, stalled = 0.0, 1e300, 0
    while (
        done < least
        or (done < settings[POLISHING_SWEEPS] and residual > aim and stalled == 0)
        or (done < settings[MOST_SWEEPS] and residual > bound)
    ):
        before = residual
        residual = sweep_once(touching, system, block, slots) / stats[F_REF]
        done += 1.0
        if residual > STALLED * before and residual <= stats[ROUNDING]:
            stalled = 1
    stats[SWEEPS] = stats[SWEEPS] + done
    if settings[LINEAR] == 1.0:
        stats[BEFORE], stats[RESIDUAL] = stats[RESIDUAL], residual


@ti.func
def move(u: ti.template(), touching: ti.template(), system: ti.template(), block: ti.template()):
    """x_K += B d; no node further than the reach: from gaps >= 0 a part of a feasible increment is feasible."""
    longest = 0.0
    for k in range(touching.nodes.shape[0]):
        longest = ti.max(longest, segment(system.increment, k, block).norm())
    part = ti.min(1.0, system.settings[REACH] / ti.max(longest, 1e-300))
    for k in range(touching.nodes.shape[0]):
        step = part * (basis_of(touching.basis, k, block) @ segment(system.increment, k, block))
        for j in ti.static(range(3)):
            place = 3 * touching.nodes[k] + j
            u[place] = u[place] + step[j]
