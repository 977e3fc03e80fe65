"""Small meshes and scenes the tests of the core share, and the same scenes for the oracle."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import oracle
from oracle import meshes

import tcontact as tc
from tcontact.planning.domain import Domain
from tcontact.planning.planning import Plan
from tcontact.schemes.explicit.stable_step import StableStep, StableSteps

ROOT = Path(__file__).resolve().parent.parent
LAWS = {"linear": tc.LinearElastic, "svk": tc.StVenantKirchhoff, "neo": tc.NeoHookean, "mooney": tc.MooneyRivlin.of}
TWINS = {
    "LinearElastic": oracle.LinearElastic,
    "StVenantKirchhoff": oracle.StVenantKirchhoff,
    "NeoHookean": oracle.NeoHookean,
    "MooneyRivlin": oracle.MooneyRivlin,
}


def material(law="neo", young=2.3e7, poisson=0.27, density=1350.0):
    """A soft material."""
    return LAWS[law](young=young, poisson=poisson, density=density)


def block(kind="hex8", cells=3, size=(0.2, 0.22, 0.18), turn=None, shift=(0.0, 0.0, 0.0), shake=0.2, seed=1):
    """A box whose inner nodes are shaken by a share of a cell, turned and moved; face sets keep their names."""
    counts = (cells,) * 3 if isinstance(cells, int) else cells
    box = tc.box_mesh(size=size, cells=counts, kind=kind)
    nodes = meshes.shaken(np.array(box.nodes), shake * min(np.array(size) / counts), seed) if shake else box.nodes
    turn = np.eye(3) if turn is None else turn
    return tc.Mesh(nodes @ turn.T + shift, box.cells, kind, face_sets=box.face_sets)


def wall(mesh, normal, gap=0.0):
    """The plane with the given normal whose smallest gap to the mesh is `gap` [m]."""
    normal = np.asarray(normal, dtype=float)
    return tc.Plane(point=(np.min(mesh.nodes @ normal) - gap) * normal, normal=normal)


def bar_speed(law):
    """sqrt(E / rho) [m/s]."""
    return np.sqrt(law.young / law.density)


def thrown(law="neo", kind="hex8", cells=3, walls=1, turn=None, speed=0.05, duration=3.0, contact=None, gravity=True,
           supports=(), gap=0.01, shake=0.2):  # fmt: skip
    """A turned, shaken block thrown at one or two slanted walls; speed, duration and gap in units of c, L/c and L."""
    turn = meshes.rotation(31) if turn is None else turn
    mesh, mat, size = block(kind, cells, turn=turn, shake=shake), material(law), 0.2
    c = bar_speed(mat)
    normals = [turn @ (0.0, 0.0, 1.0), turn @ (0.6, 0.0, 0.8)][:walls]
    body = tc.Body(
        mesh,
        mat,
        velocity=-speed * c * (turn @ (0.3, 0.1, 1.0)),
        contact=["xmin", "zmin"] if walls == 2 else "zmin",
        supports=[
            tc.Support(s.set, s.axes, velocity=c * np.asarray(s.velocity)) if np.any(s.velocity) else s
            for s in supports
        ],
    )
    return tc.Scene(
        bodies=[body],
        obstacles=[wall(mesh, normal, gap * size) for normal in normals],
        duration=duration * size / c,
        gravity=c**2 / size * np.array([0.01, 0.0, -0.02]) if gravity else None,
        contact=contact,
    )


def twin(body):
    """The oracle's body of a tcontact body."""
    fixed = np.isfinite(body.prescribed)
    return oracle.Body(
        np.array(body.mesh.nodes),
        np.array(body.mesh.cells),
        body.mesh.kind,
        TWINS[type(body.material).__name__](body.material.young, body.material.poisson),
        body.material.density,
        np.array(body.contact_faces) if body.contact else None,
        fixed if fixed.any() else None,
        np.where(fixed, body.prescribed, 0.0) if fixed.any() else None,
    )


def domain_of(body_plan):
    """The domain of one body alone."""
    return Domain((body_plan,))


def force_of(body_plan):
    """The force pass over the cells of one body."""
    from tcontact.cells.internal_force import InternalForce

    return InternalForce(domain_of(body_plan))


def state_of(scene, body_plan, displacement=None, velocity=None):
    """The state of one body of a scene from displacement and velocity [n, 3] as the user numbers nodes; 0 if None."""
    from tcontact.schemes.explicit.state import DomainState

    start = [np.zeros_like(body_plan.reference) if one is None else one for one in (displacement, velocity)]
    return DomainState(scene, domain_of(body_plan), *[[one] for one in start], Plan(scene, (body_plan,)).layout)


def stable_steps(body_plan, force, obstacles=(), stiffness=None, viscous_force=None):
    """Return the estimator of the stable step of one body whose force pass is given."""
    return StableSteps(force.without_boundary(), [StableStep(body_plan, obstacles, stiffness, viscous_force)])


def twin_planes(scene):
    """The oracle's planes of a scene."""
    return [oracle.Plane(tuple(plane.point), tuple(plane.normal)) for plane in scene.obstacles]


def simulate(scene, *, cfl=None, dt=None, **options):
    """Run a scene by central difference; the run must reach its end."""
    result = tc.simulate(scene, scheme=tc.CentralDifference(cfl=cfl, dt=dt), **options)
    assert result.ok, f"{result.reason}: {result.message}"
    return result


def python(code, *arguments, **options):
    """Run code in a fresh interpreter that sees the checkout and the tests; returns the completed process."""
    head = f"import sys; sys.path[:0] = [{str(ROOT)!r}, {str(ROOT / 'tests')!r}]\n"
    command = [sys.executable, "-W", "ignore", "-c", head + code, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, **options)
