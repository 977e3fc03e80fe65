"""Fields of the frames in result.vtkhdf for a scene, and the size of the file, both known before the run.

Every number takes 8 bytes and the mesh is stored once, so that the size is the mesh plus frames times the fields.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..base.errors import InputError, hint
from ..mesh.elements import ELEMENTS
from ..scene.friction_models import FrictionLayer
from ..scene.scene import Scene

# contact_pressure: size of the contact force, friction included, over the area of the node (METHOD 7)
NODAL = {"displacement": 3, "velocity": 3, "contact_force": 3, "contact_pressure": 1}  # numbers a node
LAYERS = {"layer_temperature": 1, "layer_shear": 1}  # numbers a node, with a FrictionLayer
CELLWISE = {"von_mises": 1}  # numbers a cell
METAL = {"plastic_strain": 1, "temperature": 1}  # numbers a cell, with a metal
FRICTION = {"slip_distance": 1, "friction_work": 1}  # numbers a node, with friction; only where they are named
STRESS = {"pressure": 1}  # numbers a cell, only where it is named
ALWAYS = "displacement"  # without it there is no shape to draw
FIXED = 1_100_000  # what a file without frames takes [byte]: mostly room for 4096 rows of the history


def available(scene: Scene) -> tuple[str, ...]:
    """Return the names of the fields that frames of this scene hold unless some are named."""
    layers = LAYERS if isinstance(scene.friction, FrictionLayer) and scene.touching else {}
    return (*NODAL, *layers, *CELLWISE, *(METAL if scene.plastic else {}))


def further(scene: Scene) -> tuple[str, ...]:
    """Return the names of the fields that frames of this scene hold only if they are named, or with "all"."""
    return (*(FRICTION if scene.friction is not None and scene.touching else {}), *STRESS)


def chosen(scene: Scene, fields: Any) -> tuple[str, ...]:
    """Return the fields to write, in their own order; None = `available`, "all" = also those that cost more.

    Raises `InputError` with those that exist.
    """
    if fields is None:
        return available(scene)
    known = (*available(scene), *further(scene))
    if isinstance(fields, str) and fields == "all":
        return known
    if isinstance(fields, str) or not isinstance(fields, Sequence):
        raise InputError("fields", fields, f"give a list of names out of {', '.join(known)}, or 'all'")
    if [*fields] == ["all"]:  # of the program
        return known
    for name in fields:
        if name not in known:
            raise InputError("fields", name, f"{hint(name, known)}frames of this scene can hold {', '.join(known)}")
    return tuple(name for name in known if name in fields or name == ALWAYS)


def size(scene: Scene, frames: int, fields: Sequence[str] | None = None) -> int:
    """Return the bytes of result.vtkhdf with this many frames and a history of up to 4096 rows."""
    nodes, cells = _counts(scene)
    corners = sum(ELEMENTS[kind].corners * count for body in scene.bodies for kind, count in body.mesh.cell_counts)
    mesh = 24 * nodes + 8 * corners + 9 * cells + (8 * cells if len(scene.bodies) > 1 else 0)
    return FIXED + mesh + frames * frame_size(scene, chosen(scene, fields))


def frame_size(scene: Scene, fields: Sequence[str]) -> int:
    """Return the bytes of a frame with these fields."""
    nodes, cells = _counts(scene)
    nodal, cellwise = NODAL | LAYERS | FRICTION, CELLWISE | METAL | STRESS
    return 8 * sum(nodal[name] * nodes if name in nodal else cellwise[name] * cells for name in fields)


def _counts(scene: Scene) -> tuple[int, int]:
    """Return the numbers of nodes and cells of all bodies."""
    meshes = [body.mesh for body in scene.bodies]
    return sum(mesh.node_count for mesh in meshes), sum(mesh.cell_count for mesh in meshes)


def check_room(folder: Path, scene: Scene, frames: int, fields: Sequence[str] | None) -> None:
    """Raise `InputError` where the disk has no room for the frames."""
    place = next((one for one in (folder, *folder.absolute().parents) if one.is_dir()), None)
    if place is None:
        return
    needed, free = size(scene, frames, fields), shutil.disk_usage(place).free
    if needed > free:
        text = f"result.vtkhdf would take {needed / 1e6:.4g} MB and it has {free / 1e6:.4g} MB free; make room or name"
        fewer = ", or take fewer frames or fields" if frames else ""
        raise InputError("out", str(folder), f"{text} another folder{fewer}")
