"""Index lists of the sweeps: lanes never couple, every matrix entry has its place, heirs carry what is left over."""

from itertools import pairwise

import numpy as np
import pytest
from scenes import block, material

import tcontact as tc
from tcontact.contact_graph import heirs
from tcontact.kernels.lanes import SWEEP_LANES
from tcontact.packing import append_own_rows, pack_cells
from tcontact.sweep_order import sweep_order


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


@pytest.mark.parametrize("block_size", [1, 3])
def test_a_dense_matrix_survives_the_lanes(block_size):
    """Blocks written at entry_place and read as a sweep reads them give the matrix of the graph."""
    graph = planned("tet4").contact.graph
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
def test_every_contact_node_has_heirs_with_mass(kind):
    body = planned(kind)
    count = len(body.contact.nodes)
    start, rows = heirs(body.cells, body.reference, body.boundary, count)
    assert (np.diff(start) >= 1).all()
    assert rows.min() >= count
    assert (np.abs(body.tensors[rows]).max(axis=(1, 2)) > 0.0).all()


@pytest.mark.parametrize("width", [1, 4, 8])
def test_own_rows_follow_those_of_the_body_and_never_meet(width):
    cells = np.random.default_rng(3).integers(0, 50, (37, 8))
    packs = pack_cells(cells, 50, width)
    own = append_own_rows(packs, cells[5:16])
    cell, corner = np.divmod(np.arange(11 * 8), 8)
    rows = own.rows(cell, corner)
    assert len(np.unique(rows)) == 88
    assert rows.min() >= packs.row_count
    assert rows.max() < own.packs.row_count
    table = own.packs.chunk_table.reshape(-1, 5)
    assert np.array_equal(table[: packs.chunks].ravel(), packs.chunk_table)
    first, base = table[packs.chunks, 0], table[packs.chunks, 2]
    lanes = own.packs.connectivity.reshape(-1, 8, width)
    for i in range(11):  # the row that the kernel computes: base + place of the corner in the connectivity
        for k in range(8):
            place = ((first + i // width) * 8 + k) * width + i % width
            assert rows[8 * i + k] == base + place
            assert lanes[first + i // width, k, i % width] == cells[5 + i, k]
