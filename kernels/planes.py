"""Gaps to planes: g_p(x) = nu_p . (x - y_p), open positive.

planes: flat [slots * 6], unit normal nu_p into the body and a point y_p of the plane. Positions count from a point
among the contact nodes, reference [k, 3] lists where these start: the gap keeps its digits far from the origin.
"""

import taichi as ti


@ti.func
def gap(planes: ti.template(), p, x):
    return normal(planes, p).dot(x - point(planes, p))


@ti.func
def normal(planes: ti.template(), p):
    return ti.Vector([planes[6 * p + j] for j in ti.static(range(3))])


@ti.func
def point(planes: ti.template(), p):
    return ti.Vector([planes[6 * p + 3 + j] for j in ti.static(range(3))])


@ti.func
def position(reference: ti.template(), k, u: ti.template(), node):
    return ti.Vector([reference[3 * k + j] + u[3 * node + j] for j in ti.static(range(3))])


@ti.func
def nearest_planes(touching: ti.template(), u: ti.template(), plane_count):
    """near: the three planes with the smallest gap at each node; only needed for more than three planes."""
    for k in range(touching.nodes.shape[0]):
        x = position(touching.reference, k, u, touching.nodes[k])
        for slot in range(3):
            best = 1e300
            for p in range(plane_count):
                g = gap(touching.planes, p, x)
                taken = 0
                for before in range(slot):
                    if touching.near[3 * k + before] == p:
                        taken = 1
                if taken == 0 and g < best:
                    best = g
                    touching.near[3 * k + slot] = p


@ti.func
def smallest_gap(touching: ti.template(), u: ti.template(), plane_count):
    """Smallest gap of the contact set to any plane."""
    least = 1e300
    for i in range(touching.all_nodes.shape[0]):
        x = position(touching.all_reference, i, u, touching.all_nodes[i])
        for p in range(plane_count):
            least = ti.min(least, gap(touching.planes, p, x))
    return least
