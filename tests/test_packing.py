"""Packing of cells: every cell once, rows without gaps, any order and size; slab order keeps rows short."""

import numpy as np
import pytest

from tcontact.errors import InputError
from tcontact.packing import TABLE, pack_cells, slab_order


def grid(counts, levels=None):
    """Nodes [n, 3] and hexes [m, 8] of a box grid; levels: coordinates per axis."""
    levels = levels or [np.linspace(0.0, c, c + 1) for c in counts]
    nodes = np.stack(np.meshgrid(*levels, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(nodes)).reshape([len(v) for v in levels])
    part = [slice(0, -1), slice(1, None)]
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    return nodes, np.stack([number[part[a], part[b], part[c]].ravel() for a, b, c in corners], axis=1)


def renumber(nodes, cells):
    node_order, cell_order = slab_order(nodes, cells)
    rank = np.empty(len(nodes), dtype=int)
    rank[node_order] = np.arange(len(nodes))
    return nodes[node_order], rank[cells][cell_order]


def meshes():
    rng = np.random.default_rng(4)
    yield grid((1, 1, 1))[1], 8
    yield grid((5, 4, 3))[1], 120
    yield rng.integers(0, 300, (500, 4)), 300  # no locality at all
    yield rng.permuted(np.arange(40)).reshape(10, 4), 60  # 20 nodes without a cell
    yield grid((7, 2, 2))[1][::-1], 72


@pytest.mark.parametrize("width", [1, 4, 8, 32])
def test_every_cell_is_scattered_once_and_every_row_is_seen_by_its_node(width):
    for cells, count in meshes():
        packs = pack_cells(cells, count, width)
        corners = cells.shape[1]
        lanes = packs.connectivity.reshape(packs.pack_count, corners, width).transpose(0, 2, 1).reshape(-1, corners)
        assert np.array_equal(lanes[: len(cells)], cells)
        assert np.array_equal(lanes[len(cells) :], np.repeat(cells[-1:], len(lanes) - len(cells), axis=0))
        assert packs.cell_count == len(cells)

        # what the kernel does: scatter 1 per corner into rows, then sum first..last per node
        rows = np.zeros(packs.row_count)
        owner = np.full(packs.row_count, -1)
        table = packs.chunk_table.reshape(packs.chunks, TABLE)
        assert table[0, 0] == 0
        assert table[-1, 1] == packs.pack_count
        assert np.array_equal(table[1:, 0], table[:-1, 1])
        for chunk, (first, end, base, last, own) in enumerate(table):
            assert (last, own) == (len(cells), 0)
            for cell in range(first * width, min(end * width, len(cells))):
                for node in cells[cell]:
                    assert 0 <= base + node < packs.row_count
                    assert owner[base + node] in (-1, chunk)
                    owner[base + node] = chunk
                    rows[base + node] += 1
        used = np.bincount(cells.ravel(), minlength=count)
        seen = np.zeros(packs.row_count)
        for node, info in enumerate(packs.node_info):
            total = 0
            for chunk in range(info & 15, (info >> 4 & 15) + 1):
                row = table[chunk, 2] + node
                assert 0 <= row < packs.row_count
                assert owner[row] in (-1, chunk)
                seen[row] += 1
                total += rows[row]
            assert total == used[node]
            assert info >> 8 == 0
        assert np.all(seen <= 1)
        assert np.all(seen[rows > 0] == 1)


def test_special_nodes_are_numbered_from_one():
    packs = pack_cells(grid((3, 3, 3))[1], 64, 8)
    info = packs.with_special(np.array([7, 0, 63]))
    assert np.array_equal(info >> 8, [2] + [0] * 6 + [1] + [0] * 55 + [3])
    assert np.array_equal(info & 255, packs.node_info)
    assert np.array_equal(packs.with_special(np.array([], dtype=int)), packs.node_info)
    for wrong in ([64], [-1], [3, 3]):
        with pytest.raises(InputError):
            packs.with_special(np.array(wrong))


@pytest.mark.parametrize(
    ("cells", "count", "width", "chunks"),
    [
        (np.zeros((0, 8), int), 8, 8, 8),
        (np.array([[0, 1, 2, 4]]), 4, 8, 8),
        (np.array([[0, 1, 2, -1]]), 4, 8, 8),
        (np.array([[0, 1, 2, 3]]), 4, 0, 8),
        (np.array([[0, 1, 2, 3]]), 4, 8, 17),
    ],
)
def test_bad_packing_is_refused(cells, count, width, chunks):
    with pytest.raises(InputError):
        pack_cells(cells, count, width, chunks)


def test_slab_order_is_a_permutation_that_follows_the_planes_of_a_box():
    levels = [np.linspace(0, 1, 4) ** 2, np.linspace(0, 3, 21), np.array([0.0, 0.1, 0.7])]  # graded
    nodes, cells = grid(None, levels)
    mixed = np.random.default_rng(0).permutation(len(nodes))
    inverse = np.argsort(mixed)
    node_order, cell_order = slab_order(nodes[mixed], inverse[cells])
    assert np.array_equal(np.sort(node_order), np.arange(len(nodes)))
    assert np.array_equal(np.sort(cell_order), np.arange(len(cells)))
    sorted_nodes = nodes[mixed][node_order]
    y, x, z = sorted_nodes[:, 1], sorted_nodes[:, 0], sorted_nodes[:, 2]
    assert np.array_equal(np.lexsort((z, x, y)), np.arange(len(nodes)))  # most planes slowest, then the next


def test_slab_order_keeps_force_rows_compact():
    """A force row per node and chunk would be 8 rows per node; neighbouring slabs share little."""
    nodes, cells = grid((24, 16, 16))
    _, ordered = renumber(nodes, cells)
    assert pack_cells(ordered, len(nodes), 8).row_count <= 1.35 * len(nodes)
    rng = np.random.default_rng(1)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    cloud = nodes @ turn + 0.2 * rng.normal(size=nodes.shape)  # unstructured, rotated
    _, ordered = renumber(cloud, rng.permutation(cells))
    assert pack_cells(ordered, len(nodes), 8).row_count <= 2.5 * len(nodes)
    graded = cloud * np.exp(cloud / 12.0)  # cells 7 times longer at one end
    _, ordered = renumber(graded, cells)
    assert pack_cells(ordered, len(nodes), 8).row_count <= 2.5 * len(nodes)
