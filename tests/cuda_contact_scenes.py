"""Scenes with contact that threads of a CUDA device step, and what the tests compare of them with the CPU."""

from __future__ import annotations

import dataclasses

import numpy as np
import tiers
from cuda_layer_scenes import STEP, baked, branded, fused, grooved
from cuda_pair_scenes import padded, paired, stacked, touched
from oracle import meshes
from scenes import block, wall

import tcontact as tc
from tcontact.device import arrays
from tcontact.planning.planning import plan
from tcontact.schemes.explicit.stable_step import StableStep

TURN = meshes.rotation(17)
LAW = tc.NeoHookean(2.3e7, 0.3, 1350.0)
SAGGING = tc.StVenantKirchhoff(2.3e7, 0.27, 1350.0)  # under compression it loses its stiffness
METAL = tc.ElastoPlastic(7e10, 0.33, 2700.0, tc.LinearHardening(2e8, 1e9), specific_heat=900.0)
DOWN = np.array([0.0, 0.0, 1.0])
SPEED = 6.0


def thrown(mesh, material=LAW, speed=SPEED, gap=2e-3, formulation="full", contact="auto", **options):
    """A scene of a body thrown at a plane below it, and its scheme; options: of `tc.MasslessContact`, `duration`."""
    duration, friction = options.pop("duration", 1.2e-2), options.pop("friction", None)
    body = tc.Body(mesh, material, (0.3 * speed, 0.0, -speed), formulation=formulation, contact=contact)
    model = tc.MasslessContact(**options)
    scene = tc.Scene([body], [wall(mesh, DOWN, gap)], duration, contact=model, friction=friction)
    return scene, tc.CentralDifference(cfl=0.6)


def rising(obstacle, speed):
    """The obstacle, moving upwards."""
    return dataclasses.replace(obstacle, velocity=(0.0, 0.0, speed))


def free_ball(mesh, radius):
    """A ball of 4 kg that spins and moves freely, 2 mm below the middle of a mesh."""
    below = mesh.nodes.mean(axis=0) - (np.ptp(mesh.nodes[:, 2]) / 2 + radius + 2e-3) * DOWN
    return tc.Sphere(tuple(below), radius, mass=4.0, angular_velocity=(0.0, 5.0, 0.0))


def loaded(scene, *loads):
    """The scene with loads on its first body."""
    first, *others = scene.bodies
    return dataclasses.replace(scene, bodies=[dataclasses.replace(first, loads=loads), *others])


def normal():
    """Normal removal, with gravity and damping."""
    scene, scheme = thrown(block(cells=(4, 3, 3), shake=0.1), removal="normal")
    parts = {"gravity": (0.0, 0.0, -9.81), "damping": tc.MassDamping(rate=20.0)}
    return tc.Scene(scene.bodies, scene.obstacles, scene.duration, contact=scene.contact, **parts), scheme


def full():
    """Full removal, edge first, in tets under a pressure that varies."""
    scene, scheme = thrown(block("tet4", 3, turn=TURN), removal="full")
    return loaded(scene, tc.Load("zmax", pressure=lambda t: 3e4 * (1.0 + np.sin(900.0 * t)))), scheme


def linear():
    """The linear law at a plane, whose solve is a single linear problem."""
    return thrown(block(cells=3, shake=0.1), tc.LinearElastic(2.3e7, 0.3, 1350.0), removal="full")


def sprung():
    """A penalty on massless nodes, and one-point hexes."""
    return thrown(block(cells=3), formulation="reduced", penalty=3e10)


def ball():
    """Two bodies that hit a large sphere beside each other: two islands with nodes of their own."""
    parts = [
        tc.Body(block("tet4", cells, shift=shift), LAW, (0.0, 0.0, -SPEED), contact=["zmin"], name=name)
        for name, cells, shift in (("left", 3, (-0.3, -0.1, 0.0)), ("right", 2, (0.05, -0.1, 0.005)))
    ]
    sphere = tc.Sphere((0.0, 0.0, -2.0), 1.99)
    return tc.Scene(parts, [sphere], 8e-3, contact=tc.MasslessContact(removal="full")), tc.CentralDifference(cfl=0.6)


def forged():
    """A metal that flows and slides at a plane, with viscous contact cells; its strength grows much with the rate."""
    options = {"formulation": "mean-dilatation", "removal": "normal", "friction": tc.Coulomb(0.1)}
    metal = dataclasses.replace(METAL, hardening=tc.JohnsonCook(2e8, 1e9, 0.7, rate_factor=0.2))
    return thrown(block(cells=3, shake=0.1), metal, 60.0, duration=3e-4, **options)


def corner():
    """A corner of two planes, whose loads are columns of their own, and supports that functions of time move.

    A pressure and a traction act, the latter on nodes in contact too.
    """
    mesh = block(cells=(3, 3, 4), shake=0.1)
    top = tc.Support("zmax", "yz", displacement=lambda t: (1e-3 * np.sin(600.0 * t), -4.0 * t - 200.0 * t**2))
    side = tc.Support("xmax", "x", velocity=lambda t: -4.0 * np.cos(900.0 * t))
    body = tc.Body(mesh, LAW, (-SPEED, 0.0, -SPEED), supports=[top, side], contact=["zmin", "xmin"])
    walls = [wall(mesh, DOWN, 2e-3), wall(mesh, [1.0, 0.0, 0.0], 4e-3)]
    scene = tc.Scene([body], walls, 8e-3, contact=tc.MasslessContact(removal="full"))
    loads = tc.Load("ymax", pressure=2e4), tc.Load("zmin", traction=(1e4, -2e4, 5e3))
    return loaded(scene, *loads), tc.CentralDifference(cfl=0.6)


def sagged():
    """A body that loses its stiffness at the plane: a static solve does not converge."""
    return thrown(block(cells=3, shake=0.1), SAGGING, 90.0, duration=1e-2)


def sank():
    """A body like `sagged` that falls first: its solve fails amid a block of steps (test_rank_cuda.py)."""
    return thrown(block(cells=3, shake=0.1), SAGGING, 90.0, gap=0.3, duration=1e-2)


def crushed():
    """A body and a plane that meet so fast that a cell inverts: their last block of steps is taken again."""
    scene, scheme = thrown(block(cells=3, shake=0.1), SAGGING, 30.0, duration=1e-2)
    return dataclasses.replace(scene, obstacles=[rising(scene.obstacles[0], 10.0)]), scheme


def fast():
    """A body that is crushed as fast as sound: its step is shortened again and again, alike on all devices."""
    return thrown(block(cells=3, shake=0.1), LAW, 130.0, duration=6e-3)


def rubbed():
    """Coulomb friction in the static solve, edge first, in tets: nodes stick and slip."""
    return thrown(block("tet4", 3, turn=TURN), removal="full", friction=tc.Coulomb(0.2))


def wedged():
    """A valley of two planes with laws of their own, one by slip speed and pressure: nodes with several rows.

    No node touches both planes, where friction would have no unique share of each.
    """
    mesh = block(cells=3, shake=0.1)
    body = tc.Body(mesh, LAW, (0.3 * SPEED, 0.0, -SPEED), contact=["zmin"])
    table = tc.FrictionTable([0.0, 1.0, 4.0], [1e4, 1e6], [[0.4, 0.3], [0.3, 0.2], [0.1, 0.05]])
    left, right = wall(mesh, [0.28, 0.0, 0.96], 2e-3), wall(mesh, [-0.28, 0.0, 0.96], 3e-3)
    walls = [dataclasses.replace(left, friction=table), right]
    options = {"contact": tc.MasslessContact(removal="full"), "friction": tc.Coulomb(0.1)}
    return tc.Scene([body], walls, 8e-3, **options), tc.CentralDifference(cfl=0.6)


def edged():
    """A body that lands above the edges of two blocks of one height, and slides over their seam."""
    mesh = block(cells=3)
    low, high = mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
    size, middle = high - low, 0.5 * (low + high)
    floor = [
        tc.Box((middle[0] + shift, middle[1], low[2] - 0.502), (size[0], size[1], 1.0), name=name)
        for name, shift in (("back", -0.25 * size[0]), ("front", 0.75 * size[0]))
    ]
    body = tc.Body(mesh, tc.LinearElastic(2.3e7, 0.0, 1350.0), (0.5 * SPEED, 0.0, -SPEED), contact=["zmin"])
    scene = tc.Scene([body], floor, 8e-3, contact=tc.MasslessContact(removal="full"))
    return scene, tc.CentralDifference(cfl=0.6)


def crept():
    """Regularised friction in the static solve."""
    law = tc.RegularizedCoulomb(0.2, 0.1)
    return thrown(block(cells=3, shake=0.1), removal="full", friction=law, duration=8e-3)


def slowed():
    """Friction of the kick, that falls with the slip speed up to a largest shear stress, with gravity and damping.

    The contact cells are viscous, as with all such scenes unless told otherwise: hexes, and tets of the linear law.
    """
    law = tc.Coulomb(static=0.4, kinetic=0.1, decay=2.0, limit=2e5)
    scene, scheme = thrown(block(cells=3, shake=0.1), removal="normal")
    tets, linear = block("tet4", 3, shift=(0.5, 0.0, 0.0)), tc.LinearElastic(2.3e7, 0.3, 1350.0)
    bodies = [*scene.bodies, tc.Body(tets, linear, (2.0, 0.0, -SPEED), contact=["zmin"], name="tets")]
    parts = {"gravity": (0.0, 0.0, -9.81), "damping": tc.MassDamping(rate=20.0), "friction": law}
    return tc.Scene(bodies, scene.obstacles, 8e-3, contact=scene.contact, **parts), scheme


def pressed():
    """A nearly incompressible body with full removal, in two islands of which one lands later: MPRGP solves.

    It is solved almost to rounding error: a larger tolerance is met a product earlier or later, as rounding decides.
    """
    soft = tc.NeoHookean(2.3e7, 0.48, 1350.0)
    parts = [
        tc.Body(block(cells=cells, shift=shift, shake=0.1), soft, (2.0, 0.0, -SPEED), contact=["zmin"], name=name)
        for name, cells, shift in (("left", 3, (0.0, 0.0, 0.0)), ("right", 2, (0.5, 0.0, 0.002)))
    ]
    ground, model = tc.Plane((0.0, 0.0, -0.001), (0.0, 0.0, 1.0)), tc.MasslessContact(removal="full", tolerance=1e-10)
    return tc.Scene(parts, [ground], 4e-3, contact=model), tc.CentralDifference(cfl=0.6)


def repelled():
    """Contact by penalty with friction, a top that a support holds, and a ball that moves freely."""
    mesh = block(cells=3, shake=0.1)
    body = tc.Body(mesh, LAW, (0.3 * SPEED, 0.0, -SPEED), contact=["zmin"], supports=[tc.Support("zmax", "y")])
    options = {"contact": tc.PenaltyContact(1e10), "friction": tc.Coulomb(0.2)}
    obstacles = [wall(mesh, DOWN, 2e-3), free_ball(mesh, 0.1)]
    return tc.Scene([body], obstacles, 6e-3, **options), tc.CentralDifference(cfl=0.6)


def struck():
    """Contact by impulses with a slanted plane that moves, with friction; the pressure varies from face to face."""
    scene, scheme = wedged()
    options = {"contact": tc.ImpulseContact(), "friction": tc.Coulomb(0.1)}
    scene = tc.Scene(scene.bodies, [rising(scene.obstacles[1], 2.0)], 6e-3, **options)
    return loaded(scene, tc.Load("zmax", pressure=lambda t, x: 4e4 * np.cos(300.0 * t) + 1e5 * x[:, 0])), scheme


def swept():
    """Friction in the static solve on a plane that a function of time moves, below a ball that spins and falls."""
    mesh = block(cells=3, shake=0.1)
    body = tc.Body(mesh, LAW, (0.0, 0.0, -2.0), contact=["zmin", "zmax"])
    plane = dataclasses.replace(wall(mesh, DOWN, 2e-3), velocity=lambda t: (4.0 * np.cos(900.0 * t), 1.0, 300.0 * t))
    above = mesh.nodes.mean(axis=0) + (np.ptp(mesh.nodes[:, 2]) / 2 + 0.401) * DOWN
    ball = tc.Sphere(tuple(above), 0.4, velocity=(0.0, 0.0, -4.0), angular_velocity=(0.0, 20.0, 5.0))
    options = {"contact": tc.MasslessContact(removal="full"), "friction": tc.Coulomb(0.2)}
    return tc.Scene([body], [plane, ball], 9e-3, **options), tc.CentralDifference(cfl=0.6)


def spun():
    """Friction of the kick that falls with the slip speed, on a cylinder that turns and rises."""
    law = tc.Coulomb(static=0.4, kinetic=0.1, decay=2.0, limit=2e5)
    mesh = block(cells=3, shake=0.1)
    scene, scheme = thrown(mesh, removal="normal", cell_viscosity=0.0, friction=law, duration=6e-3)
    below = mesh.nodes.mean(axis=0) - (np.ptp(mesh.nodes[:, 2]) / 2 + 0.502) * DOWN
    roller = tc.Cylinder(tuple(below), (0.0, 1.0, 0.0), 0.5, angular_velocity=(0.0, 30.0, 0.0))
    return dataclasses.replace(scene, obstacles=[rising(roller, 1.0)]), scheme


def carried():
    """A ball that moves freely below a block, with full removal and friction.

    It ends before they part: a run lets its step grow at the end of a block of rows, which is longer on the CPU.
    """
    mesh = block(cells=3, shake=0.1)
    body = tc.Body(mesh, LAW, (2.0 * SPEED, 0.0, -SPEED), contact=["zmin"])
    options = {"contact": tc.MasslessContact(removal="full", tolerance=1e-10), "friction": tc.Coulomb(0.1)}
    options |= {"gravity": (0.0, 0.0, -9.81)}
    return tc.Scene([body], [free_ball(mesh, 0.3)], 1.3e-3, **options), tc.CentralDifference(cfl=0.6)


def floated():
    """Viscous contact cells and friction of the kick on a light plate that moves freely, beside a plane that rises."""
    mesh = block(cells=3, shake=0.1)
    body = tc.Body(mesh, LAW, (0.3 * SPEED, 0.0, -SPEED), contact=["zmin"])
    plate = dataclasses.replace(wall(mesh, DOWN, 2e-3), mass=5.0, inertia=(0.1, 0.1, 0.2))
    low = rising(wall(mesh, DOWN, 8e-3), 1.0)
    options = {"contact": tc.MasslessContact(removal="normal"), "friction": tc.Coulomb(0.2)}
    return tc.Scene([body], [plate, low], 1.5e-3, **options), tc.CentralDifference(cfl=0.6)


def held():
    """Supports without contact, one that holds and one that moves, with damping, springs and dashpots; gravity and a
    force are functions of time."""
    supports = [tc.Support("zmax", "xyz"), tc.Support("zmin", "x", velocity=2.0)]
    springs = [tc.Spring("ymin", 2e6, 300.0, to="ymax", rest_length=0.2), tc.Spring("ymax", 1e6, 200.0, axes="yz")]
    body = tc.Body(block(cells=3, shake=0.1), LAW, supports=supports, springs=springs)
    gravity = lambda t: (40.0 * np.sin(500.0 * t), 0.0, -9.81)  # noqa: E731
    options = {"contact": None, "gravity": gravity, "damping": tc.MassDamping(rate=20.0)}
    force = tc.Load("xmax", force=lambda t: (300.0 * np.cos(400.0 * t), 0.0, 100.0))
    return loaded(tc.Scene([body], [], 6e-3, **options), force), tc.CentralDifference(cfl=0.6)


def paved():
    """Two bodies with more than a thousand contact nodes, which several blocks of threads take: friction of the kick,
    viscous contact cells, supports, gravity and damping; one lands later. The step is given, for equal times."""
    parts = [
        tc.Body(
            block(cells=(cells, cells, 2), shift=shift, shake=0.1),
            LAW,
            (2.0, 0.0, -SPEED),
            contact=["zmin"],
            supports=[tc.Support("ymax", "y")] if name == "left" else [],
            name=name,
        )
        for name, cells, shift in (("left", 24, (0.0, 0.0, 0.0)), ("right", 20, (0.5, 0.0, 3e-4)))
    ]
    ground = tc.Plane((0.0, 0.0, -1e-4), (0.0, 0.0, 1.0))
    options = {"contact": tc.MasslessContact(removal="normal"), "friction": tc.Coulomb(0.2)}
    options |= {"gravity": (0.0, 0.0, -9.81), "damping": tc.MassDamping(rate=20.0)}
    return tc.Scene(parts, [ground], 2.8e-4, **options), tc.CentralDifference(dt=2e-5)


def leant():
    """Return a block held from behind beside a plane that leans, with friction: its stable step alone is searched."""
    mesh = tc.box_mesh((0.2, 0.15, 0.1), (3, 2, 2)).rotated(TURN)
    body = tc.Body(mesh, LAW, contact="zmin", supports=[tc.Support("zmax", "xyz")], formulation="full")
    contact = tc.MasslessContact("normal", cell_viscosity=1.0)
    obstacles = [wall(mesh, TURN[:, 2], 1e-3)]
    return tc.Scene([body], obstacles, 1e-3, contact=contact, friction=tc.Coulomb(0.4)), tc.CentralDifference()


FRICTIONLESS = (normal, full, linear, sprung, ball, corner, sagged, crushed, fast, pressed, held, edged)
WITH_FRICTION = (rubbed, wedged, crept, slowed, forged, carried, floated, repelled, struck, swept, spun, paved)
LAYERED = (baked, fused, branded, grooved)
PAIRED = (paired, stacked, touched, padded)
# scenes that combine what others have term by term: with --slow alone, since each has kernels of its own
COMBINED = () if tiers.slow() else (
    linear, corner, sagged, fast, rubbed, crept, struck, spun, carried, fused, branded, grooved, stacked, touched,
    padded,
)  # fmt: skip
# and those without which one scene of every kind of contact is left: with --long alone
MORE = () if tiers.long() else (
    normal, sprung, ball, crushed, pressed, held, edged, slowed, forged, floated, repelled, swept, paved,
)  # fmt: skip
LEFT_OUT = COMBINED + MORE
RUBBING = tuple(scene.__name__ for scene in WITH_FRICTION + LAYERED if scene not in LEFT_OUT)
SCENES = {scene.__name__: scene for scene in FRICTIONLESS + WITH_FRICTION + LAYERED + PAIRED if scene not in LEFT_OUT}
STEPS = {scene.__name__: STEP for scene in LAYERED} | {"paired": 2e-6}  # first ones [s], else 2e-5

# those that run with the threads in reversed order too
REVERSED = tiers.of_tier(
    ("wedged", "paired"),
    ("full", "slowed", "pressed", "held", "floated", "paved"),
    ("crushed", "corner", "swept", "baked") if tiers.slow() else (),
)
# those whose stable steps with viscous cells are compared, and the differences they may have: kept momenta have 32
# bits, which is seen where a small body has no other mode left
SEARCHED = {"slowed": slowed, "leant": leant} if tiers.long() else {}
SEARCHES = {"slowed": (1e-9, 1e-7), "leant": (1e-4, 1e-4, 1e-4, 1e-4)}
# those whose launches of a block are counted
COUNTED = tiers.of_tier(("wedged", "baked", "paired"), ("normal", "slowed", "repelled", "swept", "paved"))
# those that run once more with several blocks of threads, which few nodes do not get by themselves
SHARED = tiers.of_tier((), ("ball",))


def state_of(name):
    """Return the state of the one domain of a scene at its start."""
    scene, scheme = {**SCENES, **SEARCHED}[name]()
    zero = [body.initial_displacement for body in scene.bodies]
    (state,) = scheme.states(scene, plan(scene), zero, [body.initial_velocity for body in scene.bodies])
    return state


def damped_steps(name):
    """Return the class of the search, and stable steps [searches, bodies] [s] with viscous cells.

    The second search is at a displacement, the others are at rest; each starts from the mode of the one before.
    """
    state, found = state_of(name), []
    bodies = [StableStep(view.plan, state.scene.obstacles, None, view.viscous_force) for view in state.views]
    search, start = state.searches(bodies), np.array(arrays.get(state.u))
    move = 0.002 * np.random.default_rng(7).normal(size=start.size)
    for u in (start, start + move, start, start)[: len(SEARCHES[name])]:
        search.estimate(arrays.put(u))
        found.append([body.damped for body in bodies])
    return type(search).__name__, np.array(found)


def run(name, arch):
    """Return what a run leaves: positions, velocities, forces, columns of its history, steps and the reason."""
    scene, scheme = SCENES[name]()
    result = tc.simulate(scene, scheme, arch=arch, progress=False)
    found = {"position": result.position, "velocity": result.velocity, "node_force": result.contact_node_force}
    found |= {"steps": result.steps, "reason": result.reason, "memory": sum(result.memory.values())}
    return found | {f"history_{column}": np.asarray(values) for column, values in result.history.items()}
