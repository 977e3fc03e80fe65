"""Measure the spin of a body at the start and its rotation: removal="normal" suits bodies and walls that do not turn.

Normal removal takes mass along the normals of the start. Where these turn, the angular momentum is lost (METHOD 1).

    spin      t, w of the rigid motion nearest to the velocity field, min sum m |v - t - w x r|^2, among the motions
              that the supports and the periodic directions leave free; for a free body I w = L
    rotation  R nearest to the deformation, max tr R^T sum m x X^T (polar decomposition)
"""

from __future__ import annotations

import numpy as np

from ..scene.body import Body
from .lumped_mass import NodeMasses

FREE = 1e-9  # eigenvalue of the constraints, over the largest, below which a rigid motion is free


def spin(body: Body, velocity: np.ndarray, nodes: np.ndarray, mass: np.ndarray | None = None) -> np.ndarray:
    """Return the angular velocity [3] [rad/s] of a body with velocity [n, 3] [m/s] at positions nodes [n, 3] [m].

    mass [n] [kg]: lumped mass of its nodes where it is known, else it is computed.
    """
    if moves_as_one(velocity):
        return np.zeros(3)
    mass = NodeMasses(body).total if mass is None else mass
    arm = nodes - (mass @ nodes) / mass.sum()
    size = float(np.abs(arm).max())
    arm /= size
    free = _free_motions(body, arm)
    if free.shape[1] == 0:
        return np.zeros(3)
    gram, right = _moments(mass, arm, velocity)
    motion = np.linalg.lstsq(free.T @ gram @ free, free.T @ right, rcond=None)[0]
    return np.asarray((free @ motion)[3:] / size)


def moves_as_one(velocity: np.ndarray) -> bool:
    """Return whether all nodes have one velocity [n, 3]."""
    return bool((velocity == velocity[:1]).all())


def turns_freely(body: Body) -> bool:
    """Return whether the supports and the periodic directions of a body leave it a rotation at the start."""
    if body.images is None and (not body.supports or np.isnan(body.prescribed).all()):
        return True
    nodes = body.initial_nodes
    arm = nodes - nodes.mean(axis=0)
    free = _free_motions(body, arm / float(np.abs(arm).max()))
    return bool((np.abs(free[3:]) > 1e-6).any())


def _moments(mass: np.ndarray, arm: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return sum m G^T G [6, 6] and sum m G^T v [6] of the rigid motions G = `_rigid_motions` of all nodes.

    They are the mass and the tensor of inertia tr(J) I - J with J = sum m r r^T, as arm [n, 3] is measured from the
    centre of mass; momentum and angular momentum.
    """
    weighed = arm * mass[:, None]
    second = arm.T @ weighed
    gram = np.zeros((6, 6))
    gram[:3, :3] = mass.sum() * np.eye(3)
    gram[3:, 3:] = np.trace(second) * np.eye(3) - second
    flow = weighed.T @ velocity  # sum m r v^T
    turning = [flow[1, 2] - flow[2, 1], flow[2, 0] - flow[0, 2], flow[0, 1] - flow[1, 0]]
    return gram, np.concatenate([mass @ velocity, turning])


def _rigid_motions(arm: np.ndarray) -> np.ndarray:
    """Return the velocities [n, 3, 6] of nodes in the three translations and the three rotations."""
    motions = np.zeros((len(arm), 3, 6))
    motions[:, :, :3] = np.eye(3)
    for axis in range(3):
        motions[:, :, 3 + axis] = np.cross(np.eye(3)[axis], arm)
    return motions


def _free_motions(body: Body, arm: np.ndarray) -> np.ndarray:
    """Return the rigid motions, columns [6, k], that supports and periodic sides leave free; arm [n, 3]: of nodes."""
    held = np.isfinite(body.prescribed)
    nodes = np.flatnonzero(held.any(axis=1))
    rows = _rigid_motions(arm[nodes])[held[nodes]]
    if body.images is not None:
        periodic = body.images.period > 0.0
        kept = periodic if periodic.sum() == 1 else np.zeros(3, dtype=bool)  # it may turn about the one period
        rows = np.concatenate([rows, np.eye(6)[3:][~kept]])
    if len(rows) == 0:
        return np.eye(6)
    values, vectors = np.linalg.eigh(rows.T @ rows)
    return np.asarray(vectors[:, values <= FREE * values[-1]])


def rotation(start: np.ndarray, now: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Return the rotation matrix [3, 3] that takes start [n, 3] nearest to now [n, 3], with weights mass [n]."""
    weights = mass / mass.sum()
    before, after = start - weights @ start, now - weights @ now
    left, _sizes, right = np.linalg.svd(np.einsum("n,ni,nj->ij", weights, after, before))
    left[:, 2] *= np.sign(np.linalg.det(left @ right))
    return np.asarray(left @ right)


def angle(turn: np.ndarray, about: np.ndarray | None = None) -> float:
    """Return the angle [rad] of a rotation matrix, or the angle by which it tilts the unit vector `about`."""
    cosine = 0.5 * (np.trace(turn) - 1.0) if about is None else about @ turn @ about
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))
