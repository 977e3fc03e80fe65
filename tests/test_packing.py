"""Packing of blocks of cells: every cell once, contact cells last, equal work; slab order keeps rows short."""

from itertools import pairwise

import numpy as np
import pytest
from oracle.meshes import HEX_TO_TETS

import tcontact as tc
from tcontact.base.errors import InputError
from tcontact.kernels import lanes
from tcontact.planning.node_order import grid_order, slab_order
from tcontact.planning.packing import Block, pack_blocks, pack_cells


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


def tetrahedra(hexes):
    return hexes[:, HEX_TO_TETS].reshape(-1, 4)


def meshes():
    """Blocks of cells, given as (cells, kind of cells, contact cells, numbers a cell keeps), and how many nodes."""
    rng = np.random.default_rng(4)
    hexes = grid((5, 4, 6))[1]
    random = rng.integers(0, 300, (500, 4))  # no locality at all
    yield [(grid((1, 1, 1))[1], 0, 0, 0)], 8
    yield [(hexes, 0, 0, 0)], 210
    yield [(random, 0, 0, 0)], 300
    yield [(rng.permuted(np.arange(40)).reshape(10, 4), 0, 3, 1)], 60  # 20 nodes without a cell
    yield [(hexes[::-1], 0, 37, 16)], 210
    yield [(hexes[:19], 0, 19, 0)], 210  # contact cells alone
    # two kinds of cells, two materials of one of them, a block without contact cells and one with nothing else
    yield [(hexes[:50], 1, 11, 8), (tetrahedra(hexes[50:90]), 0, 0, 0), (hexes[90:], 1, 30, 3)], 210
    yield [(random, 0, 100, 2), (grid((4, 4, 4))[1] + 170, 1, 1, 0)], 300
    yield [(hexes[:, [0, 1, 3, 4, 5, 7]], 2, 1, 1), (hexes[:3], 0, 3, 0), (tetrahedra(hexes[:1]), 1, 0, 5)], 210


KINDS = 3  # kinds of cells that the kernel is made for; a mesh may have fewer


def pack(blocks, count, width, chunks):
    made = [
        Block(cells, width, kind, 100 + number, contact, memory)  # told apart by where its material stands
        for number, (cells, kind, contact, memory) in enumerate(blocks)
    ]
    return made, pack_blocks(made, count, KINDS, chunks)


def table_of(packs):
    """For every chunk: the segments of each kind, where its rows begin, and whether its corners own theirs."""
    segments = packs.segments.reshape(-1, lanes.SEGMENT)
    for *starts, base, owns in packs.chunk_table.reshape(-1, KINDS + 3):
        yield [segments[first:end] for first, end in pairwise(starts)], base, owns


def visited(blocks, packs):
    """Every lane as the kernel visits it: (chunk, block number, kind, pack, lane, segment, base, owns)."""
    for chunk, (kinds, base, owns) in enumerate(table_of(packs)):
        for kind, segments in enumerate(kinds):
            for segment in segments:
                number = segment[lanes.MATERIAL] - 100
                for packed in range(segment[lanes.FIRST_PACK], segment[lanes.END_PACK]):
                    for lane in range(blocks[number].width):
                        yield chunk, number, kind, packed, lane, segment, base, owns


def places_of(block, segment, packed, lane):
    """Places in the connectivity of the corners of a lane."""
    width, corners = block.width, block.cells.shape[1]
    return segment[lanes.CONNECTIVITY] + (packed * corners + np.arange(corners)) * width + lane


@pytest.mark.parametrize(("width", "chunks"), [(1, 8), (4, 1), (8, 8), (8, 31), (32, 5)])
def test_every_cell_is_scattered_once_and_every_row_is_seen_by_its_node(width, chunks):
    """What the kernel does with the lists: add 1 for every corner into its row, then sum up the rows of every node."""
    for given, count in meshes():
        blocks, packs = pack(given, count, width, chunks)
        assert packs.chunks == chunks
        assert (
            packs.all_chunks == len(packs.chunk_table) // (KINDS + 3) == chunks * (1 + any(b.contact for b in blocks))
        )
        rows = np.zeros(packs.row_count)
        owner = np.full(packs.row_count, -1)  # the chunk that alone may write there
        seen = [np.zeros(len(block.cells), dtype=int) for block in blocks]
        for chunk, number, kind, packed, lane, segment, base, owns in visited(blocks, packs):
            block = blocks[number]
            assert kind == block.kind
            ordinary = len(block.cells) - block.contact
            cell, most = packed * width + lane, block.contact if owns else ordinary
            assert segment[lanes.END_CELL] == most
            places = places_of(block, segment, packed, lane)
            nodes = packs.connectivity[places]
            row = places + segment[lanes.ROW] if owns else base + nodes
            assert row.min() >= (packs.first_corner_row if owns else 0)
            assert row.max() < (packs.row_count if owns else packs.first_corner_row)
            assert np.isin(owner[row], (-1, chunk)).all()
            owner[row] = chunk
            at = ordinary * owns + min(cell, most - 1)  # padding repeats the last cell
            assert np.array_equal(nodes, block.cells[at])
            if cell < most:
                seen[number][at] += 1
                np.add.at(rows, row, 1)
        assert all((times == 1).all() for times in seen)
        used = sum(np.bincount(block.cells.ravel(), minlength=count) for block in blocks)
        bases = [base for _kinds, base, _owns in table_of(packs)]
        touches = np.zeros(packs.row_count)
        corner_nodes = np.concatenate([b.cells[len(b.cells) - b.contact :].ravel() for b in blocks])
        assert len(corner_nodes) == len(packs.corners)
        total = np.bincount(corner_nodes, rows[packs.corners], minlength=count)
        np.add.at(touches, packs.corners, 1)
        for node, info in enumerate(packs.node_info):
            for chunk in range(info & lanes.CHUNK_MASK, ((info >> lanes.CHUNK_BITS) & lanes.CHUNK_MASK) + 1):
                assert chunk < chunks
                row = bases[chunk] + node
                assert 0 <= row < packs.first_corner_row
                assert owner[row] in (-1, chunk)
                touches[row] += 1
                total[node] += rows[row]
            assert info >> 2 * lanes.CHUNK_BITS == 0
        assert np.array_equal(total, used)
        assert np.all(touches <= 1)
        assert np.all(touches[rows > 0] == 1)


@pytest.mark.parametrize(("width", "chunks"), [(1, 8), (8, 8), (8, 31)])
def test_corners_of_contact_cells_have_rows_of_their_own(width, chunks):
    for given, count in meshes():
        blocks, packs = pack(given, count, width, chunks)
        starts = np.cumsum([0, *(block.contact * block.cells.shape[1] for block in blocks)])
        assert len(np.unique(packs.corners)) == len(packs.corners) == starts[-1]
        written = {}
        for _chunk, number, _kind, packed, lane, segment, _base, owns in visited(blocks, packs):
            cell = packed * width + lane
            if owns and cell < blocks[number].contact:
                written[number, cell] = places_of(blocks[number], segment, packed, lane) + segment[lanes.ROW]
        for (number, cell), rows in written.items():
            corners = blocks[number].cells.shape[1]
            first = starts[number] + cell * corners
            assert np.array_equal(packs.corners[first : first + corners], rows)
        assert len(written) == sum(block.contact for block in blocks)


@pytest.mark.parametrize(("width", "chunks"), [(4, 8), (8, 31)])
def test_lanes_and_memory_of_points_never_meet_and_leave_no_room(width, chunks):
    for given, count in meshes():
        blocks, packs = pack(given, count, width, chunks)
        held, kept = np.zeros(packs.lanes, dtype=int), np.zeros(packs.memory, dtype=int)
        for _chunk, number, _kind, packed, lane, segment, _base, owns in visited(blocks, packs):
            at = segment[lanes.LANE] + packed * width + lane
            assert (at >= packs.first_contact_lane) == bool(owns)
            held[at] += 1
            size = blocks[number].memory
            if owns:
                assert segment[lanes.MEMORY] == packs.memory_places[len(blocks) + number]
            if lane == 0:
                first = segment[lanes.MEMORY] + packed * size * width
                kept[first : first + size * width] += 1
        assert (held == 1).all()
        assert (kept == 1).all()


@pytest.mark.parametrize("chunks", [1, 3, 8, 31])
def test_chunks_have_about_as_much_work_and_keep_the_order_of_a_block(chunks):
    """The corners in a chunk differ from the mean by less than one pack, contact cells and others by themselves."""
    for given, count in meshes():
        blocks, packs = pack(given, count, 8, chunks)
        work, mean, ends = np.zeros(packs.all_chunks), np.zeros(2), {}
        for chunk, (kinds, _base, owns) in enumerate(table_of(packs)):
            for segment in np.concatenate(kinds):
                number = segment[lanes.MATERIAL] - 100
                first, end = segment[lanes.FIRST_PACK], segment[lanes.END_PACK]
                assert first == ends.get((owns, number), 0)
                assert end > first
                ends[owns, number] = end
                size = (end - first) * blocks[number].cells.shape[1]
                work[chunk] += size
                mean[owns] += size / chunks
        most = max(block.cells.shape[1] for block in blocks)
        assert np.abs(work[:chunks] - mean[0]).max() < most
        if packs.all_chunks > chunks:
            assert np.abs(work[chunks:] - mean[1]).max() < most


def test_boundary_nodes_are_numbered_from_one():
    packs = pack_cells(grid((3, 3, 3))[1], 64, 8, chunks=31)
    info = packs.with_boundary(np.array([7, 0, 63]))
    assert np.array_equal(info >> 2 * lanes.CHUNK_BITS, [2] + [0] * 6 + [1] + [0] * 55 + [3])
    assert np.array_equal(info & ((1 << 2 * lanes.CHUNK_BITS) - 1), packs.node_info)
    assert np.array_equal(packs.with_boundary(np.array([], dtype=int)), packs.node_info)
    for wrong in ([64], [-1], [3, 3]):
        with pytest.raises(InputError):
            packs.with_boundary(np.array(wrong))


def test_one_block_by_itself_is_packed_as_among_blocks():
    cells = grid((4, 3, 5))[1]
    alone, among = pack_cells(cells, 120, 8, contact=13), pack_blocks([Block(cells, 8, contact=13)], 120, 1)
    for name in ("connectivity", "chunk_table", "segments", "node_info", "corners"):
        assert np.array_equal(getattr(alone, name), getattr(among, name))
    assert alone.row_count == among.row_count


@pytest.mark.parametrize(
    ("cells", "count", "width", "chunks"),
    [
        (np.zeros((0, 8), int), 8, 8, 8),
        (np.array([[0, 1, 2, 4]]), 4, 8, 8),
        (np.array([[0, 1, 2, -1]]), 4, 8, 8),
        (np.array([[0, 1, 2, 3]]), 4, 0, 8),
        (np.array([[0, 1, 2, 3]]), 4, 8, 32),
        (np.array([[0, 1, 2, 3]]), 4, 8, 0),
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


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
@pytest.mark.parametrize("counts", [(3, 3, 3), (5, 4, 3), (2, 7, 2), (1, 1, 6), (1, 1, 1)])
def test_the_order_of_a_box_is_found_without_sorting_its_nodes_and_cells(kind, counts):
    for size in ((1.0, 1.0, 1.0), (1.0, 2.0, 3.0), (3.0, 0.5, 1e-3)):
        mesh = tc.box_mesh(size, counts, kind, origin=(-0.3, 5.0, 1.0))
        for normal in (None, (1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.1, 0.2, 0.9)):
            facing = None if normal is None else np.array(normal)
            found, known = grid_order(mesh.lines, kind, facing), slab_order(mesh.nodes, mesh.cells, facing)
            assert all(map(np.array_equal, found, known))
    flat = tc.box_mesh((1.0, 1.0, 1e-9), (2, 2, 3), kind)  # its planes along z count as one
    assert grid_order(flat.lines, kind) is None


def test_slab_order_keeps_force_rows_compact():
    """A force row per node and chunk would be 8 rows per node; neighbouring slabs share little."""
    nodes, cells = grid((24, 16, 16))
    _, ordered = renumber(nodes, cells)
    assert pack_cells(ordered, len(nodes), 8).row_count <= 1.35 * len(nodes)
    half = len(ordered) // 2  # tetrahedra beyond the hexes, and among them
    for hexes, others in ((ordered[:half], ordered[half:]), (ordered[::2], ordered[1::2])):
        blocks = [Block(hexes, 8), Block(tetrahedra(others), 8, 1)]
        assert pack_blocks(blocks, len(nodes), 2).row_count <= 1.35 * len(nodes)
    rng = np.random.default_rng(1)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    cloud = nodes @ turn + 0.2 * rng.normal(size=nodes.shape)  # unstructured, rotated
    _, ordered = renumber(cloud, rng.permutation(cells))
    assert pack_cells(ordered, len(nodes), 8).row_count <= 2.5 * len(nodes)
    graded = cloud * np.exp(cloud / 12.0)  # cells 7 times longer at one end
    _, ordered = renumber(graded, cells)
    assert pack_cells(ordered, len(nodes), 8).row_count <= 2.5 * len(nodes)
