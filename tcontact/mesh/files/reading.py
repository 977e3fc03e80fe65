"""Read meshes from files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from ...base import stages
from ...base.errors import InputError
from ...base.validate import choice, number
from ..elements import ELEMENTS
from ..mesh import Mesh
from .abaqus import read_abaqus
from .content import MeshFileError, mesh_from_file
from .meshio_files import read_gmsh, read_vtu
from .second_order import first_order

_READERS = {".msh": read_gmsh, ".inp": read_abaqus, ".vtu": read_vtu}


def read_mesh(path: str | os.PathLike[str], scale: float = 1.0, kind: str | None = None) -> Mesh:
    """Read a mesh.

    path: gmsh .msh (2.2 or 4.1, ASCII or binary), Abaqus .inp, or .vtu. scale: factor on the coordinates, 1e-3 for a
    file in millimetres. kind (see `Mesh`): the kind of cells to read with their sets, None for all in the file; the
    cells of a mesh of several kinds stand in the order hex8, tet4, wedge6.

    Physical surfaces and Abaqus surfaces become face sets; physical volumes, curves and points, NSET and ELSET of
    volume elements become node sets, an ELSET only where no NSET has its name; physical volumes, ELSET of volume
    elements and in a .vtu file whole numbers of the cells, such as "region" with the sets "region-1", "region-2",
    become cell sets. Points that no volume cell uses are dropped and the others renumbered in the order of the file.
    The instances of an Abaqus assembly become one mesh, each a cell set, as is each part, with the sets of an instance
    as INSTANCE.SET where several have one of that name; `Mesh.part` makes a mesh of each. Second-order cells become
    those of first order between their corners, and mirrored cells are turned, each with a `MeshWarning`.

    Raises `InputError` for a file that is missing, broken or unknown, for pyramids and cells of third order, for cells
    of several kinds that do not fit together, and for everything `Mesh` refuses.
    """
    factor = number("scale", scale, low=0.0)
    if kind is not None:
        choice("kind", kind, ELEMENTS)
    if not isinstance(path, (str, os.PathLike)):
        raise InputError("path", path, "give the name of a mesh file")
    file = Path(path)
    reader = _reader(file)
    stages.say(f"reading {file.name}")
    try:
        return mesh_from_file(first_order(reader(file), kind), factor, kind)
    except MeshFileError as error:
        raise _refusal(file, str(error)) from error
    except InputError as error:
        if error.field == "kind":
            raise
        raise _refusal(file, f"not usable as a mesh: {error}") from error
    except MemoryError as error:
        raise _refusal(file, "needs more memory than there is; the file is damaged or too large") from error
    except Exception as error:  # readers raise all kinds of errors for broken files
        reason = " ".join(f"{type(error).__name__} {error}".split())
        raise _refusal(file, f"cannot be read ({reason}); check that it is complete, or save it again") from error


def _reader(file: Path) -> Any:
    try:
        is_folder, is_file = file.is_dir(), file.is_file()
    except (OSError, ValueError) as error:
        raise _refusal(file, f"no file can have this name ({error})") from error
    if is_folder:
        raise _refusal(file, "this is a directory; give a mesh file")
    if not is_file:
        raise _refusal(file, "no such file; check the name and the working directory")
    if file.suffix.lower() not in _READERS:
        raise _refusal(file, f"unknown extension; convert to one of {', '.join(_READERS)} (meshio convert, gmsh)")
    try:
        with file.open("rb") as stream:
            empty = not stream.read(1)
    except OSError as error:
        raise _refusal(file, f"cannot be opened ({error.strerror})") from error
    if empty:
        raise _refusal(file, "the file is empty; save it again")
    return _READERS[file.suffix.lower()]


def _refusal(file: Path, remedy: str) -> InputError:
    """Make an error with the file's name, which the shortened value of a long path would lose."""
    return InputError("path", str(file), f"{file.name or file}: {remedy}")
