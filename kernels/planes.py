"""Gaps to planes: g_p(x) = nu_p . x - offset_p, open positive.

planes: flat [slots * 4], unit normal nu_p into the body and offset nu_p . point.
"""

import taichi as ti


@ti.func
def gap(planes: ti.template(), p, x):
    return planes[4 * p] * x[0] + planes[4 * p + 1] * x[1] + planes[4 * p + 2] * x[2] - planes[4 * p + 3]


@ti.func
def normal(planes: ti.template(), p):
    return ti.Vector([planes[4 * p], planes[4 * p + 1], planes[4 * p + 2]])


@ti.func
def position(reference: ti.template(), u: ti.template(), node):
    return ti.Vector([reference[3 * node + j] + u[3 * node + j] for j in ti.static(range(3))])
