"""What a run starts with: the places and velocities of its scene, or the end of another run of the same bodies.

The other run leaves positions, velocities, friction layers (initial_layers.py) and, of metals, the state of the points
of every cell. What does not fit the scene is refused by name.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.errors import InputError
from ..mesh.mesh import Mesh
from ..results.result import Result
from ..results.stored import StoredResult
from ..scene.body import Body
from ..scene.cell_blocks import BodyBlock
from ..scene.contact_models import PenaltyContact
from ..scene.scene import Scene


def start_of_scene(scene: Scene) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Return the displacement and velocity [n, 3] of every body in the scene, read-only."""
    return [body.initial_displacement for body in scene.bodies], [body.initial_velocity for body in scene.bodies]


def check_initial(initial: Any) -> None:
    """Refuse what is no `Result` to start from, nor None. Raises `InputError`."""
    if initial is not None and not isinstance(initial, Result):
        remedy = "give the Result of another run, as simulate returned it in this program"
        if isinstance(initial, StoredResult):
            remedy = "an opened result holds no states of points and nodes: "
            remedy += "give the Result that simulate returned in this program, or `tcontact resume` its folder"
        raise InputError("initial", initial, remedy)


def start_from(scene: Scene, initial: Result | None) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Return the displacement and velocity [n, 3] of every body at the start."""
    if initial is None:
        return start_of_scene(scene)
    if any(obstacle.free for obstacle in scene.obstacles) or any(body.rigid_parts for body in scene.bodies):
        remedy = "rigid bodies (mass= of obstacles, Body.rigid_parts) start as the scene says; leave initial out"
        raise InputError("initial", initial, remedy)
    counts = [body.mesh.node_count for body in scene.bodies]
    theirs = [body.mesh for body in initial.scene.bodies]
    same = len(theirs) == len(counts) and initial.position.shape == (sum(counts), 3)
    if not same or not all(body.mesh.has_cells_of(mesh) for body, mesh in zip(scene.bodies, theirs, strict=True)):
        raise InputError(
            "initial", initial, f"it ran other meshes; give a run of the same bodies ({sum(counts)} nodes)"
        )
    for index, (body, mesh) in enumerate(zip(scene.bodies, theirs, strict=True)):
        if not _has_shape_of(body.mesh, mesh):
            remedy = f"{scene.label(index)} has the cells that it had there, but nodes at other places in the mesh: its"
            raise InputError("initial", initial.reason, f"{remedy} strains would be others; give the mesh of that run")
    if not (np.isfinite(initial.position).all() and np.isfinite(initial.velocity).all()):
        raise InputError("initial", initial.reason, "its end state is not finite; start from a run that finished")
    ends = np.cumsum(counts)[:-1]
    positions, velocities = np.split(initial.position.copy(), ends), np.split(initial.velocity.copy(), ends)
    for body, speeds in zip(scene.bodies, velocities, strict=True):
        held = np.isfinite(body.prescribed)
        speeds[held] = body.prescribed[held]
    _check_places(scene, positions)
    _check_outside(scene, positions)
    for there, body in zip(positions, scene.bodies, strict=True):  # a copy of those of the other run
        first = 0
        for nodes in body.mesh.portions("nodes"):
            there[first : first + len(nodes)] -= nodes
            first += len(nodes)
    return positions, velocities


def _check_places(scene: Scene, positions: list[np.ndarray]) -> None:
    """Set positions [n, 3] [m] to prescribed displacements at t = 0. Raises `InputError` where they are elsewhere."""
    for index, (body, there) in enumerate(zip(scene.bodies, positions, strict=True)):
        given = body.given_displacement
        known = np.isfinite(given)
        rows, axes = np.nonzero(known)
        wanted = body.mesh.nodes_at(rows)[np.arange(len(rows)), axes] + given[known]
        away = float(np.abs(there[known] - wanted).max(initial=0.0))
        if away > 1e-6 * body.mesh.shortest_edge:
            remedy = f"nodes of {scene.label(index)} ended up to {away:.3g} m from where the displacement of a support"
            raise InputError("initial", away, f"{remedy} starts; let it start from there, at t = 0")
        there[known] = wanted


def _check_outside(scene: Scene, positions: list[np.ndarray]) -> None:
    """Refuse the end of another run, positions [n, 3] [m] of every body, deep inside an obstacle. Raises `InputError`.

    Less than a cell is corrected by the first step; a penalty allows more.
    """
    contact = scene.contact
    if contact is None or isinstance(contact, PenaltyContact) or getattr(contact, "penalty", None) is not None:
        return
    for index, (body, there) in enumerate(zip(scene.bodies, positions, strict=True)):
        if not body.touches:
            continue
        allowed = body.mesh.shortest_edge
        for number, obstacle in enumerate(scene.obstacles):
            gap = obstacle.gap(there[body.contact_nodes])
            lowest = int(np.argmin(gap))
            if gap[lowest] < -allowed:
                raise InputError(
                    "initial",
                    float(gap[lowest]),
                    f"node {body.contact_nodes[lowest]} of {scene.label(index)} ends {-gap[lowest]:.6g} inside obstacle"
                    f" {scene.obstacle_label(number)} (allowed: {allowed:.3g}); move the obstacle apart",
                )


def points_of(scene: Scene, initial: Result) -> tuple[tuple[np.ndarray, ...], ...]:
    """Return the state of the points of another run, with which this one starts. Raises `InputError`."""
    if not initial.points:
        return ()
    triples = zip(scene.bodies, initial.scene.bodies, initial.points, strict=True)
    return tuple(_points_of(scene.label(index), *triple) for index, triple in enumerate(triples))


def _points_of(label: str, body: Body, before: Body, states: tuple[np.ndarray, ...]) -> tuple[np.ndarray, ...]:
    """Return the state of the points of every block of a body from those of the run before.

    A state belongs to a cell: its block may hold other cells or stand elsewhere, as regions of a body may be named, cut
    and ordered in other ways. Raises `InputError` where the state of a cell means something else.
    """
    cells = np.arange(body.mesh.cell_count)
    owner, row = np.empty(len(cells), dtype=np.int64), np.empty(len(cells), dtype=np.int64)
    for number, block in enumerate(before.blocks):
        own = cells[block.numbers]
        owner[own], row[own] = number, np.arange(len(own))
    meanings = [_meaning(block) for block in before.blocks]
    found = []
    for block in body.blocks:
        own = cells[block.numbers]
        for number in np.unique(owner[own]):
            if meanings[number] != _meaning(block):
                first = int(own[owner[own] == number][0])
                keeps = f"its points keep a state (of {meanings[number]}), which cell {first} of {label}"
                remedy = f"{keeps} ({_meaning(block)}) cannot take over; give the same materials and formulations"
                raise InputError("initial", meanings[number], remedy)
        state = np.empty((len(own), *states[owner[own[0]]].shape[1:]))
        for number in np.unique(owner[own]):
            here = owner[own] == number
            state[here] = states[number][row[own[here]]]
        found.append(state)
    return tuple(found)


def _meaning(block: BodyBlock) -> tuple[Any, ...]:
    """Return what the state of the points of a block means: element, law and initial temperature [K]."""
    return block.element, block.material.law, getattr(block.material, "initial_temperature", None)


def _has_shape_of(mesh: Mesh, other: Mesh) -> bool:
    """Return whether all nodes of a mesh stand at those of another one, but for one translation."""
    if mesh is other:
        return True
    first, shift, allowed = 0, None, 1e-6 * mesh.shortest_edge
    for nodes in mesh.portions("nodes"):
        apart = nodes - other.nodes_at(np.arange(first, first + len(nodes)))
        shift = apart[0] if shift is None else shift
        if not (np.abs(apart - shift) <= allowed).all():
            return False
        first += len(nodes)
    return True
