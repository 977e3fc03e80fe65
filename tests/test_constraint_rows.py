"""Constraint rows: the static solve works on rows that no obstacle has filled, and island by island."""

import numpy as np
import taichi as ti
from oracle import meshes
from scenes import block, material, state_of, wall
from test_static_solve import pressed, problem

import tcontact as tc
from tcontact.device import arrays
from tcontact.kernels.language.bundles import Boundary, Contact, Rows
from tcontact.kernels.language.signatures import arguments, kernel_of, signature_of
from tcontact.kernels.language.solve_bundles import Pairs, System
from tcontact.kernels.static.solve import make_resolve


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
    resolve = make_resolve(state.domain.kinds, term.block, term.plain)

    @ti.func
    def resolve_rows(body: ti.template(), boundary: ti.template(), contact: ti.template(), rows: ti.template(),
                     pairs: ti.template(), system: ti.template()):  # fmt: skip
        resolve(body, boundary, contact, rows, None, pairs, system, None, 1)

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
    state = state_of(mine, tc.plan(mine).bodies[0], start, np.zeros_like(start))
    plane, places = wanted.obstacles[0], state.contact.rows.places
    body = state.views[0].plan
    nodes = body.node_order[body.contact.nodes]
    rows = arrays.get(state.contact.rows.values).reshape(len(nodes), places.width).copy()
    rows[:, places.gap] = plane.gap(mesh.nodes[nodes] + start[nodes])
    rows[:, places.normal : places.normal + 3] = plane.normal
    arrays.set_values(state.contact.rows.values, rows)
    resolve_once(state)

    static, points, loads = problem(wanted)
    expected, pressing, _, _ = static.solve(np.array(mesh.nodes), start, points, loads)
    assert (pressing > 0).any()
    assert np.abs(expected - start).max() >= 1e-4
    assert np.abs(state.views[0].displacement() - expected).max() <= 1e-10 * 0.2


SIZES = ((0.1, 0.1, 0.1), (0.12, 0.08, 0.1))
PLACES = ((0.0, 0.0, 0.0), (0.5, 0.0, 0.0))
SPEEDS = ((0.0, 0.0, -3.0), (0.3, 0.1, -1.0))


def part(number):
    """One of two blocks thrown at a plane, each with its own mesh and speed."""
    box = tc.box_mesh(size=SIZES[number], cells=(3, 3, 2 + number))
    return tc.Mesh(box.nodes + PLACES[number], box.cells, "hex8", face_sets={"zmin": box.face_sets["zmin"]})


def thrown(*bodies):
    """A scene of meshes with the speeds [n, 3] of their nodes."""
    law = tc.NeoHookean(young=2e6, poisson=0.3, density=1000.0)
    found = [tc.Body(mesh, law, velocity=np.array(velocity), contact="zmin") for mesh, velocity in bodies]
    plane, model = tc.Plane((0.0, 0.0, -1e-3), (0.0, 0.05, 1.0)), tc.MasslessContact(removal="normal", sweeps=1)
    return tc.Scene(found, [plane], duration=0.004, contact=model)


def one_body(parts):
    """The parts as one mesh of separate parts, which is one island."""
    first = len(parts[0].nodes)
    mesh = tc.Mesh(
        np.concatenate([part.nodes for part in parts]),
        np.concatenate([parts[0].cells, parts[1].cells + first]),
        "hex8",
        face_sets={"zmin": np.concatenate([parts[0].face_sets["zmin"], parts[1].face_sets["zmin"] + first])},
    )
    return mesh, np.repeat(SPEEDS, [first, len(parts[1].nodes)], axis=0)


def end(*bodies):
    """Positions [n, 3] and contact forces [n, 3] at the end of a run."""
    result = tc.simulate(thrown(*bodies), scheme=tc.CentralDifference(dt=2.5e-4))
    assert result.ok, result.message
    return np.stack([np.asarray(values) for values in (result.position, result.contact_node_force)])


def test_islands_get_what_they_would_get_alone():
    """Two parts as one body, whose static solve shares its decisions, and as two islands, against a run of each."""
    parts = [part(0), part(1)]
    bodies = [(mesh, np.tile(speed, (len(mesh.nodes), 1))) for mesh, speed in zip(parts, SPEEDS, strict=True)]
    alone = np.concatenate([end(body) for body in bodies], axis=1)
    scale = np.abs(alone).max(axis=(1, 2))
    assert scale[1] > 1.0
    assert (np.abs(end(one_body(parts)) - alone).max(axis=(1, 2)) > 1e-12 * scale).all()
    assert (np.abs(end(*bodies) - alone).max(axis=(1, 2)) <= 1e-13 * scale).all()
