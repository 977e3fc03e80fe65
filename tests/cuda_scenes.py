"""Scenes that run on a CUDA device and on the CPU, with what the tests of CUDA compare of them."""

from __future__ import annotations

import numpy as np
from oracle import meshes
from scenes import block

import tcontact as tc
from tcontact.cases import cube_impact
from tcontact.cells.device_force import DeviceForce
from tcontact.cells.internal_force import InternalForce
from tcontact.cells.shape_rates import ShapeRates
from tcontact.device import arrays, runtime
from tcontact.schemes.explicit.device_stable_step import stable_steps
from tcontact.schemes.explicit.stable_step import StableStep

TURN = meshes.rotation(17)
SOFT = tc.NeoHookean(2.3e7, 0.27, 1350.0)
SAGGING = tc.StVenantKirchhoff(2.3e7, 0.27, 1350.0)  # under compression it loses its stiffness
STIFF = tc.NeoHookean(6e7, 0.2, 3000.0)
HARDENING = tc.ElastoPlastic(7e10, 0.33, 2700.0, tc.LinearHardening(1e8, 1e9), specific_heat=900.0)
RATES = tc.ElastoPlastic(117e9, 0.35, 8930.0, tc.JohnsonCook(9e7, 3e8, 0.31), specific_heat=385.0)
SHOCKED = tc.ElastoPlastic(
    117e9, 0.35, 8930.0, tc.LinearHardening(4e8, 1e8), specific_heat=385.0, pressure=tc.MieGrueneisen(1.5, 2.0)
)
APART = 0.7  # between the bodies of a scene [m]


def bodies(*parts):
    """Bodies of (mesh, material, formulation) beside each other."""
    made = []
    for number, (mesh, material, formulation) in enumerate(parts):
        moved = tc.Mesh(mesh.nodes + np.array([APART * number, 0.0, 0.0]), mesh.cells, mesh.kind)
        made.append(tc.Body(moved, material, formulation=formulation, name=f"body{number}"))
    return made


def every_element():
    """Return bodies of every element that the thread of a cell computes, in every variant."""
    box = block(cells=2, shake=0.0)
    turned, shaken = block(cells=2, shake=0.0, turn=TURN), block(cells=(3, 2, 2), turn=TURN)
    whole = [(mesh, SOFT, name) for name in ("full", "mean-dilatation") for mesh in (box, turned, shaken)]
    rest = [(turned, SOFT, "reduced"), (shaken, SOFT, "reduced"), (block("tet4", 2, turn=TURN), SOFT, "full")]
    prisms = block("wedge6", 2, turn=TURN)
    return bodies(*whole, *rest, (prisms, SOFT, "full"))


def every_law():
    """Return bodies of every law, two of one law with other constants, and of metals in every formulation."""
    tets, hexes, box = block("tet4", 2, turn=TURN), block(cells=(3, 2, 2), turn=TURN), block(cells=2, shake=0.0)
    return bodies(
        (box, tc.LinearElastic(3e7, 0.3, 2000.0), "full"),
        (box, tc.LinearElastic(2e7, 0.2, 1000.0), "mean-dilatation"),
        (tets, tc.StVenantKirchhoff(3e7, 0.3, 2000.0), "full"),
        (tets, tc.MooneyRivlin.of(1.2e7, 0.35, 1100.0), "full"),
        (tets, tc.Ogden.of(1.2e7, 0.35, 1100.0), "full"),
        (hexes, SOFT, "full"),
        (block(cells=2, turn=TURN), STIFF, "full"),
        (hexes, HARDENING, "full"),
        (hexes, RATES, "mean-dilatation"),
        (box, RATES, "reduced"),
        (hexes, SHOCKED, "reduced"),
    )


def forces(force_class, bodies):
    """Return the internal force [n, 3] of bodies at a random displacement, and the sums over nodes and cells."""
    (domain,) = tc.plan(tc.Scene(bodies, [], 1e-3, contact=None)).domains
    fields = [
        0.02 * body.mesh.shortest_edge * np.random.default_rng(5).normal(size=(body.mesh.node_count, 3))
        for body in bodies
    ]
    u = np.concatenate([u[plan.node_order] for u, plan in zip(fields, domain.bodies, strict=True)]).reshape(-1)
    out, force = arrays.zeros(u.size), force_class(domain)
    force.minus_force(arrays.put(u), out)
    return -np.array(arrays.get(out)).reshape(-1, 3) * domain.lumped[:, None], np.array(force.sums())


def rates(force_class, bodies):
    """Return the shape rates [2, bodies] of bodies at a random displacement, now and with half of it added."""
    (domain,) = tc.plan(tc.Scene(bodies, [], 1e-3, contact=None)).domains
    u = np.random.default_rng(5).normal(size=(len(domain.reference), 3)) * 0.004
    before = arrays.zeros(u.size)
    found = ShapeRates(domain, force_class(domain), arrays.put(u), before)
    answer = found.measure(0.5)
    found.remember()
    assert np.array_equal(arrays.get(before).reshape(-1, 3), u)
    return answer


def stable_steps_of(name):
    """Return the stable steps [3, bodies] [s] of three searches: at the start of a scene, then displaced twice."""
    scene = RUNS[name]()[0]
    (domain,) = tc.plan(scene).domains
    force = (DeviceForce if runtime.arch() == "cuda" else InternalForce)(domain)
    search = stable_steps(force.without_boundary(), [StableStep(body, [], None) for body in domain.bodies])
    parts = [body.body.initial_displacement[body.node_order] for body in domain.bodies]
    start, found = np.concatenate(parts).reshape(-1), []
    move = 0.002 * np.random.default_rng(7).normal(size=start.size)
    for u, products in ((start, 20), (start + move, 6), (start - move, 20)):
        smallest = search.estimate(arrays.put(u), products=products)
        found.append([body.elastic for body in search.bodies])
        assert smallest == min(found[-1])
    return np.array(found)


def tumbling():
    """Return two blocks of two laws and kinds of cells that spin under gravity with damping, and their scheme."""
    parts = bodies((block(turn=TURN), SOFT, "full"), (block("tet4", 2), tc.StVenantKirchhoff(3e7, 0.3, 2000.0), "full"))
    spin = np.array([20.0, -30.0, 50.0])
    moving = [
        tc.Body(
            body.mesh,
            body.material,
            lambda x: np.cross(spin, x) + 40.0 * x[:, [1, 2, 0]],
            displacement=lambda x: 0.02 * np.sin(9.0 * x[:, [2, 0, 1]]),
            formulation=body.formulation,
            name=body.name,
        )
        for body in parts
    ]
    scene = tc.Scene(moving, [], 8e-3, gravity=(0.0, 3.0, -9.81), contact=None, damping=tc.MassDamping(rate=30.0))
    return scene, tc.CentralDifference(dt=8e-5)


def forged():
    """Return blocks of two metals, stretched beyond their yield stress, and their scheme."""
    parts = bodies(
        (block(cells=2), HARDENING, "full"),
        (block(cells=2, turn=TURN), RATES, "mean-dilatation"),
        (block(cells=2), RATES, "reduced"),
    )
    moving = [
        tc.Body(body.mesh, body.material, lambda x: 900.0 * (x[:, [1, 2, 0]] - 0.1), formulation=body.formulation,
                name=body.name)
        for body in parts
    ]  # fmt: skip
    return tc.Scene(moving, [], 4e-4, contact=None), tc.CentralDifference(dt=6e-6)


def crushed():
    """Return a block whose ends rush together until a cell inverts, and its scheme."""
    body = tc.Body(block(cells=2, shake=0.1), SAGGING, lambda x: 1200.0 * (0.1 - x), name="crushed")
    return tc.Scene([body], [], 4e-3, contact=None), tc.CentralDifference(dt=1e-5)


def wall():
    """Return a cube that hits a wall, which the kernels of the CPU step on the device, and its scheme."""
    return cube_impact.scene(cells=2), tc.CentralDifference(cfl=0.5)


CONTACT = {"wall": wall}
RUNS = {"tumbling": tumbling, "forged": forged, "crushed": crushed}
FORCES = {"every_element": every_element, "every_law": every_law}


def run(name, arch):
    """Return what a run leaves: positions, velocities, columns of its history, steps and the reason of its end."""
    scene, scheme = (RUNS | CONTACT)[name]()
    result = tc.simulate(scene, scheme, arch=arch, progress=False)
    found = {"position": result.position, "velocity": result.velocity, "steps": result.steps, "reason": result.reason}
    found["memory"] = sum(result.memory.values())
    return found | {f"history_{column}": np.asarray(values) for column, values in result.history.items()}
