"""Write a scene to a TOML file exactly: numbers in all their digits, long arrays in an .npz file beside it."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...base import validate
from ...base.errors import InputError
from ...device.atomic_file import refuse_special, replaced
from ...friction_layer.metals import Metal
from ...mesh.box import box_mesh
from ...mesh.mesh import Mesh
from ...scene.body import Body
from ...scene.cell_blocks import suited_formulation
from ...scene.loads import Load
from ...scene.obstacles import Obstacle, Sdf
from ...scene.pairs import Pair
from ...scene.scene import Scene
from ...scene.springs import PointMass, Spring
from ...scene.supports import Support
from .classes import METALS, NESTED, RUN, SCENE_PARTS, word_of
from .read import files_named
from .toml import to_toml

UNWRITABLE = "a function of time has no plain data"
OTHER_FORMATS = (".json", ".yaml", ".yml", ".xml")  # in which no scene is written
INLINE = 24  # numbers of an array; longer ones go to the .npz file


def save_scene(scene: Scene, path: str | os.PathLike[str], **run: Any) -> None:
    """Write a scene, and options of `simulate` as its [run] table; `load_scene` then gives the same run, bit for bit.

    path: the TOML file; long arrays go to NAME.npz beside it (boxes of `box_mesh` are written as such).
    Velocities and displacements given as functions are written as arrays. Raises `InputError` for motions of obstacles
    and supports, loads and gravity that are functions of time, which have no plain data, for a name that ends like that
    of another format, and for a file that cannot be written, or beside which an .npz file that it does not refer to has
    the name of its arrays.
    """
    if not isinstance(scene, Scene):
        raise InputError("scene", scene, "give a tcontact.Scene")
    file = validate.path("path", path, "give the name of a TOML file")
    if not file.name:
        raise InputError("path", path, "give the name of a TOML file")
    if file.suffix == ".npz":
        raise InputError("path", str(file), "arrays of the scene have this name; give the name of a TOML file")
    if file.suffix.lower() in OTHER_FORMATS:
        raise InputError("path", str(file), "scenes are written as TOML; give the name of a TOML file")
    refuse_special(file, "path")
    writer = Writer(file.with_suffix(".npz").name)
    data = writer.scene(scene, run)
    text = to_toml(data)
    beside = [*([writer.beside] if writer.arrays else []), *writer.meshes]
    try:
        own_files = files_named(file)  # of the scene that is replaced
        foreign = [name for name in beside if Path(name) not in own_files and file.with_name(name).exists()]
        if foreign:
            unless = "remove it if no other scene needs it"
            raise FileExistsError(f"{foreign[0]} is there already, which its arrays would replace: {unless}")
        own = {writer.beside: writer.arrays} if writer.arrays else {}
        with ExitStack() as together:  # an error leaves all files as they were; the last one opened is replaced first
            together.enter_context(replaced(Path(os.path.realpath(file)))).write_text(text, encoding="utf-8")
            for name, arrays in (own | writer.meshes).items():
                with together.enter_context(replaced(file.with_name(name))).open("wb") as stream:
                    np.savez_compressed(stream, **arrays)
    except (OSError, ValueError) as error:
        raise InputError("path", str(file), f"cannot be written ({error}); name another file") from error


class Writer:
    """Collects the tables of a scene; beside: name of the .npz file for its arrays."""

    def __init__(self, beside: str) -> None:
        self.beside = beside
        self.arrays: dict[str, Any] = {}
        self.meshes: dict[str, dict[str, Any]] = {}

    def scene(self, scene: Scene, run: Mapping[str, Any]) -> dict[str, Any]:
        """Return the whole table."""
        data: dict[str, Any] = {"duration": float(scene.duration)}
        if callable(scene.gravity):
            raise InputError("gravity", scene.gravity, f"{UNWRITABLE}; give a vector, or keep this scene in Python")
        if scene.gravity is not None:
            data["gravity"] = scene.gravity.tolist()
        for key in SCENE_PARTS:
            value = getattr(scene, key)
            if value is not None:
                data[key] = self.plain(key, value)
            elif key == "contact":
                data[key] = "none"
        if scene.pairs is None:
            data["pairs"] = "none"
        elif not isinstance(scene.pairs, str):
            data["pairs"] = [self.pair(pair) for pair in scene.pairs]
        if scene.maxima:
            data["maxima"] = list(scene.maxima)
        for key, value in run.items():
            if key not in RUN:
                raise InputError(f"run.{key}", value, "not an option of a scene file; it knows " + ", ".join(RUN))
        options = {key: value for key, value in run.items() if value is not None}
        if "scheme" in options and not isinstance(options["scheme"], str):
            options["scheme"] = self.plain("scheme", options["scheme"])
        data |= {"run": options} if options else {}
        data["bodies"] = [self.body(i, body) for i, body in enumerate(scene.bodies)]
        if scene.obstacles:
            data["obstacles"] = [self.obstacle(i, obstacle) for i, obstacle in enumerate(scene.obstacles)]
        return data

    def pair(self, pair: Pair) -> dict[str, Any]:
        """Return the table of a pair of bodies."""
        given = {field.name: getattr(pair, field.name) for field in fields(pair)}
        if pair.friction is not None:
            given["friction"] = self.plain("friction", pair.friction)
        return {name: value for name, value in given.items() if value is not None}

    def body(self, index: int, body: Body) -> dict[str, Any]:
        """Return the table of a body."""
        data: dict[str, Any] = {} if body.name is None else {"name": body.name}
        data["mesh"] = self.mesh(index, body.mesh)
        if isinstance(body.material, Mapping):
            data["material"] = {name: self.plain("material", one) for name, one in body.material.items()}
        else:
            data["material"] = self.plain("material", body.material)
        data["velocity"] = self.nodal(f"velocity-{index}", body.velocity, body.initial_velocity)
        if body.displacement is not None:
            data["displacement"] = self.nodal(f"displacement-{index}", body.displacement, body.initial_displacement)
        if body.contact is not None:
            data["contact"] = list(body.contact) if len(body.contact) > 1 else body.contact[0]
        if body.metal is not None:
            data["metal"] = self.metal(body.metal)
        if body.formulation != suited_formulation(body.mesh, body.material):
            data["formulation"] = body.formulation
        if body.periodic is not None:
            data["periodic"] = body.periodic
        if body.probes:
            data["probes"] = [{"set": probe.set, "quantity": probe.quantity} for probe in body.probes]
        if body.supports:
            data["supports"] = [
                self.support(f"bodies[{index}].supports[{number}]", support)
                for number, support in enumerate(body.supports)
            ]
        if body.loads:
            data["loads"] = [self.load(f"bodies[{index}].loads[{i}]", load) for i, load in enumerate(body.loads)]
        for key in ("point_masses", "springs"):
            if getattr(body, key):
                data[key] = [self.part(part) for part in getattr(body, key)]
        for number, part in enumerate(body.rigid_parts):
            place = f"bodies[{index}].rigid_parts[{number}]"
            refuse_functions(place, part)
            table = self.plain("rigid_parts", part)
            del table["type"]
            data.setdefault("rigid_parts", []).append(table)
        return data

    def load(self, place: str, load: Load) -> dict[str, Any]:
        """Return the table of a load."""
        if load.varies:
            remedy = f"{UNWRITABLE}; give numbers, or keep this scene in Python"
            raise InputError(f"{place}.{load.kind}", load.value, remedy)
        return {"set": load.set, load.kind: np.asarray(load.value, dtype=float).tolist()}

    def support(self, place: str, support: Support) -> dict[str, Any]:
        """Return the table of a support. Raises `InputError` for a function of time."""
        value = getattr(support, support.kind)
        if support.varies:
            remedy = f"{UNWRITABLE}; give numbers, or keep this scene in Python"
            raise InputError(f"{place}.{support.kind}", value, remedy)
        return {"set": support.set, "axes": support.axes, support.kind: np.asarray(value, dtype=float).tolist()}

    def part(self, part: PointMass | Spring) -> dict[str, Any]:
        """Return the table of a point mass or a spring: its fields that differ from their defaults."""
        given = {field.name: (getattr(part, field.name), field.default) for field in fields(part)}
        found = {name: value for name, (value, default) in given.items() if value != default}
        return {name: list(value) if isinstance(value, tuple) else value for name, value in found.items()}

    def mesh(self, index: int, mesh: Mesh) -> dict[str, Any]:
        """Return the table of a mesh: a box by its numbers, or a file of arrays."""
        box = box_of(mesh)
        if box is not None:
            if mesh.cell_sets:
                sets = {label: self.array(f"cells-{index}-{label}", ids) for label, ids in mesh.cell_sets.items()}
                box["cell_sets"] = sets
            return box
        name = f"{Path(self.beside).stem}-mesh-{index}.npz"
        arrays: dict[str, np.ndarray] = {"nodes": mesh.nodes}
        if len(mesh.blocks) == 1:
            arrays |= {"cells": mesh.cells, "kind": np.array(mesh.kind)}
        else:
            arrays |= {f"cells/{kind}": cells for kind, cells in mesh.blocks}
        for group in ("node_sets", "face_sets", "cell_sets"):
            for label, ids in getattr(mesh, group).items():
                arrays[f"{group}/{label}"] = ids
        self.meshes[name] = arrays
        return {"file": name}

    def obstacle(self, index: int, obstacle: Obstacle) -> dict[str, Any]:
        """Return the table of an obstacle; the grid of an Sdf goes to the .npz file."""
        refuse_functions(f"obstacles[{index}]", obstacle)
        if not isinstance(obstacle, Sdf):
            return self.plain("obstacles", obstacle)
        data = self.plain("obstacles", obstacle, leave=("distance", "gradient", "nodes", "surface"))
        data["distance"] = self.array(f"distance-{index}", obstacle.grid[..., 0])
        data["gradient"] = self.array(f"gradient-{index}", obstacle.grid[..., 1:])
        if obstacle.surface is not None:
            points, triangles = obstacle.surface
            data["surface"] = {
                "points": self.array(f"points-{index}", np.asarray(points)),
                "triangles": self.array(f"triangles-{index}", np.asarray(triangles)),
            }
        return data

    def plain(self, place: str, value: Any, leave: tuple[str, ...] = ()) -> dict[str, Any]:
        """Return the table of an object of plain data: its arguments that differ from their defaults."""
        word = word_of(place, value)
        if word is None:
            raise InputError(place, value, "is of no class that a scene file knows")
        data: dict[str, Any] = {"type": word}
        for field in fields(value):
            given = getattr(value, field.name)
            if field.name in leave or given is None:
                continue
            if isinstance(given, Metal):
                data[field.name] = self.metal(given)
            elif field.name in NESTED and is_dataclass(given):
                data[field.name] = self.plain(field.name, given)
            elif field.default is MISSING or not np.array_equal(given, field.default):
                data[field.name] = given.tolist() if isinstance(given, (np.ndarray, np.generic)) else given
        return data

    def metal(self, metal: Metal) -> Any:
        """Return the name of a metal that has one, else its table."""
        names = [name for name, known in METALS.items() if known == metal]
        return names[0] if names else self.plain("metal", metal)

    def nodal(self, name: str, given: Any, values: np.ndarray) -> Any:
        """Return a vector as it is, anything else as an array."""
        if not callable(given) and np.shape(given) == (3,):
            return np.asarray(given, dtype=np.float64).tolist()
        return self.array(name, values)

    def array(self, name: str, values: np.ndarray) -> Any:
        """Return the numbers if they are few, else a reference to an array in the .npz file."""
        if values.size <= INLINE:
            return values.tolist()
        self.arrays[name] = values
        return {"file": self.beside, "array": name}


def refuse_functions(place: str, moved: Any) -> None:
    """Refuse rates that are functions of time, of an obstacle or a rigid part. Raises `InputError`."""
    for key in ("velocity", "angular_velocity"):
        if callable(getattr(moved, key)):
            remedy = "a function of time has no plain data; give a vector, or keep this scene in Python"
            raise InputError(f"{place}.{key}", getattr(moved, key), remedy)


def box_of(mesh: Mesh) -> dict[str, Any] | None:
    """Return the arguments with which `box_mesh` makes exactly this mesh, or None."""
    low, high = mesh.bounds
    cells = [len(np.unique(mesh.nodes[:, axis])) - 1 for axis in range(3)]
    if min(cells) < 1 or np.prod([n + 1 for n in cells], dtype=object) != mesh.node_count:
        return None
    try:
        twin = box_mesh((high - low).tolist(), cells, mesh.kind, low.tolist())
    except InputError:
        return None
    same = np.array_equal(twin.nodes, mesh.nodes) and np.array_equal(twin.cells, mesh.cells) and not mesh.node_sets
    if not same or twin.face_sets.keys() != mesh.face_sets.keys():
        return None
    if not all(np.array_equal(faces, mesh.face_sets[name]) for name, faces in twin.face_sets.items()):
        return None
    data: dict[str, Any] = {"box": (high - low).tolist(), "cells": cells, "kind": mesh.kind}
    return data | ({"origin": low.tolist()} if low.any() else {})
