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
