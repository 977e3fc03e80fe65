"""Several bodies in one numbering: every list of the domain says of each body what its own plan says."""

from itertools import pairwise

import numpy as np
import oracle
import pytest
from scenes import block, domain_of, material, state_of, twin

import tcontact as tc
from tcontact.cells.internal_force import InternalForce
from tcontact.device import arrays
from tcontact.planning.domain import Domain

SIZE = (0.2, 0.22, 0.18)
MODELS = {
    "full": tc.MasslessContact(removal="full"),
    "normal": tc.MasslessContact(removal="normal"),
    "penalty": tc.PenaltyContact(1e9),
}
NODES = ("reference", "lumped")
BOUNDARY = ("tensors", "inverses", "loads")


def bodies():
    """A supported body, one without contact, a periodic one, and one of other cells with contact on two sides."""
    held = tc.Support("xmax", "xz", velocity=(0.3, -0.1))
    return [
        tc.Body(block("tet4", 2), material("linear"), contact="zmin", supports=[held]),
        tc.Body(block("hex8", 2, shift=(1.0, 0.0, 0.0)), material(), supports=[tc.Support("zmax", "xyz")]),
        tc.Body(tc.box_mesh(SIZE, (2, 3, 2), origin=(2.0, 0.0, 0.0)), material(), contact="zmin", periodic="xy"),
        tc.Body(block("wedge6", 2, shift=(3.0, 0.0, 0.0)), material("svk"), contact=["zmin", "ymax"]),
    ]


def planned(model="full", chosen=(0, 1, 2, 3)):
    there = bodies()
    scene = tc.Scene(
        [there[number] for number in chosen],
        [tc.Plane(point=(0.0, 0.0, -0.01))],
        1.0,
        gravity=(0.1, 0.2, -9.0),
        contact=MODELS[model],
    )
    return tc.plan(scene).bodies


@pytest.fixture(params=MODELS)
def domain(request):
    return Domain(planned(request.param), tuple(range(4)))


def each(domain):
    """Every body with its first node, first contact node and where its boundary nodes stand."""
    return zip(domain.bodies, domain.node_start[:-1], domain.contact_start[:-1], domain.boundary_place, strict=True)


@pytest.mark.parametrize("number", range(4))
def test_a_domain_of_one_body_has_the_arrays_of_its_plan(number):
    body = planned()[number]
    domain = domain_of(body)
    for name in (*NODES, *BOUNDARY, "support_axes", "speeds", "contact", "images", "gravity"):
        assert getattr(domain, name) is getattr(body, name), name
    for name in ("boundary", "support_rows"):
        assert np.array_equal(getattr(domain, name), getattr(body, name)), name
    assert domain.kinds == ((body.variant, body.body.material.law),)
    if body.contact is not None:
        for mine, own in zip(domain.residual_receivers, body.residual_receivers, strict=True):
            assert np.array_equal(mine, own)


def test_nodes_stand_body_after_body(domain):
    assert domain.node_start[-1] == sum(len(body.reference) for body in domain.bodies)
    for body, first, _contact, _place in each(domain):
        own = slice(first, first + len(body.reference))
        for name in NODES:
            assert np.array_equal(getattr(domain, name)[own], getattr(body, name))


def test_boundary_nodes_begin_with_contact_nodes_and_their_followers(domain):
    assert np.array_equal(np.sort(np.concatenate(domain.boundary_place)), np.arange(len(domain.boundary)))
    assert len(np.unique(domain.boundary)) == len(domain.boundary)
    for body, first, _contact, place in each(domain):
        assert np.array_equal(domain.boundary[place], body.boundary + first)
        for name in BOUNDARY:
            assert np.array_equal(getattr(domain, name)[place], getattr(body, name)), name
    contact = domain.contact.nodes
    assert np.array_equal(domain.boundary[: len(contact)], contact)
    followers = domain.images.followers_of(contact)
    assert len(followers) > 0
    behind = domain.boundary[len(contact) : len(contact) + len(followers)]
    assert np.array_equal(np.sort(behind), np.sort(followers))


def test_images_follow_within_their_body(domain):
    for body, first, _contact, _place in each(domain):
        count = len(body.reference)
        own = domain.images.master[first : first + count] - first
        assert np.array_equal(own, np.arange(count) if body.images is None else body.images.master)
    without = [body for body in domain.bodies if body.images is None]
    assert Domain(tuple(without)).images is None


def test_contact_nodes_stand_body_after_body(domain):
    for name, shifts in (("nodes", True), ("all_nodes", True), ("areas", False), ("basis", False)):
        parts = [
            getattr(body.contact, name) + (first if shifts else 0)
            for body, first, _contact, _place in each(domain)
            if body.contact is not None and getattr(body.contact, name) is not None
        ]
        mine = getattr(domain.contact, name)
        assert (mine is None) == (not parts)
        assert mine is None or np.array_equal(mine, np.concatenate(parts)), name
    counts = [0 if body.contact is None else len(body.contact.nodes) for body in domain.bodies]
    assert np.array_equal(np.diff(domain.contact_start), counts)
    assert counts[1] == 0
    assert min(counts[0], counts[2], counts[3]) > 0
    assert Domain(domain.bodies[1:2]).contact is None


def test_supports_act_on_the_nodes_of_their_body(domain):
    wanted = np.concatenate([b.boundary[b.support_rows] + first for b, first, _contact, _place in each(domain)])
    assert np.array_equal(domain.boundary[domain.support_rows], wanted)
    assert len(wanted) > 0
    for name in ("support_axes", "speeds"):
        assert np.array_equal(getattr(domain, name), np.concatenate([getattr(b, name) for b in domain.bodies]))


def test_blocks_have_every_cell_once_and_the_contact_cells_last(domain):
    assert [block.kind[1] for block in domain.blocks] == [body.body.material.law for body in domain.bodies]
    numbers = []
    for block_, (body, first, _contact, _place) in zip(domain.blocks, each(domain), strict=True):
        assert np.array_equal(np.unique(block_.cells, axis=0), np.unique(body.cells + first, axis=0))
        assert len(block_.cells) == len(body.cells)
        numbers.append(block_.contact)
        if body.contact is not None and body.contact.graph is not None:
            assert np.array_equal(block_.contact_cells, body.cells[body.contact.graph.cells] + first)
            rest = block_.cells[: len(block_.cells) - len(block_.contact)]
            followed = np.concatenate([domain.contact.nodes, domain.images.followers_of(domain.contact.nodes)])
            assert not np.isin(rest, followed).any()
    count = sum(map(len, numbers))
    assert np.array_equal(np.concatenate(numbers), np.arange(count))
    assert (count > 0) == (domain.contact.graph is not None)


@pytest.mark.parametrize("model", ["full", "normal"])
def test_the_surface_problem_couples_nodes_of_one_cell_and_of_one_body(model):
    """Every entry of the matrix is the sum of the pairs of corners at its two nodes, each of which is there once."""
    domain = Domain(planned(model), tuple(range(4)))
    graph, master = domain.contact.graph, domain.images.master
    assert np.array_equal(graph.nodes, domain.contact.nodes)
    cells = [cell for one in domain.blocks for cell in one.contact_cells]
    assert len(graph.pair_start) == len(cells) + 1
    for cell, (first, end) in zip(cells, pairwise(graph.pair_start), strict=True):
        for pair in range(first, end):
            assert np.array_equal(graph.nodes[graph.pair_nodes[pair]], master[cell[graph.pair_corners[pair]]])
        held = np.isin(master[cell], graph.nodes).sum()
        assert end - first == held * (held + 1) // 2
    assert graph.pair_start[-1] == len(graph.pair_nodes)
    used = []
    for row, (first, end) in enumerate(pairwise(graph.row_start)):
        assert graph.column[first] == row
        for entry in range(first, end):
            sources = graph.entry_pairs[graph.entry_start[entry] : graph.entry_start[entry + 1]]
            assert len(sources) > 0
            for source in sources:
                pair = graph.pair_nodes[source] if source >= 0 else graph.pair_nodes[-1 - source][::-1]
                assert tuple(pair) == (row, graph.column[entry])
            used += sources.tolist()
    two = np.flatnonzero(graph.pair_corners[:, 0] != graph.pair_corners[:, 1])
    assert sorted(used) == sorted([*range(len(graph.pair_nodes)), *(-1 - two)])
    assert (np.diff(graph.colour_start) > 0).all()
    for first, end in pairwise([*graph.colour_start, len(graph.nodes)]):
        for node in range(first, end):
            near = graph.column[graph.row_start[node] + 1 : graph.row_start[node + 1]]
            assert not ((near >= first) & (near < end)).any()


@pytest.mark.parametrize("model", ["full", "normal"])
def test_what_is_left_unbalanced_goes_to_nodes_of_the_same_body(model):
    domain = Domain(planned(model), tuple(range(4)))
    starts, rows = domain.residual_receivers
    assert len(starts) == len(domain.contact.nodes) + 1
    assert starts[-1] == len(rows)
    for body, first, contact, _place in each(domain):
        if body.contact is not None:
            own_starts, own_rows = body.residual_receivers
            for node, (start, end) in enumerate(pairwise(own_starts)):
                mine = rows[starts[contact + node] : starts[contact + node + 1]]
                assert np.array_equal(domain.boundary[mine], body.boundary[own_rows[start:end]] + first)


def test_one_pass_gives_every_body_its_own_force():
    """A pass over several kinds of cells and laws, contact cells among them, against numpy for each body by itself.

    Images share one force: the corners of contact cells give theirs to the master, all others to their own node.
    """
    domain = Domain(planned(), tuple(range(4)))
    force = InternalForce(domain)
    u = 0.01 * np.random.default_rng(3).uniform(-1.0, 1.0, domain.reference.shape)
    answer = arrays.zeros(u.size)
    force.without_boundary().minus_force(arrays.put(u.reshape(-1)), answer)
    found = domain.images.total(-domain.lumped[:, None] * np.array(arrays.get(answer)).reshape(-1, 3))
    energy = 0.0
    for body, first, _contact, _place in each(domain):
        own, there = slice(first, first + len(body.reference)), twin(body.body)
        points = oracle.quadrature(body.reference, body.cells, there.kind)
        wanted = oracle.internal_force(points, there.law, u[own])
        if body.images is not None:
            wanted = body.images.total(wanted)
        assert np.abs(found[own] - wanted).max() <= 1e-12 * np.abs(wanted).max()
        energy += oracle.energy(points, there.law, u[own])
    assert force.sum_of("elastic") == pytest.approx(energy, rel=1e-12)


def test_what_an_exchange_adds_to_boundary_nodes_accelerates_their_body(parallel_path):
    """Once a step, between the force pass and the motion of the boundary nodes: p(t) = F t."""
    body = tc.Body(block("tet4", 2), material("linear"), supports=[tc.Support("zmin", "z")])
    scene = tc.Scene([body], [], 1.0, contact=None)
    plan = tc.plan(scene).bodies[0]
    dt, steps, force, seen = 1e-6, 5, (0.3, -0.2), []

    def exchange(special_force):
        seen.append(arrays.get(special_force).copy())
        arrays.set_values(special_force, seen[-1] - np.tile((*force, 0.0), len(seen[-1]) // 3))

    state = state_of(scene, plan)
    state.exchange = exchange
    for step in range(steps):
        state.advance(0.5 * dt if step else 0.0, 0.5 * dt, dt, step * dt, (dt if step else 0.0, dt))
    nodes = len(seen[0]) // 3
    momentum = np.einsum("n,nc->c", plan.lumped, arrays.get(state.v).reshape(-1, 3))
    assert len(seen) == steps
    assert not seen[0].any()
    assert seen[-1].any()
    assert momentum[:2] == pytest.approx(nodes * (steps - 0.5) * dt * np.array(force), rel=1e-12)
