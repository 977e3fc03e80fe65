"""Gaps to planes: g_p(x) = nu_p . (x - y_p), open positive.

planes: flat [slots * 6], unit normal nu_p into the body and a point y_p of the plane. Positions count from a point
among the contact nodes, reference [k, 3] lists where these start: the gap keeps its digits far from the origin.
"""

import taichi as ti

from .arguments import ARRAY, INDEX


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


@ti.kernel
def nearest_planes(nodes: INDEX, planes: ARRAY, plane_count: ti.i32, reference: ARRAY, u: ARRAY, near_out: INDEX):
    """The three planes with the smallest gap at each node; only launched for more than three planes."""
    ti.loop_config(serialize=True)
    for k in range(nodes.shape[0]):
        x = position(reference, k, u, nodes[k])
        for slot in range(3):
            best = 1e300
            for p in range(plane_count):
                g = gap(planes, p, x)
                taken = 0
                for before in range(slot):
                    if near_out[3 * k + before] == p:
                        taken = 1
                if taken == 0 and g < best:
                    best = g
                    near_out[3 * k + slot] = p


@ti.kernel
def smallest_gap(nodes: INDEX, planes: ARRAY, plane_count: ti.i32, reference: ARRAY, u: ARRAY, gap_out: ARRAY):
    """gap_out [1]: smallest gap of the listed nodes to any plane."""
    ti.loop_config(serialize=True)
    for _ in range(1):
        least = 1e300
        for i in range(nodes.shape[0]):
            x = position(reference, i, u, nodes[i])
            for p in range(plane_count):
                least = ti.min(least, gap(planes, p, x))
        gap_out[0] = least
