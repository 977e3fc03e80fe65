"""Scenes for runs on several ranks: together they have every term of explicit scenes, in small."""

import dataclasses

import mixed_meshes
import numpy as np

import tcontact as tc

SIZE = np.array([0.1, 0.08, 0.12])
LAWS = {"linear": tc.LinearElastic(2.3e7, 0.27, 1350.0), "neo": tc.NeoHookean(2.3e7, 0.27, 1350.0)}
EXACT = 1e-11  # of the static solve: sweeps must not stop a rounding error earlier on some ranks


def block(law="linear", counts=(4, 3, 5), kind="hex8", at=(0.0, 0.0, 1e-4), velocity=(1.0, 0.5, -8.0), **given):
    """A block above the plane z = 0."""
    mesh = tc.box_mesh(SIZE, counts, kind=kind).translated(at)
    material = LAWS[law] if isinstance(law, str) else law
    return tc.Body(mesh, material, velocity=velocity, **given)


def free():
    """Flight of two bodies that deform, one of tetrahedra, in a field of gravity."""
    bodies = [
        block("neo", kind="tet4", velocity=lambda x: 30.0 * np.cos(40.0 * x[:, [2, 0, 1]])),
        block("neo", counts=(3, 3, 3), at=(0.5, 0.0, 0.0), velocity=lambda x: 20.0 * np.sin(30.0 * x[:, [1, 2, 0]])),
    ]
    return tc.Scene(bodies, duration=2e-3, gravity=(0.0, 3.0, -9.81))


def normal():
    """Impact with normal removal, of a law whose stable step is followed; bulk viscosity and damping."""
    contact = tc.MasslessContact(removal="normal", tolerance=EXACT)
    terms = {"viscosity": tc.BulkViscosity(), "damping": tc.MassDamping(50.0)}
    return tc.Scene([block("neo", contact="zmin")], [tc.Plane()], 2e-3, contact=contact, gravity=(0, 0, -9.81), **terms)


def corner():
    """Impact into a corner with full removal and friction."""
    walls = [tc.Plane(), tc.Plane((-1e-4, 0.0, 0.0), (1.0, 0.0, 0.0))]
    body = block(contact=("zmin", "xmin"), velocity=(-5.0, 2.0, -8.0))
    contact = tc.MasslessContact(removal="full", tolerance=EXACT)
    return tc.Scene([body], walls, 1.5e-3, contact=contact, friction=tc.Coulomb(0.3))


def layered():
    """Impact into a corner with full removal and friction layers."""
    return dataclasses.replace(corner(), duration=6e-4, friction=tc.FrictionLayer())


def pushed():
    """A plane that a function of time moves pushes with a penalty; a probe."""
    wall = tc.Plane(velocity=lambda t: (0.0, 0.0, 8.0 + 2e3 * t))
    body = block(contact="zmin", velocity=(0.0, 0.0, 0.0), probes=[tc.Probe("zmax", "velocity")])
    return tc.Scene([body], [wall], 1.5e-3, contact=tc.PenaltyContact(stiffness=2e9))


def impulses():
    """Impact with impulses, of two materials, periodic along y; what acts on sides that repeat, and probes of them."""
    body = block()
    upper = body.mesh.cell_centres()[:, 2] > 0.06
    sets = {"upper": np.flatnonzero(upper), "lower": np.flatnonzero(~upper)}
    side = {"side": body.mesh.nodes_of("ymax")}
    material = {"lower": LAWS["linear"], "upper": tc.LinearElastic(7e7, 0.2, 2100.0)}
    body = tc.Body(body.mesh.with_sets(side, cell_sets=sets), material, velocity=(0.0, 0.0, -5.0), contact="zmin",
                   periodic="y", point_masses=[tc.PointMass("side", 0.1)], springs=[tc.Spring("side", 1e6)],
                   loads=[tc.Load("side", force=(0.0, 300.0, 0.0))],
                   probes=[tc.Probe("side", name) for name in ("position", "acceleration", "stress")])  # fmt: skip
    return tc.Scene([body], [tc.Plane()], 1.5e-3, contact=tc.ImpulseContact())


def held():
    """Supports at rest and driven, loads, a spring and a point mass."""
    supports = [tc.Support("xmin", "xy"), tc.Support("zmax", "z", velocity=lambda t: -4.0 * np.sin(2e3 * t))]
    loads = [tc.Load("xmax", pressure=lambda t: 1e6 * np.sin(3e3 * t)), tc.Load("ymax", force=(0.0, 200.0, 0.0))]
    body = block(
        velocity=(0.0, 0.0, 0.0), counts=(6, 3, 5), supports=supports, loads=loads,
        springs=[tc.Spring("zmin", 2e5, damping=300.0)], point_masses=[tc.PointMass("zmin", 0.2)],
    )  # fmt: skip
    return tc.Scene([body], duration=2e-3, gravity=(0.0, 0.0, -9.81))


def pull(t):
    """Gravity as a function of time."""
    return 2e4 * np.sin(4e3 * t), 500.0, -9.81 - 1e7 * t


def pulled():
    """Gravity as a function of time on a body that hits a plane, with damping and a force of its own on a side."""
    contact, damping = tc.MasslessContact(tolerance=EXACT), tc.MassDamping(200.0)
    drag = tc.Load("xmin", force=lambda x, v, t: (2e4 * t - 4.0 * v) * (1.0 + x[:, 1:2]))
    return tc.Scene(
        [block("neo", contact="zmin", loads=[drag])], [tc.Plane()], 1e-3, gravity=pull, contact=contact, damping=damping
    )


def adrift():
    """Gravity as a function of time on a body of two blocks that nothing connects, so that two ranks share no node."""
    one, other = (tc.box_mesh(SIZE, (3, 3, 3)).translated((x, 0.0, 0.5)) for x in (0.5, 0.8))
    nodes, cells = np.concatenate([one.nodes, other.nodes]), np.concatenate([one.cells, other.cells + one.node_count])
    body = tc.Body(tc.Mesh(nodes, cells, "hex8"), LAWS["neo"], velocity=lambda x: 20.0 * np.sin(30.0 * x[:, [1, 2, 0]]))
    return tc.Scene([body], duration=1e-3, gravity=pull)


def pair():
    """Two blocks that hit each other with friction, the lower one held on a side away from the contact."""
    lower = block(counts=(3, 3, 5), at=(0.003, -0.004, -0.1201), velocity=(0.0, 0.0, 0.0), contact="zmax", name="lower",
                  supports=[tc.Support("zmin", "xyz")])  # fmt: skip
    upper = block(contact="zmin", name="upper")
    contact = tc.MasslessContact(tolerance=EXACT)
    return tc.Scene([lower, upper], duration=1.2e-3, contact=contact, friction=tc.Coulomb(0.2))


def rigid():
    """A body with a rigid part falls onto a plate that moves freely."""
    plate = tc.Plane(mass=2.0, inertia=0.02, name="plate")
    body = block(contact="zmin", rigid_parts=[tc.RigidPart("zmax", mass=0.5)])
    return tc.Scene([body], [plate], 1.5e-3, contact=tc.MasslessContact(tolerance=EXACT))


def metal():
    """A metal that flows and warms, without contact."""
    hardening = tc.LinearHardening(2e8, 1e9)
    material = tc.ElastoPlastic(7e10, 0.33, 2700.0, hardening=hardening, specific_heat=900.0)
    body = block(material, counts=(2, 2, 9), velocity=lambda x: 300.0 * np.sin(26.0 * x[:, [2, 2, 2]]) * (0, 0.3, 1))
    return tc.Scene([body], duration=6e-5)


def sensed():
    """A metal that flows, with probes over some cells and over all, and maxima of all, of which no two are alike."""
    scene = metal()
    mesh = scene.bodies[0].mesh
    mesh = mesh.with_sets(cell_sets={"lowest": np.flatnonzero(mesh.cell_centres()[:, 2] < 0.02)})
    mesh = mesh.with_sets(cell_sets={"all": np.arange(mesh.cell_count)}, node_sets={"any": np.arange(mesh.node_count)})
    probes = [tc.Probe("lowest", "von_mises"), tc.Probe("lowest", "plastic_strain"), tc.Probe("zmin", "velocity")]
    probes += [tc.Probe("all", quantity) for quantity in ("stress", "plastic_strain", "position")]
    probes += [tc.Probe("any", "temperature"), tc.Probe("any", "acceleration")]
    tilted = 300.0 * np.sin(26.0 * mesh.nodes[:, [2, 2, 2]]) * (0, 0.3, 1) * (1.0 + mesh.nodes[:, :1])
    body = dataclasses.replace(scene.bodies[0], mesh=mesh, probes=probes, velocity=tilted)
    return tc.Scene([body], duration=6e-5, maxima=["von_mises", "pressure", "plastic_strain"])


def mixed():
    """An L of hexahedra, prisms and tetrahedra falls on a plane."""
    mesh = mixed_meshes.corner(counts=(6, 2, 4)).translated((0.0, 0.0, 1e-5))
    body = tc.Body(mesh, LAWS["linear"], velocity=(1.0, 0.0, -5.0), contact="zmin")
    return tc.Scene([body], [tc.Plane()], 6e-4, contact=tc.MasslessContact(tolerance=EXACT))


def crushed():
    """A body that hits the plane so fast that a cell inverts, which stops the run.

    By a penalty: a static solve of an inverted cell has no answer to compare.
    """
    contact = tc.PenaltyContact(stiffness=2e10)
    law = tc.StVenantKirchhoff(2.3e7, 0.27, 1350.0)
    return tc.Scene([block(law, velocity=(1.0, 0.5, -45.0), contact="zmin")], [tc.Plane()], 3e-3, contact=contact)


def burst():
    """Flight with steps above the stable one: the energy grows until that stops the run."""
    swaying = block("linear", velocity=lambda x: 3.0 * np.cos(40.0 * x[:, [2, 0, 1]]))
    return tc.Scene([swaying], duration=9e-3)


def uneven(x):
    """Velocity of a foot that arrives in parts."""
    still = np.zeros(len(x))
    return np.stack([still + 1.0, still, 300.0 * (x[:, 0] - 0.05) * np.cos(60.0 * x[:, 1]) - 8.0], axis=1)


def halves():
    """Ranks share the contact of two bodies with a plane that swings: hexahedra, and tetrahedra held on a side.

    The first one arrives unevenly and lifts off, so that nodes with and without contact act on each other.
    """
    plane = tc.Plane(velocity=lambda t: (0.0, 0.0, 3.0 * np.sin(1e3 * t)))
    mesh = tc.box_mesh((0.05, 0.04, 0.06), (3, 3, 3), kind="tet4").translated((0.2, 0.0, 2e-4))
    small = tc.Body(mesh, LAWS["linear"], velocity=(0.0, 0.0, -6.0), contact="zmin", supports=[tc.Support("xmin", "x")])
    contact = tc.MasslessContact(removal="normal", tolerance=EXACT)
    bodies = [block(counts=(6, 5, 3), contact="zmin", velocity=uneven), small]
    return tc.Scene(bodies, [plane], 1.6e-3, contact=contact, gravity=(0, 0, -9.81), damping=tc.MassDamping(50.0))


def walls():
    """Ranks share contact that reaches every cell: full removal and friction in a corner, nodes that supports hold."""
    planes = [tc.Plane(), tc.Plane((-1e-4, 0.0, 0.0), (1.0, 0.0, 0.0))]
    held = [tc.Support("ymin", "xyz"), tc.Support("ymax", "x")]
    body = block(contact=("zmin", "xmin"), counts=(2, 5, 4), velocity=(-5.0, 2.0, -8.0), supports=held)
    contact = tc.MasslessContact(removal="full", tolerance=EXACT)
    return tc.Scene([body], planes, 1.2e-3, contact=contact, friction=tc.Coulomb(0.3), gravity=(0.0, 0.0, -9.81))


def springy():
    """Ranks share the penalty on massless nodes, of a law whose tangent follows the motion."""
    contact = tc.MasslessContact(removal="full", penalty=1e12, tolerance=1e-9)
    return tc.Scene([block("neo", counts=(6, 4, 3), contact="zmin")], [tc.Plane()], 1e-3, contact=contact)


def rubbed():
    """Ranks share viscous contact cells: normal removal with friction, of hexahedra, and tetrahedra of another law.

    Probes: of nodes without mass, and of cells at them.
    """
    probes = [tc.Probe("zmin", quantity) for quantity in ("velocity", "acceleration", "position", "pressure")]
    feet = [foot((3, 3, 3), (0.2, 0.0, 2e-4), contact="zmin")]
    bodies = [block("neo", counts=(4, 4, 3), contact="zmin", velocity=(6.0, 1.0, -8.0), probes=probes), *feet]
    contact = tc.MasslessContact(removal="normal", tolerance=EXACT)
    return tc.Scene(bodies, [tc.Plane()], 8e-4, contact=contact, friction=tc.Coulomb(0.3))


def varied():
    """Ranks share friction whose coefficient falls with the slip speed, and is a table on the second cylinder."""
    slower = tc.Coulomb(static=0.4, kinetic=0.2, decay=1.0)
    coefficients = [[0.4, 0.3], [0.3, 0.2], [0.2, 0.1]]
    table = tc.FrictionTable(speeds=[0.0, 2.0, 5.0], pressures=[1e4, 1e6], coefficients=coefficients)
    cylinders = [
        tc.Cylinder((0.02, 0.0, -0.11), (0.0, 1.0, 0.1), 0.1, angular_velocity=(0.0, 40.0, 0.0), friction=slower),
        tc.Cylinder((0.09, 0.0, -0.1), (0.0, 1.0, 0.0), 0.1, friction=table),
    ]
    contact = tc.MasslessContact(removal="full", tolerance=EXACT)
    body = block("neo", counts=(5, 4, 4), contact="zmin")
    return tc.Scene([body], cylinders, 1.6e-3, contact=contact, friction=tc.Coulomb(0.25))


def loose():
    """Ranks share a contact whose static solve of a nonlinear law stops early, so that it leaves forces unbalanced."""
    contact = tc.MasslessContact(removal="normal", tolerance=1e-2, sweeps=1)
    return tc.Scene(
        [block("neo", counts=(4, 4, 3), contact="zmin", velocity=uneven)], [tc.Plane()], 8e-4, contact=contact
    )


def foot(counts, at, **given):
    """A second, smaller body of tetrahedra, held on a side."""
    mesh = tc.box_mesh((0.05, 0.04, 0.06), counts, kind="tet4").translated(at)
    return tc.Body(mesh, LAWS["linear"], velocity=(0.0, 0.0, -6.0), supports=[tc.Support("xmin", "x")], **given)


def pressed():
    """Ranks share a penalty that reaches every cell: friction in a corner, nodes that supports hold."""
    planes = [tc.Plane(), tc.Plane((-1e-4, 0.0, 0.0), (1.0, 0.0, 0.0))]
    body = block(contact=("zmin", "xmin"), counts=(2, 5, 4), velocity=(-5.0, 2.0, -8.0))
    bodies = [body, foot((3, 3, 3), (0.2, 0.0, 2e-4), contact=("zmin", "xmin"))]
    contact = tc.PenaltyContact(stiffness=2e10)
    return tc.Scene(bodies, planes, 1e-3, contact=contact, friction=tc.Coulomb(0.3), gravity=(0.0, 0.0, -9.81))


def knocked():
    """Ranks share the impulses of a plane that swings, with friction."""
    plane = tc.Plane(velocity=lambda t: (0.0, 0.0, 3.0 * np.sin(1e3 * t)))
    body = block(counts=(6, 5, 3), contact="zmin", velocity=uneven)
    return tc.Scene([body], [plane], 1e-3, contact=tc.ImpulseContact(), friction=tc.RegularizedCoulomb(0.4, 0.1))


def crossed():
    """Ranks share the contact of two bodies that slide on each other, one of them held at a side of its contact set.

    The rows are built anew now and then only: a run that goes on takes them over.
    """
    held = [tc.Support("xmin", "xyz")]
    lower = block(counts=(3, 3, 4), at=(0.003, -0.004, -0.1201), velocity=(0.0, 0.0, 0.0), contact="zmax", name="lower",
                  supports=held)  # fmt: skip
    upper = block(counts=(4, 3, 3), contact="zmin", name="upper", velocity=(2.0, 0.0, -8.0))
    contact = tc.MasslessContact(removal="full", tolerance=1e-6)
    return tc.Scene([lower, upper], duration=1.4e-3, contact=contact, friction=tc.Coulomb(0.1))


def tied():
    """Springs between sets in the middle and at the far ends of two bodies, to a point, and one at a rigid part."""
    mesh = tc.box_mesh(SIZE, (3, 3, 7))
    inner = np.flatnonzero((np.abs(mesh.nodes[:, 2] - SIZE[2] * 5.0 / 7.0) < 1e-9) & (mesh.nodes[:, 0] > 0.06))
    springs = [tc.Spring("inner", 2e5, 30.0, to=(0.3, 0.1, 0.05)), tc.Spring("zmax", 1e5, 20.0, to=("second", "zmax"))]
    first = tc.Body(
        mesh.with_sets(node_sets={"inner": inner}), LAWS["neo"], (1.0, 0.0, -5.0), springs=springs, name="first"
    )
    part = tc.RigidPart("zmax", mass=0.2)
    second = block(counts=(3, 3, 6), at=(0.0, 0.4, 0.0), rigid_parts=[part], name="second")
    return tc.Scene([first, second], duration=1e-3)


def uneven_laws():
    """Flight of a body that is half of a metal, of which a rank may have no cells: when shapes are looked at."""
    body = block(counts=(3, 3, 8), velocity=lambda x: 30.0 * np.sin(26.0 * x[:, [2, 2, 2]]) * (0.0, 0.3, 1.0))
    centres = body.mesh.cell_centres()[:, 2]
    sets = {"up": np.flatnonzero(centres > 0.06), "low": np.flatnonzero(centres <= 0.06)}
    metal = tc.ElastoPlastic(7e9, 0.33, 2700.0, hardening=tc.LinearHardening(2e7, 1e8), specific_heat=900.0)
    laws = {"low": metal, "up": LAWS["neo"]}
    return tc.Scene(
        [dataclasses.replace(body, mesh=body.mesh.with_sets(cell_sets=sets), material=laws)], duration=1.5e-3
    )


def averaged():
    """Tetrahedra whose volume changes are averaged at nodes: half rubber, half metal, periodic along y.

    A maximum and two probes; one measures stress in the cells of one corner, so that some ranks measure none.
    """
    metal = tc.ElastoPlastic(2.3e7, 0.27, 1350.0, tc.LinearHardening(5e4, 1e6), specific_heat=900.0)
    along = 2.0 * np.pi / SIZE[1]  # what repeats along y alone would have its maximum in several cells
    rippled = {"velocity": lambda x: np.sin(along * x[:, [1]] + 1.0) - (3.0, 4.0, 8.0)}
    body = block(counts=(4, 3, 6), kind="tet4", contact="zmin", **rippled)
    centres = body.mesh.cell_centres()
    sets = {"up": np.flatnonzero(centres[:, 2] > 0.06), "low": np.flatnonzero(centres[:, 2] <= 0.06)}
    sets["tip"] = np.flatnonzero((centres > 0.75 * SIZE).all(axis=1))
    laws = {"low": tc.NeoHookean(2.3e7, 0.49, 1350.0), "up": metal}
    probes = [tc.Probe("tip", "pressure"), tc.Probe("zmax", "velocity")]
    given = {"mesh": body.mesh.with_sets(cell_sets=sets), "material": laws, "periodic": "y"}
    contact = tc.MasslessContact(removal="normal", tolerance=EXACT)
    bodies = [dataclasses.replace(body, probes=probes, **given)]
    return tc.Scene(bodies, [tc.Plane()], 1.2e-3, contact=contact, friction=tc.Coulomb(0.3), maxima=("pressure",))


def bonded():
    """Averaged tetrahedra of a linear law, held on a side that all ranks have, with bulk viscosity.

    Ranks share the contact of a second body of the same law, whose nodes have their ordinary mass.
    """
    law = tc.LinearElastic(2.3e7, 0.49, 1350.0)
    first = block(law, counts=(4, 3, 6), kind="tet4", velocity=(3.0, 0.0, 0.0))
    first = dataclasses.replace(first, supports=[tc.Support("xmin", "xyz")], name="first")
    second = block(law, counts=(3, 3, 4), kind="tet4", at=(0.3, 0.0, 1e-4), contact="zmin", name="second")
    contact = tc.PenaltyContact(stiffness=2e9)
    return tc.Scene([first, second], [tc.Plane()], 1.2e-3, contact=contact, viscosity=tc.BulkViscosity())


def strewn():
    """Hexahedra that hit a plane, on the first rank alone, beside averaged tetrahedra of a metal in flight."""
    metal = tc.ElastoPlastic(2.3e7, 0.27, 1350.0, tc.LinearHardening(5e4, 1e6), specific_heat=900.0)
    first = block("neo", counts=(3, 3, 3), contact="zmin", name="first")
    moved = {"velocity": lambda x: 12.0 * np.sin(40.0 * x[:, [1, 2, 0]]), "at": (0.3, 0.0, 0.2)}
    second = block(metal, counts=(3, 3, 3), kind="tet4", name="second", **moved)
    contact = tc.PenaltyContact(stiffness=2e9)
    return tc.Scene([first, second], [tc.Plane()], 2e-3, contact=contact, maxima=("plastic_strain", "pressure"))


def hung():
    """Ranks share the contact of two bodies that springs and rigid parts hold, with a table of coefficients."""
    coefficients = [[0.4, 0.35, 0.3], [0.3, 0.25, 0.2], [0.1, 0.1, 0.05]]
    table = tc.FrictionTable([0.0, 1.0, 10.0], [0.0, 1e5, 1e6], coefficients)
    springs = [tc.Spring("zmax", 2e5, damping=300.0), tc.Spring("zmax", 1e5, to=("second", "zmax"))]
    parts = [tc.RigidPart("zmax", mass=0.5)]
    first = block(counts=(5, 4, 3), contact="zmin", springs=springs, rigid_parts=parts)
    second = block("neo", counts=(3, 3, 3), at=(0.3, 0.0, 1e-4), contact="zmin", name="second")
    contact = tc.MasslessContact(removal="full", tolerance=EXACT)
    return tc.Scene([first, second], [tc.Plane()], 1.5e-3, contact=contact, friction=table)


def mashed():
    """Ranks share the contact of a metal with bulk viscosity that flows, one side of it driven as a rigid part."""
    material = tc.ElastoPlastic(2.3e7, 0.27, 1350.0, tc.LinearHardening(5e4, 1e6), specific_heat=900.0)
    driven = [tc.RigidPart("zmax", velocity=(1.0, 0.5, -8.0), driven=True)]
    body = block(material, counts=(5, 4, 4), contact="zmin", velocity=(1.0, 0.5, -8.0), rigid_parts=driven)
    contact = tc.MasslessContact(removal="normal", tolerance=EXACT)
    return tc.Scene([body], [tc.Plane()], 1.5e-3, contact=contact, viscosity=tc.BulkViscosity())


def scraped():
    """Ranks share viscous contact cells of two bodies that slide on each other."""
    lower = block("neo", counts=(3, 3, 4), at=(0.003, -0.004, -0.1201), velocity=(0.0, 0.0, 0.0), contact="zmax")
    bodies = [lower, block("neo", counts=(4, 3, 3), contact="zmin", velocity=(4.0, 0.0, -8.0))]
    contact = tc.MasslessContact(removal="normal", tolerance=EXACT)
    return tc.Scene(bodies, duration=1.4e-3, contact=contact, friction=tc.Coulomb(0.2))


def rubber():
    """Ranks share contacts that MPRGP solves: a rubber of nearly constant volume, and a second body of tall cells.

    The law of the latter is linear, and a side of its contact set is held.
    """
    law = tc.NeoHookean(2.3e7, 0.46, 1350.0)
    tall = tc.box_mesh((0.04, 0.04, 0.1), (4, 4, 2)).translated((0.3, 0.0, 1e-4))
    held = [tc.Support("xmin", "y")]
    second = tc.Body(tall, LAWS["linear"], velocity=(0.0, 1.0, -6.0), contact="zmin", supports=held)
    contact = tc.MasslessContact(removal="full", tolerance=EXACT)
    body = block(law, counts=(5, 4, 3), contact="zmin")
    return tc.Scene([body, second], [tc.Plane()], 1e-3, contact=contact, gravity=(0.0, 0.0, -9.81))


def squeezed():
    """Ranks share a penalty between two bodies of which one is of a law whose stable step is followed."""
    lower = block("neo", counts=(3, 3, 4), at=(0.003, -0.004, -0.1201), velocity=(0.0, 0.0, 3.0), contact="zmax")
    bodies = [lower, block(counts=(4, 3, 3), contact="zmin", velocity=(9.0, 0.0, -8.0))]
    return tc.Scene(bodies, duration=1e-3, contact=tc.PenaltyContact(stiffness=2e10), friction=tc.Coulomb(0.2))


EVERY = (free, normal, corner, layered, pushed, impulses, held, pulled, adrift, pair, rigid, metal, sensed, mixed)
EVERY = (
    *EVERY,
    crushed,
    burst,
    halves,
    walls,
    springy,
    rubbed,
    varied,
    loose,
    pressed,
    knocked,
    crossed,
    squeezed,
    uneven_laws,
    tied,
    hung,
    mashed,
    scraped,
    rubber,
    averaged,
    bonded,
    strewn,
)
SCENES = {one.__name__: one for one in EVERY}
SCHEMES = {"crushed": tc.CentralDifference(cfl=0.2), "burst": tc.CentralDifference(dt=1.7e-4)}
REASONS = {"crushed": "inverted-cell", "burst": "diverged"}  # of the others: "finished"
CONTACT_RANKS = {
    "halves": 4,
    "walls": 2,
    "springy": 3,
    "rubbed": 3,
    "varied": 2,
    "loose": 2,
    "pressed": 2,
    "knocked": 3,
    "crossed": 2,
    "squeezed": 2,
    "hung": 2,
    "mashed": 3,
    "scraped": 2,
    "rubber": 2,
    "bonded": 2,
}  # of the others: as many as the model of the work says
APART = ("crossed",)  # each body on a rank of its own
PRESSURES = ("normal", "pushed", "pair", "walls", "crossed")  # their runs keep pressures, and so do one row at a time
