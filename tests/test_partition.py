"""A cut mesh: every cell once, equal work, and copies, owners, ghosts and receivers that fit together."""

import numpy as np
import pytest
from mixed_meshes import corner

import tcontact as tc
from tcontact.base.errors import InputError
from tcontact.planning.contact_graph import contact_graph, residual_receivers
from tcontact.planning.lumped_mass import corner_masses
from tcontact.planning.partition import box_graph, cell_graph
from tcontact.planning.partition.box_graph import BoxGraph
from tcontact.planning.partition.cell_graph import CellGraph
from tcontact.planning.partition.contact_parts import contact_part, receiver_ranks
from tcontact.planning.partition.cut import EXTRA_WORK, contact_ranks, cut_cells
from tcontact.planning.partition.domain_part import cut_domain, domain_part, kept_by, shares_contact
from tcontact.planning.partition.parts import parts_of
from tcontact.planning.planning import plan

pytest.importorskip("pymetis", reason="METIS cuts the meshes: pip install pymetis")

MESHES = {
    "hex8": lambda: tc.box_mesh((1.0, 1.0, 1.0), (6, 6, 6)),
    "tet4": lambda: tc.box_mesh((1.0, 1.0, 1.0), (4, 4, 4), kind="tet4"),
    "wedge6": lambda: tc.box_mesh((1.0, 1.0, 1.0), (4, 4, 4), kind="wedge6"),
    "mixed": lambda: corner((8, 4, 8)),
}
every_mesh = pytest.mark.parametrize("mesh", [make() for make in MESHES.values()], ids=MESHES)
every_count = pytest.mark.parametrize("ranks", [1, 2, 3, 4, 7])


def cut_mesh(mesh, ranks, extra=EXTRA_WORK["full"]):
    contact = mesh.nodes_of("zmin")
    rank = cut_cells(mesh.blocks, mesh.node_count, ranks, contact, extra)
    return contact, rank, parts_of(mesh.blocks, mesh.node_count, rank)


def cells_round(mesh):
    """Nodes of every cell, one after another."""
    return [set(row.tolist()) for _, rows in mesh.blocks for row in rows]


@every_count
@every_mesh
def test_every_cell_has_one_rank_and_every_node_one_owner(mesh, ranks):
    _, rank, parts = cut_mesh(mesh, ranks)
    assert sorted(np.concatenate([part.cells for part in parts])) == list(range(mesh.cell_count))
    assert all(len(part.cells) for part in parts)
    owned = np.concatenate([part.nodes[part.owned] for part in parts])
    assert sorted(owned) == list(range(mesh.node_count))
    around = cells_round(mesh)
    for part in parts:
        nodes = set().union(*(around[cell] for cell in part.cells))
        assert part.nodes.tolist() == sorted(nodes)
        lowest = [min(rank[c] for c, cell in enumerate(around) if node in cell) for node in part.nodes[:25]]
        assert part.owner[:25].tolist() == lowest


@every_count
@every_mesh
def test_two_ranks_list_the_nodes_they_share_in_the_same_order(mesh, ranks):
    _, _, parts = cut_mesh(mesh, ranks)
    for part in parts:
        assert [other for other, _ in part.shared] == sorted(other for other, _ in part.shared)
        for other, places in part.shared:
            theirs = dict(parts[other].shared)[part.rank]
            assert (part.nodes[places] == parts[other].nodes[theirs]).all()
        for other in set(range(ranks)) - {part.rank}:
            both = np.intersect1d(part.nodes, parts[other].nodes)
            listed = dict(part.shared).get(other, np.zeros(0, dtype=int))
            assert part.nodes[listed].tolist() == both.tolist()


@every_mesh
def test_masses_of_the_parts_add_up_over_the_copies(mesh):
    _, _, parts = cut_mesh(mesh, 4)

    def masses(chosen):
        total, first = np.zeros(mesh.node_count), 0
        for kind, rows in mesh.blocks:
            mine = chosen[(chosen >= first) & (chosen < first + len(rows))] - first
            first += len(rows)
            if len(mine):
                np.add.at(total, rows[mine], corner_masses(kind, mesh.nodes, rows[mine], 1000.0))
        return total

    whole = masses(np.arange(mesh.cell_count))
    own = [masses(part.cells) for part in parts]
    for part in parts:
        total = own[part.rank][part.nodes].copy()
        for other, places in part.shared:
            total[places] += own[other][part.nodes[places]]
        assert total == pytest.approx(whole[part.nodes], rel=1e-14)


@pytest.mark.parametrize("extra", EXTRA_WORK.values(), ids=EXTRA_WORK)
@pytest.mark.parametrize(("cells", "ranks"), [(12, 2), (12, 4), (16, 8), (18, 27)])
def test_contact_ranks_are_few_and_the_time_of_a_step_is_the_mean(cells, ranks, extra):
    """A contact rank takes as long as its cells and the largest contact work of any rank; METIS alone: .65 to .9."""
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (cells, cells, cells))
    contact, rank, _ = cut_mesh(mesh, ranks, extra)
    touching = np.isin(mesh.cells, contact).any(axis=1)
    own = np.bincount(rank[touching], minlength=ranks)
    with_contact = own[own > 0]
    mean = (mesh.cell_count + extra * touching.sum()) / ranks
    assert len(with_contact) == int(np.clip(np.ceil(touching.sum() * (1 + extra) / mean), 1, ranks))
    assert with_contact.max() <= 1.05 * with_contact.mean() + 1
    slowest = (np.bincount(rank, minlength=ranks) + np.where(own > 0, extra * own.max(), 0.0)).max()
    assert mean / slowest >= 0.95


@every_count
@every_mesh
def test_ghosts_are_the_nodes_of_own_rows_and_own_cells_that_others_own(mesh, ranks):
    contact, rank, parts = cut_mesh(mesh, ranks, extra=0.0)
    found = [contact_part(mesh.blocks, rank, contact, own) for own in range(ranks)]
    graph = contact_graph(mesh.cells, contact, mesh.node_count, mesh.repeated)
    columns = {
        node: set(graph.nodes[graph.column[graph.row_start[k] : graph.row_start[k + 1]]].tolist())
        for k, node in enumerate(graph.nodes.tolist())
    }
    assert sorted(np.concatenate([part.owned for part in found])) == sorted(contact)
    for part in found:
        own = set(part.owned.tolist())
        copies = set(np.intersect1d(parts[part.rank].nodes, contact).tolist())
        needed = (set().union(*(columns[node] for node in own)) | copies) - own
        assert sorted(np.concatenate([[], *(nodes for _, nodes in part.ghosts)])) == sorted(needed)
        for other, nodes in part.ghosts:
            assert set(nodes.tolist()) <= set(found[other].owned.tolist())
            assert nodes.tolist() == dict(found[other].sent)[part.rank].tolist()


@every_count
@every_mesh
def test_a_share_is_handed_over_by_the_lowest_rank_that_has_both_nodes_in_a_cell(mesh, ranks):
    contact, rank, _ = cut_mesh(mesh, ranks)
    around = cells_round(mesh)
    others = np.setdiff1d(np.unique(np.concatenate([rows[np.isin(rows, contact).any(axis=1)].reshape(-1)
                                                    for _, rows in mesh.blocks])), contact)  # fmt: skip
    boundary = np.concatenate([contact, others])
    start, places = residual_receivers(mesh.cells, mesh.nodes, boundary, len(contact))
    pairs = np.repeat(contact, np.diff(start)), boundary[places]
    ranks_of_pairs = receiver_ranks(mesh.blocks, rank, *pairs)
    for first, second, own in list(zip(*pairs, ranks_of_pairs, strict=True))[::7]:
        assert own == min(rank[c] for c, cell in enumerate(around) if {first, second} <= cell)


def test_a_receiver_without_a_common_cell_is_refused():
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
    rank = np.zeros(mesh.cell_count, dtype=int)
    with pytest.raises(InputError, match="refine the mesh there"):
        receiver_ranks(mesh.blocks, rank, np.array([0]), np.array([mesh.node_count - 1]))


@pytest.mark.parametrize("ranks", [0, -1, 9])
def test_more_ranks_than_cells_are_refused(ranks):
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
    with pytest.raises(InputError, match="8 cells; start 1 to 8 ranks"):
        cut_cells(mesh.blocks, mesh.node_count, ranks)


def test_a_mesh_of_one_cell_runs_without_mpiexec():
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (1, 1, 1))
    with pytest.raises(InputError, match="the mesh has 1 cell; run it without mpiexec"):
        cut_cells(mesh.blocks, mesh.node_count, 2)


def test_as_many_ranks_as_cells():
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
    assert sorted(cut_cells(mesh.blocks, mesh.node_count, 8, mesh.nodes_of("zmin"), 7.0)) == list(range(8))


@pytest.mark.parametrize("ranks", [2, 5])
def test_a_mesh_in_pieces_is_cut_whole(ranks):
    """Two boxes that nothing connects, the upper one without contact."""
    box = tc.box_mesh((1.0, 1.0, 1.0), (4, 4, 4))
    nodes = np.concatenate([box.nodes, box.nodes + np.array([0.0, 0.0, 2.0])])
    blocks = (("hex8", np.concatenate([box.cells, box.cells + box.node_count])),)
    rank = cut_cells(blocks, len(nodes), ranks, box.nodes_of("zmin"), 4.0)
    touching = np.isin(blocks[0][1], box.nodes_of("zmin")).any(axis=1)
    work = np.bincount(rank, weights=1.0 + 4.0 * touching, minlength=ranks)
    assert work.min() > 0
    assert work.max() <= 1.15 * work.mean()


@every_mesh
def test_cells_that_share_a_face_are_neighbours(mesh):
    """Oracle: two cells with at least three common nodes (four where one is a hexahedron's face)."""
    graph = CellGraph.of(mesh.blocks, mesh.node_count)
    around = cells_round(mesh)
    for cell in range(0, mesh.cell_count, 11):
        expected = [c for c, other in enumerate(around) if c != cell and len(around[cell] & other) >= 3]
        assert graph.near[graph.start[cell] : graph.start[cell + 1]].tolist() == expected


def test_the_same_mesh_is_cut_the_same_way_twice():
    mesh = MESHES["tet4"]()
    assert (cut_mesh(mesh, 4)[1] == cut_mesh(mesh, 4)[1]).all()


@pytest.mark.parametrize(
    ("size", "ranks", "removal", "expected"),
    [(24, 4, "normal", 1), (64, 8, "full", 1), (32, 512, "full", 1), (160, 64, "full", 4), (160, 8, "normal", 1)],
)
def test_few_contact_nodes_stay_together_and_many_are_shared_where_that_shortens_the_step(
    size, ranks, removal, expected
):
    nodes, cells = (size + 1) ** 2, size**3
    assert contact_ranks(cells, size**2, nodes, ranks, removal, cells - size**2) == expected


def test_a_contact_that_leaves_no_cells_for_other_ranks_is_shared():
    assert contact_ranks(40, 40, 66, 2, "full", 0) == 2


@pytest.mark.parametrize("patches", [2, 3, 4])
def test_patches_have_equal_contact_work_and_the_first_rank_what_belongs_together(patches):
    """Cells that belong together stand in a corner of the face, and in one above it."""
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (12, 12, 12))
    contact, together = mesh.nodes_of("zmin"), np.array([0, 1, 12, 13, 1700, 1701])
    extra = EXTRA_WORK["normal"]
    rank = cut_cells(mesh.blocks, mesh.node_count, 4, contact, extra, patches, together)
    touching = np.isin(mesh.cells, contact).any(axis=1)
    own = np.bincount(rank[touching], minlength=4)
    assert (rank[together] == 0).all()
    assert (own > 0).sum() == patches
    assert own.max() <= 1.05 * own[own > 0].mean() + 2
    work = np.bincount(rank, minlength=4) + extra * own
    assert work.max() <= 1.1 * work.mean()


@pytest.mark.parametrize("counts", [(5, 5, 1), (2, 2, 2), (4, 3, 2)])
@pytest.mark.parametrize("ranks", [2, 3, 5])
def test_the_first_rank_has_all_that_belongs_together_or_the_cut_is_refused(counts, ranks):
    """Also where so many cells belong together that ranks would be left without any, and take one from others."""
    mesh, random = tc.box_mesh((1.0, 1.0, 1.0), counts), np.random.default_rng(7)
    contact = mesh.nodes_of("zmin")
    for most in range(mesh.cell_count + 1):
        together, patches = random.permutation(mesh.cell_count)[:most], int(random.integers(2, ranks + 1))
        if mesh.cell_count - most < ranks - 1:
            room = mesh.cell_count - most + 1
            with pytest.raises(InputError, match=f"start 1 to {room} ranks" if room > 1 else "run it without mpiexec"):
                cut_cells(mesh.blocks, mesh.node_count, ranks, contact, 7.0, patches, together)
            continue
        rank = cut_cells(mesh.blocks, mesh.node_count, ranks, contact, 7.0, patches, together)
        assert (rank[together] == 0).all()
        assert (np.bincount(rank, minlength=ranks) > 0).all()


@pytest.mark.parametrize(
    "given",
    [
        {"loads": [tc.Load("zmax", pressure=1e4)]},
        {"point_masses": [tc.PointMass("zmax", 0.1)]},
        {"supports": [tc.Support("zmax", "x", velocity=lambda t: 1e3 * t)]},
    ],
)
@pytest.mark.parametrize("contact", [tc.MasslessContact(), tc.PenaltyContact(stiffness=2e9)])
def test_a_sheet_on_which_something_acts_everywhere_is_refused(given, contact):
    """Contact below and something above leave no cell for another rank: ranks may share the contact, not what acts."""
    mesh = tc.box_mesh((0.1, 0.1, 0.02), (5, 5, 1)).translated((0.0, 0.0, 1e-4))
    sheet = tc.Body(mesh, tc.LinearElastic(2.3e7, 0.27, 1350.0), contact="zmin", **given)
    scene = tc.Scene([sheet], [tc.Plane()], duration=2e-3, contact=contact)
    (domain,) = plan(scene).domains
    for ranks in (2, 3):
        with pytest.raises(InputError, match="25 of 25 cells touch loads, springs or driven supports"):
            cut_domain(domain, scene, ranks)


@pytest.mark.parametrize("share", [1.0, 0.75])
@pytest.mark.parametrize(("ranks", "asked"), [(3, 2), (4, 2), (4, 3), (4, 4)])
def test_what_keeps_contact_cells_together_leaves_equal_work_to_other_ranks(share, ranks, asked):
    """Springs are at contact nodes that all ranks were to share: the first rank has these cells, and no others."""
    mesh = tc.box_mesh((0.1, 0.1, 0.2), (8, 8, 16)).translated((0.0, 0.0, 1e-4))
    low = mesh.nodes_of("zmin")
    sprung = low[mesh.nodes[low, 0] < share * 0.1 + 1e-9]
    body = tc.Body(
        mesh.with_sets(node_sets={"sprung": sprung}),
        tc.LinearElastic(2.3e7, 0.27, 1350.0),
        contact="zmin",
        springs=[tc.Spring("sprung", 1e4)],
    )
    scene = tc.Scene([body], [tc.Plane()], duration=2e-3, contact=tc.PenaltyContact(stiffness=2e9))
    (domain,) = plan(scene).domains
    cut = cut_domain(domain, scene, ranks, asked)
    assert np.bincount(cut, minlength=ranks).max() <= 1.01 * mesh.cell_count / ranks + 1.0
    assert shares_contact(domain, cut) == (share < 1.0)
    if share == 1.0:
        assert kept_by(domain, scene).startswith("what else acts on its contact nodes (springs, ")


def test_parts_share_the_probes():
    """Every cell of a set, and every node with copies on several ranks, counts once in a mean."""
    rng, mesh = np.random.default_rng(5), tc.box_mesh((0.3, 0.2, 0.1), (6, 5, 4))
    mesh = mesh.with_sets(cell_sets={"some": rng.choice(120, 70, False)}, node_sets={"few": rng.choice(210, 40, False)})
    probes = [tc.Probe(name, quantity) for name in ("some", "few", "zmax") for quantity in ("position", "pressure")]
    body = tc.Body(mesh, tc.LinearElastic(2.3e7, 0.27, 1350.0), contact="zmin", probes=probes)
    scene = tc.Scene([body], [tc.Plane()], duration=2e-3)
    (domain,) = plan(scene).domains
    parts = [domain_part(domain, cut_domain(domain, scene, 3), rank).bodies[0] for rank in range(3)]
    for number, probe in enumerate(probes):
        items, weights = [], []
        for part in parts:
            place, own = part.plan.probes[number], part.part
            items += [(own.cells if probe.facts.of_cells else own.nodes)[place.items]]
            weights += [place.weights]
        known = body.mesh.nodes_of("zmax") if probe.set == "zmax" else mesh.node_sets.get(probe.set)
        if probe.facts.of_cells:
            known = [cell for cell, nodes in enumerate(mesh.cells) if known is not None and np.isin(nodes, known).any()]
        if probe.set == "some":
            known = mesh.cell_sets["some"] if probe.facts.of_cells else np.unique(mesh.cells[mesh.cell_sets["some"]])
        assert np.array_equal(np.sort(np.concatenate(items)), np.sort(known))
        assert np.concatenate(weights).sum() == pytest.approx(1.0, rel=1e-12)


def test_the_graph_of_a_box_is_that_of_its_faces(monkeypatch):
    """Whole, and of some cells; in portions of a few cells, as large meshes are done."""
    monkeypatch.setattr(cell_graph, "AT_ONCE", 7)
    for counts in ((4, 3, 5), (1, 1, 6), (1, 1, 1)):
        mesh = tc.box_mesh((1.0, 1.0, 1.0), counts)
        found, known = CellGraph.of_box(mesh.counts), CellGraph.of(mesh.blocks, mesh.node_count)
        chosen = np.flatnonzero(np.random.default_rng(3).random(mesh.cell_count) < 0.6)
        for one, other in ((found, known), (found.within(chosen), known.within(chosen))):
            assert np.array_equal(one.start, other.start)
            assert np.array_equal(one.near, other.near)
        inside = found.within(chosen)
        for place, cell in enumerate(chosen):
            near = [np.searchsorted(chosen, one) for one in found.near_of(np.array([cell])) if one in chosen]
            assert inside.near_of(np.array([place])).tolist() == near
            assert (
                BoxGraph([mesh.counts]).near_of(np.array([cell])).tolist() == found.near_of(np.array([cell])).tolist()
            )


def test_the_graph_of_several_boxes_is_that_of_their_cells_one_after_the_other(monkeypatch):
    meshes = [tc.box_mesh((1.0, 1.0, 1.0), counts) for counts in ((4, 3, 5), (2, 2, 2), (1, 6, 3))]
    known, graph = CellGraph.of_meshes(meshes), BoxGraph([mesh.counts for mesh in meshes])
    several = np.array([3, 59, 60, 67, 68, 85])
    assert graph.near_of(several).tolist() == known.near_of(several).tolist()
    chosen = np.flatnonzero(np.random.default_rng(5).random(86) < 0.7)
    for one, other in ((graph, known), (graph.within(chosen), known.within(chosen))):
        assert np.array_equal(one.cut(3), other.cut(3))
    monkeypatch.setattr(box_graph, "FINE", 0)
    blocks = CellGraph.joined([graph._blocks(number)[0] for number in range(3)])
    assert (blocks.weights > 0).all()
    assert blocks.near.max() == len(blocks.start) - 2
    for one in (graph, graph.within(chosen)):
        sizes = np.bincount(one.cut(2), minlength=2)
        assert sizes.max() - sizes.mean() <= 8  # parts are equal to a block of cells
    apart = graph.within(np.concatenate([np.arange(60), np.arange(68, 86)]))  # nothing of the second box
    assert len(apart.cut(2)) == 78


@pytest.mark.parametrize("counts", [(9, 8, 11), (21, 4, 5)])
@pytest.mark.parametrize("some", [False, True])
def test_a_large_box_is_cut_by_blocks_of_cells_as_well_as_by_its_cells(counts, some, monkeypatch):
    """Weights of the blocks are cells and faces counted one by one; parts are equal to a block, cuts a third longer."""
    monkeypatch.setattr(box_graph, "FINE", 0)
    known, graph = CellGraph.of_box(counts), BoxGraph([counts])
    if some:
        chosen = np.flatnonzero(np.arange(np.prod(counts)) // counts[0] % counts[1] != 1)
        known, graph = known.within(chosen), graph.within(chosen)
    blocks, sizes, block = graph._blocks(0)
    block = block if not some else block[chosen]
    assert np.array_equal(np.bincount(block), sizes)
    left = np.repeat(np.arange(len(block)), np.diff(known.start))
    faces = np.zeros((len(sizes), len(sizes)), dtype=int)
    np.add.at(faces, (block[left], block[known.near]), 1)
    np.fill_diagonal(faces, 0)
    for one in range(len(sizes)):
        near = slice(blocks.start[one], blocks.start[one + 1])
        assert np.array_equal(blocks.near[near], np.flatnonzero(faces[one]))
        assert np.array_equal(blocks.weights[near], faces[one][faces[one] > 0])
    for ranks in (2, 3):
        ends = [(part[left] != part[known.near]).sum() for part in (graph.cut(ranks), known.cut(ranks))]
        assert ends[0] <= 1.34 * ends[1]
        own = np.bincount(graph.cut(ranks), minlength=ranks)
        assert own.max() - own.mean() <= 0.01 * own.mean() + 8
