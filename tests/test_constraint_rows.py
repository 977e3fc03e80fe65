"""Constraint rows: the static solve works on rows that no obstacle has filled, and island by island."""

import importlib
from dataclasses import replace

import numpy as np
import taichi as ti
from oracle import meshes
from scenes import block, material, wall
from test_static_solve import pressed, problem

import tcontact as tc
from tcontact.device import arrays
from tcontact.kernels.language.bundles import Boundary, Contact, Pairs, Rows, System
from tcontact.kernels.language.signatures import arguments, kernel_of, signature_of
from tcontact.kernels.static.solve import make_resolve
from tcontact.planning import contact_graph, islands
from tcontact.schemes.explicit.state import BodyState


def resolve_once(state):
    """Measure the contact cells and resolve the rows as they are, without any search."""
    term, solve = state.contact, state.contact.static_solve
    bundles = {
        "body": state.internal_force.bundle()._replace(u=state.u, v=state.v),
        "boundary": Boundary(**state.boundary_nodes.arguments()),
        "contact": Contact(**term.arguments(), sums=state.serial.sums),
        "rows": Rows(**term.row_arguments()),
        "pairs": Pairs(**solve.pairs),
        "system": System(**solve.system),
    }
    resolve = make_resolve(state.plan.variant, state.plan.body.material.law, term.block, term.plain)

    @ti.func
    def resolve_rows(body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(),
                     pairs: ti.template(), system: ti.template()):  # fmt: skip
        resolve(body, boundary, contact, rows, pairs, system, None, 1)

    state.internal_force.measure_surface(state.u, state.v)
    kernel_of(resolve_rows, signature_of(bundles), options=term.options)(*arguments(bundles))


def test_rows_that_nothing_has_searched_for_are_resolved():
    """Gaps and normals written by hand, of a plane that the scene does not have, against the oracle with that plane."""
    turn = meshes.rotation(5)
    mesh, law = block("hex8", 3, turn=turn), material("linear")
    other = turn @ (0.36, 0.48, 0.8)

    def scene(normal):
        body = tc.Body(mesh, law, contact="zmin")
        model = tc.MasslessContact(removal="full", tolerance=1e-12, sweeps=20)
        return tc.Scene([body], [wall(mesh, normal, 1e-4)], duration=1.0, contact=model)

    mine, wanted = scene(-other), scene(other)
    start = pressed(mesh, np.asarray(wanted.obstacles[0].normal), 3e-3)
    state = BodyState(mine, tc.plan(mine).bodies[0], start, np.zeros_like(start))
    plane, places = wanted.obstacles[0], state.contact.rows.places
    nodes = state.plan.node_order[state.plan.contact.nodes]
    rows = arrays.get(state.contact.rows.values).reshape(len(nodes), places.width).copy()
    rows[:, places.gap] = plane.gap(mesh.nodes[nodes] + start[nodes])
    rows[:, places.normal : places.normal + 3] = plane.normal
    arrays.set_values(state.contact.rows.values, rows)
    resolve_once(state)

    static, points, loads = problem(wanted)
    expected, pressing, _, _ = static.solve(np.array(mesh.nodes), start, points, loads)
    assert (pressing > 0).any()
    assert np.abs(expected - start).max() >= 1e-4
    assert np.abs(state.displacement() - expected).max() <= 1e-10 * 0.2


SIZES = ((0.1, 0.1, 0.1), (0.12, 0.08, 0.1))
PLACES = ((0.0, 0.0, 0.0), (0.5, 0.0, 0.0))
SPEEDS = ((0.0, 0.0, -3.0), (0.3, 0.1, -1.0))


def thrown(*numbers):
    """One or both of two blocks thrown at a plane, each with its own mesh and speed, as one body of separate parts."""
    parts = [tc.box_mesh(size=SIZES[i], cells=(3, 3, 2 + i)) for i in numbers]
    first = np.cumsum([0, *(len(part.nodes) for part in parts)])
    bottom = [part.face_sets["zmin"] + at for at, part in zip(first, parts, strict=False)]
    mesh = tc.Mesh(
        np.concatenate([part.nodes + PLACES[i] for i, part in zip(numbers, parts, strict=True)]),
        np.concatenate([part.cells + at for at, part in zip(first, parts, strict=False)]),
        "hex8",
        face_sets={"zmin": np.concatenate(bottom)},
    )
    velocity = np.repeat([SPEEDS[i] for i in numbers], np.diff(first), axis=0)
    body = tc.Body(mesh, tc.NeoHookean(young=2e6, poisson=0.3, density=1000.0), velocity=velocity, contact="zmin")
    plane, model = tc.Plane((0.0, 0.0, -1e-3), (0.0, 0.05, 1.0)), tc.MasslessContact(removal="normal", sweeps=1)
    return tc.Scene([body], [plane], duration=0.004, contact=model)


def end(*numbers):
    """Positions [n, 3] and contact forces [n, 3] at the end of a run."""
    result = tc.simulate(thrown(*numbers), scheme=tc.CentralDifference(dt=2.5e-4))
    assert result.ok, result.message
    return np.stack([np.asarray(values) for values in (result.position, result.contact_node_force)])


def part_of(cells, count):
    """Number of the separate part of a mesh that each node belongs to [n]."""
    part = np.arange(count)
    while True:
        smallest = part.copy()
        np.minimum.at(smallest, cells, part[cells].min(axis=1, keepdims=True))
        if (smallest == part).all():
            return np.unique(part, return_inverse=True)[1].reshape(-1)
        part = smallest


def graph_of_parts(cells, nodes, count):
    """The contact graph of separate parts, one after another."""
    part = part_of(cells, count)
    graphs = [contact_graph.contact_graph(cells, nodes[part[nodes] == i], count) for i in range(part.max() + 1)]
    return contact_graph.joined(graphs, [0] * len(graphs), [0] * len(graphs), cells.shape[1])


def islands_of_parts(plan):
    """An island for each of two separate parts."""
    (whole,) = islands.islands_of(plan)
    part, contact = part_of(plan.cells, len(plan.reference)), plan.contact
    nodes = int((part[contact.nodes] == 0).sum())
    cells = int((part[plan.cells[contact.graph.cells, 0]] == 0).sum())
    first = replace(whole, nodes=slice(0, nodes), cells=slice(0, cells), all_nodes=slice(0, 0))
    return first, replace(whole, nodes=slice(nodes, whole.nodes.stop), cells=slice(cells, whole.cells.stop))


def test_islands_get_what_they_would_get_alone(monkeypatch):
    """Two parts in one static solve, which shares its decisions, and in two islands of it, against a run of each."""
    alone = np.concatenate([end(0), end(1)], axis=1)
    scale = np.abs(alone).max(axis=(1, 2))
    assert scale[1] > 1.0
    assert (np.abs(end(0, 1) - alone).max(axis=(1, 2)) > 1e-12 * scale).all()
    monkeypatch.setattr(importlib.import_module("tcontact.plan"), "contact_graph", graph_of_parts)
    monkeypatch.setattr(importlib.import_module("tcontact.contact.term"), "islands_of", islands_of_parts)
    assert (np.abs(end(0, 1) - alone).max(axis=(1, 2)) <= 1e-13 * scale).all()
