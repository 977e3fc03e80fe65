"""Read a scene from a TOML file; every error names the place in the file."""

from __future__ import annotations

import inspect
import os
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...base.errors import InputError, Shown, hint
from ...base.validate import choice, number
from ...mesh.box import box_mesh
from ...mesh.elements import ELEMENTS, MIXED
from ...mesh.files.reading import read_mesh
from ...mesh.mesh import Mesh
from ...mesh.round import ball_mesh, cylinder_mesh, ring_mesh
from ...scene.body import Body
from ...scene.loads import Load
from ...scene.obstacles import Sdf
from ...scene.pairs import Pair
from ...scene.probes import Probe
from ...scene.scene import Scene
from ...scene.springs import PointMass, Spring
from ...scene.supports import Support
from .classes import METALS, NESTED, RUN, SCENE_PARTS, SURFACE, keys_of, words_of

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib  # type: ignore[import-not-found, unused-ignore]

MISSING = Shown("(missing)")  # value of a key that is not there; a word in quotes would look as if it were in the file
MAXIMUM_BYTES = 2**24  # largest TOML file [bytes]; long arrays are in another file
BOX = {"box": "size", "cells": "cells", "kind": "kind", "origin": "origin"}
FILE = {"file": "path", "scale": "scale", "kind": "kind"}
ROUND: dict[str, Callable[..., Mesh]] = {
    "ring": ring_mesh,
    "cylinder": cylinder_mesh,
    "ball": ball_mesh,
}  # by their arguments
ARRAYS = {name: name for name in ("nodes", "cells", "kind", "node_sets", "face_sets", "cell_sets")}


def load_scene(path: str | os.PathLike[str]) -> tuple[Scene, dict[str, Any]]:
    """Read the scene of a TOML file, and the options of its [run] table as keywords of `simulate`.

    Paths in it are relative to its folder. Raises `InputError` naming the place in the file: no or broken TOML,
    unknown keys and words, missing keys, files that are missing or broken, and everything the classes refuse.
    """
    if not isinstance(path, (str, os.PathLike)):
        raise InputError("path", path, "give the name of a TOML file")
    file = Path(path)
    data = _toml(file)
    reader = Reader(file.parent)
    options = reader.run(data.pop("run", {}))
    return reader.scene(data), options


def _toml(file: Path) -> dict[str, Any]:
    try:
        if not file.is_file():
            raise InputError("path", str(file), "no such file; give a scene as TOML")
        if file.stat().st_size > MAXIMUM_BYTES:
            raise InputError("path", str(file), "is too large for a scene; put long arrays into an .npz file beside it")
        return tomllib.loads(file.read_text(encoding="utf-8-sig"))
    except (OSError, RecursionError) as error:
        raise InputError("path", str(file), f"cannot be read ({error})") from error
    except InputError:
        raise
    except ValueError as error:  # UnicodeDecodeError, TOMLDecodeError, null bytes in the name
        raise InputError("path", str(file), f"is no valid TOML ({error})") from error


def files_named(file: Path) -> set[Path]:
    """Return the names of the files that a scene file refers to; none for a file that is missing or no TOML."""

    def within(value: Any) -> set[Path]:
        inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
        own = {Path(value["file"])} if isinstance(value, dict) and isinstance(value.get("file"), str) else set()
        return own.union(*(within(one) for one in inner))

    try:
        return within(_toml(file))
    except InputError:
        return set()


class Reader:
    """Builds the objects of a scene file; folder: folder of the files that it names."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def scene(self, data: dict[str, Any]) -> Scene:
        """Build the scene of the whole table."""
        known = keys_of(Scene)
        check_keys("", data, [*known, "run"])
        for key in ("bodies", "duration"):
            if key not in data:
                raise InputError(key, MISSING, f"add {key} to the file")
        values = dict(data)
        values["bodies"] = [self.body(f"bodies[{i}]", table) for i, table in enumerate(tables("bodies", data))]
        if "obstacles" in data:
            found = enumerate(tables("obstacles", data))
            values["obstacles"] = [self.obstacle(f"obstacles[{i}]", table) for i, table in found]
        for key in SCENE_PARTS:
            if key in data:
                values[key] = None if data[key] == "none" else self.plain(key, data[key], key)
        if data.get("pairs") == "none":
            values["pairs"] = None
        elif isinstance(data.get("pairs"), list):
            values["pairs"] = [self.pair(f"pairs[{i}]", one) for i, one in enumerate(tables("pairs", data))]
        return made("scene", Scene, values)

    def run(self, data: Any) -> dict[str, Any]:
        """Return the keywords of `simulate`."""
        check_keys("run", table("run", data), RUN)
        values = dict(data)
        if isinstance(values.get("scheme"), dict):
            values["scheme"] = self.plain("run.scheme", values["scheme"], "scheme", word="central-difference")
        return values

    def pair(self, place: str, data: dict[str, Any]) -> Pair:
        """Build a pair of bodies."""
        check_keys(place, data, keys_of(Pair))
        values = dict(data)
        if "friction" in data:
            values["friction"] = self.plain(f"{place}.friction", data["friction"], "friction")
        return made(place, Pair, values)

    def body(self, place: str, data: dict[str, Any]) -> Body:
        """Build a body."""
        check_keys(place, data, keys_of(Body))
        values = dict(data)
        for key in ("mesh", "material"):
            if key not in data:
                raise InputError(f"{place}.{key}", MISSING, "every body needs one")
        values["mesh"] = self.mesh(f"{place}.mesh", data["mesh"])
        values["material"] = self.materials(f"{place}.material", data["material"])
        self.find_metal(place, values)
        for key in ("velocity", "displacement"):
            if key in data:
                values[key] = self.array(f"{place}.{key}", data[key])
        parts = (("supports", Support), ("loads", Load), ("point_masses", PointMass), ("springs", Spring))
        for key, kind in parts:
            if key in data:
                values[key] = []
                for i, part in enumerate(tables(f"{place}.{key}", data, key)):
                    check_keys(f"{place}.{key}[{i}]", part, keys_of(kind))
                    values[key].append(made(f"{place}.{key}[{i}]", kind, part))
        if "probes" in data:
            probes = enumerate(tables(f"{place}.probes", data, "probes"))
            values["probes"] = [self.probe(f"{place}.probes[{i}]", one) for i, one in probes]
        if "rigid_parts" in data:
            rigid = enumerate(tables(f"{place}.rigid_parts", data, "rigid_parts"))
            values["rigid_parts"] = [self.plain(f"{place}.rigid_parts[{i}]", one, "rigid_parts") for i, one in rigid]
        return made(place, Body, values)

    def probe(self, place: str, data: dict[str, Any]) -> Probe:
        """Build a probe."""
        check_keys(place, data, keys_of(Probe))
        return made(place, Probe, data)

    def materials(self, place: str, data: Any) -> Any:
        """Build a material, or a dict of materials from a table of tables by cell set."""
        given = table(place, data)
        if given and all(isinstance(one, dict) for one in given.values()):
            return {name: self.plain(f"{place}.{name}", one, "material") for name, one in given.items()}
        return self.plain(place, given, "material")

    def mesh(self, place: str, data: Any) -> Mesh:
        """Build a mesh: a box, a round body, a mesh file, or nodes and cells; cell sets go with each."""
        given = table(place, data)
        if "cell_sets" in given and "nodes" not in given:
            sets = {name: self.array(f"{place}.cell_sets.{name}", ids)
                    for name, ids in table(f"{place}.cell_sets", given["cell_sets"]).items()}  # fmt: skip
            plain = self.mesh(place, {key: value for key, value in given.items() if key != "cell_sets"})
            return made(place, plain.with_sets, {"cell_sets": sets})
        for word, function in ROUND.items():
            if word in given:
                check_keys(place, given, (word,))
                values = table(f"{place}.{word}", given[word])
                check_keys(f"{place}.{word}", values, inspect.signature(function).parameters)
                return made(f"{place}.{word}", function, values)
        for first, names, build in (("box", BOX, box_mesh), ("file", FILE, self._mesh_file), ("nodes", ARRAYS, Mesh)):
            if first in given:
                check_keys(place, given, names)
                values = {names[key]: value for key, value in given.items()}
                return made(place, build, values, {name: key for key, name in names.items()})
        remedy = 'give box = [..] and cells = [..], a table ring, cylinder or ball, file = "a.msh", or nodes and cells'
        raise InputError(place, list(given), remedy)

    def obstacle(self, place: str, data: dict[str, Any]) -> Any:
        """Build an obstacle; an Sdf from a surface or from arrays in a file."""
        if data.get("type") != "Sdf":
            return self.plain(place, data, "obstacles")
        values = {key: value for key, value in data.items() if key != "type"}
        if "friction" in values:
            values["friction"] = self.plain(f"{place}.friction", values["friction"], "friction")
        if isinstance(data.get("surface"), str):
            own = ["name", "velocity", "angular_velocity", "center", "metal", "friction", "mass", "inertia"]
            check_keys(place, values, [*SURFACE, *own])
            self.find_metal(place, values)
            values["surface"] = str(self.folder / data["surface"])
            return made(place, Sdf.from_surface, values)
        check_keys(place, values, keys_of(Sdf))
        if "distance" not in values:
            remedy = 'give a file of triangles, such as surface = "die.stl", or an array distance and its spacing'
            raise InputError(f"{place}.{'distance' if 'surface' in values else 'surface'}", MISSING, remedy)
        self.find_metal(place, values)
        for key in ("distance", "gradient"):
            if key in values:
                values[key] = self.array(f"{place}.{key}", values[key])
        if "surface" in values:
            pair = table(f"{place}.surface", values["surface"])
            if "file" in pair:
                remedy = 'a file stands as its name: write surface = "die.stl" and scale = 1e-3 beside it'
                raise InputError(f"{place}.surface.file", pair["file"], remedy)
            check_keys(f"{place}.surface", pair, ("points", "triangles"))
            for key in ("points", "triangles"):
                if key not in pair:
                    raise InputError(f"{place}.surface", pair, f"give its {key} too, or leave it out")
            values["surface"] = tuple(
                self.array(f"{place}.surface.{key}", pair[key]) for key in ("points", "triangles")
            )
        return made(place, Sdf, values)

    def plain(self, place: str, data: Any, kind: str, word: str | None = None) -> Any:
        """Build an object of plain data; kind: the place it belongs to (`words_of`)."""
        if kind == "metal" and isinstance(data, str):
            return METALS[choice(place, data, METALS)]
        values = dict(table(place, data))
        words = words_of(kind)
        default = word or (next(iter(words)) if len(words) == 1 or kind == "contact" else None)
        word = values.pop("type", default)
        if word is None:
            raise InputError(f"{place}.type", MISSING, "use one of " + ", ".join(repr(one) for one in words))
        if kind == "material" and isinstance(word, str) and word not in words:
            remedy = f"use one of {', '.join(words)}; an own law is registered before the file is read: import the"
            remedy += " module that calls tcontact.register_law, on the command line with --import FILE.py"
            raise InputError(f"{place}.type", word, remedy)
        built = words[choice(f"{place}.type", word, words)]
        check_keys(place, values, keys_of(built))
        self.find_metal(place, values, "material" if kind == "friction" else "metal")
        for key in NESTED:
            if isinstance(values.get(key), dict):
                values[key] = self.plain(f"{place}.{key}", values[key], key)
        return made(place, built, values)

    def find_metal(self, place: str, values: dict[str, Any], key: str = "metal") -> None:
        """Replace a metal among the values, if there is one, by the object that its name or table says."""
        if key in values:
            values[key] = self.plain(f"{place}.{key}", values[key], "metal")

    def array(self, place: str, data: Any) -> Any:
        """Return an array written out, or one of an .npz file."""
        if not isinstance(data, dict):
            return data
        check_keys(place, data, ("file", "array"))
        if not isinstance(data.get("file"), str) or not isinstance(data.get("array"), str):
            raise InputError(place, data, 'give { file = "name.npz", array = "name in it" }')
        return _from_npz(place, self.folder / data["file"], [data["array"]])[data["array"]]

    def _mesh_file(self, path: Any, scale: Any = 1.0, kind: str | None = None) -> Mesh:
        if not isinstance(path, str):
            raise InputError("file", path, "give the name of a mesh file")
        file = self.folder / path
        if file.suffix.lower() != ".npz":
            return read_mesh(file, scale, kind)
        found = _from_npz("file", file, None)
        several = {name.partition("/")[2]: found[name] for name in found if name.startswith("cells/")}
        if several:
            found |= {"cells": np.zeros(0), "kind": np.array(MIXED)}
        if not {"nodes", "cells", "kind"} <= found.keys():
            raise InputError("file", str(file), "holds no mesh: nodes, cells and kind; save the scene again")
        if found["kind"].dtype.kind != "U" or found["kind"].ndim:
            raise InputError("file", str(file), "its kind is no text; save the scene again")
        sets: dict[str, dict[str, Any]] = {"node_sets": {}, "face_sets": {}, "cell_sets": {}}
        for name, values in found.items():
            group, _, label = name.partition("/")
            if group in sets and label:
                sets[group][label] = values
        mesh = Mesh(found["nodes"], several or found["cells"], str(found["kind"]), **sets)  # type: ignore[arg-type]
        if kind is not None and mesh.kind != choice("kind", kind, ELEMENTS):
            raise InputError("kind", kind, f"the file holds {mesh.kind} cells; leave kind out")
        return mesh if number("scale", scale, low=0.0) == 1.0 else mesh.scaled(scale)


def _from_npz(place: str, file: Path, names: list[str] | None) -> dict[str, np.ndarray]:
    """Read the array of this name in an .npz file, None for all."""
    if not file.is_file():
        raise InputError(place, str(file), "no such file; it is looked for beside the scene")
    try:
        with np.load(file, allow_pickle=False) as arrays:
            wanted = list(arrays.files) if names is None else names
            missing = [name for name in wanted if name not in arrays.files]
            if not missing:
                return {name: np.asarray(arrays[name]) for name in wanted}
            held = ", ".join(arrays.files) or "nothing"
    except Exception as error:  # a broken archive raises all kinds of errors
        raise InputError(place, str(file), f"cannot be read ({error}); save the scene again") from error
    raise InputError(place, missing[0], f"{file.name} holds no such array; it holds {held}")


def made(place: str, build: Callable[..., Any], values: dict[str, Any], keys: Mapping[str, str] | None = None) -> Any:
    """Call `build` with the values; its errors and those for missing arguments name the place.

    keys: of the file, by the argument, where they differ.
    """
    try:
        return build(**values)
    except InputError as error:
        field = (keys or {}).get(error.field, error.field)
        raise InputError(f"{place}: {field}", error.value, error.remedy) from error
    except TypeError as error:
        if "argument" not in str(error):
            raise
        raise InputError(place, values, f"something is missing ({error})") from error


def table(place: str, data: Any) -> dict[str, Any]:
    """Return a table of TOML."""
    if not isinstance(data, dict):
        raise InputError(place, data, "give a table, [like.this] or { like = 'this' }")
    return data


def tables(place: str, data: dict[str, Any], key: str | None = None) -> list[dict[str, Any]]:
    """Return a list of tables."""
    given = data[key or place]
    if not isinstance(given, list) or not all(isinstance(one, dict) for one in given):
        raise InputError(place, given, f"give a list of tables: [[{place}]]")
    return given


def check_keys(place: str, data: dict[str, Any], known: Iterable[str]) -> None:
    """Refuse an unknown key."""
    words = list(known)
    for key in data:
        if key not in words:
            where = f"{place}.{key}" if place else key
            meant = hint(key, words)
            known_are = f"{meant}Known are" if meant else "known are"
            raise InputError(where, data[key], f"unknown key; {known_are} {', '.join(words)}")
