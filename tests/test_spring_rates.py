"""The stable step of many springs: block by block, with the eigenvalues of the whole matrix of all springs."""

import numpy as np
import pytest

import tcontact as tc
from tcontact.planning.springs import spring_rates

RUBBER = tc.LinearElastic(young=1e6, poisson=0.3, density=1000.0)


def block(sets, springs, parts=(), origin=(0.0, 0.0, 0.0), name="block"):
    """Return a block of 5^3 nodes with node sets and springs."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (4, 4, 4), origin=origin).with_sets(node_sets=sets)
    return tc.Body(mesh, RUBBER, springs=springs, rigid_parts=parts, name=name)


def random_bodies(random, parts):
    """Return two blocks with springs of random sets of nodes, to the ground and to each other; parts: rigid faces."""
    counts, bodies = [int(n) for n in random.integers(1, 12, size=2)], []
    for number, name in enumerate(("one", "two")):
        sets = {f"s{i}": random.choice(125, random.integers(1, 4), replace=False) for i in range(12)}
        springs = []
        for i in range(counts[number]):
            to = (
                ("two" if name == "one" else "one", f"s{random.integers(12)}") if random.random() < 0.3 else (0, 0, 3.0)
            )
            springs.append(tc.Spring(f"s{i}", stiffness=float(10.0 ** random.uniform(2, 5)), to=to))
        if random.random() < 0.3:  # both ends at one place of a body
            springs.append(tc.Spring("s0", 1e5, to=(name, "s0"), axes="z"))
        rigid = [tc.RigidPart("zmax", mass=0.1), tc.RigidPart("zmin", mass=0.0)] if parts else []
        bodies.append(block(sets, springs, rigid, (0.0, 0.0, 0.3 * number), name))
    return bodies


def whole_matrix(domain):
    """Return the largest eigenvalue of the matrix of all springs, from every spring with every other one."""
    springs, count = domain.springs, len(domain.boundary)
    owner = np.full(count, -1)
    for number, part in enumerate(domain.rigid):
        owner[part.nodes] = number
    weights, inverse, ends = np.zeros((len(springs), count)), np.zeros(count), []
    for row, spring in enumerate(springs):
        ends.append([])
        for sign, end in zip((-1.0, 1.0), spring.ends, strict=True):
            if end.body is None:
                continue
            body, first = domain.bodies[end.body], int(domain.node_start[end.body])
            numbers = np.sort(body.place[end.nodes]) + first
            nodes = np.array([int(np.flatnonzero(domain.boundary == node)[0]) for node in numbers])
            weights[row, nodes] += np.sqrt(spring.spring.stiffness) / len(nodes)
            inverse[nodes] = (owner[nodes] < 0) / domain.lumped[numbers]
            ends[row].append((sign, nodes))
    at_nodes = weights @ np.diag(inverse) @ weights.T
    at_parts, most = np.zeros_like(at_nodes), 0.0
    for number, part in enumerate(domain.rigid):
        root, moves, here = np.linalg.inv(np.linalg.cholesky(part.inertia)), [], []
        for row, spring in enumerate(springs):
            share, arm, held = 0.0, np.zeros(3), False
            for sign, nodes in ends[row]:
                mine = nodes[owner[nodes] == number]
                held |= len(mine) > 0
                share += sign * len(mine) / len(nodes)
                for node in mine:
                    arm += sign / len(nodes) * part.arms[list(part.nodes).index(node)]
            if held:
                stretch = 0.0 if spring.spring.directions else np.linalg.norm(spring.rest) - spring.rest_length
                longer = np.sqrt(1.0 + max(abs(stretch) / max(np.linalg.norm(arm), 1e-200), 1.0))
                turn = root @ np.cross(np.eye(3), arm) * longer
                move = np.concatenate([share / np.sqrt(part.mass) * np.eye(3), turn])
                moves.append(np.sqrt(spring.spring.stiffness) * move)
                here.append(row)
        for one, own in zip(here, moves, strict=True):
            for other, its in zip(here, moves, strict=True):
                at_parts[one, other] += np.linalg.norm(own.T @ its, 2)
        most += np.linalg.norm(np.concatenate(moves, axis=1), 2) ** 2 if moves else 0.0
    together, apart = (np.linalg.eigvalsh(each).max() for each in (at_nodes + at_parts, at_nodes))
    return min(together, apart + most)


@pytest.mark.parametrize("parts", [False, True])
@pytest.mark.parametrize("seed", range(8))
def test_the_rate_is_that_of_the_whole_matrix(seed, parts):
    """Random springs between random nodes of two bodies, with and without rigid parts."""
    random = np.random.default_rng(seed)
    for domain in tc.plan(tc.Scene(random_bodies(random, parts), duration=1e-3)).domains:
        if domain.springs:
            wanted = whole_matrix(domain)
            for rate in spring_rates(domain).values():
                assert rate == pytest.approx(wanted, rel=1e-12)


def solved(monkeypatch, sets):
    """Return the sizes of the eigenvalue problems for springs on these sets, and the rate found."""
    springs = [tc.Spring(name, stiffness=100.0 + i, to=(0.0, 0.0, 1.0)) for i, name in enumerate(sets)]
    domain = tc.plan(tc.Scene([block(sets, springs)], duration=1e-3)).domains[0]
    sizes, eigvalsh = [], np.linalg.eigvalsh
    with monkeypatch.context() as patch:
        patch.setattr(np.linalg, "eigvalsh", lambda matrix: sizes.append(len(matrix)) or eigvalsh(matrix))
        rate = spring_rates(domain)[0]
    assert rate == pytest.approx(whole_matrix(domain), rel=1e-12)
    return sizes


def test_springs_without_common_nodes_need_no_eigenvalue_problem(monkeypatch):
    """Sixty springs with two nodes each of their own: each alone is one number."""
    assert solved(monkeypatch, {f"s{i}": [2 * i, 2 * i + 1] for i in range(60)}) == []


def test_springs_that_share_nodes_are_solved_in_their_smaller_dimension(monkeypatch):
    """Thirty springs on pairs of three nodes are one problem of 3; chains of two springs problems of 2."""
    assert solved(monkeypatch, {f"s{i}": [[0, 1], [1, 2], [0, 2]][i % 3] for i in range(30)}) == [3]
    chains = {f"s{i}": [3 * (i // 2) + i % 2, 3 * (i // 2) + 1 + i % 2] for i in range(40)}
    assert set(solved(monkeypatch, chains)) == {2}


def test_a_domain_finds_its_rates_once():
    """Every body of a run asks for the rates of all domains."""
    domain = tc.plan(tc.Scene([block({"s": [0]}, [tc.Spring("s", 1e3)])], duration=1e-3)).domains[0]
    assert domain.spring_rates is domain.spring_rates
    assert domain.spring_rates == spring_rates(domain)
