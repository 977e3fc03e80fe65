"""Figures of the oracle for the hard cases: prints the table that `tcontact.study.hard.references` keeps.

    python tests/hard_references.py [--full] [NAME ...]

Meshes, velocities, walls and material constants are those of the cases; everything that is computed from them is the
oracle's: its masses, its stable step, its choice of the removed mass, its contact solution.
"""

import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import oracle  # noqa: E402
from scenes import twin, twin_planes  # noqa: E402

import tcontact as tc  # noqa: E402
from tcontact.study import hard_register  # noqa: E402
from tcontact.study.hard import references  # noqa: E402


def stable_step(scene):
    """Largest stable step [s] of the oracle: 2/omega of the free body."""
    return oracle.stable_step(twin(scene.bodies[0]))


def removal(scene):
    """The removal a scene asks for, "auto" resolved by the oracle's rule."""
    if scene.contact.removal != "auto":
        return scene.contact.removal
    body = scene.bodies[0]
    faces = np.array(body.contact_faces)
    centre = np.broadcast_to(body.mesh.nodes.mean(axis=0), (len(faces), 3))
    return oracle.choose_removal(body.mesh.nodes, faces, centre, [plane.normal for plane in scene.obstacles])


def measure(run, until=None):
    """Impulse [N s], mean time [s] and width [s] of the force on every wall [p, 3], by the oracle."""
    scene, scheme = run.scene, run.scheme
    body = scene.bodies[0]
    dt = (scheme.cfl or 0.9) * stable_step(scene) if scheme.dt is None else scheme.dt
    history = oracle.run(
        twin(body),
        twin_planes(scene),
        body.initial_velocity,
        duration=(until or scene.duration) + dt,
        dt=dt,
        contact=oracle.Massless(removal(scene)),
        gravity=None if scene.gravity is None else np.asarray(scene.gravity, float),
    )
    return references.figures(
        history.time, history.contact_force, [plane.unit for plane in twin_planes(scene)], until or scene.duration
    )


def runs(name, full=False):
    """The runs of a case that have a reference: mesh size, and those that are compared."""
    chosen = [
        run
        for run in hard_register.register()[name].runs(full)[: references.RUNS.get(name)]
        if isinstance(run.scene.contact, tc.MasslessContact)
    ]
    return chosen[0].scene.bodies[0].mesh.cell_count, chosen


def main(words):
    """Print the rows of the tables."""
    full = "--full" in words
    names = [word for word in words if word != "--full"]
    for name in names or references.STABLE_STEPS:
        if name in references.STABLE_STEPS:
            scene = hard_register.register()["step-1.3" if name == "step" else name].runs(full)[0].scene
            print(f'"{name}": {{{scene.bodies[0].mesh.cell_count}: {stable_step(scene):.6g}}},', flush=True)
    for name in names or references.IMPULSES:
        if name not in references.IMPULSES:
            continue
        cells, chosen = runs(name, full)
        found = [measure(run, references.UNTIL.get(name)) for run in chosen]
        rows = ", ".join("[" + ", ".join(f"({j:.5g}, {t:.5g}, {w:.4g})" for j, t, w in table) + "]" for table in found)
        print(f'"{name}": {{{cells}: [{rows}]}},', flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
