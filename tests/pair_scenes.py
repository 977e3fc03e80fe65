"""Scenes of two and more bodies that touch each other, for the tests of pairs."""

import numpy as np

import tcontact as tc

OBLIQUE = np.array((0.05, 0.02, -0.05))  # speed of the upper cube over the wave speed of a unit cube
TURN = 17.0  # degrees


def soft(law=tc.NeoHookean, young=1.0, poisson=0.3):
    """Return a material of unit density."""
    return law(young=young, poisson=poisson, density=1.0)


def oblique_cubes(
    upper=4, lower=5, kind="hex8", law=tc.NeoHookean, young=1.0, removal="full", duration=3.0, motion=None, **options
):
    """Two free unit cubes with turned meshes, the upper one with an oblique velocity; motion: (rotation, offset)."""
    below = tc.box_mesh((1, 1, 1), (lower,) * 3, kind, origin=(0, 0, -1.0))
    above = tc.box_mesh((1, 1, 1), (upper,) * 3, kind, origin=(0, 0, 0.002))
    above = above.rotated(((0, 0, 1), np.radians(TURN)), about=(0.5, 0.5, 0.5)).translated((0.25, 0.1, 0.0))
    velocity = OBLIQUE
    if motion is not None:
        below, above = (mesh.rotated(motion[0]).translated(motion[1]) for mesh in (below, above))
        velocity = motion[0] @ velocity
    bodies = [
        tc.Body(above, soft(law, young), velocity, contact="zmin", name="up"),
        tc.Body(below, soft(law), contact="zmax", name="low"),
    ]
    contact = options.pop("contact", None) or tc.MasslessContact(removal)
    return tc.Scene(bodies, duration=duration, contact=contact, **options)


def bar(cells, across, start, speed, name, young=1.0, kind="hex8", law=tc.LinearElastic, contact=("zmin", "zmax")):
    """Return a bar of length 1 along z that begins at `start`; poisson 0."""
    mesh = tc.box_mesh((0.1, 0.1, 1.0), (across, across, cells), kind, origin=(0, 0, start))
    return tc.Body(mesh, soft(law, young, 0.0), (0, 0, speed), contact=contact, name=name)


def mirror_images():
    """Return two linear cubes, "up" and "low", that are mirror images in the plane z = 0 and meet there."""
    mesh = tc.box_mesh((1, 1, 1), (4, 4, 4), origin=(0, 0, 0.001))
    mirrored = tc.Mesh(mesh.nodes * (1, 1, -1), mesh.cells[:, [4, 5, 6, 7, 0, 1, 2, 3]], "hex8",
                       face_sets={"zmax": mesh.face_sets["zmin"]})  # fmt: skip
    law = soft(tc.LinearElastic)
    one = tc.Body(mesh, law, (0, 0, -0.02), contact="zmin", name="up")
    other = tc.Body(mirrored, law, (0, 0, 0.02), contact="zmax", name="low")
    return one, other


def total(result, name):
    """Return the largest change of a history column over its largest value at the start."""
    column = result.history[name]
    return np.abs(column - column[0]).max() / np.abs(column[0]).max()


def touching(result, pair):
    """Return the rows of the history in which a pair has a force."""
    return result.history[f"pair_pressed:{pair}"] > 0


def touches(force):
    """Return how often a force [rows] rises from 0."""
    return int((np.diff((np.abs(force) > 1e-9 * np.abs(force).max()).astype(int)) > 0).sum())


def variation(force):
    """Return the total variation of a force [rows] that rises and falls, over twice its largest value."""
    return np.abs(np.diff(force)).sum() / (2.0 * np.abs(force).max())
