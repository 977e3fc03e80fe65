"""Forces on the contact nodes of a pack that the motion of their neighbours causes, for both static solvers."""

from ..engine import ti
from ..lanes import SWEEP_LANES as LANES
from ..language.vectors import MASK, load


@ti.func
def neighbour_forces(system: ti.template(), pack, block: ti.template()):
    """Return sum_j K_kj d_j [block] [N] of the nodes k of a pack (lanes), j not k; d_j: `System.increment`."""
    stride = system.stiffness.shape[0]
    force = [ti.Vector([0.0 for _ in range(LANES)]) for _ in range(block)]
    for entry in range(system.lane_start[pack], system.lane_start[pack + 1]):
        there = [system.column[((entry * LANES) & MASK) + lane] for lane in range(LANES)]
        start = entry * block * block * LANES
        for j in ti.static(range(block)):
            moved = ti.Vector([system.increment[j * stride + k] for k in there])
            for i in ti.static(range(block)):
                force[i] += load(system.values, start + (i * block + j) * LANES, LANES) * moved
    return force


@ti.func
def forces_at(system: ti.template(), pack, lane, block: ti.template()):
    """Return sum_j K_kj d_j [block] [N] of the node in one lane of a pack, as `neighbour_forces`."""
    stride = system.stiffness.shape[0]
    force = ti.Vector.zero(ti.f64, block)
    for entry in range(system.lane_start[pack], system.lane_start[pack + 1]):
        k, start = system.column[entry * LANES + lane], entry * block * block * LANES + lane
        for j in ti.static(range(block)):
            moved = system.increment[j * stride + k]
            for i in ti.static(range(block)):
                force[i] += system.values[start + (i * block + j) * LANES] * moved
    return force
