"""The lists of the static solve: colours never share a cell, entries add up to the dense matrix."""

import numpy as np
import pytest
from oracle import meshes
from scenes import block

from tcontact.planning.contact_graph import contact_graph

SETS = [("hex8", ["zmin"]), ("tet4", ["zmin"]), ("tet4", ["zmin", "xmin", "ymax"]), ("hex8", ["xmin", "xmax"])]


def graph_of(kind, names, seed=0):
    """A graph on shuffled node numbers, and the cells it belongs to."""
    mesh = block(kind, (3, 4, 3))
    order = np.random.default_rng(seed).permutation(mesh.node_count)
    cells = order[mesh.cells]
    nodes = np.sort(order[mesh.nodes_of(names)])
    return contact_graph(cells, nodes, mesh.node_count), cells, nodes, mesh.node_count


@pytest.mark.parametrize(("kind", "names"), SETS)
def test_no_two_nodes_of_a_colour_share_a_cell(kind, names):
    graph, cells, nodes, count = graph_of(kind, names)
    assert sorted(graph.nodes) == list(nodes)
    slot = np.full(count, -1)
    slot[graph.nodes] = np.arange(len(nodes))
    neighbours = [set() for _ in nodes]
    for cell in slot[cells]:
        members = set(cell[cell >= 0])
        for node in members:
            neighbours[node] |= members - {node}
    # colours are consecutive runs of the numbering: the longest runs without neighbours cannot be fewer
    runs, current = 1, set()
    for node in range(len(nodes)):
        if neighbours[node] & current:
            runs, current = runs + 1, set()
        current.add(node)
    assert runs <= graph.colours <= 1 + max(map(len, neighbours))


@pytest.mark.parametrize(("kind", "names"), SETS)
def test_entries_add_up_to_the_dense_matrix(kind, names):
    """Random symmetric cell matrices of 2 x 2 blocks, assembled densely by node ids and through the lists."""
    graph, cells, nodes, count = graph_of(kind, names)
    touched = np.isin(cells, nodes).any(axis=1)
    assert np.array_equal(graph.cells, np.flatnonzero(touched))
    width = cells.shape[1]
    values = np.random.default_rng(2).normal(size=(len(cells), width, width, 2, 2))
    values += values.transpose(0, 2, 1, 4, 3)
    dense = np.zeros((count, count, 2, 2))
    for cell, matrix in zip(cells, values, strict=True):
        dense[np.ix_(cell, cell)] += matrix
    wanted = dense[np.ix_(graph.nodes, graph.nodes)]

    pairs = []
    for number, cell in enumerate(graph.cells):
        for pair in range(graph.pair_start[number], graph.pair_start[number + 1]):
            first, second = graph.pair_corners[pair]
            assert cells[cell, first] == graph.nodes[graph.pair_nodes[pair, 0]]
            assert cells[cell, second] == graph.nodes[graph.pair_nodes[pair, 1]]
            pairs.append(values[cell, first, second])
    found = np.zeros_like(wanted)
    for row in range(len(nodes)):
        assert graph.column[graph.row_start[row]] == row, "the diagonal entry comes first"
        for entry in range(graph.row_start[row], graph.row_start[row + 1]):
            assert not found[row, graph.column[entry]].any(), "every entry once"
            members = graph.entry_pairs[graph.entry_start[entry] : graph.entry_start[entry + 1]]
            found[row, graph.column[entry]] = sum(pairs[p] if p >= 0 else pairs[-1 - p].T for p in members)
    assert np.allclose(found, wanted, rtol=1e-13, atol=1e-13)
    alone = (graph.pair_corners[:, 0] == graph.pair_corners[:, 1]).sum()
    assert len(graph.entry_pairs) == 2 * len(pairs) - alone


def test_structured_faces_need_few_colours():
    """A flat face of hexes is a grid with diagonals: four colours."""
    mesh = block("hex8", 6, shake=0.0, turn=meshes.rotation(1))
    assert contact_graph(mesh.cells, mesh.nodes_of("zmin"), mesh.node_count).colours == 4
