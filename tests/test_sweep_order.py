"""Index lists of the sweeps: lanes never couple, every matrix entry has its place, residuals go to nodes with mass."""

from itertools import pairwise

import numpy as np
import pytest
from scenes import block, domain_of, material

import tcontact as tc
from tcontact.kernels.lanes import SWEEP_LANES
from tcontact.planning.contact_graph import residual_receivers
from tcontact.planning.domain_packs import corner_lists, pack_domain
from tcontact.planning.sweep_order import sweep_order


def planned(kind, cells=4):
    body = tc.Body(block(kind, cells), material(), contact=["zmin", "xmin"])
    planes = [tc.Plane(point=(0, 0, -1.0)), tc.Plane(point=(-1.0, 0, 0), normal=(1, 0, 0))]
    scene = tc.Scene([body], planes, 1.0, contact=tc.MasslessContact(removal="full"))
    return tc.plan(scene).bodies[0]


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_lanes_hold_every_node_once_and_do_not_couple(kind):
    graph = planned(kind).contact.graph
    order = sweep_order(graph, 3)
    assert order.pack_start[0] == 0
    assert order.pack_start[-1] == len(graph.nodes)
    sizes = np.diff(order.pack_start)
    assert sizes.min() >= 1
    assert sizes.max() <= SWEEP_LANES
    for first, end in pairwise(order.pack_start):
        members = set(range(first, end))
        for node in members:
            row = set(graph.column[graph.row_start[node] + 1 : graph.row_start[node + 1]].tolist())
            assert not row & members


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
@pytest.mark.parametrize("block_size", [1, 3])
def test_a_dense_matrix_survives_the_lanes(block_size, kind):
    """Blocks written at entry_place and read as a sweep reads them give the matrix of the graph."""
    graph = planned(kind).contact.graph
    order = sweep_order(graph, block_size)
    count = len(graph.nodes)
    values = np.zeros(order.column.size * block_size**2)
    wanted = np.zeros((count, count))
    for node in range(count):
        for entry in range(graph.row_start[node] + 1, graph.row_start[node + 1]):
            wanted[node, graph.column[entry]] = entry
            values[order.entry_place[entry] + (block_size**2 - 1) * SWEEP_LANES] = entry
    found = np.zeros_like(wanted)
    for pack, nodes in enumerate(pairwise(order.pack_start)):
        for at in range(order.lane_start[pack], order.lane_start[pack + 1]):
            for lane, node in enumerate(range(*nodes)):
                place = (at * block_size**2 + block_size**2 - 1) * SWEEP_LANES + lane
                found[node, order.column[at, lane]] += values[place]
    assert np.array_equal(found, wanted)


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_every_contact_node_has_residual_receivers_with_mass(kind):
    body = planned(kind)
    count = len(body.contact.nodes)
    start, rows = residual_receivers(body.cells, body.reference, body.boundary, count)
    assert (np.diff(start) >= 1).all()
    assert rows.min() >= count
    assert (np.abs(body.tensors[rows]).max(axis=(1, 2)) > 0.0).all()


@pytest.mark.parametrize(("kind", "periodic"), [("hex8", None), ("tet4", None), ("hex8", "xy")])
def test_a_boundary_node_reads_the_rows_of_its_corners_of_contact_cells(kind, periodic):
    """Every corner of a contact cell once, at the node that it is an image of; others have none."""
    sides = ["zmin"] if periodic else ["zmin", "xmin"]
    mesh = tc.box_mesh((1, 1, 1), (3, 4, 5)) if periodic else block(kind, 3)
    body = tc.Body(mesh, material(), contact=sides, periodic=periodic)
    scene = tc.Scene([body], [tc.Plane(point=(0, 0, -1.0))], 1.0, contact=tc.MasslessContact())
    plan = tc.plan(scene).bodies[0]
    domain = domain_of(plan)
    packs = pack_domain(domain)
    lists, count = corner_lists(domain, packs), len(plan.boundary)
    assert lists[0] == count + 1
    assert lists[count] == len(lists)
    master = np.arange(len(plan.reference)) if plan.images is None else plan.images.master
    contact_cells = master[domain.blocks[0].contact_cells]
    row_of = packs.corners.reshape(contact_cells.shape)
    for place, node in enumerate(plan.boundary):
        assert sorted(lists[lists[place] : lists[place + 1]]) == sorted(row_of[contact_cells == node])
    assert lists[count] - lists[0] == contact_cells.size
