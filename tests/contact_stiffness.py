"""The stiffness between contact nodes as the kernels of the static solve make it, for the tests."""

from collections import namedtuple
from functools import cache

import numpy as np
from scenes import domain_of, force_of

import tcontact as tc
from tcontact.contact.static_solve import contact_blocks
from tcontact.device import arrays

Bodies = namedtuple("Bodies", "params position u memory")
Contacts = namedtuple("Contacts", "basis options")
Pairs = namedtuple("Pairs", "blocks cell_nodes shape_gradients start corners nodes values")


@cache
def tangent_kernel(kind, law, block, plain):
    """The tangent of the static solve as a kernel of its own."""
    import taichi as ti

    from tcontact.kernels.elements import FUNCTIONS
    from tcontact.kernels.language.arguments import ARRAY, INDEX
    from tcontact.kernels.language.bundles import ContactOptions
    from tcontact.kernels.static.reduced_tangent import make_reduced_tangent
    from tcontact.kernels.static.surface_tangent import make_surface_tangent

    if FUNCTIONS[kind].tangent == "reduced":
        tangent = make_reduced_tangent(kind, law, block)
    else:
        tangent = make_surface_tangent(kind, law, block, plain)

    @ti.kernel
    def kernel(
        params: ARRAY, position: ARRAY, u: ARRAY, blocks: INDEX, cell_nodes: INDEX, shape_gradients: ARRAY,
        start: INDEX, corners: INDEX, nodes: INDEX, values: ARRAY, basis: ARRAY, memory: ARRAY,
    ):  # fmt: skip
        body = ti.static(Bodies(params, position, u, memory))
        lists = ti.static(Pairs(blocks, cell_nodes, shape_gradients, start, corners, nodes, values))
        tangent(body, ti.static(Contacts(basis, ContactOptions())), lists, 0)

    return kernel


def contact_plan(body, removal):
    """Plan of a body above a plane."""
    scene = tc.Scene([body], [tc.Plane((0, 0, -1.0))], 1.0, contact=tc.MasslessContact(removal=removal))
    return tc.plan(scene).bodies[0]


def contact_stiffness(body, removal, u, force=None):
    """K_KK [k * block, k * block] at u, its nodes in the user's numbering and their basis [k, 3, block].

    force: the force pass of its `contact_plan`, with the state of its points; None: one at the start.
    """
    plan = contact_plan(body, removal)
    graph, block, count = plan.contact.graph, plan.contact.block, len(plan.contact.nodes)
    basis = plan.contact.basis[:, :, :block]
    values = arrays.zeros(len(graph.pair_nodes) * block * block)
    force = force_of(plan) if force is None else force
    lists = contact_blocks(domain_of(plan), force)
    plain = bool((basis == np.eye(3)[:, :block]).all()) and block == 3
    kernel = tangent_kernel(plan.variant, body.material.law, block, plain)
    points = [lists[name] for name in ("blocks", "cell_nodes", "shape_gradients")]
    before = (plan.reference, u[plan.node_order], *points, graph.pair_start, graph.pair_corners, graph.pair_nodes)
    memory = arrays.zeros(1) if force.memory is None else force.memory
    kernel(force.parameters, *map(arrays.put, before), values, arrays.put(basis), memory)
    matrix = np.zeros((count, block, count, block))
    pair_values = np.array(arrays.get(values)).reshape(-1, block, block)
    for (row, column), corners, value in zip(graph.pair_nodes, graph.pair_corners, pair_values, strict=True):
        matrix[row, :, column] += value
        if corners[0] != corners[1]:
            matrix[column, :, row] += value.T
    return matrix.reshape(count * block, -1), plan.node_order[plan.contact.nodes], basis


def spread_of(nodes, basis):
    """Degrees of freedom [3k] of the contact nodes, and the matrix [3k, k * block] that spreads what they move by."""
    spread = np.zeros((3 * len(nodes), basis.shape[0] * basis.shape[2]))
    for k, columns in enumerate(basis):
        width = columns.shape[1]
        spread[3 * k : 3 * k + 3, width * k : width * (k + 1)] = columns
    return (3 * nodes[:, None] + np.arange(3)).ravel(), spread
