"""Samples: displacement and velocity of some nodes at the start of every row of a launch, from which the host computes
what probes and maxima measure (tcontact/schemes/sensors.py).

`samples`: number of nodes, the nodes, then for each row displacement (3) [m] and velocity (3) [m/s] of every node.
"""

from ..engine import ti

SAMPLE = 6


@ti.func
def take_sample(samples: ti.template(), body: ti.template(), number):
    """Store the sample of row `number`, before the force pass of the row moves the nodes."""
    count = int(samples[0])
    for i in range(count):
        node = 3 * int(samples[1 + i])
        place = 1 + count + SAMPLE * (number * count + i)
        for j in ti.static(range(3)):
            samples[place + j] = body.u[node + j]
            samples[place + 3 + j] = body.v[node + j]
