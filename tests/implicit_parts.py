"""Small bodies in the middle of an implicit step, and tangents as matrices, for the tests of the implicit schemes."""

from dataclasses import replace

import numpy as np
import scenes
from scipy.sparse import bsr_matrix

import tcontact as tc
from tcontact.device import runtime
from tcontact.planning.planning import plan
from tcontact.schemes.implicit.solution.body import ImplicitBody
from tcontact.schemes.implicit.solution.cells import Cells

MATERIALS = {
    "linear": tc.LinearElastic(1e3, 0.3, 1.2),
    "svk": tc.StVenantKirchhoff(1e3, 0.3, 1.2),
    "neo": tc.NeoHookean(1e3, 0.3, 1.2),
    "mooney": tc.MooneyRivlin(150.0, 40.0, 500.0, 1.2),
}
OBSTACLES = {
    "plane": tc.Plane(point=(0, 0, 0.1), normal=(0.1, 0.2, 1.0)),
    "sphere": tc.Sphere(center=(0.4, 0.5, -1.0), radius=1.1),
    "bowl": tc.Sphere(center=(0.4, 0.5, 1.9), radius=1.8, inside=True),
    "cylinder": tc.Cylinder(point=(0.4, 0.5, -1.0), axis=(1.0, 0.3, 0.1), radius=1.1),
    "box": tc.Box(center=(0.4, 0.5, -0.9), size=(1.3, 1.2, 2.0)),
    "sdf": tc.Sdf(
        distance=lambda x: np.linalg.norm(x - (0.4, 0.5, -1.0), axis=1) - 1.1,
        origin=(-1.0, -1.0, -1.0), spacing=0.25, nodes=(13, 13, 11),
    ),
}  # fmt: skip


def body(law="neo", kind="hex8", formulation="full", cells=(2, 1, 1), **options):
    """A shaken unit block."""
    mesh = scenes.block(kind, cells, size=(1.0, 1.0, 1.0), shake=0.1)
    return tc.Body(mesh, MATERIALS[law], formulation=formulation, **options)


def cells_of(body):
    """Its cells in the user's numbering."""
    runtime.start("cpu")
    return Cells(body.blocks[0], np.array(body.mesh.nodes), np.array(body.mesh.cells))


def moves(count, size=0.05, seed=0):
    """Displacement and increment [n, 3]."""
    generator = np.random.default_rng(seed)
    return size * generator.standard_normal((count, 3)), size * generator.standard_normal((count, 3))


def dense(blocks, sparsity):
    """Blocks as a matrix."""
    count = 3 * len(sparsity.diagonal)
    return bsr_matrix((blocks, sparsity.columns, sparsity.starts), shape=(count, count)).toarray()


def differences(function, d, step=1e-5):
    """Fourth-order central differences of function(d) [n, 3] along every component of d [n, 3]."""
    columns = []
    for place in range(d.size):
        unit = np.zeros(d.size)
        unit[place] = step
        off = unit.reshape(d.shape)
        near = function(d + off) - function(d - off)
        columns.append((8.0 * near - (function(d + 2 * off) - function(d - 2 * off))).reshape(-1) / (12.0 * step))
    return np.stack(columns, axis=1)


def in_step(scheme, obstacle, law="neo", contact=None, **options):
    """An ImplicitBody that touches the obstacle, ready to evaluate a step; and its increment d [n, 3]."""
    own = body(law, **options)
    low, lift = np.array(own.mesh.nodes)[own.mesh.nodes_of("zmin")], 0.0
    for _ in range(40):
        lift -= np.median(obstacle.gap(low + np.array([0.0, 0.0, lift]))) + 0.01
    own = replace(own, contact="zmin", displacement=(0.0, 0.0, lift))
    scene = tc.Scene(bodies=[own], obstacles=[obstacle], duration=1.0, contact=contact or tc.PenaltyContact(1e4))
    runtime.start("cpu")
    planned = plan(scene).bodies[0]
    stepped = ImplicitBody(scene, planned, scheme)
    u0, d = (part[planned.node_order] for part in moves(own.mesh.node_count, 0.04))
    u0[:, 2] += lift
    level = stepped._level(u0, np.zeros_like(u0), np.zeros_like(u0))
    stepped._forces(level)
    past = scheme.past
    stepped.equations.prepare(u0, *scheme.inertia(0.1, level.v, level.a), past * level.force, past * level.contact)
    return stepped, d
